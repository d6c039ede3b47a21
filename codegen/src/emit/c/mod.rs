//! C99 from programs: one header and one source per robot and support.
//!
//! The same listing as Rust's: temporaries carry the same names in the same
//! order, and f64 and f32 give the same bits as Rust when contraction is off
//! (`-ffp-contract=off`). What does not depend on the robot stands in
//! `templates/`.

mod about;
mod columns;
mod core;
mod data;
mod estimator;
mod exported;
mod fixed;
mod float;
mod functions;
mod helpers;
mod lanes;
pub mod layout;
mod points;
mod prefix;
mod routines;
mod selftest;
mod servos;
mod sines;
mod spelling;
mod ticks;

use minijinja::value::{Serde, Value, merge_maps};
use minijinja::{Environment, context};
use serde::Serialize;

use crate::Error;
use crate::error::Problem;
use crate::facts::Facts;
use helpers::Calls;
pub(crate) use prefix::PREFIX;
pub use prefix::suggest;
pub use servos::{Scale, Servo, Servos, Setting};
use sesc_model::bounds::Precision;
use sesc_model::{Function, hash};
use spelling::{number, pair, quoted, spelled, unread};

/// Arithmetic of the generated C.
///
/// ```
/// use sesc_codegen::{Builder, Scalar};
///
/// let builder = Builder::new("op2.urdf").support("r_sole").c99("firmware").scalar(Scalar::F32);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Scalar {
    /// `double`.
    F64,
    /// `float`.
    F32,
    /// `int32_t`, binary points from proven ranges.
    Fixed32,
}

impl Scalar {
    fn c_type(self) -> &'static str {
        match self {
            Scalar::F64 => "double",
            Scalar::F32 => "float",
            Scalar::Fixed32 => "int32_t",
        }
    }

    fn precision(self) -> Option<Precision> {
        match self {
            Scalar::F64 => Some(Precision::F64),
            Scalar::F32 => Some(Precision::F32),
            Scalar::Fixed32 => None,
        }
    }
}

/// What to generate.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Options {
    /// Arithmetic.
    pub scalar: Scalar,
    /// Whether functions of servo ticks are wanted, and of which servos.
    pub servos: Option<Servos>,
    /// Whether the recursive estimator of the parameters is wanted, in f64 and f32.
    pub estimator: bool,
    /// Most postures that functions of many postures compute side by side: 4, 8 or 16, in f64
    /// and f32. Without it there are no such functions.
    pub lanes: Option<u32>,
}

impl Options {
    /// The usual for `scalar`: ticks of 4096 a turn in f32 and fixed32, none in f64; no
    /// estimator, no lanes.
    pub fn of(scalar: Scalar) -> Options {
        Options {
            scalar,
            servos: (scalar != Scalar::F64).then(Servos::default),
            estimator: false,
            lanes: None,
        }
    }
}

/// A header and a source file.
#[derive(Debug, Clone, PartialEq)]
pub struct Package {
    /// `NAME.h`.
    pub header: String,
    /// `NAME.c`.
    pub source: String,
    /// What the user should know: why `_ticks` functions are left out.
    pub notes: Vec<String>,
}

