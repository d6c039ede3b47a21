//! What may be wrong with a log, beside all that a diagnosis knows and names.
//!
//! Each hypothesis changes what CAD predicts, or the readings, and leaves some of these:
//!
//! ```text
//! fault            what it does                                     unknowns
//! other_foot       p ← CAD on another link that carries no joint    –
//! frame_turned     p ← CAD with another axis up, by right angles    –
//! frame_turned     p ← T p: axes that are exchanged, mirrored or    the sensor's zero, the angle
//!                  turned about the normal of the sole (fits)
//! encoder_stuck    p ← p(q + δ_k e_j)                               δ_k, one a posture
//!
//! known            CAD; c + A p(φ) under each wiring φ; an offset or a scale of one joint;
//!                  masses within the usual tolerances of CAD, and the sensor's zero
//!
//! score            s² = (‖(y − p) / σ‖² + penalty) / (rows − unknowns of the rows)
//! found if         s²(known) > cost(known) · (1 + m · max(s²(fault) − chance, 0))
//! ```
//!
//! for CAD and wirings beside another frame, wirings and masses beside turned axes, and all four
//! beside a stuck encoder. The costs, `m` and the chance stand in [`super::criteria`]. A diagnosis
//! fits turned axes of the sensor beside all else; a fit of masses takes them for masses, and asks
//! here first.
//!
//! An axis of the readings goes with the postures where CAD under some wiring explains more of it
//! than chance does in one of 1/[`UNLIKELY`] logs:
//!
//! ```text
//! R² of noise on 2 columns:    P(R² > x) = (1 − x)^((n − 3)/2)
//! ```
//!
//! One that goes with none is dead where it does not move as CAD does, whatever the wiring, and of
//! other rows where both move as CAD has them.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{DMatrix, DVector};
use sesc_model::Function;
use sesc_model::tree::{like_sole, sole_parts};

use super::criteria::{
    ALIKE, BY_CHANCE, CAD, ENOUGH, FAR_M, LEAST_YAW, MORE, MOVES_M, MUST_MOVE, STILL, WIRING,
};
use super::view::{
    Cop, View, centred, column, dot, left_by_gain, left_by_plane, mean, scatter, without,
};
use super::{Finding, Kind};
use crate::evaluate::Evaluator;
use crate::observations::criteria::noise::SHOWS;
use crate::observations::criteria::repeats::UNLIKELY;
use crate::observations::noise::NoiseSource;
use crate::observations::postures::rms;
use crate::observations::rows::CopRows;
use crate::tolerances::Tolerances;

/// Beyond this a known explanation of some cost leaves so much more than a fault that the fault is
/// found; all in variances of readings.
pub(super) fn limit(cost: f64, fault: f64, noise: f64) -> f64 {
    cost * (noise + MORE * (fault - BY_CHANCE * noise).max(0.0))
}

/// A fault of the frame, and the CoP of the readings if it is there.
struct Fault {
    kind: Kind,
    target: String,
    /// Where readings are off, and where they are less.
    off: String,
    less: String,
    marks: [String; 2],
    cop: Cop,
}

impl Fault {
    fn finding(self, view: &View, off: String) -> Finding {
        let sentence = format!(
            "The readings are {off} mm off {} and {:.1} mm {}.",
            self.off,
            1e3 * view.gap(&self.cop),
            self.less
        );
        let picture = view.distances(&self.cop, self.marks.each_ref().map(String::as_str));
        Finding::new(self.kind, &self.target, sentence).showing(picture)
    }
}

/// Another link, or other axes of this one, that the readings fit.
pub(super) fn elsewhere(view: &View) -> Option<Finding> {
    let here = view.gap(&view.cad);
    if here < FAR_M {
        return None;
    }
    let faults = other_feet(view).chain(other_axes_up(view));
    let scored = faults.map(|fault| (view.chi2(&fault.cop), fault));
    let (left, fault) = scored.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let few = view.few();
    // The sensor's offset and gain are free beside the fault, too.
    let beside_sensor = left_of(view, by_sensor(view), &fault.cop);
    let unlikely = view.chi2(&view.cad) > limit(CAD, left, 1.0)
        && no_wiring_leaves(&few, by_sensor(&few), limit(WIRING, beside_sensor, 1.0));
    unlikely.then(|| fault.finding(view, format!("{:.0}", 1e3 * here)))
}

