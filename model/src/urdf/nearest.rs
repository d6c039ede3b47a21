//! The nearest spelling of a name that a URDF refers to and does not have.

use super::report::shown;
use crate::spelling::nearest;

/// Comparing every wrong name with every right one takes time; after this many
/// the rest go without a suggestion.
pub(super) const SUGGESTIONS: usize = 20;

/// `; did you mean `elbow`?`, or none when no name is close. Among equals
/// the one wins that starts like `owner`, whose reference it is.
pub(crate) fn suggest<'a>(
    wrong: &str,
    owner: &str,
    names: impl Iterator<Item = &'a str>,
) -> Option<String> {
    nearest(wrong, owner, names).map(|name| format!("; did you mean {}?", shown(name)))
}
