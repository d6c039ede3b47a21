//! The measurement equation, open to effects.
//!
//! ```text
//! q ─ wiring, joints ─▶ φ ─ bends under gravity ─▶ φ'      r ─ loads ─▶ r'
//! c = r'_0 + Σ B_i(φ') r'_i                                CoM, loads included
//! p = c_xy + c_z·tilt + Σ b_k z_k(φ') + Δ + ∂Δ/∂φ (φ' − q)  CoP; pulls b at points z; loads
//!                                                          that move: see `motion`
//! y = sensor(p)                                            the reading
//! ```
//!
//! Stages are walked in this order; an effect rewrites what its stage holds.
//! Gravity, for bends as for the CoP, points along `(tilt_x, tilt_y, −1)`; what
//! presses on the ground is taken along the sole's normal as on level ground,
//! which leaves out a part tilt²/2 of what forces and springs in N add. Δ is what motion adds,
//! which the context of a posture says for the positions q that the wiring makes of encoders.

mod bends;
mod body;
mod context;
pub(crate) mod foot;
mod inverse;
mod motion;

use nalgebra::Vector3;

use crate::expr::{Argument, Graph, Id};
use crate::formula::Variable;
use crate::functions::{Direction, Parameters, Scratch, Subtree, Wanted};
use crate::inertia::PointMass;
use crate::interface::Given;
use crate::robot::Robot;
use bends::Bend;
pub use bends::ROUNDS;
pub use context::{ContextSource, PostureContext};
pub(crate) use foot::Foot;

/// A pull on a point of the robot.
struct Pull {
    /// The point, as base parameters: its position is what their CoM would be.
    point: Vec<f64>,
    /// Horizontal force over the weight on the ground.
    force: [Id; 2],
    /// Vertical force over it, down, where it is counted as a load: unlike one it
    /// keeps its direction on a slope.
    load: Id,
}

/// A load that has joined the robot, as shares of all that presses on the ground.
#[derive(Clone, Copy)]
struct CarriedLoad {
    link: usize,
    share: Id,
    /// First moment in the frame of the link, m.
    moment: [Id; 3],
    /// Whether it is accelerated with the link: a force is not.
    inert: bool,
}

/// The measurement of one posture while effects rewrite it.
pub struct Measured<'m> {
    scratch: Scratch<'m>,
    pub(crate) source: ContextSource,
    /// What each encoder says of its joint, rad or m.
    pub wired: Vec<Id>,
    /// Joint positions as the robot has them, rad or m.
    pub joints: Vec<Id>,
    /// Gravity's slope against the sole's normal.
    pub tilt: [Id; 2],
    /// How the ground gives way under the CoP: axis and slope, of a CoP that is free there.
    soft: Vec<(usize, Id)>,
    /// The CoP before it does.
    firm: [Id; 2],
    /// CoP reading, m; none before the sensor stage.
    pub reading: [Id; 2],
    /// Units of the record per metre.
    pub record_scale: f64,
    /// Foot cells, m, where the log says where they are.
    pub cells: Vec<[f64; 2]>,
    pub(crate) foot: Option<Foot>,
    /// Weight on the ground over the nominal weight.
    pub weight: Id,
    /// How much later the robot moves than encoders say, s.
    late: Vec<Id>,
    pulls: Vec<Pull>,
    carried: Vec<CarriedLoad>,
    bends: Vec<Bend>,
    /// How far into its dead band each joint is where it rests, −1 to 1; none where it has none.
    pub(crate) sides: Vec<Option<Id>>,
    /// Loads that are point masses of known size.
    loads: Vec<PointMass>,
    /// Joint positions before any joint gives way.
    straight: Vec<Id>,
    /// Joint positions of each round of bending,
    rounds: Vec<Vec<Id>>,
    /// and gravity's moments there.
    round_moments: Vec<Vec<Id>>,
    /// What generated code takes beside q and r, in its order.
    pub(crate) beyond: Vec<Variable>,
}

