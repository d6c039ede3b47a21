//! Figures of an identification: what was found, rows in, SVG out.

mod bodies;
mod changes;
mod correlation;
mod sole;
#[cfg(test)]
mod tests;
mod waterfall;

pub use bodies::bodies;
pub use changes::changes;
pub use correlation::correlation;
pub use sole::sole;
pub use waterfall::waterfall;

/// Longest name that fits beside a plane.
const NAME: usize = 21;

/// A name that fits beside a plane.
pub(in crate::report::figures) fn shortened(name: &str) -> String {
    if name.chars().count() <= NAME {
        return name.to_string();
    }
    name.chars().take(NAME - 1).chain(['…']).collect()
}
