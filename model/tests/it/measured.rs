//! The measurement with effects, against closed forms and against other URDFs.

use sesc_model::effects::{self, Catalog, EffectContext, Instance, PostureContext};
use sesc_model::program::Program;
use sesc_model::tape::{Kernels, Tape, Values};
use sesc_model::{Model, ModelFile, Snapping, urdf};

const GRAVITY: f64 = 9.80665;

/// An inverted pendulum: `rod` rotates about y, 0.05 m above the sole.
const PENDULUM: &str = r#"<robot name="pendulum">
    <link name="foot"><inertial><mass value="0.5"/><origin xyz="0.01 0.02 0.02"/></inertial></link>
    <link name="rod"><inertial><mass value="2"/><origin xyz="0 0 0.4"/></inertial></link>
    <link name="tip"/>
    <joint name="ankle" type="revolute"><parent link="foot"/><child link="rod"/>
        <origin xyz="0 0 0.05"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
    <joint name="top" type="fixed"><parent link="rod"/><child link="tip"/>
        <origin xyz="0 0 0.7"/></joint>
</robot>"#;
const MASSES: [f64; 2] = [0.5, 2.0];
const MASS: f64 = 2.5;
/// Heights over the sole and over the pivot, m.
const PIVOT: f64 = 0.05;
const HEAVY: f64 = 0.4;
const TIP: f64 = 0.7;

/// A lift that carries an arm with a skewed axis, and a hand that follows.
const LIFT: &str = r#"<robot name="lift">
    <link name="base"><inertial><mass value="3"/><origin xyz="0.01 0 0.1"/></inertial></link>
    <link name="mast"><inertial><mass value="1"/><origin xyz="0 0.1 0.2"/></inertial></link>
    <link name="arm"><inertial><mass value="0.8"/><origin xyz="0.2 0 0.05"/></inertial></link>
    <link name="hand"><inertial><mass value="MASS"/><origin xyz="COM"/></inertial></link>
    <joint name="rail" type="prismatic"><parent link="base"/><child link="mast"/>
        <axis xyz="0.1 0 1"/><limit lower="0" upper="0.4" effort="1" velocity="1"/></joint>
    <joint name="shoulder" type="revolute"><parent link="mast"/><child link="arm"/>
        <origin xyz="0 0 0.3" rpy="0.3 0.2 0.1"/><axis xyz="1 2 0.5"/>
        <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
    <joint name="wrist" type="revolute"><parent link="arm"/><child link="hand"/>
        <origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
        <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
</robot>"#;

fn model(text: &str, support: &str) -> Model {
    let description = urdf::parse(text, "robot.urdf").unwrap();
    Model::new(&description, support, Snapping::Off).unwrap()
}

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
fn a_payload_is_a_heavier_link_of_the_urdf() {
    let hand = |mass: f64, com: [f64; 3]| {
        let com = com.map(|x| format!("{x:?}")).join(" ");
        LIFT.replace("MASS", &format!("{mass:?}"))
            .replace("COM", &com)
    };
    let (mass, com) = (0.5, [0.05, 0.01, -0.02]);
    for (load, at) in [
        (0.3, [0.1, -0.05, 0.02]),
        (2.0, [0.0, 0.2, 0.0]),
        (-0.2, com),
    ] {
        let both = mass + load;
        let joined = [0, 1, 2].map(|k| (mass * com[k] + load * at[k]) / both);
        // The base stands, or the hand does, whose own load rests on the ground.
        for support in ["base", "hand"] {
            let bare = model(&hand(mass, com), support);
            let heavy = model(&hand(both, joined), support);
            let context = EffectContext::new(&bare, &[], true, Catalog::standard());
            let values = [load, at[0], at[1], at[2]];
            let payload = effect(&context, "payload", "hand", &values);
            for q in [[0.1, 0.5, -0.3], [0.3, -1.2, 0.9]] {
                let expected = heavy.com_by_sum(&q);
                let found = reading(&bare, std::slice::from_ref(&payload), &q, [0.0; 2]);
                assert_near(found, [expected[0], expected[1]], 1e-14);
            }
        }
    }
}

#[test]
fn a_slope_is_gravity_that_leans() {
    let robot = LIFT
        .replace("MASS", "0.5")
        .replace("COM", "0.05 0.01 -0.02");
    let model = model(&robot, "base");
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
            let program = effects::reading(
                &context,
                std::slice::from_ref(&instance),
                &model.cad_params(),
            );
            let out = run(&model, &program, &[q], &unknowns, [0.0; 2]);
            assert_near([out[0], out[out.len() / 2]], expected, 1e-14);
            // About y through the pivot, over the weight on the ground.
            let gravity = MASSES[1] * GRAVITY * HEAVY * s;
            let moment = gravity + TIP * (force[0] * c - force[2] * s);
            let moments = effects::moments(
                &context,
                std::slice::from_ref(&instance),
                &model.cad_params(),
            );
            let found = run(&model, &moments, &[q], &unknowns, [0.0; 2])[0];
            assert!((found - moment / ground).abs() < 1e-14, "{found}");
        }
    }
}

/// `φ = q + τ(φ)/k` to four rounds: what is left is the fifth power of gravity's
/// stiffness over the spring's, of half a radian.
#[test]
fn a_spring_holds_a_pendulum_where_moments_balance() {
    let model = model(PENDULUM, "foot");
    let context = EffectContext::new(&model, &[], true, Catalog::standard());
    let gravity = MASSES[1] * GRAVITY * HEAVY;
    for softness in [0.2, 0.05, 0.01] {
        let stiffness = gravity / softness;
        let (instance, unknowns) = effect(&context, "joint_compliance", "ankle", &[stiffness]);
        let program = effects::joints(&context, &[instance], &model.cad_params());
        for q in [-0.4, 0.2, 0.5_f64] {
            let mut rest = q;
            for _ in 0..200 {
                rest = q + softness * rest.sin();
            }
            let found = run(&model, &program, &[q], &unknowns, [0.0; 2])[0];
            let left = 0.5 * softness.powi(5) + 1e-15;
            assert!((found - rest).abs() <= left, "{found} {rest} {left:.1e}");
            assert!((rest - q).abs() > 0.5 * softness * q.abs().sin());
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
        assert!(
            model
                .program(Function::CorrectCop, Given::Positions)
                .is_none()
        );
    }
}
