//! Stretches in which nothing stands on the sensor, and cells that are not plugged in.
//!
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
//!
//! What carries the robot: a total force that is not its weight, and a second sole on the floor.

use sesc_model::Model;
use sesc_model::effects::other_sole_by_joints;
use sesc_model::inertia::GRAVITY;
use sesc_model::tape::{Tape, Values};
use sesc_model::urdf::extents;

use super::LogRows;
use super::screen::LeftOut;
use crate::evaluate::FASTEST;
use crate::feet::Feet;
use crate::health::criteria::{
    BEYOND_SOLE, CAD_ELSEWHERE_M, FEW_ROWS, FLAT_M, FLAT_PART, FLAT_RAD, FLAT_SWING, FORCE_KNOWN,
    FORCE_UNLIKE, LOADED, MARGIN_M, MARGIN_OF_CLOUD, MARGIN_OF_SOLE, MOST_BEYOND, MOST_LOST,
    MOST_OUTSIDE, OTHER_UNIT, SPREAD, WIRED_NEARER,
};
use crate::health::wirings::Wirings;
use crate::health::wirings::scatter;
use crate::health::{Finding, Kind, Picture};
use crate::logs::{LEAST_LOAD_N, Sidecar};
use crate::observations::postures::range;
use crate::robot::Robot;

/// Rows without load, or with a CoP of exactly zero where CAD has it elsewhere.
pub(super) fn lost(rows: &LogRows, left_out: &mut LeftOut) -> Option<Finding> {
    let mut rules = LeftOut::default();
    if rows.cells > 0 {
        let mut totals: Vec<f64> = (0..rows.len())
            .map(|k| rows.force(k).iter().sum())
            .collect();
        totals.sort_by(f64::total_cmp);
        let typical = totals[totals.len() / 2];
        rules.least_load = Some((LOADED * typical).max(LEAST_LOAD_N));
    } else {
        let elsewhere = |k: usize| rows.cad[k][0].hypot(rows.cad[k][1]) > CAD_ELSEWHERE_M;
        let zero = |k: &usize| rows.reading[*k] == [0.0; 2] && elsewhere(*k);
        rules.zero = (0..rows.len()).filter(zero).count() >= FEW_ROWS;
    }
    let gone = |k: usize| !rules.keeps(rows.reading[k], rows.force(k));
    let lost: Vec<usize> = (0..rows.len()).filter(|&k| gone(k)).collect();
    let few = if rows.cells > 0 { 1 } else { FEW_ROWS };
    if lost.len() < few || lost.len() as f64 > MOST_LOST * rows.len() as f64 {
        return None;
    }
    let begins = |w: &&[usize]| w[1] > w[0] + 1;
    let stretches = 1 + lost.windows(2).filter(begins).count();
    (left_out.least_load, left_out.zero) = (rules.least_load, rules.zero);
    let what = match rows.cells {
        0 => "the CoP is exactly zero",
        _ => "next to nothing stands on the cells",
    };
    let share = 100.0 * lost.len() as f64 / rows.len() as f64;
    let finding = Finding::new(
        Kind::ContactLost,
        "-",
        format!(
            "In {} ({share:.0} %, {stretches} {}) {what}: the foot lost contact or the sensor \
             dropped out; they are left out. Check that the foot stands flat, and the sensor's cable.",
            rows.some(lost.len()),
            if stretches == 1 {
                "stretch"
            } else {
                "stretches"
            },
        ),
    );
    let length = |k: usize| 1e3 * rows.reading[k][0].hypot(rows.reading[k][1]);
    let load = |k: usize| rows.force(k).iter().sum::<f64>();
    let (title, value): (&str, &dyn Fn(usize) -> f64) = match rows.cells {
        0 => ("Distance of the CoP from the origin, mm", &length),
        _ => ("Load on all cells, N", &load),
    };
    let picture = Picture::of(title, rows.len(), |k| rows.row(k), value, gone);
    Some(finding.showing(picture))
}

