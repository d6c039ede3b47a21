//! Velocities and accelerations of joints from a log: a polynomial through the rows around
//! each row, whatever their stamps.
//!
//! ```text
//! min_a Σ_i (q_i − Σ_m a_m ((t_i − t)/h)^m)²    |t_i − t| ≤ h       q̇ = a_1/h,  q̈ = 2 a_2/h²
//! ```
//!
//! h is 0.15, 0.3, 0.6 or 1.2 s, or 3.4 intervals where rows are further apart; beyond
//! `LONGEST_S` a log knows its accelerations only where joints are slow, beyond 1.1 s never.
//! Long windows have little noise and bend
//! what is fast: order 3 takes β = (ω h)²/14 of the acceleration of a sine of ω, order 4
//! β²/4. β is seen by comparing both orders in the same windows,
//!
//! ```text
//! β² ≈ (mean (q̈_4 − q̈_3)² − s² (w_4² − w_3²))/(mean q̈_4² − s² w_4²)
//! E_3² = s² w_3² + (10 β)² mean q̈²      E_4² = s² w_4² + (10 β²/4)² mean q̈²
//! ```
//!
//! with s² what order 4 leaves of q and w² the square sum of the rows' weights. The log takes
//! the order and the window whose E is least: what is bent counts ten times, since it is the
//! same in every swing while noise averages out. Accelerations by order 4 are then divided by
//! 1 − β²/4 of their own joint. Dense rows are averaged over a twentieth of h
//! first. A window ends where the log pauses; a row with too little of it on either side does
//! not know its motion, unless nothing moves in what there is. What rows of whole windows leave of
//! the polynomials is the noise of positions: encoders that turn in ticks have some. How
//! accelerations change from row to row is known, too, for joints that are late.
//!
//! Rows of a regressor that hold this noise would pull the parameters to zero, the more the less
//! the joints move: for them the motion is also known smooth, by order 4 through windows of
//! 2 h, which have a hundredth of the noise's square.
//!
//! ```text
//! E[Xᵀ e] = −E[ε_Xᵀ ε_X] r        where the noise of q, q̇ and q̈ is in rows and readings alike
//! ```
//!
//! Of a window of 2 h the noise of an acceleration has a thirtieth of the square that one of h
//! has, and what both share is no more than that (it is the better estimate of the two). Near the
//! ends and beside a pause a window reaches as far as the log goes on: a few rows as they were read
//! would hold more of the noise than all others together, and rows freed of noise that lasts are
//! differences, which have all of it.

mod polynomials;
#[cfg(test)]
mod tests;
mod windows;

use super::criteria::accelerations::{
    BENT, COHERENT, COVERED, LONGEST_OF_SLOW_S, LONGEST_S, MOST_BENT, MOVES, NOISIEST, REACH_S,
};
use std::ops::Range;

use super::correlation::{self, GAP};
use crate::logs::{Block, keep_some};
use crate::threads::by_parts;
use polynomials::{HIGH, Polynomials};
use windows::{FEWEST, Nodes};

/// Coefficients of the polynomials of order 3, and of one to a side.
const LOW: usize = 4;
const EDGE: usize = 3;
/// Rows that one thread works on.
const PART: usize = 512;
/// Windows that settle the order, at most.
const LOOKED_AT: usize = 400;
/// What order 4 bends where order 3 bends β, over β²: 0.00126 (ω h)⁴ over ((ω h)²/14)².
const OF_HIGH: f64 = 0.25;

/// What a window leaves of the noise of its own row at least, as a part.
const LEAST_LEFT: f64 = 0.2;
/// Windows of smooth motion are so many times as long.
const LONGER: f64 = 2.0;

/// How the joints of a log are differentiated.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Between rows, s.
    pub step_s: f64,
    /// Whether there are less than some eight rows to a swing.
    pub is_too_coarse: bool,
    half: f64,
    terms: usize,
    /// What accelerations of each joint are multiplied by, since windows bend them.
    unbend: Vec<f64>,
}

