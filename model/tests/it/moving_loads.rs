//! Loads on a robot that moves: in closed form, and against a URDF that has them.

use sesc_model::effects::{self, Catalog, EffectContext, PostureContext};
use sesc_model::tape::{Kernels, Tape, Values};
use sesc_model::{Function, Given, Model};

use crate::{GRAVITY, LIFT, PENDULUM, model};

/// How the joints are and move.
struct Motion<'a> {
    q: &'a [f64],
    rates: &'a [f64],
    gains: &'a [f64],
    tilt: [f64; 2],
}

/// The reading of a robot with `effect` at `target`, of `values`, whose bare self has the ZMP
/// `bare` beyond its static CoP and is lifted by `lift`.
fn reading(
    model: &Model,
    (effect, target, values): (&str, &str, &[f64]),
    motion: &Motion,
    (bare, lift): ([f64; 2], f64),
) -> [f64; 2] {
    let mut context = EffectContext::new(model, &[], true, Catalog::standard());
    context.moving = true;
    let mut instances = effects::instances(&context).into_iter();
    let label = format!("{effect}:{target}");
    let instance = instances.find(|one| one.label(&context) == label).unwrap();
    let unknowns = instance.effect.unknowns(&context, &instance.target, values);
    let layout = PostureContext::of(model);
    let mut posture = vec![0.0; layout.len()];
    posture[layout.lift()] = lift;
    for axis in 0..2 {
        posture[layout.tilt(axis)] = motion.tilt[axis];
        posture[layout.shift(axis)] = bare[axis];
    }
    for j in 0..model.dof() {
        posture[layout.rate(j)] = motion.rates[j];
        posture[layout.acceleration(j)] = motion.gains[j];
    }
    let program = effects::reading(&context, &[instance], &model.cad_params());
    let tape = Tape::new(&program);
    let mut out = vec![0.0; tape.outputs()];
    let arguments = [motion.q, &unknowns, &posture].map(Values::Shared);
    tape.run(&arguments, 1, &mut out, Kernels::LIBM);
    [out[0], out[tape.outputs() / 2]]
}

/// A point over the pivot with its acceleration: `(x, z)` in the rod, turned.
fn on_rod([x, z]: [f64; 2], angle: f64, rate: f64, gain: f64) -> [f64; 4] {
    let (s, c) = angle.sin_cos();
    let (along, up) = (c * x + s * z, c * z - s * x);
    [
        along,
        0.05 + up,
        gain * up - rate * rate * along,
        -gain * along - rate * rate * up,
    ]
}

/// The CoP of masses (kg, x, y, z, ẍ, z̈), forces (N, x, z, F_x, F_z) beside them.
fn cop(masses: &[[f64; 6]], tilt: [f64; 2], force: [f64; 4]) -> [f64; 2] {
    let [at, height, pulls, lifts] = force;
    let load: f64 = masses.iter().map(|[m, .., up]| m * (GRAVITY + up)).sum();
    let moment = |axis: usize| -> f64 {
        let of = |[m, x, y, z, along, up]: &[f64; 6]| {
            let (place, push) = if axis == 0 { (x, *along) } else { (y, 0.0) };
            m * ((GRAVITY + up) * place - z * (push - GRAVITY * tilt[axis]))
        };
        masses.iter().map(of).sum()
    };
    let pulled = [height * pulls - at * lifts, 0.0];
    [0, 1].map(|axis| (moment(axis) + pulled[axis]) / (load - lifts))
}

