//! Each kind of joint by itself, and the support anywhere.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::common::{bushy, near, postures, robot, urdf};
use nalgebra::Vector3;
use sesc_reference::{ErrorKind, Reference, Robot};

#[test]
fn a_skewed_axis_is_made_a_unit_axis() {
    // A third of a turn about the space diagonal takes x to y, y to z, z to x.
    let robot = robot(
        "<link name='base'/>
         link arm 2 0.1 0.2 0.3
         revolute j base arm | xyz='1 0 0' | <axis xyz='7 7 7'/>",
    );
    let reference = Reference::new(&robot, "base").unwrap();
    for (q, com) in [(TAU / 3.0, [1.3, 0.1, 0.2]), (-TAU / 3.0, [1.2, 0.3, 0.1])] {
        near(reference.com(&[q]).into(), com, 1e-15);
    }
}

#[test]
fn an_origin_turns_by_roll_then_pitch_then_yaw() {
    let quarter = FRAC_PI_2;
    for (origin, version, com) in [
        // Roll takes y to z; pitch then takes z to x; yaw then takes x to y.
        (format!("rpy='{quarter} 0 0'"), "", [0.0, 0.0, 1.0]),
        (format!("rpy='{quarter} {quarter} 0'"), "", [1.0, 0.0, 0.0]),
        (
            format!("rpy='{quarter} {quarter} {quarter}'"),
            "",
            [0.0, 1.0, 0.0],
        ),
        // The quaternion of any length, heeded from version 1.1 on: y to z to x.
        (
            "quat_xyzw='3 3 3 3'".into(),
            "version='1.1'",
            [0.0, 0.0, 1.0],
        ),
        ("quat_xyzw='3 3 3 3'".into(), "", [0.0, 1.0, 0.0]),
    ] {
        let arm = format!("<link name='base'/>\nlink arm 1 0 1 0\nfixed j base arm | {origin}");
        let robot = Robot::from_urdf(&urdf(&format!("name='r' {version}"), &arm)).unwrap();
        let reference = Reference::new(&robot, "base").unwrap();
        near(reference.com(&[]).into(), com, 1e-15);
    }
}

/// urdf-rs would round the pitch of these to ±90°.
#[test]
fn quaternions_near_upright_keep_their_angles() {
    use nalgebra::{Quaternion, Rotation3};
    for short in [0.0, 1e-12, 1e-7, 1e-3, 4e-3] {
        for pitch in [FRAC_PI_2 - short, short - FRAC_PI_2] {
            let turn = nalgebra::UnitQuaternion::from_euler_angles(0.3, pitch, -1.1);
            let Quaternion { coords } = turn.into_inner();
            let [x, y, z, w]: [f64; 4] = coords.into();
            let arm = format!(
                "<link name='base'/><link name='arm'/>
                 fixed j base arm | quat_xyzw='{x} {y} {z} {w}'"
            );
            let read = Robot::from_urdf(&urdf("name='r' version='1.1'", &arm)).unwrap();
            let error = read.joints()[0].origin.rotation.matrix() - Rotation3::from(turn).matrix();
            assert!(error.norm() < 1e-15, "{pitch}: {error}");
        }
    }
}

#[test]
fn a_slide_moves_along_its_axis() {
    let robot = robot(
        "link base 1 0 0 0
         link lift 3 0 0.1 0
         prismatic j base lift | xyz='0 0 1' | <axis xyz='0 3 4'/>",
    );
    let reference = Reference::new(&robot, "base").unwrap();
    let com = [0.0, 0.75 * 0.4, 0.75 * 1.4];
    near(reference.com(&[0.5]).into(), com, 1e-15);
    // From the lift, the base goes the other way.
    let from_lift = Reference::new(&robot, "lift").unwrap();
    let com = [0.0, 0.75 * 0.1 - 0.25 * 0.3, -0.25 * 1.4];
    near(from_lift.com(&[0.5]).into(), com, 1e-15);
    let jacobian = reference.com_jacobian(&[0.5]);
    assert!((jacobian.column(0) - Vector3::new(0.0, 0.45, 0.6)).norm() < 1e-12);
}

