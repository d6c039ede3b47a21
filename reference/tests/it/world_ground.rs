//! Pulls, inertia, delays and the order of a log under the sole.

use crate::common::{LEANING_KG, bushy_on_sole, near, postures, robot, stick};
use sesc_reference::{GRAVITY, Robot, Track, World};

#[test]
fn a_pull_overturns_by_its_height() {
    // Upright, pulled sideways at the top: 0.6 m above the sole.
    let (force, at) = ([1.0, -2.0, 0.0], [0.0, 0.0, 0.5]);
    let pulled = stick().external_force_at("stick", force, at).unwrap();
    let weight = LEANING_KG * GRAVITY;
    near(pulled.cop(&[0.0]), [0.6 / weight, -1.2 / weight], 1e-15);
    // The axes are the sole's, whatever the link does.
    let (sin, cos) = 0.3_f64.sin_cos();
    let expected = [
        0.5 * sin + (0.1 + 0.5 * cos) / weight,
        -2.0 * (0.1 + 0.5 * cos) / weight,
    ];
    near(pulled.cop(&[0.3]), expected, 1e-15);
}

#[test]
fn a_pull_straight_down_is_a_payload() {
    let (_, reference, world) = bushy_on_sole();
    for mass in [0.3, -0.1] {
        let force = [0.0, 0.0, -mass * GRAVITY];
        let pulled = world.clone().external_force("arm", force).unwrap();
        let loaded = world.clone().payload("arm", mass, [0.0; 3]).unwrap();
        for q in postures(&reference, 10) {
            near(pulled.cop(&q), loaded.cop(&q), 1e-14);
        }
    }
}

#[test]
fn a_pull_on_a_slope_meets_the_tilted_plane() {
    let pulled = stick()
        .ground_slope([0.1, 0.0])
        .unwrap()
        .external_force("stick", [0.5, 0.0, -1.0])
        .unwrap();
    // Forces at (0, 0.6) and (0, 0.1): where their sum meets z = 0.
    let level = (1.0_f64 + 0.01).sqrt();
    let [x, z] = [0.1, 1.0].map(|part| LEANING_KG * GRAVITY * part / level);
    let expected = (x * 0.6 + 0.5 * 0.1) / (z + 1.0);
    near(pulled.cop(&[0.0]), [expected, 0.0], 1e-15);
}

/// A mass of 1 kg, 0.4 m up, on a prismatic joint along x.
fn cart() -> World {
    let cart = robot(
        "<link name='floor'/>
         link cart 1 0 0 0.4
         prismatic rail floor cart | | <axis xyz='1 0 0'/>",
    );
    World::new(&cart, "floor").unwrap()
}

#[test]
fn a_swinging_mass_throws_the_cop_beyond_itself() {
    let world = cart();
    let rate = 2.0_f64;
    let times: Vec<f64> = (0..20).map(|i| 0.17 * f64::from(i)).collect();
    let track = Track::moving(times.clone(), move |t| vec![0.05 * (rate * t).sin()]);
    let still = world.readings(&track);
    let moving = world.unsettled().readings(&track);
    for ((t, still), moving) in times.iter().zip(still).zip(moving) {
        let x = 0.05 * (rate * t).sin();
        near(still.cop, [x, 0.0], 1e-15);
        // x - a h / g with a = -rate² x; differences of 1 ms leave 1e-9.
        let thrown = x * (1.0 + 0.4 * rate * rate / GRAVITY);
        near(moving.cop, [thrown, 0.0], 1e-8);
    }
}

#[test]
fn late_angles_belong_to_an_earlier_reading() {
    let world = cart().time_delay(0.1);
    let motion = |t: f64| vec![0.05 * (3.0 * t).sin() + 0.01 * t];
    let times: Vec<f64> = (0..10).map(|i| 0.3 * f64::from(i)).collect();
    let track = Track::moving(times.clone(), motion);
    for (t, reading) in times.iter().zip(world.readings(&track)) {
        near(reading.cop, [motion(t + 0.1)[0], 0.0], 1e-15);
    }
    // A single posture, or one at rest, has no other to be late for.
    assert_eq!(world.cop(&[0.02]), [0.02, 0.0]);
    let still = Track::still(vec![vec![0.02], vec![0.03]]);
    assert_eq!(world.readings(&still)[1].cop, [0.03, 0.0]);
}

