//! Figures of a plan: postures in, SVG out.

mod joints;
mod region;
#[cfg(test)]
mod tests;
mod worth;

pub use joints::joints;
pub use region::region;
pub use worth::worth;
