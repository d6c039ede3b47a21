//! Servo files, as diagnoses take them.

use std::collections::BTreeMap;
use std::path::Path;

use sesc_codegen::{Scale, Servos};
use sesc_identify::diagnose::remedy::{Servo, Step};
use sesc_identify::robot::Robot;
use sesc_model::urdf::JointType;

/// The servos of a file, by joint of `robot`.
///
/// # Errors
/// A file that cannot be read, a joint that the robot does not have, a value that no servo has.
pub fn read(file: &Path, robot: &Robot) -> Result<BTreeMap<String, Servo>, sesc_codegen::Error> {
    let joints = robot.description.joints.iter();
    let driven = joints.filter(|joint| joint.joint_type.is_single() && joint.mimic.is_none());
    let driven = driven.map(|joint| (&*joint.name, joint.joint_type == JointType::Prismatic));
    let servos = Servos::read(file)?.of(driven)?;
    let of = |(joint, servo): (String, sesc_codegen::Servo)| {
        let step = match servo.scale {
            Scale::TicksPerTurn(ticks) => Step::TicksPerTurn(ticks),
            Scale::MetresPerTick(metres) => Step::MetresPerTick(metres),
        };
        let (zero, sign) = (servo.zero, servo.sign);
        (joint, Servo { zero, sign, step })
    };
    Ok(servos.into_iter().map(of).collect())
}
