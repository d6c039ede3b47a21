//! Lists and names that stay short, and text that shows what it holds, for messages,
//! reports and generated files.

use std::collections::BTreeMap;

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

/// Sentences of one kind as one: those that differ by the first name in backquotes alone, from
/// three on, are told of the first, with the names of the others.
pub fn gathered(sentences: Vec<String>) -> Vec<String> {
    const FEW: usize = 3;
    let kind = |said: &str| -> Option<(String, String)> {
        let (before, rest) = said.split_once('`')?;
        let (name, after) = rest.split_once('`')?;
        let place = before.trim_start_matches(|c: char| c != ' ');
        // Digits differ from one to the next: how far off each is.
        let like = |text: &str| -> String {
            let plain = text.chars().filter(|c| !c.is_ascii_digit());
            plain.collect()
        };
        Some((like(place) + "`" + &like(after), name.to_string()))
    };
    let mut names: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (kind, name) in sentences.iter().filter_map(|said| kind(said)) {
        names.entry(kind).or_default().push(name);
    }
    let mut out = Vec::new();
    for said in sentences {
        let own = kind(&said).and_then(|(kind, name)| Some((names.get(&kind)?, name)));
        match own.filter(|(all, _)| all.len() >= FEW) {
            Some((all, name)) if all[0] == name => {
                let others = all[1..].iter().map(|name| format!("`{name}`"));
                let others = listed(others, 6);
                out.push(format!("{said}; likewise {} more: {others}", all.len() - 1));
            }
            Some(_) => {}
            None => out.push(said),
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_of_one_kind_are_one() {
        let said = |k: usize| format!("r.urdf:{k}: joint `j{k}`: {k}e-4 rad off");
        let mut all: Vec<String> = (1..=9).map(said).collect();
        all.push("r.urdf:7: link `a`: no mass".into());
        let found = gathered(all.clone());
        assert_eq!(found.len(), 2);
        let first = "r.urdf:1: joint `j1`: 1e-4 rad off; likewise 8 more: `j2`, `j3`, `j4`, `j5`, \
                     `j6`, `j7` and 2 more";
        assert_eq!(found, [first, "r.urdf:7: link `a`: no mass"]);
        // Two stay two.
        assert_eq!(gathered(all[..2].to_vec()), all[..2]);
    }

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
