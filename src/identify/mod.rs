//! From postures and CoP to parameters.

pub mod fit;
