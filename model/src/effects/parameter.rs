//! Parameters of effects and their units.
//!
//! Model files and JSON name a parameter with its unit at the end (`offset_rad`); what that
//! ending means stands here alone.

use core::f64::consts::PI;

/// The unit of an effect's parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Unit {
    /// A part of something: a scale, a gain, a slope, an exponent.
    One,
    /// An angle.
    Radian,
    /// A length.
    Metre,
    /// A mass.
    Kilogram,
    /// A force.
    Newton,
    /// A time.
    Second,
    /// The stiffness of a joint.
    NewtonMetrePerRadian,
    /// Another one, by its symbol: of a parameter of a formula.
    Other(&'static str),
}

impl Unit {
    /// All but [`Unit::One`], those with the longest endings first.
    const NAMED: [Unit; 6] = [
        Unit::NewtonMetrePerRadian,
        Unit::Radian,
        Unit::Kilogram,
        Unit::Metre,
        Unit::Newton,
        Unit::Second,
    ];

    /// The unit of the parameter that files call `name`.
    ///
    /// ```
    /// use sesc_model::effects::Unit;
    ///
    /// assert_eq!(Unit::of("stiffness_nm_per_rad"), Unit::NewtonMetrePerRadian);
    /// assert_eq!(Unit::of("gain_x"), Unit::One);
    /// ```
    pub const fn of(name: &str) -> Unit {
        let mut k = 0;
        while k < Unit::NAMED.len() {
            if ends_with(name.as_bytes(), Unit::NAMED[k].ending().as_bytes()) {
                return Unit::NAMED[k];
            }
            k += 1;
        }
        Unit::One
    }

    /// The unit of this symbol.
    pub fn by_symbol(symbol: &'static str) -> Unit {
        let named = Unit::NAMED.into_iter().chain([Unit::One]);
        let known = |unit: &Unit| unit.symbol() == symbol;
        named.into_iter().find(known).unwrap_or(Unit::Other(symbol))
    }

    /// The parameter that files call `name` without its unit: `force x` of `force_x_n`.
    pub fn stem(name: &str) -> String {
        let ending = Unit::of(name).ending();
        name[..name.len() - ending.len()].replace('_', " ")
    }

    /// What names of parameters with this unit end in: `_rad`.
    const fn ending(self) -> &'static str {
        match self {
            Unit::One | Unit::Other(_) => "",
            Unit::Radian => "_rad",
            Unit::Metre => "_m",
            Unit::Kilogram => "_kg",
            Unit::Newton => "_n",
            Unit::Second => "_s",
            Unit::NewtonMetrePerRadian => "_nm_per_rad",
        }
    }

    /// Its symbol; `1` where there is none.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::One => "1",
            Unit::Radian => "rad",
            Unit::Metre => "m",
            Unit::Kilogram => "kg",
            Unit::Newton => "N",
            Unit::Second => "s",
            Unit::NewtonMetrePerRadian => "Nm/rad",
            Unit::Other(symbol) => symbol,
        }
    }

    /// What a value is multiplied with for people, and the symbol of the unit that it then has;
    /// an empty one where there is none.
    pub fn shown(self) -> (f64, &'static str) {
        match self {
            Unit::One => (1.0, ""),
            Unit::Radian => (180.0 / PI, "°"),
            Unit::Metre => (1e3, "mm"),
            Unit::Kilogram => (1e3, "g"),
            Unit::Second => (1e3, "ms"),
            Unit::Newton | Unit::NewtonMetrePerRadian | Unit::Other(_) => (1.0, self.symbol()),
        }
    }

    /// Units in which people may write a value, and how many of this unit each is; one that
    /// ends in another comes before it.
    pub fn spellings(self) -> &'static [(&'static str, f64)] {
        match self {
            Unit::One => &[("%", 1e-2)],
            Unit::Radian => &[("deg", PI / 180.0), ("°", PI / 180.0), ("rad", 1.0)],
            Unit::Metre => &[("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)],
            Unit::Kilogram => &[("kg", 1.0), ("g", 1e-3)],
            Unit::Newton => &[("N", 1.0)],
            Unit::Second => &[("ms", 1e-3), ("s", 1.0)],
            Unit::NewtonMetrePerRadian => &[("Nm/rad", 1.0)],
            Unit::Other(_) => &[],
        }
    }
}

/// `str::ends_with`, which is not const.
const fn ends_with(name: &[u8], ending: &[u8]) -> bool {
    if ending.len() > name.len() {
        return false;
    }
    let mut k = 0;
    while k < ending.len() {
        if name[name.len() - ending.len() + k] != ending[k] {
            return false;
        }
        k += 1;
    }
    true
}

/// A parameter of an effect as people know it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// With its unit at the end: `offset_rad`, `mass_kg`.
    pub name: &'static str,
    /// That unit.
    pub unit: Unit,
    /// An ordinary size of the unknown that it belongs to.
    pub scale: f64,
    /// What that unknown is.
    pub fitted: Fitted,
}

