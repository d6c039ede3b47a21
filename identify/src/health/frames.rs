//! Readings of another frame than the log says, of turned axes, or of other rows.
//!
//! ```text
//! p_link(q) ≈ y        or        (R CoM(q))_xy ≈ y,  R e_z ≠ ± e_z by right angles
//! ```
//!
//! # Axes
//!
//! The axes of a sensor may be exchanged, mirrored, or turned about the normal of the sole:
//!
//! ```text
//! y = c + T p(q)        T = R(ψ)  or  T = R(ψ) diag(1, −1) with ψ a multiple of 90°
//! ```
//!
//! A diagnosis fits such a `T` beside all else that may be missing. A fit of masses does not,
//! and takes it for masses: it asks here first, and goes on unless `T` is far likelier than
//! CAD, every wiring, and free masses of CAD's axes.
//!
//! # Columns
//!
//! A column of the CoP may show nothing, or readings of other postures than those they stand beside.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{DMatrix, DVector, Matrix3};
use sesc_model::tree::{like_sole, sole_parts};
use sesc_model::{Function, Model};

use super::criteria::{
    ALIKE, BETTER, BY_MASSES, ENOUGH, EXCHANGED, FAR_M, FITS, LEAST_YAW, MOVES_M, MUST_MOVE,
    RIGHT_ANGLE, SHOWS, SILENT_ROWS, STILL, TURNED_SHOWS,
};
use super::wirings::{Wirings, axis, centred, correlation, dot, gap, mean, rms_of, scatter};
use super::{Finding, Kind, Look};
use crate::evaluate::Evaluator;
use crate::observations::correlation;
use crate::observations::noise::NoiseSource;
use crate::observations::postures::{Postures, rms};

/// Another link, or other axes of this one, that the readings fit.
pub(super) fn wrong(look: &Look, wirings: &Wirings) -> Option<Finding> {
    let here = look.gap();
    if here < FAR_M {
        return None;
    }
    let support = look.model.support();
    let frame = another_up(look)?;
    let fits = |left: f64| left < FITS * here;
    let foot = other_foot(look).filter(|foot| fits(foot.left) && foot.left <= frame.left);
    if foot.is_none() && !fits(frame.left) {
        return None;
    }
    let by_wirings = match &foot {
        Some(foot) => wirings.left_on(&foot.model),
        None => wirings.left(frame.flat),
    };
    // A wiring of the robot as the log has it explains them as well.
    if wirings.left([0, 1]) < BETTER * by_wirings {
        return None;
    }
    if let Some(Foot {
        left, link, cop, ..
    }) = foot
    {
        let sentence = format!(
            "The readings are {:.0} mm off on `{support}` and {:.1} mm on `{link}`: the \
             robot stood on `{link}`; give that support.",
            1e3 * here,
            1e3 * left
        );
        let marks = [&*format!("on {link}"), &*format!("on {support}")];
        let picture = look.distances(&cop, marks);
        return Some(Finding::new(Kind::OtherFoot, &link, sentence).showing(picture));
    }
    let (axis, down) = frame.up;
    let sentence = format!(
        "The readings are {:.0} mm off in the frame of `{support}` and {:.1} mm where \
         its {axis} axis points {}: its z axis is not the normal of the sole; \
         give a sole link as support.",
        1e3 * here,
        1e3 * frame.left,
        if down { "down" } else { "up" }
    );
    let picture = look.distances(&frame.cop, ["with another axis up", "in this frame"]);
    Some(Finding::new(Kind::FrameTurned, support, sentence).showing(picture))
}

/// Another link that the readings may be of.
struct Foot {
    /// Gap to the readings, m.
    left: f64,
    link: String,
    model: Model,
    /// CoP by CAD on it, m.
    cop: Vec<f64>,
}