#[test]
fn a_mimic_follows_through_chains() {
    // All on the base, so that each shows its own angle. Followers come first.
    let z = "<axis xyz='0 0 1'/>";
    let links = ["a", "b", "c", "d", "e"].map(|name| format!("link {name} 1 1 0 0\n"));
    let robot = robot(&format!(
        "<link name='base'/>
         {}revolute last base a | | {z}<mimic joint='middle' multiplier='-2' offset='0.1'/>
         revolute middle base b | | {z}<mimic joint='lead' multiplier='0.5' offset='0.3'/>
         revolute lead base c | | {z}
         fixed rigid base d | | {z}<mimic joint='nowhere'/>
         revolute held base e | | {z}<mimic joint='rigid' multiplier='5' offset='0.7'/>",
        links.concat()
    ));
    let reference = Reference::new(&robot, "base").unwrap();
    assert_eq!(reference.joint_names(), ["lead"]);
    let lead: f64 = 0.4;
    let middle = 0.5 * lead + 0.3;
    let angles = [-2.0 * middle + 0.1, middle, lead, 0.0, 0.7];
    let expected: Vector3<f64> = angles
        .iter()
        .map(|angle| Vector3::new(angle.cos(), angle.sin(), 0.0) / 5.0)
        .sum();
    assert!((reference.com(&[lead]) - expected).norm() < 1e-15);
    // d/dlead = (cos', sin') with rates -1, 1/2, 1.
    let rates = [-1.0, 0.5, 1.0, 0.0, 0.0];
    let slope: Vector3<f64> = angles
        .iter()
        .zip(rates)
        .map(|(angle, rate)| Vector3::new(-angle.sin(), angle.cos(), 0.0) * rate / 5.0)
        .sum();
    assert!((reference.com_jacobian(&[lead]).column(0) - slope).norm() < 1e-12);
}

#[test]
fn every_support_sees_the_same_point() {
    let robot = bushy();
    let torso = Reference::new(&robot, "torso").unwrap();
    for link in robot.links() {
        let other = Reference::new(&robot, &link.name).unwrap();
        let l = robot.link_index(&link.name).unwrap();
        for q in postures(&torso, 20) {
            let seen = torso.link_poses(&q)[l] * nalgebra::Point3::from(other.com(&q));
            let error = seen.coords - torso.com(&q);
            assert!(error.norm() < 1e-14, "{}", link.name);
            let own = other.link_poses(&q)[l];
            assert!((own.to_homogeneous() - nalgebra::Matrix4::identity()).norm() < 1e-14);
        }
    }
}

#[test]
fn the_jacobian_is_the_screw_formula() {
    // Revolute: a × (masses beyond, weighted, from the axis); prismatic: a times
    // their share. Written here from poses, with mimic followers added.
    let robot = bushy();
    let reference = Reference::new(&robot, "torso").unwrap();
    let names = reference.joint_names();
    let beyond: [(&str, &[&str]); 5] = [
        ("hip", &["thigh", "shin", "foot"]),
        ("knee", &["shin", "foot"]),
        ("ankle", &["foot"]),
        ("shoulder", &["arm", "piston", "finger"]),
        ("slide", &["piston", "finger"]),
    ];
    for q in postures(&reference, 20) {
        let poses = reference.link_poses(&q);
        let spin = |joint: &str, carried: &[&str]| -> Vector3<f64> {
            let joint = robot.joints().iter().find(|j| j.name == joint).unwrap();
            let frame = poses[joint.child];
            let axis = frame.rotation * joint.axis.into_inner();
            let masses = carried.iter().map(|name| {
                let l = robot.link_index(name).unwrap();
                let link = &robot.links()[l];
                let arm = (poses[l] * link.com_m).coords - frame.translation.vector;
                axis.cross(&arm) * link.mass_kg
            });
            masses.sum::<Vector3<f64>>() / reference.total_mass()
        };
        let jacobian = reference.com_jacobian(&q);
        for (j, (name, carried)) in beyond.iter().enumerate() {
            assert_eq!(names[j], *name);
            let expected = match *name {
                "slide" => {
                    let joint = robot.joints().iter().find(|j| j.name == "slide").unwrap();
                    let share = 0.25 / reference.total_mass();
                    poses[joint.child].rotation * joint.axis.into_inner() * share
                }
                "shoulder" => spin(name, carried) - 0.7 * spin("curl", &["finger"]),
                _ => spin(name, carried),
            };
            let error = jacobian.column(j) - expected;
            assert!(error.norm() < 1e-12, "{name}: {error}");
        }
    }
}