/// What windows of one length show of a log.
#[derive(Default)]
struct Survey {
    /// Windows that are whole, times joints.
    count: f64,
    /// Time from one window to the next that is looked at, s.
    stride: f64,
    /// Sums of q̈_4², of (q̈_4 − q̈_3)², of s² w_4² and of s² w_3².
    sums: [f64; 4],
    /// The same of each joint.
    joints: Vec<[f64; 4]>,
    /// Sum of s² of each joint.
    variances: Vec<f64>,
}

/// What is to be known of a motion beside its velocities and accelerations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// Nothing: for predictions.
    Alone,
    /// How accelerations change, jerks and snaps: for joints that are late.
    Changes,
    /// Smoothed positions: for rows of a regressor.
    Smooth,
}

/// How the joints move in rows of a log, row by row and joint by joint.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Motion {
    /// Where joints are, rad or m: by the polynomials, as read where joints stand.
    pub positions: Vec<f64>,
    /// rad/s or m/s
    pub rates: Vec<f64>,
    /// rad/s² or m/s²
    pub gains: Vec<f64>,
    /// Standard deviation of `gains`.
    pub gains_std: Vec<f64>,
    /// Standard deviation of `positions`, rad or m; 0 where nothing moves.
    pub positions_std: Vec<f64>,
    /// Correlation of `gains` with `positions`, which are of the same polynomials.
    pub with_positions: Vec<f64>,
    /// First derivative of `gains` in time; 0 where it is not known or not [`Wanted`],
    pub jerks: Vec<f64>,
    /// and second.
    pub snaps: Vec<f64>,
    /// Whether the row has a window.
    pub known: Vec<bool>,
    /// Positions, velocities and accelerations by windows of twice the length, with little noise and
    /// bent where it is fast, row by row and joint by joint; none where they are not asked for.
    pub smooth: Option<[Vec<f64>; 3]>,
}

impl Plan {
    /// For a log that begins with rows at times `t` (s) and positions `q` of `dof` joints; none
    /// where rows are too few or too far apart to know accelerations.
    pub fn of(t: &[f64], q: &[f64], dof: usize) -> Option<Plan> {
        let step_s = correlation::step(t).filter(|step| *step <= LONGEST_OF_SLOW_S)?;
        if dof == 0 || t.len() < FEWEST {
            return None;
        }
        let mut best: Option<(f64, Plan)> = None;
        let mut shortest = None;
        for half in windows::halves(step_s) {
            let survey = Survey::of(t, q, dof, step_s, half);
            let is_bent = OF_HIGH * bent(survey.sums).1 > BENT;
            let seconds = *shortest.get_or_insert(survey.seconds());
            let is_short = best.is_some() && survey.seconds() < COVERED * seconds;
            // Windows longer than a swing leave it, and their orders agree.
            let leaves = best.is_some() && survey.left() > NOISIEST;
            if step_s > LONGEST_S * 1.02 && is_bent || is_short || leaves {
                break;
            }
            for (terms, error) in survey.errors() {
                if best.as_ref().is_none_or(|(least, _)| error < *least) {
                    let unbend = survey.unbend(terms);
                    let plan = Plan {
                        step_s,
                        is_too_coarse: survey.is_too_coarse(),
                        half,
                        terms,
                        unbend,
                    };
                    best = Some((error, plan));
                }
            }
        }
        best.map(|(_, plan)| plan)
    }

    /// How far what is known of a row reaches to either side, s.
    pub fn reach_s(&self) -> f64 {
        windows::reach(LONGER * self.half) + self.reach_of_changes_s()
    }

