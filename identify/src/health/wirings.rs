//! What CAD says under every wiring that the effects know.
//!
//! ```text
//! φ = q;  q π/180;  −q_j;  q_a ↔ q_b;  and each of the latter in degrees
//! y ≈ c + A p(φ)        offset, gain, rotation, signs and exchange of the axes
//! ```
//!
//! A finding that makes data unusable holds under all of them: where one explains the
//! readings, naming it is the work of a diagnosis. Some postures, evenly chosen, are
//! looked at, and only once a finding is at hand. Columns of numbers:
//!
//! ```text
//! s(x) = √(Σ (x − x̄)² / n)        ρ(a, b)        R² = 1 − min_c ‖y − X c‖² / ‖y − ȳ‖²
//! ```

use std::borrow::Cow;
use std::cell::OnceCell;
use std::iter;

use sesc_model::effects::{self, Catalog, EffectContext, Instance, Stage, Target};
use sesc_model::tape::{Tape, Values};
use sesc_model::{Function, Model};

use super::criteria::CHANCE;
use crate::evaluate::{Evaluator, FASTEST};
use crate::observations::postures::{Postures, rms};

/// Coordinates of the CoM that are kept from one question to the next, at most: 64 MiB.
const KEPT: usize = 8 << 20;

/// Joint positions of some postures under every wiring.
pub(super) struct Wirings<'a> {
    model: &'a Model,
    /// Which postures.
    chosen: Vec<usize>,
    /// Their joint positions as logged, and their readings.
    q: Vec<f64>,
    reading: Vec<f64>,
    /// Those in each unit of angles, the log's first.
    units: OnceCell<Vec<Vec<f64>>>,
    /// CoM under each wiring, where they are few; wirings follow each other unit by unit.
    com: OnceCell<Vec<Vec<f64>>>,
}

impl<'a> Wirings<'a> {
    pub fn new(model: &'a Model, data: &Postures) -> Wirings<'a> {
        let (n, dof) = (data.len(), model.dof());
        // Nearly all wirings are exchanges of two joints, in two units of angles.
        let most = (KEPT / 3 / (dof * dof + 1)).clamp(40, 300);
        let chosen = evenly(0..n, most);
        let rows = |values: &[f64], width: usize| -> Vec<f64> {
            let of = |&k: &usize| values[k * width..(k + 1) * width].to_vec();
            chosen.iter().flat_map(of).collect()
        };
        Wirings {
            model,
            q: rows(&data.q, dof),
            reading: rows(&data.reading, 2),
            chosen,
            units: OnceCell::new(),
            com: OnceCell::new(),
        }
    }

    fn context(&self) -> EffectContext<'a> {
        EffectContext::new(self.model, &[], false, Catalog::standard())
    }

    /// Joint positions in each unit of angles that is tried; the log's is the first.
    fn units(&self) -> &[Vec<f64>] {
        self.units.get_or_init(|| {
            let context = self.context();
            let mut units = vec![self.q.clone()];
            for unit in of_wiring(&context, true) {
                let q = self.under(&context, &unit, &self.q);
                if !units.contains(&q) {
                    units.push(q);
                }
            }
            units
        })
    }

    /// How many wirings there are.
    fn count(&self) -> usize {
        (1 + of_wiring(&self.context(), false).len()) * self.units().len()
    }

    fn under(&self, context: &EffectContext, fault: &Instance, q: &[f64]) -> Vec<f64> {
        let program = effects::wired_joints(context, std::slice::from_ref(fault));
        let mut out = vec![0.0; q.len()];
        let positions = [Values::PerPosture(q)];
        Tape::of_many(&program).run(&positions, self.chosen.len(), &mut out, FASTEST);
        out
    }

    /// CoM under each wiring, on the support of `model`: that of the log first, unit by unit.
    /// Each is made when it is asked for: exchanges of two joints are joints², and their joint
    /// positions are joints³.
    fn made<'b>(&'b self, model: &'b Model) -> impl Iterator<Item = Vec<f64>> + 'b {
        let context = self.context();
        let com = Evaluator::new(model, Function::Com).fastest();
        let faults = of_wiring(&context, false).into_iter().map(Some);
        let all = iter::once(None).chain(faults);
        let both = all.flat_map(|fault| self.units().iter().map(move |q| (fault.clone(), q)));
        both.map(move |(fault, q)| match fault {
            None => com.run(q, self.chosen.len()),
            Some(fault) => com.run(&self.under(&context, &fault, q), self.chosen.len()),
        })
    }

