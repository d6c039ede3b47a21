//! Noise of a recording is correlated: what is said of it counts independent samples.

use std::path::Path;
use std::sync::Arc;

use sesc_identify::diagnose::Diagnosis;
use sesc_identify::diagnose::{Request, Verdict, diagnose};
use sesc_identify::logs::Table;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::Snapping;
use sesc_reference::World;
use sesc_test_support::command::ROOT;

const NOISE_M: f64 = 2e-3;

/// An OP2 that sways through slow sines for `seconds` at `rate` Hz; noise of correlation
/// time `tau`, stated truthfully.
fn diagnosis(
    hide: impl Fn(World) -> World,
    (seconds, rate): (f64, f64),
    tau: f64,
    seed: u64,
) -> Diagnosis {
    let robot = Robot::read(Path::new(&format!("{ROOT}/robots/op2/op2.urdf"))).unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let described = sesc_reference::Robot::from_urdf(robot.text()).unwrap();
    let world = hide(World::new(&described, "r_sole").unwrap());
    let n = (seconds * rate) as usize;
    let t: Vec<f64> = (0..n).map(|k| k as f64 / rate).collect();
    let at = |j: usize, t: f64| 0.25 * ((0.4 + 0.07 * j as f64) * t + 1.3 * j as f64).sin();
    let q: Vec<Vec<f64>> = t
        .iter()
        .map(|t| (0..model.dof()).map(|j| at(j, *t)).collect())
        .collect();
    let mut simulator = Simulator::new(&model.tree.dofs, None, seed);
    let rho = if tau > 0.0 {
        (-1.0 / (rate * tau)).exp()
    } else {
        0.0
    };
    let mut noise = |n: usize| -> Vec<f64> {
        let mut e = simulator.gauss(NOISE_M);
        (0..n)
            .map(|_| {
                e = rho * e + (1.0 - rho * rho).sqrt() * simulator.gauss(NOISE_M);
                e
            })
            .collect()
    };
    let noise = [noise(n), noise(n)];
    let axis = |axis: usize| -> Vec<f64> {
        (0..n)
            .map(|k| world.cop(&q[k])[axis] + noise[axis][k])
            .collect()
    };
    let mut log = Table::new("log")
        .numbers("t", t.clone())
        .numbers("cop_x", axis(0))
        .numbers("cop_y", axis(1));
    for (j, dof) in model.tree.dofs.iter().enumerate() {
        log = log.numbers(&dof.joint, q.iter().map(|q| q[j]).collect::<Vec<f64>>());
    }
    let mut request = Request::new(Arc::new(robot), log);
    request.support = Some("r_sole".into());
    request.noise = Some(NOISE_M);
    diagnose(&request, &mut ()).unwrap().diagnosis
}

/// `cargo xtask study false-alarms` counts false alarms of many such recordings.
#[test]
fn nothing_is_named_in_correlated_noise() {
    for (seed, tau) in [(0, 0.1), (10, 0.4), (20, 0.8)] {
        let found = diagnosis(|w| w, (120.0, 10.0), tau, seed);
        println!("τ {tau} s: {:?} {:?}", found.verdict, found.samples);
        assert_eq!(found.verdict, Verdict::None, "τ {tau}");
        let a = (-1.0_f64 / (10.0 * tau)).exp();
        let true_count = 1200.0 * (1.0 - a) / (1.0 + a);
        // Of the axis that has fewer, which scatters below the truth.
        let ratio = found.samples.independent as f64 / true_count;
        assert!((0.3..2.0).contains(&ratio), "τ {tau}: {ratio}");
    }
}

#[test]
fn a_large_effect_is_named_in_correlated_noise() {
    let hide = |w: World| w.joint_offset("r_hip_roll", 0.12).unwrap();
    let found = diagnosis(hide, (60.0, 20.0), 0.3, 5);
    let steps: Vec<String> = found
        .steps
        .iter()
        .map(|s| format!("{}:{}", s.effect, s.target))
        .collect();
    println!("{:?} {steps:?} {:?}", found.verdict, found.samples);
    let members = &found.indistinguishable;
    let is = |member: &Vec<String>| *member == ["joint_offset:r_hip_roll"];
    assert!(members.iter().any(is), "{members:?}");
}

#[test]
fn white_noise_counts_every_row() {
    let found = diagnosis(|w| w, (40.0, 10.0), 0.0, 8);
    assert_eq!(found.samples.independent, found.samples.rows);
    assert_eq!(found.verdict, Verdict::None);
}
