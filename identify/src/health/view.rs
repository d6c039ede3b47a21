//! Postures beside what CAD says of them, and under every wiring that the effects know.
//!
//! ```text
//! s(x) = √(Σ (x − x̄)² / n)        χ² = mean of ((y − p) / σ)²
//! φ = q;  q π/180;  −q_j;  q_a ↔ q_b;  and each of the latter in degrees
//! ```

use sesc_model::effects::{Catalog, EffectContext, Instance, Stage, Target};
use sesc_model::{Function, Model, Snapping};

use super::criteria::UNKNOWN_NOISE_M;
use super::finding::{Picture, Row};
use super::wirings;
use crate::evaluate::Evaluator;
use crate::observations::postures::{Postures, range, rms};
use crate::robot::Robot;

/// x and y of a CoP, posture by posture, m.
pub(super) type Cop = [Vec<f64>; 2];

/// A robot on its support.
#[derive(Clone, Copy)]
pub(super) struct On<'a> {
    pub robot: &'a Robot,
    pub model: &'a Model,
    pub snapping: Snapping,
}

impl<'a> On<'a> {
    pub(super) fn new((robot, model): (&'a Robot, &'a Model), snapping: Snapping) -> On<'a> {
        On {
            robot,
            model,
            snapping,
        }
    }
}

/// Postures beside what CAD says of them.
pub(super) struct View<'a> {
    pub on: On<'a>,
    pub data: Postures,
    pub reading: Cop,
    /// Deviation of each reading, m; a guess where it is not known yet.
    pub std: Cop,
    /// CoM by CAD, three per posture, m.
    pub com: Vec<f64>,
    /// Its x and y.
    pub cad: Cop,
}

impl<'a> View<'a> {
    pub(super) fn new(on: On<'a>, data: Postures) -> View<'a> {
        let com = Evaluator::new(on.model, Function::Com).run(&data.q, data.len());
        let known = |std: f64| if std.is_nan() { UNKNOWN_NOISE_M } else { std };
        let std = |k: usize| column(&data.std, 2, k).into_iter().map(known).collect();
        View {
            on,
            reading: [0, 1].map(|k| column(&data.reading, 2, k)),
            std: [0, 1].map(std),
            cad: [0, 1].map(|k| column(&com, 3, k)),
            com,
            data,
        }
    }

    /// Some of the postures, evenly chosen: as many as are looked at under every wiring.
    pub(super) fn few(&self) -> View<'a> {
        let mut keep = vec![false; self.len()];
        for k in evenly(0..self.len(), 300) {
            keep[k] = true;
        }
        let mut data = self.data.clone();
        data.keep(&keep);
        View::new(self.on, data)
    }

    pub(super) fn len(&self) -> usize {
        self.data.len()
    }

    /// Positions of one joint.
    pub(super) fn joint(&self, joint: usize) -> Vec<f64> {
        column(&self.data.q, self.on.model.dof(), joint)
    }

    /// Distance of the readings from a CoP, m RMS.
    pub(super) fn gap(&self, cop: &Cop) -> f64 {
        rms((0..2).flat_map(|k| self.reading[k].iter().zip(&cop[k]).map(|(y, p)| y - p)))
    }

    /// The same squared, variances of the noise a reading.
    pub(super) fn chi2(&self, cop: &Cop) -> f64 {
        let axis = |k: usize| {
            let gaps = self.reading[k].iter().zip(&cop[k]).zip(&self.std[k]);
            gaps.map(|((y, p), std)| (y - p) / std)
        };
        rms(axis(0).chain(axis(1))).powi(2)
    }

