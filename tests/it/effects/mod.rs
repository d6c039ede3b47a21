//! Every effect of the library: what it computes, against a robot that is bent on
//! purpose; its slopes; its records in model files; and the code made of it.
//!
//! All walk [`sesc_model::effects::Catalog`]: an effect without an entry in
//! `hidden.rs` fails.

mod body;
pub(crate) mod compiled;
pub(crate) mod composed;
pub(crate) mod correction;
mod families;
pub(crate) mod hidden;
mod records;
pub(crate) mod robots;
mod slopes;
mod together;
mod verified;
mod virtual_robot;
