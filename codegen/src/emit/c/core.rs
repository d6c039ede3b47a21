//! Bodies that stand once, in floating point.
//!
//! ```text
//! com(q, r, com) = com_core(0, q, q, q, r, com)
//! com_sc(sin_q, cos_q, r, com) = com_core(1, sin_q, sin_q, cos_q, r, com)
//! ```
//!
//! Compilers make the body a part of both functions, where what comes from sines is known: each
//! costs what it does with a body of its own. In fixed point both round elsewhere (a sum is cut
//! where it is long), and bodies of their own keep their bits.

use serde::Serialize;

use super::exported::{Exported, Input};
use super::float::{self, Core, Turned};
use super::{Scalar, spelled};
use crate::emit::c::helpers::Calls;
use crate::emit::listing::{Line, Listing, Results};
use crate::emit::shared::{Shared, values};
use sesc_model::Given;
use sesc_model::expr::{Argument, Id};
use sesc_model::program::Program;

/// Text of a body.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Text {
    parameters: String,
    body: Vec<String>,
}

/// The body that `routine` shares with its counterpart, if it does.
pub(super) fn of(
    routine: &Exported,
    all: &[Exported],
    scalar: Scalar,
    calls: &Calls,
) -> Option<Core> {
    let find = |given| {
        let mut all = all.iter();
        all.find(|other| {
            other.input == Input::Program
                && other.given == given
                && (other.function, other.baked) == (routine.function, routine.baked)
        })
    };
    if scalar == Scalar::Fixed32 || routine.input != Input::Program {
        return None;
    }
    let (positions, sines) = (find(Given::Positions)?, find(Given::SinesCosines)?);
    let shared = Shared::new(routine.function, &positions.program, &sines.program)?;
    let spell = |program: &Program, id: Id| value(program, id, scalar, calls);
    let turned = shared.angles.iter().map(|angle| {
        let Some(pair) = angle.turned else {
            return Some(None);
        };
        let own = [Argument::Sines, Argument::Cosines]
            .map(|array| format!("{}[{}]", spelled(array), angle.joint));
        let [sine, cosine] = [0, 1].map(|k| match pair[k] {
            Some(id) => spell(&sines.program, id),
            // Not needed.
            None => Some(own[k].clone()),
        });
        Some(Some(Turned {
            angle: spell(&positions.program, angle.id)?,
            sine_and_cosine: [sine?, cosine?],
        }))
    });
    let turned = turned.collect::<Option<Vec<_>>>()?;
    Some(Core { shared, turned })
}

/// A value as one expression, unless it takes statements.
fn value(program: &Program, id: Id, scalar: Scalar, calls: &Calls) -> Option<String> {
    let mut program = values(program, &[id]);
    program.nodes[id.index()].name = None;
    let listing = Listing::new(&program, Results::AtTheEnd);
    let takes_statements = |line: &Line| !matches!(line, Line::Result(_));
    if listing.lines.iter().any(takes_statements) {
        return None;
    }
    Some(float::value(&listing, scalar, calls, id))
}

/// The arguments besides angles, and the result.
fn others(routine: &Exported) -> Vec<&'static str> {
    let mut arguments = routine.arguments();
    let of_angles = [Argument::Positions, Argument::Sines, Argument::Cosines];
    arguments.retain(|argument| !of_angles.contains(argument));
    let names = arguments.into_iter().map(spelled);
    names.chain([routine.output()]).collect()
}

impl Core {
    /// The body; `others` are the parameters besides angles.
    pub(super) fn text(
        &self,
        routine: &Exported,
        others: &[String],
        scalar: Scalar,
        name: &str,
        calls: &Calls,
    ) -> Text {
        let angles = [Argument::Positions, Argument::Sines, Argument::Cosines];
        let angles = angles.map(|array| format!("const {name}_real {}[]", spelled(array)));
        let parameters = ["int of_sines".to_string()].into_iter().chain(angles);
        let parameters: Vec<String> = parameters.chain(others.iter().cloned()).collect();
        Text {
            parameters: format!("\n    {}", parameters.join(",\n    ")),
            body: float::body(
                &self.shared.core,
                Some(self),
                scalar,
                calls,
                routine.output(),
            ),
        }
    }
}

/// The call of the body.
pub(super) fn call(routine: &Exported, name: &str) -> Vec<String> {
    let angles = match routine.given {
        Given::Positions => "0, q, q, q",
        Given::SinesCosines | Given::Direction => "1, sin_q, sin_q, cos_q",
    };
    let of = if routine.baked { "model_" } else { "" };
    let function = routine.function.name();
    let others = others(routine).join(", ");
    vec![format!("{name}_{of}{function}_core({angles}, {others});")]
}