/// Other links that carry no joint: feet, hands, the head.
fn other_feet<'v>(view: &'v View) -> impl Iterator<Item = Fault> + 'v {
    let on = view.on;
    let support = on.model.support();
    let description = &on.robot.description;
    let carries = |link: &str| description.joints.iter().any(|joint| joint.parent == link);
    let leaves = description.links.iter().map(|link| &link.name);
    let leaves = leaves.filter(move |link| !carries(link)).map(move |link| {
        if on.model.tree.by_height {
            like_sole(support, link)
        } else {
            link.clone()
        }
    });
    let leaves = leaves.filter(move |link| link != support).take(64);
    leaves.filter_map(move |link| {
        let model = on.robot.model(&link, on.snapping, None).ok()?;
        let cop = Evaluator::new(&model, Function::Cop).run(&view.data.q, view.len());
        Some(Fault {
            kind: Kind::OtherFoot,
            off: format!("on `{support}`"),
            less: format!("on `{link}`: the robot stood on `{link}`; give that support"),
            marks: [format!("on {link}"), format!("on {support}")],
            cop: [0, 1].map(|k| column(&cop, 2, k)),
            target: link,
        })
    })
}

/// Rotations of the support's frame by right angles after which another axis than z is vertical.
fn other_axes_up<'v>(view: &'v View) -> impl Iterator<Item = Fault> + 'v {
    let support = view.on.model.support();
    // The sole of a link is moved along the link's z: another axis points up from the link itself.
    let height = match sole_parts(support) {
        Some(Ok((_, height))) if view.on.model.tree.by_height => height,
        _ => 0.0,
    };
    let axes = [(0, 2, 1), (1, 2, 0), (2, 0, 1), (2, 1, 0)];
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let all = axes.into_iter();
    let all = all.flat_map(move |axes| signs.map(|signs| (axes, signs)));
    all.map(move |((x, y, up), (sign_x, sign_y))| {
        // Right-handed: e_x × e_y is e_up or its opposite.
        let cyclic = (x + 1) % 3 == y;
        let down = (sign_x * sign_y > 0.0) != cyclic;
        let along = |axis: usize, sign: f64| {
            let of = |c: &[f64]| sign * (c[axis] - if axis == 2 { height } else { 0.0 });
            view.com.chunks_exact(3).map(of).collect()
        };
        let less = format!(
            "where its {} axis points {}: its z axis is not the normal of the sole; give a sole \
             link as support",
            ["x", "y", "z"][up],
            if down { "down" } else { "up" }
        );
        Fault {
            kind: Kind::FrameTurned,
            target: support.to_string(),
            off: format!("in the frame of `{support}`"),
            less,
            marks: ["with another axis up", "in this frame"].map(str::to_string),
            cop: [along(x, sign_x), along(y, sign_y)],
        }
    })
}

/// How the sensor's axes may lie in the sole: its x and y by those of the CoP, and in words.
const AXES: [([[f64; 2]; 2], &str); 7] = [
    ([[0.0, -1.0], [1.0, 0.0]], "the sensor is turned by 90°"),
    ([[-1.0, 0.0], [0.0, -1.0]], "the sensor is turned by 180°"),
    ([[0.0, 1.0], [-1.0, 0.0]], "the sensor is turned by −90°"),
    ([[1.0, 0.0], [0.0, -1.0]], "its y axis points the other way"),
    ([[0.0, 1.0], [1.0, 0.0]], "x and y are exchanged"),
    ([[-1.0, 0.0], [0.0, 1.0]], "its x axis points the other way"),
    ([[0.0, -1.0], [-1.0, 0.0]], "x is −y and y is −x"),
];

