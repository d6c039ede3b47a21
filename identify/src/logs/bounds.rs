//! What a value of a log can be: beyond it no sensor, sole or robot is.
//!
//! ```text
//! joint     20 bits of rad, m: beyond it sines mean nothing      10⁶ m
//! t         10¹⁵ s: a clock of today in nanoseconds is beyond it
//! CoP, its deviation      10⁶, in whatever unit it was logged: a metre in micrometres
//! force, its deviation    10⁹ N
//! gravity   0.01 to 10⁶ m/s², of which the sine of a degree pulls onto the sole
//! ```
//!
//! Values within these bounds keep every later sum of squares finite. They are wide: which
//! unit a log is in, and which rows are outliers, is for others to find.

use sesc_model::tree::Dof;

use super::settings::{IN_DEGREES, OR_SIDECAR};
use crate::{Message, Setting, message};

/// Least force on a sole, N: with less, nothing stands on it, whoever measured it.
pub(crate) const LEAST_LOAD_N: f64 = 1.0;
/// Largest angle, rad, as the table says.
const ANGLE_RAD: f64 = 1_048_576.0;

/// The values that a column can have, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bound {
    least: f64,
    most: f64,
    unit: &'static str,
}

impl Bound {
    /// Any finite value.
    pub(super) const ANY: Bound = Bound::within(f64::MAX, "");
    pub(super) const COP: Bound = Bound::within(1e6, "m");
    pub(super) const FORCE: Bound = Bound::within(1e9, "N");

    pub(super) const fn within(most: f64, unit: &'static str) -> Bound {
        Bound {
            least: -most,
            most,
            unit,
        }
    }

    /// Deviations of such values, which are positive.
    pub(super) const fn of_deviation(self) -> Bound {
        Bound {
            least: f64::MIN_POSITIVE,
            ..self
        }
    }

    pub(super) fn joint(dof: &Dof, any_unit: bool) -> Bound {
        if dof.prismatic {
            return Bound::within(1e6, "m");
        }
        // Further out than a full turn a joint with limits was hardly logged in radians.
        let reach = match dof.continuous || any_unit {
            true => f64::INFINITY,
            false => 6.3_f64.max(dof.lower.abs()).max(dof.upper.abs()),
        };
        Bound::within(reach.min(ANGLE_RAD), "rad")
    }

    pub(super) fn holds(&self, value: f64) -> bool {
        self.least <= value && value <= self.most
    }

    /// Whether a value is one that can be meant, with its column and a remedy where it is not.
    pub(super) fn check(&self, name: &str, value: f64) -> Result<(), Message> {
        let said = if !value.is_finite() {
            format!("{value:?} is not finite; remove the row or mend the value")
        } else if self.holds(value) {
            return Ok(());
        } else if self.least > 0.0 && value <= 0.0 {
            format!("a standard deviation of {value}; it must be positive, or leave out the column")
        } else {
            match self.unit {
                "rad" if self.most < ANGLE_RAD => return Err(beyond_a_turn(name, value)),
                "rad" => format!(
                    "{value:?} rad: an angle is beyond 2^20 rad, where sines mean nothing; reduce \
                     it by whole turns, or mend the value"
                ),
                "s" => format!("{value:?} s is beyond every clock; give seconds"),
                _ => format!(
                    "{value:?} is beyond {:e}, more than any sensor reads; remove the row or mend \
                     the value",
                    self.most
                ),
            }
        };
        Err(format!("column `{name}`: {said}").into())
    }
}

fn beyond_a_turn(name: &str, rad: f64) -> Message {
    let said = format!(
        "column `{name}`: {} rad is more than a full turn",
        three_digits(rad)
    );
    // No joint is logged further out in degrees.
    if rad.abs() > 400.0 {
        let remedy = "give (ticks − zero) · 2π / ticks of a turn";
        return format!("{said}, and would be in degrees: are these ticks of an encoder? {remedy}")
            .into();
    }
    message![format!("{said}; {IN_DEGREES}"), Setting::Angles, OR_SIDECAR]
}

/// The same of a CoP that forces on cells give.
pub(super) fn check_cop([x, y]: [f64; 2]) -> Result<(), Message> {
    let check = |x| Bound::COP.check("cop_x, cop_y of the forces", x);
    check(x).and_then(|()| check(y))
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

#[cfg(test)]
mod tests {
    use super::*;

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
