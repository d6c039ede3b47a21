//! One model file, four ways to its readings: `sesc predict`, compiled Rust, and
//! compiled C with parameters passed and with parameters baked in.

use std::fmt::Write as _;
use std::fs;

use sesc_codegen::emit::c::{self, Options, Scalar};
use sesc_codegen::facts::Facts;
use sesc_identify::evaluate::Evaluator;
use sesc_model::effects::Catalog;
use sesc_model::{Function, Given, Model};

use super::correction::{file, with};
use super::generated::{self, Case, Said};
use super::hidden::Hidden;
use super::robots::{Stand, distance, run, urdf};
use sesc_test_support::command::{sesc, stdout};

const POSTURES: usize = 60;
/// Ways of one formula that round differently, m (or the record's unit).
const SAME: f64 = 1e-12;

/// Each effect by itself, then three at a time.
pub fn all(stand: &Stand) -> Vec<(String, Vec<Hidden>)> {
    let context = stand.context();
    let named = |effect: &str, target: &str, values: &[f64]| {
        Hidden::named(&context, effect, target, values)
    };
    let mut cases: Vec<(String, Vec<Hidden>)> = Vec::new();
    for effect in Catalog::standard().iter() {
        let all = Hidden::of(effect, &context, 3);
        let chosen = all[all.len() / 2].clone();
        cases.push((effect.id().name().to_string(), vec![chosen]));
    }
    cases.push((
        "three_of_the_robot".to_string(),
        vec![
            named("joint_compliance", "all", &[400.0]),
            named("backlash", "r_knee", &[0.02]),
            named("payload", "body_link", &[0.4, 0.02, 0.0, 0.05]),
        ],
    ));
    cases.push((
        "three_of_the_sensor".to_string(),
        vec![
            named("cell_gain", "fsr_2", &[0.7]),
            named("sensor_rotation", "-", &[-0.2]),
            named("sensor_offset", "-", &[0.004, -0.003]),
        ],
    ));
    cases.push((
        "three_of_all".to_string(),
        vec![
            named("joint_offset", "l_knee", &[0.05]),
            named("ground_slope", "-", &[0.02, -0.01]),
            named("units", "millimetres", &[]),
        ],
    ));
    cases
}

#[test]
fn prediction_rust_and_c_say_the_same() {
    let stand = Stand::new("op2", "r_sole");
    let folder = generated::folder("compiled");
    let postures: Vec<Vec<f64>> = stand
        .postures(20 * POSTURES, 0.35, 41)
        .into_iter()
        .filter(|q| stand.is_inside(stand.world().cop(q)))
        .take(POSTURES)
        .collect();
    assert_eq!(postures.len(), POSTURES);
    let bytes: Vec<u8> = postures
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let raw = folder.join("postures");
    fs::write(&raw, bytes).unwrap();
    let log = folder.join("postures.csv");
    fs::write(&log, csv(&stand, &postures)).unwrap();
    let mut cases = Vec::new();
    for (module, hidden) in all(&stand) {
        let model = with(&stand, &hidden);
        let case = Case {
            corrects: model
                .program(Function::CorrectCop, Given::Positions)
                .is_some(),
            // Springs of all joints, four rounds of them, make it ten times as long.
            moves: !model.effects_of(Function::Zmp).is_empty()
                && !["three_of_the_robot", "joint_compliance"].contains(&module.as_str()),
            file: file(&stand, &hidden),
            module,
        };
        generated::write(&folder, &stand, &case);
        cases.push((case, hidden));
    }
    let (cases, hidden): (Vec<Case>, Vec<Vec<Hidden>>) = cases.into_iter().unzip();
    let rust = generated::rust(&folder, &cases, &raw, POSTURES);
    for ((case, hidden), rust) in cases.iter().zip(&hidden).zip(&rust) {
        let model = folder.join(format!("{}.toml", case.module));
        let (model, log, urdf) = (model.display(), log.display(), urdf(stand.name));
        let (model, log) = (model.to_string(), log.to_string());
        let arguments = ["--no-snap", "--model", &model, "--data", &log];
        let predicted = stdout(&sesc(&[&["predict", &urdf][..], &arguments].concat()));
        let predicted = cops(&predicted);
        let c = generated::c(&folder, case, &raw, POSTURES);
        let nominal = stand
            .model
            .program(Function::Cop, Given::Positions)
            .unwrap();
        let params = stand.model.cad_params();
        let (mut off, mut moved) = (0.0_f64, 0.0_f64);
        for (k, q) in postures.iter().enumerate() {
            assert_eq!(rust[k].cop, c[k].cop, "{}: bit for bit", case.module);
            let ways = [Some(rust[k].cop), Some(c[k].cop), c[k].baked];
            for way in ways.into_iter().flatten() {
                let apart = distance(way, predicted[k]);
                assert!(apart <= SAME, "{}: {way:?} {:?}", case.module, predicted[k]);
                off = off.max(apart);
            }
            let bare = run(&nominal, &[q, &params]);
            moved = moved.max(distance([bare[0], bare[1]], predicted[k]));
        }
        println!("{}: {off:.1e} m", case.module);
        let shown = with(&stand, hidden).static_effects().next().is_some();
        assert_eq!(moved > 1e-7, shown, "{}: {moved}", case.module);
        corrected(&stand, case, hidden, &postures, [rust, &c]);
        same_body(&with(&stand, hidden), case, &postures, [rust, &c]);
    }
}

