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
        let moment = self.g().input(Argument::Free, MOMENTS + joint);
        let by = self.mul(compliance, moment);
        self.give_way(joint, by);
    }

    /// The joint is moved by a function of [`Measured::moment`]s.
    pub fn give_way(&mut self, joint: usize, by: Id) {
        self.bends.push(Bend::Yield(joint, by));
    }

    /// Gravity's moment about a joint, N m: where joints give way it stands for that of each round.
    pub fn moment(&mut self, joint: usize) -> Id {
        let nominal = self.constant(self.robot().tree.mass * GRAVITY);
        let weight = self.mul(nominal, self.weight);
        let over_weight = self.g().input(Argument::Free, MOMENTS + joint);
        self.mul(weight, over_weight)
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
        let straight = self.joints.clone();
        let zero = self.constant(0.0);
        let mut slid = vec![zero; self.bends.len()];
        for round in 0..rounds {
            self.rounds.push(self.joints.clone());
            let moments = self.moments(&format!("{round}"));
            self.round_moments.push(moments.clone());
            let mut bent = straight.clone();
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
    fn with_moments(&mut self, of: &[Id], moments: &[Id]) -> Vec<Id> {
        let free: Vec<Id> = (0..moments.len())
            .map(|j| self.g().input(Argument::Free, MOMENTS + j))
            .collect();
        self.g().substitute(of, &free, moments)
    }

    /// How far into its band a loose joint is, −1 to 1, after one more round.
    fn slide(&mut self, before: Id, joint: usize, moment: Id, rounds: usize) -> Id {
        if self.source == ContextSource::Log {
            let at = PostureContext::of(self.robot()).side(joint);
            return self.posture_context(at);
        }
        let (sharp, step) = (self.constant(SHARP), self.constant(1.0 / rounds as f64));
        let scaled = self.mul(sharp, moment);
        let sign = self.scratch.g.clamp(scaled);
        let moved = self.mul(step, sign);
        self.add(before, moved)
    }

    /// Gravity's direction in the support frame.
    pub(super) fn gravity(&mut self) -> Direction {
        let down = self.constant(-1.0);
        let steepness = self.tilt.map(|t| self.g().value(t));
        let norm = match steepness {
            [Some(x), Some(y)] => libm::sqrt(1.0 + x * x + y * y),
            _ => f64::INFINITY,
        };
        Direction {
            entries: [self.tilt[0], self.tilt[1], down],
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
                for (slope, rate) in by_moments.chain(by_encoders) {
                    let by = self.mul(slope, rate);
                    rates[response.joint] = self.add(rates[response.joint], by);
                }
            }
        }
        rates
    }

    /// The same before anything gives way, by the columns of the encoders.
    pub(super) fn straight_rates(
        &mut self,
        columns: &[(usize, Vec<(usize, Id)>)],
        encoders: &[Id],
    ) -> Vec<Id> {
        let zero = self.constant(0.0);
        let mut straight = vec![zero; encoders.len()];
        for (j, column) in columns {
            for (joint, slope) in column {
                let term = self.mul(*slope, encoders[*j]);
                straight[*joint] = self.add(straight[*joint], term);
            }
        }
        straight
    }

    /// Accelerations of the joints where the robot bends, from its `rates`: how those change
    /// as the encoders move on. A dead band stays on its side.
    pub(super) fn accelerations(&mut self, rates: &[Id]) -> Vec<Id> {
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
                false => (g.mul(cos, rate), g.mul(sin, rate)),
            };
            let back = g.neg(back);
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
                    let by = self.mul(slope, own);
                    rates[m] = self.add(rates[m], by);
                }
                for (j, slope) in response.by_encoders {
                    let by = self.mul(slope, own);
                    slopes[j] = self.add(slopes[j], by);
                }
            }
            last = self.moment_rates(k, &rates, tag);
            for (sum, more) in total.iter_mut().zip(&last) {
                *sum = self.add(*sum, *more);
            }
        }
        for (j, column) in self.encoder_columns() {
            for (joint, slope) in column {
                let term = self.mul(slope, total[joint]);
                slopes[j] = self.add(slopes[j], term);
            }
        }
        slopes
    }

    /// Rounds that a change of the encoders passes through: none where nothing springs.
    fn spring_rounds(&self) -> usize {
        if self.yields() { self.rounds.len() } else { 0 }
    }

    /// `C` and `D` of round `k`, by the joints that yield.
    fn responses(&mut self, k: usize) -> Vec<Response> {
        let moments = self.round_moments[k].clone();
        let free = self.free_responses();
        let at_moments = |of: &mut Self, slopes: Vec<(usize, Id)>| -> Vec<(usize, Id)> {
            let (places, slopes): (Vec<usize>, Vec<Id>) = slopes.into_iter().unzip();
            let slopes = of.with_moments(&slopes, &moments);
            places.into_iter().zip(slopes).collect()
        };
        let responses = free.into_iter().map(|(_, response)| Response {
            by_moments: at_moments(self, response.by_moments),
            by_encoders: at_moments(self, response.by_encoders),
            ..response
        });
        responses.collect()
    }

    /// The same with moments free, each with what moves its joint.
    fn free_responses(&mut self) -> Vec<(Id, Response)> {
        let mut responses = Vec::new();
        for bend in self.bends.clone() {
            let Bend::Yield(joint, by) = bend else {
                continue;
            };
            let of_moments = self.inputs_of(by, &[Argument::Free]).into_iter();
            let of_moments: Vec<(Id, usize)> = of_moments
                .map(|(id, place)| (id, place - MOMENTS))
                .collect();
            let of_encoders = self.inputs_of(by, &ENCODERS);
            // A sign stays where it is.
            let mut slopes = |of: Vec<(Id, usize)>| -> Vec<(usize, Id)> {
                let one = self.constant(1.0);
                of.into_iter()
                    .map(|(input, place)| {
                        let rate = self.g().rates(&[by], &HashMap::from([(input, one)]));
                        (place, rate[0])
                    })
                    .collect()
            };
            let response = Response {
                joint,
                by_moments: slopes(of_moments),
                by_encoders: slopes(of_encoders),
            };
            responses.push((by, response));
        }
        responses
    }

    /// How far joints are moved by moments over the weight (m, as [`Argument::Free`]) at encoder
    /// positions, and how much of it each moment makes: the program's outputs are the motions of
    /// all joints, then slopes, one for each pair (joint, moment) that is given beside it.
    pub(crate) fn yielding(mut self) -> (Program, Vec<(usize, usize)>) {
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
        for p in 0..self.pulls.len() {
            let pull = self.direction_of(p);
            let more = self.at_point(p, &format!("{tag}{k}p{p}"), |scratch, subtrees| {
                scratch.slope_rates(&pull, &subtrees, rates)
            });
            for (moving, more) in moving.iter_mut().zip(more) {
                *moving = self.add(*moving, more);
            }
        }
        moving
    }

    /// `∂φ/∂q_j` of the joints that encoder `j` says something of, zeros left out.
    pub(super) fn encoder_columns(&mut self) -> Vec<(usize, Vec<(usize, Id)>)> {
        let straight = self.straight.clone();
        let mut columns: Vec<(usize, Vec<(usize, Id)>)> =
            (0..straight.len()).map(|j| (j, Vec::new())).collect();
        for (joint, phi) in straight.into_iter().enumerate() {
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
    fn inputs_of(&mut self, x: Id, arrays: &[Argument]) -> Vec<(Id, usize)> {
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
