//! What effects do and who imitates them, on a robot of which it is known in closed form.

use sesc_identify::diagnose::FIVE_DEVIATIONS;
use sesc_identify::diagnose::footprint::{Footprints, Quantity};
use sesc_identify::fit::prior::PriorChoice;
use sesc_identify::logs::{LogSource, Table};
use sesc_identify::robot::Robot;
use sesc_model::{Model, Snapping};

/// Turns about the vertical: the CoM keeps its height of 0.3 m and goes round on 0.1 m.
const SPIN: &str = "<robot name='spin'><link name='foot'/>\
    <joint name='yaw' type='revolute'><parent link='foot'/><child link='arm'/>\
    <axis xyz='0 0 1'/><limit lower='-4' upper='4'/></joint>\
    <link name='arm'><inertial><origin xyz='0.1 0 0.3'/><mass value='2'/></inertial></link>\
    </robot>";
const NOISE_M: f64 = 1e-3;
const POSTURES: usize = 24;

fn model() -> Model {
    let robot = Robot::parse(SPIN, "spin.urdf").unwrap();
    robot.model("foot", Snapping::default(), None).unwrap()
}

/// Once round, evenly: a constant shift and one that goes round have nothing in common.
fn round() -> Vec<f64> {
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / POSTURES as f64;
    (0..POSTURES).map(|k| angle(k) - 3.0).collect()
}

#[test]
fn a_slope_imitates_the_sensors_offset_where_the_com_keeps_its_height() {
    let model = model();
    let all = Footprints::new(&model, &round(), &[], NOISE_M, &PriorChoice::from("tight")).unwrap();
    let [offset] = &all.of("sensor_offset")[..] else {
        panic!("one sensor");
    };
    let share = |label: &str| {
        let found = offset.imitators.iter().find(|other| other.label == label);
        found
            .unwrap_or_else(|| panic!("{label} is not there"))
            .share
    };
    assert!(share("ground_slope") > 0.9999, "{}", share("ground_slope"));
    assert!(
        share("joint_offset:yaw") < 1e-3,
        "{}",
        share("joint_offset:yaw")
    );
    assert!(
        offset
            .imitators
            .iter()
            .all(|other| other.label != "sensor_offset")
    );
    // A load on the foot would, but the foot carries nothing that data know of; masses of the
    // arm go round with it.
    assert!(
        offset.taken_by_free_masses < 0.05,
        "{}",
        offset.taken_by_free_masses
    );
}

#[test]
fn an_offset_moves_the_cop_by_radius_times_angle() {
    let model = model();
    let all = Footprints::new(&model, &round(), &[], NOISE_M, &PriorChoice::from("tight")).unwrap();
    let [offset] = &all.of("joint_offset")[..] else {
        panic!("one joint");
    };
    assert_eq!(offset.size[0].name, "offset_rad");
    let moves = 0.1 * offset.size[0].value;
    assert!(
        (offset.moves_m / moves - 1.0).abs() < 1e-9,
        "{} {moves}",
        offset.moves_m
    );
    // The CoM of the arm may lie elsewhere in the arm: its usual 5 mm take all of the offset's
    // 2 mm, its tight 0.1 mm a little.
    assert!(
        offset.taken_by_free_masses > 0.9,
        "{}",
        offset.taken_by_free_masses
    );
    assert!(offset.taken_by_masses < 0.3, "{}", offset.taken_by_masses);
    let turned = offset
        .imitators
        .iter()
        .find(|other| other.label == "sensor_rotation");
    assert!(turned.unwrap().share > 0.9999, "{turned:?}");
}

