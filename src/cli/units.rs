//! Units of options and of Python's keywords: a value that can only have been meant in another
//! unit, such as a length in millimetres, is refused with what was meant.

use sesc_identify::logs::Stays;
use sesc_identify::robot::Robot;

/// No sensor of a robot that stands is noisier, m.
pub(super) const NOISIEST_M: f64 = 0.1;
/// No frame of a foot is further off, m.
pub(super) const LARGEST_SHIFT_M: f64 = 1.0;
/// No sole, and no height above it that a plan keeps clear, is larger, m; who wants no bound
/// gives a metre.
pub(super) const LARGEST_M: f64 = 2.0;
/// No sole leaves room for a margin so wide, m.
pub(super) const WIDEST_M: f64 = 0.25;
/// No joint is drawn from more than a turn either way, degrees.
const TURN_DEG: f64 = 360.0;
/// No encoder of a robot is read more often, Hz.
const FASTEST_HZ: f64 = 50_000.0;
/// A robot does not weigh so many times what CAD says, or so small a part of it.
const MASS_RATIO: f64 = 100.0;

/// Whether the value of a keyword of Python can be meant: in SI units, so that a range is in rad.
///
/// # Errors
/// What is more likely to be in another unit, with what was meant.
pub fn check(keyword: &str, value: f64) -> Result<(), String> {
    match keyword {
        "noise" | "floor" => check_m(value, NOISIEST_M),
        "offset" => check_m(value, LARGEST_SHIFT_M),
        "cop_box" | "clearance" => check_m(value, LARGEST_M),
        "margin" => check_m(value, WIDEST_M),
        "rate" => check_hz(value),
        "range" if value.to_degrees().abs() > TURN_DEG => Err(match value.abs() <= TURN_DEG {
            true => format!(
                "that is {value} rad, more than a turn; give radians: {:.4} for {value}°",
                value.to_radians()
            ),
            false => format!("give radians, {:.4} at most", TURN_DEG.to_radians()),
        }),
        _ => Ok(()),
    }
}

/// A length of the robot or of a reading, up to `most` metres.
pub(super) fn metres(most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| parsed(text, "metres", |x| check_m(x, most))
}

/// How long a robot holds still, s.
pub(super) fn stays(text: &str) -> Result<Stays, String> {
    let seconds = text.parse();
    Stays::settled(seconds.map_err(|_| "give a number of seconds".to_string())?)
}

/// A range of joint angles, degrees.
pub(super) fn range_deg(text: &str) -> Result<f64, String> {
    let meant = |x: f64| (x / 1000.0).to_degrees();
    let check = |x: f64| match x.abs() > TURN_DEG {
        true if meant(x).abs() <= TURN_DEG => Err(format!(
            "that is {x}°, more than a turn; give degrees: {:.4} for {x} mrad",
            meant(x)
        )),
        true => Err(format!("give degrees, {TURN_DEG} at most")),
        false => Ok(()),
    };
    parsed(text, "degrees", check)
}

/// Rows per second.
pub(super) fn rate_hz(text: &str) -> Result<f64, String> {
    parsed(text, "rows per second", check_hz)
}

fn check_hz(x: f64) -> Result<(), String> {
    match x.abs() > FASTEST_HZ {
        true if (0.0..=1e9).contains(&x) => Err(format!(
            "that is {x} rows a second, more than any robot logs; give Hz: {} for a row every {x} ns",
            1e9 / x
        )),
        true => Err(format!("give rows per second, {FASTEST_HZ} at most")),
        false => Ok(()),
    }
}

/// Whether a robot may weigh `kg`; what else is wrong with it is for others to say.
///
/// # Errors
/// What is more likely to be in grams.
pub fn check_mass(kg: Option<f64>, robot: &Robot) -> Result<(), String> {
    let links = robot.description.links.iter();
    let cad_kg: f64 = links.map(|link| link.inertial.mass_kg).sum();
    match kg.filter(|kg| *kg > MASS_RATIO * cad_kg && cad_kg > 0.0) {
        None => Ok(()),
        Some(kg) => Err(format!(
            "that is {kg} kg, and the robot weighs {cad_kg:.3} kg in its URDF; give kilograms: {} \
             for {kg} g",
            kg / 1000.0
        )),
    }
}

/// Metres, up to `most` either way.
fn check_m(x: f64, most: f64) -> Result<(), String> {
    let meant = x / 1000.0;
    match x.abs() > most {
        // Millimetres would be too much, too.
        true if meant.abs() > most => Err(format!("give metres, {most} at most")),
        true => Err(format!("that is {x} m; give metres: {meant} for {x} mm")),
        false => Ok(()),
    }
}

/// A number that can be meant; what else is wrong with it is for the command to say.
fn parsed(
    text: &str,
    unit: &str,
    check: impl Fn(f64) -> Result<(), String>,
) -> Result<f64, String> {
    let value: f64 = text
        .parse()
        .map_err(|_| format!("give a number of {unit}"))?;
    check(value).map(|()| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the command line's own tests do not type.
    #[test]
    fn numbers_that_no_unit_makes_likely_have_a_bound() {
        for far in ["inf", "-inf", "1e300", "5000"] {
            let said = metres(LARGEST_M)(far).unwrap_err();
            assert_eq!(said, "give metres, 2 at most", "{far}");
        }
        // What is not a number passes on to the command's own check.
        let length_m = metres(LARGEST_M);
        assert!(length_m("nan").unwrap().is_nan() && length_m("x").is_err());
        assert_eq!(range_deg("360"), Ok(360.0));
        assert_eq!(range_deg("1e300").unwrap_err(), "give degrees, 360 at most");
        let said = rate_hz("inf").unwrap_err();
        assert_eq!(said, "give rows per second, 50000 at most");
        assert_eq!(stays("0.5"), Ok(Stays::Alone(0.5)));
        assert_eq!(stays("0"), Ok(Stays::Moving));
        assert!(stays("-1").is_err() && stays("nan").is_err() && stays("x").is_err());
    }
}