/// `T p`
fn along(axes: [[f64; 2]; 2], p: &Cop) -> Cop {
    axes.map(|[a, b]| p[0].iter().zip(&p[1]).map(|(x, y)| a * x + b * y).collect())
}

/// `Tᵀ`, which turns back.
fn back([[a, b], [c, d]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [[a, c], [b, d]]
}

/// What to do about axes along those of the sole, and what CAD's CoP is drawn as.
fn remedy(axes: [[f64; 2]; 2]) -> (String, &'static str) {
    let [x, y] = back(axes).map(|[x, y]| match (x + y < 0.0, x == 0.0) {
        (false, false) => "cop_x",
        (false, true) => "cop_y",
        (true, false) => "−cop_x",
        (true, true) => "−cop_y",
    });
    let remedy = format!("the CoP is x = {x}, y = {y}; write the log so, or place the cells so");
    let [[xx, xy], [yx, yy]] = axes;
    let drawn = if xx * yy - xy * yx > 0.0 {
        "turned"
    } else if xx == 0.0 {
        "axes exchanged"
    } else {
        "an axis the other way"
    };
    (remedy, drawn)
}

/// Axes of the sensor with which CAD predicts the readings, and as they stand does not.
pub(super) fn turned(view: &View) -> Option<Finding> {
    if view.len() < ENOUGH {
        return None;
    }
    let [read, cad] = [&view.reading, &view.cad].map(|cop| cop.each_ref().map(|x| centred(x)));
    let sine = dot(&read[1], &cad[0]) - dot(&read[0], &cad[1]);
    let yaw = sine.atan2(dot(&read[0], &cad[0]) + dot(&read[1], &cad[1]));
    let is_free = (yaw - (yaw / FRAC_PI_2).round() * FRAC_PI_2).abs() > LEAST_YAW;
    let free = is_free.then(|| {
        let (degrees, (sine, cosine)) = (yaw.to_degrees(), yaw.sin_cos());
        let what = format!("the sensor is turned by {degrees:.0}° about the normal of the sole");
        let remedy = format!(
            "turn the CoP of the log, or the places of the cells, by {:.0}°, or run a diagnosis, \
             which finds the angle",
            -degrees
        );
        ([[cosine, -sine], [sine, cosine]], what, (remedy, "turned"))
    });
    let right = AXES.map(|(axes, what)| (axes, what.to_string(), remedy(axes)));
    let zero = view.reading.each_ref().map(|x| mean(x));
    let turned_by = |axes: [[f64; 2]; 2]| {
        let mut cop = along(axes, &cad);
        (0..2).for_each(|k| cop[k].iter_mut().for_each(|x| *x += zero[k]));
        cop
    };
    let all = right.into_iter().chain(free);
    let scored = all.map(|own| (view.chi2(&turned_by(own.0)), own));
    let (left, (axes, what, (remedy, drawn))) = scored.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let few = view.few();
    let by_gain = |k: usize, cop: &Cop| left_by_gain(&few.reading[k], &cop[k]);
    if !no_wiring_leaves(&few, by_gain, limit(WIRING, left, 1.0)) {
        return None;
    }
    let as_read = left_by_masses(&few, &few.reading, 1.0)?;
    let turned = left_by_masses(&few, &along(back(axes), &few.reading), 1.0)?;
    if as_read <= limit(BY_CHANCE, turned, 1.0) {
        return None;
    }
    let support = view.on.model.support();
    let fault = Fault {
        kind: Kind::FrameTurned,
        target: support.to_string(),
        off: format!("in the axes of `{support}`"),
        less: format!(
            "where {what}, wherever the sensor's zero is, and masses do not explain it: {remedy}"
        ),
        marks: [drawn, "axes of the support"].map(str::to_string),
        cop: turned_by(axes),
    };
    let here = rms((0..2).flat_map(|k| read[k].iter().zip(&cad[k]).map(|(y, p)| y - p)));
    Some(fault.finding(view, format!("{:.1}", 1e3 * here)))
}

/// Whether every wiring leaves more than this of the readings, where `left` of an axis, m RMS, is
/// what is left beside a CoP.
pub(super) fn no_wiring_leaves(view: &View, left: impl Fn(usize, &Cop) -> f64, limit: f64) -> bool {
    let mut wired = view.wired();
    wired.all(|(_, cop)| left_of(view, &left, &cop) > limit)
}

/// What is left beside a CoP, in variances of the noise, where `left` of an axis is, m RMS.
fn left_of(view: &View, left: impl Fn(usize, &Cop) -> f64, cop: &Cop) -> f64 {
    let noise = rms(view.std.iter().flatten().copied());
    (rms([0, 1].into_iter().map(|k| left(k, cop))) / noise).powi(2)
}

/// What one axis has left beside any offset, gain, rotation and exchange of the sensor's axes.
pub(super) fn by_sensor<'v>(view: &'v View<'v>) -> impl Fn(usize, &Cop) -> f64 + 'v {
    |k, cop| left_by_plane(&view.reading[k], [&cop[0], &cop[1]])
}

/// What masses within the usual tolerances of CAD and any zero of the sensor leave of readings,
/// squared, in units of the view's deviations, the penalty of the tolerances included; `noise`:
/// variance of the noise in the same units.
pub(super) fn left_by_masses(view: &View, reading: &Cop, noise: f64) -> Option<f64> {
    let model = view.on.model;
    let rows = CopRows::new(model).fastest();
    let rows = rows.of(&view.data.q, view.len(), None);
    let free = rows * Tolerances::usual().factor(model);
    let count = free.ncols();
    let mut all = free.insert_column(count, 0.0);
    for row in 0..all.nrows() {
        let (axis, k) = (row % 2, row / 2);
        all[(row, count)] = reading[axis][k] - view.cad[axis][k];
    }
    for mut column in all.column_iter_mut() {
        for axis in 0..2 {
            let own = column.iter().skip(axis).step_by(2);
            let zero = own.sum::<f64>() / view.len() as f64;
            let own = column.iter_mut().skip(axis).step_by(2);
            own.zip(&view.std[axis])
                .for_each(|(x, std)| *x = (*x - zero) / (noise.sqrt() * std));
        }
    }
    let products = all.tr_mul(&all);
    let inner = products.view((0, 0), (count, count)) + DMatrix::identity(count, count);
    let along: DVector<f64> = products.view((0, count), (count, 1)).column(0).into_owned();
    let explained = along.dot(&inner.cholesky()?.solve(&along));
    Some(noise * (products[(count, count)] - explained) / all.nrows() as f64)
}

/// Whether one axis of the readings goes with the postures under some wiring by more than chance
/// does, be the sensor's zero and axes what they may.
fn relates(view: &View, k: usize) -> bool {
    let mut wired = view.wired();
    let tests = 2.0 * wired.len() as f64;
    let free = (view.len() as f64 - 3.0).max(1.0);
    let chance = ((UNLIKELY / tests).ln() / free).exp() * scatter(&view.reading[k]);
    let by_sensor = by_sensor(view);
    wired.any(|(_, cop)| by_sensor(k, &cop) < chance)
}

/// Axes of the sensor that do not move where CAD moves them, whatever the wiring.
pub(super) fn dead_axes(view: &View) -> Option<Finding> {
    let few = view.few();
    let [x, y] = [0, 1].map(|k| is_dead(view, &few, k).then(|| 1e3 * scatter(&view.cad[k])));
    let of_axis = "check the sensor's wiring and the column";
    let (kind, target, what, axis, moves, remedy) = match (x, y) {
        (None, None) => return None,
        (Some(x), None) => (Kind::CopAxisDead, "x", "cop_x", 0, x, of_axis),
        (None, Some(y)) => (Kind::CopAxisDead, "y", "cop_y", 1, y, of_axis),
        (Some(x), Some(y)) => {
            let remedy = "check that the sensor is on and that its topic is the right one";
            let both = rms([x, y].into_iter());
            // The axis that should move more shows it best.
            (
                Kind::CopConstant,
                "-",
                "The CoP",
                usize::from(y > x),
                both,
                remedy,
            )
        }
    };
    let sentence = format!(
        "{what} does not move with the robot, where CAD moves it by {moves:.1} mm RMS: {remedy}."
    );
    Some(Finding::new(kind, target, sentence).showing(view.beside_cad(axis)))
}

/// Whether an axis does not move at all.
pub(super) fn is_constant(view: &View) -> bool {
    view.reading.iter().any(|axis| scatter(axis) < STILL)
}

fn is_dead(view: &View, few: &View, k: usize) -> bool {
    let moves = scatter(&view.reading[k]);
    let constant = moves < STILL;
    let (least, rows) = match constant {
        true => (MOVES_M, 3),
        false => (MUST_MOVE * moves, ENOUGH),
    };
    if view.len() < rows || scatter(&view.cad[k]) <= least {
        return false;
    }
    // Where the axes are exchanged, this one shows what CAD says of the other.
    let other = centred(&view.reading[1 - k]);
    let left = [1 - k, k].map(|k| scatter(&without(&other, &centred(&view.cad[k]))));
    let exchanged = left[1] < left[0] && MORE * left[1].powi(2) < scatter(&other).powi(2);
    let in_unit = |(in_unit, cop): (bool, Cop)| !in_unit || scatter(&cop[k]) > least;
    !exchanged && few.wired().all(in_unit) && (constant || !relates(few, k))
}

/// Readings that scatter as CAD says and go with no posture, whatever the wiring.
pub(super) fn shuffled(view: &View) -> Option<Finding> {
    // Where postures were repeated, shuffled rows scatter within a posture, and their means hardly.
    let repeats = match view.data.noise_source {
        NoiseSource::Repeats => view.data.rows_per_posture,
        _ => 0.0,
    };
    let as_cad = |k: usize| {
        let (read, cad) = (&view.reading[k], &view.cad[k]);
        let noise = rms(view.std[k].iter().copied());
        let ratio = scatter(read).hypot(repeats.sqrt() * noise) / scatter(cad);
        let near = (mean(read) - mean(cad)).abs() < scatter(cad);
        (ALIKE.0..ALIKE.1).contains(&ratio) && near && scatter(cad) > SHOWS * noise
    };
    let few = view.few();
    let relates = |k: usize| relates(&few, k);
    if view.len() < ENOUGH || !(0..2).all(as_cad) || (0..2).any(relates) {
        return None;
    }
    let sentence = "Readings scatter as CAD says and go with no posture: rows of the CoP and of the \
                    joints do not belong together; check how they were joined.";
    let finding = Finding::new(Kind::RowsShuffled, "-", sentence.to_string());
    Some(finding.showing(view.beside_cad(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of the seven ways that axes can lie along each other, and what is said of it.
    #[test]
    fn what_is_turned_is_turned_back() {
        let cop = [vec![0.3], vec![-0.7]];
        for (axes, what) in AXES {
            let read = along(axes, &cop);
            let again = along(back(axes), &read);
            assert_eq!(again, cop, "{what}");
            let named = |name: &str| match name {
                "cop_x" => read[0][0],
                "cop_y" => read[1][0],
                "−cop_x" => -read[0][0],
                _ => -read[1][0],
            };
            let (said, _) = remedy(axes);
            let (x, y) = said
                .split_once(';')
                .unwrap()
                .0
                .split_once(", y = ")
                .unwrap();
            let x = x.strip_prefix("the CoP is x = ").unwrap();
            assert_eq!([named(x), named(y)], [0.3, -0.7], "{what}: {said}");
        }
    }
}
