//! Rust crates to measure against, behind the plain C functions of `peers.h`.

mod fit;
mod kinematics;
mod symbolic;
