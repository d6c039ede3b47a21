//! The symbolic measurement with each effect, against the virtual robot.
//!
//! Exact effects agree to rounding. Not exact by construction are: springs (four
//! rounds of a fixed point leave the fifth power of gravity's stiffness over the
//! joint's), roots of faint loads (a floor of 1e-12 of the weight), angles late by d
//! (third order in d), inertia (first order in the accelerations).

use std::collections::BTreeMap;

use sesc_model::effects::{self, Catalog, Effect};
use sesc_reference::Track;

use super::hidden::{Hidden, hide, hide_all};
use super::robots::{Stand, distance, run};
use crate::c99::bounds::larger;

/// What rounding leaves, m, and a joint that comes to rest within 1e-13 rad.
const EXACT: f64 = 2e-12;
const POSTURES: usize = 12;

/// How far the formula may be from the bent robot, m.
fn tolerance(effect: &dyn Effect, stand: &Stand, hidden: &Hidden) -> f64 {
    let context = stand.context();
    match effect.id().name() {
        "joint_compliance" => {
            // Every joint's deflection moves what the next round loads.
            let gravity = context.weight() * stand.model.reach();
            let joints = if hidden.target == "all" { 3.0 } else { 1.0 };
            let softness = joints * gravity / hidden.values[0];
            stand.model.reach() * softness.powi(5) + EXACT
        }
        "cell_exponent" => {
            let span = distance(stand.cells[0], stand.cells[2]);
            span * 1e-12_f64.powf(hidden.values[0].min(1.0)) + EXACT
        }
        _ => EXACT,
    }
}

#[test]
fn every_effect_bends_the_reading_as_it_bends_the_robot() {
    let mut worst: BTreeMap<&str, f64> = BTreeMap::new();
    for stand in Stand::all() {
        let context = stand.context();
        for effect in Catalog::standard().iter() {
            if effect.id().name() == "time_delay" {
                continue;
            }
            let mut moved: f64 = 0.0;
            for hidden in Hidden::of(effect, &context, 4) {
                let found = compare(&stand, &hidden);
                let allowed = tolerance(effect, &stand, &hidden);
                let off = format!("{:.1e} of {allowed:.1e} m", found.off);
                assert!(found.off <= allowed, "{} {hidden:?}: {off}", stand.name);
                moved = moved.max(found.moved);
                let worst = worst.entry(effect.id().name()).or_default();
                *worst = worst.max(found.off);
            }
            // It would be no test if nothing happened.
            assert!(moved > 1e-5, "{}: {moved}", effect.id().name());
        }
    }
    for (effect, worst) in worst {
        println!("{effect:<20} {worst:.1e} m");
    }
}

pub(super) struct Found {
    /// Largest distance of formula and robot, m.
    pub off: f64,
    /// How far the effect moves the reading at most.
    pub moved: f64,
}

/// Formula and robot in random postures of a log.
pub(super) fn compare(stand: &Stand, hidden: &Hidden) -> Found {
    compare_all(stand, std::slice::from_ref(hidden))
}

