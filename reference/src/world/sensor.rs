//! From the pressure under the sole to what is written down.
//!
//! ```text
//! y    = Rot(ψ) diag(gain) p + o + u d + sine + jump
//! log  = unit · A y                      axes exchanged or turned round, millimetres
//! ```
//!
//! `p` is the CoP, as the [cells](super::cells) have it where there are any.
//! `u` runs from 0 to 1 over a log, by pose number.

use nalgebra::{Matrix2, Rotation2, Vector2};

use crate::error::Error;

use super::World;
use super::statics::above_zero;

#[derive(Debug, Clone)]
pub(super) struct Sensor {
    gain: Vector2<f64>,
    rotation: Rotation2<f64>,
    offset_m: Vector2<f64>,
    drift_m: Vector2<f64>,
    wiring: Matrix2<f64>,
    unit: f64,
    pub outliers: Option<Outliers>,
}

/// Which postures of a log jump, and how far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outliers {
    pub fraction: f64,
    pub size_m: f64,
    pub seed: u64,
}

impl Sensor {
    pub(super) fn ideal() -> Self {
        Self {
            gain: Vector2::new(1.0, 1.0),
            rotation: Rotation2::identity(),
            offset_m: Vector2::zeros(),
            drift_m: Vector2::zeros(),
            wiring: Matrix2::identity(),
            unit: 1.0,
            outliers: None,
        }
    }

    /// The reading behind the cells, before it is written down.
    pub(super) fn reading(&self, cop_m: Vector2<f64>, progress: f64) -> Vector2<f64> {
        let drift = self.drift_m * progress;
        self.rotation * cop_m.component_mul(&self.gain) + self.offset_m + drift
    }

    /// What is written down, m unless another unit is.
    pub(super) fn write(&self, reading: Vector2<f64>) -> [f64; 2] {
        (self.wiring * reading * self.unit).into()
    }
}

impl World {
    /// The sensor's zero lies elsewhere: `offset_m` is added to every reading,
    /// in the support frame. Offsets add up.
    pub fn sensor_offset(mut self, offset_m: [f64; 2]) -> Self {
        self.sensor.offset_m += Vector2::from(offset_m);
        self
    }

    /// Readings come out `gain` times as large, per axis about the support's
    /// origin, before any rotation. Gains multiply.
    pub fn sensor_gain(mut self, gain: [f64; 2]) -> Self {
        self.sensor.gain.component_mul_assign(&Vector2::from(gain));
        self
    }

    /// Readings come out turned by `yaw` (rad) about the support's z axis,
    /// counter-clockwise seen from above, before any offset. Rotations add up.
    pub fn sensor_rotation(mut self, yaw: f64) -> Self {
        self.sensor.rotation *= Rotation2::new(yaw);
        self
    }

    /// Readings wander by `drift_m` from the first to the last of a
    /// [log](World::readings), evenly by pose number. Drifts add up.
    pub fn sensor_drift(mut self, drift_m: [f64; 2]) -> Self {
        self.sensor.drift_m += Vector2::from(drift_m);
        self
    }

    /// The reading's x and y are exchanged, then turned round where a sign is
    /// −1, when they are written down.
    pub fn sensor_axes(mut self, swapped: bool, signs: [f64; 2]) -> Self {
        let swap = if swapped {
            Matrix2::new(0.0, 1.0, 1.0, 0.0)
        } else {
            Matrix2::identity()
        };
        self.sensor.wiring =
            Matrix2::from_diagonal(&Vector2::from(signs)) * swap * self.sensor.wiring;
        self
    }

    /// One metre is written down as `per_metre`: 1000 in millimetres.
    pub fn sensor_unit(mut self, per_metre: f64) -> Self {
        self.sensor.unit *= per_metre;
        self
    }

    /// A fraction of a log's postures reads wrong: thrown 0.6 to 1.5 times
    /// `size_m` in any direction. Which ones, the seed decides.
    ///
    /// # Errors
    /// `ErrorKind::Value` unless the fraction is above zero.
    pub fn cop_outliers(mut self, fraction: f64, size_m: f64, seed: u64) -> Result<Self, Error> {
        self.sensor.outliers = Some(Outliers {
            fraction: above_zero("fraction", fraction)?,
            size_m,
            seed,
        });
        Ok(self)
    }
}