#[test]
fn the_jacobian_is_the_slope_of_the_com_on_every_support() {
    // Differences of the CoM of whole postures; the support may itself hang on a follower of
    // a joint that moves it.
    const STEP: f64 = 1e-3;
    let robot = bushy();
    for link in robot.links() {
        let reference = Reference::new(&robot, &link.name).unwrap();
        for q in postures(&reference, 5) {
            let jacobian = reference.com_jacobian(&q);
            for (j, column) in jacobian.column_iter().enumerate() {
                let at = |steps: f64| {
                    let mut moved = q.clone();
                    moved[j] += steps * STEP;
                    reference.com(&moved)
                };
                let near = (at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0));
                let error = near / (12.0 * STEP) - column;
                assert!(error.norm() < 2e-12, "{}, {j}: {error}", link.name);
            }
        }
    }
}

#[test]
fn a_free_joint_must_carry_no_mass_away() {
    let body = "<link name='world'/>
        link base 2 0.1 0 0
        link arm 1 0 0.2 0
        floating free world base | xyz='5 6 7' rpy='0.1 0.2 0.3'
        revolute j base arm | xyz='0 0 0.5' | <axis xyz='0 0 1'/>";
    let floating = robot(body);
    let reference = Reference::new(&floating, "base").unwrap();
    // Ten metres of way to the root and back cost a digit.
    let error = reference.com(&[FRAC_PI_2]) - Vector3::new(0.0, 0.0, 0.5 / 3.0);
    assert!(error.norm() < 1e-14, "{error}");
    assert!(!reference.is_placed(0) && reference.is_placed(1));
    assert_eq!(reference.standard_columns(&[0.3]).columns(0, 4).norm(), 0.0);

    let planar = robot(&body.replace("floating", "planar"));
    let error = Reference::new(&planar, "world").unwrap_err();
    assert_eq!(error.kind(), ErrorKind::MassBeyondFreeJoint);
    assert!(error.to_string().contains("link `base`"), "{error}");
    assert!(error.to_string().contains("planar joint `free`"), "{error}");
}

#[test]
fn ranges_have_width() {
    let full = (-PI, PI);
    for (kind, limit, range) in [
        ("revolute", "<limit lower='-0.5' upper='1'/>", (-0.5, 1.0)),
        ("revolute", "", full),
        ("revolute", "<limit effort='1' velocity='1'/>", full),
        ("revolute", "<limit lower='0.2' upper='0.2'/>", full),
        ("continuous", "<limit lower='-1' upper='1'/>", full),
        ("prismatic", "", (-1.0, 1.0)),
        ("prismatic", "<limit lower='0' upper='0.3'/>", (0.0, 0.3)),
        ("revolute", "<limit lower='-1'/>", (-1.0, 0.0)),
        ("revolute", "<limit lower='-inf' upper='inf'/>", full),
    ] {
        let joint = format!("link base 1 0 0 0\n<link name='l'/>\n{kind} j base l | | {limit}");
        let limits = Reference::new(&robot(&joint), "base").unwrap().limits();
        assert_eq!(limits, [range], "{kind} {limit}");
    }
}
