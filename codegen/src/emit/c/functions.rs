//! The public functions: their programs, bounds, documentation and bodies.

use serde::Serialize;

use super::ticks::Ticks;
use super::{Scalar, fixed, float};
use crate::Error;
use crate::emit::header;
use sesc_model::bounds::{Formats, Overflow, Unfit};
use sesc_model::expr::Argument;
use sesc_model::program::{Program, Shape};
use sesc_model::{Function, Given, Model};

/// What a function takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Input {
    Program,
    /// Servo ticks, turned into what the program takes.
    Ticks,
}

/// A function to write.
#[derive(Debug, Clone)]
pub(super) struct Routine {
    pub(super) function: Function,
    pub(super) given: Given,
    pub(super) input: Input,
    /// Whether parameters are constants.
    pub(super) baked: bool,
    pub(super) program: Program,
    pub(super) formats: Option<Formats>,
    /// Proven bound on the rounding error, m.
    pub(super) bound: f64,
}

impl Routine {
    /// Its name behind the prefix.
    pub(super) fn name(&self) -> String {
        let suffix = match (self.input, self.given) {
            (Input::Ticks, _) => "_ticks",
            (_, Given::SinesCosines) => "_sc",
            (_, Given::Direction) => "_along",
            (_, Given::Positions) => "",
        };
        format!("{}{suffix}", self.stem())
    }

    fn stem(&self) -> String {
        let model = if self.baked { "model_" } else { "" };
        format!("{model}{}", self.function.name())
    }

    pub(super) fn is_of_ticks(&self) -> bool {
        self.input == Input::Ticks
    }

    pub(super) fn takes_parameters(&self) -> bool {
        self.function.takes_parameters() && !self.baked
    }
}

/// Every function that can be had, in the order of the header.
pub(super) fn routines(
    model: &Model,
    scalar: Scalar,
    ticks: Option<&Ticks>,
) -> Result<Vec<Routine>, Error> {
    let mut routines = Vec::new();
    let baked: &[bool] = match &model.file {
        Some(_) => &[false, true],
        None => &[false],
    };
    for &baked in baked {
        for given in [Given::Positions, Given::SinesCosines] {
            for function in Function::ALL {
                let program = match baked {
                    false => model.program(function, given),
                    true if matches!(function, Function::Com | Function::Cop) => {
                        model.baked_program(function, given)
                    }
                    true => None,
                };
                let Some(program) = program.filter(|program| !program.shape.is_empty()) else {
                    continue;
                };
                routines.push(routine(model, scalar, function, given, baked, program)?);
            }
        }
        if let Some(ticks) = ticks {
            let of_ticks: Vec<Routine> = routines
                .iter()
                .filter(|r| r.baked == baked && r.given == ticks.given && !r.is_of_ticks())
                .map(|r| Routine {
                    input: Input::Ticks,
                    ..r.clone()
                })
                .collect();
            routines.extend(of_ticks);
        }
    }
    if let Some(program) = model.program(Function::CorrectCop, Given::Positions) {
        let given = Given::Positions;
        routines.push(routine(
            model,
            scalar,
            Function::CorrectCop,
            given,
            false,
            program,
        )?);
    }
    share_formats(&mut routines);
    for routine in &mut routines {
        routine.bound = match (routine.input, ticks, &routine.formats, scalar.precision()) {
            (Input::Ticks, Some(ticks), ..) => ticks.bound(model, routine),
            (_, _, Some(formats), _) => model.rounding_fixed(&routine.program, formats).worst,
            (_, _, None, Some(precision)) => model.rounding(&routine.program, precision).worst,
            (_, _, None, None) => unreachable!("fixed point comes with formats"),
        };
        // An iteration has no proven bound; its header says so.
        if !routine.bound.is_finite() && routine.function != Function::CorrectCop {
            return Err(match routine.program.counts().other {
                0 => Error::Unbounded {
                    function: routine.name(),
                },
                _ => Error::UnboundedEffect {
                    function: routine.name(),
                },
            });
        }
    }
    Ok(routines)
}

fn routine(
    model: &Model,
    scalar: Scalar,
    function: Function,
    given: Given,
    baked: bool,
    program: Program,
) -> Result<Routine, Error> {
    let formats = match scalar {
        Scalar::Fixed32 => {
            let formats = model.fixed_point(&program);
            Some(formats.map_err(|unfit| no_fixed_point(model, function, &unfit))?)
        }
        _ => None,
    };
    Ok(Routine {
        function,
        given,
        input: Input::Program,
        baked,
        program,
        formats,
        bound: f64::INFINITY,
    })
}

fn no_fixed_point(model: &Model, function: Function, unfit: &Unfit) -> Error {
    match unfit {
        Unfit::Overflow(overflow) => too_large(model, function, overflow),
        Unfit::Operation => Error::NoFixedPoint {
            function: function.name(),
        },
    }
}

