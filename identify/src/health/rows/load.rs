//! What carries the robot: a total force that is not its weight, and a second sole on the floor.

use sesc_model::Model;
use sesc_model::effects::other_sole_by_joints;
use sesc_model::inertia::GRAVITY;
use sesc_model::tape::{Tape, Values};

use super::LogRows;
use super::screen::LeftOut;
use crate::evaluate::FASTEST;
use crate::feet::Feet;
use crate::health::criteria::{FLAT_M, FLAT_PART, FLAT_RAD, FLAT_SWING, FORCE_KNOWN, FORCE_UNLIKE};
use crate::health::{Finding, Kind, Picture};
use crate::logs::Sidecar;
use crate::observations::postures::range;

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