impl<'m> Measured<'m> {
    /// The nominal measurement: joints where the encoders say, CAD's loads.
    pub(crate) fn new(
        robot: &'m Robot,
        source: ContextSource,
        given: Given,
        parameters: Parameters,
        cells: &[[f64; 2]],
    ) -> Self {
        let mut scratch = Scratch::new(robot, given, parameters);
        let joints = scratch.positions.clone();
        let params = 0..robot.base.params.len();
        let masses = params.map(|k| scratch.parameter(Some(k))).collect();
        scratch.masses = Some(masses);
        let (one, zero) = (scratch.g.constant(1.0), scratch.g.constant(0.0));
        let mut measured = Measured {
            scratch,
            source,
            wired: joints.clone(),
            straight: joints.clone(),
            joints,
            tilt: [zero; 2],
            soft: Vec::new(),
            firm: [zero; 2],
            reading: [zero; 2],
            record_scale: 1.0,
            cells: cells.to_vec(),
            foot: None,
            weight: one,
            late: Vec::new(),
            pulls: Vec::new(),
            carried: Vec::new(),
            loads: Vec::new(),
            bends: Vec::new(),
            sides: vec![None; robot.dof()],
            rounds: Vec::new(),
            round_moments: Vec::new(),
            beyond: Vec::new(),
        };
        if source != ContextSource::Posture {
            let at = PostureContext::of(robot);
            measured.tilt = [0, 1].map(|k| measured.posture_context(at.tilt(k)));
        }
        measured
    }

