//! The zero-moment point: against a pendulum and a bow in closed form, and against the CoM
//! and its acceleration where parameters are not those of CAD.

use sesc::verify::JointMotion;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::tape::Values;
use sesc_model::{Function, Given, Model, Snapping};
use sesc_test_support::trees::{Kind, tree};

const G: f64 = 9.80665;

fn model(text: &str, support: &str) -> Model {
    let robot = Robot::parse(text, "robot.urdf").unwrap();
    robot.model(support, Snapping::Off, None).unwrap()
}

fn zmp(model: &Model, q: &[f64], rates: &[f64], gains: &[f64], r: &[f64]) -> [f64; 2] {
    let evaluator = Evaluator::with_params(model, Function::Zmp, r.to_vec());
    let p = evaluator.run_moving(q, [rates, gains].map(Values::Shared), 1);
    [p[0], p[1]]
}

/// A foot of 1 kg, a leg of 3 kg and 0.4 m from an ankle 0.1 m high, a trunk of 5 kg on it.
const BOW: &str = r#"<robot name="bow">
  <link name="foot"><inertial><origin xyz="0.02 0 0.03"/><mass value="1"/></inertial></link>
  <link name="leg"><inertial><origin xyz="0 0 0.25"/><mass value="3"/>
    <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.01"/></inertial></link>
  <link name="trunk"><inertial><origin xyz="0 0 0.2"/><mass value="5"/>
    <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.15" iyz="0" izz="0.05"/></inertial></link>
  <joint name="ankle" type="continuous"><parent link="foot"/><child link="leg"/>
    <origin xyz="0 0 0.1"/><axis xyz="0 1 0"/></joint>
  <joint name="hip" type="continuous"><parent link="leg"/><child link="trunk"/>
    <origin xyz="0 0 0.4"/><axis xyz="0 1 0"/></joint>
</robot>"#;

/// A point of the plane with what moves it: x, z and their second derivatives.
fn on_arm(length: f64, [angle, rate, gain]: [f64; 3]) -> [f64; 4] {
    let (s, c) = angle.sin_cos();
    [
        length * s,
        length * c,
        length * (c * gain - s * rate * rate),
        -length * (s * gain + c * rate * rate),
    ]
}

/// Moments of weight, inertia and turning about the origin, over the load on the ground.
fn bow_by_hand(q: [f64; 2], rates: [f64; 2], gains: [f64; 2]) -> f64 {
    let leg = [q[0], rates[0], gains[0]];
    let trunk = [q[0] + q[1], rates[0] + rates[1], gains[0] + gains[1]];
    let hip = on_arm(0.4, leg);
    let above = on_arm(0.2, trunk);
    let trunk_at = [0, 1, 2, 3].map(|k| hip[k] + above[k]);
    let mut bodies = vec![(1.0, [0.02, 0.03, 0.0, 0.0])];
    for (mass, [x, z, ax, az]) in [(3.0, on_arm(0.25, leg)), (5.0, trunk_at)] {
        bodies.push((mass, [x, z + 0.1, ax, az]));
    }
    let load: f64 = bodies.iter().map(|(m, [.., az])| m * (G + az)).sum();
    let moment: f64 = bodies
        .iter()
        .map(|(m, [x, z, ax, az])| m * (x * (G + az) - z * ax))
        .sum();
    (moment - 0.04 * leg[2] - 0.15 * trunk[2]) / load
}

#[test]
fn a_bow_is_its_closed_form() {
    let model = model(BOW, "foot");
    let r = model.cad_params();
    for (q, rates, gains) in [
        ([0.0, 0.0], [0.0, 0.0], [0.0, 0.0]),
        ([0.0, 0.0], [0.0, 0.0], [1.0, 0.0]),
        ([0.1, 0.6], [0.0, 0.8], [0.0, -2.0]),
        ([-0.2, 1.1], [0.7, -1.5], [3.0, 2.0]),
        ([0.3, -0.9], [-2.0, 3.0], [-4.0, 9.0]),
    ] {
        let [x, y] = zmp(&model, &q, &rates, &gains, &r);
        let expected = bow_by_hand(q, rates, gains);
        assert!((x - expected).abs() < 1e-14, "{q:?}: {x} {expected}");
        assert_eq!(y, 0.0, "{q:?}");
    }
}

