//! Units of options: a length that can only have been meant in millimetres is refused.

use sesc_identify::logs::Stays;

/// No sensor of a robot that stands is noisier, m.
const NOISIEST_M: f64 = 0.1;
/// No sole, and no height above it that a plan keeps clear, is larger, m; who wants no bound
/// gives a metre or more.
const LARGEST_M: f64 = 10.0;

/// A standard deviation of a reading, m.
pub(super) fn deviation_m(text: &str) -> Result<f64, String> {
    metres(text, NOISIEST_M)
}

/// How long a robot holds still, s.
pub(super) fn stays(text: &str) -> Result<Stays, String> {
    let seconds = text.parse();
    Stays::alone(seconds.map_err(|_| "give a number of seconds".to_string())?)
}

/// A length on the robot's scale, m.
pub(super) fn length_m(text: &str) -> Result<f64, String> {
    metres(text, LARGEST_M)
}

/// A number of metres, up to `most` either way; what else is wrong with it is for the command
/// to say.
fn metres(text: &str, most: f64) -> Result<f64, String> {
    let value: f64 = text
        .parse()
        .map_err(|_| "give a number of metres".to_string())?;
    match value.abs() > most {
        true => Err(format!(
            "that is {value} m; give metres: {} for {value} mm",
            value / 1000.0
        )),
        false => Ok(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn millimetres_are_told_from_metres() {
        assert_eq!(deviation_m("0.0005"), Ok(0.0005));
        let said = deviation_m("0.5").unwrap_err();
        assert!(said.contains("0.0005 for 0.5 mm"), "{said}");
        assert!(length_m("23").unwrap_err().contains("0.023 for 23 mm"));
        assert!(length_m("inf").is_err() && length_m("x").is_err());
        // What is not a number passes on to the command's own check.
        assert!(length_m("nan").unwrap().is_nan());
        assert_eq!(stays("0.5"), Ok(Stays::Alone(0.5)));
        assert!(stays("0").is_err() && stays("nan").is_err() && stays("x").is_err());
    }
}
