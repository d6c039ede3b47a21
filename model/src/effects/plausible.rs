//! Hard physical bounds: what no robot that stood in a lab has.
//!
//! A fit may pass them on its way; an explanation that ends at or beyond one is not
//! believed. Each bound has its reason, which is what a reader is told.

/// A fit that ends this close to a bound, as a part of it, sits at it.
const AT: f64 = 1e-3;

/// Slope of the ground, as a tangent: 20°.
pub const LARGEST_SLOPE: (f64, &str) = (
    0.363_970_234_266_202_4,
    "soles slip on a floor of 20° and more",
);
/// Scale of a joint.
pub const JOINT_SCALE: (f64, f64, &str) = (
    0.5,
    2.0,
    "no gear or encoder is wrong by a factor of 2 that is not a wrong unit",
);
/// Width of a dead band, rad: 20°.
pub const WIDEST_BACKLASH_RAD: (f64, &str) = (
    0.349_065_850_398_865_9,
    "a joint that is loose by 20° and more is broken",
);
/// Gain of the CoP sensor.
pub const SENSOR_GAIN: (f64, f64, &str) = (
    0.2,
    5.0,
    "a sensor that shows less than a fifth or more than five times of the CoP is dead or has \
     another unit",
);
/// A pull at the robot, as a part of its weight.
pub const LARGEST_PULL: (f64, &str) = (
    1.0 / 3.0,
    "a pull of a third of the robot's weight and more does not go unnoticed",
);
/// Reason against a payload.
pub const PAYLOAD_HEAVIER: &str = "it would weigh as much as the robot and more";
/// Reason against a payload at the end of a long pole.
pub const PAYLOAD_FARTHER: &str = "it would be many times farther out than the robot reaches";
/// What a body lacks of its mass, as a part of it.
pub const LACKING: (f64, &str) = (
    0.2,
    "its body would lack a fifth of its mass and more, which no hardware does unnoticed",
);
/// A load on the foot on which the robot stands, as a part of the robot's mass.
pub const ON_THE_FOOT: (f64, &str) = (
    0.2,
    "a fifth of the robot's mass and more on the foot that it stands on does not go unnoticed",
);
/// Reason against a spring.
pub const STIFFNESS: &str = "a spring that does not push back holds nothing";

/// The reason, where `x` is not clearly inside of `least` and `most`.
pub(super) fn outside(
    (least, most, reason): (f64, f64, &'static str),
    x: f64,
) -> Option<&'static str> {
    let inside = x - least > AT * least.abs() && most - x > AT * most.abs();
    (!inside).then_some(reason)
}

/// The reason, where `x` is not clearly below `most`.
pub(super) fn above((most, reason): (f64, &'static str), x: f64) -> Option<&'static str> {
    (most - x <= AT * most || x.is_nan()).then_some(reason)
}
