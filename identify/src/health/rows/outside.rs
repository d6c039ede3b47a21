//! Readings where no CoP can be.
//!
//! ```text
//! box = hull(sole ∪ cells ∪ CoP by CAD ∪ most readings), wider by max(m, its diameter)
//! m = half the diameter of the sole where the URDF has its shape, else 0.15 m
//! ```
//!
//! A few such rows are left out. Where most readings are beyond cells and CAD, the log is of
//! another frame; readings that scatter many times as much are in another unit, which is an
//! effect and no finding, as is a wiring that brings CAD near those readings.

use sesc_model::Model;
use sesc_model::urdf::extents;

use super::LogRows;
use super::screen::LeftOut;
use crate::health::criteria::{
    BEYOND_SOLE, MARGIN_M, MARGIN_OF_CLOUD, MARGIN_OF_SOLE, MOST_BEYOND, MOST_OUTSIDE, OTHER_UNIT,
    SPREAD, WIRED_NEARER,
};
use crate::health::statistics::scatter;
use crate::health::wirings::Wirings;
use crate::health::{Finding, Kind, Picture};
use crate::observations::postures::range;
use crate::robot::Robot;

pub(super) fn sole(rows: &LogRows, model: &Model, left_out: &mut LeftOut) -> Option<Finding> {
    let everywhere = rows.cad.iter().chain(&rows.cad_of_degrees);
    let mut all: Vec<[f64; 2]> = everywhere.chain(&rows.places).copied().collect();
    let middle = [0, 1].map(|k| quantile(&rows.reading, k, 0.5));
    let rules = |all: &[[f64; 2]]| rules(all, rows.sole);
    if rules(&all)?.keeps(middle, &[]) {
        // Wrong signs and loads spread readings wider than CAD: most of them are no fault.
        for part in [SPREAD.0, SPREAD.1] {
            all.push([0, 1].map(|k| quantile(&rows.reading, k, part)));
        }
    } else if elsewhere(rows) && !is_wired_otherwise(rows, model, |_| true) {
        return Some(frame(rows, middle));
    } else {
        return beyond_the_sole(rows);
    }
    let inside = rules(&all)?;
    let beyond = |k: usize| !inside.keeps(rows.reading[k], &[]);
    let count = (0..rows.len()).filter(|k| beyond(*k)).count();
    let total = rows.len();
    if count == 0 || count as f64 > MOST_OUTSIDE * total as f64 {
        return beyond_the_sole(rows);
    }
    if is_wired_otherwise(rows, model, beyond) {
        return None;
    }
    let length = |k: usize| rows.reading[k][0].hypot(rows.reading[k][1]);
    left_out.sole = inside.sole;
    let sentence = format!(
        "The CoP of {count} of {} lies beyond the sole and every CoP that CAD predicts, \
         up to {:.2} m from the frame's origin: these rows are left out; check the sensor's cable \
         and the topic.",
        rows.total(),
        (0..total).map(length).fold(0.0, f64::max)
    );
    Some(Finding::new(Kind::CopOutsideSole, "-", sentence).showing(picture(rows, beyond)))
}

/// Whether a wiring brings CAD's CoP near the readings of some of the rows.
fn is_wired_otherwise(rows: &LogRows, model: &Model, which: impl Fn(usize) -> bool) -> bool {
    let chosen: Vec<usize> = (0..rows.len()).filter(|k| which(*k)).collect();
    Wirings::new(model, &rows.postures(&chosen)).nearer() < WIRED_NEARER
}

/// The box around places and the sole, wider by the margin.
fn rules(places: &[[f64; 2]], sole: Option<[[f64; 2]; 2]>) -> Option<LeftOut> {
    let diameter = |low: [f64; 2], high: [f64; 2]| (high[0] - low[0]).hypot(high[1] - low[1]);
    let [x, y] = [0, 1].map(|k| range(places.iter().map(|p| p[k])));
    let (mut low, mut high) = ([x.0, y.0], [x.1, y.1]);
    let size = diameter(low, high);
    let mut least = MARGIN_M;
    if let Some([from, to]) = sole {
        least = MARGIN_OF_SOLE * diameter(from, to);
        low = [0, 1].map(|k| low[k].min(from[k]));
        high = [0, 1].map(|k| high[k].max(to[k]));
    }
    let margin = least.max(MARGIN_OF_CLOUD * size);
    size.is_finite().then(|| LeftOut {
        sole: Some([low.map(|x| x - margin), high.map(|x| x + margin)]),
        ..LeftOut::default()
    })
}