    /// CoP by CAD under every wiring, that of the log first, and whether angles are in the log's unit. Each
    /// is made when it is asked for: exchanges of two joints are joints², and their joint positions
    /// joints³.
    pub(super) fn wired(&self) -> impl ExactSizeIterator<Item = (bool, Cop)> + '_ {
        let model = self.on.model;
        let context = EffectContext::new(model, &[], false, Catalog::standard());
        let com = Evaluator::new(model, Function::Com).fastest();
        let wiring = wirings::faults(&context).into_iter();
        let wiring = wiring.filter(|fault| fault.effect.stage() == Stage::Wiring);
        let (units, mut faults): (Vec<_>, Vec<_>) =
            wiring.partition(|fault| fault.effect.is_unit());
        // Of robots with hundreds of joints, exchanges of joints that are near in their order, as
        // plugs are beside each other.
        faults.sort_by_key(|fault| match fault.target {
            Target::Joints(a, b) => a.abs_diff(b),
            _ => 0,
        });
        // All of a robot of 140 joints.
        faults.truncate(10_000);
        let count = 1 + units.len();
        (0..(1 + faults.len()) * count).map(move |k| {
            // The first of both is none.
            let [unit, fault] = [(&units, k % count), (&faults, k / count)]
                .map(|(all, at)| at.checked_sub(1).map(|at| all[at].clone()));
            let in_unit = unit.is_none();
            let wiring: Vec<Instance> = unit.into_iter().chain(fault).collect();
            let q = wirings::positions(&context, &wiring, &self.data.q);
            let com = com.run(&q, self.len());
            (in_unit, [0, 1].map(|k| column(&com, 3, k)))
        })
    }

    /// One axis of the readings beside what CAD says.
    pub(super) fn beside_cad(&self, axis: usize) -> Picture {
        let title = ["CoP x, mm", "CoP y, mm"][axis];
        let both = |k: usize| [&self.cad, &self.reading].map(|cop| 1e3 * cop[axis][k]);
        self.of_two(title, both, ["CAD", "reading"])
    }

    /// Distance of the readings from CAD's CoP as they should be meant, and as they are.
    pub(super) fn distances(&self, meant: &Cop, marks: [&str; 2]) -> Picture {
        let from = |cop: &Cop, k: usize| {
            let gap = |axis: usize| self.reading[axis][k] - cop[axis][k];
            1e3 * gap(0).hypot(gap(1))
        };
        let both = |k: usize| [from(meant, k), from(&self.cad, k)];
        self.of_two("Distance of the CoP from CAD's, mm", both, marks)
    }

    /// Two values of every posture: one that would be in order, and that of the finding.
    fn of_two(&self, title: &str, both: impl Fn(usize) -> [f64; 2], marks: [&str; 2]) -> Picture {
        let values = |k: usize| both(k).into_iter().zip([false, true]).collect();
        Picture {
            marks: Some(marks.map(str::to_string)),
            ..Picture::new(title, self.len(), |k| self.row(k), values)
        }
    }

    /// A posture as figures show it.
    pub(super) fn row(&self, k: usize) -> Row {
        Row::among(&self.data.pose, &self.data.q, k)
    }
}

/// Every so manyth value.
pub(super) fn column(values: &[f64], width: usize, k: usize) -> Vec<f64> {
    values.iter().skip(k).step_by(width).copied().collect()
}

/// Some of the rows, at most so many, evenly chosen.
pub(super) fn evenly(rows: impl ExactSizeIterator<Item = usize>, most: usize) -> Vec<usize> {
    let stride = rows.len().div_ceil(most).max(1);
    rows.step_by(stride).collect()
}

/// How far the largest of some values is above the least.
pub(super) fn span(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = range(values);
    high - low
}

pub(super) fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

/// Values less their mean.
pub(super) fn centred(x: &[f64]) -> Vec<f64> {
    let middle = mean(x);
    x.iter().map(|x| x - middle).collect()
}

/// Deviation from the mean, RMS.
pub(super) fn scatter(x: &[f64]) -> f64 {
    rms(centred(x).into_iter())
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// What the best `a·x` leaves of `y`.
pub(super) fn without(y: &[f64], x: &[f64]) -> Vec<f64> {
    let share = dot(y, x) / dot(x, x).max(f64::MIN_POSITIVE);
    y.iter().zip(x).map(|(y, x)| y - share * x).collect()
}

/// What the best `c + a·u + b·v` leaves of `y`, RMS.
pub(super) fn left_by_plane(y: &[f64], [u, v]: [&[f64]; 2]) -> f64 {
    let [y, u, v] = [y, u, v].map(centred);
    rms(without(&without(&y, &u), &without(&v, &u)).into_iter())
}

/// What the best `c + a·x` with `a ≥ 0` leaves of `y`, RMS.
pub(super) fn left_by_gain(y: &[f64], x: &[f64]) -> f64 {
    let [y, x] = [y, x].map(centred);
    if dot(&y, &x) > 0.0 {
        rms(without(&y, &x).into_iter())
    } else {
        rms(y.into_iter())
    }
}
