//! What is known near a node, and how well encoders are read.

use super::Motion;
use super::polynomials::Polynomials;

/// What a window leaves of the noise of its own row at least, as a part.
const LEAST_LEFT: f64 = 0.2;

/// What rows leave of the polynomials of their windows.
pub(super) struct PositionNoise {
    /// Rows averaged to a node.
    rows: f64,
    /// Σ e² of each joint, over what a fit leaves of noise of variance one.
    squares: Vec<f64>,
    count: f64,
}

impl PositionNoise {
    pub fn new(dof: usize, rows: usize) -> PositionNoise {
        PositionNoise {
            rows: rows as f64,
            squares: vec![0.0; dof],
            count: 0.0,
        }
    }

    /// Row `q`, `after` seconds from a node at `origin`.
    pub fn add(&mut self, fit: &Polynomials, after: f64, q: &[f64], origin: impl Fn(usize) -> f64) {
        let left = (1.0 - fit.own / self.rows).max(LEAST_LEFT);
        for (joint, square) in self.squares.iter_mut().enumerate() {
            let off = q[joint] - origin(joint) - fit.position(joint, after);
            *square += off * off / left;
        }
        self.count += 1.0;
    }

    /// Add what other rows show.
    pub fn merge(&mut self, other: &PositionNoise) {
        for (sum, more) in self.squares.iter_mut().zip(&other.squares) {
            *sum += more;
        }
        self.count += other.count;
    }

    /// Standard deviation of each row and joint; joints that stand there have accelerations
    /// without deviation.
    pub fn of_rows(&self, gains_std: &[f64]) -> Vec<f64> {
        let std = self.squares.iter().map(|sum| match self.count > 0.0 {
            true => (sum / self.count).sqrt(),
            false => 0.0,
        });
        let std: Vec<f64> = std.collect();
        let rows = gains_std.iter().enumerate();
        rows.map(|(k, gain)| if *gain > 0.0 { std[k % std.len()] } else { 0.0 })
            .collect()
    }
}

/// What is known near a node.
pub(super) enum Local {
    Still,
    /// With whether its window is whole.
    Moving(Polynomials, bool),
    Unknown,
}

impl Local {
    /// The row `after` seconds from the node, which is the mean of so many `rows`; joints that are
    /// not `moving` stand, and accelerations of the others are multiplied by `unbend`.
    pub fn push(
        &self,
        after: f64,
        rows: f64,
        (moving, unbend): (&[Option<f64>], &[f64]),
        motion: &mut Motion,
    ) {
        let (first, all) = (motion.rates.len(), motion.rates.len() + moving.len());
        for column in [
            &mut motion.rates,
            &mut motion.gains,
            &mut motion.gains_std,
            &mut motion.with_positions,
        ] {
            column.resize(all, 0.0);
        }
        if let Local::Moving(fit, _) = self {
            let own = first..all;
            fit.rates(after, &mut motion.rates[own.clone()]);
            fit.gains(after, &mut motion.gains[own.clone()]);
            fit.gains_std(moving, &mut motion.gains_std[own.clone()]);
            motion.with_positions[own].fill(fit.with_own / rows.sqrt());
            for (joint, (variance, unbend)) in moving.iter().zip(unbend).enumerate() {
                motion.gains[first + joint] *= unbend;
                motion.gains_std[first + joint] *= unbend;
                if variance.is_none() {
                    motion.rates[first + joint] = 0.0;
                    motion.gains[first + joint] = 0.0;
                }
            }
        }
        motion.known.push(match self {
            Local::Still => true,
            Local::Moving(_, whole) => *whole,
            Local::Unknown => false,
        });
    }
}
