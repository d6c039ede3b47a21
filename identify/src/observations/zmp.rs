//! What motion adds to readings of the CoP, and to their rows.
//!
//! ```text
//! p = c_xy − (c_z (c̈_xy − g τ) + L̇⊥/M)/(g + c̈_z)        τ: gravity's slope against the sole
//! y − (p⁰ − Y r⁰) = Y r        Y = ∂p/∂r at CAD's r⁰: rows of c and c̈, linear in r
//! ```
//!
//! c and c̈ have rows in the base parameters. L̇ and the vertical force are those of the URDF's masses
//! and inertias: a CoP tells of neither, and the force of masses that are free may be anything. The
//! product c_z c̈_xy is taken to first order about CAD. p⁰ is that of what was
//! read, Y of smooth motion ([`super::motion`]): noise that both shared would bend the fit. How well
//! accelerations and positions are known adds to the noise:
//! `σ² = Σ_j a_j² + b_j² + 2 ρ a_j b_j`, `a_j = (∂p/∂q̈_j) σ(q̈_j)`, `b_j = (∂c/∂q_j) σ(q_j)`, where ρ is
//! their correlation: an acceleration is made of the position that was read, too.

use std::array;
use std::ops::Range;

use sesc_model::effects::PostureContext;
use sesc_model::inertia::GRAVITY;
use sesc_model::tape::{Tape, Values};
use sesc_model::{Model, motion_parts, motion_rows};

use super::criteria::accelerations::LEAST_LOAD;
use super::motion::Motion;
use super::row_matrix::RowMatrix;
use crate::evaluate::FASTEST;
use crate::threads::by_parts;

/// An acceleration that hardly changes the load on the ground, rad/s² or m/s².
const SMALL: f64 = 1e-3;
/// Joints are moved by this for differences, rad or m,
const STEP: f64 = 1e-5;
/// and the robot by this along its motion, s.
const STEP_S: f64 = 1e-3;

/// Postures in which it is asked what joints do to the ZMP, at most.
const LEVERS: usize = 32;
/// Postures that one thread works on.
const PART: usize = 256;

/// The ZMP of one robot on its support, row by row.
pub struct Zmp {
    tape: Tape,
    /// CoM, acceleration and L̇⊥/M by CAD.
    by_cad: Tape,
    /// CAD's.
    params: Vec<f64>,
    dof: usize,
}

/// What motion does to some rows.
#[derive(Debug, Clone, Default)]
pub struct Moved {
    /// `∂p/∂r`, 2 per posture.
    pub rows: RowMatrix,
    /// The ZMP less the static CoP, by CAD, m.
    pub shift: Vec<[f64; 2]>,
    /// The same by smooth motion, which hardly has the noise of joints; as it is where that is not
    /// known.
    pub smooth_shift: Vec<[f64; 2]>,
    /// How the CoM is accelerated upwards by CAD, over gravity.
    pub lift: Vec<f64>,
    /// What is taken from readings, so that rows times parameters is what is left, m.
    pub correction: Vec<[f64; 2]>,
    /// Deviation of the ZMP because accelerations and positions are not known better, m.
    pub std: Vec<[f64; 2]>,
    /// ∂shift/∂q_j, x and y, posture by posture and joint by joint, m/rad or 1; empty until asked
    /// for.
    pub slopes: Vec<[f64; 2]>,
    /// First and second derivative of the shift in time beside what slopes make of velocities and
    /// accelerations, m/s and m/s², x and y each; empty until asked for.
    pub in_time: Vec<[[f64; 2]; 2]>,
}

impl Moved {
    /// Write what is known of posture `k` into its context.
    pub fn tell(&self, k: usize, layout: PostureContext, context: &mut [f64]) {
        context[layout.lift()] = self.lift[k];
        for axis in 0..2 {
            context[layout.shift(axis)] = self.shift[k][axis];
            for order in [1, 2] {
                let of = self.in_time.get(k).map_or(0.0, |own| own[order - 1][axis]);
                context[layout.shift_in_time(order, axis)] = of;
            }
        }
        let width = self.slopes.len() / self.shift.len().max(1);
        let slopes = &self.slopes[k * width..(k + 1) * width];
        for (joint, slopes) in slopes.iter().enumerate() {
            (0..2).for_each(|axis| context[layout.shift_slope(joint, axis)] = slopes[axis]);
        }
    }
}

