//! Rows that are left out of a log, by the rules that a look at it made; and digits, which tell
//! rows apart.

use std::collections::HashSet;
use std::ops::RangeInclusive;
use std::sync::Arc;

use sesc_model::hash::{START, fnv1a};

use crate::evaluate::Evaluator;
use crate::health::criteria::STILL;
use crate::logs::{Block, LEAST_LOAD_N, Screen, Screening};

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

/// Least and greatest corner of a box, m.
pub(crate) type Corners = [[f64; 2]; 2];
/// A box without edges.
pub(super) const EVERYWHERE: Corners = [[f64::NEG_INFINITY; 2], [f64::INFINITY; 2]];

/// Whether a reading lies on the edge of a box, or further out.
pub(super) fn is_beyond([low, high]: Corners, reading: [f64; 2]) -> bool {
    (0..2).any(|k| reading[k] <= low[k] || reading[k] >= high[k])
}

/// Rules for single rows. Those of the default leave out nothing, also no rows without contact.
#[derive(Clone, Default, PartialEq)]
pub(in crate::health) struct LeftOut {
    /// Less in total on the sensor is no contact, N.
    pub least_load: Option<f64>,
    /// Stretches in which something else carries the robot, by the places of their rows in the log.
    pub held: Vec<RangeInclusive<u64>>,
    /// Both feet stand in every row: none with a foot in the air is one.
    pub lifted: bool,
    /// A CoP of exactly zero is no contact.
    pub zero: bool,
    /// On its edges channels are clipped, and beyond it the CoP is none.
    pub within: Option<Corners>,
    /// Values at which a channel of the CoP (0, 1), or all cells (0), froze.
    pub frozen: HashSet<(usize, u64)>,
    /// Joints whose encoders stop, and where, rad or m.
    pub parked: Vec<(usize, f64)>,
    /// Rows that came before, once more.
    pub copies: bool,
    /// Added in quadrature to stated deviations, m: steps of the readings.
    pub steps: [f64; 2],
    /// An encoder that does not follow its joint: rows count for less along its motion.
    pub less_known: Option<LessKnown>,
}

/// What rows are less known by along the motion of a joint.
#[derive(Clone)]
pub(in crate::health) struct LessKnown {
    /// CoM Jacobian of the robot.
    pub slopes: Arc<Evaluator>,
    pub joint: usize,
    /// How far the joint may be from where its encoder says, rad or m.
    pub anywhere: f64,
    /// Noise of rows that state none, m.
    pub noise: Option<f64>,
}

impl PartialEq for LessKnown {
    fn eq(&self, other: &LessKnown) -> bool {
        self.joint == other.joint
    }
}

impl LessKnown {
    fn apply(&self, block: &mut Block) {
        let n = block.len();
        if let (None, Some(noise)) = (&block.std, self.noise) {
            block.std = Some(vec![[noise; 2]; n]);
        }
        let slopes = self.slopes.run(&block.q, n);
        let dof = block.q.len() / n.max(1);
        for (k, std) in block.std.iter_mut().flatten().enumerate() {
            let slope = |axis: usize| slopes[(3 * k + axis) * dof + self.joint];
            *std = [0, 1].map(|axis| std[axis].hypot(self.anywhere * slope(axis)));
        }
    }
}

impl LeftOut {
    /// Whether encoders at positions `q` follow their joints.
    pub(crate) fn follows(&self, q: &[f64]) -> bool {
        let mut parked = self.parked.iter();
        !parked.any(|(joint, at)| (q[*joint] - at).abs() <= STILL)
    }

    /// Whether a row of a block with readings stays.
    pub(crate) fn keeps(&self, block: &Block, row: usize) -> bool {
        let Some(&reading) = block.reading.as_ref().and_then(|all| all.get(row)) else {
            return true;
        };
        let force = block.forces(row);
        let load = || block.total_force(row).unwrap_or(f64::INFINITY);
        let is_stale = || match force {
            [] => (0..2).any(|k| self.frozen.contains(&(k, reading[k].to_bits()))),
            force => self.frozen.contains(&(0, key(&[], force))),
        };
        let both_stand = || {
            let share = block.other.as_ref().map_or(0.5, |all| all[row][0]);
            share.min(1.0 - share) * load() >= LEAST_LOAD_N
        };
        let stands = |rows: &RangeInclusive<u64>| !rows.contains(&block.line[row]);
        self.least_load.is_none_or(|least| load() >= least)
            && (!self.lifted || both_stand())
            && self.held.iter().all(stands)
            && !(self.zero && reading == [0.0; 2])
            && (self.frozen.is_empty() || !is_stale())
            && self.within.is_none_or(|within| !is_beyond(within, reading))
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
            let mut keep = |row: usize| {
                let (q, force) = (block.joints(row), block.forces(row));
                rules.keeps(block, row)
                    && rules.follows(q)
                    && (!rules.copies || known.insert(key(q, reading_of(&reading[row], force))))
            };
            let keep: Vec<bool> = (0..block.len()).map(&mut keep).collect();
            block.retain(&keep);
            for std in block.std.iter_mut().flatten() {
                *std = [0, 1].map(|k| std[k].hypot(rules.steps[k]));
            }
            if let Some(less_known) = &rules.less_known {
                less_known.apply(block);
            }
        })
    }
}