    /// The robot that is measured.
    pub fn robot(&self) -> &'m Robot {
        self.scratch.m
    }

    /// The graph that everything is written in.
    pub fn g(&self) -> &Graph {
        &self.scratch.g
    }

    /// Element `index` of the posture's [`PostureContext`].
    pub fn posture_context(&self, index: usize) -> Id {
        self.scratch.g.input(Argument::Context, index)
    }

    /// What a formula finds beside positions and readings: an input of code that takes it, in a
    /// log what that has of it, else `usual`.
    pub(crate) fn beyond(&self, variable: &Variable, usual: f64) -> Id {
        if let Some(place) = self.beyond.iter().position(|known| known == variable) {
            return self.posture_context(place);
        }
        let layout = PostureContext::of(self.robot());
        let joint = |name: &str| {
            let mut dofs = self.robot().tree.dofs.iter();
            dofs.position(|dof| dof.joint == name)
        };
        let place = match variable {
            Variable::Time => Some(layout.time()),
            Variable::Approach(Some(name)) => joint(name).map(|joint| layout.approach(joint)),
            _ => None,
        };
        match place.filter(|_| self.source != ContextSource::Posture) {
            Some(place) => self.posture_context(place),
            None => self.constant(usual),
        }
    }

    /// The node of a constant.
    pub fn constant(&self, x: f64) -> Id {
        self.scratch.g.constant(x)
    }

    /// `a + b`
    pub fn add(&self, a: Id, b: Id) -> Id {
        self.scratch.g.add(a, b)
    }

    /// `a − b`
    pub fn sub(&self, a: Id, b: Id) -> Id {
        self.scratch.g.sub(a, b)
    }

    /// `a b`
    pub fn mul(&self, a: Id, b: Id) -> Id {
        self.scratch.g.mul(a, b)
    }

    /// `a / b`
    pub fn div(&self, a: Id, b: Id) -> Id {
        self.scratch.g.div(a, b)
    }

    /// `−a`
    pub fn neg(&self, a: Id) -> Id {
        self.scratch.g.neg(a)
    }

    /// `joint += by`
    pub fn shift_joint(&mut self, joint: usize, by: Id) {
        self.joints[joint] = self.add(self.joints[joint], by);
    }

    /// Velocities and accelerations are those of `by` seconds later; positions are shifted by
    /// [`Measured::shift_joint`].
    pub fn shift_motion(&mut self, by: Id) {
        self.late.push(by);
    }

    /// A mass joins the nominal robot: `share` of both together, `moment` its
    /// first moment over both in the frame of `link`: `r' = (1 − share) r + W
    /// (share, moment)`. Gives back what makes shares of both shares of all that
    /// presses on the ground, loads before this one included.
    ///
    /// ```text
    /// G' = G + μ/(1 − μ)        share' = μ c,  moment' = moment c        c = 1/(G (1 − μ) + μ)
    /// ```
    ///
    /// with `G` the weight on the ground over the nominal one; `c = 1` where `G` was.
    pub fn load(&mut self, link: usize, share: Id, moment: [Id; 3]) -> Id {
        let map = self.robot().standard_map_of(link);
        let g = &self.scratch.g;
        let sizes = [share, moment[0], moment[1], moment[2]].map(|x| g.value(x));
        if let [Some(share), Some(x), Some(y), Some(z)] = sizes
            && share != 0.0
        {
            self.loads.push(PointMass {
                link,
                mass: share / (1.0 - share),
                at: Vector3::new(x, y, z) / share,
            });
        }
        let one = g.constant(1.0);
        let bare = g.sub(one, share);
        let factor = match g.value(self.weight) {
            Some(1.0) => {
                self.weight = g.div(one, bare);
                one
            }
            _ => {
                let all = g.add(g.mul(self.weight, bare), share);
                self.weight = g.div(all, bare);
                g.div(one, all)
            }
        };
        let with = [share, moment[0], moment[1], moment[2]].map(|x| g.mul(factor, x));
        let rest = g.sub(one, with[0]);
        let masses = self.scratch.masses.as_mut().expect("set by `new`");
        for ((mass, limit), row) in masses.iter_mut().zip(map.row_iter()) {
            let weights: Vec<Id> = row.iter().map(|w| g.constant(*w)).collect();
            let added = g.dot(&weights, &with);
            *mass = g.add(g.mul(rest, *mass), added);
            // A constant's size is known; of an argument the sum is at most this.
            *limit = match g.value(*mass) {
                Some(x) => libm::fabs(x),
                None => 2.0 * *limit + row.amax(),
            };
        }
        for pull in &mut self.pulls {
            pull.force = pull.force.map(|force| g.mul(rest, force));
            pull.load = g.mul(rest, pull.load);
        }
        for load in &mut self.carried {
            load.share = g.mul(rest, load.share);
            load.moment = load.moment.map(|x| g.mul(rest, x));
        }
        let [share, x, y, z] = with;
        self.carried.push(CarriedLoad {
            link,
            share,
            moment: [x, y, z],
            inert: true,
        });
        factor
    }

    /// A pull at the origin of `link`: horizontally `force` over the nominal
    /// weight less the pull, down `share` of that.
    pub fn pull(&mut self, link: usize, force: [Id; 2], share: Id) {
        let (zero, before) = (self.constant(0.0), self.carried.len());
        let factor = self.load(link, share, [zero; 3]);
        for load in &mut self.carried[before..] {
            load.inert = false;
        }
        let map = self.robot().standard_map_of(link);
        let point = map.column(0).iter().copied().collect();
        let force = force.map(|force| self.mul(factor, force));
        let load = self.mul(factor, share);
        self.pulls.push(Pull { point, force, load });
    }

    /// What pull `k` is horizontally, less what counting it as a load puts there
    /// on a slope.
    fn sideways(&self, k: usize) -> [Id; 2] {
        let Pull { force, load, .. } = self.pulls[k];
        [0, 1].map(|axis| self.sub(force[axis], self.mul(self.tilt[axis], load)))
    }

    /// Gravity moments of all joints at [`Measured::joints`], over the weight, m:
    /// `τ_j = d·∂c/∂φ_j + Σ b·∂p/∂φ_j` with `d` gravity's direction.
    pub(crate) fn moments(&mut self, pass: &str) -> Vec<Id> {
        self.at(self.joints.clone(), pass);
        let subtrees = self.scratch.subtrees(Wanted::Rotated);
        let gravity = self.gravity();
        let mut moments = self.scratch.slopes_along(&[gravity], &subtrees, false);
        self.add_pulls(&mut moments, pass, |scratch, subtrees, pull| {
            scratch.slopes_along(&[pull], &subtrees, false)
        });
        moments
    }

    /// Adds what `of` makes of each pull to the moments of all joints.
    fn add_pulls(
        &mut self,
        moments: &mut [Id],
        pass: &str,
        of: impl Fn(&mut Scratch, Vec<Subtree>, Direction) -> Vec<Id>,
    ) {
        for k in 0..self.pulls.len() {
            let pull = self.direction_of(k);
            let more = self.at_point(k, &format!("{pass}p{k}"), |scratch, subtrees| {
                of(scratch, subtrees, pull)
            });
            for (moment, more) in moments.iter_mut().zip(more) {
                *moment = self.add(*moment, more);
            }
        }
    }

    /// Where pull `k` pulls beside the load that it is counted as.
    fn direction_of(&self, k: usize) -> Direction {
        let [x, y] = self.sideways(k);
        Direction {
            entries: [x, y, self.constant(0.0)],
            norm: f64::INFINITY,
            tag: "f",
        }
    }

    /// How far the CoP moves with what each encoder reads, pulls and springs included: x row
    /// then y row.
    pub(crate) fn cop_slopes(&mut self) -> Vec<Id> {
        // The CoP has vectors of its own.
        let mut slopes = self.slopes("m");
        let dof = self.robot().dof();
        for k in 0..self.pulls.len() {
            let force = self.sideways(k);
            let rising = self.at_point(k, &format!("p{k}"), |scratch, subtrees| {
                let up = scratch.axes_of_support(&[2]);
                scratch.slopes_along(&up, &subtrees, false)
            });
            for (place, slope) in slopes.iter_mut().enumerate() {
                *slope = self.add(*slope, self.mul(force[place / dof], rising[place % dof]));
            }
        }
        self.lean_slopes(&mut slopes);
        let rows = slopes.chunks(dof.max(1)).zip(["x", "y"]);
        rows.flat_map(|(row, tag)| self.by_encoders(row, tag))
            .collect()
    }

    /// The ground falls by a slope along an axis that depends on the CoP, whose coordinates
    /// [`Measured::free_cop`] has.
    pub fn soften(&mut self, axis: usize, slope: Id) {
        self.soft.push((axis, slope));
    }

    /// The CoP that a soft ground's slope is a function of.
    pub fn free_cop(&self) -> [Id; 2] {
        [0, 1].map(|axis| self.g().input(Argument::Free, axis))
    }

    /// Functions of the CoP at the one that presses on the ground.
    fn under(&self, of: &[Id]) -> Vec<Id> {
        let (free, firm) = (self.free_cop(), self.firm);
        self.g().substitute(of, &free, &firm)
    }

    /// What soft ground adds to slopes of the CoP by joints: `z f(p)` with `∂z`, `∂p`.
    fn lean_slopes(&mut self, slopes: &mut [Id]) {
        if self.soft.is_empty() {
            return;
        }
        let dof = self.robot().dof();
        self.at(self.joints.clone(), "");
        let subtrees = self.scratch.subtrees(Wanted::Rotated);
        let up = self.scratch.axes_of_support(&[2]);
        let rising = self.scratch.slopes_along(&up, &subtrees, false);
        let height = subtrees[0].v.entries[2];
        let firm = slopes.to_vec();
        let free = self.free_cop();
        for (axis, slope) in self.soft.clone() {
            let by_cop = free.map(|x| self.g().derivative(&[slope], x)[0]);
            let at = self.under(&[slope, by_cop[0], by_cop[1]]);
            for j in 0..dof {
                let [x, y] = [0, 1].map(|k| self.mul(at[1 + k], firm[k * dof + j]));
                let turning = self.mul(height, self.add(x, y));
                let more = self.add(self.mul(at[0], rising[j]), turning);
                slopes[axis * dof + j] = self.add(slopes[axis * dof + j], more);
            }
        }
    }

    /// How far a perfect sensor's reading moves with each joint, x row then y row.
    pub(crate) fn slopes(&mut self, pass: &str) -> Vec<Id> {
        self.at(self.joints.clone(), pass);
        let subtrees = self.scratch.subtrees(Wanted::Rotated);
        let rows = self.scratch.axes_of_support(&[0, 1, 2]);
        let jacobian = self.scratch.slopes_along(&rows, &subtrees, false);
        let dof = self.robot().dof();
        let mut slopes = Vec::with_capacity(2 * dof);
        for axis in 0..2 {
            for j in 0..dof {
                let leaning = self.mul(self.tilt[axis], jacobian[2 * dof + j]);
                slopes.push(self.add(jacobian[axis * dof + j], leaning));
            }
        }
        slopes
    }

    /// The CoP becomes the reading, the sensor still perfect; with loads that are accelerated
    /// where the robot is `moving`.
    pub(crate) fn stand(&mut self, moving: bool) {
        self.at(self.joints.clone(), "");
        let com = self.scratch.subtrees(Wanted::Sums)[0].v.entries;
        self.reading = [0, 1].map(|k| self.add(com[k], self.mul(self.tilt[k], com[2])));
        let mut pulled = [self.constant(0.0); 2];
        for k in 0..self.pulls.len() {
            let height = self.at_point(k, &format!("p{k}"), |_, subtrees| subtrees[0].v.entries[2]);
            let force = self.sideways(k);
            pulled = [0, 1].map(|axis| self.add(pulled[axis], self.mul(force[axis], height)));
        }
        self.reading = [0, 1].map(|axis| self.add(self.reading[axis], pulled[axis]));
        self.firm = self.reading;
        for (axis, slope) in self.soft.clone() {
            let lean = self.under(&[slope])[0];
            self.reading[axis] = self.add(self.reading[axis], self.mul(lean, com[2]));
        }
        if self.source != ContextSource::Posture {
            self.set_in_motion(pulled, moving);
        }
    }

    /// From here on expressions are those of the robot at these joint positions.
    fn at(&mut self, joints: Vec<Id>, pass: &str) {
        self.scratch.positions = joints;
        self.scratch.rotations.fill(None);
        self.scratch.pass = pass.to_string();
    }

    /// What comes of the subtree vectors of the point that pull `k` holds.
    fn at_point<T>(
        &mut self,
        k: usize,
        pass: &str,
        of: impl FnOnce(&mut Scratch, Vec<Subtree>) -> T,
    ) -> T {
        let point = self.pulls[k].point.clone();
        self.of_point(point, pass, of)
    }

    /// What comes of the subtree vectors of a point, or of a direction, that base parameters
    /// stand for.
    fn of_point<T>(
        &mut self,
        point: Vec<f64>,
        pass: &str,
        made: impl FnOnce(&mut Scratch, Vec<Subtree>) -> T,
    ) -> T {
        let of = |x: f64| (self.scratch.g.constant(x), libm::fabs(x));
        let point = point.into_iter().map(of).collect();
        let masses = self.scratch.masses.replace(point);
        let before = std::mem::replace(&mut self.scratch.pass, pass.to_string());
        let subtrees = self.scratch.subtrees(Wanted::Rotated);
        let made = made(&mut self.scratch, subtrees);
        self.scratch.pass = before;
        self.scratch.masses = masses;
        made
    }

    /// How `link` lies on the sole plane at [`Measured::joints`]: the height of the point that is
    /// `below_m` under its origin along its −z, m, and the sines of its roll and pitch,
    /// `(p_z − below R_zz, R_zy, −R_zx)` of its frame.
    pub(crate) fn lies(&mut self, link: usize, below_m: f64) -> [Id; 3] {
        self.at(self.joints.clone(), "");
        // The columns of a link stand for its origin and for the axes of its frame.
        let map = self.robot().standard_map_of(link);
        let mut height = |column: usize| {
            let own = map.column(column).into_owned();
            let point = match column {
                0 => own - below_m * map.column(3),
                _ => own,
            };
            let point = point.iter().copied().collect();
            let height = |_: &mut Scratch, subtrees: Vec<Subtree>| subtrees[0].v.entries[2];
            self.of_point(point, &format!("o{column}"), height)
        };
        let [origin, x, y] = [0, 1, 2].map(&mut height);
        [origin, y, self.neg(x)]
    }

    /// The record's unit, once everything else is written.
    pub(crate) fn record(&mut self) {
        self.scale_reading(self.record_scale);
    }

    /// Metres again, before anything else is undone.
    pub(crate) fn unrecord(&mut self) {
        self.scale_reading(1.0 / self.record_scale);
    }

    fn scale_reading(&mut self, scale: f64) {
        let scale = self.constant(scale);
        self.reading = self.reading.map(|y| self.mul(scale, y));
    }

    /// The graph, once everything is written.
    pub(crate) fn into_graph(self) -> Graph {
        self.scratch.g
    }
}
