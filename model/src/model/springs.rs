//! Whether joints that give way come to rest.
//!
//! ```text
//! φᵏ⁺¹ = φ + f(τ(φᵏ))        ρ = largest eigenvalue of C H over the joint limits
//! C = ∂f/∂τ, of a spring its compliance,  H = ∂τ/∂φ
//! ```
//!
//! Each round leaves out ρ of what the one before did. `H` is taken along one direction at a
//! time, by differences; the largest of 64 postures counts, the upright one among them.

use super::{Model, posture};
use crate::effects::{ROUNDS, Stage};
use crate::interface::{Function, Given};
use crate::numeric;
use crate::program::Program;
use crate::tape::{Kernels, Tape, Values};

/// Above this contraction there are more than the usual rounds,
const SOFT: f64 = 0.3;
/// and so many at most.
const MOST_ROUNDS: usize = 8;
/// Above this one rounds say nothing of where the robot rests.
const SOFTEST: f64 = 0.8;
/// What rounds may leave out of the CoM, m.
const LEFT_OUT_M: f64 = 1e-3;
/// Rounds after which the robot rests, at the softest to a millionth.
const AT_REST: usize = 64;
const POSTURES: usize = 64;
/// Powers of C H, by which its largest eigenvalue is found.
const POWERS: usize = 12;
/// Step of the differences, rad.
const STEP: f64 = 1e-5;

/// The rounds that the springs of a model take.
///
/// # Errors
/// Where rounds do not come to rest, in a sentence.
pub(super) fn rounds(model: &Model) -> Result<usize, String> {
    let (program, pairs) = posture::yielding(model);
    if pairs.is_empty() {
        return Ok(ROUNDS);
    }
    let still = Still::new(model, &program, pairs);
    let contraction = still.contraction();
    let soft = |what: String| {
        format!(
            "springs are too soft: {what}; give joint_compliance a larger stiffness_nm_per_rad (a \
             joint that carries the robot has five times that of gravity and more), functions of \
             tau smaller parameters"
        )
    };
    if contraction > SOFTEST {
        return Err(soft(format!(
            "where gravity bends a joint it adds {contraction:.2} of that bend again, and more \
             than {SOFTEST} comes to no rest"
        )));
    }
    let wanted = match contraction <= SOFT {
        true => ROUNDS,
        false => libm::ceil(ROUNDS as f64 * libm::log(SOFT) / libm::log(contraction)) as usize,
    };
    let rounds = wanted.min(MOST_ROUNDS);
    let left_out = still.left_out(rounds);
    match left_out <= LEFT_OUT_M {
        true => Ok(rounds),
        false => Err(soft(format!(
            "{rounds} rounds of bending leave out {:.1} mm of the CoM",
            1e3 * left_out
        ))),
    }
}

/// The robot with its loads whose joints do not give way, in postures.
struct Still {
    moments: Tape,
    /// How far joints are moved by moments, and by how much of each of `pairs`.
    yielding: Tape,
    /// Entries of its second input, of which moments are the last.
    free: usize,
    /// Joint and moment.
    pairs: Vec<(usize, usize)>,
    com: Tape,
    params: Vec<f64>,
    dof: usize,
    /// Row by row.
    postures: Vec<f64>,
}

impl Still {
    fn new(model: &Model, yielding: &Program, pairs: Vec<(usize, usize)>) -> Still {
        let mut still = model.clone();
        still
            .effects
            .retain(|(instance, _)| instance.effect.stage() == Stage::Loads);
        let tape = |function| {
            let program = still.program(function, Given::Positions);
            Tape::new(&program.expect("positions give every function"))
        };
        let dofs = &model.tree.dofs;
        let upright: Vec<f64> = dofs
            .iter()
            .map(|dof| 0.0_f64.max(dof.lower).min(dof.upper))
            .collect();
        let others = numeric::postures(dofs, POSTURES - 1).flatten();
        Still {
            moments: tape(Function::GravityMoments),
            yielding: Tape::new(yielding),
            free: yielding.inputs[1].len,
            pairs,
            com: tape(Function::Com),
            params: model.params(),
            dof: dofs.len(),
            postures: upright.into_iter().chain(others).collect(),
        }
    }

