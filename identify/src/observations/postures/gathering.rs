//! Rows of a log gathered into postures: sums per posture, in bounded memory.

use super::super::grouping::Grouping;
use super::super::motion::Motion;
use super::super::repeats::Repeats;
use super::super::rows::{CopRows, tilt};
use super::super::stays::Stays;
use nalgebra::DVector;
use sesc_model::Model;

/// Postures that a diagnosis looks at, up to twice this; evenly chosen of more.
pub(crate) const MOST: usize = 2000;

/// One posture while its rows are gathered.
#[derive(Clone, Default)]
pub(super) struct Posture {
    pub(super) pose: i64,
    pub(super) rows: f64,
    pub(super) q: Vec<f64>,
    pub(super) sum: [f64; 2],
    /// Σ of stated variances, m².
    pub(super) variance: [f64; 2],
    pub(super) t: f64,
    pub(super) tilt: [f64; 2],
    /// Σ of what the other foot has of the load, and of that times its CoP, m.
    pub(super) other: [f64; 3],
    pub(super) moving: Motions,
    /// Σ of the sides from which joints came; empty where these are not known.
    pub(super) sides: Vec<f64>,
}

/// Sums of what is known of a motion beside positions, variances in the place of deviations, over
/// rows that know it; empty where joints stand.
#[derive(Clone, Default)]
pub(super) struct Motions {
    pub(super) rows: f64,
    /// Whether a row does not know its motion.
    pub(super) unknown: bool,
    pub(super) sums: [Vec<f64>; 7],
}

impl Motions {
    pub(super) fn of(motion: Option<&Motion>, row: usize, dof: usize) -> Motions {
        let Some(motion) = motion else {
            return Motions {
                rows: 1.0,
                ..Motions::default()
            };
        };
        let of = |all: &[f64]| all[row * dof..(row + 1) * dof].to_vec();
        let variances = |all: &[f64]| of(all).iter().map(|s| s * s).collect();
        Motions {
            rows: 1.0,
            unknown: !motion.known[row],
            sums: [
                of(&motion.rates),
                of(&motion.gains),
                variances(&motion.gains_std),
                variances(&motion.positions_std),
                of(&motion.with_positions),
                of(&motion.jerks),
                of(&motion.snaps),
            ],
        }
    }

    pub(super) fn join(&mut self, other: &Motions) {
        match (self.unknown, other.unknown) {
            // What is known counts.
            (false, true) => return,
            (true, false) => *self = Motions::default(),
            _ => {}
        }
        self.rows += other.rows;
        for (sums, more) in self.sums.iter_mut().zip(&other.sums) {
            sums.resize(more.len().max(sums.len()), 0.0);
            add(sums, more);
        }
    }
}

impl Posture {
    pub(super) fn mean(&self) -> Vec<f64> {
        self.q.iter().map(|sum| sum / self.rows).collect()
    }

    fn join(&mut self, row: &Posture) {
        self.rows += row.rows;
        add(&mut self.q, &row.q);
        add(&mut self.sum, &row.sum);
        add(&mut self.variance, &row.variance);
        add(&mut self.other, &row.other);
        self.moving.join(&row.moving);
        add(&mut self.sides, &row.sides);
    }
}

fn add(sums: &mut [f64], more: &[f64]) {
    sums.iter_mut().zip(more).for_each(|(sum, x)| *sum += x);
}

/// Postures of a log of any length in bounded memory: every `stride`-th is kept,
/// and `stride` doubles whenever they are too many. An even choice keeps the
/// order, the times and the range.
#[derive(Default)]
pub(super) struct Gathering {
    /// Postures number 0, `stride`, 2 `stride`, ….
    pub(super) kept: Vec<Posture>,
    stride: usize,
    /// Postures that rows may come back to.
    pub(super) known: Grouping,
    pub(super) repeats: Repeats,
    pub(super) stays: Stays,
    /// The first posture that each is a visit of; empty where all were reached under one number.
    pub(super) first_visits: Vec<usize>,
    /// Postures that are whole, and the one that rows belong to now.
    seen: usize,
    current: Option<Posture>,
    first: Option<i64>,
    /// Whether pose numbers rise all along.
    rising: bool,
    end: i64,
    /// Least and largest time, s.
    span: (f64, f64),
}