/// Cells that never show a load while the others do.
pub(super) fn unplugged(rows: &LogRows) -> Vec<Finding> {
    let never = |cell: usize| {
        let mut loads = (0..rows.len()).map(|k| rows.force(k)[cell]);
        let first = loads.next().unwrap_or(0.0);
        loads.all(|load| load == first)
    };
    let dead: Vec<usize> = (0..rows.cells).filter(|&cell| never(cell)).collect();
    if rows.len() < FEW_ROWS || dead.len() == rows.cells {
        return Vec::new();
    }
    let sentence = |cell: usize| {
        format!(
            "fsr_{} shows {} N in every row while other cells change: it is not plugged in; \
             check its cable. Until then the CoP is that of the other cells.",
            cell + 1,
            rows.force(0)[cell]
        )
    };
    let of = |cell: usize| {
        let load = |k: usize| rows.force(k)[cell];
        let title = format!("Load on fsr_{}, N", cell + 1);
        let picture = Picture::of(&title, rows.len(), |k| rows.row(k), load, |_| true);
        Finding::new(
            Kind::ContactLost,
            &format!("fsr_{}", cell + 1),
            sentence(cell),
        )
        .showing(picture)
    };
    dead.into_iter().map(of).collect()
}

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

/// What makes a force so many times the weight.
const CAUSES: [(f64, &str); 7] = [
    (1.0 / 9.80665, "it is in kgf (1 kgf is 9.81 N)"),
    (1.0 / 4.448_222, "it is in lbf (1 lbf is 4.45 N)"),
    (1e3 / 9.80665, "it is in gf (1 gf is 9.81 mN)"),
    (1e3, "it is in mN"),
    (1e-3, "it is in kN"),
    (0.5, "the other foot carries as much"),
    (2.0, "it is counted twice"),
];

/// A typical total force that is not the weight by CAD.
pub(super) fn unlike_weight(rows: &LogRows, model: &Model, left_out: &LeftOut) -> Option<Finding> {
    if rows.load.len() != rows.len() || rows.both_feet == Some(true) && rows.cells > 0 {
        return None;
    }
    let mut loads: Vec<f64> = rows.kept(left_out).iter().map(|&k| rows.load[k]).collect();
    loads.sort_by(f64::total_cmp);
    let typical = *loads.get(loads.len() / 2)?;
    let weight = model.tree.mass * GRAVITY;
    let ratio = typical / weight;
    if ratio <= 0.0 || (1.0 / FORCE_UNLIKE..FORCE_UNLIKE).contains(&ratio) {
        return None;
    }
    let off = |known: f64| (ratio / known).ln().abs();
    let cause = CAUSES.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
    let cause = cause.filter(|(known, _)| off(*known) < FORCE_KNOWN.ln());
    let why = match cause {
        Some((_, why)) => format!("as if {why}"),
        None => "as of another robot, a sensor with a wrong scale, or counts of a converter".into(),
    };
    let unit = match rows.cells {
        0 => {
            "a CoP of this force and of moments in N m is wrong by the same factor: correct the \
              force"
        }
        _ => "the CoP of cells does not depend on their unit, but does on cells that are missing",
    };
    let sentence = format!(
        "The total force is typically {typical:.3} N and the weight by CAD {weight:.3} N, {why}; \
         {unit}."
    );
    let picture = Picture::of(
        "Total force, N",
        rows.len(),
        |k| rows.row(k),
        |k| rows.load[k],
        |_| true,
    );
    Some(Finding::new(Kind::ForceUnlikeWeight, "-", sentence).showing(picture))
}

/// The other sole on the floor in nearly all rows, while joints between both soles move and nobody
/// said how many feet stand.
pub(super) fn both_flat(rows: &LogRows, model: &Model) -> Option<Finding> {
    let dof = rows.dof;
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
    let mut out = vec![0.0; rows.len() * width];
    tape.run(
        &[Values::PerPosture(&rows.q)],
        rows.len(),
        &mut out,
        FASTEST,
    );
    // Height, roll and pitch, each with its slopes by all joints.
    let at = |k: usize, row: usize| out[k * width + row * (1 + dof)];
    let flat = |k: &usize| {
        at(*k, 0).abs() < FLAT_M && at(*k, 1).abs() < FLAT_RAD && at(*k, 2).abs() < FLAT_RAD
    };
    let flat: Vec<usize> = (0..rows.len()).filter(flat).collect();
    if (flat.len() as f64) < FLAT_PART * rows.len() as f64 {
        return None;
    }
    let between = |j: &usize| (0..3).any(|row| out[row * (1 + dof) + 1 + j].abs() > 1e-6);
    let swings = |j: usize| {
        let (low, high) = range(rows.q.iter().skip(j).step_by(dof).copied());
        high - low > FLAT_SWING
    };
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
    let picture = Picture::of(
        &format!("Height of {} over the floor, mm", other.name),
        rows.len(),
        |k| rows.row(k),
        |k| 1e3 * at(k, 0),
        |_| true,
    );
    Some(Finding::new(Kind::BothFeetFlat, &other.name, sentence).showing(picture))
}