fn too_large(model: &Model, function: Function, overflow: &Overflow) -> Error {
    let what = match overflow.angle {
        true => "an angle needs 16 bits below its point",
        false => "32 bits do not hold it",
    };
    let quantity = match overflow.quantity.strip_prefix("q[") {
        Some(index) => {
            let index: usize = index.trim_end_matches(']').parse().unwrap_or(0);
            let joint = model
                .tree
                .dofs
                .get(index)
                .map_or("", |dof| dof.joint.as_str());
            format!("the position of joint `{joint}`")
        }
        None => format!("{} of {}", overflow.quantity, function.name()),
    };
    Error::Overflow {
        reason: format!(
            "{quantity} may reach {:.3e}; {what} (the robot reaches {:.3e} m)",
            overflow.size,
            model.reach()
        ),
    }
}

/// Variants of one function share the binary point of its results.
fn share_formats(routines: &mut [Routine]) {
    for function in Function::ALL {
        let of = |r: &&Routine| r.function == function;
        let outputs = routines
            .iter()
            .filter(of)
            .filter_map(|r| r.formats.as_ref());
        let Some(coarsest) = outputs.map(|formats| formats.output).min() else {
            continue;
        };
        for routine in routines.iter_mut().filter(|r| r.function == function) {
            if let Some(formats) = &mut routine.formats {
                formats.share_output(coarsest);
            }
        }
    }
}

/// A macro that tells a binary point.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Point {
    name: String,
    of: String,
    bits: i32,
}

/// Binary points of inputs and results, each once.
pub(super) fn points(routines: &[Routine]) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    let mut push = |name: String, of: String, bits: i32| {
        if points.iter().all(|point| point.name != name) {
            points.push(Point { name, of, bits });
        }
    };
    for routine in routines {
        let Some(formats) = &routine.formats else {
            continue;
        };
        for (array, bits) in routine.program.inputs.iter().zip(&formats.arrays) {
            let (name, of) = match array.argument {
                Argument::Reading => ("READING", "readings of the CoP, m or the record's unit"),
                Argument::Positions => ("Q", "joint positions, rad or m"),
                Argument::Parameters => ("R", "parameters, m"),
                _ => (
                    "SC",
                    "sines and cosines (and of what slides pass in sin_q, m)",
                ),
            };
            push(name.to_string(), of.to_string(), *bits);
        }
        let name = routine.function.name();
        push(
            name.to_uppercase(),
            format!("the results of {name}"),
            formats.output,
        );
    }
    points
}

/// What a template needs of a function.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Text {
    pub(super) name: String,
    brief: String,
    details: Vec<String>,
    parameters: Vec<Parameter>,
    signature: String,
    pub(super) body: Vec<String>,
}

#[derive(Debug, Clone, Serialize)]
struct Parameter {
    direction: &'static str,
    name: String,
    meaning: String,
    #[serde(skip)]
    declaration: String,
}

pub(super) fn text(model: &Model, routine: &Routine, scalar: Scalar, name: &str) -> Text {
    let output = output(routine.function);
    let body = match (routine.input, &routine.formats) {
        (Input::Ticks, _) => ticks_body(routine, name),
        (_, Some(formats)) => fixed::body(&routine.program, formats, name, output),
        (_, None) => float::body(&routine.program, scalar, name, output),
    };
    let parameters = parameters(routine, name);
    let declarations: Vec<&str> = parameters.iter().map(|p| p.declaration.as_str()).collect();
    let mut details = Vec::new();
    if routine.baked
        && let Some(file) = &model.file
    {
        details.push(format!(
            "Parameters of the model file are constants here (source: {}).",
            header::printable(&file.source())
        ));
    }
    if routine.given == Given::SinesCosines && !routine.is_of_ticks() {
        details
            .push("From sines and cosines; a sliding joint passes its position in sin_q.".into());
    }
    details.push(match routine.bound.is_finite() {
        true => format!(
            "Proven rounding error below {} m; arrays must not overlap.",
            header::at_most(routine.bound)
        ),
        false => "Newton's method, unrolled: no rounding bound is proven; arrays must not overlap."
            .to_string(),
    });
    Text {
        name: routine.name(),
        brief: brief(model, routine.function).to_string(),
        details,
        signature: signature(&declarations, routine.name().len() + name.len()),
        parameters,
        body,
    }
}

/// Parameters in a row, or one a line where the row would be long.
fn signature(declarations: &[&str], before: usize) -> String {
    let row = declarations.join(", ");
    match before + row.len() < 92 {
        true => row,
        false => format!("\n    {}", declarations.join(",\n    ")),
    }
}

