//! A sensor whose axes are exchanged, mirrored, or turned about the normal of the sole.
//!
//! ```text
//! y = c + T p(q)        T = R(ψ)  or  T = R(ψ) diag(1, −1) with ψ a multiple of 90°
//! ```
//!
//! A diagnosis fits such a `T` beside all else that may be missing. A fit of masses does not,
//! and takes it for masses: it asks here first, and goes on unless `T` is far likelier than
//! CAD, every wiring, and free masses of CAD's axes.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{DMatrix, DVector};

use super::criteria::{ENOUGH, LEAST_YAW, MASSES_LEAVE, RIGHT_ANGLE, TURNED_LEAVES, TURNED_SHOWS};
use super::statistics::{axis, mean, rms_of};
use super::wirings::Wirings;
use super::{Finding, Kind, Look};
use crate::observations::correlation;
use crate::observations::postures::rms;
use crate::observations::rows::CopRows;

/// Postures that free masses are fitted to, at most.
const FITTED: usize = 400;

/// How a sensor's axes lie in the sole.
#[derive(Debug, Clone, Copy)]
struct Turn {
    /// About the normal, rad.
    yaw: f64,
    /// The y axis points the other way before that.
    mirrored: bool,
    /// Quarters of a turn, where it is so many exactly.
    quarters: Option<u8>,
}

/// Axes of the sensor with which CAD predicts the readings, and as they stand does not.
pub(super) fn turned(look: &Look, wirings: &Wirings) -> Option<Finding> {
    let data = look.data;
    if data.len() < ENOUGH {
        return None;
    }
    let [x, y] = [0, 1].map(|k| centred(&data.reading, k));
    let [px, py] = [0, 1].map(|k| centred(&look.predicted, k));
    let noise = rms([0, 1].map(|k| rms_of(&look.std, k)).into_iter());
    let left = |turn: &Turn| {
        let gap = |k: usize| {
            let [u, v] = turn.reading([px[k], py[k]]);
            [x[k] - u, y[k] - v]
        };
        rms((0..data.len()).flat_map(gap))
    };
    let turns = [false, true].into_iter().filter_map(|mirrored| {
        let py: Vec<f64> = match mirrored {
            true => py.iter().map(|y| -y).collect(),
            false => py.clone(),
        };
        Turn::of(
            along(&x, &px) + along(&y, &py),
            along(&y, &px) - along(&x, &py),
            mirrored,
        )
    });
    let all = turns.map(|turn| (left(&turn), turn));
    let (turned, turn) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
    // What noise leaves is no part of the comparison.
    let beyond = |left: f64| (left * left - noise * noise).max(0.0).sqrt();
    let as_well = |straight: f64| {
        beyond(turned) > TURNED_LEAVES * beyond(straight) || straight < TURNED_SHOWS * noise
    };
    if wirings.upright(as_well) {
        return None;
    }
    // Masses that are all negative explain half a turn; no robot has them.
    if !turn.is_half() {
        let [as_read, back] = left_by_masses(look, &turn)?;
        if as_read < MASSES_LEAVE * back {
            return None;
        }
    }
    let tree = &look.model.tree;
    let support = &tree.links[tree.support].name;
    let here = rms(x
        .iter()
        .zip(&px)
        .chain(y.iter().zip(&py))
        .map(|(y, p)| y - p));
    let (what, remedy) = turn.words();
    let sentence = format!(
        "The readings are {:.1} mm off in the axes of `{support}` and {:.1} mm where {what}, \
         wherever the sensor's zero is, and masses do not explain it: {remedy}.",
        1e3 * here,
        1e3 * turned
    );
    let zero = [0, 1].map(|k| mean(&axis(&data.reading, k)));
    let cop = |k: usize| {
        let [u, v] = turn.reading([px[k], py[k]]);
        [zero[0] + u, zero[1] + v]
    };
    let cop: Vec<f64> = (0..data.len()).flat_map(cop).collect();
    let picture = look.distances(&cop, [turn.mark(), "axes of the support"]);
    Some(Finding::new(Kind::FrameTurned, support, sentence).showing(picture))
}

/// What free masses and any zero of the sensor leave of the readings as they stand, and turned
/// back, m; none where too few postures tell.
fn left_by_masses(look: &Look, turn: &Turn) -> Option<[f64; 2]> {
    let (data, model) = (look.data, look.model);
    let dof = model.dof();
    let stride = data.len().div_ceil(FITTED).max(1);
    let chosen: Vec<usize> = (0..data.len()).step_by(stride).collect();
    let q = chosen.iter().flat_map(|k| &data.q[k * dof..(k + 1) * dof]);
    let q: Vec<f64> = q.copied().collect();
    let of_masses = CopRows::new(model).fastest().of(&q, chosen.len(), None);
    let columns = of_masses.ncols();
    let x = DMatrix::from_fn(2 * chosen.len(), columns + 2, |row, column| {
        match column.checked_sub(columns) {
            None => of_masses[(row, column)],
            Some(axis) => f64::from(u8::from(row % 2 == axis)),
        }
    });
    let reading = |k: usize| [data.reading[2 * k], data.reading[2 * k + 1]];
    let left = |of: &dyn Fn([f64; 2]) -> [f64; 2]| {
        let y = chosen.iter().flat_map(|k| of(reading(*k)));
        let y = DVector::from_iterator(2 * chosen.len(), y);
        let (square, df) = correlation::left(&x, &y);
        (df >= ENOUGH as f64).then(|| square.sqrt())
    };
    Some([left(&|y| y)?, left(&|y| turn.back(y))?])
}

