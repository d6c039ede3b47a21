//! C99 from programs: one header and one source per robot and support.
//!
//! The same listing as Rust's: temporaries carry the same names in the same
//! order, and f64 and f32 give the same bits as Rust when contraction is off
//! (`-ffp-contract=off`). What does not depend on the robot stands in
//! `templates/`.

mod fixed;
mod float;
pub mod free;
mod functions;
pub mod layout;
mod selftest;
mod servos;
mod tables;
mod ticks;

use minijinja::value::{Serde, Value};
use minijinja::{Environment, context};
use serde::Serialize;

use super::listing::Listing;
use super::{header, names};
use crate::Error;
use functions::Routine;
pub use servos::{Servos, Setting};
use sesc_model::Model;
use sesc_model::bounds::Precision;
use sesc_model::expr::{Argument, Id};

/// Arithmetic of the generated C.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    F64,
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
pub struct Options {
    pub scalar: Scalar,
    /// Whether functions of servo ticks are wanted, and of which servos.
    pub servos: Option<Servos>,
}

impl Options {
    /// The usual for `scalar`: ticks of 4096 a turn in f32 and fixed32, none in f64.
    pub fn of(scalar: Scalar) -> Options {
        Options {
            scalar,
            servos: (scalar != Scalar::F64).then(Servos::default),
        }
    }
}

/// A header and a source file.
#[derive(Debug, Clone, PartialEq)]
pub struct Package {
    pub header: String,
    pub source: String,
    /// What the user should know: why `_ticks` functions are left out.
    pub notes: Vec<String>,
}

/// Longest prefix: macros with it stay distinct in C99's 63 characters.
const LONGEST_NAME: usize = 32;

/// Headers of the C library: a file of that name would stand in their way.
const HEADERS: [&str; 24] = [
    "assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits",
    "locale", "math", "setjmp", "signal", "stdarg", "stdbool", "stddef", "stdint", "stdio",
    "stdlib", "string", "tgmath", "time", "wchar", "wctype",
];

/// Whether `name` serves as a prefix of C and C++ names, and of files.
pub fn is_prefix(name: &str) -> bool {
    name.len() <= LONGEST_NAME
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
        && !HEADERS.contains(&name.to_lowercase().as_str())
}

/// A name like `name` that serves.
pub fn suggest(name: &str) -> String {
    let mut word = names::module(name);
    while word.contains("__") {
        word = word.replace("__", "_");
    }
    word.truncate(LONGEST_NAME);
    let word = word.trim_end_matches('_');
    match is_prefix(word) {
        true => word.to_string(),
        false => format!("{word}_robot"),
    }
}

/// Header and source for `model`, every name beginning with `name`.
///
/// # Errors
/// When `name` is no prefix of C names, a servo setting makes no sense, or a
/// quantity does not fit 32-bit fixed point.
pub fn package(model: &Model, name: &str, options: &Options) -> Result<Package, Error> {
    if !is_prefix(name) {
        return Err(Error::BadPrefix {
            name: name.to_string(),
            suggestion: suggest(name),
        });
    }
    let mut notes = Vec::new();
    let ticks = ticks::Ticks::of(model, options, &mut notes)?;
    if ticks.as_ref().is_some_and(|ticks| !ticks.reach_cop(model)) {
        notes.push(
            "cop_ticks is left out: effects are written for joint angles; call cop with those"
                .to_string(),
        );
    }
    let routines = functions::routines(model, options.scalar, ticks.as_ref())?;
    let functions: Vec<functions::Text> = routines
        .iter()
        .map(|routine| functions::text(model, routine, options.scalar, name))
        .collect();
    let from_ticks = ticks
        .as_ref()
        .map(|ticks| ticks.text(model, options.scalar, name, &routines));
    let needs = Needs::of(&functions, from_ticks.as_ref(), options.scalar, name);
    let arrays = tables::arrays(model, options.scalar, &routines, name);
    let (selftest, results) =
        selftest::checks(model, options.scalar, &routines, name, ticks.as_ref());
    let points = functions::points(&routines);
    let joints: Vec<String> = model
        .tree
        .dofs
        .iter()
        .map(|dof| quoted(&dof.joint))
        .collect();
    let texts = context! {
        name,
        guard => format!("{}_H", name.to_uppercase()),
        about => about(model, &routines, options.scalar),
        includes_stdint => options.scalar == Scalar::Fixed32 || from_ticks.is_some(),
        scalar_note => match options.scalar {
            Scalar::Fixed32 => ": an integer, its binary point by quantity as below",
            _ => "",
        },
        real => options.scalar.c_type(),
        dof => model.dof(),
        base_params => model.base.params.len(),
        full_params => model.chain.full_params,
        points => listed(points),
        unit => match options.scalar {
            Scalar::Fixed32 => format!("m / 2^{name}_R_FRACTION_BITS"),
            _ => "m".to_string(),
        },
        model_source => model.file.as_ref().map(|file| header::printable(&file.source())),
        selftest_weights => selftest::weights(&selftest),
        has_names => !joints.is_empty(),
        joints,
        arrays => listed(arrays),
        functions => listed(functions),
        quarter => tables::quarter(options.scalar),
        from_ticks => Value::from(Serde(from_ticks)),
        selftest => listed(selftest),
        selftest_results => listed(results),
    };
    let texts = context! { ..helpers(&needs, options.scalar), ..texts };
    Ok(Package {
        header: render("package.h", &texts)?,
        source: render("package.c", &texts)?,
        notes,
    })
}