fn output(function: Function) -> &'static str {
    match function {
        Function::Com => "com",
        Function::Cop | Function::CorrectCop => "cop",
        Function::ComJacobian => "jac",
        Function::GravityMoments => "moments",
        Function::Regressor | Function::RegressorCop | Function::RegressorFull => "rows",
    }
}

fn brief(model: &Model, function: Function) -> &'static str {
    match function {
        Function::Cop if model.static_effects().next().is_some() => {
            "Reading of the CoP that a static posture foretells, with the effects named above, m."
        }
        Function::CorrectCop => {
            "CoP that a reading was made of, m: the effects of the sensor taken back."
        }
        Function::Com => "Centre of mass in the support frame, m: r_0 + sum of B_i(q) r_i.",
        Function::ComJacobian => "d CoM / d q, m/rad (m/m for sliding joints), row-major: x, y, z.",
        Function::GravityMoments => {
            "Moment of gravity about each joint, per kg of total mass times g, m: -d CoM_z / d q."
        }
        Function::Regressor => "Rows of the base regressor, row-major: CoM = rows r.",
        Function::RegressorCop => {
            "The x and y rows of the base regressor, row-major: CoP = rows r."
        }
        Function::RegressorFull => {
            "Rows [B_0 B_1 ...] of the full regressor in link frames, row-major."
        }
        Function::Cop => "Centre of pressure that a static posture shows on a level sole, m.",
    }
}

/// How the result's length is written.
fn length(routine: &Routine, name: &str) -> String {
    let columns = match routine.function {
        Function::Com => return "3".to_string(),
        Function::Cop | Function::CorrectCop => return "2".to_string(),
        Function::GravityMoments => return format!("{name}_DOF"),
        Function::ComJacobian => format!("{name}_DOF"),
        Function::RegressorFull => format!("{name}_FULL_PARAMS"),
        Function::Regressor | Function::RegressorCop => format!("{name}_BASE_PARAMS"),
    };
    match routine.program.shape {
        Shape::Matrix { rows, .. } => format!("{rows} * {columns}"),
        Shape::Vector(_) => columns,
    }
}

fn parameters(routine: &Routine, name: &str) -> Vec<Parameter> {
    let real = format!("{name}_real");
    let input = |array: &str, scalar: &str, meaning: String| Parameter {
        direction: "in",
        name: array.to_string(),
        meaning,
        declaration: format!("const {scalar} {array}[]"),
    };
    let mut parameters = match (routine.input, routine.given) {
        _ if routine.function == Function::CorrectCop => vec![Parameter {
            direction: "in",
            name: "reading".to_string(),
            meaning: "what the sensor says, in the unit of cop, [2]".to_string(),
            declaration: format!("const {real} reading[2]"),
        }],
        (Input::Ticks, _) => vec![input(
            "ticks",
            "int32_t",
            format!("servo ticks, [{name}_DOF], within the joint limits"),
        )],
        (_, Given::Positions) => vec![input(
            "q",
            &real,
            format!("joint positions, rad (m for sliding joints), [{name}_DOF]"),
        )],
        (_, Given::SinesCosines | Given::Direction) => vec![
            input(
                "sin_q",
                &real,
                format!("sines of the joint angles, [{name}_DOF]"),
            ),
            input(
                "cos_q",
                &real,
                format!("cosines of the joint angles, [{name}_DOF]"),
            ),
        ],
    };
    if routine.takes_parameters() {
        parameters.push(input(
            "r",
            &real,
            format!("base parameters, m, [{name}_BASE_PARAMS]"),
        ));
    }
    let array = output(routine.function);
    let length = length(routine, name);
    parameters.push(Parameter {
        direction: "out",
        name: array.to_string(),
        meaning: format!("the result, [{length}]"),
        declaration: format!("{real} {array}[{length}]"),
    });
    parameters
}

/// Ticks to sines and cosines (or positions), then the function of those.
fn ticks_body(routine: &Routine, name: &str) -> Vec<String> {
    let arrays: &[&str] = match routine.given {
        Given::Positions => &["q"],
        Given::SinesCosines | Given::Direction => &["sin_q", "cos_q"],
    };
    let mut lines: Vec<String> = arrays
        .iter()
        .map(|array| format!("{name}_real {array}[{name}_DOF];"))
        .collect();
    let arrays = arrays.join(", ");
    lines.push(format!("{name}_from_ticks(ticks, {arrays});"));
    let target = Routine {
        input: Input::Program,
        ..routine.clone()
    };
    let r = if routine.takes_parameters() {
        "r, "
    } else {
        ""
    };
    let output = output(routine.function);
    lines.push(format!("{name}_{}({arrays}, {r}{output});", target.name()));
    lines
}

#[cfg(test)]
mod tests;
