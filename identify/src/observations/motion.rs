//! Velocities and accelerations of joints from a log: a polynomial through the rows around
//! each row, whatever their stamps.
//!
//! ```text
//! min_a Σ_i (q_i − Σ_m a_m ((t_i − t)/h)^m)²    |t_i − t| ≤ h       q̇ = a_1/h,  q̈ = 2 a_2/h²
//! ```
//!
//! h is 0.15 s, or 3.4 intervals where rows are further apart; beyond [`LONGEST_S`] a log
//! does not know its accelerations. Order 4 is exact where joints are fast, order 3 has a
//! third of the noise: a log takes the one whose expected error is smaller,
//!
//! ```text
//! E_4² = s² w_4²      E_3² = s² w_3² + max(0, mean (q̈_4 − q̈_3)² − s² (w_4² − w_3²))
//! ```
//!
//! with s² what order 4 leaves of q and w² the square sum of the rows' weights. Dense rows are
//! averaged over `NODE_S` first. A window ends where the log pauses; a row with too little of
//! it on either side does not know its motion, unless nothing moves in what there is.

use super::correlation;
use crate::logs::Block;

/// Half of the window, s.
const HALF_S: f64 = 0.15;
/// Rows of a window on either side where they are far apart.
const SIDE: f64 = 3.4;
/// Longest interval between rows, s.
pub const LONGEST_S: f64 = 0.2;
/// Rows are averaged over this time, s.
const NODE_S: f64 = 0.0075;
/// Coefficients of the polynomials of order 3 and 4, and of one to a side.
const LOW: usize = 4;
const HIGH: usize = 5;
const EDGE: usize = 3;
/// Rows that a window needs beyond its coefficients.
const SPARE: usize = 1;
/// A pause is this many intervals.
const PAUSE: f64 = 4.0;
/// Part of half a window that rows must span on either side.
const SPANNED: f64 = 0.55;
/// Windows that settle the order, at most.
const LOOKED_AT: usize = 400;
/// A joint moves where its acceleration is this many times what noise makes of one, RMS.
const MOVES: f64 = 2.0;

/// How the joints of a log are differentiated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Between rows, s.
    pub step_s: f64,
    terms: usize,
}

/// How the joints move in rows of a log, row by row and joint by joint.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Motion {
    /// rad/s or m/s
    pub rates: Vec<f64>,
    /// rad/s² or m/s²
    pub gains: Vec<f64>,
    /// Standard deviation of `gains`.
    pub gains_std: Vec<f64>,
    /// Whether the row has a window.
    pub known: Vec<bool>,
}

impl Plan {
    /// For a log that begins with rows at times `t` (s) and positions `q` of `dof` joints; none
    /// where rows are too few or too far apart to know accelerations.
    pub fn of(t: &[f64], q: &[f64], dof: usize) -> Option<Plan> {
        let step_s = correlation::step(t).filter(|step| *step <= LONGEST_S * 1.02)?;
        if dof == 0 || t.len() < HIGH + SPARE {
            return None;
        }
        let nodes = Nodes::of(t, q, dof, step_s);
        let window = Window::new(&nodes, step_s);
        // Σ over joints: (q̈_4 − q̈_3)², and variances of both.
        let [mut apart, mut of_low, mut of_high] = [0.0; 3];
        let stride = nodes.len().div_ceil(LOOKED_AT).max(1);
        for node in (0..nodes.len()).step_by(stride) {
            let around = window.around(node);
            if !window.is_whole(node, &around) || nodes.are_still(&around) {
                continue;
            }
            let fit = |terms| Polynomials::fit(&nodes, node, around.clone(), window.half, terms);
            let (Some(low), Some(high)) = (fit(LOW), fit(HIGH)) else {
                continue;
            };
            for joint in 0..dof {
                let difference = high.gain(joint) - low.gain(joint);
                let variance = high.variance(joint);
                apart += difference * difference;
                of_low += variance * low.weight * low.weight;
                of_high += variance * high.weight * high.weight;
            }
        }
        let bias = (apart - (of_high - of_low)).max(0.0);
        Some(Plan {
            step_s,
            terms: if of_low + bias < of_high { LOW } else { HIGH },
        })
    }

    /// How far a window reaches to either side, s.
    pub fn reach_s(&self) -> f64 {
        Window::half(self.step_s) + 2.0 * NODE_S
    }