#[test]
fn a_load_on_a_pendulum_is_its_closed_form() {
    let model = model(PENDULUM, "foot");
    for (angle, rate, gain) in [(0.3, 0.0, 0.0), (0.3, 2.0, 0.0), (-0.2, 1.5, 6.0)] {
        for tilt in [[0.0; 2], [0.03, -0.02]] {
            let [x, z, along, up] = on_rod([0.0, 0.4], angle, rate, gain);
            let own = [
                [0.5, 0.01, 0.02, 0.02, 0.0, 0.0],
                [2.0, x, 0.0, z, along, up],
            ];
            let mut still = own;
            still[1][4..].fill(0.0);
            let (there, here) = (cop(&own, tilt, [0.0; 4]), cop(&still, tilt, [0.0; 4]));
            let bare = [there[0] - here[0], there[1] - here[1]];
            let lift = 2.0 * up / 2.5 / GRAVITY;
            let motion = Motion {
                q: &[angle],
                rates: &[rate],
                gains: &[gain],
                tilt,
            };
            for mass in [0.4, -0.2] {
                let point = on_rod([0.07, 0.5], angle, rate, gain);
                let load = [mass, point[0], 0.03, point[1], point[2], point[3]];
                let expected = cop(&[own[0], own[1], load], tilt, [0.0; 4]);
                let values = [mass, 0.07, 0.03, 0.5];
                let found = reading(&model, ("payload", "rod", &values), &motion, (bare, lift));
                for axis in 0..2 {
                    let off = (found[axis] - expected[axis]).abs();
                    assert!(off < 1e-6, "{angle} {mass}: {found:?} {expected:?}");
                }
            }
            // A force is not accelerated with the rod.
            let [x, z, ..] = on_rod([0.0, 0.0], angle, rate, gain);
            let expected = cop(&own, tilt, [x, z, 1.5, 4.0]);
            let values = [1.5, 0.0, 4.0];
            let pulled = ("external_force", "rod", &values[..]);
            let found = reading(&model, pulled, &motion, (bare, lift));
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off < 1e-12, "{angle}: {found:?} {expected:?}");
        }
    }
}

/// The same in space: a weight in the hand is a link of another URDF, whose ZMP has a test of
/// its own.
#[test]
fn a_load_in_space_is_that_of_a_urdf_which_has_it() {
    let load = r#"<link name="load"><inertial><mass value="0.7"/></inertial></link>
        <joint name="grip" type="fixed"><parent link="hand"/><child link="load"/>
        <origin xyz="0.12 -0.03 0.05"/></joint>"#;
    let bare = model(&LIFT.replace("LOAD", ""), "base");
    let full = model(&LIFT.replace("LOAD", load), "base");
    let motion = Motion {
        q: &[0.15, 0.7, -0.5],
        rates: &[0.4, -1.2, 2.0],
        gains: &[-1.0, 3.0, 5.0],
        tilt: [0.0; 2],
    };
    let zmp = |model: &Model, moves: bool| {
        let still = [0.0; 3];
        let of = |moving| if moves { moving } else { &still[..] };
        let (rates, gains) = (of(motion.rates), of(motion.gains));
        let program = model.program(Function::Zmp, Given::Positions).unwrap();
        let params = model.cad_params();
        let arguments = [motion.q, rates, gains, &params].map(Values::Shared);
        let mut out = [0.0; 2];
        Tape::new(&program).run(&arguments, 1, &mut out, Kernels::LIBM);
        out
    };
    // The CoM along the path of the joints, differentiated.
    let height = |t: f64| {
        let moves = motion.rates.iter().zip(motion.gains).zip(motion.q);
        let q = moves.map(|((v, a), q)| q + t * v + 0.5 * t * t * a);
        bare.com_by_sum(&q.collect::<Vec<_>>())[2]
    };
    let step = 1e-3;
    let lift = (height(step) - 2.0 * height(0.0) + height(-step)) / (step * step) / GRAVITY;
    let (there, here) = (zmp(&bare, true), zmp(&bare, false));
    let shift = [there[0] - here[0], there[1] - here[1]];
    let values = [0.7, 0.12, -0.03, 0.05];
    let found = reading(&bare, ("payload", "hand", &values), &motion, (shift, lift));
    let expected = zmp(&full, true);
    let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
    // Without what moves the load it would be far off.
    let standing = zmp(&full, false);
    let without = [standing[0] + shift[0], standing[1] + shift[1]];
    let missed = (without[0] - expected[0]).hypot(without[1] - expected[1]);
    assert!(off < 2e-6, "{found:?} {expected:?}");
    assert!(missed > 4e-3, "{missed}");
}