/// The same for several effects at once.
pub(super) fn compare_all(stand: &Stand, hidden: &[Hidden]) -> Found {
    let context = stand.context();
    let instances: Vec<_> = hidden.iter().map(|h| h.instance.clone()).collect();
    let unknowns: Vec<f64> = hidden.iter().flat_map(|h| h.unknowns(&context)).collect();
    let program = stand.reading(&instances, &stand.model.cad_params());
    let is = |name: &str, target: &str| {
        let mut all = hidden.iter();
        all.any(|h| {
            h.instance.effect.id().name() == name && (target.is_empty() || h.target == target)
        })
    };
    let mut all = hidden.iter();
    let cells = all.any(|h| h.instance.effect.stage() == effects::Stage::Cells);
    let bare = match cells {
        true => stand.world().cells(&stand.cells).unwrap(),
        false => stand.world(),
    };
    let world = hide_all(bare, stand, hidden);
    let mut postures = stand.postures(POSTURES, 0.35, 17);
    if cells {
        // Outside the cells' outline no foot stands.
        postures = stand.postures(40 * POSTURES, 0.7, 17);
        let of_robot = hidden
            .iter()
            .filter(|h| !h.instance.effect.is_sensor_effect(&h.instance.target));
        let carried = of_robot.fold(stand.world(), |world, h| hide(world, stand, h));
        postures.retain(|q| stand.is_inside(carried.cop(q)));
        postures.truncate(3 * POSTURES);
        assert!(postures.len() >= POSTURES, "{}", stand.name);
    }
    let (mut off, mut moved) = (0.0_f64, 0.0_f64);
    let written: Vec<Vec<f64>> = match is("units", "degrees") {
        // The virtual robot's log has millimetres where it has degrees.
        true => postures.iter().map(|q| logged(stand, q, 1e3)).collect(),
        false => postures.clone(),
    };
    let last = postures.len() as f64 - 1.0;
    let readings = world.readings(&Track::still(written.clone()));
    for (k, (q, reading)) in postures.iter().zip(&readings).enumerate() {
        let layout = stand.posture_context();
        let mut posture_context = vec![0.0; layout.len()];
        posture_context[layout.place()] = k as f64 / last;
        if is("backlash", "") {
            let rest = world.true_posture(&written[k]);
            for h in hidden
                .iter()
                .filter(|h| h.instance.effect.id().name() == "backlash")
            {
                for (j, dof) in stand.model.tree.dofs.iter().enumerate() {
                    if !dof.prismatic && (h.target == "all" || h.target == dof.joint) {
                        // Only this effect moves joints here.
                        let side = (rest[j] - q[j]) / (0.5 * h.values[0]);
                        posture_context[layout.side(j)] = side;
                    }
                }
            }
        }
        let q = match is("units", "degrees") {
            true => logged(stand, q, 1.0),
            false => q.clone(),
        };
        let out = run(&program, &[&q, &unknowns, &posture_context]);
        let width = out.len() / 2;
        off = larger(off, distance([out[0], out[width]], reading.cop));
        let straight = stand.world().cop(&postures[k]);
        moved = larger(moved, distance(reading.cop, straight));
    }
    Found { off, moved }
}

/// A posture in degrees, prismatic positions times `length`.
fn logged(stand: &Stand, q: &[f64], length: f64) -> Vec<f64> {
    let dofs = stand.model.tree.dofs.iter().zip(q);
    dofs.map(|(dof, q)| match dof.prismatic {
        true => length * q,
        false => q.to_degrees(),
    })
    .collect()
}

/// A slow dance: every joint its own sine, within its limits.
#[derive(Clone)]
struct Dance(Vec<(f64, f64, f64, f64)>);

impl Dance {
    fn of(stand: &Stand, rate: f64) -> Dance {
        let middles = stand.postures(1, 0.2, 3).remove(0);
        let sines = stand.model.tree.dofs.iter().enumerate().map(|(j, dof)| {
            let size = if dof.prismatic { 0.02 } else { 0.15 };
            let rate = rate * (1.0 + 0.05 * j as f64);
            (middles[j], size, rate, 0.7 * j as f64)
        });
        Dance(sines.collect())
    }

    fn at(&self, t: f64) -> Vec<f64> {
        let of = |(m, a, w, p): &(f64, f64, f64, f64)| m + a * (w * t + p).sin();
        self.0.iter().map(of).collect()
    }

    /// Rates, then accelerations, in the order of the posture context.
    fn derivatives(&self, t: f64) -> (Vec<f64>, Vec<f64>) {
        let rate = |(_, a, w, p): &(f64, f64, f64, f64)| a * w * (w * t + p).cos();
        let bend = |(_, a, w, p): &(f64, f64, f64, f64)| -a * w * w * (w * t + p).sin();
        let all = self.0.iter();
        (all.clone().map(rate).collect(), all.map(bend).collect())
    }
}

/// Formula, robot, and the robot at rest, all along the dance.
fn dance(stand: &Stand, hidden: &Hidden, dance: &Dance) -> Vec<[[f64; 2]; 3]> {
    let context = stand.context();
    let instances = std::slice::from_ref(&hidden.instance);
    let program = stand.reading(instances, &stand.model.cad_params());
    let times: Vec<f64> = (0..25).map(|k| 0.21 * f64::from(k)).collect();
    let moving = dance.clone();
    let track = Track::moving(times.clone(), move |t| moving.at(t));
    let world = hide(stand.world(), stand, hidden);
    let readings = world.readings(&track);
    let layout = stand.posture_context();
    let rows = times.iter().zip(readings);
    rows.map(|(&t, reading)| {
        let q = dance.at(t);
        let mut posture_context = vec![0.0; layout.len()];
        let (rates, bends) = dance.derivatives(t);
        for j in 0..q.len() {
            posture_context[layout.rate(j)] = rates[j];
            posture_context[layout.acceleration(j)] = bends[j];
        }
        let unknowns = hidden.unknowns(&context);
        let out = run(&program, &[&q, &unknowns, &posture_context]);
        let formula = [out[0], out[out.len() / 2]];
        [formula, reading.cop, stand.world().cop(&q)]
    })
    .collect()
}

