//! How the robot gives way under its loads.
//!
//! ```text
//! τ_j   = s_j a_j · Σ_{loads beyond j} (p - o_j) × F    revolute; s_j a_j · Σ F prismatic
//! φ_j   = unloaded_j + slack_j + (τ_j(φ) + cable_j(φ_j)) / k_j      to the fixed point
//! |slack_j| ≤ β_j / 2                                   dead bands
//! ```
//!
//! A load is a force `F` (N, support frame) at a point `p` of a link: every
//! link's weight, whatever is hung on or pulled at it. `o_j`, `a_j` are the joint's place and axis in the support frame,
//! `s_j` is −1 where the joint's parent is the link that moves. A follower's
//! moment counts for its master, times its factor.
//!
//! A loose joint starts in the middle of its band and slides towards its
//! moment, slow enough that inertia plays no part; all loose joints slide at
//! once, each through its band in the same time, until each has reached an end
//! or a place where its moment changes sign. Bands are narrow and moments
//! cross-coupled, so there may be two such places: this one is reached first.

use nalgebra::{Point3, Vector3};

use crate::error::{Error, Problem};
use crate::joint::{JointKind, Pose};
use crate::robot::Robot;

use super::World;

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;

/// A force at a point of a link, in the support frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Load {
    pub link: usize,
    pub at_m: Point3<f64>,
    pub force_n: Vector3<f64>,
}

/// A force that somebody pulls with.
#[derive(Debug, Clone)]
pub(super) struct Pull {
    pub link: usize,
    /// In the link's frame.
    pub at_m: Point3<f64>,
    /// In the support frame.
    pub force_n: Vector3<f64>,
}

/// How much one entry of the posture gives way.
#[derive(Debug, Clone, Default)]
pub(super) struct Yielding {
    /// 1/stiffness, rad/(N m) or m/N; 0 is rigid.
    pub compliance: f64,
    /// Width of the dead band, rad or m.
    pub slack: f64,
    pub cable: Option<Cable>,
}

/// What pulls a joint back beyond a position.
#[derive(Debug, Clone)]
pub(super) struct Cable {
    pub stiffness: f64,
    pub taut: f64,
}

impl Yielding {
    pub(super) fn cable_moment(&self, joint: f64) -> f64 {
        self.cable.as_ref().map_or(0.0, |cable| {
            -cable.stiffness * (joint - cable.taut).max(0.0)
        })
    }

    /// Where spring and cable hold the joint under a moment; `free` is where it
    /// stands without any. The cable may well be the stiffer of the two.
    fn held(&self, free: f64, moment: f64) -> f64 {
        let sprung = free + self.compliance * moment;
        match &self.cable {
            Some(cable) if sprung > cable.taut => {
                let share = self.compliance * cable.stiffness;
                (sprung + share * cable.taut) / (1.0 + share)
            }
            _ => sprung,
        }
    }
}

/// Which links every joint of the file moves as seen from the support, and
/// whether it moves them backwards.
pub(super) fn moved_links(robot: &Robot, support: usize) -> Vec<(Vec<bool>, f64)> {
    let joints = robot.joints();
    joints
        .iter()
        .map(|joint| {
            let mut below = vec![false; robot.links().len()];
            below[joint.child] = true;
            for &j in robot.joints_from_root() {
                if below[joints[j].parent] {
                    below[joints[j].child] = true;
                }
            }
            if below[support] {
                (below.iter().map(|below| !below).collect(), -1.0)
            } else {
                (below, 1.0)
            }
        })
        .collect()
}

impl World {
    /// A force (N, in the axes of the support frame, whatever the posture)
    /// pulls at the origin of a link. It overturns; the joints yield to it
    /// where they are [soft](World::joint_compliance) or
    /// [loose](World::backlash).
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`.
    pub fn external_force(self, link: &str, force_n: [f64; 3]) -> Result<Self, Error> {
        self.external_force_at(link, force_n, [0.0; 3])
    }

    /// A force as [`World::external_force`], at the point `at_m` of the link's
    /// frame.
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`.
    pub fn external_force_at(
        mut self,
        link: &str,
        force_n: [f64; 3],
        at_m: [f64; 3],
    ) -> Result<Self, Error> {
        self.pulls.push(Pull {
            link: self.robot().link_index(link)?,
            at_m: Point3::from(at_m),
            force_n: Vector3::from(force_n),
        });
        Ok(self)
    }

    /// The joint is held by a spring of this stiffness, N m/rad or N/m; a
    /// second one sits in series.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`; `ErrorKind::Value` unless it is above zero.
    pub fn joint_compliance(mut self, joint: &str, stiffness: f64) -> Result<Self, Error> {
        let j = self.encoder(joint)?;
        self.yielding[j].compliance += 1.0 / above_zero("stiffness", stiffness)?;
        Ok(self)
    }

