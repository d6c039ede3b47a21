//! Functions of the body with each effect, against the virtual robot that has it.
//!
//! The robot bends itself: where its CoM really is when encoders read q, how that changes
//! with q (by differences), and what gravity does to its joints. Springs are not exact by
//! construction (four rounds of a fixed point); the Jacobian is exact for what they give.

use std::collections::BTreeMap;

use sesc_identify::evaluate::Evaluator;
use sesc_model::effects::Catalog;
use sesc_model::tape::Values;
use sesc_model::{Function, Given};
use sesc_reference::{GRAVITY, World};

use super::composed::slopes;
use super::correction::with;
use super::hidden::{Hidden, hide_all};
use super::robots::Stand;
use crate::c99::bounds::largest;

/// What rounding and joints that come to rest within 1e-13 rad leave, m.
const EXACT: f64 = 4e-12;
const POSTURES: usize = 6;

/// What the virtual robot does when its encoders read q.
struct Truth {
    com: Vec<f64>,
    /// ∂CoM/∂q by central differences, row-major.
    jacobian: Vec<f64>,
    /// Moments of gravity over weight, m.
    moments: Vec<f64>,
}

impl Truth {
    fn of(world: &World, q: &[f64]) -> Truth {
        let mass: f64 = world.robot().links().iter().map(|link| link.mass_kg).sum();
        let moments = world.joint_moments(q);
        Truth {
            com: world.com(q).as_slice().to_vec(),
            // The error of fourth-order differences is below that of their rounding.
            jacobian: slopes(q, |q| world.com(q).into()),
            moments: moments.iter().map(|m| m / (mass * GRAVITY)).collect(),
        }
    }
}

fn shown(errors: &[f64; 3]) -> String {
    let [com, jacobian, moments] = errors;
    format!("com {com:.1e} m, jacobian {jacobian:.1e}, moments {moments:.1e}")
}

/// How far the functions of the model are from the bent robot: CoM, Jacobian, moments, m.
fn compare(stand: &Stand, hidden: &[Hidden], given: Given) -> Option<[f64; 3]> {
    let model = with(stand, hidden);
    let world = hide_all(stand.world(), stand, hidden);
    let of = |function| Evaluator::variant(&model, function, given, model.params());
    let com = of(Function::Com)?;
    let jacobian = of(Function::ComJacobian)?;
    let moments = of(Function::GravityMoments)?;
    let rates: Vec<f64> = (0..model.dof()).map(|j| 1.0 / (1.0 + j as f64)).collect();
    let velocity = of(Function::ComVelocity)?;
    let mut worst = [0.0_f64; 3];
    for q in decided(stand, hidden) {
        let truth = Truth::of(&world, &q);
        let slopes = jacobian.run(&q, 1);
        let along = |row: &[f64]| row.iter().zip(&rates).map(|(a, b)| a * b).sum();
        let moved: Vec<f64> = slopes.chunks(model.dof()).map(along).collect();
        // The velocity is that of the Jacobian itself, whatever it is worth.
        let motion = [Values::Shared(&rates); 2];
        let off = largest(&velocity.run_moving(&q, motion, 1), &moved);
        assert!(off < 1e-12, "{hidden:?}: {off:.1e} m/s off its Jacobian");
        let found = [
            largest(&com.run(&q, 1), &truth.com),
            largest(&slopes, &truth.jacobian),
            largest(&moments.run(&q, 1), &truth.moments),
        ];
        worst = [0, 1, 2].map(|k| worst[k].max(found[k]));
    }
    Some(worst)
}

/// Postures in which gravity says on which end of its band every loose joint rests,
/// wherever in their bands the others are. In between it depends on how it got there.
fn decided(stand: &Stand, hidden: &[Hidden]) -> Vec<Vec<f64>> {
    let loose = |h: &&Hidden| h.instance.effect.id().name() == "backlash";
    let Some(backlash) = hidden.iter().find(loose) else {
        return stand.postures(POSTURES, 0.35, 23);
    };
    let (half, world) = (0.5 * backlash.values[0], stand.world());
    let dofs = &stand.model.tree.dofs;
    let loose: Vec<usize> = (0..dofs.len())
        .filter(|&j| !dofs[j].prismatic)
        .filter(|&j| ["all", &dofs[j].joint].contains(&backlash.target.as_str()))
        .collect();
    let is_decided = |q: &Vec<f64>| {
        let moments = world.joint_moments(q);
        let mut budget = vec![0.0; q.len()];
        for &i in &loose {
            let mut moved = q.clone();
            moved[i] += half;
            let with = world.joint_moments(&moved);
            for &j in &loose {
                budget[j] += 1.5 * (with[j] - moments[j]).abs();
            }
        }
        loose.iter().all(|&j| moments[j].abs() > budget[j])
    };
    let drawn = stand.postures(300, 0.5, 23).into_iter();
    drawn.filter(is_decided).take(POSTURES).collect()
}

/// How far they may be.
fn allowed(stand: &Stand, hidden: &Hidden) -> [f64; 3] {
    // Differences: rounding of the CoM over the step, and a dead band's end that moves.
    let reach = stand.model.reach();
    let exact = [EXACT, 2e-9, EXACT].map(|error| error * reach.max(1.0));
    if hidden.instance.effect.id().name() != "joint_compliance" {
        return exact;
    }
    let gravity = stand.context().weight() * reach;
    let joints = if hidden.target == "all" { 3.0 } else { 1.0 };
    let softness: f64 = joints * gravity / hidden.values[0];
    let left = reach * softness.powi(5);
    // What is left of a deflection changes with each of its five factors.
    [0, 1, 2].map(|k| exact[k] + [1.0, 10.0, 5.0][k] * left)
}

