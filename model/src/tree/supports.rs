//! Links that a robot may stand on, by their names.

use crate::text;
use crate::urdf::nearest::suggest;

/// Words in the names of links that stand on the ground, the likeliest first.
const SUPPORTS: [&str; 3] = ["sole", "foot", "ankle"];

/// How unlikely a robot stands on the link of this name: 0 for a sole.
#[doc(hidden)]
pub fn support_rank(link: &str) -> usize {
    let name = link.to_lowercase();
    let first = SUPPORTS.iter().position(|word| name.contains(word));
    first.unwrap_or(SUPPORTS.len())
}

/// Up to a dozen names for a message, those that contain `asked` first, then soles and feet,
/// and the one that was probably meant.
pub(super) fn name_some<'a>(asked: &str, names: impl Iterator<Item = &'a str>) -> String {
    let mut names: Vec<&str> = names.collect();
    let meant = suggest(asked, "", names.iter().copied()).unwrap_or_default();
    let asked = asked.to_lowercase();
    names.sort_by_key(|name| (!name.to_lowercase().contains(&asked), support_rank(name)));
    text::listed(names, 12) + &meant
}
