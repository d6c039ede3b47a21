//! How residuals are spread: over their size, and over the sole.

use super::super::problem::Problem;
use super::Residuals;
use crate::observations::postures::{range, rms};

/// Residuals are counted from −EDGE to EDGE, in units of noise.
pub const EDGE: f64 = 6.0;
/// Bins between.
const BINS: usize = 24;
/// Squares along the longer side of the map.
const SQUARES: f64 = 8.0;

/// Whitened residuals, counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Readings per bin before.
    pub before: Vec<usize>,
    /// Readings per bin after.
    pub after: Vec<usize>,
    /// Beyond the edges, before and after.
    pub beyond: [usize; 2],
    /// RMS before and after; outliers in neither.
    pub rms: [f64; 2],
    /// Readings that are counted.
    pub count: usize,
}

impl Spread {
    pub(super) fn of(problem: &Problem, residuals: &Residuals) -> Spread {
        let counted = |errors: &[f64]| {
            let (mut bins, mut beyond) = (vec![0; BINS], 0);
            for (error, weight) in errors.iter().zip(problem.first().inverse_noise()) {
                let place = (error * weight + EDGE) / (2.0 * EDGE) * BINS as f64;
                match (0.0..BINS as f64).contains(&place) {
                    true => bins[place as usize] += 1,
                    false => beyond += 1,
                }
            }
            let entries = errors.iter().zip(problem.first().inverse_noise());
            let kept = entries
                .enumerate()
                .filter(|(row, _)| !residuals.outlier[row / 2]);
            (bins, beyond, rms(kept.map(|(_, (e, w))| e * w)))
        };
        let before = counted(&residuals.before);
        let after = counted(&residuals.after);
        Spread {
            before: before.0,
            after: after.0,
            beyond: [before.1, after.1],
            rms: [before.2, after.2],
            count: residuals.before.len(),
        }
    }
}

/// Residuals in one square of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Corner nearest to the origin of the map, m.
    pub corner: [f64; 2],
    /// Postures with readings in it.
    pub postures: usize,
    /// RMS in units of noise, before and after.
    pub rms: [f64; 2],
}

/// Squares of the sole in which readings lie; outliers apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Regions {
    /// Side of a square, m.
    pub side: f64,
    /// The squares that hold readings.
    pub squares: Vec<Region>,
}

impl Regions {
    pub(super) fn of(problem: &Problem, residuals: &Residuals) -> Regions {
        let reading = &problem.data().reading;
        let kept: Vec<usize> = (0..problem.data().len())
            .filter(|&k| !residuals.outlier[k])
            .collect();
        let ends = [0, 1].map(|axis| {
            let ends = range(kept.iter().map(|k| reading[2 * k + axis]));
            [ends.0, ends.1]
        });
        let longest = ends
            .iter()
            .map(|[low, high]| high - low)
            .fold(1e-3, f64::max);
        let side = longest / SQUARES;
        let counts = ends.map(|[low, high]| ((high - low) / side).ceil().max(1.0) as usize);
        let mut members = vec![Vec::new(); counts[0] * counts[1]];
        for &k in &kept {
            // The far end belongs to the last square.
            let [i, j] = [0, 1].map(|axis| {
                let place = (reading[2 * k + axis] - ends[axis][0]) / side;
                (place as usize).min(counts[axis] - 1)
            });
            members[i * counts[1] + j].push(k);
        }
        let squares = members
            .iter()
            .enumerate()
            .filter(|(_, own)| !own.is_empty());
        let weights: Vec<f64> = problem.first().inverse_noise().collect();
        let region = |(place, own): (usize, &Vec<usize>)| {
            let rows = || own.iter().flat_map(|&k| [2 * k, 2 * k + 1]);
            let of = |errors: &[f64]| rms(rows().map(|row| errors[row] * weights[row]));
            Region {
                corner: [
                    ends[0][0] + side * (place / counts[1]) as f64,
                    ends[1][0] + side * (place % counts[1]) as f64,
                ],
                postures: own.len(),
                rms: [of(&residuals.before), of(&residuals.after)],
            }
        };
        Regions {
            side,
            squares: squares.map(region).collect(),
        }
    }
}