#[test]
fn every_effect_of_the_body_moves_com_jacobian_and_moments_as_it_moves_the_robot() {
    let mut worst: BTreeMap<&str, [f64; 3]> = BTreeMap::new();
    for stand in Stand::all() {
        let context = stand.context();
        for effect in Catalog::standard().iter() {
            let name = effect.id().name();
            for hidden in Hidden::of(effect, &context, 3) {
                if !effect.changes_body(&hidden.instance.target) {
                    continue;
                }
                // The virtual robot's degrees count prismatic joints in millimetres.
                if name == "units" && stand.model.tree.dofs.iter().any(|dof| dof.prismatic) {
                    continue;
                }
                let allowed = allowed(&stand, &hidden);
                for given in [Given::Positions, Given::SinesCosines] {
                    if stand.model.program(Function::Com, given).is_none() {
                        continue; // a mimic takes half an angle
                    }
                    let found = compare(&stand, std::slice::from_ref(&hidden), given);
                    let Some(found) = found else {
                        assert_ne!(given, Given::Positions);
                        // Sines of q do not tell those of 1.03 q.
                        assert!(["joint_scale", "units"].contains(&name), "{hidden:?}");
                        continue;
                    };
                    let within = (0..3).all(|k| found[k] <= allowed[k]);
                    let of = format!("{} of {}", shown(&found), shown(&allowed));
                    assert!(within, "{} {hidden:?} {given:?}: {of}", stand.name);
                    let worst = worst.entry(name).or_default();
                    *worst = [0, 1, 2].map(|k| worst[k].max(found[k]));
                }
            }
        }
    }
    for (effect, worst) in &worst {
        println!("{effect:<20} {}", shown(worst));
        // Nothing compared is nothing off.
        assert!(worst[0] > 0.0, "{effect}");
    }
    let known: Vec<&str> = worst.into_keys().collect();
    let expected = "backlash joint_compliance joint_offset joint_scale joint_sign joint_swap \
                    payload units";
    assert_eq!(known.join(" "), expected);
}

/// Effects that meet in one body.
#[test]
fn effects_of_the_body_meet() {
    let stand = Stand::new("op2", "r_sole");
    let hidden = [
        stand.hidden("payload", "body_link", &[0.5, 0.02, 0.01, 0.1]),
        stand.hidden("joint_compliance", "r_knee", &[300.0]),
        stand.hidden("joint_compliance", "r_ank_pitch", &[250.0]),
        stand.hidden("joint_offset", "r_knee", &[0.03]),
        stand.hidden("joint_scale", "l_knee", &[1.05]),
        stand.hidden("backlash", "l_sho_pitch", &[0.02]),
    ];
    let found = compare(&stand, &hidden, Given::Positions).unwrap();
    println!("{}", shown(&found));
    for (found, allowed) in found.into_iter().zip([1e-6, 1e-5, 5e-6]) {
        assert!(found < allowed, "{found:.1e} of {allowed:.1e}");
    }
}

/// What the ground and the sensor do is part of the CoP alone.
#[test]
fn effects_of_ground_and_sensor_leave_the_body_alone() {
    let stand = Stand::new("op2", "r_sole");
    let hidden = [
        stand.hidden("ground_slope", "-", &[0.05, -0.02]),
        stand.hidden("external_force", "body_link", &[1.0, -2.0, 3.0]),
        stand.hidden("sensor_gain", "-", &[1.2, 0.9]),
        stand.hidden("cell_gain", "fsr_2", &[0.7]),
        stand.hidden("units", "millimetres", &[]),
    ];
    let model = with(&stand, &hidden);
    let q = stand.postures(4, 0.5, 5).concat();
    use Function::{Cop, CopJacobian, CorrectCop, Zmp};
    for function in Function::ALL
        .into_iter()
        .filter(|f| ![CopJacobian, CorrectCop, Zmp].contains(f))
    {
        let [plain, own] = [&stand.model, &model].map(|m| Evaluator::new(m, function).run(&q, 4));
        assert_eq!(own == plain, function != Cop, "{function:?}");
    }
}

/// Rows take wiring, offset and scale: rows times parameters is the CoM of the model
/// with those, for any parameters.
#[test]
fn regressor_rows_take_the_kinematic_effects() {
    let stand = Stand::new("op2", "r_sole");
    let kinematic = [
        stand.hidden("joint_offset", "r_knee", &[0.1]),
        stand.hidden("joint_scale", "r_ank_pitch", &[1.2]),
        stand.hidden("joint_swap", "r_hip_roll,l_hip_roll", &[]),
        stand.hidden("joint_sign", "head_pan", &[]),
    ];
    let world = hide_all(stand.world(), &stand, &kinematic);
    let mut all = kinematic.to_vec();
    all.push(stand.hidden("payload", "body_link", &[0.5, 0.0, 0.0, 0.1]));
    all.push(stand.hidden("joint_compliance", "all", &[200.0]));
    let model = with(&stand, &all);
    let r = model.cad_params();
    for q in stand.postures(POSTURES, 0.5, 9) {
        let com = world.com(&q);
        for function in [Function::Regressor, Function::RegressorCop] {
            let rows = Evaluator::new(&model, function).run(&q, 1);
            for (row, truth) in rows.chunks(r.len()).zip(com.iter()) {
                let found: f64 = row.iter().zip(&r).map(|(y, r)| y * r).sum();
                assert!((found - truth).abs() < EXACT, "{function:?}");
            }
        }
    }
}