    /// Every joint is held by a spring of this stiffness.
    ///
    /// # Errors
    /// `ErrorKind::Value` unless it is above zero.
    pub fn joint_compliance_all(mut self, stiffness: f64) -> Result<Self, Error> {
        let compliance = 1.0 / above_zero("stiffness", stiffness)?;
        for joint in &mut self.yielding[..self.encoders.len()] {
            joint.compliance += compliance;
        }
        Ok(self)
    }

    /// The joint moves freely within a band of this width, rad or m, whose
    /// middle is what the encoder says.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`; `ErrorKind::Value` unless it is above zero.
    pub fn backlash(mut self, joint: &str, width: f64) -> Result<Self, Error> {
        let j = self.encoder(joint)?;
        self.yielding[j].slack += above_zero("dead band", width)?;
        Ok(self)
    }

    /// Every joint moves freely within a band of this width.
    ///
    /// # Errors
    /// `ErrorKind::Value` unless it is above zero.
    pub fn backlash_all(mut self, width: f64) -> Result<Self, Error> {
        let width = above_zero("dead band", width)?;
        for joint in &mut self.yielding[..self.encoders.len()] {
            joint.slack += width;
        }
        Ok(self)
    }

    /// What gravity and pulls do to the joints at their true positions `joints`:
    /// N m, or N for prismatic ones.
    pub(super) fn moments(&self, joints: &[f64]) -> Vec<f64> {
        let robot = self.robot();
        let poses = self.reference.link_poses(joints);
        let loads = self.loads(&poses);
        let mut moments = vec![0.0; joints.len()];
        for (j, (joint, coordinate)) in robot.joints().iter().zip(robot.coordinates()).enumerate() {
            let Some(dof) = coordinate.dof else { continue };
            let (moved, sign) = &self.moved[j];
            let place: Pose = poses[joint.parent] * joint.origin;
            let origin = Point3::from(place.translation.vector);
            let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
            for load in loads.iter().filter(|load| moved[load.link]) {
                force += load.force_n;
                moment += (load.at_m - origin).cross(&load.force_n);
            }
            let along = match joint.kind {
                JointKind::Prismatic => force,
                _ => moment,
            };
            let axis = place.rotation * joint.axis.into_inner();
            moments[dof] += coordinate.factor * sign * axis.dot(&along);
        }
        moments
    }

    /// Where the joints come to rest when the encoders read `q`; not a number
    /// where the springs are too soft to hold the robot.
    pub(super) fn settle(&self, q: &[f64]) -> Vec<f64> {
        let unloaded = self.unloaded(q);
        let soft = self.yielding.iter().any(|joint| joint.compliance > 0.0);
        let loose = self.yielding.iter().any(|joint| joint.slack > 0.0);
        if !soft && !loose && !self.functions.move_joints() {
            return unloaded;
        }
        let mut slides: Vec<Slide> = self.yielding.iter().map(Slide::new).collect();
        let mut joints = unloaded.clone();
        for round in 0..MAX_STEPS {
            if self.rounds == Some(round) {
                return joints;
            }
            let moments = self.moments(&joints);
            let mut moved: f64 = 0.0;
            for (j, (joint, yielding)) in joints.iter_mut().zip(&self.yielding).enumerate() {
                let slid = slides[j].follow(moments[j] + yielding.cable_moment(*joint));
                let free = unloaded[j] + slides[j].at + self.functions.moved(j, q, &moments);
                let next = yielding.held(free, moments[j]);
                moved = moved.max((next - *joint).abs()).max(slid);
                *joint = next;
            }
            // False for what is not a number, too.
            if !(moved > AT_REST && moved < 1e3) {
                return if moved <= AT_REST {
                    joints
                } else {
                    vec![f64::NAN; joints.len()]
                };
            }
        }
        vec![f64::NAN; joints.len()]
    }
}

/// Movement below which everything rests, rad or m.
const AT_REST: f64 = 1e-13;
const MAX_STEPS: usize = 4000;

/// A joint on its way through its dead band.
struct Slide {
    half: f64,
    at: f64,
    /// How far it goes in one step; halved whenever its moment reverses.
    step: f64,
    heading: f64,
}

impl Slide {
    fn new(joint: &Yielding) -> Self {
        Self {
            half: joint.slack / 2.0,
            at: 0.0,
            step: joint.slack / 40.0,
            heading: 0.0,
        }
    }

    /// One step towards the moment; how far it went.
    fn follow(&mut self, moment: f64) -> f64 {
        if self.half == 0.0 || moment == 0.0 {
            return 0.0;
        }
        let heading = moment.signum();
        if heading == -self.heading {
            self.step /= 2.0;
        } else {
            self.step = (self.step * 1.1).min(self.half / 20.0);
        }
        self.heading = heading;
        let before = self.at;
        self.at = (before + heading * self.step).clamp(-self.half, self.half);
        (self.at - before).abs()
    }
}

pub(super) fn above_zero(what: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Problem::Value { what, value }.into())
    }
}
