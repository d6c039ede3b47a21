//! One model file, several ways to its readings: `sesc predict` and the tape, whose bits compiled C
//! has here, and compiled Rust in `tests/it/compiled.rs`.

use sesc_codegen::emit::c::Scalar;
use sesc_identify::evaluate::Evaluator;
use sesc_model::effects::Catalog;
use sesc_model::{Function, Given};

use super::correction::{file, with};
use super::hidden::Hidden;
use super::robots::{Stand, distance};
use crate::c99::bits::has_the_bits_of_rust;
use crate::c99::case::{Case, jobs, servos};
use crate::c99::compiled::{Compiled, parallel};
use crate::c99::draw::draw;
use crate::c99::fixed::trapping;
use sesc_test_support::command::{Folder, Sheet, scratch};

/// Each effect by itself.
pub(crate) fn alone(stand: &Stand) -> Vec<(String, Vec<Hidden>)> {
    let catalog = Catalog::standard();
    let alone = catalog.iter().map(|effect| {
        let all = Hidden::of(effect, &stand.context(), 3);
        let chosen = all[all.len() / 2].clone();
        (effect.id().name().to_string(), vec![chosen])
    });
    alone.collect()
}

/// Three effects of the OP2 at a time.
pub(crate) fn together(stand: &Stand) -> Vec<(String, Vec<Hidden>)> {
    let robot = vec![
        stand.hidden("joint_compliance", "all", &[400.0]),
        stand.hidden("backlash", "r_knee", &[0.02]),
        stand.hidden("payload", "body_link", &[0.4, 0.02, 0.0, 0.05]),
    ];
    let sensor = vec![
        stand.hidden("cell_gain", "fsr_2", &[0.7]),
        stand.hidden("sensor_rotation", "-", &[-0.2]),
        stand.hidden("sensor_offset", "-", &[0.004, -0.003]),
    ];
    let all = vec![
        stand.hidden("joint_offset", "l_knee", &[0.05]),
        stand.hidden("ground_slope", "-", &[0.02, -0.01]),
        stand.hidden("units", "millimetres", &[]),
    ];
    let three = [("robot", robot), ("sensor", sensor), ("all", all)];
    three
        .map(|(of, hidden)| (format!("three_of_the_{of}"), hidden))
        .into()
}

/// Ways of one formula that round differently, m (or the record's unit).
const SAME: f64 = 1e-12;

#[test]
fn predictions_are_those_of_the_tape() {
    const POSTURES: usize = 60;
    let stand = Stand::new("op2", "r_sole");
    let folder = Folder::with("op2");
    let postures = stand.postures_inside(POSTURES);
    let joints = stand.model.tree.dofs.iter().map(|dof| dof.joint.as_str());
    let mut sheet = Sheet::read(&(joints.collect::<Vec<_>>().join(",") + "\n"));
    let texts = postures
        .iter()
        .map(|q| q.iter().map(|x| format!("{x:?}")).collect());
    sheet.rows = texts.collect();
    folder.write("postures.csv", sheet.to_string());
    let nominal = Evaluator::new(&stand.model, Function::Cop).run(&postures.concat(), POSTURES);
    for (name, hidden) in alone(&stand).into_iter().chain(together(&stand)) {
        let text = toml::to_string(&file(&stand, &hidden)).unwrap();
        folder.write("model.toml", text);
        let predict = "predict op2.urdf --no-snap --model model.toml --data postures.csv";
        let predicted = Sheet::read(&folder.stdout(predict)).cop();
        let model = with(&stand, &hidden);
        let tape = Evaluator::new(&model, Function::Cop).run(&postures.concat(), POSTURES);
        assert_eq!(predicted.len(), POSTURES);
        let (mut off, mut moved) = (0.0_f64, 0.0_f64);
        for (k, predicted) in predicted.into_iter().enumerate() {
            let [way, bare] = [&tape, &nominal].map(|all| [all[2 * k], all[2 * k + 1]]);
            off = off.max(distance(way, predicted));
            moved = moved.max(distance(bare, predicted));
        }
        println!("{name}: {off:.1e} m");
        assert!(off <= SAME, "{name}: {off:e}");
        let shown = model.static_effects().next().is_some();
        assert_eq!(moved > 1e-7, shown, "{name}: {moved}");
    }
}

/// Firmware in f32 and integers checks itself, `correct_cop` among all: against what the generator
/// computed in f64. In floats every function has the bits of the tape.
#[test]
fn every_effect_in_c_has_the_bits_of_the_tape() {
    let stand = Stand::new("two_link", "foot");
    let folder = scratch("c99/effects");
    let cases = alone(&stand).into_iter().map(|(name, hidden)| {
        let model = with(&stand, &hidden);
        let servos = servos(&model);
        Case::new(model, &name, servos)
    });
    let cases: Vec<Case> = cases.collect();
    let corrects = |case: &Case| {
        let correction = case.model.program(Function::CorrectCop, Given::Positions);
        correction.is_some()
    };
    let corrected = cases.iter().filter(|case| corrects(case)).count();
    assert!(corrected >= 5, "{corrected}");
    parallel(jobs(&cases), |(case, scalar)| {
        let source = case.package(scalar).source;
        let call = format!("{}_correct_cop(reading, cop);", case.name);
        assert_eq!(source.contains(&call), corrects(case), "{}", case.name);
        let entries = case.entries(scalar);
        let compiled = match scalar {
            Scalar::Fixed32 => trapping(&folder, case),
            _ => Compiled::plain(&folder, case, scalar, "cc", "-O1"),
        };
        let drawn = draw(case, 60, 41, &*compiled.hold());
        has_the_bits_of_rust(case, scalar, &compiled, &entries, &drawn);
    });
}