/// What one joint does to the ZMP, by axis: means over postures.
#[derive(Clone, Copy, Default)]
struct Lever {
    /// Square of the effect of its acceleration on the CoP, (m s²/rad)² or s⁴.
    gain: [f64; 2],
    /// Square of the effect of its position on the CoP, (m/rad)² or 1.
    position: [f64; 2],
    /// Product of both.
    both: [f64; 2],
}

/// Deviation of the ZMP in a row of `motion`, whose joints are at `own`, by axis, m.
fn deviation(levers: &[Lever], motion: &Motion, own: Range<usize>) -> [f64; 2] {
    [0, 1].map(|axis| {
        let by = levers.iter().zip(own.clone()).map(|(lever, at)| {
            let (gain, position) = (motion.gains_std[at], motion.positions_std[at]);
            let both = motion.with_positions[at] * gain * position * lever.both[axis];
            gain * gain * lever.gain[axis] + position * position * lever.position[axis] + 2.0 * both
        });
        by.sum::<f64>().max(0.0).sqrt()
    })
}

/// c, c̈ and L̇⊥/M of one posture.
struct Parts {
    com: [f64; 3],
    gain: [f64; 3],
    spin: [f64; 2],
}

impl Parts {
    /// The parts among what [`motion_parts`] gives.
    fn of([x, y, z, ax, ay, az, front, side]: [f64; 8]) -> Parts {
        Parts {
            com: [x, y, z],
            gain: [ax, ay, az],
            spin: [front, side],
        }
    }

    fn load(&self) -> f64 {
        (GRAVITY + self.gain[2]).max(LEAST_LOAD * GRAVITY)
    }

    /// Moment over the load, by axis.
    fn pushed(&self, axis: usize, tilt: [f64; 2]) -> f64 {
        let push = self.gain[axis] - GRAVITY * tilt[axis];
        (self.com[2] * push + self.spin[axis]) / self.load()
    }

    fn shift(&self, tilt: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| -self.pushed(axis, tilt) - self.com[2] * tilt[axis])
    }
}

impl Zmp {
    /// Prepare the ZMP of `model` on its support.
    pub fn new(model: &Model) -> Zmp {
        let model = &*model.with_believed_inertias();
        Zmp {
            tape: Tape::new(&motion_rows(model)),
            by_cad: Tape::new(&motion_parts(model)),
            params: model.cad_params(),
            dof: model.dof(),
        }
    }

    /// Evaluate postures with their velocities and accelerations.
    fn run(&self, tape: &Tape, motion: [&[f64]; 3]) -> Vec<f64> {
        let n = motion[0].len() / self.dof.max(1);
        let parts = by_parts(0..n, PART, |rows| {
            let own = rows.start * self.dof..rows.end * self.dof;
            let arguments = motion.map(|all| Values::PerPosture(&all[own.clone()]));
            let mut out = vec![0.0; rows.len() * tape.outputs()];
            tape.run(&arguments, rows.len(), &mut out, FASTEST);
            out
        });
        parts.concat()
    }

    fn parts(&self, out: &[f64], params: &[f64]) -> Parts {
        let p = params.len();
        Parts::of(array::from_fn(|part| match part {
            6 | 7 => out[6 * p + part - 6],
            row => {
                let row = &out[row * p..(row + 1) * p];
                row.iter().zip(params).map(|(a, b)| a * b).sum()
            }
        }))
    }

    /// The ZMP less the static CoP of parameters `params`, m, of postures `q`; `tilts` as
    /// those of [`super::rows::tilt`].
    pub fn shifts(
        &self,
        params: &[f64],
        q: &[f64],
        (rates, gains): (&[f64], &[f64]),
        tilts: &[[f64; 2]],
    ) -> Vec<[f64; 2]> {
        self.of_rows([q, rates, gains], tilts, |out, tilt| {
            self.parts(out, params).shift(tilt)
        })
    }

    /// What `of` makes of the rows of each posture in motion.
    fn of_rows(
        &self,
        motion: [&[f64]; 3],
        tilts: &[[f64; 2]],
        of: impl Fn(&[f64], [f64; 2]) -> [f64; 2],
    ) -> Vec<[f64; 2]> {
        let out = self.run(&self.tape, motion);
        let all = out.chunks_exact(self.tape.outputs()).zip(tilts);
        all.map(|(out, tilt)| of(out, *tilt)).collect()
    }

