//! Newton and Euler against differences of what they are the laws of: momentum.

use nalgebra::{Matrix3, Vector3};
use sesc_reference::{Reference, Robot};

/// Turned inertias, a slide, a follower, and a foot that is not the root.
const ARM: &str = r#"<robot name="arm">
  <link name="base"><inertial><origin xyz="0.1 0 0.2" rpy="0.3 0.2 0.1"/><mass value="4"/>
    <inertia ixx="0.2" ixy="0.01" ixz="-0.02" iyy="0.3" iyz="0.03" izz="0.1"/></inertial></link>
  <link name="upper"><inertial><origin xyz="0 0.05 0.3" rpy="1 0 0.4"/><mass value="2"/>
    <inertia ixx="0.05" ixy="0" ixz="0.01" iyy="0.08" iyz="0" izz="0.02"/></inertial></link>
  <link name="slide"><inertial><origin xyz="0.02 0 0.1"/><mass value="1.5"/>
    <inertia ixx="0.02" ixy="0.002" ixz="0" iyy="0.03" iyz="0" izz="0.01"/></inertial></link>
  <link name="foot"><inertial><origin xyz="0 0 -0.1"/><mass value="0.7"/>
    <inertia ixx="0.004" ixy="0" ixz="0" iyy="0.006" iyz="0.001" izz="0.005"/></inertial></link>
  <joint name="a" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.1 -0.4 0.2"/><axis xyz="0.2 1 -0.3"/>
    <limit lower="-2" upper="2"/></joint>
  <joint name="b" type="prismatic"><parent link="upper"/><child link="slide"/>
    <origin xyz="0 0.1 0.4" rpy="0.5 0 0"/><axis xyz="1 0.5 0"/><limit lower="-1" upper="1"/></joint>
  <joint name="c" type="revolute"><parent link="base"/><child link="foot"/>
    <origin xyz="-0.1 0 -0.4" rpy="0 0.3 0"/><axis xyz="1 0 0.2"/>
    <mimic joint="a" multiplier="-0.7" offset="0.1"/><limit lower="-2" upper="2"/></joint>
</robot>"#;

const STEP: f64 = 1e-2;

/// Centre of mass and momentum about the origin at a time, by differences of link poses.
struct Path<'a> {
    reference: &'a Reference,
    start: [[f64; 2]; 3],
}

impl Path<'_> {
    fn q(&self, t: f64) -> Vec<f64> {
        let [q, v, a] = self.start;
        (0..2).map(|j| q[j] + t * (v[j] + 0.5 * t * a[j])).collect()
    }

    /// Linear momentum and angular momentum about the origin of the support frame.
    fn momentum(&self, t: f64) -> [Vector3<f64>; 2] {
        let poses = |t: f64| self.reference.link_poses(&self.q(t));
        let path: Vec<_> = (-3..=3).map(|k| poses(t + f64::from(k) * STEP)).collect();
        let weights = [-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0].map(|w| w / (60.0 * STEP));
        let [mut linear, mut angular] = [Vector3::zeros(); 2];
        for (l, link) in self.reference.robot().links().iter().enumerate() {
            let mut velocity = Vector3::zeros();
            let mut rotation_rate = Matrix3::zeros();
            for (poses, w) in path.iter().zip(weights) {
                velocity += (poses[l] * link.com_m).coords * w;
                rotation_rate += poses[l].rotation.matrix() * w;
            }
            let here = &path[3][l];
            // Ṙ Rᵀ is the cross product with ω.
            let spin = rotation_rate * here.rotation.matrix().transpose();
            let rate = Vector3::new(spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]);
            let inertia =
                here.rotation.matrix() * link.inertia_kg_m2 * here.rotation.matrix().transpose();
            linear += velocity * link.mass_kg;
            angular +=
                (here * link.com_m).coords.cross(&(velocity * link.mass_kg)) + inertia * rate;
        }
        [linear, angular]
    }
}

#[test]
fn forces_and_moments_are_the_rates_of_momentum() {
    let robot = Robot::from_urdf(ARM).unwrap();
    for support in ["base", "foot", "slide"] {
        let reference = Reference::new(&robot, support).unwrap();
        for start in [
            [[0.3, 0.1], [1.0, -0.4], [2.0, 1.0]],
            [[-0.8, -0.3], [-0.6, 0.5], [-1.0, 3.0]],
        ] {
            let path = Path {
                reference: &reference,
                start,
            };
            let [before, after] = [-1.0, 1.0].map(|k| path.momentum(k * STEP));
            let [far_before, far_after] = [-2.0, 2.0].map(|k| path.momentum(k * STEP));
            let rate = |k: usize| {
                ((after[k] - before[k]) * 8.0 - (far_after[k] - far_before[k])) / (12.0 * STEP)
            };
            let motion = reference.motion(&start[0], &start[1], &start[2]);
            let mass = reference.total_mass();
            let force = motion.com_acceleration * mass;
            assert!(
                (force - rate(0)).norm() < 1e-5,
                "{support}: {force} {}",
                rate(0)
            );
            let moment = motion.momentum_rate + motion.com.cross(&force);
            assert!(
                (moment - rate(1)).norm() < 1e-5,
                "{support}: {moment} {}",
                rate(1)
            );
            // What moves is more than what the tolerance hides.
            assert!(motion.momentum_rate.norm() > 0.05, "{support}: {motion:?}");
        }
    }
}

/// A wheel that is spun up about its own axis turns its ground back, and moves no CoM.
#[test]
fn a_wheel_turns_the_ground_by_its_inertia() {
    let text = r#"<robot name="wheel">
      <link name="stand"><inertial><origin xyz="0 0 0.5"/><mass value="3"/></inertial></link>
      <link name="wheel"><inertial><mass value="1"/>
        <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.1"/></inertial></link>
      <joint name="axle" type="continuous"><parent link="stand"/><child link="wheel"/>
        <origin xyz="0 0 1"/><axis xyz="0 1 0"/></joint></robot>"#;
    let robot = Robot::from_urdf(text).unwrap();
    let reference = Reference::new(&robot, "stand").unwrap();
    let p = reference.zmp(&[0.4], &[7.0], &[3.0]);
    assert!((p.x + 0.2 * 3.0 / (4.0 * 9.80665)).abs() < 1e-15, "{p}");
    assert!(p.y.abs() < 1e-15, "{p}");
}

/// A point mass joins the inertia of its link as Steiner says.
#[test]
fn a_payload_turns_with_its_link() {
    let arm = r#"<robot name="arm"><link name="stand"/>
      <link name="rod"><inertial><origin xyz="0 0 0.5"/><mass value="1"/>
        <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.01"/></inertial></link>
      <joint name="pivot" type="continuous"><parent link="stand"/><child link="rod"/>
        <axis xyz="0 1 0"/></joint></robot>"#;
    let robot = Robot::from_urdf(arm).unwrap();
    let loaded = robot.with_point_mass("rod", 2.0, [0.0, 0.0, 1.0]).unwrap();
    let reference = Reference::new(&loaded, "stand").unwrap();
    let p = reference.zmp(&[0.0], &[0.0], &[1.0]);
    // Moment about the pivot, which is on the ground: all of it turns.
    let inertia = 0.1 + 1.0 * 0.25 + 2.0 * 1.0;
    assert!((p.x + inertia / (3.0 * 9.80665)).abs() < 1e-15, "{p}");
}
