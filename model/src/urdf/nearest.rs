//! The nearest spelling of a name that a URDF refers to and does not have.

use super::report::shown;
use crate::spelling::nearest;

/// Comparing every wrong name with every right one takes time; after this many
/// the rest go without a suggestion.
const MOST: usize = 20;

/// Suggestions for one wrong name after the other.
#[derive(Default)]
pub(super) struct Suggestions(usize);

impl Suggestions {
    /// The end of a message about the next wrong name, which `owner` refers to.
    pub(super) fn remedy<'a>(
        &mut self,
        wrong: &str,
        owner: &str,
        names: impl Iterator<Item = &'a str>,
        otherwise: &str,
    ) -> String {
        self.0 += 1;
        let names = names.filter(|_| self.0 <= MOST);
        suggest(wrong, owner, names).unwrap_or_else(|| otherwise.to_string())
    }
}

/// `; did you mean `elbow`?`, or none when no name is close. Among equals
/// the one wins that starts like `owner`, whose reference it is.
pub(crate) fn suggest<'a>(
    wrong: &str,
    owner: &str,
    names: impl Iterator<Item = &'a str>,
) -> Option<String> {
    nearest(wrong, owner, names).map(|name| format!("; did you mean {}?", shown(name)))
}

/// `; did you mean `elbow`?` for the end of a message about a name that does not exist, empty
/// where none of `names` is close.
///
/// ```
/// use sesc_model::urdf::suggestion;
///
/// let meant = suggestion("l_eblow", ["l_elbow", "l_wrist"]);
/// assert_eq!(meant, "; did you mean `l_elbow`?");
/// assert_eq!(suggestion("camera", ["l_elbow"]), "");
/// ```
pub fn suggestion<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    suggest(wrong, "", names.into_iter()).unwrap_or_default()
}