#[test]
fn nothing_in_common_is_told_apart_by_the_whole_effect() {
    let model = model();
    let all = Footprints::new(&model, &round(), &[], NOISE_M, &PriorChoice::from("tight")).unwrap();
    let offset = &all.of("sensor_offset")[0];
    let telling = all.telling(offset, "joint_offset:yaw").unwrap();
    let rest = 1.0 - offset.taken_by_masses;
    let expected = FIVE_DEVIATIONS * NOISE_M * NOISE_M / (offset.moves_m * offset.moves_m * rest);
    assert!(
        (telling.postures / expected - 1.0).abs() < 1e-3,
        "{} {expected}",
        telling.postures
    );
    // Every posture tells the same.
    assert!(
        (telling.share_of_tenth - 2.0 / 24.0).abs() < 1e-2,
        "{}",
        telling.share_of_tenth
    );
    let apart = |k: usize| -> f64 {
        let [a, b] = [telling.with[k], telling.without[k]];
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    assert!((apart(3) - offset.moves_m).abs() < 1e-12);
    assert!(
        telling
            .features
            .iter()
            .any(|f| f.what == Quantity::ComHeight && f.spread < 1e-12)
    );
    assert!(all.telling(offset, "nobody").is_none());
}

#[test]
fn what_needs_motion_is_not_seen() {
    let model = model();
    let all = Footprints::new(&model, &round(), &[], NOISE_M, &PriorChoice::from("tight")).unwrap();
    assert!(all.of("time_delay").is_empty());
    assert!(all.of("cell_gain").is_empty());
    let sign = &all.of("joint_sign")[0];
    assert!(sign.size.is_empty() && sign.moves_m > 0.01);
}

/// The ZMP of [`SPIN`] at time `t` of a swing of 1 rad at 0.5 Hz, in closed form: that of a point
/// on a circle, c − (z/g) c̈, whose spin about the vertical moves nothing.
fn zmp(t: f64) -> [f64; 2] {
    let w = std::f64::consts::PI;
    let (sin, cos) = (w * t).sin_cos();
    let (q, rate, acceleration) = (sin, w * cos, -w * w * sin);
    let by_height = 0.3 / 9.80665;
    let out = 0.1 * (1.0 + by_height * rate * rate);
    let along = -0.1 * by_height * acceleration;
    [
        out * q.cos() - along * q.sin(),
        out * q.sin() + along * q.cos(),
    ]
}

/// Angles that are older than readings by a little move the ZMP by its own speed.
#[test]
fn a_delay_moves_the_zmp_of_a_swing_by_its_speed() {
    let model = model();
    let times: Vec<f64> = (0..400).map(|k| 0.02 * k as f64).collect();
    let column = |of: &dyn Fn(f64) -> f64| -> Vec<f64> { times.iter().map(|t| of(*t)).collect() };
    let table = Table::new("swing")
        .numbers("t", times.clone())
        .numbers("yaw", column(&|t| (std::f64::consts::PI * t).sin()))
        .numbers("cop_x", column(&|t| zmp(t)[0]))
        .numbers("cop_y", column(&|t| zmp(t)[1]));
    let log = LogSource::from(table);
    let prior = PriorChoice::from("tight");
    let moving = Footprints::moving(&model, &log, NOISE_M, &prior).unwrap();
    let [delay] = &moving.of("time_delay")[..] else {
        panic!("one delay");
    };
    let seconds = delay.size[0].value;
    let speed = |t: f64| {
        let (a, b) = (zmp(t - 1e-5), zmp(t + 1e-5));
        (b[0] - a[0]).hypot(b[1] - a[1]) / 2e-5
    };
    // Rows at either end do not know their accelerations.
    let known = &times[5..395];
    let squares: f64 = known.iter().map(|t| speed(*t).powi(2)).sum();
    let expected = seconds * (squares / known.len() as f64).sqrt();
    assert!(
        (delay.moves_m / expected - 1.0).abs() < 0.02,
        "{} instead of {expected}",
        delay.moves_m
    );
    // Nobody sees it in a robot that stands.
    let standing = Footprints::new(&model, &round(), &[], NOISE_M, &prior).unwrap();
    assert!(standing.of("time_delay").is_empty());
    let telling = moving.telling(delay, &delay.imitators[0].label).unwrap();
    let speeds = telling.features.iter();
    assert!(speeds.clone().any(|f| f.what == Quantity::JointSpeed(0)));
}
