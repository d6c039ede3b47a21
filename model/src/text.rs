//! Lists and names that stay short, for messages and reports.

/// `a, b and 3 more`: the first `most` items, and how many follow.
pub fn listed<T: ToString>(items: impl IntoIterator<Item = T>, most: usize) -> String {
    let mut items = items.into_iter();
    let shown: Vec<String> = items.by_ref().take(most).map(|x| x.to_string()).collect();
    let shown = shown.join(", ");
    match items.count() {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// The first letters of a name that has more than `most`.
pub fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_string();
    }
    name.chars().take(most - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_say_how_many_are_left_out() {
        assert_eq!(listed(["a", "b"], 2), "a, b");
        assert_eq!(listed(1..=20, 3), "1, 2, 3 and 17 more");
        assert_eq!(listed([""; 0], 3), "");
    }

    #[test]
    fn names_are_cut_to_letters_not_bytes() {
        assert_eq!(shortened("Hüfte", 5), "Hüfte");
        assert_eq!(shortened("Hüftgelenk", 5), "Hüft…");
    }
}
