//! Units of options: a value that can only have been meant in another unit, such as a length in
//! millimetres, is refused with what was meant.

use sesc_identify::logs::Stays;
use sesc_model::Model;
use sesc_model::effects::Unit;

use crate::Error;

/// No sensor of a robot that stands is noisier, m.
const NOISIEST_M: f64 = 0.1;
/// No sole, and no height above it that a plan keeps clear, is larger, m; who wants no bound
/// gives a metre.
const LARGEST_M: f64 = 2.0;
/// No sole leaves room for a margin so wide, m.
const WIDEST_M: f64 = 0.25;
/// No joint is drawn from more than a turn either way, degrees.
const TURN_DEG: f64 = 360.0;
/// No encoder of a robot is read more often, Hz.
const FASTEST_HZ: f64 = 50_000.0;
/// A robot does not weigh so many times what CAD says, or so small a part of it.
const MASS_RATIO: f64 = 100.0;

/// An angle or a length of a hidden effect that is given without its unit is no larger, rad or m.
const HIDDEN_RAD: f64 = 0.6;
const HIDDEN_M: f64 = 1.0;
/// A mass that is given without its unit is no larger a part of what the robot weighs.
const HIDDEN_PART: f64 = 3.0;

/// What is hidden in a simulated robot: `effects` as they were typed, which the model has last.
///
/// # Errors
/// A number without a unit that is no likely one of rad, m or kg.
pub(super) fn check_hidden(effects: &[String], model: &Model) -> Result<(), Error> {
    let robot_kg = model.tree.mass;
    let records = model.file.as_ref().map_or(&[][..], |file| &file.effects);
    let typed = effects.iter().rev().zip(records.iter().rev());
    for (text, record) in typed {
        let values = text.rsplit_once('=').map_or("", |(_, values)| values);
        let bare: Vec<f64> = values
            .split(',')
            .filter_map(|x| x.trim().parse().ok())
            .collect();
        for (name, value) in &record.parameters {
            let value = value.value;
            let (most, shown, meant, unit) = match Unit::of(name) {
                Unit::Radian => (
                    HIDDEN_RAD,
                    format!("{:.0}°", value.to_degrees()),
                    "deg",
                    "rad",
                ),
                Unit::Metre => (HIDDEN_M, format!("{} mm", 1e3 * value), "mm", "m"),
                Unit::Kilogram => {
                    let shown = format!("the robot weighs {robot_kg:.3} kg");
                    (HIDDEN_PART * robot_kg, shown, "g", "kg")
                }
                _ => continue,
            };
            if value.abs() > most && bare.contains(&value) {
                return Err(Error::Usage(format!(
                    "--hide {text}: {value} of {name} is {value} {unit} ({shown}); give its unit: \
                     {value}{meant}, or {value}{unit} if that is meant"
                )));
            }
        }
    }
    Ok(())
}

/// A standard deviation of a reading, m.
pub(super) fn deviation_m(text: &str) -> Result<f64, String> {
    metres(text, NOISIEST_M)
}

/// How long a robot holds still, s.
pub(super) fn stays(text: &str) -> Result<Stays, String> {
    let seconds = text.parse();
    Stays::settled(seconds.map_err(|_| "give a number of seconds".to_string())?)
}

/// A length on the robot's scale, m.
pub(super) fn length_m(text: &str) -> Result<f64, String> {
    metres(text, LARGEST_M)
}

/// A distance from the edge of a sole, m.
pub(super) fn margin_m(text: &str) -> Result<f64, String> {
    metres(text, WIDEST_M)
}

/// A range of joint angles, degrees.
pub(super) fn range_deg(text: &str) -> Result<f64, String> {
    let meant = |x: f64| (x / 1000.0).to_degrees();
    number(
        text,
        "degrees",
        TURN_DEG,
        |x| meant(x).abs() <= TURN_DEG,
        |x| {
            let meant = meant(x);
            format!("that is {x}°, more than a turn; give degrees: {meant:.4} for {x} mrad")
        },
    )
}

/// Rows per second.
pub(super) fn rate_hz(text: &str) -> Result<f64, String> {
    number(
        text,
        "rows per second",
        FASTEST_HZ,
        |x| (0.0..=1e9).contains(&x),
        |x| {
            let rate = 1e9 / x;
            format!(
                "that is {x} rows a second, more than any robot logs; give Hz: {rate} for a row every \
             {x} ns"
            )
        },
    )
}

/// Whether a robot of `cad_kg` may weigh `kg`; what else is wrong with it is for the command to
/// say.
pub(super) fn check_mass(kg: Option<f64>, cad_kg: f64) -> Result<(), Error> {
    let Some(kg) = kg.filter(|kg| *kg > MASS_RATIO * cad_kg && cad_kg > 0.0) else {
        return Ok(());
    };
    Err(Error::Usage(format!(
        "--total-mass {kg}: that is {kg} kg, and the robot weighs {cad_kg:.3} kg in its URDF; give \
         kilograms: {} for {kg} g",
        kg / 1000.0
    )))
}

/// A number of metres, up to `most` either way; what else is wrong with it is for the command
/// to say.
fn metres(text: &str, most: f64) -> Result<f64, String> {
    // Millimetres would be too much, too.
    number(
        text,
        "metres",
        most,
        |x| (x / 1000.0).abs() <= most,
        |x| {
            let meant = x / 1000.0;
            format!("that is {x} m; give metres: {meant} for {x} mm")
        },
    )
}

/// A number up to `most` either way. What is more `is_likely` to have been typed in another unit is
/// refused with what was `meant`.
fn number(
    text: &str,
    unit: &str,
    most: f64,
    is_likely: impl Fn(f64) -> bool,
    meant: impl Fn(f64) -> String,
) -> Result<f64, String> {
    let value: f64 = text
        .parse()
        .map_err(|_| format!("give a number of {unit}"))?;
    match value.abs() > most {
        true if is_likely(value) => Err(meant(value)),
        true => Err(format!("give {unit}, {most} at most")),
        false => Ok(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the command line's own tests do not type.
    #[test]
    fn numbers_that_no_unit_makes_likely_have_a_bound() {
        for far in ["inf", "-inf", "1e300", "5000"] {
            let said = length_m(far).unwrap_err();
            assert_eq!(said, "give metres, 2 at most", "{far}");
        }
        // What is not a number passes on to the command's own check.
        assert!(length_m("nan").unwrap().is_nan() && length_m("x").is_err());
        assert_eq!(range_deg("360"), Ok(360.0));
        assert_eq!(range_deg("1e300").unwrap_err(), "give degrees, 360 at most");
        let said = rate_hz("inf").unwrap_err();
        assert_eq!(said, "give rows per second, 50000 at most");
        assert!(check_mass(Some(3.0), 2.9).is_ok() && check_mass(None, 0.0).is_ok());
        assert_eq!(stays("0.5"), Ok(Stays::Alone(0.5)));
        assert_eq!(stays("0"), Ok(Stays::Moving));
        assert!(stays("-1").is_err() && stays("nan").is_err() && stays("x").is_err());
    }
}