    /// The motion in some `rows` of a log, of whose neighbours `t` and `q` hold what windows
    /// reach; none where no joint moves by more than noise shows.
    pub fn motion(
        &self,
        t: &[f64],
        q: &[f64],
        dof: usize,
        rows: std::ops::Range<usize>,
    ) -> Option<Motion> {
        if is_still(q, dof) || rows.is_empty() {
            return None;
        }
        let nodes = Nodes::of(t, q, dof, self.step_s);
        let window = Window::new(&nodes, self.step_s);
        let moving = self.moving(&nodes, &window)?;
        let mut motion = Motion::default();
        let count = rows.len() * dof;
        for all in [&mut motion.rates, &mut motion.gains, &mut motion.gains_std] {
            all.reserve(count);
        }
        let mut at: Option<(usize, Local)> = None;
        for row in rows {
            let node = nodes.of_row[row];
            if at.as_ref().is_none_or(|(of, _)| *of != node) {
                at = Some((node, self.local(&nodes, &window, node)));
            }
            let (_, local) = at.as_ref().expect("set above");
            local.push(t[row] - nodes.t[node], &moving, &mut motion);
        }
        Some(motion)
    }

    /// Which joints move by more than noise shows; none where none does.
    fn moving(&self, nodes: &Nodes, window: &Window) -> Option<Vec<bool>> {
        let dof = nodes.dof;
        let (mut gains, mut noise) = (vec![0.0; dof], vec![0.0; dof]);
        let stride = nodes.len().div_ceil(LOOKED_AT / 4).max(1);
        for node in (0..nodes.len()).step_by(stride) {
            let around = window.around(node);
            if !window.is_whole(node, &around) || nodes.are_still(&around) {
                continue;
            }
            let Some(fit) = Polynomials::fit(nodes, node, around, window.half, self.terms) else {
                continue;
            };
            for joint in 0..dof {
                gains[joint] += fit.gain(joint).powi(2);
                noise[joint] += fit.variance(joint) * fit.weight * fit.weight;
            }
        }
        let pairs = gains.iter().zip(&noise);
        let moving: Vec<bool> = pairs
            .map(|(gain, noise)| *gain > MOVES * MOVES * noise)
            .collect();
        moving.contains(&true).then_some(moving)
    }

    fn local(&self, nodes: &Nodes, window: &Window, node: usize) -> Local {
        let around = window.around(node);
        if nodes.are_still(&around) && around.len() > 1 {
            return Local::Still;
        }
        let whole = window.is_whole(node, &around);
        let terms = if whole { self.terms } else { EDGE };
        match Polynomials::fit(nodes, node, around, window.half, terms) {
            Some(fit) => Local::Moving(fit, whole),
            None => Local::Unknown,
        }
    }
}

impl Motion {
    /// Leave out rows of `block` whose motion is not known; gives back how many.
    pub fn leave_out_unknown(&mut self, block: &mut Block) -> u64 {
        let keep = self.known.clone();
        block.retain(&keep);
        self.retain(&keep);
        (keep.len() - block.len()) as u64
    }

    fn retain(&mut self, keep: &[bool]) {
        let dof = self.dof();
        for all in [&mut self.rates, &mut self.gains, &mut self.gains_std] {
            let mut at = 0;
            all.retain(|_| {
                at += 1;
                keep[(at - 1) / dof]
            });
        }
        self.known.retain(|known| *known);
    }

    /// Add rows; those of a log that stands where there is none.
    pub fn extend(&mut self, other: Option<Motion>, rows: usize, dof: usize) {
        match other {
            Some(other) => {
                self.rates.extend(other.rates);
                self.gains.extend(other.gains);
                self.gains_std.extend(other.gains_std);
                self.known.extend(other.known);
            }
            None => {
                for all in [&mut self.rates, &mut self.gains, &mut self.gains_std] {
                    all.resize(all.len() + rows * dof, 0.0);
                }
                self.known.resize(self.known.len() + rows, true);
            }
        }
    }

    fn dof(&self) -> usize {
        (self.rates.len() / self.known.len().max(1)).max(1)
    }
}

/// Whether all rows are the same.
fn is_still(q: &[f64], dof: usize) -> bool {
    q.chunks_exact(dof).all(|row| *row == q[..dof])
}

/// Rows averaged over a few milliseconds.
struct Nodes {
    dof: usize,
    t: Vec<f64>,
    q: Vec<f64>,
    /// The node of each row.
    of_row: Vec<usize>,
    /// How often the rows had moved when a node began, and when it ended.
    moved: Vec<[usize; 2]>,
}

