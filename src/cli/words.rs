//! What the library says besides its results, as a shell knows it.

use sesc_identify::Message;

use crate::words::option;

/// A warning of the library on stderr.
pub(super) fn warn(warning: &Message) {
    super::message(&format!("warning: {}", warning.worded(option)));
}
