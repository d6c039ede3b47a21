//! Joints that give way to gravity, and how far they follow when the encoders move.
//!
//! ```text
//! φ⁰ = φ        φᵏ⁺¹ = φ + C τ(φᵏ) + slack        C = diag(compliance), τ = ∂(d·c)/∂φ
//! ```
//!
//! with gravity's direction `d`. The slack of a dead band stays where it is while the sign
//! of its moment does, so with the symmetric Hessian `H = ∂τ/∂φ` and rates `φ̇` of the
//! joints as their encoders have them
//!
//! ```text
//! φ̇ᵏ⁺¹ = φ̇ + C H(φᵏ) φ̇ᵏ        λᵏ = H(φᵏ) C λᵏ⁺¹,  λ̇ᵀφ̇ = Σ_k λᵏ · φ̇
//! ```
//!
//! forward for a velocity, backward for a row λ of a Jacobian: one pass over the chain a
//! round, never a matrix of joints by joints.

use std::collections::{HashMap, HashSet};

use super::{ContextSource, Measured, PostureContext};
use crate::expr::{Argument, Expr, Id};
use crate::functions::{Direction, Wanted};
use crate::program::operands;

/// Rounds of `φ' = φ + bend(τ(φ'))`: each adds a factor of (gravity stiffness /
/// joint stiffness), 0.2 and less in joints that can carry the robot; a model file with softer
/// springs takes more.
pub const ROUNDS: usize = 4;
/// Gravity moment (m) times this, clamped to ±1, is its sign. A power of two, so that
/// no scalar rounds it; no larger, so that 32 bits hold the moment of a robot of 10 m.
const SHARP: f64 = 134_217_728.0;

/// A joint that gives way to its gravity moment.
#[derive(Clone, Copy)]
pub(super) enum Bend {
    /// A joint turned by its moment times this compliance: rad per m of moment over the
    /// nominal weight.
    Spring(usize, Id),
    /// To one end of a dead band of half this width, rad.
    Slack(usize, Id),
}

impl Measured<'_> {
    /// The joint yields by `compliance` times its gravity moment over the weight.
    pub fn spring(&mut self, joint: usize, compliance: Id) {
        self.bends.push(Bend::Spring(joint, compliance));
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
            let mut bent = straight.clone();
            for (bend, slid) in self.bends.clone().into_iter().zip(&mut slid) {
                let (joint, by) = match bend {
                    Bend::Spring(joint, compliance) => {
                        let compliance = self.mul(self.weight, compliance);
                        (joint, self.mul(compliance, moments[joint]))
                    }
                    Bend::Slack(joint, half) => {
                        *slid = self.slide(*slid, joint, moments[joint], rounds);
                        self.sides[joint] = Some(*slid);
                        (joint, self.mul(half, *slid))
                    }
                };
                bent[joint] = self.add(bent[joint], by);
            }
            self.joints = bent;
            let springs = self.bends.iter().any(|b| matches!(b, Bend::Spring(..)));
            if self.source == ContextSource::Log && !springs {
                break;
            }
        }
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
            let yielding = self.yielding(&moving);
            rates = straight.clone();
            for (joint, by) in yielding {
                rates[joint] = self.add(rates[joint], by);
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
        for k in (0..self.spring_rounds()).rev() {
            let mut rates = vec![zero; row.len()];
            for (joint, by) in self.yielding(&last) {
                rates[joint] = self.add(rates[joint], by);
            }
            last = self.moment_rates(k, &rates, tag);
            for (sum, more) in total.iter_mut().zip(&last) {
                *sum = self.add(*sum, *more);
            }
        }
        let mut slopes = vec![zero; row.len()];
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
        let springs = self.bends.iter().any(|b| matches!(b, Bend::Spring(..)));
        if springs { self.rounds.len() } else { 0 }
    }

    /// `C x`: by how much each compliant joint yields to moments `x`.
    fn yielding(&mut self, moments: &[Id]) -> Vec<(usize, Id)> {
        let mut yielding = Vec::new();
        for bend in self.bends.clone() {
            if let Bend::Spring(joint, compliance) = bend {
                let compliance = self.mul(self.weight, compliance);
                yielding.push((joint, self.mul(compliance, moments[joint])));
            }
        }
        yielding
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
            for (input, j) in self.encoders_in(phi) {
                let slope = match input == phi {
                    true => self.constant(1.0),
                    false => self.g().derivative(&[phi], input)[0],
                };
                columns[j].1.push((joint, slope));
            }
        }
        columns
    }

    /// The encoders that an expression reads, with their nodes.
    fn encoders_in(&mut self, x: Id) -> Vec<(Id, usize)> {
        let (mut found, mut seen, mut stack) = (Vec::new(), HashSet::new(), vec![x]);
        while let Some(id) = stack.pop() {
            if !seen.insert(id) {
                continue;
            }
            let expr = self.g().expr(id);
            if let Expr::Input {
                argument: Argument::Positions | Argument::Sines,
                index,
            } = expr
            {
                found.push((id, index as usize));
            }
            stack.extend(operands(expr));
        }
        found
    }
}