/// What the templates of static helpers read.
fn helpers(needs: &Needs, scalar: Scalar) -> Value {
    let (kernel, power, bits, suffix) = match scalar {
        Scalar::F64 => ("kernel_f64.c", "power_f64.c", "uint64_t", ""),
        Scalar::F32 => ("kernel_f32.c", "power_f32.c", "uint32_t", "f"),
        Scalar::Fixed32 => ("kernel_fixed.c", "", "", ""),
    };
    context! {
        has_kernel => needs.kernel,
        has_table => needs.table,
        has_narrow => needs.narrow,
        has_clamp => needs.clamp,
        has_power => needs.power,
        kernel,
        power,
        bits,
        suffix,
    }
}

/// A template of this crate, filled in.
fn render(template: &str, texts: &Value) -> Result<String, Error> {
    environment()
        .get_template(template)
        .and_then(|template| template.render(texts))
        .map(|text| text + "\n")
        .map_err(|error| Error::Emitted {
            reason: format!("{error:#}"),
        })
}

/// A list as a template reads it.
fn listed<T: Serialize + Send + Sync + 'static>(list: Vec<T>) -> Value {
    list.into_iter()
        .map(|item| Value::from(Serde(item)))
        .collect()
}

fn environment() -> Environment<'static> {
    let mut environment = Environment::new();
    for (name, text) in [
        ("package.h", include_str!("templates/package.h")),
        ("package.c", include_str!("templates/package.c")),
        ("includes.c", include_str!("templates/includes.c")),
        ("helpers.c", include_str!("templates/helpers.c")),
        ("narrow.c", include_str!("templates/narrow.c")),
        ("table.c", include_str!("templates/table.c")),
        ("kernel_f64.c", include_str!("templates/kernel_f64.c")),
        ("kernel_f32.c", include_str!("templates/kernel_f32.c")),
        ("kernel_fixed.c", include_str!("templates/kernel_fixed.c")),
        ("bits.c", include_str!("templates/bits.c")),
        ("clamp.c", include_str!("templates/clamp.c")),
        ("power_f64.c", include_str!("templates/power_f64.c")),
        ("power_f32.c", include_str!("templates/power_f32.c")),
        ("selftest.c", include_str!("templates/selftest.c")),
        ("free.h", include_str!("templates/free.h")),
        ("free.c", include_str!("templates/free.c")),
    ] {
        environment
            .add_template(name, text)
            .expect("the templates are part of this crate and parse");
    }
    environment
}

/// Static helpers that some function calls; an unused one would be a warning.
#[derive(Debug, Clone, Copy)]
struct Needs {
    kernel: bool,
    table: bool,
    narrow: bool,
    /// For effects alone.
    clamp: bool,
    power: bool,
}

