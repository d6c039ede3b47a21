//! The public functions as text: documentation, parameters and bodies.

use crate::emit::header::printable;
use serde::Serialize;

use super::exported::{Exported, Input};
use super::helpers::Calls;
use super::lanes::{self, Block};
use super::{Scalar, fixed, float};
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
    /// Of many postures: those of one register.
    block: Option<Block>,
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
    scalar: Scalar,
    name: &str,
    calls: &Calls,
) -> Text {
    let output = routine.output();
    let block = (routine.is_batch()).then(|| lanes::block(routine, scalar, name, calls));
    let body = match (routine.input, &routine.formats) {
        (Input::Ticks, _) => ticks_body(routine, name),
        (Input::Batch, _) => lanes::body(routine, name, calls),
        (_, Some(formats)) => fixed::body(&routine.program, formats, calls, output),
        (_, None) => float::body(&routine.program, scalar, calls, output),
    };
    let parameters = parameters(routine, name);
    let before = routine.name().len() + name.len();
    let signature = |parameter: fn(&Parameter) -> String| {
        let declarations: Vec<String> = parameters.iter().map(parameter).collect();
        signature(&declarations, before)
    };
    Text {
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
    details.push(match (routine.bound.is_finite(), routine.function) {
        (true, _) => format!(
            "Proven rounding error below {}; arrays must not overlap.",
            header::bound_of(routine.function, routine.bound)
        ),
        (false, Function::Zmp) => {
            "No rounding bound is proven for this robot; arrays must not overlap.".to_string()
        }
        (false, _) => {
            "Newton's method, unrolled: no rounding bound is proven; arrays must not overlap."
                .to_string()
        }
    });
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

/// How the result's length is written.
fn length(routine: &Exported, name: &str) -> String {
    let columns = match routine.function.columns() {
        Extent::Fixed(n) => n.to_string(),
        Extent::Dof => format!("{name}_DOF"),
        Extent::BaseParams => format!("{name}_BASE_PARAMS"),
        Extent::FullParams => format!("{name}_FULL_PARAMS"),
    };
    match routine.program.shape {
        Shape::Matrix { rows, .. } => format!("{rows} * {columns}"),
        Shape::Vector(_) => columns,
    }
}

fn parameters(routine: &Exported, name: &str) -> Vec<Parameter> {
    let real = format!("{name}_real");
    let input = |array: &str, scalar: &str, meaning: String| Parameter {
        direction: "in",
        name: array.to_string(),
        meaning,
        scalar: format!("const {scalar}"),
        length: Some(String::new()),
    };
    let mut parameters = match (routine.input, routine.given) {
        _ if routine.function == Function::CorrectCop => vec![Parameter {
            length: Some("2".to_string()),
            ..input(
                "reading",
                &real,
                "sensor reading, in the unit of cop, [2]".to_string(),
            )
        }],
        (Input::Ticks, _) => vec![input(
            "ticks",
            "int32_t",
            format!("servo ticks, [{name}_DOF], within the joint limits"),
        )],
        (_, Given::Positions) => vec![input(
            "q",
            &real,
            format!("joint positions, rad (m for prismatic joints), [{name}_DOF]"),
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
    let moves = |argument| {
        routine
            .function
            .arguments(routine.given)
            .contains(&argument)
    };
    if moves(Argument::Velocities) {
        let meaning = format!("joint velocities, rad/s (m/s), [{name}_DOF]");
        parameters.push(input("qd", &real, meaning));
    }
    if moves(Argument::Accelerations) {
        let meaning = format!("joint accelerations, rad/s2 (m/s2), [{name}_DOF]");
        parameters.push(input("qdd", &real, meaning));
    }
    if routine.takes_parameters() {
        let meaning = format!("base parameters, m, [{name}_BASE_PARAMS]");
        parameters.push(input("r", &real, meaning));
    }
    let length = length(routine, name);
    parameters.push(Parameter {
        direction: "out",
        name: routine.output().to_string(),
        meaning: format!("the result, [{length}]"),
        scalar: real,
        length: Some(length),
    });
    match routine.is_batch() {
        true => of_many(parameters),
        false => parameters,
    }
}

/// The parameters of a function of n postures; r is one for all.
fn of_many(one: Vec<Parameter>) -> Vec<Parameter> {
    let mut parameters = vec![Parameter {
        direction: "in",
        name: "n".to_string(),
        meaning: "number of postures, 0 as well".to_string(),
        scalar: "size_t".to_string(),
        length: None,
    }];
    parameters.extend(one.into_iter().map(|parameter| {
        let Some((meaning, length)) = parameter.meaning.rsplit_once(", [") else {
            return parameter;
        };
        if parameter.name == "r" {
            return parameter;
        }
        let length = length.trim_end_matches(']');
        Parameter {
            meaning: format!("{meaning}, [{length} * n]"),
            length: Some(String::new()),
            ..parameter
        }
    }));
    parameters
}

/// Ticks to sines and cosines (or positions), then the function of those.
fn ticks_body(routine: &Exported, name: &str) -> Vec<String> {
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
    let target = Exported {
        input: Input::Program,
        ..routine.clone()
    };
    let r = match (routine.function, routine.takes_parameters()) {
        (Function::ComVelocity, _) => "qd, r, ",
        (Function::Zmp, _) => "qd, qdd, r, ",
        (_, true) => "r, ",
        (_, false) => "",
    };
    let output = routine.output();
    lines.push(format!("{name}_{}({arrays}, {r}{output});", target.name()));
    lines
}