/// CoM, Jacobian, velocity and moments of Rust and C are those of the tape, bit for bit.
fn same_body(model: &Model, case: &Case, q: &[Vec<f64>], ways: [&[Said]; 2]) {
    let rates = generated::rates(model.dof());
    let times = |factor: f64| rates.iter().map(|x| factor * x).collect::<Vec<f64>>();
    let (slow, gains) = (times(0.125), times(-0.5));
    let evaluators: Vec<Evaluator> = case
        .body()
        .map(|function| match function {
            Function::Zmp => Evaluator::new(model, function).moving(&slow, &gains),
            _ => Evaluator::new(model, function).moving(&rates, &[]),
        })
        .collect();
    for (k, q) in q.iter().enumerate() {
        let tape: Vec<f64> = evaluators.iter().flat_map(|e| e.run(q, 1)).collect();
        for way in ways {
            assert_eq!(way[k].body, tape, "{}: posture {k}", case.module);
        }
    }
}

/// `correct_cop(cop)` is the CoP of the robot's own effects alone.
fn corrected(stand: &Stand, case: &Case, hidden: &[Hidden], q: &[Vec<f64>], ways: [&[Said]; 2]) {
    let of_robot = hidden
        .iter()
        .filter(|h| !h.instance.effect.is_sensor_effect(&h.instance.target));
    let of_robot: Vec<Hidden> = of_robot.cloned().collect();
    let model = with(stand, &of_robot);
    let program = model.program(Function::Cop, Given::Positions).unwrap();
    for (k, q) in q.iter().enumerate() {
        let bare = run(&program, &[q, &model.params()]);
        for way in ways {
            if let Some(back) = way[k].corrected {
                let apart = distance(back, [bare[0], bare[1]]);
                assert!(apart <= 1e-9, "{}: {back:?} {bare:?}", case.module);
            }
        }
    }
}

fn csv(stand: &Stand, postures: &[Vec<f64>]) -> String {
    let joints = stand.model.tree.dofs.iter().map(|dof| dof.joint.as_str());
    let mut text = format!("pose,{}\n", joints.collect::<Vec<_>>().join(","));
    for (pose, q) in postures.iter().enumerate() {
        let row: Vec<String> = q.iter().map(|x| format!("{x:?}")).collect();
        let _ = writeln!(text, "{pose},{}", row.join(","));
    }
    text
}

/// The last two columns.
fn cops(text: &str) -> Vec<[f64; 2]> {
    let cop = |line: &str| {
        let mut cells = line.rsplit(',').map(|x| x.parse::<f64>().unwrap());
        let y = cells.next().unwrap();
        [cells.next().unwrap(), y]
    };
    text.lines().skip(1).map(cop).collect()
}

/// Firmware in f32 and integers checks itself: `cop`, `model_cop`, `correct_cop` with
/// effects against what the generator computed in f64.
#[test]
fn self_tests_know_effects_in_every_scalar() {
    let stand = Stand::new("two_link", "foot");
    let context = stand.context();
    let folder = generated::folder("scalars");
    let mut corrected = 0;
    for effect in Catalog::standard().iter() {
        let all = Hidden::of(effect, &context, 3);
        let hidden = &all[all.len() / 2..][..1];
        let model = with(&stand, hidden);
        let corrects = model.program(Function::CorrectCop, Given::Positions);
        for scalar in [Scalar::F64, Scalar::F32, Scalar::Fixed32] {
            let package =
                match c::package(&Facts::of(&model), effect.id().name(), &Options::of(scalar)) {
                    Ok(package) => package,
                    // Refused by name: see `records`.
                    Err(_) if scalar == Scalar::Fixed32 => continue,
                    Err(error) => panic!("{}: {error}", effect.id().name()),
                };
            // Effects take away no function.
            let of_ticks = package.source.contains("_cop_ticks(");
            assert_eq!(of_ticks, scalar != Scalar::F64, "{:?}", package.notes);
            let name = effect.id().name();
            let call = format!("{name}_correct_cop(reading, cop);");
            assert_eq!(package.source.contains(&call), corrects.is_some());
            corrected += usize::from(corrects.is_some());
            generated::self_test(&folder, name, &package);
        }
    }
    assert!(corrected >= 3 * 5, "{corrected}");
}