    /// What motion adds where base parameters are `off` CAD's by so much, m: as rows of
    /// [`Zmp::moved`] have it.
    pub fn shifts_by_masses(
        &self,
        off: &[f64],
        q: &[f64],
        (rates, gains): (&[f64], &[f64]),
        tilts: &[[f64; 2]],
    ) -> Vec<[f64; 2]> {
        self.of_rows([q, rates, gains], tilts, |out, tilt| {
            let (by, more) = (self.parts(out, &self.params), self.parts(out, off));
            [0, 1].map(|axis| {
                let push = by.gain[axis] - GRAVITY * tilt[axis];
                let moments = push * more.com[2] + by.com[2] * more.gain[axis];
                -moments / by.load() - tilt[axis] * more.com[2]
            })
        })
    }

    /// Rows, corrections and deviations of postures `q`, which are `rows` of `motion`.
    pub fn moved(
        &self,
        q: &[f64],
        motion: &Motion,
        rows: Range<usize>,
        tilts: &[[f64; 2]],
    ) -> Moved {
        let own = rows.start * self.dof..rows.end * self.dof;
        let levers = match motion.gains_std[own].iter().any(|std| *std > 0.0) {
            true => self.levers(q),
            false => vec![Lever::default(); self.dof],
        };
        let parts = by_parts(0..tilts.len(), PART, |own| {
            let of_log = rows.start + own.start..rows.start + own.end;
            let q = &q[own.start * self.dof..own.end * self.dof];
            self.moved_part(q, (motion, of_log), &tilts[own], &levers)
        });
        let columns = self.params.len();
        let mut moved = Moved {
            rows: RowMatrix {
                entries: Vec::with_capacity(2 * tilts.len() * columns),
                columns,
            },
            ..Moved::default()
        };
        for part in parts {
            moved.rows.entries.extend(part.rows.entries);
            moved.shift.extend(part.shift);
            moved.smooth_shift.extend(part.smooth_shift);
            moved.lift.extend(part.lift);
            moved.correction.extend(part.correction);
            moved.std.extend(part.std);
        }
        moved
    }

    fn moved_part(
        &self,
        q: &[f64],
        (motion, rows): (&Motion, Range<usize>),
        tilts: &[[f64; 2]],
        levers: &[Lever],
    ) -> Moved {
        let own = rows.start * self.dof..rows.end * self.dof;
        let motion_read = [q, &motion.rates[own.clone()], &motion.gains[own.clone()]];
        let read = self.run(&self.by_cad, motion_read);
        // Where nothing smooth is known, rows have the noise of the readings' motion.
        let smooth = motion.smooth.as_ref();
        let smooth = smooth.map(|smooth| smooth.each_ref().map(|all| &all[own.clone()]));
        let of_rows = self.run(&self.tape, smooth.unwrap_or(motion_read));
        let p = self.params.len();
        let mut moved = Moved::default();
        moved.rows.entries.reserve(2 * tilts.len() * p);
        let (read, _) = read.as_chunks::<8>();
        let both = read.iter().zip(of_rows.chunks_exact(self.tape.outputs()));
        for (row, ((read, of_rows), tilt)) in rows.zip(both.zip(tilts)) {
            let (parts, by) = (Parts::of(*read), self.parts(of_rows, &self.params));
            moved.shift.push(parts.shift(*tilt));
            moved.smooth_shift.push(by.shift(*tilt));
            moved.lift.push(parts.load() / GRAVITY - 1.0);
            let own = row * self.dof..(row + 1) * self.dof;
            moved.std.push(deviation(levers, motion, own));
            let row = |row: usize| &of_rows[row * p..(row + 1) * p];
            moved.correction.push([0, 1].map(|axis| {
                let push = by.gain[axis] - GRAVITY * tilt[axis];
                let (com, height, gain) = (row(axis), row(2), row(3 + axis));
                let inverse = 1.0 / by.load();
                let entry = |k: usize| com[k] - (push * height[k] + by.com[2] * gain[k]) * inverse;
                let start = moved.rows.entries.len();
                moved.rows.entries.extend((0..p).map(entry));
                let pairs = moved.rows.entries[start..].iter().zip(&self.params);
                let sum: f64 = pairs.map(|(entry, param)| entry * param).sum();
                parts.com[axis] - parts.pushed(axis, *tilt) - sum
            }));
        }
        moved
    }

