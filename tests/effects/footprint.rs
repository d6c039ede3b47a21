//! What effects do and who imitates them, on a robot of which it is known in closed form.

use sesc_identify::diagnose::FIVE_DEVIATIONS;
use sesc_identify::diagnose::footprint::{Footprints, Quantity};
use sesc_identify::fit::prior::PriorChoice;
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
