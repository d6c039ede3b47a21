//! What a value of a log can be: beyond it no sensor, sole or robot is.
//!
//! Values within these bounds keep every later sum of squares finite. They are wide: which
//! unit a log is in, and which rows are outliers, is for others to find.

use crate::{Message, Setting, message};

/// Largest angle of a joint, rad: beyond it sines mean nothing (2^20).
pub(super) const ANGLE_RAD: f64 = 1_048_576.0;
/// Largest stroke of a prismatic joint, m.
pub(super) const STROKE_M: f64 = 1e6;
/// Largest CoP, and deviation of one, in whatever unit it was logged: a metre in micrometres.
pub(super) const COP: f64 = 1e6;
/// Largest force of a cell, and deviation of one, N.
pub(super) const FORCE_N: f64 = 1e9;
/// Least force on a sole, N: with less, nothing stands on it, whoever measured it.
pub(crate) const LEAST_LOAD_N: f64 = 1.0;
/// Largest time, s; in nanoseconds a clock of today is beyond it.
pub(super) const TIME_S: f64 = 1e15;
/// Largest entry of gravity, m/s².
pub(super) const GRAVITY: f64 = 1e6;
/// Least gravity that holds a robot on the ground, m/s²; a direction of length 1 is more.
const LEAST_GRAVITY: f64 = 0.01;
/// Part of gravity that must pull onto the sole: the sine of a degree.
pub(super) const ONTO_SOLE: f64 = 0.017;
/// A CoP is typically known better than this, m, or its deviation is not in metres.
pub(super) const STD_M: f64 = 0.1;

/// Whether a value is one that can be meant, with its column and a remedy where it is not.
pub(super) fn check(name: &str, value: f64, most: f64) -> Result<(), Message> {
    if value.is_finite() && value.abs() <= most {
        return Ok(());
    }
    let what = match value.is_finite() {
        true => format!("is beyond {most:e}, more than any sensor reads"),
        false => "is not finite".to_string(),
    };
    Err(format!("column `{name}`: {value:?} {what}; remove the row or mend the value").into())
}

/// The same of a joint's position, rad or m.
pub(super) fn check_joint(name: &str, value: f64, prismatic: bool) -> Result<(), Message> {
    if prismatic {
        return check(name, value, STROKE_M);
    }
    if value.abs() <= ANGLE_RAD {
        return Ok(());
    }
    Err(format!(
        "column `{name}`: {value:?} rad: an angle is beyond 2^20 rad, where sines mean nothing; \
         reduce it by whole turns, or mend the value"
    )
    .into())
}

/// The same of the time of a row.
pub(super) fn check_time(name: &str, value: f64) -> Result<(), Message> {
    if value.abs() <= TIME_S {
        return Ok(());
    }
    Err(format!("column `{name}`: {value:?} s is beyond every clock; give seconds").into())
}

/// Gravity must pull onto the sole, or nothing stands on it.
pub(super) fn check_gravity([x, y, z]: [f64; 3]) -> Result<(), String> {
    let largest = [x, y, z].iter().fold(0.0, |most: f64, g| most.max(g.abs()));
    // By the largest entry, so that no square overflows.
    let size = [x, y, z]
        .iter()
        .map(|g| (g / largest).powi(2))
        .sum::<f64>()
        .sqrt();
    let pulls = z < 0.0 && -z / largest >= ONTO_SOLE * size;
    if pulls
        && (LEAST_GRAVITY..=GRAVITY).contains(&largest)
        && [x, y, z].iter().all(|g| g.is_finite())
    {
        Ok(())
    } else {
        Err(format!(
            "gravity [{x:?}, {y:?}, {z:?}] does not pull onto the sole; its z must be negative, \
             m/s², and not small beside the others"
        ))
    }
}

/// A number with three digits that count, as people write it.
pub(super) fn three_digits(x: f64) -> String {
    match x.abs() {
        size if (1e-3..1e5).contains(&size) => {
            let digits = (2.0 - size.log10().floor()).max(0.0) as usize;
            format!("{x:.digits$}")
        }
        _ => format!("{x:.2e}"),
    }
}

/// Deviations as they typically stand in a log whose CoP is in metres.
pub(super) fn check_typical_std(typical: f64) -> Result<(), Message> {
    if typical <= STD_M {
        return Ok(());
    }
    Err(message![
        format!(
            "columns `cop_x_std`, `cop_y_std`: a reading is typically known to {} m, more than a \
             sole; give metres, not millimetres, or leave out the columns and give ",
            three_digits(typical)
        ),
        Setting::Noise
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_pulls_onto_the_sole() {
        for [x, y, z] in [[0.0, 0.0, -9.80665], [0.0, 0.0, -1.0], [1.0, 1.0, -9.7]] {
            assert_eq!(check_gravity([x, y, z]), Ok(()));
        }
        let least = f64::MIN_POSITIVE;
        for z in [
            9.8,
            0.0,
            -least,
            -1e-300,
            -1e-3,
            -1e7,
            f64::NEG_INFINITY,
            f64::NAN,
        ] {
            assert!(check_gravity([0.0, 0.0, z]).is_err(), "{z:?}");
        }
    }

    #[test]
    fn numbers_have_three_digits_that_count() {
        for (x, said) in [
            (83.082_602_608_169_72, "83.1"),
            (2.5, "2.50"),
            (0.012_34, "0.0123"),
            (12_345.6, "12346"),
            (1.5e300, "1.50e300"),
            (0.0, "0.00e0"),
        ] {
            assert_eq!(three_digits(x), said);
        }
    }
}