#[test]
fn samples_of_a_parabola_are_a_parabola() {
    let parabola = |t: f64| 0.02 + 0.1 * t - 0.05 * t * t;
    // Unevenly spaced; the last one, and the first, lie beyond the samples.
    let times: Vec<f64> = (0..10)
        .map(|i| 0.1 * f64::from(i) + 0.003 * f64::from(i * i))
        .collect();
    let postures: Vec<_> = times.iter().map(|&t| vec![parabola(t)]).collect();
    for delay in [0.03, -0.03] {
        let world = cart().time_delay(delay);
        let track = Track::sampled(times.clone(), postures.clone());
        for (t, reading) in times.iter().zip(&world.readings(&track)) {
            near(reading.cop, [parabola(t + delay), 0.0], 1e-15);
        }
    }
    // Two samples are a line, one is a place.
    let world = cart().time_delay(0.5);
    let two = Track::sampled(vec![0.0, 1.0], vec![vec![0.0], vec![0.02]]);
    near(world.readings(&two)[0].cop, [0.01, 0.0], 1e-17);
    let one = Track::sampled(vec![3.0], vec![vec![0.02]]);
    near(world.readings(&one)[0].cop, [0.02, 0.0], 1e-17);
}

#[test]
fn drift_runs_from_the_first_pose_number_to_the_last() {
    let world = cart();
    let world = world.sensor_drift([0.01, -0.02]);
    let track = Track::still(vec![vec![0.0]; 4]).numbered(vec![3.0, 4.0, 8.0, 13.0]);
    let found: Vec<[f64; 2]> = world.readings(&track).iter().map(|r| r.cop).collect();
    for (found, u) in found.into_iter().zip([0.0, 0.1, 0.5, 1.0]) {
        near(found, [0.01 * u, -0.02 * u], 1e-17);
    }
    let alone = Track::still(vec![vec![0.0]]);
    assert_eq!(world.readings(&alone)[0].cop, [0.0, 0.0]);
}

#[test]
fn outliers_are_as_many_and_as_far_as_asked() {
    let world = cart();
    let track = Track::still(vec![vec![0.0]; 38]);
    let jumps = |seed| -> Vec<[f64; 2]> {
        let world = world.clone().cop_outliers(0.13, 0.01, seed).unwrap();
        world.readings(&track).iter().map(|r| r.cop).collect()
    };
    let found = jumps(1);
    let far = found.iter().map(|[x, y]| x.hypot(*y));
    let far: Vec<f64> = far.filter(|far| *far > 0.0).collect();
    assert_eq!(far.len(), 5, "13 % of 38");
    let wide = |far: &f64| (0.006..0.015).contains(far);
    assert!(far.iter().all(wide), "{far:?}");
    assert_eq!(found, jumps(1));
    assert_ne!(found, jumps(2));
}

/// A flywheel about its own CoM pushes no mass, and turns the ground all the same: p = −I α/(M g).
#[test]
fn a_wheel_that_is_spun_up_moves_the_cop() {
    let wheel = "<robot name='wheel'><link name='floor'/><link name='wheel'><inertial>\
        <mass value='2'/><inertia ixx='0.1' ixy='0' ixz='0' iyy='0.3' iyz='0' izz='0.1'/>\
        </inertial></link><joint name='axle' type='continuous'><parent link='floor'/>\
        <child link='wheel'/><origin xyz='0 0 0.4'/><axis xyz='0 1 0'/></joint></robot>";
    let robot = Robot::from_urdf(wheel).unwrap();
    let world = World::new(&robot, "floor").unwrap().unsettled();
    let times: Vec<f64> = (0..20).map(|i| 0.17 * f64::from(i)).collect();
    let track = Track::moving(times.clone(), |t| vec![0.5 * (2.0 * t).sin()]);
    for (t, reading) in times.iter().zip(world.readings(&track)) {
        let gain = -0.5 * 4.0 * (2.0 * t).sin();
        near(reading.cop, [-0.3 * gain / (2.0 * GRAVITY), 0.0], 1e-7);
    }
}
