//! The measurement equation, open to effects.
//!
//! ```text
//! q ─ wiring, joints ─▶ φ ─ bends under gravity ─▶ φ'      r ─ loads ─▶ r'
//! c = r'_0 + Σ B_i(φ') r'_i                                CoM, loads included
//! p = c_xy + c_z·tilt + Σ b_k z_k(φ')                      CoP; pulls b at points z
//! y = sensor(p)                                            the reading
//! ```
//!
//! Stages are walked in this order; an effect rewrites what its stage holds.
//! Gravity, for bends as for the CoP, points along `(tilt_x, tilt_y, −1)`.

use super::Scratch;
use crate::effects::Target;
use crate::expr::{Graph, Id};
use crate::model::{Given, Model};

/// Rounds of `φ' = φ + bend(τ(φ'))`: each adds a factor of (gravity stiffness /
/// joint stiffness), 0.2 and less in joints that can carry the robot.
pub const ROUNDS: usize = 4;
/// Gravity moment (m) times this, clamped to ±1, is its sign.
const SHARP: f64 = 1e9;

/// What a posture brings along beside its joint positions, in this order:
/// place in the log, tilt (2), rates, accelerations, sides of dead bands.
#[derive(Debug, Clone, Copy)]
pub struct Circumstances {
    dof: usize,
}

impl Circumstances {
    pub fn of(model: &Model) -> Circumstances {
        Circumstances { dof: model.dof() }
    }

    /// Of a robot with `dof` independent joints.
    pub fn with_joints(dof: usize) -> Circumstances {
        Circumstances { dof }
    }

    /// Entries per posture.
    pub fn len(self) -> usize {
        3 + 3 * self.dof
    }

    /// Never: tilt is always there.
    pub fn is_empty(self) -> bool {
        false
    }

    /// Place in the log: 0 at its first posture, 1 at its last.
    pub fn place(self) -> usize {
        0
    }

    /// Gravity's direction: `-g_x / g_z` (axis 0), `-g_y / g_z` (axis 1).
    pub fn tilt(self, axis: usize) -> usize {
        1 + axis
    }

    /// Velocity of a joint, rad/s or m/s.
    pub fn rate(self, dof: usize) -> usize {
        3 + dof
    }

    /// Acceleration of a joint, rad/s² or m/s².
    pub fn acceleration(self, dof: usize) -> usize {
        3 + self.dof + dof
    }

    /// Which side of its dead band a joint rests on, −1 to 1.
    pub fn side(self, dof: usize) -> usize {
        3 + 2 * self.dof + dof
    }
}

/// Where the measurement gets what its posture alone does not tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// A posture of a log: circumstances are inputs.
    Log,
    /// Any posture: level ground, standing still, sides by the gravity moments.
    Posture,
    /// Any posture, with gravity's direction from its circumstances.
    Tilted,
}

/// A pull on a point of the robot.
struct Pull {
    /// The point, as base parameters: its position is what their CoM would be.
    point: Vec<f64>,
    /// Horizontal force over the weight on the ground.
    force: [Id; 2],
}

/// A joint that gives way to its gravity moment.
#[derive(Clone, Copy)]
enum Bend {
    /// By `1` times its moment (rad per m of moment over weight).
    Spring(usize, Id),
    /// To one end of a dead band of half this width.
    Slack(usize, Id),
}

/// The measurement of one posture while effects rewrite it.
pub struct Measured<'m> {
    scratch: Scratch<'m>,
    pub(crate) source: Source,
    /// Input array of circumstances.
    circumstances: u16,
    /// What each encoder says of its joint, rad or m.
    pub(crate) wired: Vec<Id>,
    /// Joint positions as the robot has them, rad or m.
    pub(crate) joints: Vec<Id>,
    /// Gravity's slope against the sole's normal.
    pub(crate) tilt: [Id; 2],
    /// CoP reading, m; none before the sensor stage.
    pub(crate) reading: [Id; 2],
    /// Units of the record per metre.
    pub(crate) record_scale: f64,
    /// Foot cells, m, where the log says where they are.
    pub(crate) cells: Vec<[f64; 2]>,
    pulls: Vec<Pull>,
    bends: Vec<Bend>,
}

impl<'m> Measured<'m> {
    /// The nominal measurement: joints where the encoders say, CAD's loads.
    ///
    /// `circumstances` is the number of their input array; parameters are input
    /// array 1 unless `baked`.
    pub(crate) fn new(
        model: &'m Model,
        source: Source,
        circumstances: u16,
        baked: Option<Vec<f64>>,
        cells: &[[f64; 2]],
    ) -> Self {
        let mut scratch = Scratch::new(model, Given::Positions);
        scratch.baked = baked;
        let joints: Vec<Id> = (0..model.dof()).map(|j| scratch.g.input(0, j)).collect();
        let masses = (0..model.base.params.len())
            .map(|k| {
                let limit = scratch.parameter_limit(Some(k));
                (scratch.parameter(Some(k)), limit)
            })
            .collect();
        scratch.masses = Some(masses);
        let zero = scratch.g.constant(0.0);
        let mut measured = Measured {
            scratch,
            source,
            circumstances,
            wired: joints.clone(),
            joints,
            tilt: [zero; 2],
            reading: [zero; 2],
            record_scale: 1.0,
            cells: cells.to_vec(),
            pulls: Vec::new(),
            bends: Vec::new(),
        };
        if source != Source::Posture {
            let at = Circumstances::of(model);
            measured.tilt = [0, 1].map(|k| measured.circumstance(at.tilt(k)));
        }
        measured
    }