    /// The motion in some `rows` of a log, of whose neighbours `t` and `q` hold what
    /// [`Plan::reach_s`] says; none where no joint moves by more than noise shows.
    pub fn motion(
        &self,
        (t, q, dof): (&[f64], &[f64], usize),
        rows: Range<usize>,
        wanted: Wanted,
    ) -> Option<Motion> {
        let is_still = q.chunks_exact(dof).all(|row| *row == q[..dof]);
        if is_still || rows.is_empty() {
            return None;
        }
        let reach = match wanted {
            Wanted::Changes => self.reach_of_changes_s(),
            _ => f64::NEG_INFINITY,
        };
        let near = |a: usize, b: usize| (t[b] - t[a]).abs() <= reach;
        let before = (0..rows.start)
            .rev()
            .take_while(|row| near(*row, rows.start));
        let after = (rows.end..t.len()).take_while(|row| near(rows.end - 1, *row));
        let around = rows.start - before.count()..rows.end + after.count();
        let mut motion = self.motion_in(t, q, dof, around.clone())?;
        if wanted == Wanted::Changes {
            self.find_changes(&mut motion, &t[around.clone()]);
        }
        if around != rows {
            let keep: Vec<bool> = around.map(|row| rows.contains(&row)).collect();
            motion.keep(&keep);
        }
        if wanted == Wanted::Smooth {
            motion.smooth = Some(self.smooth(t, q, &motion, rows));
        }
        Some(motion)
    }

    /// The same without changes of accelerations.
    fn motion_in(&self, t: &[f64], q: &[f64], dof: usize, rows: Range<usize>) -> Option<Motion> {
        let nodes = Nodes::of(t, q, dof, self.step_s, self.half);
        let moving = self.moving(&nodes);
        let stands = moving.is_none();
        let moving = moving.unwrap_or_else(|| vec![None; dof]);
        let read = &q[rows.start * dof..];
        let parts = by_parts(rows, PART, |rows| {
            let mut motion = Motion::default();
            for (node, rows) in nodes.with_rows(rows) {
                let (fit, known) = self.local(&nodes, node);
                // Order 4 bends no position, where order 3 is enough for accelerations.
                let higher = (known && fit.is_some() && self.terms == LOW)
                    .then(|| Polynomials::fit(&nodes, node, nodes.around(node), HIGH));
                let higher = higher.flatten();
                let fit = fit.as_ref();
                let place = higher.as_ref().or(fit).filter(|_| known);
                // The polynomial at a node has this part of its own noise, and so much of a row's.
                let own = place.map_or(1.0, |place| place.own.clamp(f64::MIN_POSITIVE, 1.0));
                let of_reading = place.map_or(0.0, |_| (own / nodes.rows as f64).sqrt());
                let correlation = |fit: &Polynomials| (fit.with_own / own.sqrt()).clamp(-1.0, 1.0);
                let with_positions = fit.map_or(0.0, correlation);
                for row in rows {
                    let after = t[row] - nodes.t[node];
                    for joint in 0..dof {
                        let position = place.map_or(q[row * dof + joint], |place| {
                            nodes.position(node, joint) + place.position(joint, after)
                        });
                        // Joints that do not move stand.
                        let known = fit.zip(moving[joint]);
                        let [rate, gain, std] = known.map_or([0.0; 3], |(fit, variance)| {
                            let gain = fit.gain(joint, after) * self.unbend[joint];
                            let std = fit.gain_std(joint, variance) * self.unbend[joint];
                            [fit.rate(joint, after), gain, std]
                        });
                        let here = [
                            position,
                            rate,
                            gain,
                            std,
                            of_reading,
                            with_positions,
                            0.0,
                            0.0,
                        ];
                        let columns = motion.columns().into_iter();
                        columns.zip(here).for_each(|(column, x)| column.push(x));
                    }
                    motion.known.push(known);
                }
            }
            motion
        });
        let mut motion = Motion::default();
        for own in parts {
            let rows = own.known.len();
            motion.extend(Some(own), rows, dof);
        }
        for joint in 0..dof {
            let all = (joint..motion.positions.len()).step_by(dof);
            let (mut square, mut count) = (0.0, 0.0_f64);
            // What rows leave of the polynomials, over what a fit leaves of noise of variance one.
            for k in all.clone().filter(|k| motion.positions_std[*k] > 0.0) {
                let left = (1.0 - motion.positions_std[k].powi(2)).max(LEAST_LEFT);
                square += (read[k] - motion.positions[k]).powi(2) / left;
                count += 1.0;
            }
            let of_reading = (square / count.max(1.0)).sqrt();
            let jumps = of_reading > NOISIEST;
            if stands && jumps {
                return None;
            }
            for k in all {
                motion.positions_std[k] *= of_reading;
                if jumps {
                    (motion.positions[k], motion.positions_std[k]) = (read[k], 0.0);
                }
            }
        }
        if stands {
            motion.known.fill(true);
        }
        Some(motion)
    }

