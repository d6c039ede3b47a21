//! Rows in which nothing stands on the sensor, readings where no CoP can be, and what carries the
//! robot.
//!
//! ```text
//! box = hull(sole ∪ cells ∪ CoP by CAD ∪ most readings), wider by max(m, its diameter)
//! m = half the diameter of the sole where the URDF has its shape, else 0.15 m
//! ```
//!
//! A few rows beyond the box are left out. Where most readings are beyond cells and CAD, the log is
//! of another frame; readings that scatter many times as much are in another unit, which is an
//! effect and no finding, as is a wiring that brings CAD near those readings.

use nalgebra::Vector3;
use sesc_model::Model;
use sesc_model::effects::other_sole_by_joints;
use sesc_model::inertia::GRAVITY;
use sesc_model::tape::{Tape, Values};

use super::LogRows;
use super::screen::{Corners, LeftOut, is_beyond};
use crate::evaluate::FASTEST;
use crate::feet::Feet;
use crate::health::criteria::{
    BEYOND_SOLE, FEW_ROWS, FLAT, FORCE_UNLIKE, MANY_ROWS, MARGIN_M, MORE, NEARLY_ALL, TENFOLD,
    UNKNOWN_NOISE_M,
};
use crate::health::view::{On, column, scatter, span};
use crate::health::{Finding, Kind};
use crate::logs::{LEAST_LOAD_N, Sidecar};
use crate::observations::criteria::accelerations::LEAST_LOAD;
use crate::observations::noise::quantile;
use crate::observations::postures::range;
use crate::poses::on_ground;
use crate::robot::Robot;

/// What figures show of readings.
const DISTANCE: &str = "Distance of the CoP from the origin, mm";

/// Rows without load, or with a CoP of exactly zero where CAD has it elsewhere.
pub(super) fn lost(rows: &LogRows, left_out: &mut LeftOut) -> Option<Finding> {
    let mut rules = LeftOut::default();
    let known = rows.block.total_force(0).is_some();
    if known {
        let typical = quantile((0..rows.len()).map(|k| rows.load(k)), 0.5)?;
        rules.least_load = Some((LEAST_LOAD * typical).max(LEAST_LOAD_N));
        rules.lifted = rows.both_feet == Some(true) && rows.block.other.is_some();
    }
    if rows.cells() == 0 {
        let elsewhere = |k: usize| rows.cad[k][0].hypot(rows.cad[k][1]) > UNKNOWN_NOISE_M;
        let zero = |k: &usize| rows.readings()[*k] == [0.0; 2] && elsewhere(*k);
        rules.zero = (0..rows.len()).filter(zero).count() >= FEW_ROWS;
    }
    let gone = |k: usize| !rules.keeps(&rows.block, k);
    let lost: Vec<usize> = (0..rows.len()).filter(|&k| gone(k)).collect();
    let few = if known { 1 } else { FEW_ROWS };
    if lost.len() < few || lost.len() as f64 > NEARLY_ALL * rows.len() as f64 {
        return None;
    }
    let stretches = lost.chunk_by(|a, b| *b == a + 1).count();
    let what = match rows.cells() {
        0 if !known => "the CoP is exactly zero",
        0 if rules.lifted => "next to nothing stands on one of the sensors",
        0 => "next to nothing stands on the sensor",
        _ => "next to nothing stands on the cells",
    };
    let sentence = format!(
        "In {} ({:.0} %, {stretches} stretch{}) {what}: the foot lost contact or the sensor \
         dropped out; they are left out. Check that the foot stands flat, and the sensor's cable.",
        rows.some(lost.len()),
        100.0 * lost.len() as f64 / rows.len() as f64,
        if stretches == 1 { "" } else { "es" },
    );
    let about = (Kind::ContactLost, "-", sentence);
    let load = |k: usize| rows.load(k);
    let finding = match rows.cells() {
        0 if !known => rows.finding(about, DISTANCE, |k| 1e3 * rows.distance(k), gone),
        0 => rows.finding(about, "Total force, N", load, gone),
        _ => rows.finding(about, "Load on all cells, N", load, gone),
    };
    // The first rules that are made.
    *left_out = rules;
    Some(finding)
}

