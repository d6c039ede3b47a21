//! The public functions as text: documentation, parameters and bodies.

use crate::emit::header::printable;
use serde::Serialize;

use super::exported::{Exported, Input};
use super::helpers::Calls;
use super::lanes::{self, Block};
use super::{Scalar, core, fixed, float, spelled};
use crate::emit::header;
use crate::facts::Facts;
use sesc_model::expr::Argument;
use sesc_model::program::Shape;
use sesc_model::{Extent, Function, Given};

/// What a template needs of a function.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Text {
    name: String,
    brief: &'static str,
    details: Vec<String>,
    parameters: Vec<Parameter>,
    /// Parameters as the header declares them, and as the source defines them.
    declaration: String,
    definition: String,
    body: Vec<String>,
    /// The body that it shares with its counterpart of sines and cosines, before the first.
    core: Option<core::Text>,
    /// For functions of many postures: the function of one register's postures.
    block: Option<Block>,
}

impl Text {
    /// Whether the body is another's, too.
    pub(super) fn is_shared(&self) -> bool {
        self.core.is_some()
    }
}

#[derive(Debug, Clone, Serialize)]
struct Parameter {
    direction: &'static str,
    name: String,
    meaning: String,
    /// With the element type in front.
    #[serde(skip)]
    scalar: String,
    /// What stands between the brackets; none where it is one number.
    #[serde(skip)]
    length: Option<String>,
}

impl Parameter {
    fn input(name: &str, meaning: String, scalar: String, length: Option<String>) -> Parameter {
        Parameter {
            direction: "in",
            name: name.to_string(),
            meaning,
            scalar,
            length,
        }
    }

    fn declared(&self) -> String {
        match &self.length {
            Some(length) => format!("{} {}[{length}]", self.scalar, self.name),
            None => format!("{} {}", self.scalar, self.name),
        }
    }

    /// A result overlaps no argument: that is what the header asks of callers.
    fn defined(&self) -> String {
        match (self.direction, &self.length) {
            ("out", Some(length)) => {
                let brackets = format!("restrict {length}");
                format!("{} {}[{}]", self.scalar, self.name, brackets.trim_end())
            }
            _ => self.declared(),
        }
    }
}

pub(super) fn text(
    facts: &Facts,
    routine: &Exported,
    all: &[Exported],
    scalar: Scalar,
    name: &str,
    calls: &Calls,
) -> Text {
    let output = routine.output();
    let core = core::of(routine, all, scalar, calls);
    let block = (routine.is_batch()).then(|| lanes::block(routine, scalar, name, calls));
    let body = match (routine.input, &routine.formats) {
        _ if core.is_some() => core::call(routine, name),
        (Input::Ticks, _) => ticks_body(routine, name),
        // Around the block, in its template.
        (Input::Batch, _) => Vec::new(),
        (_, Some(formats)) => fixed::body(&routine.program, formats, calls, output),
        (_, None) => float::body(&routine.program, None, scalar, calls, output),
    };
    let parameters = parameters(routine, name);
    let before = routine.name().len() + name.len();
    let signature = |parameter: fn(&Parameter) -> String| {
        let declarations: Vec<String> = parameters.iter().map(parameter).collect();
        signature(&declarations, before)
    };
    let core = core
        .filter(|_| routine.given == Given::Positions)
        .map(|core| {
            // Joint positions come first.
            let others: Vec<String> = parameters[1..].iter().map(Parameter::defined).collect();
            core.text(routine, &others, scalar, name, calls)
        });
    Text {
        core,
        name: routine.name(),
        brief: routine.function.sentences(facts.has_static_effects())[1],
        details: details(facts, routine),
        declaration: signature(Parameter::declared),
        definition: signature(Parameter::defined),
        parameters,
        body,
        block,
    }
}

fn details(facts: &Facts, routine: &Exported) -> Vec<String> {
    let mut details: Vec<String> = Vec::new();
    details.extend(facts.effects_sentence(routine.function).map(str::to_string));
    if routine.baked
        && let Some(identified) = &facts.identified
    {
        details.push(format!(
            "Parameters of the model file are constants here (source: {}).",
            printable(&identified.source)
        ));
        let of_reading = matches!(routine.function, Function::Cop | Function::CopJacobian);
        let (body, cop) = (facts.effects_in(true), facts.effects_in(false));
        let texts = match of_reading {
            true => [("Holds", [body, cop].concat()), ("", Vec::new())],
            false => [("Holds", body), ("Only model_cop holds", cop)],
        };
        for (what, effects) in texts {
            if !effects.is_empty() {
                let text = format!("{what}: {}.", printable(&effects.join(", ")));
                details.extend(header::wrapped(&text));
            }
        }
    }
    if routine.is_batch() {
        details.push(format!(
            "Of n postures: entry k of posture i is {}[k * n + i], and likewise in arguments.",
            routine.output()
        ));
    }
    if routine.given == Given::SinesCosines && !routine.is_of_ticks() {
        details
            .push("From sines and cosines; a prismatic joint passes its position in sin_q.".into());
    }
    let bound = match (routine.seen, routine.function) {
        (Some(seen), function) => format!(
            "No useful rounding bound is proven, {} is the largest error seen",
            header::bound_of(function, seen)
        ),
        (_, function) if routine.bound.is_finite() => format!(
            "Proven rounding error below {}",
            header::bound_of(function, routine.bound)
        ),
        (_, Function::Zmp | Function::CopJacobian) => {
            "No rounding bound is proven for this robot".to_string()
        }
        _ => "Newton's method, unrolled: no rounding bound is proven".to_string(),
    };
    details.push(bound + "; arrays must not overlap.");
    details
}

