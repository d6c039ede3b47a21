//! Figures of a plan: postures in, SVG out.

mod efficiency;
mod joints;
mod region;
#[cfg(test)]
mod tests;

pub use efficiency::efficiency;
pub use joints::joints;
pub use region::region;
