//! Lists and names that stay short, and text that shows what it holds, for messages,
//! reports and generated files.

use std::collections::BTreeSet;

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

/// Text whose numbers have a true minus: `x −1.5 mm (−2e-3)`. A hyphen after a letter, a digit or
/// another sign is part of a name, an exponent or an option.
pub fn minus(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut letters = text.chars().peekable();
    while let Some(c) = letters.next() {
        let begins = out.chars().next_back().is_none_or(|before| {
            before.is_whitespace() || matches!(before, '(' | '[' | '±' | '=' | '/' | '|' | '…')
        });
        let number = letters.peek().is_some_and(|next| next.is_ascii_digit());
        out.push(if c == '-' && begins && number {
            '−'
        } else {
            c
        });
    }
    out
}

/// The first letters of a name that has more than `most`.
pub fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_string();
    }
    name.chars().take(most - 1).chain(['…']).collect()
}

/// Names of which each has at most `most` letters and that stay as different as they are: the middle
/// is left out where that tells them apart, else more of the beginning or of the end; names that
/// differ everywhere stay whole.
pub fn apart(names: &[&str], most: usize) -> Vec<String> {
    let kinds = |names: &[String]| names.iter().collect::<BTreeSet<_>>().len();
    let whole: Vec<String> = names.iter().map(ToString::to_string).collect();
    let cut = |tail: usize| -> Vec<String> {
        let short = |name: &String| {
            let letters: Vec<char> = name.chars().collect();
            match letters.len() <= most {
                true => name.clone(),
                false => {
                    let (head, end) = (most - 1 - tail, letters.len() - tail);
                    let parts = letters[..head].iter().chain(&['…']).chain(&letters[end..]);
                    parts.collect()
                }
            }
        };
        whole.iter().map(short).collect()
    };
    let room = most.saturating_sub(1);
    let mut tails: Vec<usize> = (0..=room).collect();
    tails.sort_by_key(|tail| (2 * tail).abs_diff(room));
    let cuts = tails.into_iter().map(cut);
    let found = { cuts }.find(|short| kinds(short) == kinds(&whole));
    found.unwrap_or_else(|| whole.clone())
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
    fn numbers_have_a_true_minus_and_names_a_hyphen() {
        for (text, shown) in [
            ("-1.5 mm (-2) ± -3e-4", "−1.5 mm (−2) ± −3e-4"),
            ("l-knee-2 --noise 5-7 -.5", "l-knee-2 --noise 5-7 -.5"),
        ] {
            assert_eq!(minus(text), shown);
        }
    }

    #[test]
    fn names_are_never_cut_before_what_tells_them_apart() {
        let short = |names: &[&str], most| apart(names, most).join(" ");
        let links = ["leg_right_3_link.x", "leg_right_3_link.z", "l_knee.x"];
        assert_eq!(
            short(&links, 17),
            "leg_righ…3_link.x leg_righ…3_link.z l_knee.x"
        );
        let joints = ["arm_right_2_joint", "arm_right_3_joint"];
        assert_eq!(short(&joints, 12), "arm_…2_joint arm_…3_joint");
        let turned = ["left_arm_motor_housing", "right_arm_motor_housing"];
        assert_eq!(short(&turned, 9), "left…sing righ…sing");
        let whole = ["abcdef", "abzdef"];
        assert_eq!(short(&whole, 3), "abcdef abzdef");
    }

    #[test]
    fn names_are_cut_to_letters_not_bytes() {
        assert_eq!(shortened("Hüfte", 5), "Hüfte");
        assert_eq!(shortened("Hüftgelenk", 5), "Hüft…");
    }
}