/// Cells that never show a load while the others do.
pub(super) fn unplugged(rows: &LogRows) -> Vec<Finding> {
    let load = |cell: usize| move |k: usize| rows.force(k)[cell];
    let never = |cell: &usize| (1..rows.len()).all(|k| load(*cell)(k) == load(*cell)(0));
    let dead: Vec<usize> = (0..rows.cells()).filter(never).collect();
    if rows.len() < FEW_ROWS || dead.len() == rows.cells() {
        return Vec::new();
    }
    let of = |cell: usize| {
        let name = format!("fsr_{}", cell + 1);
        let sentence = format!(
            "{name} shows {} N in every row while other cells change: it is not plugged in; \
             check its cable. Until then the CoP is that of the other cells.",
            load(cell)(0)
        );
        let about = (Kind::ContactLost, name.as_str(), sentence);
        rows.finding(about, &format!("Load on {name}, N"), load(cell), |_| true)
    };
    dead.into_iter().map(of).collect()
}

/// Readings beyond the sole and every CoP that CAD predicts.
pub(super) fn outside(rows: &LogRows, on: On, left_out: &mut LeftOut) -> Option<Finding> {
    let mut all = [&rows.cad[..], &rows.places].concat();
    let at_part = |part: f64| {
        [0, 1].map(|k| quantile(rows.readings().iter().map(|y| y[k]), part).unwrap_or(0.0))
    };
    let middle = at_part(0.5);
    let total = rows.len() as f64;
    let elsewhere = |meant: &dyn Fn(usize) -> bool, sentence: String| {
        let about = (Kind::CopOutsideSole, "-", sentence);
        Some(rows.finding(about, DISTANCE, |k| 1e3 * rows.distance(k), meant))
    };
    if is_beyond(within(&all, rows.sole)?, middle) {
        if !in_another_unit(rows) && !is_wired_otherwise(rows, on, |_| true) {
            let sentence = format!(
                "Most readings lie beyond the sole and every CoP that CAD predicts, about {:.2} m \
                 from the frame's origin: check that the support frame lies on the sole and that \
                 the CoP is given in it, in metres.",
                middle[0].hypot(middle[1])
            );
            return elsewhere(&|_| true, sentence);
        }
    } else {
        // Wrong signs and loads spread readings wider than CAD: most of them are no fault.
        all.extend([MANY_ROWS, 1.0 - MANY_ROWS].map(at_part));
        let inside = within(&all, rows.sole)?;
        let beyond = |k: usize| is_beyond(inside, rows.readings()[k]);
        let count = (0..rows.len()).filter(|k| beyond(*k)).count();
        if count > 0 && count as f64 <= MANY_ROWS * total {
            if is_wired_otherwise(rows, on, beyond) {
                return None;
            }
            left_out.within = Some(inside);
            let sentence = format!(
                "The CoP of {count} of {} lies beyond the sole and every CoP that CAD predicts, \
                 up to {:.2} m from the frame's origin: these rows are left out; check the sensor's \
                 cable and the topic.",
                rows.total(),
                range((0..rows.len()).map(|k| rows.distance(k))).1
            );
            return elsewhere(&beyond, sentence);
        }
    }
    // Most readings beyond what the sole can carry, where CAD has the robot balanced on it.
    let sole = rows.sole?;
    let around_sole = wider(sole, BEYOND_SOLE * diameter(sole));
    let beyond = |y: &&[f64; 2]| is_beyond(around_sole, **y);
    let part = |all: &[[f64; 2]]| all.iter().filter(beyond).count() as f64 / total;
    if part(rows.readings()) <= 0.5 || part(&rows.cad) > MANY_ROWS {
        return None;
    }
    let sentence = format!(
        "{:.0} % of the readings lie beyond the sole, which no ground can push there, and CAD has \
         the robot balanced on it: the CoP is in another unit, of another frame, or of a force and \
         moments in different units.",
        100.0 * part(rows.readings())
    );
    elsewhere(&|k| beyond(&&rows.readings()[k]), sentence)
}