/// Header and source of a robot, every name beginning with `name`.
///
/// # Errors
/// When `name` is no prefix of C names or too long for a file, a servo setting makes no sense, a quantity does not
/// fit 32-bit fixed point, the estimator or lanes are wanted there, there are not 4, 8 or 16
/// lanes, or the estimator is wanted without the rows that it calls.
pub fn package(facts: &Facts, name: &str, options: &Options) -> Result<Package, Error> {
    PREFIX.check(name)?;
    let mut notes = Vec::new();
    let registers = lanes::widths(options)?;
    let ticks = ticks::Ticks::of(facts, options, &mut notes)?;
    let routines = routines::routines(facts, options, ticks.as_ref())?;
    let calls = Calls::new(name);
    let functions: Vec<functions::Text> = routines
        .iter()
        .map(|routine| functions::text(facts, routine, &routines, options.scalar, name, &calls))
        .collect();
    let from_ticks = ticks
        .as_ref()
        .map(|ticks| ticks.text(facts.dofs, name, &routines, &calls));
    let selftest = selftest::texts(facts, options.scalar, &routines, name, ticks.as_ref());
    let has = |function| routines.iter().any(|routine| routine.function == function);
    if options.estimator && !has(Function::RegressorCop) {
        return Err(Problem::EstimatorWithoutRows.into());
    }
    let corrects = has(Function::CorrectCop);
    let estimator = (options.estimator)
        .then(|| estimator::texts(facts, options.scalar, corrects))
        .transpose()?;
    let texts = context! {
        name,
        pair => PAIR,
        guard => format!("{}_H", name.to_uppercase()),
        about => about::about(facts, &routines, options),
        includes_stdint => options.scalar == Scalar::Fixed32
            || from_ticks.is_some()
            || options.estimator,
        has_shared => functions.iter().any(functions::Text::is_shared),
        has_lanes => options.lanes.is_some(),
        most_lanes => options.lanes,
        registers => listed(registers),
        has_infinity => data::has_infinity(facts, options),
        scalar_note => match options.scalar {
            Scalar::Fixed32 => ": an integer, its binary point by quantity as below",
            _ => "",
        },
        real => options.scalar.c_type(),
        dof => facts.dof(),
        base_params => facts.model.base.params.len(),
        full_params => facts.model.chain.full_params,
        context => facts.context.len(),
        points => listed(points::points(&routines, facts.model.total_mass_kg())),
        joints => data::enumerators(facts),
        constants => listed(data::constants(facts, options, &routines, name)),
        estimator => estimator,
        ticks => ticks.as_ref().map(|ticks| ticks.convention(facts.dofs)),
        ticks_beyond => ticks.as_ref().map(|ticks| ticks.beyond(facts.dofs)),
        functions => listed(functions),
        quarter => data::quarter(options.scalar),
        from_ticks => Value::from(Serde(from_ticks)),
        ..merge_maps([selftest, calls.texts(options.scalar)])
    };
    let [header, source] = paired([render("package.h", &texts)?, render("package.c", &texts)?]);
    Ok(Package {
        header,
        source,
        notes,
    })
}

/// Stands for the hash of both files until they are there, and is as long; no name of a robot
/// brings a control character so far.
const PAIR: &str =
    "\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}";

/// Header and source with the hash of both in their symbols, so that those of two runs do not
/// go together.
fn paired(texts: [String; 2]) -> [String; 2] {
    let begin = hash::START;
    let both = (texts.iter()).fold(begin, |hash, text| hash::fnv1a(hash, text.as_bytes()));
    texts.map(|text| text.replace(PAIR, &format!("{both:016x}")))
}

/// A template of this crate, filled in.
fn render(template: &str, texts: &Value) -> Result<String, Error> {
    let environment = environment();
    let template = environment.get_template(template);
    let text = template.and_then(|template| template.render(texts));
    text.map(|text| columns::fitted(&text)).map_err(emitted)
}

/// A template that does not render.
fn emitted(error: minijinja::Error) -> Error {
    let reason = format!("{error:#}");
    Problem::Emitted { reason }.into()
}

/// A list as a template reads it.
fn listed<T: Serialize + Send + Sync + 'static>(list: Vec<T>) -> Value {
    list.into_iter()
        .map(|item| Value::from(Serde(item)))
        .collect()
}

fn environment() -> Environment<'static> {
    let mut environment = Environment::new();
    environment.add_filter("taking_turns", sines::taking_turns);
    for (name, text) in [
        ("package.h", include_str!("templates/package.h")),
        ("package.c", include_str!("templates/package.c")),
        ("batch.c", include_str!("templates/batch.c")),
        ("estimator.h", include_str!("templates/estimator.h")),
        ("estimator.c", include_str!("templates/estimator.c")),
        ("includes.c", include_str!("templates/includes.c")),
        ("helpers.c", include_str!("templates/helpers.c")),
        ("table.c", include_str!("templates/table.c")),
        ("lanes.c", include_str!("templates/lanes.c")),
        ("kernel_lanes.c", include_str!("templates/kernel_lanes.c")),
        ("kernel_float.c", include_str!("templates/kernel_float.c")),
        ("kernel_fixed.c", include_str!("templates/kernel_fixed.c")),
        ("steps.c", include_str!("templates/steps.c")),
        ("reduction_f64.c", include_str!("templates/reduction_f64.c")),
        ("reduction_f32.c", include_str!("templates/reduction_f32.c")),
        ("series_f64.c", include_str!("templates/series_f64.c")),
        ("series_f32.c", include_str!("templates/series_f32.c")),
        ("bits.c", include_str!("templates/bits.c")),
        ("power_f64.c", include_str!("templates/power_f64.c")),
        ("power_f32.c", include_str!("templates/power_f32.c")),
        ("selftest.c", include_str!("templates/selftest.c")),
    ] {
        environment
            .add_template(name, text)
            .expect("the templates are part of this crate and parse");
    }
    environment
}