    /// Tell how what motion adds to postures `q` changes with the position of each joint, and along
    /// their `motion`.
    pub fn tell_changes(&self, moved: &mut Moved, q: &[f64], motion: &Motion, tilts: &[[f64; 2]]) {
        let (dof, known) = (self.dof, motion);
        let shifts = |q: &[f64], rates: &[f64], gains: &[f64]| {
            self.shifts(&self.params, q, (rates, gains), tilts)
        };
        let here = shifts(q, &known.rates, &known.gains);
        moved.slopes = vec![[0.0; 2]; q.len()];
        for joint in 0..dof {
            let mut turned = q.to_vec();
            let own = turned.iter_mut().skip(joint).step_by(dof);
            own.for_each(|q| *q += STEP);
            let turned = shifts(&turned, &known.rates, &known.gains);
            for (k, (after, before)) in turned.iter().zip(&here).enumerate() {
                let slope = |axis: usize| (after[axis] - before[axis]) / STEP;
                moved.slopes[k * dof + joint] = [0, 1].map(slope);
            }
        }
        // Where all derivatives but the last are known, `dt` later.
        let later = |dt: f64, [x, rate, gain]: [&[f64]; 3]| -> Vec<f64> {
            let all = x.iter().zip(rate).zip(gain);
            all.map(|((x, rate), gain)| x + dt * (rate + 0.5 * dt * gain))
                .collect()
        };
        let [before, after] = [-STEP_S, STEP_S].map(|dt| {
            let q = later(dt, [q, &known.rates, &known.gains]);
            let rates = later(dt, [&known.rates, &known.gains, &known.jerks]);
            let gains = later(dt, [&known.gains, &known.jerks, &known.snaps]);
            shifts(&q, &rates, &gains)
        });
        let of = |k: usize| {
            let own = k * dof..(k + 1) * dof;
            if known.jerks[own.clone()].iter().all(|jerk| *jerk == 0.0) {
                return [[0.0; 2]; 2];
            }
            let by_slopes = |motion: &[f64], axis: usize| -> f64 {
                let pairs = motion[own.clone()].iter().zip(&moved.slopes[own.clone()]);
                pairs.map(|(x, slope)| x * slope[axis]).sum()
            };
            let rate = |axis: usize| (after[k][axis] - before[k][axis]) / (2.0 * STEP_S);
            let curve = |axis: usize| {
                let sum = after[k][axis] + before[k][axis];
                (sum - 2.0 * here[k][axis]) / (STEP_S * STEP_S)
            };
            [
                [0, 1].map(|axis| rate(axis) - by_slopes(&known.rates, axis)),
                [0, 1].map(|axis| curve(axis) - by_slopes(&known.gains, axis)),
            ]
        };
        moved.in_time = (0..tilts.len()).map(of).collect();
    }

    /// What joints do to the ZMP in postures `q`, on average of some of them.
    fn levers(&self, q: &[f64]) -> Vec<Lever> {
        let (dof, n) = (self.dof, q.len() / self.dof);
        let some = n.min(LEVERS);
        // Each posture as it is, with each joint accelerated, and with each joint moved.
        let each = 1 + 2 * dof;
        let mut postures = Vec::with_capacity(some * each * dof);
        let mut gains = vec![0.0; some * each * dof];
        for k in 0..some {
            let own = (2 * k + 1) * n / (2 * some) * dof;
            for change in 0..each {
                let at = (k * each + change) * dof;
                postures.extend(&q[own..own + dof]);
                match change {
                    0 => {}
                    _ if change <= dof => gains[at + change - 1] = SMALL,
                    _ => postures[at + change - 1 - dof] += STEP,
                }
            }
        }
        let still = vec![0.0; gains.len()];
        let out = self.run(&self.by_cad, [&postures, &still, &gains]);
        let (parts, _) = out.as_chunks::<8>();
        let mut levers = vec![Lever::default(); dof];
        for own in parts.chunks_exact(each) {
            let own: Vec<Parts> = own.iter().map(|parts| Parts::of(*parts)).collect();
            for (joint, lever) in levers.iter_mut().enumerate() {
                let shift = own[1 + joint].shift([0.0; 2]);
                for (axis, shift) in shift.into_iter().enumerate() {
                    let gain = shift / SMALL;
                    let moved = own[1 + dof + joint].com[axis] - own[0].com[axis];
                    let position = moved / STEP;
                    lever.gain[axis] += gain * gain / some as f64;
                    lever.position[axis] += position * position / some as f64;
                    lever.both[axis] += gain * position / some as f64;
                }
            }
        }
        levers
    }
}

#[cfg(test)]
mod tests;
