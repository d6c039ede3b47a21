//! What a fit found: on the console, and as a page with figures.

mod text;

pub use text::text;