    fn run(&self, tape: &Tape, q: &[f64], width: usize) -> Vec<f64> {
        let count = q.len() / self.dof;
        let mut out = vec![0.0; count * width];
        let arguments = [Values::PerPosture(q), Values::Shared(&self.params)];
        tape.run(&arguments, count, &mut out, Kernels::LIBM);
        out
    }

    /// How far moments move the joints from where they stand, and the entries of C, posture by
    /// posture.
    fn yields(&self, moments: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (dof, width) = (self.dof, self.dof + self.pairs.len());
        let count = moments.len() / dof;
        // Those before the moments are no part of it.
        let before = self.free - dof;
        let mut free = Vec::with_capacity(count * (before + dof));
        for row in moments.chunks(dof) {
            free.extend(std::iter::repeat_n(0.0, before));
            free.extend(row);
        }
        let mut out = vec![0.0; count * width];
        let arguments = [
            Values::PerPosture(&self.postures),
            Values::PerPosture(&free),
        ];
        self.yielding
            .run(&arguments, count, &mut out, Kernels::LIBM);
        let rows = out.chunks(width).map(|row| row.split_at(dof));
        let (by, slopes): (Vec<&[f64]>, Vec<&[f64]>) = rows.unzip();
        (by.concat(), slopes.concat())
    }

    /// The largest eigenvalue of C H over the postures, by its powers.
    fn contraction(&self) -> f64 {
        let dof = self.dof;
        let moments = self.run(&self.moments, &self.postures, dof);
        let (_, slopes) = self.yields(&moments);
        // No two entries alike, so that none is across the eigenvector.
        let start = (0..dof).map(|j| 1.0 / (1.0 + j as f64));
        let mut v: Vec<f64> = start.collect::<Vec<f64>>().repeat(POSTURES);
        let mut worst: f64 = 0.0;
        for _ in 0..POWERS {
            worst = 0.0;
            for row in v.chunks_mut(dof) {
                let norm = libm::sqrt(row.iter().map(|x| x * x).sum());
                row.iter_mut()
                    .for_each(|x| *x /= if norm > 0.0 { norm } else { 1.0 });
            }
            let moved = |step: f64| -> Vec<f64> {
                let both = self.postures.iter().zip(&v);
                let at = both.map(|(q, v)| q + step * v);
                self.run(&self.moments, &at.collect::<Vec<f64>>(), dof)
            };
            let rates = moved(STEP).into_iter().zip(moved(-STEP));
            let rates = rates.map(|(ahead, back)| (ahead - back) / (2.0 * STEP));
            let rates: Vec<f64> = rates.collect();
            v.fill(0.0);
            for (posture, slopes) in slopes.chunks(self.pairs.len()).enumerate() {
                for ((joint, moment), slope) in self.pairs.iter().zip(slopes) {
                    v[posture * dof + joint] += slope * rates[posture * dof + moment];
                }
            }
            for row in v.chunks(dof) {
                let norm = libm::sqrt(row.iter().map(|x| x * x).sum());
                worst = if norm.is_finite() {
                    worst.max(norm)
                } else {
                    f64::INFINITY
                };
            }
        }
        worst
    }

    /// How far the CoM after `rounds` is from where it rests, m, at most.
    fn left_out(&self, rounds: usize) -> f64 {
        let mut bent = self.postures.clone();
        let mut found = Vec::new();
        for round in 0..AT_REST {
            if round == rounds {
                found = self.run(&self.com, &bent, 3);
            }
            let moments = self.run(&self.moments, &bent, self.dof);
            let (by, _) = self.yields(&moments);
            let straight = self.postures.iter().zip(by);
            bent = straight.map(|(q, by)| q + by).collect();
        }
        let at_rest = self.run(&self.com, &bent, 3);
        let off = found.chunks(3).zip(at_rest.chunks(3));
        let off = off.map(|(a, b)| libm::hypot(libm::hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]));
        off.fold(0.0, |worst: f64, x| {
            if x.is_nan() {
                f64::INFINITY
            } else {
                worst.max(x)
            }
        })
    }
}