/// A trunk that is thrown forward pushes the ground back: its own inertia, and 5 kg at the end of an
/// arm of 0.2 m, 0.7 m above the ground.
#[test]
fn a_trunk_thrown_forward_moves_the_zmp_back() {
    let model = model(BOW, "foot");
    let [x, _] = zmp(
        &model,
        &[0.0; 2],
        &[0.0; 2],
        &[0.0, 1.0],
        &model.cad_params(),
    );
    let standing = 0.02 / 9.0;
    let expected = standing - (5.0 * 0.2 * 0.7 + 0.15) / (9.0 * G);
    assert!((x - expected).abs() < 1e-15, "{x} {expected}");
    assert!(x < standing - 9e-3);
}

/// A box that falls along a slanted rail as fast as free bodies do: there is no ZMP, and no
/// panic.
#[test]
fn where_the_ground_carries_nothing_there_is_no_zmp() {
    let text = r#"<robot name="lift"><link name="foot"/>
      <link name="box"><inertial><origin xyz="0 0 1"/><mass value="2"/></inertial></link>
      <joint name="lift" type="prismatic"><parent link="foot"/><child link="box"/>
        <axis xyz="3 0 4"/><limit lower="-1" upper="1"/></joint></robot>"#;
    let model = model(text, "foot");
    let r = model.cad_params();
    let [x, y] = zmp(&model, &[0.0], &[0.0], &[-G / 0.8], &r);
    assert!(!x.is_finite() || x.abs() > 1e12, "{x} {y}");
    // At half of that the ground feels half of the weight, pushed by 3/8 of g at 1 m.
    let [x, _] = zmp(&model, &[0.0], &[0.0], &[-0.5 * G / 0.8], &r);
    assert!((x - 0.75).abs() < 1e-14, "{x}");
}

/// `c` and its acceleration follow from r; `L̇` stays that of the URDF.
#[test]
fn parameters_enter_by_the_com_and_its_acceleration() {
    const STEP: f64 = 0.02;
    for seed in 0..40 {
        let kind = Kind {
            joints: 1 + seed as usize % 12,
            canonical: false,
            revolute: false,
            chained: 0.6,
        };
        let (text, links) = tree(seed, kind);
        let robot = Robot::parse(&text, "random.urdf").unwrap();
        let support = &links[seed as usize % links.len()];
        let model = robot.model(support, Snapping::Off, None).unwrap();
        let reference = sesc::verify::reference(&robot, &model).unwrap();
        let cad = model.cad_params().into_iter().enumerate();
        let r: Vec<f64> = cad
            .map(|(k, x)| 1.2 * x + 0.01 * (k as f64).sin())
            .collect();
        let com = Evaluator::with_params(&model, Function::Com, r.clone());
        let joints = JointMotion::of(&model);
        for q in Simulator::new(&model.tree.dofs, None, seed)
            .batch(5)
            .chunks(model.dof())
        {
            let at = |t: f64| -> Vec<f64> {
                let moves = joints.rates.iter().zip(&joints.accelerations);
                let moved = q.iter().zip(moves);
                let moved = moved.map(|(q, (v, a))| q + t * (v + 0.5 * t * a));
                com.run(&moved.collect::<Vec<_>>(), 1)
            };
            let path: Vec<Vec<f64>> = (-3..=3).map(|k| at(f64::from(k) * STEP)).collect();
            let weights = [2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0];
            let gain = |axis: usize| {
                let sum: f64 = path.iter().zip(weights).map(|(c, w)| w * c[axis]).sum();
                sum / (180.0 * STEP * STEP)
            };
            let spin = reference
                .motion(q, &joints.rates, &joints.accelerations)
                .momentum_rate;
            let spin = [spin.y, -spin.x].map(|x| x / reference.total_mass());
            let (c, load) = (&path[3], G + gain(2));
            let found = zmp(&model, q, &joints.rates, &joints.accelerations, &r);
            for axis in 0..2 {
                let expected = c[axis] - (c[2] * gain(axis) + spin[axis]) / load;
                let off = (found[axis] - expected).abs();
                assert!(off < 1e-8, "seed {seed}: {} {expected}", found[axis]);
            }
        }
    }
}

/// Counts are exact: one pair of sines, one quotient, and no product with what is zero.
#[test]
fn a_pendulum_costs_what_its_equation_does() {
    let text = r#"<robot name="p"><link name="foot"/>
      <link name="rod"><inertial><origin xyz="0 0 0.5"/><mass value="2"/>
        <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
      <joint name="pivot" type="continuous"><parent link="foot"/><child link="rod"/>
        <axis xyz="0 1 0"/></joint></robot>"#;
    let program = model(text, "foot")
        .program(Function::Zmp, Given::Positions)
        .unwrap();
    let counts = program.counts();
    assert_eq!([counts.mul, counts.add], [27, 16]);
    assert_eq!([counts.sin_cos, counts.angle, counts.other], [1, 0, 1]);
}