impl Nodes {
    fn of(t: &[f64], q: &[f64], dof: usize, step_s: f64) -> Nodes {
        let rows = ((NODE_S / step_s) as usize).max(1);
        let mut nodes = Nodes {
            dof,
            t: Vec::with_capacity(t.len() / rows + 1),
            q: Vec::with_capacity(q.len() / rows + dof),
            of_row: Vec::with_capacity(t.len()),
            moved: Vec::with_capacity(t.len() / rows + 1),
        };
        let (mut count, mut moved) = (0.0_f64, 0);
        for (row, &now) in t.iter().enumerate() {
            let own = &q[row * dof..(row + 1) * dof];
            let last = row.checked_sub(1);
            let step = last.map_or(f64::INFINITY, |last| now - t[last]);
            let joins = count > 0.0 && (count as usize) < rows && (0.0..=NODE_S).contains(&step);
            if last.is_some_and(|last| q[last * dof..row * dof] != *own) {
                moved += 1;
            }
            if !joins {
                count = 0.0;
                nodes.t.push(0.0);
                nodes.q.resize(nodes.q.len() + dof, 0.0);
                nodes.moved.push([moved; 2]);
            }
            count += 1.0;
            let node = nodes.t.len() - 1;
            nodes.of_row.push(node);
            nodes.moved[node][1] = moved;
            nodes.t[node] += (now - nodes.t[node]) / count;
            let mean = &mut nodes.q[node * dof..];
            for (mean, x) in mean.iter_mut().zip(own) {
                *mean += (x - *mean) / count;
            }
        }
        nodes
    }

    fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether nothing moves in all of some nodes.
    fn are_still(&self, around: &std::ops::Range<usize>) -> bool {
        self.moved[around.start][0] == self.moved[around.end - 1][1]
    }
}

struct Window<'a> {
    t: &'a [f64],
    half: f64,
    pause: f64,
}

impl<'a> Window<'a> {
    fn new(nodes: &'a Nodes, step_s: f64) -> Window<'a> {
        Window {
            t: &nodes.t,
            half: Window::half(step_s),
            pause: PAUSE * step_s.max(NODE_S),
        }
    }

    /// Stamps that jitter leave the outermost rows inside.
    fn half(step_s: f64) -> f64 {
        HALF_S.max(SIDE * step_s) * 1.02
    }

    /// Nodes around one without a pause.
    fn around(&self, node: usize) -> std::ops::Range<usize> {
        let here = self.t[node];
        let joins = |a: usize, b: usize| {
            let step = self.t[b] - self.t[a];
            (0.0..=self.pause).contains(&step)
        };
        let (mut first, mut last) = (node, node);
        while first > 0 && joins(first - 1, first) && here - self.t[first - 1] <= self.half {
            first -= 1;
        }
        while last + 1 < self.t.len()
            && joins(last, last + 1)
            && self.t[last + 1] - here <= self.half
        {
            last += 1;
        }
        first..last + 1
    }

    /// Whether nodes reach far enough to both sides.
    fn is_whole(&self, node: usize, around: &std::ops::Range<usize>) -> bool {
        let here = self.t[node];
        let spanned = SPANNED * self.half;
        here - self.t[around.start] >= spanned
            && self.t[around.end - 1] - here >= spanned
            && around.len() >= HIGH + SPARE
    }
}

/// What is known near a node.
enum Local {
    Still,
    /// With whether its window is whole.
    Moving(Polynomials, bool),
    Unknown,
}

impl Local {
    /// The row `after` seconds from the node; joints that are not `moving` stand.
    fn push(&self, after: f64, moving: &[bool], motion: &mut Motion) {
        for (joint, moves) in moving.iter().enumerate() {
            let [rate, gain, std] = match self {
                Local::Moving(fit, _) if *moves => fit.at(joint, after),
                _ => [0.0; 3],
            };
            motion.rates.push(rate);
            motion.gains.push(gain);
            motion.gains_std.push(std);
        }
        motion.known.push(match self {
            Local::Still => true,
            Local::Moving(_, whole) => *whole,
            Local::Unknown => false,
        });
    }
}

/// The polynomials of all joints about a node.
struct Polynomials {
    terms: usize,
    /// Joint by joint within each power.
    coefficients: Vec<f64>,
    /// What they leave of each joint: Σ e².
    left: Vec<f64>,
    /// Nodes beyond the coefficients.
    spare: f64,
    half: f64,
    /// Deviation of an acceleration for nodes of deviation one.
    weight: f64,
}

impl Polynomials {
    fn fit(
        nodes: &Nodes,
        node: usize,
        around: std::ops::Range<usize>,
        half: f64,
        terms: usize,
    ) -> Option<Polynomials> {
        let (dof, count) = (nodes.dof, around.len());
        if count < terms {
            return None;
        }
        let about = &nodes.q[node * dof..(node + 1) * dof];
        let mut normal = [[0.0; HIGH]; HIGH];
        let mut sums = vec![0.0; terms * dof];
        let mut left = vec![0.0; dof];
        for i in around {
            let s = (nodes.t[i] - nodes.t[node]) / half;
            let powers = [1.0, s, s * s, s * s * s, s * s * s * s];
            for a in 0..terms {
                for b in 0..terms {
                    normal[a][b] += powers[a] * powers[b];
                }
            }
            let own = &nodes.q[i * dof..(i + 1) * dof];
            for (m, sums) in sums.chunks_exact_mut(dof).enumerate() {
                for ((sum, x), origin) in sums.iter_mut().zip(own).zip(about) {
                    *sum += powers[m] * (x - origin);
                }
            }
            for ((sum, x), origin) in left.iter_mut().zip(own).zip(about) {
                *sum += (x - origin) * (x - origin);
            }
        }
        let inverse = inverse(normal, terms)?;
        let mut coefficients = vec![0.0; terms * dof];
        for (m, row) in coefficients.chunks_exact_mut(dof).enumerate() {
            for (k, sums) in sums.chunks_exact(dof).enumerate() {
                for (c, sum) in row.iter_mut().zip(sums) {
                    *c += inverse[m][k] * sum;
                }
            }
        }
        for (c, sum) in coefficients.chunks_exact(dof).zip(sums.chunks_exact(dof)) {
            for ((left, c), sum) in left.iter_mut().zip(c).zip(sum) {
                *left -= c * sum;
            }
        }
        Some(Polynomials {
            terms,
            coefficients,
            left,
            spare: (count - terms).max(1) as f64,
            half,
            weight: 2.0 / (half * half) * inverse[2][2].max(0.0).sqrt(),
        })
    }