/// Below which so large a part of the readings is on one axis, m.
fn quantile(readings: &[[f64; 2]], axis: usize, part: f64) -> f64 {
    let mut sorted: Vec<f64> = readings.iter().map(|y| y[axis]).collect();
    sorted.sort_by(f64::total_cmp);
    let at = (part * (sorted.len() - 1) as f64).round() as usize;
    sorted.get(at).copied().unwrap_or(0.0)
}

/// Most readings beyond what the sole can carry, where CAD has the robot balanced on it.
fn beyond_the_sole(rows: &LogRows) -> Option<Finding> {
    let [low, high] = rows.sole?;
    let margin = BEYOND_SOLE * (high[0] - low[0]).hypot(high[1] - low[1]);
    let sole = LeftOut {
        sole: Some([low.map(|x| x - margin), high.map(|x| x + margin)]),
        ..LeftOut::default()
    };
    let beyond = |y: &[f64; 2]| !sole.keeps(*y, &[]);
    let part =
        |all: &[[f64; 2]]| all.iter().filter(|y| beyond(y)).count() as f64 / rows.len() as f64;
    if part(&rows.reading) <= MOST_BEYOND || part(&rows.cad) > MOST_OUTSIDE {
        return None;
    }
    let sentence = format!(
        "{:.0} % of the readings lie beyond the sole, which no ground can push there, and CAD has \
         the robot balanced on it: the CoP is in another unit, of another frame, or of a force and \
         moments in different units.",
        100.0 * part(&rows.reading)
    );
    let meant = |k: usize| beyond(&rows.reading[k]);
    Some(Finding::new(Kind::CopOutsideSole, "-", sentence).showing(picture(rows, meant)))
}

/// A finding about the whole log: most readings are elsewhere.
fn frame(rows: &LogRows, middle: [f64; 2]) -> Finding {
    let sentence = format!(
        "Most readings lie beyond the sole and every CoP that CAD predicts, about {:.2} m from the \
         frame's origin: check that the support frame lies on the sole and that the CoP is given in \
         it, in metres.",
        middle[0].hypot(middle[1])
    );
    Finding::new(Kind::CopOutsideSole, "-", sentence).showing(picture(rows, |_| true))
}

fn picture(rows: &LogRows, meant: impl Fn(usize) -> bool) -> Picture {
    let length = |k: usize| 1e3 * rows.reading[k][0].hypot(rows.reading[k][1]);
    let title = "Distance of the CoP from the origin, mm";
    Picture::of(title, rows.len(), |k| rows.row(k), length, meant)
}

/// Whether readings scatter no more than CAD says: in another unit they would.
fn elsewhere(rows: &LogRows) -> bool {
    let column = |all: &[[f64; 2]], k: usize| -> Vec<f64> { all.iter().map(|p| p[k]).collect() };
    let larger = |k: usize| {
        let cad = scatter(&column(&rows.cad, 0)).max(scatter(&column(&rows.cad, 1)));
        scatter(&column(&rows.reading, k)) > OTHER_UNIT * cad
    };
    !(larger(0) || larger(1))
}

/// Least and greatest corner of the sole, m, by the collision shapes of all links fixed to the
/// support, in its frame, seen from above; none where the URDF has no shapes there but meshes.
pub(super) fn corners(robot: &Robot, model: &Model) -> Option<[[f64; 2]; 2]> {
    let description = &robot.description;
    let boxes = extents(description).ok()?;
    let mut corners: Option<[[f64; 2]; 2]> = None;
    for (name, extent) in description.link_names().zip(boxes) {
        let link = model.tree.links.iter().position(|link| link.name == name);
        let place = link.and_then(|link| model.chain.places[link]);
        let (Some(extent), Some(place)) = (extent, place) else {
            continue;
        };
        if place.body != 0 {
            continue;
        }
        let (rows, origin) = (place.orientation(), place.origin());
        for corner in 0..8 {
            let local = [0, 1, 2].map(|axis| match corner >> axis & 1 {
                0 => extent.low[axis],
                _ => extent.high[axis],
            });
            let at = [0, 1].map(|axis| {
                let turned = rows[axis].iter().zip(local).map(|(a, b)| a * b);
                origin[axis] + turned.sum::<f64>()
            });
            let [low, high] = corners.unwrap_or([at, at]);
            corners = Some([
                [0, 1].map(|axis| at[axis].min(low[axis])),
                [0, 1].map(|axis| at[axis].max(high[axis])),
            ]);
        }
    }
    corners
}