    /// The motion of `rows` by longer windows; that which is `known` where those reach no further to
    /// either side, and of joints that stand: their accelerations have no deviation.
    fn smooth(&self, t: &[f64], q: &[f64], known: &Motion, rows: Range<usize>) -> [Vec<f64>; 3] {
        let dof = known.dof();
        let nodes = Nodes::of(t, q, dof, self.step_s, LONGER * self.half);
        let first = rows.start;
        let parts = by_parts(rows, PART, |rows| {
            let mut smooth: [Vec<f64>; 3] = Default::default();
            for (node, rows) in nodes.with_rows(rows) {
                let around = nodes.around(node);
                let fits = nodes.reaches(node, &around, self.half) && !nodes.are_still(&around);
                let fit = fits.then(|| Polynomials::fit(&nodes, node, around, HIGH));
                let fit = fit.flatten();
                for (row, joint) in rows.flat_map(|row| (0..dof).map(move |joint| (row, joint))) {
                    let (at, after) = ((row - first) * dof + joint, t[row] - nodes.t[node]);
                    let here = match fit.as_ref().filter(|_| known.gains_std[at] > 0.0) {
                        Some(fit) => [
                            nodes.position(node, joint) + fit.position(joint, after),
                            fit.rate(joint, after),
                            fit.gain(joint, after),
                        ],
                        None => [q[row * dof + joint], known.rates[at], known.gains[at]],
                    };
                    smooth.iter_mut().zip(here).for_each(|(all, x)| all.push(x));
                }
            }
            smooth
        });
        [0, 1, 2].map(|k| parts.iter().flat_map(|own| &own[k]).copied().collect())
    }

    /// How far a parabola through accelerations of rows reaches to either side, s; 0 where rows are
    /// too far apart.
    fn reach_of_changes_s(&self) -> f64 {
        match self.step_s > 2.0 * REACH_S {
            true => 0.0,
            false => REACH_S.max(1.5 * self.step_s),
        }
    }

    /// Find how accelerations change in rows at times `t`, by parabolas through those of the rows
    /// around each row; left zero where a row has a neighbour of known motion on one side alone, and
    /// where rows are too far apart.
    ///
    /// ```text
    /// b, f: slopes to the first and to the last row, at −a and +c        |a|, |c| ≤ reach
    /// d³q/dt³ = (c b + a f)/(a + c)        d⁴q/dt⁴ = 2 (f − b)/(a + c)
    /// ```
    fn find_changes(&self, motion: &mut Motion, t: &[f64]) {
        let (dof, reach) = (motion.dof(), self.reach_of_changes_s());
        let joins = |a: usize, b: usize| t[b] > t[a] && t[b] - t[a] <= GAP * self.step_s;
        for k in 0..t.len() {
            let near = |row: usize| motion.known[row] && (t[row] - t[k]).abs() <= reach;
            let (mut first, mut last) = (k, k);
            while first > 0 && joins(first - 1, first) && near(first - 1) {
                first -= 1;
            }
            while last + 1 < t.len() && joins(last, last + 1) && near(last + 1) {
                last += 1;
            }
            if first == k || last == k || !motion.known[k] {
                continue;
            }
            let (a, c) = (t[k] - t[first], t[last] - t[k]);
            for joint in 0..dof {
                let at = |row: usize| motion.gains[row * dof + joint];
                let (back, forth) = ((at(k) - at(first)) / a, (at(last) - at(k)) / c);
                motion.jerks[k * dof + joint] = (c * back + a * forth) / (a + c);
                motion.snaps[k * dof + joint] = 2.0 * (forth - back) / (a + c);
            }
        }
    }

