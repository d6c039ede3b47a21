//! The measurement with effects, against closed forms and against other URDFs.

use sesc_model::effects::{self, Catalog, EffectContext, Instance, PostureContext};
use sesc_model::program::Program;
use sesc_model::tape::{Kernels, Tape, Values};
use sesc_model::{Model, ModelFile};

use crate::{GRAVITY, LIFT, PENDULUM, model};
const MASSES: [f64; 2] = [0.5, 2.0];
const MASS: f64 = 2.5;
/// Heights over the sole and over the pivot, m.
const PIVOT: f64 = 0.05;
const HEAVY: f64 = 0.4;
const TIP: f64 = 0.7;

/// What a program says at `q` with `unknowns`, in a log whose tilt is `tilt`.
fn run(model: &Model, program: &Program, q: &[f64], unknowns: &[f64], tilt: [f64; 2]) -> Vec<f64> {
    let layout = PostureContext::of(model);
    let mut posture_context = vec![0.0; layout.len()];
    for axis in 0..2 {
        posture_context[layout.tilt(axis)] = tilt[axis];
    }
    let tape = Tape::new(program);
    let mut out = vec![0.0; tape.outputs()];
    let arguments = [q, unknowns, &posture_context].map(Values::Shared);
    tape.run(&arguments, 1, &mut out, Kernels::LIBM);
    out
}

/// An effect by name, with values as people know them.
fn effect(
    context: &EffectContext,
    name: &str,
    target: &str,
    values: &[f64],
) -> (Instance, Vec<f64>) {
    let effect = Catalog::standard().named(name).unwrap();
    let target = context.target_named(effect, target).unwrap();
    let unknowns = effect.unknowns(context, &target, values);
    (Instance { effect, target }, unknowns)
}

fn reading(model: &Model, effects: &[(Instance, Vec<f64>)], q: &[f64], tilt: [f64; 2]) -> [f64; 2] {
    let context = EffectContext::new(model, &[], true, Catalog::standard());
    let instances: Vec<Instance> = effects.iter().map(|(i, _)| i.clone()).collect();
    let unknowns: Vec<f64> = effects.iter().flat_map(|(_, x)| x.clone()).collect();
    let program = effects::reading(&context, &instances, &model.cad_params());
    let out = run(model, &program, q, &unknowns, tilt);
    [out[0], out[out.len() / 2]]
}

#[track_caller]
fn assert_near(a: [f64; 2], b: [f64; 2], tolerance: f64) {
    assert!((a[0] - b[0]).hypot(a[1] - b[1]) <= tolerance, "{a:?} {b:?}");
}

#[test]
fn a_slope_is_gravity_that_leans() {
    let model = model(&LIFT.replace("LOAD", ""), "base");
    let context = EffectContext::new(&model, &[], true, Catalog::standard());
    let soft = effect(&context, "joint_compliance", "all", &[200.0]);
    for slope in [[0.02, -0.03], [-0.3, 0.1]] {
        let leaning = effect(&context, "ground_slope", "-", &slope);
        for q in [[0.1, 0.5, -0.3], [0.3, -1.2, 0.9]] {
            let [x, y, z] = model.com_by_sum(&q);
            let found = reading(&model, std::slice::from_ref(&leaning), &q, [0.0; 2]);
            assert_near(found, [x + slope[0] * z, y + slope[1] * z], 1e-15);
            // A log that states gravity says the same; springs feel it alike.
            let both = reading(&model, &[leaning.clone(), soft.clone()], &q, [0.0; 2]);
            let stated = reading(&model, std::slice::from_ref(&soft), &q, slope);
            assert_near(both, stated, 1e-15);
            assert!((both[0] - found[0]).abs() > 1e-5, "springs give way");
        }
    }
}

#[test]
fn a_pull_on_a_pendulum_is_a_sum_of_moments() {
    let model = model(PENDULUM, "foot");
    let context = EffectContext::new(&model, &[], true, Catalog::standard());
    for force in [
        [2.0, 0.0, 0.0],
        [0.0, -1.5, 0.0],
        [1.0, 0.5, 4.0],
        [0.3, 0.2, -6.0],
    ] {
        // Any link of the body: the force is at that link's own origin.
        let (instance, unknowns) = effect(&context, "external_force", "tip", &force);
        for q in [-0.8, 0.0, 0.3_f64] {
            let (s, c) = q.sin_cos();
            let weight = MASS * GRAVITY;
            let ground = weight - force[2];
            let com = [
                (MASSES[0] * 0.01 + MASSES[1] * HEAVY * s) / MASS,
                MASSES[0] * 0.02 / MASS,
            ];
            let tip = [TIP * s, 0.0, PIVOT + TIP * c];
            let expected = [0, 1].map(|axis| {
                let lifted = force[axis] * tip[2] - force[2] * tip[axis];
                (weight * com[axis] + lifted) / ground
            });
            let pull = [(instance.clone(), unknowns.clone())];
            assert_near(reading(&model, &pull, &[q], [0.0; 2]), expected, 1e-14);
            // About y through the pivot, over the weight on the ground.
            let gravity = MASSES[1] * GRAVITY * HEAVY * s;
            let moment = gravity + TIP * (force[0] * c - force[2] * s);
            let own = std::slice::from_ref(&instance);
            let moments = effects::moments(&context, own, &model.cad_params());
            let found = run(&model, &moments, &[q], &unknowns, [0.0; 2])[0];
            assert!((found - moment / ground).abs() < 1e-14, "{found}");
        }
    }
}

/// Only what a posture shows makes another function of the CoP.
#[test]
fn a_model_with_nothing_to_show_keeps_its_functions() {
    use sesc_model::{EffectRecord, Function, Given, Quantity};
    let bare = model(PENDULUM, "foot");
    let with = |effect: &str, names: &[&str]| {
        let mut file = ModelFile::from_values(&bare, &bare.cad_params(), None, "data");
        let value = Quantity {
            value: 0.01,
            std: None,
        };
        file.effects.push(EffectRecord {
            effect: effect.into(),
            target: "-".into(),
            parameters: names.iter().map(|name| (name.to_string(), value)).collect(),
            ..EffectRecord::default()
        });
        bare.clone().with_file(file).unwrap()
    };
    // Only a log shows these.
    let effects: [(&str, &[&str]); 2] = [
        ("time_delay", &["delay_s"]),
        ("sensor_drift", &["drift_x_m", "drift_y_m"]),
    ];
    for (effect, names) in effects {
        let model = with(effect, names);
        let cop = model.program(Function::Cop, Given::SinesCosines);
        assert!(cop.is_some(), "{effect}");
        let correct = model.program(Function::CorrectCop, Given::Positions);
        assert!(correct.is_none(), "{effect}");
    }
}
