//! Values of options and of Python's keywords. Words stand in a table with what they mean. So do
//! numbers with their unit: one that can only have been meant in another unit, such as a length in
//! millimetres, is refused with what was meant.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use sesc_codegen::{Layout, Scalar};
use sesc_identify::fit::{Duplicates, Loss, MotionModel};
use sesc_identify::fleet::Only;
use sesc_identify::logs::Stays;
use sesc_identify::robot::Robot;

/// Words that an option takes, what they mean, and what help says of those that do not speak for
/// themselves.
pub type Words<T> = [(&'static str, T, &'static str)];

/// What becomes of factor files whose logs are all in another one.
pub const DUPLICATES: &Words<Duplicates> = &[
    ("refuse", Duplicates::Refuse, ""),
    ("skip", Duplicates::Skip, ""),
];
/// What is put around the C of a robot.
pub const LAYOUTS: &Words<Layout> = &[
    ("bare", Layout::Bare, "NAME.h and NAME.c, nothing else"),
    (
        "cmake",
        Layout::Cmake,
        "CMake project: target NAME::NAME, FetchContent, find_package, pkg-config",
    ),
    (
        "platformio",
        Layout::PlatformIo,
        "PlatformIO library, for any framework and platform",
    ),
    (
        "arduino",
        Layout::Arduino,
        "Library of the Arduino IDE, with an example",
    ),
];
/// How postures are trusted less that no noise explains.
pub const LOSSES: &Words<Loss> = &[("huber", Loss::Huber, ""), ("tukey", Loss::Tukey, "")];
/// Whether the motion of the joints counts.
pub const MOTION: &Words<MotionModel> = &[
    ("auto", MotionModel::Auto, ""),
    ("off", MotionModel::Off, ""),
];
/// What alone is made of each robot and day of a fleet.
pub const ONLY: &Words<Only> = &[("parameters", Only::Parameters, "")];
/// Arithmetic of C.
pub const SCALARS: &Words<Scalar> = &[
    ("f64", Scalar::F64, ""),
    ("f32", Scalar::F32, ""),
    (
        "fixed32",
        Scalar::Fixed32,
        "32-bit integers with proven binary points, for processors without FPU",
    ),
];

/// One of these words.
pub(super) fn one_of<T: Copy + Send + Sync + 'static>(
    words: &'static Words<T>,
) -> impl TypedValueParser<Value = T> {
    let possible = words.iter().map(|(word, _, help)| match *help {
        "" => PossibleValue::new(*word),
        help => PossibleValue::new(*word).help(help),
    });
    PossibleValuesParser::new(possible).try_map(|typed| {
        let meant = words.iter().find(|(word, ..)| *word == typed);
        meant.map(|(_, value, _)| *value).ok_or("no such word")
    })
}

/// What a number is, and how large it can be meant.
#[derive(Clone, Copy)]
enum Size {
    /// Metres, so many at most either way.
    Metres(f64),
    Hertz,
    /// A range of joint angles: degrees on the command line, radians in Python.
    Turn,
}

/// Options and keywords that are numbers with a unit. No sensor of a robot that stands is noisier,
/// no sole leaves room for a wider margin, and no sole, and no height above it that a plan keeps
/// clear, is larger; who wants no bound gives a metre.
const SIZES: [(&str, Size); 9] = [
    ("noise", Size::Metres(0.1)),
    ("offset", Size::Metres(1.0)),
    ("floor", Size::Metres(0.1)),
    ("cop_box", Size::Metres(2.0)),
    ("clearance", Size::Metres(2.0)),
    ("margin", Size::Metres(0.25)),
    ("rate", Size::Hertz),
    ("range", Size::Turn),
    ("sole_height", Size::Metres(2.0)),
];
/// No joint is drawn from more than a turn either way, degrees.
const TURN_DEG: f64 = 360.0;
/// No encoder of a robot is read more often, Hz.
const FASTEST_HZ: f64 = 50_000.0;
/// A robot does not weigh so many times what CAD says, or so small a part of it.
const MASS_RATIO: f64 = 100.0;

/// Keywords whose values [`check`] knows.
pub fn sized() -> impl Iterator<Item = &'static str> {
    SIZES.into_iter().map(|(keyword, _)| keyword)
}

fn size(keyword: &str) -> Option<Size> {
    let mut all = SIZES.into_iter();
    all.find_map(|(known, size)| (known == keyword).then_some(size))
}

/// Whether the value of a keyword of Python can be meant: in SI units, so that a range is in rad.
///
/// # Errors
/// What is more likely to be in another unit, with what was meant.
pub fn check(keyword: &str, value: f64) -> Result<(), String> {
    match size(keyword) {
        Some(Size::Metres(most)) => check_m(value, most),
        Some(Size::Hertz) => check_hz(value),
        Some(Size::Turn) => check_rad(value),
        None => Ok(()),
    }
}

/// The number of an option of this name, in its unit; what else is wrong with it is for the command
/// to say.
pub(super) fn number(option: &'static str) -> impl Fn(&str) -> Result<f64, String> + Clone {
    let size = size(option).expect("an option that is a number stands in the table");
    move |text| {
        let (unit, check): (_, &dyn Fn(f64) -> Result<(), String>) = match size {
            Size::Metres(most) => ("metres", &move |x| check_m(x, most)),
            Size::Hertz => ("rows per second", &check_hz),
            Size::Turn => ("degrees", &check_deg),
        };
        let value = text.parse();
        let value = value.map_err(|_| format!("give a number of {unit}"))?;
        check(value).map(|()| value)
    }
}

/// How long a robot holds still, s.
pub(super) fn stays(text: &str) -> Result<Stays, String> {
    let seconds = text.parse();
    Stays::settled(seconds.map_err(|_| "give a number of seconds".to_string())?)
}

fn check_deg(x: f64) -> Result<(), String> {
    let meant = (x / 1000.0).to_degrees();
    match x.abs() > TURN_DEG {
        true if meant.abs() <= TURN_DEG => Err(format!(
            "that is {x}°, more than a turn; give degrees: {meant:.4} for {x} mrad"
        )),
        true => Err(format!("give degrees, {TURN_DEG} at most")),
        false => Ok(()),
    }
}

fn check_rad(x: f64) -> Result<(), String> {
    let most = TURN_DEG.to_radians();
    match x.to_degrees().abs() > TURN_DEG {
        true if x.abs() <= TURN_DEG => Err(format!(
            "that is {x} rad, more than a turn; give radians: {:.4} for {x}°",
            x.to_radians()
        )),
        true => Err(format!("give radians, {most:.4} at most")),
        false => Ok(()),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// What the command line's own tests do not type.
    #[test]
    fn numbers_that_no_unit_makes_likely_have_a_bound() {
        for far in ["inf", "-inf", "1e300", "5000"] {
            let said = number("cop_box")(far).unwrap_err();
            assert_eq!(said, "give metres, 2 at most", "{far}");
        }
        // What is not a number passes on to the command's own check.
        let length_m = number("cop_box");
        assert!(length_m("nan").unwrap().is_nan() && length_m("x").is_err());
        assert_eq!(number("range")("360"), Ok(360.0));
        assert_eq!(
            number("range")("1e300").unwrap_err(),
            "give degrees, 360 at most"
        );
        let said = number("rate")("inf").unwrap_err();
        assert_eq!(said, "give rows per second, 50000 at most");
        assert_eq!(stays("0.5"), Ok(Stays::Alone(0.5)));
        assert_eq!(stays("0"), Ok(Stays::Moving));
        assert!(stays("-1").is_err() && stays("nan").is_err() && stays("x").is_err());
    }
}