/// Parameters in a row, or one a line where the row would be long.
fn signature(declarations: &[String], before: usize) -> String {
    let row = declarations.join(", ");
    match before + row.len() < 92 {
        true => row,
        false => format!("\n    {}", declarations.join(",\n    ")),
    }
}

/// A length as C names it.
fn extent(extent: Extent, name: &str) -> String {
    match extent {
        Extent::Fixed(n) => n.to_string(),
        Extent::Dof => format!("{name}_DOF"),
        Extent::BaseParams => format!("{name}_BASE_PARAMS"),
        Extent::FullParams => format!("{name}_FULL_PARAMS"),
        Extent::Context => format!("{name}_CONTEXT"),
    }
}

/// How many entries the result of one posture has.
fn entries(routine: &Exported, name: &str) -> String {
    let columns = extent(routine.function.columns(), name);
    match routine.program.shape {
        Shape::Matrix { rows, .. } => format!("{rows} * {columns}"),
        Shape::Vector(_) => columns,
    }
}

/// What the header says of an argument.
fn meaning(argument: Argument) -> &'static str {
    match argument {
        Argument::Positions => "joint positions, rad (m for prismatic joints)",
        Argument::Sines => "sines of the joint angles",
        Argument::Cosines => "cosines of the joint angles",
        Argument::Velocities => "joint velocities, rad/s (m/s)",
        Argument::Accelerations => "joint accelerations, rad/s2 (m/s2)",
        Argument::Parameters => "base parameters, m",
        Argument::Direction => "a direction of the support frame, no longer than 1",
        Argument::Reading => "sensor reading, in the unit of cop",
        Argument::Context => "what effects depend on beside q, in the order of context_names",
        // Unknowns are inputs of fits, in Rust alone.
        _ => "an input of fits",
    }
}

/// An input of a function. Of many postures all but the base parameters have n times as
/// many entries.
fn input(routine: &Exported, argument: Argument, name: &str) -> Parameter {
    let entries = extent(Extent::of(argument), name);
    let many = match routine.is_batch() && argument != Argument::Parameters {
        true => " * n",
        false => "",
    };
    let meaning = format!("{}, [{entries}{many}]", meaning(argument));
    let length = match argument {
        Argument::Reading if !routine.is_batch() => entries,
        _ => String::new(),
    };
    let scalar = format!("const {name}_real");
    Parameter::input(spelled(argument), meaning, scalar, Some(length))
}

fn parameters(routine: &Exported, name: &str) -> Vec<Parameter> {
    let mut parameters = Vec::new();
    if routine.is_batch() {
        let meaning = "number of postures, 0 as well".to_string();
        parameters.push(Parameter::input("n", meaning, "size_t".to_string(), None));
    }
    let mut arguments = routine.arguments();
    if routine.is_of_ticks() {
        arguments.retain(|argument| !angles(*argument));
        let meaning = format!("servo ticks, [{name}_DOF], within the joint limits");
        let scalar = "const int32_t".to_string();
        parameters.push(Parameter::input(
            "ticks",
            meaning,
            scalar,
            Some(String::new()),
        ));
    }
    let inputs = arguments.into_iter();
    parameters.extend(inputs.map(|argument| input(routine, argument, name)));
    let entries = entries(routine, name);
    let (meaning, length) = match routine.is_batch() {
        true => (format!("the result, [{entries} * n]"), String::new()),
        false => (format!("the result, [{entries}]"), entries),
    };
    let output = routine.output();
    parameters.push(Parameter {
        direction: "out",
        ..Parameter::input(output, meaning, format!("{name}_real"), Some(length))
    });
    parameters
}

/// Whether an argument is what servo ticks are turned into.
fn angles(argument: Argument) -> bool {
    matches!(
        argument,
        Argument::Positions | Argument::Sines | Argument::Cosines
    )
}

/// Ticks to sines and cosines (or positions), then the function of those.
fn ticks_body(routine: &Exported, name: &str) -> Vec<String> {
    let (arrays, others): (Vec<Argument>, Vec<Argument>) =
        routine.arguments().into_iter().partition(|it| angles(*it));
    let names = |arguments: &[Argument]| arguments.iter().map(|it| spelled(*it)).collect();
    let (arrays, mut passed): (Vec<&str>, Vec<&str>) = (names(&arrays), names(&others));
    let mut lines: Vec<String> = arrays
        .iter()
        .map(|array| format!("{name}_real {array}[{name}_DOF];"))
        .collect();
    let arrays = arrays.join(", ");
    lines.push(format!("{name}_from_ticks(ticks, {arrays});"));
    let target = Exported {
        input: Input::Program,
        ..routine.clone()
    };
    passed.push(routine.output());
    let passed = passed.join(", ");
    lines.push(format!("{name}_{}({arrays}, {passed});", target.name()));
    lines
}
