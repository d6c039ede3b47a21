//! Imperfections that are any function of what the robot reads and bears.
//!
//! ```text
//! φ_j = unloaded_j + … + f(q, τ(φ))        to the fixed point
//! y   = … + f(p)                           p the reading so far
//! p   = … + c_z f(p)                       ground that gives way under the pressure at p
//! ```
//!
//! `q` is what all encoders read, `τ` what loads do to the joints (N m, N for prismatic ones).

use std::fmt;
use std::sync::Arc;

use nalgebra::Vector2;

use crate::error::Error;

use super::World;

type OfJoint = dyn Fn(&[f64], &[f64]) -> f64 + Send + Sync;
type OfSensor = dyn Fn([f64; 2]) -> f64 + Send + Sync;

#[derive(Clone, Default)]
pub(super) struct Functions {
    /// With the joint that each moves.
    joints: Vec<(usize, Arc<OfJoint>)>,
    /// With the axis that each adds to.
    sensor: Vec<(usize, Arc<OfSensor>)>,
    /// Slopes along axes.
    ground: Vec<(usize, Arc<OfSensor>)>,
}

impl fmt::Debug for Functions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = [self.joints.len(), self.sensor.len(), self.ground.len()];
        write!(f, "{all:?}")
    }
}

impl Functions {
    pub(super) fn move_joints(&self) -> bool {
        !self.joints.is_empty()
    }

    /// How far joint `j` is moved.
    pub(super) fn moved(&self, j: usize, q: &[f64], moments: &[f64]) -> f64 {
        let own = self.joints.iter().filter(|(joint, _)| *joint == j);
        own.map(|(_, function)| function(q, moments)).sum()
    }

    /// What is added to a reading.
    pub(super) fn added(&self, reading: Vector2<f64>) -> Vector2<f64> {
        sum(&self.sensor, reading)
    }

    /// The slope of soft ground under a CoP.
    pub(super) fn slope(&self, cop_m: Vector2<f64>) -> Vector2<f64> {
        sum(&self.ground, cop_m)
    }
}

fn sum(functions: &[(usize, Arc<OfSensor>)], at: Vector2<f64>) -> Vector2<f64> {
    let mut sum = Vector2::zeros();
    for (axis, function) in functions {
        sum[*axis] += function(at.into());
    }
    sum
}

impl World {
    /// The joint stands `function(q, τ)` further than its encoder says.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`.
    pub fn joint_function(
        mut self,
        joint: &str,
        function: impl Fn(&[f64], &[f64]) -> f64 + Send + Sync + 'static,
    ) -> Result<Self, Error> {
        let j = self.encoder(joint)?;
        self.functions.joints.push((j, Arc::new(function)));
        Ok(self)
    }

    /// Readings along an axis (0 x, 1 y) are `function(reading)` more, m.
    pub fn sensor_function(
        mut self,
        axis: usize,
        function: impl Fn([f64; 2]) -> f64 + Send + Sync + 'static,
    ) -> Self {
        self.functions.sensor.push((axis, Arc::new(function)));
        self
    }

    /// The ground falls off by `function(CoP)` along an axis (0 x, 1 y), as the CoP is without it;
    /// joints do not lean with it.
    pub fn ground_function(
        mut self,
        axis: usize,
        function: impl Fn([f64; 2]) -> f64 + Send + Sync + 'static,
    ) -> Self {
        self.functions.ground.push((axis, Arc::new(function)));
        self
    }
}
