//! The effects of this crate.

use super::{
    Catalog, Effect, axes, backlash, cells, external_force, ground_slope, joint_compliance,
    joint_offset, joint_scale, joint_sign, joint_swap, payload, sensor_drift, sensor_gain,
    sensor_offset, sensor_rotation, time_delay, units,
};

/// All effects that this crate knows, in the order in which ties are broken: the
/// plainest first.
const STANDARD: &[&dyn Effect] = &[
    &sensor_offset::SensorOffset,
    &sensor_rotation::SensorRotation,
    &sensor_gain::SensorGain,
    &ground_slope::GroundSlope,
    &joint_offset::JointOffset,
    &joint_scale::JointScale,
    &joint_compliance::JointCompliance,
    &backlash::Backlash,
    &payload::Payload,
    &external_force::ExternalForce,
    &sensor_drift::SensorDrift,
    &cells::Gain,
    &cells::Offset,
    &cells::Exponent,
    &cells::Saturation,
    &time_delay::TimeDelay,
    &joint_sign::JointSign,
    &joint_swap::JointSwap,
    &axes::SensorAxes,
    &units::Units,
];

impl Catalog {
    /// The effects of this crate.
    pub fn standard() -> Catalog {
        Catalog::of(STANDARD)
    }
}
