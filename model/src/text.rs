//! Lists and names that stay short, and text that shows what it holds, for messages,
//! reports and generated files.

/// Whether a character is not seen as what it is: control characters, and those that turn
/// the direction of text or end a line. A terminal obeys them, and a compiler reads
/// something else than a person does.
pub fn is_hidden(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || turns || matches!(c, '\u{2028}' | '\u{2029}')
}

/// The same text with what is hidden spelled out: `\u{202e}`.
pub fn visible(text: &str) -> String {
    spelled_out(text, is_hidden)
}

/// Lines of text with what is hidden spelled out.
pub fn visible_lines(text: &str) -> String {
    spelled_out(text, |c| is_hidden(c) && c != '\n' && c != '\t')
}

fn spelled_out(text: &str, hidden: impl Fn(char) -> bool) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match hidden(c) {
            true => out.extend(c.escape_unicode()),
            false => out.push(c),
        }
    }
    out
}

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
    fn what_is_hidden_is_spelled_out() {
        let spelled = "a\\u{1b}[2J\\u{202e}b\\u{a}";
        assert_eq!(visible("a\u{1b}[2J\u{202e}b\n"), spelled);
        assert_eq!(visible_lines("a\u{9b}\n"), "a\\u{9b}\n");
        assert_eq!(visible("機械 \u{200d} é"), "機械 \u{200d} é");
    }

    #[test]
    fn names_are_cut_to_letters_not_bytes() {
        assert_eq!(shortened("Hüfte", 5), "Hüfte");
        assert_eq!(shortened("Hüftgelenk", 5), "Hüft…");
    }
}