impl Needs {
    fn of(
        functions: &[functions::Text],
        from_ticks: Option<&ticks::Text>,
        scalar: Scalar,
        name: &str,
    ) -> Needs {
        let ticks = from_ticks.iter().flat_map(|text| &text.lines);
        let bodies = functions.iter().flat_map(|text| &text.body);
        Needs::of_lines(bodies.chain(ticks), scalar, name)
    }

    fn of_lines<'l>(
        lines: impl Iterator<Item = &'l String> + Clone,
        scalar: Scalar,
        name: &str,
    ) -> Needs {
        let calls = |helper: &str| {
            let call = format!("{name}_{helper}(");
            lines.clone().any(|line| line.contains(&call))
        };
        let kernel = calls("sincos");
        let fixed = scalar == Scalar::Fixed32;
        Needs {
            kernel,
            table: calls("lookup") || (fixed && kernel),
            narrow: fixed && (kernel || calls("narrow")),
            clamp: calls("clamp"),
            power: calls("power"),
        }
    }
}

/// The comment at the top of both files.
fn about(model: &Model, routines: &[Routine], scalar: Scalar) -> Vec<String> {
    let mut lines = header::about(model);
    lines.push(format!(
        "scalar         {}",
        match scalar {
            Scalar::F64 => "f64 (double)",
            Scalar::F32 => "f32 (float); double is never touched",
            Scalar::Fixed32 => "fixed32 (int32_t, binary points proven from ranges; no division)",
        }
    ));
    lines.push(String::new());
    lines.push(format!(
        "{:<22} {:>7} {:>7} {:>9}   proven |rounding error|, m",
        "function", "mul", "add", "sin_cos"
    ));
    for routine in routines {
        let counts = routine.program.counts();
        lines.push(format!(
            "{:<22} {:>7} {:>7} {:>9}   {}{}",
            routine.name(),
            counts.mul,
            counts.add,
            counts.sin_cos,
            header::bound(routine.bound),
            header::others(counts)
        ));
    }
    lines.extend(header::PROMISE.map(str::to_string));
    let proven = routines.iter().all(|routine| routine.bound.is_finite());
    lines.extend(header::cautions(model, proven));
    if routines.iter().any(Routine::is_of_ticks) {
        lines.push(
            "Functions of ticks: against the angles and positions that the ticks stand for.".into(),
        );
    }
    lines
        .iter()
        .map(|line| header::printable(line).trim_end().to_string())
        .collect()
}

/// Name of an input array in C; `sin` and `cos` belong to the library.
fn argument(argument: Argument) -> &'static str {
    match argument {
        Argument::Sines => "sin_q",
        Argument::Cosines => "cos_q",
        other => other.name(),
    }
}

/// Names of a sine and a cosine; the one nobody reads needs a place all the same.
fn pair(listing: &Listing, sin: Option<Id>, cos: Option<Id>) -> [String; 2] {
    let name = |id: Option<Id>| id.and_then(|id| listing.name(id)).map(str::to_string);
    match (name(sin), name(cos)) {
        (Some(s), Some(c)) => [s, c],
        (Some(s), None) => [s.clone(), format!("no_c{}", s.trim_start_matches('s'))],
        (None, Some(c)) => [format!("no_s{}", c.trim_start_matches('c')), c],
        (None, None) => ["no_s".to_string(), "no_c".to_string()],
    }
}

/// A C string literal: printable ASCII as it is, everything else by octal escapes.
fn quoted(text: &str) -> String {
    let mut literal = String::from("\"");
    for byte in text.bytes() {
        match byte {
            b'"' | b'\\' => {
                literal.push('\\');
                literal.push(char::from(byte));
            }
            // `??` would begin a trigraph.
            b' '..=b'~' if byte != b'?' => literal.push(char::from(byte)),
            _ => literal.push_str(&format!("\\{byte:03o}")),
        }
    }
    literal.push('"');
    literal
}

/// A value of the scalar, with `bits` fraction bits where it is fixed point.
fn number(x: f64, scalar: Scalar, bits: i32) -> String {
    match scalar {
        Scalar::Fixed32 => fixed::literal(x, bits),
        _ => float::literal(x, scalar),
    }
}

/// An array definition.
#[derive(Debug, Clone, Serialize)]
struct Array {
    declaration: String,
    values: Vec<String>,
}
