//! Names in messages: lists that stay short, and the nearest right spelling.

use sesc_model::text::listed;
use strsim::damerau_levenshtein;

/// Longer names and more of them are not compared: it takes time.
const LONGEST: usize = 64;
const COMPARED: usize = 2_000;
const SUGGESTED: usize = 3;

/// Names for a message, a dozen at most.
pub(crate) fn list(names: &[&str]) -> String {
    listed(names.iter().map(|name| format!("`{}`", short(name))), 12)
}

/// A piece of a file, cut so that a message stays readable.
pub(crate) fn short(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", text[..end].escape_debug()),
        None => text.escape_debug().to_string(),
    }
}

/// `; did you mean `a` for `b`?` for the first few wrong names that have a near one.
pub(super) fn suggestion<'a>(wrong: &[&str], right: impl Iterator<Item = &'a str>) -> String {
    let right: Vec<&str> = right.take(COMPARED).collect();
    let found: Vec<String> = wrong
        .iter()
        .take(SUGGESTED)
        .filter_map(|wrong| nearest(wrong, &right).map(|near| format!("`{near}` for `{wrong}`")))
        .collect();
    match found.len() {
        0 => String::new(),
        _ => format!("; did you mean {}?", found.join(", ")),
    }
}

/// The nearest of `names`; letter case and the kind of separator are free.
pub(crate) fn nearest<'a>(wrong: &str, names: &[&'a str]) -> Option<&'a str> {
    if wrong.is_empty() || wrong.len() > LONGEST {
        return None;
    }
    let fold = |name: &str| name.to_lowercase().replace(['-', '.', ' ', '/'], "_");
    let folded = fold(wrong);
    let most = match folded.chars().count() {
        0..=2 => 0,
        length => (length / 3).clamp(1, 3),
    };
    names
        .iter()
        .filter(|name| name.len() <= LONGEST)
        .map(|name| (damerau_levenshtein(&folded, &fold(name)), *name))
        .filter(|(distance, _)| *distance <= most)
        .min()
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        let names = ["l_knee", "r_knee", "head_pan"];
        assert_eq!(nearest("L-Knee", &names), Some("l_knee"));
        assert_eq!(nearest("hed_pan", &names), Some("head_pan"));
        assert_eq!(nearest("camera", &names), None);
        assert_eq!(nearest("", &names), None);
        assert_eq!(nearest("é", &["e"]), None);
    }

    #[test]
    fn lists_and_pieces_stay_short() {
        assert_eq!(list(&["a", "b"]), "`a`, `b`");
        assert!(list(&["x"; 20]).ends_with("and 8 more"));
        assert_eq!(short(&"é".repeat(500)).chars().count(), LONGEST + 1);
    }
}