/// The unknown that is fitted for a parameter: zero where there is no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fitted {
    /// The value.
    Value,
    /// The value less one: of a factor.
    LessOne,
    /// The value over the robot's weight: of a force.
    OverWeight,
    /// The robot's weight over the value: of a stiffness.
    WeightOver,
}

impl Fitted {
    /// The value that this unknown means, on a robot of `weight` N.
    pub fn value(self, unknown: f64, weight: f64) -> f64 {
        match self {
            Fitted::Value => unknown,
            Fitted::LessOne => 1.0 + unknown,
            Fitted::OverWeight => unknown * weight,
            Fitted::WeightOver => weight / unknown,
        }
    }

    /// The unknown that has this value.
    pub fn unknown(self, value: f64, weight: f64) -> f64 {
        match self {
            Fitted::Value => value,
            Fitted::LessOne => value - 1.0,
            Fitted::OverWeight => value / weight,
            Fitted::WeightOver => weight / value,
        }
    }
}

impl Parameter {
    /// A parameter and an ordinary size of its unknown; its unit is the one that its name ends
    /// in.
    ///
    /// ```
    /// use sesc_model::effects::{Parameter, Unit};
    ///
    /// const WIDTH: Parameter = Parameter::new("width_rad", 0.02);
    /// assert_eq!(WIDTH.unit, Unit::Radian);
    /// ```
    pub const fn new(name: &'static str, scale: f64) -> Parameter {
        Parameter {
            name,
            unit: Unit::of(name),
            scale,
            fitted: Fitted::Value,
        }
    }

    /// The same, of which something else than the value is fitted.
    pub const fn fitted(self, fitted: Fitted) -> Parameter {
        Parameter { fitted, ..self }
    }
}

/// A parameter with its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// With its unit: `offset_rad`, `mass_kg`.
    pub name: &'static str,
    /// In that unit.
    pub value: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_a_stem_and_a_unit() {
        for (name, stem, unit) in [
            ("force_x_n", "force x", "N"),
            ("offset_x_m", "offset x", "mm"),
            ("stiffness_nm_per_rad", "stiffness", "Nm/rad"),
            ("delay_s", "delay", "ms"),
            ("mass_kg", "mass", "g"),
            ("yaw_rad", "yaw", "°"),
            ("slope_x", "slope x", ""),
        ] {
            assert_eq!((&*Unit::stem(name), Unit::of(name).shown().1), (stem, unit));
        }
        assert_eq!(Unit::of("m"), Unit::One);
    }

    #[test]
    fn a_spelling_is_found_by_what_a_text_ends_in() {
        for unit in Unit::NAMED {
            for (k, (spelling, _)) in unit.spellings().iter().enumerate() {
                let first = unit
                    .spellings()
                    .iter()
                    .position(|(s, _)| spelling.ends_with(s));
                assert_eq!(first, Some(k), "{spelling} of {unit:?}");
            }
        }
    }
}
