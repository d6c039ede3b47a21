//! Rows that are left out of a log, by the rules that a look at it made.
//!
//! Digits of a log: what tells rows apart, and steps that a channel moves in.

use std::collections::HashSet;

use sesc_model::hash::{START, fnv1a};

use crate::health::criteria::STILL;
use crate::logs::{Screen, Screening};

/// Takes rows without contact as they are, to look at them.
#[derive(Debug)]
pub(super) struct Everything;

impl Screen for Everything {
    fn start(&self) -> Screening {
        Box::new(|_| {})
    }
}

/// An end of a channel of the CoP.
#[derive(Debug, Clone, Copy)]
pub(in crate::health) struct End {
    /// 0 or 1.
    pub channel: usize,
    /// Whether values end above, or below.
    pub upper: bool,
    /// m
    pub at: f64,
}

/// An encoder that stops for a while.
#[derive(Debug, Clone, Copy)]
pub(in crate::health) struct Parked {
    /// Number of the joint.
    pub joint: usize,
    /// Where it says that the joint is then, rad or m.
    pub at: f64,
}

/// Rules for single rows.
#[derive(Debug, Clone, Default)]
pub(in crate::health) struct LeftOut {
    /// Less in total on the cells is no contact, N.
    pub least_load: Option<f64>,
    /// A CoP of exactly zero is no contact.
    pub zero: bool,
    /// A CoP beyond these corners is no CoP, m.
    pub sole: Option<[[f64; 2]; 2]>,
    /// Channels of the CoP that are at or beyond their end.
    pub ends: Vec<End>,
    /// Values at which a channel of the CoP (0, 1), or all cells (0), froze.
    pub frozen: HashSet<(usize, u64)>,
    /// Encoders that stop, and where.
    pub parked: Vec<Parked>,
    /// Rows that came before, once more.
    pub copies: bool,
    /// Added in quadrature to stated deviations, m: steps of the readings.
    pub steps: [f64; 2],
}

impl LeftOut {
    /// Whether every row stays as it is.
    pub fn is_nothing(&self) -> bool {
        self.least_load.is_none()
            && !self.zero
            && self.sole.is_none()
            && self.ends.is_empty()
            && self.frozen.is_empty()
            && self.parked.is_empty()
            && !self.copies
            && self.steps == [0.0; 2]
    }

    /// Whether encoders at positions `q` follow their joints.
    pub fn follows(&self, q: &[f64]) -> bool {
        let parked = |parked: &Parked| (q[parked.joint] - parked.at).abs() <= STILL;
        !self.parked.iter().any(parked)
    }

    /// Whether a row of this reading, and these loads, stays.
    pub fn keeps(&self, reading: [f64; 2], force: &[f64]) -> bool {
        let standing = self
            .least_load
            .is_none_or(|least| force.iter().sum::<f64>() >= least);
        let seen = !self.zero || reading != [0.0; 2];
        let inside = self
            .sole
            .is_none_or(|[low, high]| (0..2).all(|k| (low[k]..=high[k]).contains(&reading[k])));
        let beyond = |end: &End| match end.upper {
            true => reading[end.channel] >= end.at,
            false => reading[end.channel] <= end.at,
        };
        let stale = || match force {
            [] => (0..2).any(|k| self.frozen.contains(&(k, reading[k].to_bits()))),
            force => self.frozen.contains(&(0, key(&[], force))),
        };
        let stale = !self.frozen.is_empty() && stale();
        standing && seen && inside && !stale && !self.ends.iter().any(beyond)
    }
}

impl Screen for LeftOut {
    fn start(&self) -> Screening {
        let rules = self.clone();
        let mut known: HashSet<u64> = HashSet::new();
        Box::new(move |block| {
            let Some(reading) = &block.reading else {
                return;
            };
            let dof = block.q.len() / block.len().max(1);
            let force = |row: usize| match &block.cells {
                Some(cells) => &cells.force[row * cells.count..(row + 1) * cells.count],
                None => &[],
            };
            let mut keep = |row: usize| {
                let q = &block.q[row * dof..(row + 1) * dof];
                let own = || key(q, &reading_of(reading[row], force(row)));
                rules.keeps(reading[row], force(row))
                    && rules.follows(q)
                    && (!rules.copies || known.insert(own()))
            };
            let keep: Vec<bool> = (0..block.len()).map(&mut keep).collect();
            block.retain(&keep);
            for std in block.std.iter_mut().flatten() {
                *std = [0, 1].map(|k| std[k].hypot(rules.steps[k]));
            }
        })
    }
}

/// What tells a row: its joints and what was read, to the last bit.
pub(super) fn key(q: &[f64], reading: &[f64]) -> u64 {
    let values = q.iter().chain(reading);
    values.fold(START, |hash, value| {
        fnv1a(hash, &value.to_bits().to_le_bytes())
    })
}

/// What was read: the forces where there are cells, else the CoP.
pub(super) fn reading_of(cop: [f64; 2], force: &[f64]) -> Vec<f64> {
    match force {
        [] => cop.to_vec(),
        force => force.to_vec(),
    }
}

/// The step that all values are multiples of, if there is one.
pub(super) fn step(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let gaps: Vec<f64> = sorted.windows(2).map(|w| w[1] - w[0]).collect();
    let least = gaps
        .iter()
        .copied()
        .filter(|g| *g > 1e-9)
        .fold(f64::INFINITY, f64::min);
    let whole = |gap: &f64| {
        let times = gap / least;
        (times - times.round()).abs() < 0.01 * times.clamp(1.0, 10.0)
    };
    let regular = least.is_finite() && gaps.len() >= 2 && gaps.iter().all(whole);
    // Few values far apart have a step only if some of them share it.
    let shared = gaps.iter().filter(|g| **g < 1.5 * least).count();
    (regular && 4 * shared >= gaps.len() && shared >= 2).then_some(least)
}
