//! Machine-written modules for robots of `robots/`; `cargo regen` rewrites them.

#![no_std]
#![forbid(unsafe_code)]

/// `op2` on its link `r_sole`.
#[rustfmt::skip]
pub mod op2_r_sole;
/// `two_link` on its link `foot`.
#[rustfmt::skip]
pub mod two_link_foot;
