//! Joints that give way to gravity, and how far they follow when the encoders move.
//!
//! ```text
//! φ⁰ = φ        φᵏ⁺¹ = φ + f(q, τ(φᵏ)) + slack        τ = ∂(d·c)/∂φ;  of a spring f = κ τ
//! ```
//!
//! with gravity's direction `d`. The slack of a dead band stays where it is while the sign
//! of its moment does, so with the symmetric Hessian `H = ∂τ/∂φ`, `C = ∂f/∂τ`, `D = ∂f/∂q` and
//! rates `φ̇` of the joints as their encoders have them (`q̇`)
//!
//! ```text
//! φ̇ᵏ⁺¹ = φ̇ + D q̇ + C H(φᵏ) φ̇ᵏ        λᵏ = H(φᵏ) Cᵀ λᵏ⁺¹,  λ̇ᵀφ̇ = Σ_k (λᵏ · φ̇ + Dᵀ λᵏ⁺¹ · q̇)
//! ```
//!
//! forward for a velocity, backward for a row λ of a Jacobian: one pass over the chain a
//! round, never a matrix of joints by joints.

use std::collections::{HashMap, HashSet};

use super::{ContextSource, Measured, PostureContext};
use crate::expr::{Argument, Expr, Id};
use crate::functions::{Direction, Wanted};
use crate::inertia::GRAVITY;
use crate::program::{Array, Program, Shape, operands};

/// Rounds of `φ' = φ + bend(τ(φ'))`: each adds a factor of (gravity stiffness /
/// joint stiffness), 0.2 and less in joints that can carry the robot; a model file with softer
/// springs takes more.
pub const ROUNDS: usize = 4;
/// Gravity moment (m) times this, clamped to ±1, is its sign. A power of two, so that
/// no scalar rounds it; no larger, so that 32 bits hold the moment of a robot of 10 m.
const SHARP: f64 = 134_217_728.0;

/// Of [`Argument::Free`], the place of the first joint's moment: those before are solved for.
const MOMENTS: usize = 2;

/// A joint that gives way to its gravity moment.
#[derive(Clone, Copy)]
pub(super) enum Bend {
    /// A joint moved by this function of moments, which are free in it.
    Yield(usize, Id),
    /// To one end of a dead band of half this width, rad.
    Slack(usize, Id),
}

/// What encoders read; of a prismatic joint the position stands among the sines.
const ENCODERS: [Argument; 2] = [Argument::Positions, Argument::Sines];

/// How a joint that yields follows moments and encoders: places and slopes.
struct Response {
    joint: usize,
    by_moments: Vec<(usize, Id)>,
    by_encoders: Vec<(usize, Id)>,
}