    fn coefficient(&self, power: usize, joint: usize) -> f64 {
        let dof = self.left.len();
        match power < self.terms {
            true => self.coefficients[power * dof + joint],
            false => 0.0,
        }
    }

    /// Acceleration at the node.
    fn gain(&self, joint: usize) -> f64 {
        2.0 * self.coefficient(2, joint) / (self.half * self.half)
    }

    /// Variance of a node.
    fn variance(&self, joint: usize) -> f64 {
        self.left[joint].max(0.0) / self.spare
    }

    /// Velocity, acceleration and the deviation of that, `after` seconds from the node.
    fn at(&self, joint: usize, after: f64) -> [f64; 3] {
        let (s, h) = (after / self.half, self.half);
        let c = |power| self.coefficient(power, joint);
        let rate = c(1) + s * (2.0 * c(2) + s * (3.0 * c(3) + s * 4.0 * c(4)));
        let gain = 2.0 * c(2) + s * (6.0 * c(3) + s * 12.0 * c(4));
        let std = self.variance(joint).sqrt() * self.weight;
        [rate / h, gain / (h * h), std]
    }
}

/// The inverse of the leading block of a positive definite matrix; none of another.
fn inverse(mut a: [[f64; HIGH]; HIGH], n: usize) -> Option<[[f64; HIGH]; HIGH]> {
    let mut b = [[0.0; HIGH]; HIGH];
    (0..n).for_each(|k| b[k][k] = 1.0);
    for k in 0..n {
        let pivot = a[k][k];
        if pivot.is_nan() || pivot <= 1e-9 * (n as f64) {
            return None;
        }
        for c in 0..n {
            a[k][c] /= pivot;
            b[k][c] /= pivot;
        }
        let (row_a, row_b) = (a[k], b[k]);
        for r in (0..n).filter(|r| *r != k) {
            let factor = a[r][k];
            for c in 0..n {
                a[r][c] -= factor * row_a[c];
                b[r][c] -= factor * row_b[c];
            }
        }
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint that swings, with stamps that jitter by a third of an interval.
    fn swing(interval: f64, seconds: f64, hertz: f64) -> (Vec<f64>, Vec<f64>) {
        let count = (seconds / interval) as usize;
        let jitter = |k: usize| 0.33 * interval * (12.9 * k as f64).sin();
        let t: Vec<f64> = (0..count)
            .map(|k| k as f64 * interval + jitter(k))
            .collect();
        let q = t
            .iter()
            .map(|t| 0.3 * (std::f64::consts::TAU * hertz * t).sin());
        let q = q.collect();
        (t, q)
    }

    /// Uniform noise of deviation `std` from a fixed sequence.
    fn noise(count: usize, std: f64) -> Vec<f64> {
        let mut state = 1_u64;
        let mut draw = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * std * 12_f64.sqrt()
        };
        (0..count).map(|_| draw()).collect()
    }

    fn rms(x: &[f64]) -> f64 {
        (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
    }

    #[test]
    fn a_swing_is_differentiated_on_jittering_stamps() {
        // Worst errors, relative: 1 kHz down to 5 Hz.
        for (step, hertz, within) in [
            (0.001, 1.0, 0.012),
            (0.01, 1.0, 0.01),
            (0.05, 0.5, 0.01),
            (0.1, 0.3, 0.02),
            (0.2, 0.1, 0.02),
        ] {
            let (t, q) = swing(step, 200.0 * step + 4.0 / hertz, hertz);
            let plan = Plan::of(&t, &q, 1).unwrap();
            let motion = plan.motion(&t, &q, 1, 0..t.len()).unwrap();
            let known = motion.known.iter().filter(|known| **known).count();
            assert!(known as f64 > 0.85 * t.len() as f64, "{known} of {step}");
            let w = std::f64::consts::TAU * hertz;
            for (k, t) in t.iter().enumerate().filter(|(k, _)| motion.known[*k]) {
                let off = (motion.gains[k] + 0.3 * w * w * (w * t).sin()).abs();
                assert!(off < within * 0.3 * w * w, "{step} s: {off}");
                let off = (motion.rates[k] - 0.3 * w * (w * t).cos()).abs();
                assert!(off < within * 0.3 * w, "{step} s: {off}");
            }
        }
    }

    #[test]
    fn logs_with_long_intervals_know_no_accelerations() {
        let (t, q) = swing(0.5, 60.0, 0.2);
        assert_eq!(Plan::of(&t, &q, 1), None);
        assert_eq!(Plan::of(&[0.0, 0.01, 0.02], &[0.0, 0.1, 0.2], 1), None);
        // Rows within the interval whose motion is far faster than they show.
        let (t, _) = swing(0.1, 60.0, 0.2);
        let q = noise(t.len(), 0.3);
        let plan = Plan::of(&t, &q, 1).unwrap();
        assert_eq!(plan.motion(&t, &q, 1, 0..t.len()), None);
    }

    /// Rows at the ends and beside a pause have no window, unless the robot stands there.
    #[test]
    fn edges_have_no_window_unless_the_robot_stands() {
        let mut t: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
        t.iter_mut().skip(100).for_each(|t| *t += 5.0);
        let q: Vec<f64> = t
            .iter()
            .enumerate()
            .map(|(k, t)| if k < 100 { (3.0 * t).sin() } else { 0.1 })
            .collect();
        let plan = Plan::of(&t, &q, 1).unwrap();
        let motion = plan.motion(&t, &q, 1, 0..t.len()).unwrap();
        for (row, known) in motion.known.iter().enumerate() {
            let whole = row >= 100 || row.min(99 - row) >= 9;
            assert_eq!(*known, whole, "row {row}");
        }
        assert!(motion.gains[100..].iter().all(|gain| *gain == 0.0));
        let still = vec![0.1; t.len()];
        assert_eq!(plan.motion(&t, &still, 1, 0..t.len()), None);
    }

    /// The stated deviation of an acceleration is what noise of the encoders makes of it, and a
    /// slow swing in such noise is taken by order 3.
    #[test]
    fn deviations_are_those_of_the_noise() {
        let (t, slow) = swing(0.01, 60.0, 0.25);
        let noise = noise(t.len(), 1e-3);
        let pairs = slow.iter().zip(&noise);
        let q: Vec<f64> = pairs.map(|(a, b)| a + b).collect();
        let plan = Plan::of(&t, &q, 1).unwrap();
        assert_eq!(plan.terms, LOW);
        let motion = plan.motion(&t, &q, 1, 100..t.len() - 100).unwrap();
        let w = std::f64::consts::TAU * 0.25;
        let off: Vec<f64> = motion
            .gains
            .iter()
            .zip(&t[100..])
            .map(|(gain, t)| gain + 0.3 * w * w * (w * t).sin())
            .collect();
        let ratio = rms(&off) / rms(&motion.gains_std);
        assert!((0.85..1.15).contains(&ratio), "{ratio}");
        // Noise alone moves no joint.
        assert_eq!(plan.motion(&t, &noise, 1, 0..t.len()), None);
    }
}
