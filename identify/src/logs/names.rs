//! Names in messages: lists that stay short, and the nearest right spelling.

use sesc_model::spelling::nearest;
use sesc_model::text::listed;

/// Letters of a piece of a file in a message.
const LONGEST: usize = 64;
/// Names that a wrong one is compared with, at most: it takes time.
const COMPARED: usize = 2_000;
/// Wrong names that a message says more of.
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
        .filter_map(|wrong| {
            let around = right.iter().copied().filter(|own| contains(own, wrong));
            let near = around.min_by_key(|own| own.len());
            let near = near.or_else(|| nearest(wrong, "", right.iter().copied()))?;
            Some(format!("`{}` for `{wrong}`", short(near)))
        })
        .collect();
    match found.len() {
        0 => String::new(),
        _ => format!("; did you mean {}?", found.join(", ")),
    }
}

/// Whether a name has another in it, with its ends: `q/l_knee [rad]` has `l_knee`.
fn contains(name: &str, part: &str) -> bool {
    let ends = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
    name.match_indices(part).any(|(at, _)| {
        ends(name[..at].chars().next_back()) && ends(name[at + part.len()..].chars().next())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_wrong_names_get_a_suggestion() {
        let joints = ["l_knee", "r_knee", "head_pan"];
        let said = suggestion(&["L-Knee", "camera", "hed_pan"], joints.into_iter());
        assert_eq!(
            said,
            "; did you mean `l_knee` for `L-Knee`, `head_pan` for `hed_pan`?"
        );
        assert_eq!(suggestion(&["camera"], joints.into_iter()), "");
        let columns = ["qd/l_knee [rad/s]", "q/l_knee [rad]", "nickel_knees"];
        let said = suggestion(&["l_knee"], columns.into_iter());
        assert_eq!(said, "; did you mean `q/l_knee [rad]` for `l_knee`?");
    }

    #[test]
    fn lists_and_pieces_stay_short() {
        assert_eq!(list(&["a", "b"]), "`a`, `b`");
        assert!(list(&["x"; 20]).ends_with("and 8 more"));
        assert_eq!(short(&"é".repeat(500)).chars().count(), LONGEST + 1);
    }
}
