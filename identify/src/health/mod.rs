//! A look at the data before any hypothesis: what no effect should be fitted to.
//!
//! ```text
//! columns    an axis of the CoP that does not move where CAD says it must
//! frames     CAD on another link, or with another axis up, predicts the readings
//! order      readings scatter as CAD says, and go with no posture
//! encoders   an encoder that does not move, and a gap that motion of its joint explains
//! ```
//!
//! Data that fit are healthy: every test asks for a gap far above the noise first. And what
//! a known effect explains is no broken data: before a finding makes data unusable it must
//! hold under every wiring that the effects know ([`wirings`]) and any offset, gain, rotation
//! or exchange of the sensor's axes.

mod columns;
mod criteria;
mod encoders;
mod finding;
mod frames;
mod order;
mod statistics;
mod wirings;

use sesc_model::{Function, Model, Snapping};

use crate::evaluate::Evaluator;
use crate::observations::postures::Postures;
use crate::robot::Robot;
pub use finding::{Finding, Kind};
use wirings::Wirings;

/// What is found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Health {
    /// Each finding; data that cannot be used have one.
    pub findings: Vec<Finding>,
}

impl Health {
    /// Whether anything can be done with the data.
    pub fn is_usable(&self) -> bool {
        !self.findings.iter().any(|f| f.kind.makes_unusable())
    }
}

/// A log beside what CAD says of it.
struct Look<'a> {
    robot: &'a Robot,
    model: &'a Model,
    snapping: Snapping,
    data: &'a Postures,
    /// CoM by CAD, three per posture, m.
    com: Vec<f64>,
    /// Its x and y, m.
    predicted: Vec<f64>,
}

/// Examine a log of `model`; postures on a joint whose encoder is stuck count as little as
/// is known of them from then on.
pub fn examine(robot: &Robot, model: &Model, snapping: Snapping, data: &mut Postures) -> Health {
    let com = Evaluator::new(model, Function::Com).run(&data.q, data.len());
    let predicted = com.chunks_exact(3).flat_map(|c| [c[0], c[1]]).collect();
    let look = Look {
        robot,
        model,
        snapping,
        data,
        com,
        predicted,
    };
    let wirings = Wirings::new(model, data);
    let broken = columns::dead_axes(&look, &wirings)
        .or_else(|| frames::wrong(&look, &wirings))
        .or_else(|| order::shuffled(&look, &wirings));
    if let Some(finding) = broken {
        return Health {
            findings: vec![finding],
        };
    }
    let stuck = encoders::stuck(&look, &wirings);
    if let Some(stuck) = &stuck {
        data.std.clone_from(&stuck.std);
    }
    Health {
        findings: stuck.into_iter().map(|stuck| stuck.finding).collect(),
    }
}