impl Gathering {
    pub(super) fn new(any_unit: bool) -> Gathering {
        Gathering {
            stride: 1,
            known: Grouping::of_any_unit(any_unit),
            rising: true,
            span: (f64::INFINITY, f64::NEG_INFINITY),
            ..Gathering::default()
        }
    }

    /// A row with gravity along `gravity` and its deviation (1 where none is stated), m.
    pub(super) fn push(&mut self, row: Posture, gravity: [f64; 3], std: [f64; 2]) {
        self.span = (self.span.0.min(row.t), self.span.1.max(row.t));
        let posture = self.known.of_row((row.pose, ""), &row.q, gravity);
        let (number, visit) = (posture.number, posture.visits);
        self.repeats.push(&mut posture.group, visit, row.sum, std);
        self.stays.push((number, visit), row.t, row.sum);
        if let Some(current) = self.current.as_mut().filter(|_| number == self.seen) {
            current.join(&row);
            return;
        }
        self.close();
        if number == self.seen {
            self.current = Some(row);
        } else if number.is_multiple_of(self.stride) {
            // Back at an old posture: more readings of it.
            self.kept[number / self.stride].join(&row);
        }
    }

    /// The posture at hand is whole.
    pub(super) fn close(&mut self) {
        let Some(posture) = self.current.take() else {
            return;
        };
        self.rising &= self.seen == 0 || posture.pose > self.end;
        self.first.get_or_insert(posture.pose);
        self.end = posture.pose;
        if self.seen.is_multiple_of(self.stride) {
            self.kept.push(posture);
            if self.kept.len() > 2 * MOST {
                self.stride *= 2;
                let kept = std::mem::take(&mut self.kept);
                self.kept = kept.into_iter().step_by(2).collect();
            }
        }
        self.seen += 1;
    }

    /// Take postures that were reached again under another number for visits of one.
    pub(super) fn join_reached_again(&mut self, model: &Model) {
        let Some(first) = self.known.reached_again() else {
            return;
        };
        let stances = self.known.stances();
        let tilts: Vec<_> = stances.gravity.iter().flatten().map(|g| tilt(*g)).collect();
        let rows = CopRows::new(model).of(&stances.q, stances.len(), Some(&tilts));
        let predicted = rows * DVector::from_vec(model.cad_params());
        let group = |k| &self.known.posture(k).group;
        self.repeats
            .join_visits(&first, group, predicted.as_slice());
        self.first_visits = first;
    }

    /// How the joints move in the postures that were kept.
    pub(super) fn motion(&self, dof: usize) -> Motion {
        let mut motion = Motion::default();
        for posture in &self.kept {
            let own = &posture.moving;
            let moves = !own.sums[0].is_empty();
            let one = moves.then(|| {
                let mut one = Motion::default();
                for (mean, sums) in one.columns().into_iter().skip(1).zip(&own.sums) {
                    mean.extend(sums.iter().map(|sum| sum / own.rows));
                }
                one.positions = posture.mean();
                one.gains_std.iter_mut().for_each(|std| *std = std.sqrt());
                // Accelerations of neighbours are from the same window, positions are read anew.
                let positions = one.positions_std.iter_mut();
                positions.for_each(|std| *std = (*std / own.rows).sqrt());
                // Of the mean of the positions, whose noise is so much less.
                let with = one.with_positions.iter_mut();
                with.for_each(|with| *with = (*with * own.rows.sqrt()).clamp(-1.0, 1.0));
                one.known.push(!own.unknown);
                one
            });
            motion.extend(one, 1, dof);
        }
        motion
    }

    /// Time of a posture since the log began, s; 0 where there are no times.
    pub(super) fn since(&self, k: usize, timed: bool) -> f64 {
        match timed {
            true => self.kept[k].t - self.span.0,
            false => 0.0,
        }
    }

    /// Place of a posture in the log, 0 to 1: by time, by number where numbers
    /// rise, else by order.
    pub(super) fn place(&self, k: usize, timed: bool) -> f64 {
        let (first, end) = (self.first.unwrap_or_default(), self.end);
        let posture = &self.kept[k];
        let (from, to, at) = match (timed, self.rising) {
            (true, _) => (self.span.0, self.span.1, posture.t),
            (false, true) => (first as f64, end as f64, posture.pose as f64),
            (false, false) => (0.0, self.seen as f64 - 1.0, (k * self.stride) as f64),
        };
        if to > from {
            (at - from) / (to - from)
        } else {
            0.0
        }
    }
}
