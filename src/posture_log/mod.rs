//! Posture logs: joint angles of many postures, from CSV with a sidecar.

mod csv;
mod sidecar;

pub use csv::{PostureReader, Row};
pub use sidecar::{Angles, Sidecar};