    pub(crate) fn model(&self) -> &'m Model {
        self.scratch.m
    }

    /// The graph that everything is written in.
    pub(crate) fn g(&mut self) -> &mut Graph {
        &mut self.scratch.g
    }

    /// Element `index` of the posture's [`Circumstances`].
    pub(crate) fn circumstance(&mut self, index: usize) -> Id {
        self.scratch.g.input(self.circumstances, index)
    }

    pub(crate) fn constant(&mut self, x: f64) -> Id {
        self.scratch.g.constant(x)
    }

    pub(crate) fn add(&mut self, a: Id, b: Id) -> Id {
        self.scratch.g.add(a, b)
    }

    pub(crate) fn sub(&mut self, a: Id, b: Id) -> Id {
        self.scratch.g.sub(a, b)
    }

    pub(crate) fn mul(&mut self, a: Id, b: Id) -> Id {
        self.scratch.g.mul(a, b)
    }

    pub(crate) fn div(&mut self, a: Id, b: Id) -> Id {
        self.scratch.g.div(a, b)
    }

    pub(crate) fn neg(&mut self, a: Id) -> Id {
        self.scratch.g.neg(a)
    }

    /// `joint += by`
    pub(crate) fn shift_joint(&mut self, joint: usize, by: Id) {
        self.joints[joint] = self.scratch.g.add(self.joints[joint], by);
    }

    /// A mass joins: `share` of the new whole, `moment` its first moment over
    /// the whole in the frame of `link`: `r' = (1 − share) r + W (share, moment)`.
    pub(crate) fn load(&mut self, link: usize, share: Id, moment: [Id; 3]) {
        let map = self.model().standard_map_of(link);
        let g = &mut self.scratch.g;
        let one = g.constant(1.0);
        let rest = g.sub(one, share);
        let with = [share, moment[0], moment[1], moment[2]];
        let masses = self.scratch.masses.as_mut().expect("set by `new`");
        for ((mass, limit), row) in masses.iter_mut().zip(map.row_iter()) {
            let weights: Vec<Id> = row.iter().map(|w| g.constant(*w)).collect();
            let added = g.dot(&weights, &with);
            let kept = g.mul(rest, *mass);
            *mass = g.add(kept, added);
            // A constant's size is known; of an argument the sum is at most this.
            *limit = match g.value(*mass) {
                Some(x) => libm::fabs(x),
                None => 2.0 * *limit + row.amax(),
            };
        }
    }

    /// A horizontal pull at the origin of `link`, over the weight on the ground.
    pub(crate) fn pull(&mut self, link: usize, force: [Id; 2]) {
        let map = self.model().standard_map_of(link);
        let point = map.column(0).iter().copied().collect();
        self.pulls.push(Pull { point, force });
    }

    /// The turning joints that a target means.
    pub(crate) fn turning(&self, target: &Target) -> Vec<usize> {
        let dofs = &self.model().tree.dofs;
        match *target {
            Target::Joint(joint) => vec![joint],
            Target::AllJoints => (0..dofs.len()).filter(|&j| !dofs[j].prismatic).collect(),
            _ => Vec::new(),
        }
    }

    /// The joint yields by `compliance` times its gravity moment over the weight.
    pub(crate) fn spring(&mut self, joint: usize, compliance: Id) {
        self.bends.push(Bend::Spring(joint, compliance));
    }

    /// The joint falls to an end of its dead band of half width `half`, rad.
    pub(crate) fn slack(&mut self, joint: usize, half: Id) {
        self.bends.push(Bend::Slack(joint, half));
    }

    /// Where the joints come to rest under their gravity moments.
    ///
    /// Springs by iteration. Loose joints slide all at once from the middle of
    /// their bands, an equal step each round along their moments, so that one
    /// that carries the robot sees where the others went before it is at its end.
    pub(crate) fn bend(&mut self) {
        if self.bends.is_empty() {
            return;
        }
        let straight = self.joints.clone();
        let zero = self.constant(0.0);
        let mut slid = vec![zero; self.bends.len()];
        for round in 0..ROUNDS {
            let moments = self.moments(&format!("{round}"));
            let mut bent = straight.clone();
            for (bend, slid) in self.bends.clone().into_iter().zip(&mut slid) {
                let (joint, by) = match bend {
                    Bend::Spring(joint, compliance) => {
                        (joint, self.mul(compliance, moments[joint]))
                    }
                    Bend::Slack(joint, half) => {
                        *slid = self.slide(*slid, joint, moments[joint]);
                        (joint, self.mul(half, *slid))
                    }
                };
                bent[joint] = self.add(bent[joint], by);
            }
            self.joints = bent;
            let springs = self.bends.iter().any(|b| matches!(b, Bend::Spring(..)));
            if self.source == Source::Log && !springs {
                break;
            }
        }
    }

    /// How far into its band a loose joint is, −1 to 1, after one more round.
    fn slide(&mut self, before: Id, joint: usize, moment: Id) -> Id {
        if self.source == Source::Log {
            let at = Circumstances::of(self.model()).side(joint);
            return self.circumstance(at);
        }
        let (sharp, step) = (self.constant(SHARP), self.constant(1.0 / ROUNDS as f64));
        let scaled = self.mul(sharp, moment);
        let sign = self.scratch.g.clamp(scaled);
        let moved = self.mul(step, sign);
        self.add(before, moved)
    }

    /// Gravity moments of all joints at [`Measured::joints`], over the weight, m:
    /// `τ_j = d·∂c/∂φ_j + Σ b·∂p/∂φ_j` with `d` gravity's direction.
    pub(crate) fn moments(&mut self, pass: &str) -> Vec<Id> {
        self.enter(pass);
        let subtrees = self.scratch.subtrees();
        let down = self.constant(-1.0);
        let gravity = [self.tilt[0], self.tilt[1], down];
        let steepness = self.tilt.map(|t| self.scratch.g.value(t));
        let norm = match steepness {
            [Some(x), Some(y)] => libm::sqrt(1.0 + x * x + y * y),
            _ => f64::INFINITY,
        };
        let orientations = self.scratch.directions(gravity, norm, "g");
        let mut moments = self.scratch.turned(&subtrees, &[orientations], false);
        let zero = self.constant(0.0);
        for k in 0..self.pulls.len() {
            let force = self.pulls[k].force;
            let subtrees = self.at_point(k, &format!("{pass}p{k}"));
            let direction = [force[0], force[1], zero];
            let rows = self.scratch.directions(direction, f64::INFINITY, "f");
            let more = self.scratch.turned(&subtrees, &[rows], false);
            for (moment, more) in moments.iter_mut().zip(more) {
                *moment = self.scratch.g.add(*moment, more);
            }
        }
        moments
    }

    /// How far a perfect sensor's reading moves with each joint, x row then y row.
    pub(crate) fn slopes(&mut self) -> Vec<Id> {
        self.enter("m");
        let subtrees = self.scratch.subtrees();
        let rows: Vec<_> = (0..3).map(|k| self.scratch.orientations(k)).collect();
        let jacobian = self.scratch.turned(&subtrees, &rows, false);
        let dof = self.model().dof();
        let mut slopes = Vec::with_capacity(2 * dof);
        for axis in 0..2 {
            for j in 0..dof {
                let g = &mut self.scratch.g;
                let leaning = g.mul(self.tilt[axis], jacobian[2 * dof + j]);
                slopes.push(g.add(jacobian[axis * dof + j], leaning));
            }
        }
        slopes
    }

    /// The CoP becomes the reading, the sensor still perfect.
    pub(crate) fn stand(&mut self) {
        self.enter("");
        let com = self.scratch.subtrees()[0].v.entries;
        for axis in 0..2 {
            let g = &mut self.scratch.g;
            let leaning = g.mul(self.tilt[axis], com[2]);
            self.reading[axis] = g.add(com[axis], leaning);
        }
        for k in 0..self.pulls.len() {
            let height = self.at_point(k, &format!("p{k}"))[0].v.entries[2];
            for axis in 0..2 {
                let g = &mut self.scratch.g;
                let moved = g.mul(self.pulls[k].force[axis], height);
                self.reading[axis] = g.add(self.reading[axis], moved);
            }
        }
    }

    /// From here on expressions are those of the joints as they are now.
    fn enter(&mut self, pass: &str) {
        self.scratch.positions = Some(self.joints.clone());
        self.scratch.turns.fill(None);
        self.scratch.pass = pass.to_string();
    }

    /// Subtree vectors of the point that pull `k` holds.
    fn at_point(&mut self, k: usize, pass: &str) -> Vec<super::subtrees::Subtree> {
        let point = self.pulls[k].point.clone();
        let of = |x: f64| (self.scratch.g.constant(x), libm::fabs(x));
        let point = point.into_iter().map(of).collect();
        let masses = self.scratch.masses.replace(point);
        let before = std::mem::replace(&mut self.scratch.pass, pass.to_string());
        let subtrees = self.scratch.subtrees();
        self.scratch.pass = before;
        self.scratch.masses = masses;
        subtrees
    }

    /// The record's unit, once everything else is written.
    pub(crate) fn record(&mut self) {
        let scale = self.constant(self.record_scale);
        self.reading = self.reading.map(|y| self.scratch.g.mul(scale, y));
    }

    /// The graph, once everything is written.
    pub(crate) fn into_graph(self) -> Graph {
        self.scratch.g
    }
}
