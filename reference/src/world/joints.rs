//! From what the encoders say to where the joints would stand unloaded.
//!
//! ```text
//! φ_j = scale_j q_w(j) + offset_j + wave_j sin(n_j q_w(j) + phase_j)
//! ```
//!
//! `w(j)` is the channel that joint j is wired to, itself where nothing is
//! swapped; a reversed sign is a scale of −1, a log in degrees one of π/180.
//! What bends joints further is in [`statics`](super::statics).

use std::f64::consts::PI;

use crate::error::{Error, Problem};
use crate::joint::JointKind;

use super::World;

/// One entry of the posture between encoder and joint.
#[derive(Debug, Clone)]
pub(super) struct Encoder {
    /// The entry of the log that holds this joint's angle.
    pub channel: usize,
    pub scale: f64,
    pub offset: f64,
    pub wave: Option<Wave>,
}

/// What a gear gets wrong again and again.
#[derive(Debug, Clone)]
pub(super) struct Wave {
    /// Rad or m.
    amplitude: f64,
    harmonic: f64,
    phase: f64,
}

impl Encoder {
    pub(super) fn true_of(dof: usize) -> Self {
        Self {
            channel: dof,
            scale: 1.0,
            offset: 0.0,
            wave: None,
        }
    }

    fn position(&self, q: &[f64]) -> f64 {
        let q = q[self.channel];
        let linear = self.scale * q + self.offset;
        match &self.wave {
            Some(wave) => linear + wave.amplitude * (wave.harmonic * q + wave.phase).sin(),
            None => linear,
        }
    }
}

impl World {
    /// The joint stands `offset` (rad or m) further than its encoder says.
    /// Joints that mimic it follow where it really is. Offsets add up.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`.
    pub fn joint_offset(mut self, joint: &str, offset: f64) -> Result<Self, Error> {
        let j = self.encoder(joint)?;
        self.encoders[j].offset += offset;
        Ok(self)
    }

    /// The joint moves `factor` times as far as its encoder says (1: true),
    /// counted from its zero and before any offset. Factors multiply.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`.
    pub fn joint_scale(mut self, joint: &str, factor: f64) -> Result<Self, Error> {
        let j = self.encoder(joint)?;
        self.encoders[j].scale *= factor;
        Ok(self)
    }

    /// The encoder counts backwards: the joint stands at `-q`.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`.
    pub fn joint_sign(self, joint: &str) -> Result<Self, Error> {
        self.joint_scale(joint, -1.0)
    }

    /// Two plugs are exchanged: each joint stands where the other's encoder
    /// says. Scales and offsets stay with their joint.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`.
    pub fn joint_swap(mut self, one: &str, other: &str) -> Result<Self, Error> {
        let (one, other) = (self.encoder(one)?, self.encoder(other)?);
        let channel = self.encoders[one].channel;
        self.encoders[one].channel = self.encoders[other].channel;
        self.encoders[other].channel = channel;
        Ok(self)
    }

    /// The log's joint angles are in degrees, its prismatic positions in millimetres.
    pub fn joints_in_degrees(mut self) -> Self {
        let kinds = self.robot().movable_joints().map(|joint| joint.kind);
        let units: Vec<f64> = kinds
            .map(|kind| match kind {
                JointKind::Prismatic => 1e-3,
                _ => PI / 180.0,
            })
            .collect();
        for (encoder, unit) in self.encoders.iter_mut().zip(units) {
            encoder.scale *= unit;
        }
        self
    }

    /// The gear is not round: the joint stands `amplitude sin(harmonic q +
    /// phase)` further than its encoder says; harmonic 1 is a gear off its
    /// centre. It replaces an earlier one. Not in the library of effects.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`.
    pub fn gear_error(
        mut self,
        joint: &str,
        amplitude: f64,
        harmonic: f64,
        phase: f64,
    ) -> Result<Self, Error> {
        let j = self.encoder(joint)?;
        self.encoders[j].wave = Some(Wave {
            amplitude,
            harmonic,
            phase,
        });
        Ok(self)
    }

    /// Where the joints stand before any load bends them, hidden joints at 0.
    pub(super) fn unloaded(&self, q: &[f64]) -> Vec<f64> {
        assert_eq!(q.len(), self.dof(), "one entry per movable joint");
        let mut joints: Vec<f64> = self.encoders.iter().map(|e| e.position(q)).collect();
        joints.resize(self.reference.dof(), 0.0);
        joints
    }

    /// Index of a joint that has an encoder.
    pub(super) fn encoder(&self, joint: &str) -> Result<usize, Error> {
        // Hidden joints stand behind all others; `robot()` knows no name twice.
        let j = self.robot().dof_index(joint)?;
        if j < self.dof() {
            Ok(j)
        } else {
            Err(Problem::HiddenJoint {
                joint: joint.to_owned(),
            }
            .into())
        }
    }
}