    /// The variance of nodes of each joint that moves by more than noise shows, `None` of the
    /// others; none where none does.
    fn moving(&self, nodes: &Nodes) -> Option<Vec<Option<f64>>> {
        let dof = nodes.dof;
        let (mut gains, mut noise) = (vec![0.0; dof], vec![0.0; dof]);
        let (mut variances, mut count) = (vec![0.0; dof], 0.0);
        let stride = nodes.t.len().div_ceil(LOOKED_AT / 4).max(1);
        for (node, around) in nodes.moving(stride) {
            let Some(fit) = Polynomials::fit(nodes, node, around, self.terms) else {
                continue;
            };
            count += 1.0;
            for joint in 0..dof {
                gains[joint] += fit.gain(joint, 0.0).powi(2);
                variances[joint] += fit.variance(joint);
                noise[joint] += fit.variance(joint) * fit.weight * fit.weight;
            }
        }
        let of = |joint: usize| {
            let moves = gains[joint] > MOVES * MOVES * noise[joint];
            moves.then(|| variances[joint] / count)
        };
        let moving: Vec<Option<f64>> = (0..dof).map(of).collect();
        moving.iter().any(Option::is_some).then_some(moving)
    }

    /// The polynomials about a node, none where nothing moves or nodes do not settle them; and
    /// whether motion is known there.
    fn local(&self, nodes: &Nodes, node: usize) -> (Option<Polynomials>, bool) {
        let around = nodes.around(node);
        if nodes.are_still(&around) && around.len() > 1 {
            return (None, true);
        }
        let whole = nodes.reaches(node, &around, self.half);
        let terms = if whole { self.terms } else { EDGE };
        let fit = Polynomials::fit(nodes, node, around, terms);
        let known = whole && fit.is_some();
        (fit, known)
    }
}

impl Survey {
    fn of(t: &[f64], q: &[f64], dof: usize, step_s: f64, half: f64) -> Survey {
        let nodes = Nodes::of(t, q, dof, step_s, half);
        let count = nodes.t.len();
        let stride = count.div_ceil(LOOKED_AT).max(1);
        let span = nodes.t[count - 1] - nodes.t[0];
        let mut survey = Survey {
            stride: span * stride as f64 / count as f64,
            joints: vec![[0.0; 4]; dof],
            variances: vec![0.0; dof],
            ..Survey::default()
        };
        for (node, around) in nodes.moving(stride) {
            let fit = |terms| Polynomials::fit(&nodes, node, around.clone(), terms);
            let (Some(low), Some(high)) = (fit(LOW), fit(HIGH)) else {
                continue;
            };
            survey.count += dof as f64;
            for joint in 0..dof {
                let (gain, variance) = (high.gain(joint, 0.0), high.variance(joint));
                let own = [
                    gain.powi(2),
                    (gain - low.gain(joint, 0.0)).powi(2),
                    variance * high.weight * high.weight,
                    variance * low.weight * low.weight,
                ];
                survey.variances[joint] += variance;
                let sums = survey.joints[joint].iter_mut();
                sums.zip(own).for_each(|(sum, own)| *sum += own);
            }
        }
        survey.sums = [0, 1, 2, 3].map(|k| survey.joints.iter().map(|own| own[k]).sum());
        survey
    }