impl Measured<'_> {
    /// The joint yields by `compliance` times its gravity moment over the nominal weight.
    pub fn spring(&mut self, joint: usize, compliance: Id) {
        let compliance = self.mul(self.weight, compliance);
        self.give_way(joint, self.mul(compliance, self.free_moment(joint)));
    }

    fn free_moment(&self, joint: usize) -> Id {
        self.g().input(Argument::Free, MOMENTS + joint)
    }

    /// The joint is moved by a function of [`Measured::moment`]s.
    pub fn give_way(&mut self, joint: usize, by: Id) {
        self.bends.push(Bend::Yield(joint, by));
    }

    /// Gravity's moment about a joint, N m: where joints give way it stands for that of each round.
    pub fn moment(&self, joint: usize) -> Id {
        let nominal = self.constant(self.robot().tree.mass * GRAVITY);
        self.mul(self.mul(nominal, self.weight), self.free_moment(joint))
    }

    /// The joint falls to an end of its dead band of half width `half`, rad.
    pub fn slack(&mut self, joint: usize, half: Id) {
        self.bends.push(Bend::Slack(joint, half));
    }

    /// Where the joints come to rest under their gravity moments.
    ///
    /// Springs by iteration. Loose joints slide all at once from the middle of
    /// their bands, an equal step each round along their moments, so that one
    /// that carries the robot sees where the others went before it is at its end.
    pub(crate) fn bend(&mut self, rounds: usize) {
        self.straight = self.joints.clone();
        if self.bends.is_empty() {
            return;
        }
        let mut slid = vec![self.constant(0.0); self.bends.len()];
        for round in 0..rounds {
            self.rounds.push(self.joints.clone());
            let moments = self.moments(&format!("{round}"));
            self.round_moments.push(moments.clone());
            let mut bent = self.straight.clone();
            for (bend, slid) in self.bends.clone().into_iter().zip(&mut slid) {
                let (joint, by) = match bend {
                    Bend::Yield(joint, by) => (joint, self.with_moments(&[by], &moments)[0]),
                    Bend::Slack(joint, half) => {
                        *slid = self.slide(*slid, joint, moments[joint], rounds);
                        self.sides[joint] = Some(*slid);
                        (joint, self.mul(half, *slid))
                    }
                };
                bent[joint] = self.add(bent[joint], by);
            }
            self.joints = bent;
            if self.source == ContextSource::Log && !self.yields() {
                break;
            }
        }
    }

    /// Whether any joint yields to moments, beside slack.
    fn yields(&self) -> bool {
        let mut bends = self.bends.iter();
        bends.any(|bend| matches!(bend, Bend::Yield(..)))
    }

    /// Expressions in which moments are free, at these moments.
    fn with_moments(&self, of: &[Id], moments: &[Id]) -> Vec<Id> {
        let joints = 0..moments.len();
        let free: Vec<Id> = joints.map(|joint| self.free_moment(joint)).collect();
        self.g().substitute(of, &free, moments)
    }

    /// How far into its band a loose joint is, −1 to 1, after one more round.
    fn slide(&self, before: Id, joint: usize, moment: Id, rounds: usize) -> Id {
        if self.source == ContextSource::Log {
            let at = PostureContext::of(self.robot()).side(joint);
            return self.posture_context(at);
        }
        let (sharp, step) = (self.constant(SHARP), self.constant(1.0 / rounds as f64));
        let sign = self.g().clamp(self.mul(sharp, moment));
        self.add(before, self.mul(step, sign))
    }

    /// Gravity's direction in the support frame.
    pub(super) fn gravity(&self) -> Direction {
        let steepness = self.tilt.map(|t| self.g().value(t));
        let norm = match steepness {
            [Some(x), Some(y)] => libm::sqrt(1.0 + x * x + y * y),
            _ => f64::INFINITY,
        };
        Direction {
            entries: [self.tilt[0], self.tilt[1], self.constant(-1.0)],
            norm,
            tag: "g",
        }
    }

    /// Rates of the joints where the robot bends, from those that encoders show.
    pub(super) fn rates(&mut self, encoders: &[Id]) -> Vec<Id> {
        let columns = self.encoder_columns();
        let straight = self.straight_rates(&columns, encoders);
        let mut rates = straight.clone();
        for k in 0..self.spring_rounds() {
            let moving = self.moment_rates(k, &rates, "t");
            rates = straight.clone();
            for response in self.responses(k) {
                let by_moments = response.by_moments.iter().map(|(m, c)| (*c, moving[*m]));
                let by_encoders = response.by_encoders.iter().map(|(j, d)| (*d, encoders[*j]));
                rates[response.joint] = by_moments
                    .chain(by_encoders)
                    .fold(rates[response.joint], |sum, (slope, rate)| {
                        self.add(sum, self.mul(slope, rate))
                    });
            }
        }
        rates
    }

    /// The same before anything gives way, by the columns of the encoders.
    pub(super) fn straight_rates(
        &self,
        columns: &[(usize, Vec<(usize, Id)>)],
        encoders: &[Id],
    ) -> Vec<Id> {
        let zero = self.constant(0.0);
        let mut straight = vec![zero; encoders.len()];
        for (j, column) in columns {
            for (joint, slope) in column {
                straight[*joint] = self.add(straight[*joint], self.mul(*slope, encoders[*j]));
            }
        }
        straight
    }

    /// Accelerations of the joints where the robot bends, from its `rates`: how those change
    /// as the encoders move on. A dead band stays on its side.
    pub(super) fn accelerations(&self, rates: &[Id]) -> Vec<Id> {
        let dofs = &self.robot().tree.dofs;
        let mut inputs = HashMap::new();
        for (j, dof) in dofs.iter().enumerate() {
            let g = self.g();
            let [q, sin, cos] = [Argument::Positions, Argument::Sines, Argument::Cosines]
                .map(|argument| g.input(argument, j));
            let rate = g.input(Argument::Velocities, j);
            let acceleration = g.input(Argument::Accelerations, j);
            let (ahead, back) = match dof.prismatic {
                true => (rate, g.constant(0.0)),
                false => (g.mul(cos, rate), g.neg(g.mul(sin, rate))),
            };
            inputs.extend([(q, rate), (sin, ahead), (cos, back), (rate, acceleration)]);
        }
        self.g().rates(rates, &inputs)
    }

    /// A row of slopes `∂/∂φ'` of the bent joints as one of slopes `∂/∂q` of the encoders.
    pub(super) fn by_encoders(&mut self, row: &[Id], tag: &str) -> Vec<Id> {
        let zero = self.constant(0.0);
        let mut total = row.to_vec();
        let mut last = row.to_vec();
        let mut slopes = vec![zero; row.len()];
        for k in (0..self.spring_rounds()).rev() {
            let mut rates = vec![zero; row.len()];
            for response in self.responses(k) {
                let own = last[response.joint];
                for (m, slope) in response.by_moments {
                    rates[m] = self.add(rates[m], self.mul(slope, own));
                }
                for (j, slope) in response.by_encoders {
                    slopes[j] = self.add(slopes[j], self.mul(slope, own));
                }
            }
            last = self.moment_rates(k, &rates, tag);
            for (sum, more) in total.iter_mut().zip(&last) {
                *sum = self.add(*sum, *more);
            }
        }
        for (j, column) in self.encoder_columns() {
            for (joint, slope) in column {
                slopes[j] = self.add(slopes[j], self.mul(slope, total[joint]));
            }
        }
        slopes
    }

    /// Rounds that a change of the encoders passes through: none where nothing springs.
    fn spring_rounds(&self) -> usize {
        if self.yields() { self.rounds.len() } else { 0 }
    }

    /// `C` and `D` of round `k`, by the joints that yield.
    fn responses(&self, k: usize) -> Vec<Response> {
        let at_moments = |slopes: Vec<(usize, Id)>| -> Vec<(usize, Id)> {
            let (places, slopes): (Vec<usize>, Vec<Id>) = slopes.into_iter().unzip();
            let slopes = self.with_moments(&slopes, &self.round_moments[k]);
            places.into_iter().zip(slopes).collect()
        };
        let free = self.free_responses().into_iter();
        let responses = free.map(|(_, response)| Response {
            by_moments: at_moments(response.by_moments),
            by_encoders: at_moments(response.by_encoders),
            ..response
        });
        responses.collect()
    }

    /// The same with moments free, each with what moves its joint.
    fn free_responses(&self) -> Vec<(Id, Response)> {
        // A sign stays where it is.
        let slopes = |by: Id, arrays: &[Argument]| {
            let inputs = self.inputs_of(by, arrays).into_iter();
            let slope = |(input, place)| {
                let rates = HashMap::from([(input, self.constant(1.0))]);
                (place, self.g().rates(&[by], &rates)[0])
            };
            inputs.map(slope).collect::<Vec<(usize, Id)>>()
        };
        let yields = self.bends.iter().filter_map(|bend| match *bend {
            Bend::Yield(joint, by) => Some((joint, by)),
            Bend::Slack(..) => None,
        });
        let responses = yields.map(|(joint, by)| {
            let mut by_moments = slopes(by, &[Argument::Free]);
            by_moments
                .iter_mut()
                .for_each(|(place, _)| *place -= MOMENTS);
            let response = Response {
                joint,
                by_moments,
                by_encoders: slopes(by, &ENCODERS),
            };
            (by, response)
        });
        responses.collect()
    }

    /// How far joints are moved by moments over the weight (m, as [`Argument::Free`]) at encoder
    /// positions, and how much of it each moment makes: the program's outputs are the motions of
    /// all joints, then slopes, one for each pair (joint, moment) that is given beside it.
    pub(crate) fn yielding(self) -> (Program, Vec<(usize, usize)>) {
        let dof = self.robot().dof();
        let zero = self.constant(0.0);
        let mut outputs = vec![zero; dof];
        let (mut pairs, mut all) = (Vec::new(), Vec::new());
        for (by, response) in self.free_responses() {
            outputs[response.joint] = self.add(outputs[response.joint], by);
            for (moment, slope) in response.by_moments {
                pairs.push((response.joint, moment));
                all.push(slope);
            }
        }
        outputs.extend(all);
        let inputs = vec![
            Array::new(Argument::Positions, dof),
            Array::new(Argument::Free, MOMENTS + dof),
        ];
        let shape = Shape::Vector(outputs.len());
        let program = Program::new(self.into_graph(), inputs, shape, &outputs);
        (program, pairs)
    }

    /// `H(φᵏ) ω`: how gravity's moments of round `k` change as joints move at `rates`.
    fn moment_rates(&mut self, k: usize, rates: &[Id], tag: &str) -> Vec<Id> {
        let joints = self.rounds[k].clone();
        self.at(joints, &format!("{k}"));
        let subtrees = self.scratch.subtrees(Wanted::Rotated);
        let gravity = self.gravity();
        self.scratch.pass = format!("{tag}{k}");
        let mut moving = self.scratch.slope_rates(&gravity, &subtrees, rates);
        self.add_pulls(
            &mut moving,
            &format!("{tag}{k}"),
            |scratch, subtrees, pull| scratch.slope_rates(&pull, &subtrees, rates),
        );
        moving
    }

    /// `∂φ/∂q_j` of the joints that encoder `j` says something of, zeros left out.
    pub(super) fn encoder_columns(&self) -> Vec<(usize, Vec<(usize, Id)>)> {
        let mut columns: Vec<(usize, Vec<(usize, Id)>)> =
            (0..self.straight.len()).map(|j| (j, Vec::new())).collect();
        for (joint, &phi) in self.straight.iter().enumerate() {
            for (input, j) in self.inputs_of(phi, &ENCODERS) {
                let slope = match input == phi {
                    true => self.constant(1.0),
                    false => self.g().derivative(&[phi], input)[0],
                };
                columns[j].1.push((joint, slope));
            }
        }
        columns
    }

    /// The inputs of these arrays that an expression reads: nodes and places.
    fn inputs_of(&self, x: Id, arrays: &[Argument]) -> Vec<(Id, usize)> {
        let (mut found, mut seen, mut stack) = (Vec::new(), HashSet::new(), vec![x]);
        while let Some(id) = stack.pop() {
            if !seen.insert(id) {
                continue;
            }
            let expr = self.g().expr(id);
            if let Expr::Input { argument, index } = expr
                && arrays.contains(&argument)
            {
                found.push((id, index as usize));
            }
            stack.extend(operands(expr));
        }
        found
    }
}