    /// CoM under each wiring on the log's support; they are kept where they are few.
    fn com(&self) -> Box<dyn Iterator<Item = Cow<'_, [f64]>> + '_> {
        if self.count() * self.chosen.len() * 3 > KEPT {
            return Box::new(self.made(self.model).map(Cow::Owned));
        }
        let kept = self.com.get_or_init(|| self.made(self.model).collect());
        Box::new(kept.iter().map(|com| Cow::Borrowed(&com[..])))
    }

    /// Least scatter of one axis of the CoP under any wiring in the log's unit, m.
    pub fn least_scatter(&self, k: usize) -> f64 {
        let in_unit = self.com().step_by(self.units().len());
        let of = |com: Cow<'_, [f64]>| scatter(&column(&com, k));
        in_unit.map(of).fold(f64::INFINITY, f64::min)
    }

    /// What the best wiring leaves of the readings, m RMS, where the sensor may be offset,
    /// scaled, rotated and mirrored; axes `axes` of the CoM are those of the sole.
    pub fn left(&self, axes: [usize; 2]) -> f64 {
        self.least_left(self.com(), axes)
    }

    /// The same on another support.
    pub fn left_on(&self, model: &Model) -> f64 {
        self.least_left(self.made(model).map(Cow::Owned), [0, 1])
    }

    fn least_left<'b>(&self, com: impl Iterator<Item = Cow<'b, [f64]>>, axes: [usize; 2]) -> f64 {
        let both = |com: Cow<'b, [f64]>| {
            let [x, y] = axes.map(|k| column(&com, k));
            let left = |k| left_by_plane(&axis(&self.reading, k), [&x, &y]);
            f64::hypot(left(0), left(1)) / f64::sqrt(2.0)
        };
        com.map(both).fold(f64::INFINITY, f64::min)
    }

    /// Distance of the readings from CAD's CoP under the best wiring, as a part of that under the
    /// log's own.
    pub fn nearer(&self) -> f64 {
        let gap = |com: Cow<'_, [f64]>| {
            let gaps = self.reading.chunks_exact(2).zip(com.chunks_exact(3));
            rms_of_gaps(gaps.map(|(y, c)| [y[0] - c[0], y[1] - c[1]]))
        };
        let mut gaps = self.com().map(gap);
        let own = gaps.next().unwrap_or(0.0);
        gaps.fold(own, f64::min) / own.max(f64::MIN_POSITIVE)
    }

    /// Whether `holds` of what some wiring leaves, m RMS, in the axes of the support: the sensor's
    /// zero and the gain of each axis are free, and none is mirrored.
    pub fn upright(&self, holds: impl Fn(f64) -> bool) -> bool {
        self.any(|com| {
            let left = |k| left_by_gain(&axis(&self.reading, k), &column(com, k));
            holds(f64::hypot(left(0), left(1)) / f64::sqrt(2.0))
        })
    }

    /// Whether `holds` of the CoM under some wiring. Most logs are wired as they say, and
    /// hundreds of other wirings need not be made.
    fn any(&self, holds: impl Fn(&[f64]) -> bool) -> bool {
        self.made(self.model).take(1).any(|com| holds(&com)) || self.com().any(|com| holds(&com))
    }

    /// Whether one axis of the readings goes with the postures under some wiring by more
    /// than chance does in one of [`CHANCE`] logs, be the sensor's zero and axes what they may.
    ///
    /// ```text
    /// R² of noise on 2 columns:    P(R² > x) = (1 − x)^((n − 3)/2)
    /// ```
    pub fn relates(&self, k: usize) -> bool {
        let tests = 2.0 * self.count() as f64;
        let free = (self.chosen.len() as f64 - 3.0).max(1.0);
        let kept = (-2.0 * (CHANCE * tests).ln() / free).exp();
        let read = axis(&self.reading, k);
        self.any(|com| {
            let left = left_by_plane(&read, [&column(com, 0), &column(com, 1)]);
            left * left < kept * scatter(&read).powi(2)
        })
    }
}

