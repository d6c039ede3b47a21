//! What to change about an effect, in words with sign and unit.
//!
//! ```text
//! φ = a q + b        q: what the encoder reads, φ: where the joint is
//! ```

use super::Stage;

/// How the position that an encoder reads becomes the true one: `scale · q + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderMap {
    /// Below zero where the encoder counts backwards.
    pub scale: f64,
    /// rad; m for a prismatic joint
    pub offset: f64,
}

impl EncoderMap {
    /// The map of an encoder that reads the truth.
    pub const TRUE: EncoderMap = EncoderMap {
        scale: 1.0,
        offset: 0.0,
    };

    /// Both effects on one joint: scales act on what the encoder reads, offsets add.
    pub fn and(self, other: EncoderMap) -> EncoderMap {
        EncoderMap {
            scale: self.scale * other.scale,
            offset: self.offset + other.offset,
        }
    }
}

/// Why a URDF cannot hold an effect of this stage.
pub(super) fn urdf_gap(stage: Stage, is_static: bool) -> &'static str {
    match stage {
        _ if !is_static => "it belongs to this log, not to the robot",
        Stage::Wiring => "a URDF does not say how encoders are wired or what their units are",
        Stage::Joints => {
            "a URDF knows no encoders; mend the servo, or generate code from the model file"
        }
        Stage::Loads => "a URDF knows no forces",
        Stage::Ground => "a URDF describes the robot, not the ground",
        Stage::Bends => "a URDF holds no compliance and no play; generate code from the model file",
        _ => "a URDF describes no CoP sensor; correct readings by the model file",
    }
}

/// `1.517°`
pub(super) fn degrees(rad: f64) -> String {
    format!("{:.3}°", rad.to_degrees())
}

/// `2.10 mm`
pub(super) fn millimetres(m: f64) -> String {
    format!("{:.2} mm", 1e3 * m)
}

/// `31 g`
pub(super) fn grams(kg: f64) -> String {
    format!("{:.1} g", 1e3 * kg)
}

/// `(1.0, −2.5, 30.0) mm`
pub(super) fn point(at_m: &[f64]) -> String {
    let of = |x: &f64| format!("{:.1}", 1e3 * x).replace('-', "−");
    format!(
        "({}) mm",
        at_m.iter().map(of).collect::<Vec<_>>().join(", ")
    )
}

/// A plain number with `count` digits after the decimal point.
pub(super) fn digits(x: f64, count: usize) -> String {
    format!("{x:.count$}").replace('-', "−")
}

/// `+ 1.517°`, `− 1.517°`
pub(super) fn signed(size: String) -> String {
    match size.strip_prefix('-') {
        Some(size) => format!("− {size}"),
        None => format!("+ {size}"),
    }
}
