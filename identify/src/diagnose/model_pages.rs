//! Pages of what a diagnosis may name beside effects.

use super::hypothesis::{FREE_MASSES, MODELS};

/// What a diagnosis may name that is no effect: its name, the kind of thing that it is about, and
/// its page, which begins with a sentence.
#[doc(hidden)]
pub const MODEL_PAGES: [(&str, &str, &str); MODELS] = [
    (
        FREE_MASSES,
        "the robot",
        include_str!("pages/mass_distribution.md"),
    ),
    (
        "cop_outliers",
        "readings",
        include_str!("pages/cop_outliers.md"),
    ),
];