/// Faults of wiring: those of the unit of angles, or the others. Of robots with hundreds of
/// joints, those exchanges are asked about that are nearest in the order of the joints, as plugs
/// are beside each other.
fn of_wiring(context: &EffectContext, units: bool) -> Vec<Instance> {
    let all = effects::instances(context).into_iter();
    let own = |i: &Instance| i.effect.is_unit() == units;
    let wiring = all.filter(|i| i.effect.stage() == Stage::Wiring && own(i));
    let mut all: Vec<Instance> = wiring.collect();
    // All of a robot of 140 joints.
    let most = 10_000;
    if all.len() > most {
        all.sort_by_key(|instance| match instance.target {
            Target::Joints(a, b) => a.abs_diff(b),
            _ => 0,
        });
        all.truncate(most);
    }
    all
}

fn column(com: &[f64], k: usize) -> Vec<f64> {
    com.iter().skip(k).step_by(3).copied().collect()
}

/// Some of the rows, at most so many, evenly chosen.
pub(super) fn evenly(rows: impl ExactSizeIterator<Item = usize>, most: usize) -> Vec<usize> {
    let stride = rows.len().div_ceil(most).max(1);
    rows.step_by(stride).collect()
}

/// Values less their mean.
pub(super) fn centred(x: &[f64]) -> Vec<f64> {
    let middle = mean(x);
    x.iter().map(|x| x - middle).collect()
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Every second value.
pub(super) fn axis(values: &[f64], axis: usize) -> Vec<f64> {
    values.iter().skip(axis).step_by(2).copied().collect()
}

pub(super) fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

/// Deviation from the mean, RMS.
pub(super) fn scatter(x: &[f64]) -> f64 {
    let middle = mean(x);
    rms(x.iter().map(|x| x - middle))
}

/// Correlation of two columns; zero where one of them does not move.
pub(super) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (ma, mb) = (mean(a), mean(b));
    let both: f64 = a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum();
    let size = scatter(a) * scatter(b) * a.len() as f64;
    if size > 0.0 { both / size } else { 0.0 }
}

/// RMS over one axis.
pub(super) fn rms_of(values: &[f64], k: usize) -> f64 {
    rms(axis(values, k).into_iter())
}

/// Gap of the readings to a CoP, m RMS.
pub(super) fn gap(data: &Postures, cop: &[f64]) -> f64 {
    rms(data.reading.iter().zip(cop).map(|(y, p)| y - p))
}

/// What the best `c + a·x₁ + b·x₂` leaves of `y`, RMS.
pub(super) fn left_by_plane(y: &[f64], x: [&[f64]; 2]) -> f64 {
    let mut left = centred(y);
    let mut directions: Vec<Vec<f64>> = Vec::new();
    for column in x {
        let mut own = centred(column);
        let whole = dot(&own, &own);
        for other in &directions {
            let share = dot(&own, other) / dot(other, other);
            own.iter_mut().zip(other).for_each(|(a, b)| *a -= share * b);
        }
        // A column that the other one repeats has no direction of its own.
        if dot(&own, &own) <= 1e-20 * whole || whole == 0.0 {
            continue;
        }
        let share = dot(&left, &own) / dot(&own, &own);
        left.iter_mut().zip(&own).for_each(|(a, b)| *a -= share * b);
        directions.push(own);
    }
    rms(left.into_iter())
}

/// What the best `c + a·x` with `a ≥ 0` leaves of `y`, RMS.
pub(super) fn left_by_gain(y: &[f64], x: &[f64]) -> f64 {
    let along = correlation(y, x).max(0.0);
    scatter(y) * (1.0 - along * along).max(0.0).sqrt()
}

/// Size of gaps on two axes, RMS over both.
pub(super) fn rms_of_gaps(gaps: impl Iterator<Item = [f64; 2]>) -> f64 {
    rms(gaps.flatten())
}