fn centred(values: &[f64], k: usize) -> Vec<f64> {
    let own = axis(values, k);
    let middle = mean(&own);
    own.iter().map(|x| x - middle).collect()
}

fn along(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Turn {
    /// The turn whose cosine and sine are as these are; none that is as good as none, and no
    /// mirror but one along the axes or the diagonals.
    fn of(cosine: f64, sine: f64, mirrored: bool) -> Option<Turn> {
        let yaw = sine.atan2(cosine);
        let whole = (yaw / FRAC_PI_2).round();
        let right = (yaw - whole * FRAC_PI_2).abs() < RIGHT_ANGLE;
        // −2 and 2 quarters are the same.
        let quarters = right.then(|| whole.rem_euclid(4.0) as u8);
        let yaw = quarters.map_or(yaw, |n| f64::from(n) * FRAC_PI_2);
        let turn = Turn {
            yaw,
            mirrored,
            quarters,
        };
        match (mirrored, quarters) {
            (false, Some(0)) | (true, None) => None,
            (false, None) if yaw.abs() < LEAST_YAW => None,
            _ => Some(turn),
        }
    }

    /// Whether both axes point the other way.
    fn is_half(&self) -> bool {
        !self.mirrored && self.quarters == Some(2)
    }

    /// What the sensor reads of a CoP.
    fn reading(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let y = if self.mirrored { -y } else { y };
        let (sine, cosine) = self.yaw.sin_cos();
        [cosine * x - sine * y, sine * x + cosine * y]
    }

    /// The CoP of a reading.
    fn back(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = self.yaw.sin_cos();
        let (x, y) = (cosine * x + sine * y, cosine * y - sine * x);
        [x, if self.mirrored { -y } else { y }]
    }

    /// What CAD's CoP is drawn as.
    fn mark(&self) -> &'static str {
        match (self.mirrored, self.quarters) {
            (true, Some(1 | 3)) => "axes exchanged",
            (true, _) => "an axis the other way",
            (false, _) => "turned",
        }
    }

    /// Where CAD predicts the readings, and what to do.
    fn words(&self) -> (String, String) {
        let cop = |x: &str, y: &str| {
            format!("the CoP is x = {x}, y = {y}; write the log so, or place the cells so")
        };
        let (what, remedy) = match (self.mirrored, self.quarters) {
            (false, Some(1)) => ("the sensor is turned by 90°", cop("cop_y", "−cop_x")),
            (false, Some(2)) => ("the sensor is turned by 180°", cop("−cop_x", "−cop_y")),
            (false, Some(3)) => ("the sensor is turned by −90°", cop("−cop_y", "cop_x")),
            (true, Some(0)) => ("its y axis points the other way", cop("cop_x", "−cop_y")),
            (true, Some(1)) => ("x and y are exchanged", cop("cop_y", "cop_x")),
            (true, Some(2)) => ("its x axis points the other way", cop("−cop_x", "cop_y")),
            (true, _) => ("x is −y and y is −x", cop("−cop_y", "−cop_x")),
            (false, _) => {
                let degrees = self.yaw.to_degrees();
                return (
                    format!("the sensor is turned by {degrees:.0}° about the normal of the sole"),
                    format!(
                        "turn the CoP of the log, or the places of the cells, by {:.0}°, or run a \
                         diagnosis, which finds the angle",
                        -degrees
                    ),
                );
            }
        };
        (what.to_string(), remedy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of the eight ways that axes can lie along each other.
    #[test]
    fn what_is_turned_is_turned_back() {
        for mirrored in [false, true] {
            for quarters in 0..4_u8 {
                let yaw = f64::from(quarters) * FRAC_PI_2;
                let Some(turn) = Turn::of(yaw.cos(), yaw.sin(), mirrored) else {
                    assert!(!mirrored && quarters == 0);
                    continue;
                };
                assert_eq!(turn.quarters, Some(quarters));
                let [x, y] = turn.back(turn.reading([0.3, -0.7]));
                assert!((x - 0.3).abs() < 1e-12 && (y + 0.7).abs() < 1e-12);
            }
        }
        assert!(Turn::of(1.0, 0.2, false).is_none());
        assert!(Turn::of(1.0, 0.5, true).is_none());
        assert!(Turn::of(1.0, 0.5, false).is_some());
        let [x, y] = Turn::of(0.0, -1.0, true).unwrap().reading([0.3, -0.7]);
        assert!((x - 0.7).abs() < 1e-12 && (y + 0.3).abs() < 1e-12);
    }
}
