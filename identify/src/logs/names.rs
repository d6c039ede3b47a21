//! Names in messages: lists that stay short, and the nearest right spelling.

use std::collections::HashMap;

use sesc_model::spelling::nearest;
use sesc_model::text::listed;

/// Letters of a piece of a file in a message.
const LONGEST: usize = 64;

/// What joints' columns are called beside the joint, best first: positions, then what is none.
const POSITIONS: &str = "position pos angle q actual measured";
const NO_POSITIONS: &str = "velocity vel speed qd qdd dq effort torque tau current cmd command \
                            target desired reference error";

/// Names for a message, a dozen at most.
pub(crate) fn list(names: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    let quoted = |name: &str| format!("`{}`", short(name));
    listed(names.into_iter().map(|name| quoted(name.as_ref())), 12)
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
    // Comparing takes time.
    let right: Vec<&str> = right.take(2_000).collect();
    let near = wrong.iter().take(3).filter_map(|wrong| {
        let near = nearest(wrong, "", right.iter().copied())?;
        Some(format!("`{near}` for `{wrong}`"))
    });
    let found = near.collect::<Vec<_>>().join(", ");
    match found.is_empty() {
        true => found,
        false => format!("; did you mean {found}?"),
    }
}

/// The columns of a log that are positions of `missing` joints by their names: the name in
/// the log, then the joint.
pub(super) fn meant<'a>(
    missing: &[&'a str],
    columns: impl Iterator<Item = &'a str>,
) -> Vec<(&'a str, &'a str)> {
    let mut found: HashMap<&str, Vec<&str>> = HashMap::new();
    for column in columns {
        // `l_hip_roll_pos` is of `l_hip_roll`, not of a joint `hip`.
        let of = missing.iter().filter(|joint| holds(column, joint));
        if let Some(joint) = of.max_by_key(|joint| joint.len()) {
            found.entry(*joint).or_default().push(column);
        }
    }
    let pairs = missing.iter().filter_map(|joint| {
        let mut own = found.remove(joint)?;
        let says = |column: &str, words: &str| {
            let rest = column.replacen(joint, " ", 1).to_lowercase();
            let mut parts = rest.split(|c: char| !c.is_alphanumeric());
            parts.any(|part| words.split(' ').any(|word| word == part))
        };
        own.retain(|column| !says(column, NO_POSITIONS));
        if own.len() > 1 {
            own.retain(|column| says(column, POSITIONS));
        }
        let [one] = own[..] else { return None };
        Some((one, *joint))
    });
    pairs.take(100).collect()
}

/// Whether `name` has `part` in it, as a word or words of its own.
fn holds(name: &str, part: &str) -> bool {
    let is_end = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
    let mut places = name.match_indices(part);
    places.any(|(at, _)| {
        let (before, after) = (&name[..at], &name[at + part.len()..]);
        is_end(before.chars().next_back()) && is_end(after.chars().next())
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
    }

    #[test]
    fn lists_and_pieces_stay_short() {
        assert_eq!(list(["a", "b"]), "`a`, `b`");
        assert!(list(["x"; 20]).ends_with("and 8 more"));
        assert_eq!(short(&"é".repeat(500)).chars().count(), LONGEST + 1);
    }

    #[test]
    fn columns_that_hold_a_joint_s_name_are_told() {
        let joints = ["knee", "l_knee", "ankle"];
        let columns = [
            "/joint_states/l_knee/position",
            "/joint_states/l_knee/velocity",
            "knee_pos",
            "knee_cmd",
            "ankles",
        ];
        let found = meant(&joints, columns.into_iter());
        let expected = [
            ("knee_pos", "knee"),
            ("/joint_states/l_knee/position", "l_knee"),
        ];
        assert_eq!(found, expected);
    }
}