/// Whether a wiring brings CAD's CoP near the readings of some of the rows.
fn is_wired_otherwise(rows: &LogRows, on: On, which: impl Fn(usize) -> bool) -> bool {
    let chosen: Vec<usize> = (0..rows.len()).filter(|k| which(*k)).collect();
    let view = rows.view(on, &rows.as_read(&chosen)).few();
    let far = view.chi2(&view.cad);
    let mut wired = view.wired();
    wired.any(|(_, cop)| MORE * view.chi2(&cop) < far)
}

fn diameter([low, high]: Corners) -> f64 {
    (high[0] - low[0]).hypot(high[1] - low[1])
}

/// A box that is wider by a margin.
fn wider([low, high]: Corners, margin: f64) -> Corners {
    [low.map(|x| x - margin), high.map(|x| x + margin)]
}

/// The box around some places.
fn around(places: &[[f64; 2]]) -> Corners {
    let [x, y] = [0, 1].map(|k| range(places.iter().map(|p| p[k])));
    [[x.0, y.0], [x.1, y.1]]
}

/// The box around places and the sole, wider by half the diameter of the sole where its shape is
/// known, and by that of the places.
fn within(places: &[[f64; 2]], sole: Option<Corners>) -> Option<Corners> {
    let size = diameter(around(places));
    let least = sole.map_or(MARGIN_M, |sole| 0.5 * diameter(sole));
    let all = [places, sole.as_ref().map_or(&[], |sole| &sole[..])].concat();
    let wider = wider(around(&all), least.max(size));
    size.is_finite().then_some(wider)
}

/// Whether readings scatter by more than CAD says, as they do in another unit.
fn in_another_unit(rows: &LogRows) -> bool {
    let by_axis = |all: &[[f64; 2]]| [0, 1].map(|k| scatter(&column(all.as_flattened(), 2, k)));
    let [[x, y], read] = [&rows.cad, rows.readings()].map(by_axis);
    read.iter().any(|own| *own > TENFOLD * x.max(y))
}

/// Corners of the sole, m, by the collision shapes of all links fixed to the support, in its
/// frame, seen from above; none where the URDF has no shapes there but meshes.
pub(crate) fn sole_of(robot: &Robot, model: &Model) -> Option<Corners> {
    let description = &robot.description;
    let mut corners: Vec<[f64; 2]> = Vec::new();
    for (name, extent) in description.link_names().zip(&description.shapes) {
        let own = on_ground(model).find(|(link, _)| link.name == name);
        if let (Some(extent), Some((_, place))) = (extent, own) {
            let ends = [extent.low, extent.high];
            let local = |corner: usize| Vector3::from_fn(|k, _| ends[corner >> k & 1][k]);
            let seen = (0..8).map(|corner| place.point(&local(corner)));
            corners.extend(seen.map(|p| [p.x, p.y]));
        }
    }
    (!corners.is_empty()).then(|| around(&corners))
}