/// `q + d q' + d² q''/2` is off by at most `d³ |q'''| / 6`, a joint turns the CoM
/// by at most the robot's reach per radian.
#[test]
fn late_angles_are_predicted_to_third_order() {
    for stand in Stand::all() {
        let context = stand.context();
        let dancing = Dance::of(&stand, 2.0);
        let jerk: f64 = dancing.0.iter().map(|(_, a, w, _)| a * w.powi(3)).sum();
        let delay = Catalog::standard().named("time_delay").unwrap();
        for hidden in Hidden::of(delay, &context, 2) {
            let bound = hidden.values[0].abs().powi(3) * jerk / 6.0;
            let bound = bound * stand.model.reach() * stand.model.largest_tie();
            let rows = dance(&stand, &hidden, &dancing);
            let off = rows
                .iter()
                .map(|[a, b, _]| distance(*a, *b))
                .fold(0.0, larger);
            let moved = rows
                .iter()
                .map(|[_, a, b]| distance(*a, *b))
                .fold(0.0, larger);
            assert!(
                off <= bound + EXACT,
                "{}: {off:.1e} of {bound:.1e}",
                stand.name
            );
            assert!(moved > 20.0 * off, "{moved:.1e} {off:.1e}");
        }
    }
}

/// Masses found anew are other parameters, not another formula.
#[test]
fn masses_are_the_parameters_themselves() {
    for stand in Stand::all() {
        let tree = &stand.model.tree;
        let links = 0..tree.links.len();
        let heavier = |a: &usize, b: &usize| tree.links[*a].mass.total_cmp(&tree.links[*b].mass);
        let link = links.max_by(heavier).unwrap();
        let (mass, at) = (0.1 * tree.mass, [0.03, -0.02, 0.05]);
        let share = mass / (tree.mass + mass);
        let map = stand.model.standard_map_of(link);
        let cad = stand.model.cad_params();
        let param = |k: usize| {
            let arm: f64 = (0..3).map(|axis| map[(k, 1 + axis)] * at[axis]).sum();
            (1.0 - share) * cad[k] + share * (map[(k, 0)] + arm)
        };
        let params: Vec<f64> = (0..cad.len()).map(param).collect();
        let program = stand.reading(&[], &params);
        let loaded = stand.world().payload(&tree.links[link].name, mass, at);
        let world = loaded.unwrap();
        for q in stand.postures(POSTURES, 0.7, 5) {
            let posture_context = vec![0.0; stand.posture_context().len()];
            let out = run(&program, &[&q, &[], &posture_context]);
            let off = distance([out[0], out[1]], world.cop(&q));
            assert!(off < EXACT, "{}: {off:e}", stand.name);
        }
    }
}

/// Without a log, a loose joint falls where gravity loads it; near zero moment it may
/// rest on either side, and such postures are not asked.
#[test]
fn loose_joints_fall_where_gravity_puts_them() {
    use sesc_model::{Function, Given};

    let stand = Stand::new("op2", "r_sole");
    let context = stand.context();
    let weight = context.weight();
    for target in ["r_knee", "r_ank_roll", "r_hip_pitch"] {
        let hidden = stand.hidden("backlash", target, &[0.03]);
        let model = super::correction::with(&stand, std::slice::from_ref(&hidden));
        let program = model.program(Function::Cop, Given::Positions).unwrap();
        let world = hide(stand.world(), &stand, &hidden);
        let mut dofs = stand.model.tree.dofs.iter();
        let joint = dofs.position(|dof| dof.joint == target);
        let mut asked = 0;
        for q in stand.postures(60, 0.5, 29) {
            // Half the band turns a moment by at most this.
            let even = 0.015 * weight * stand.model.reach();
            if world.joint_moments(&q)[joint.unwrap()].abs() < 2.0 * even {
                continue;
            }
            asked += 1;
            let out = run(&program, &[&q, &model.params()]);
            let off = distance([out[0], out[1]], world.cop(&q));
            assert!(off < EXACT, "{target}: {off:e}");
        }
        assert!(asked > 15, "{target}: {asked}");
    }
}