/// Another frame of the support that the readings may be in.
struct Frame {
    /// Gap to the readings, m.
    left: f64,
    /// Axes that lie in the sole.
    flat: [usize; 2],
    /// The axis of the support that points up, and whether it points down instead.
    up: (&'static str, bool),
    /// CoP by CAD in it, m.
    cop: Vec<f64>,
}

/// Another link that carries no joint, which the readings fit best.
fn other_foot(look: &Look) -> Option<Foot> {
    let tree = &look.model.tree;
    let support = &tree.links[tree.support].name;
    let description = &look.on.robot.description;
    // Links that carry no joint: feet, hands, the head.
    let carries = |link: &str| description.joints.iter().any(|joint| joint.parent == link);
    let leaves = description.links.iter().map(|link| &link.name);
    let leaves = leaves.filter(|link| !carries(link)).map(|link| {
        if tree.by_height {
            like_sole(support, link)
        } else {
            link.clone()
        }
    });
    let leaves = leaves.filter(|link| link != support);
    let on = |link: String| {
        let model = look.on.robot.model(&link, look.on.snapping, None).ok()?;
        let cop = Evaluator::new(&model, Function::Cop).run(&look.data.q, look.data.len());
        let left = gap(look.data, &cop);
        Some(Foot {
            left,
            link,
            model,
            cop,
        })
    };
    let feet = leaves.take(64).filter_map(on);
    feet.min_by(|a, b| a.left.total_cmp(&b.left))
}

/// The frame, turned by right angles, that the readings fit best.
fn another_up(look: &Look) -> Option<Frame> {
    // The sole of a link is moved along the link's z: another axis points up from the link itself.
    let height = match sole_parts(look.model.support()) {
        Some(Ok((_, height))) if look.model.tree.by_height => height,
        _ => 0.0,
    };
    let frames = axes_with_another_up().into_iter().map(|(axes, flat)| {
        let row = |c: &[f64], k: usize| -> f64 {
            let at = [c[0], c[1], c[2] - height];
            (0..3).map(|m| axes[(k, m)] * at[m]).sum()
        };
        let up = (0..3).find(|m| axes[(2, *m)] != 0.0).unwrap_or(2);
        let up = (["x", "y", "z"][up], axes[(2, up)] < 0.0);
        let com = look.com.chunks_exact(3);
        let cop: Vec<f64> = com.flat_map(|c| [row(c, 0), row(c, 1)]).collect();
        let left = gap(look.data, &cop);
        Frame {
            left,
            flat,
            up,
            cop,
        }
    });
    frames.min_by(|a, b| a.left.total_cmp(&b.left))
}

/// Rotations by right angles after which another axis than z is vertical, and the axes that
/// lie in the plane then.
fn axes_with_another_up() -> Vec<(Matrix3<f64>, [usize; 2])> {
    let mut found = Vec::new();
    for (x, y, z) in [(0, 2, 1), (1, 2, 0), (2, 0, 1), (2, 1, 0)] {
        for signs in 0..8 {
            let sign = |bit: usize| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let mut axes = Matrix3::zeros();
            axes[(0, x)] = sign(0);
            axes[(1, y)] = sign(1);
            axes[(2, z)] = sign(2);
            if axes.determinant() > 0.0 {
                found.push((axes, [x, y]));
            }
        }
    }
    found
}

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
    let [x, y] = [0, 1].map(|k| centred(&axis(&data.reading, k)));
    let [px, py] = [0, 1].map(|k| centred(&axis(&look.predicted, k)));
    let noise = rms([0, 1].map(|k| rms_of(&look.std, k)).into_iter());
    let left = |turn: &Turn| {
        let gap = |k: usize| {
            let [u, v] = turn.reading([px[k], py[k]]);
            [x[k] - u, y[k] - v]
        };
        rms((0..data.len()).flat_map(gap))
    };
    let turns = [false, true].into_iter().filter_map(|mirrored| {
        let sign = if mirrored { -1.0 } else { 1.0 };
        let py: Vec<f64> = py.iter().map(|y| sign * y).collect();
        Turn::of(
            dot(&x, &px) + dot(&y, &py),
            dot(&y, &px) - dot(&x, &py),
            mirrored,
        )
    });
    let all = turns.map(|turn| (left(&turn), turn));
    let (turned, turn) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
    // What noise leaves is no part of the comparison.
    let beyond = |left: f64| (left * left - noise * noise).max(0.0).sqrt();
    let as_well = |straight: f64| {
        beyond(turned) > BETTER * beyond(straight) || straight < TURNED_SHOWS * noise
    };
    if wirings.upright(as_well) {
        return None;
    }
    // Masses that are all negative explain half a turn; no robot has them.
    if !turn.is_half() {
        let [as_read, back] = left_by_masses(look, &turn)?;
        if as_read < BY_MASSES * back {
            return None;
        }
    }
    let support = look.model.support();
    let gaps = x.iter().zip(&px).chain(y.iter().zip(&py));
    let here = rms(gaps.map(|(y, p)| y - p));
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
    let data = look.data;
    let (chosen, of_masses) = look.rows_of_masses(400);
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

/// Axes of the sensor that do not move where CAD moves them, whatever the wiring.
pub(super) fn dead_axes(look: &Look, wirings: &Wirings) -> Option<Finding> {
    let dead: Vec<usize> = (0..2).filter(|&k| is_dead(look, wirings, k)).collect();
    let millimetres = |k: usize| 1e3 * scatter(&axis(&look.predicted, k));
    let name = |k: usize| ["x", "y"][k];
    match dead[..] {
        [] => None,
        [k] => {
            let sentence = format!(
                "cop_{} does not move with the robot, where CAD moves it by {:.1} mm RMS: check \
                 the sensor's wiring and the column.",
                name(k),
                millimetres(k)
            );
            let finding = Finding::new(Kind::CopAxisDead, name(k), sentence);
            Some(finding.showing(look.beside_cad(k)))
        }
        _ => {
            let sentence = format!(
                "The CoP does not move with the robot, where CAD moves it by {:.1} mm RMS: check \
                 that the sensor is on and that its topic is the right one.",
                rms([millimetres(0), millimetres(1)].into_iter())
            );
            // The axis that should move more shows it best.
            let axis = usize::from(millimetres(1) > millimetres(0));
            let finding = Finding::new(Kind::CopConstant, "-", sentence);
            Some(finding.showing(look.beside_cad(axis)))
        }
    }
}

/// Whether an axis does not move at all.
pub(super) fn is_constant(data: &Postures) -> bool {
    (0..2).any(|k| scatter(&axis(&data.reading, k)) < STILL)
}

fn is_dead(look: &Look, wirings: &Wirings, k: usize) -> bool {
    let data = look.data;
    if data.len() < 3 {
        return false;
    }
    let [read, other] = [k, 1 - k].map(|k| axis(&data.reading, k));
    let [cad, across] = [k, 1 - k].map(|k| axis(&look.predicted, k));
    let moves = scatter(&read);
    let constant = moves < STILL;
    let least = if constant { MOVES_M } else { MUST_MOVE * moves };
    if scatter(&cad) <= least || !constant && data.len() < SILENT_ROWS {
        return false;
    }
    // Where the axes are exchanged, this one shows what CAD says of the other.
    let [own, exchanged] = [&across, &cad].map(|cad| correlation(&other, cad).abs());
    let exchanged = exchanged > EXCHANGED && exchanged > own;
    !exchanged && wirings.least_scatter(k) > least && (constant || !wirings.relates(k))
}

/// Readings that scatter as CAD says and go with no posture, whatever the wiring.
pub(super) fn shuffled(look: &Look, wirings: &Wirings) -> Option<Finding> {
    let data = look.data;
    let as_cad = (0..2).all(|k| {
        let (read, cad) = (axis(&data.reading, k), axis(&look.predicted, k));
        let ratio = scatter_of_rows(look, k, scatter(&read)) / scatter(&cad);
        let near = (mean(&read) - mean(&cad)).abs() < scatter(&cad);
        let moves = scatter(&cad) > SHOWS * rms_of(&look.std, k);
        (ALIKE.0..ALIKE.1).contains(&ratio) && near && moves
    });
    let relates = || (0..2).any(|k| wirings.relates(k));
    let broken = data.len() >= ENOUGH && as_cad && !relates();
    broken.then(|| {
        Finding::new(
            Kind::RowsShuffled,
            "-",
            "Readings scatter as CAD says and go with no posture: rows of the CoP and of the \
             joints do not belong together; check how they were joined."
                .to_string(),
        )
        .showing(look.beside_cad(0))
    })
}

/// Scatter of single readings: where postures were repeated, shuffled rows scatter within a
/// posture, and their means hardly.
fn scatter_of_rows(look: &Look, k: usize, of_means: f64) -> f64 {
    let data = look.data;
    let within = match data.noise_source {
        NoiseSource::Repeats => data.rows_per_posture.sqrt() * rms_of(&look.std, k),
        _ => 0.0,
    };
    of_means.hypot(within)
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