/// A typical total force that is not the weight by CAD.
pub(super) fn unlike_weight(rows: &LogRows, model: &Model, left_out: &LeftOut) -> Option<Finding> {
    if rows.both_feet == Some(true) && rows.cells() > 0 {
        return None;
    }
    rows.block.total_force(0)?;
    let kept = rows.kept(left_out);
    let typical = quantile(kept.iter().map(|&k| rows.load(k)), 0.5)?;
    let weight = model.tree.mass * GRAVITY;
    let ratio = typical / weight;
    if ratio <= 0.0 || (1.0 / FORCE_UNLIKE..FORCE_UNLIKE).contains(&ratio) {
        return None;
    }
    // What makes a force so many times the weight.
    let causes = [
        (1.0 / 9.80665, "it is in kgf (1 kgf is 9.81 N)"),
        (1.0 / 4.448_222, "it is in lbf (1 lbf is 4.45 N)"),
        (1e3 / 9.80665, "it is in gf (1 gf is 9.81 mN)"),
        (1e3, "it is in mN"),
        (1e-3, "it is in kN"),
        (0.5, "the other foot carries as much"),
        (2.0, "it is counted twice"),
    ];
    let off = |known: f64| (ratio / known).ln().abs();
    let cause = causes.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
    let cause = cause.filter(|(known, _)| 2.0 * off(*known) < FORCE_UNLIKE.ln());
    let why = match cause {
        Some((_, why)) => format!("as if {why}"),
        None => "as of another robot, a sensor with a wrong scale, or counts of a converter".into(),
    };
    let mut unit = "a CoP of this force and of moments in N m is wrong by the same factor: correct \
                    the force";
    if rows.cells() > 0 {
        unit = "the CoP of cells does not depend on their unit, but does on cells that are missing";
    }
    let sentence = format!(
        "The total force is typically {typical:.3} N and the weight by CAD {weight:.3} N, {why}; \
         {unit}."
    );
    let about = (Kind::ForceUnlikeWeight, "-", sentence);
    Some(rows.finding(about, "Total force, N", |k| rows.load(k), |_| true))
}

/// The other sole on the floor in nearly all rows, while joints between both soles move and nobody
/// said how many feet stand.
pub(super) fn both_flat(rows: &LogRows, model: &Model) -> Option<Finding> {
    let (dof, n) = (rows.dof, rows.len());
    if rows.both_feet.is_some() || dof == 0 {
        return None;
    }
    let feet = Feet {
        both: Some(true),
        other: None,
    };
    let other = feet.of(&Sidecar::default(), model).ok()??;
    let tape = Tape::new(&other_sole_by_joints(model, other.place()));
    let width = tape.outputs();
    let mut out = vec![0.0; n * width];
    tape.run(&[Values::PerPosture(&rows.block.q)], n, &mut out, FASTEST);
    // Height, roll and pitch, each with its slopes by all joints.
    let at = |k: usize, row: usize| out[k * width + row * (1 + dof)];
    let limits = [FLAT.0, FLAT.1, FLAT.1];
    let flat = |k: &usize| (0..3).all(|row| at(*k, row).abs() < limits[row]);
    let flat: Vec<usize> = (0..n).filter(flat).collect();
    if (flat.len() as f64) < NEARLY_ALL * n as f64 {
        return None;
    }
    let between = |j: &usize| (0..3).any(|row| out[row * (1 + dof) + 1 + j].abs() > 1e-6);
    let swings = |j: usize| span(rows.block.q.iter().skip(j).step_by(dof).copied()) > FLAT.1;
    if !(0..dof).filter(between).any(swings) {
        return None;
    }
    let most = |row: usize| flat.iter().map(|&k| at(k, row).abs()).fold(0.0, f64::max);
    let sentence = format!(
        "In {} of {} the sole of `{}` lies flat on the floor of `{}`, too (within {:.1} mm and \
         {:.1}°): if both feet carry the robot, say `both_feet = true` in the sidecar; the CoP is \
         then that of both, and the soles tell offsets of joints. If one foot does, say \
         `both_feet = false`.",
        flat.len(),
        rows.total(),
        other.name,
        model.support(),
        1e3 * most(0),
        most(1).max(most(2)).to_degrees(),
    );
    let title = format!("Height of {} over the floor, mm", other.name);
    let about = (Kind::BothFeetFlat, other.name.as_str(), sentence);
    Some(rows.finding(about, &title, |k| 1e3 * at(k, 0), |_| true))
}
