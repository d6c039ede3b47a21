//! Rows that are left out of a log, by the rules that a look at it made; and digits, which tell
//! rows apart.

use std::collections::HashSet;

use sesc_model::hash::{START, fnv1a};

use crate::health::criteria::STILL;
use crate::logs::{Screen, Screening};

/// What tells a row: its joints and what was read, to the last bit.
pub(super) fn key(q: &[f64], reading: &[f64]) -> u64 {
    let values = q.iter().chain(reading);
    values.fold(START, |hash, value| {
        fnv1a(hash, &value.to_bits().to_le_bytes())
    })
}

/// What was read: the forces where there are cells, else the CoP.
pub(super) fn reading_of<'a>(cop: &'a [f64; 2], force: &'a [f64]) -> &'a [f64] {
    if force.is_empty() { cop } else { force }
}

/// An end of a channel of the CoP.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::health) struct End {
    /// 0 or 1.
    pub channel: usize,
    /// Whether values end above, or below.
    pub upper: bool,
    /// m
    pub at: f64,
}

/// An encoder that stops for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::health) struct Parked {
    /// Number of the joint.
    pub joint: usize,
    /// Where it says that the joint is then, rad or m.
    pub at: f64,
}

/// Rules for single rows. Those of the default leave out nothing, also no rows without contact.
#[derive(Debug, Clone, Default, PartialEq)]
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
    /// Whether encoders at positions `q` follow their joints.
    pub fn follows(&self, q: &[f64]) -> bool {
        let parked = |parked: &Parked| (q[parked.joint] - parked.at).abs() <= STILL;
        !self.parked.iter().any(parked)
    }

    /// Whether a row of this reading, and these loads, stays.
    pub fn keeps(&self, reading: [f64; 2], force: &[f64]) -> bool {
        let load = || force.iter().sum::<f64>();
        let is_in =
            |[low, high]: [[f64; 2]; 2]| (0..2).all(|k| (low[k]..=high[k]).contains(&reading[k]));
        let beyond = |end: &End| match end.upper {
            true => reading[end.channel] >= end.at,
            false => reading[end.channel] <= end.at,
        };
        let is_stale = || match force {
            [] => (0..2).any(|k| self.frozen.contains(&(k, reading[k].to_bits()))),
            force => self.frozen.contains(&(0, key(&[], force))),
        };
        self.least_load.is_none_or(|least| load() >= least)
            && !(self.zero && reading == [0.0; 2])
            && self.sole.is_none_or(is_in)
            && (self.frozen.is_empty() || !is_stale())
            && !self.ends.iter().any(beyond)
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
            let mut keep = |row: usize| {
                let q = &block.q[row * dof..(row + 1) * dof];
                let force = match &block.cells {
                    Some(cells) => &cells.force[row * cells.count..(row + 1) * cells.count],
                    None => &[],
                };
                rules.keeps(reading[row], force)
                    && rules.follows(q)
                    && (!rules.copies || known.insert(key(q, reading_of(&reading[row], force))))
            };
            let keep: Vec<bool> = (0..block.len()).map(&mut keep).collect();
            block.retain(&keep);
            for std in block.std.iter_mut().flatten() {
                *std = [0, 1].map(|k| std[k].hypot(rules.steps[k]));
            }
        })
    }
}
