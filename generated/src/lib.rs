//! Machine-written modules for robots of `robots/`; `cargo regen` rewrites them.

#![no_std]
#![forbid(unsafe_code)]

#[rustfmt::skip]
pub mod op2_r_sole;
#[rustfmt::skip]
pub mod op2_l_sole;
#[rustfmt::skip]
pub mod two_link_foot;
