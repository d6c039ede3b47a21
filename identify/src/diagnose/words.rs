//! Findings in the words of the people who use them.

use nalgebra::DMatrix;
use sesc_model::effects::{Instance, Setting, Value};

use super::problem::{Fit, Problem};

/// A value of an effect with its standard deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    pub name: &'static str,
    pub value: f64,
    pub std: f64,
}

/// What each effect of a fit amounts to: deviations by the slopes of the values.
pub fn values(problem: &Problem, fit: &Fit) -> Vec<Vec<Found>> {
    let setting = &problem.setting;
    let mut at = 0;
    fit.instances
        .iter()
        .map(|instance| {
            let count = instance.unknowns(setting);
            let own = &fit.unknowns[at..at + count];
            let covariance = fit.covariance.view((at, at), (count, count)).into_owned();
            at += count;
            with_deviations(setting, instance, own, &covariance)
        })
        .collect()
}

fn with_deviations(
    setting: &Setting,
    instance: &Instance,
    unknowns: &[f64],
    covariance: &DMatrix<f64>,
) -> Vec<Found> {
    let of = |x: &[f64]| instance.effect.values(setting, &instance.target, x);
    let scales = instance.effect.scales(setting, &instance.target);
    let now = of(unknowns);
    let mut slopes = DMatrix::zeros(now.len(), unknowns.len());
    for k in 0..unknowns.len() {
        let step = 1e-5 * scales[k];
        let moved = |by: f64| {
            let mut x = unknowns.to_vec();
            x[k] += by;
            of(&x)
        };
        let (ahead, behind) = (moved(step), moved(-step));
        for (row, (a, b)) in ahead.iter().zip(&behind).enumerate() {
            slopes[(row, k)] = (a.value - b.value) / (2.0 * step);
        }
    }
    let spread = &slopes * covariance * slopes.transpose();
    now.into_iter()
        .enumerate()
        .map(|(k, Value { name, value })| Found {
            name,
            value,
            std: spread[(k, k)].max(0.0).sqrt(),
        })
        .collect()
}

/// `0.93° ± 0.04°`, `31 g ± 2 g`: by the unit at the end of its name.
pub fn spoken(found: &Found) -> String {
    let (factor, unit) = unit_of(found.name);
    let (value, std) = (factor * found.value, factor * found.std);
    let digits = match std {
        s if s.is_finite() && s > 0.0 => (1.0 - s.log10().floor()).clamp(0.0, 6.0) as usize,
        _ => 3,
    };
    let gap = if unit == "°" { "" } else { " " };
    format!("{value:.digits$}{gap}{unit} ± {std:.digits$}{gap}{unit}")
        .replace("  ", " ")
        .trim_end()
        .to_string()
}

fn unit_of(name: &str) -> (f64, &'static str) {
    match name {
        n if n.ends_with("_nm_per_rad") => (1.0, "Nm/rad"),
        n if n.ends_with("_rad") => (180.0 / std::f64::consts::PI, "°"),
        n if n.ends_with("_kg") => (1e3, "g"),
        n if n.ends_with("_m") => (1e3, "mm"),
        n if n.ends_with("_n") => (1.0, "N"),
        n if n.ends_with("_s") => (1e3, "ms"),
        _ => (1.0, ""),
    }
}

/// What an instance is, as the subject of a sentence: `an offset of l_knee`.
pub fn subject(setting: &Setting, instance: &Instance) -> String {
    let target = setting.name_of(&instance.target);
    let joint = match target.as_str() {
        "all" => "every joint".to_string(),
        other => other.to_string(),
    };
    match instance.effect.name() {
        "sensor_offset" => "an offset of the sensor".to_string(),
        "sensor_gain" => "a gain of the sensor".to_string(),
        "sensor_rotation" => "a sensor turned about the vertical".to_string(),
        "sensor_drift" => "a drift of the sensor over the log".to_string(),
        "sensor_axes" => match target.as_str() {
            "swapped" => "swapped axes of the sensor".to_string(),
            "flip_x" => "a flipped x axis of the sensor".to_string(),
            _ => "a flipped y axis of the sensor".to_string(),
        },
        "cell_gain" => format!("a gain of foot cell {joint}"),
        "cell_offset" => format!("a zero offset of foot cell {joint}"),
        "cell_exponent" => format!("a bent characteristic of foot cell {joint}"),
        "cell_saturation" => format!("a saturated foot cell {joint}"),
        "ground_slope" => "a slope of the ground".to_string(),
        "payload" => format!("an unknown mass on {joint}"),
        "external_force" => format!("a force that pulls at {joint}"),
        "joint_offset" => format!("an offset of {joint}"),
        "joint_scale" => format!("a wrong scale of {joint}"),
        "joint_sign" => format!("a reversed encoder of {joint}"),
        "joint_swap" => format!(
            "encoders of {} plugged into each other's channel",
            joint.replace(',', " and ")
        ),
        "joint_compliance" => format!("compliance of {joint}"),
        "backlash" => format!("backlash in {joint}"),
        "time_delay" => "joint angles older than the readings".to_string(),
        "unsettled_motion" => "readings taken while the robot still moved".to_string(),
        "units" => match target.as_str() {
            "degrees" => "joint angles in degrees, not radians".to_string(),
            "millimetres" => "a CoP in millimetres, not metres".to_string(),
            _ => "a CoP in centimetres, not metres".to_string(),
        },
        "mass_distribution" => "masses that differ from CAD".to_string(),
        "cop_outliers" => "a few readings that come from elsewhere".to_string(),
        other => format!("{other} {joint}"),
    }
}

/// `width 0.93° ± 0.04°`: what it is called, without the unit, and its value.
pub fn named(found: &Found) -> String {
    let plain = ["_nm_per_rad", "_rad", "_kg", "_m", "_n", "_s"];
    let stem = plain
        .iter()
        .find_map(|unit| found.name.strip_suffix(unit))
        .unwrap_or(found.name);
    format!("{} {}", stem.replace('_', " "), spoken(found))
}

/// `subject`, with its values: `backlash in every joint: width 0.93° ± 0.04°`.
pub fn clause(setting: &Setting, instance: &Instance, values: &[Found]) -> String {
    let subject = subject(setting, instance);
    let said: Vec<String> = values.iter().map(named).collect();
    match said.is_empty() {
        true => subject,
        false => format!("{subject} ({})", said.join(", ")),
    }
}