    /// Time that windows are whole for, times joints, s.
    fn seconds(&self) -> f64 {
        self.count * self.stride
    }

    /// What order 4 leaves of the positions of the joint of which it leaves most, RMS, rad or m.
    fn left(&self) -> f64 {
        let windows = self.count / self.variances.len() as f64;
        let most = self.variances.iter().copied().fold(0.0, f64::max);
        (most / windows.max(1.0)).sqrt()
    }

    /// Whether order 3 bends more of accelerations than can be made good, and order 4 leaves more of
    /// positions than markers have noise.
    fn is_too_coarse(&self) -> bool {
        bent(self.sums).1 > MOST_BENT && self.left() > 0.5 * NOISIEST
    }

    /// What accelerations of each joint are to be multiplied by. Those by order 3 are taken where
    /// it bends next to nothing, and β itself is known less well than β².
    fn unbend(&self, terms: usize) -> Vec<f64> {
        let of = |own: &[f64; 4]| {
            if terms == HIGH && own[0] > MOVES * MOVES * own[2] {
                1.0 / (1.0 - OF_HIGH * bent(*own).1.min(MOST_BENT))
            } else {
                1.0
            }
        };
        self.joints.iter().map(of).collect()
    }

    /// E² of both orders.
    fn errors(&self) -> [(usize, f64); 2] {
        let [.., of_high, of_low] = self.sums;
        let (moves, square) = bent(self.sums);
        let (bent, count) = (COHERENT * OF_HIGH * square, self.count.max(1.0));
        let low = (of_low + COHERENT * COHERENT * square * moves) / count;
        [(HIGH, (of_high + bent * bent * moves) / count), (LOW, low)]
    }
}

impl Motion {
    /// Leave out rows of `block` whose motion is not known; gives back how many.
    pub fn leave_out_unknown(&mut self, block: &mut Block) -> u64 {
        if self.known.iter().all(|known| *known) {
            return 0;
        }
        let keep = self.known.clone();
        block.retain(&keep);
        self.keep(&keep);
        (keep.len() - block.len()) as u64
    }

    /// Leave out the rows that are false in `keep`.
    pub fn keep(&mut self, keep: &[bool]) {
        let dof = self.dof();
        for all in self.smooth.iter_mut().flatten() {
            keep_some(all, dof, keep);
        }
        for all in self.columns() {
            keep_some(all, dof, keep);
        }
        keep_some(&mut self.known, 1, keep);
    }

    /// Add rows; those of a log that stands where there is none, whose positions are those that were read.
    /// What is smooth is not kept.
    pub fn extend(&mut self, other: Option<Motion>, rows: usize, dof: usize) {
        self.smooth = None;
        match other {
            Some(mut other) => {
                for (own, more) in self.columns().into_iter().zip(other.columns()) {
                    own.append(more);
                }
                self.known.extend(other.known);
            }
            None => {
                for all in self.columns() {
                    all.resize(all.len() + rows * dof, 0.0);
                }
                self.known.resize(self.known.len() + rows, true);
            }
        }
    }

    /// What is known of each row and joint, positions first.
    pub fn columns(&mut self) -> [&mut Vec<f64>; 8] {
        [
            &mut self.positions,
            &mut self.rates,
            &mut self.gains,
            &mut self.gains_std,
            &mut self.positions_std,
            &mut self.with_positions,
            &mut self.jerks,
            &mut self.snaps,
        ]
    }

    fn dof(&self) -> usize {
        (self.rates.len() / self.known.len().max(1)).max(1)
    }
}

/// Σ q̈² of what moves, and β², of the sums of a [`Survey`].
fn bent([gains, apart, of_high, of_low]: [f64; 4]) -> (f64, f64) {
    let moves = (gains - of_high).max(0.0);
    let bent = (apart - (of_high - of_low)).max(0.0);
    (moves, if moves > 0.0 { bent / moves } else { 0.0 })
}
