//! A plan: on the console, and as a page with figures.

mod page;
#[cfg(test)]
mod tests;
mod text;

pub use page::page;
pub use text::text;
