//! JSON schemas of what commands print with `--json`.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use sesc_identify::compare::Comparison;
use sesc_identify::plan::Plan;
use sesc_identify::predict::Predictions;

use super::{Failure, demo, effects, generate, predict, simulate};
use crate::inspect::Inspection;
use crate::report::diagnose::DiagnoseReport;
use crate::report::next_steps::WithSteps;
use crate::report::{fit, fleet};
use crate::verify::Verification;

/// What commands print.
pub struct Schemas {
    /// Command, in which case it prints this, and the schema; the first is that of errors.
    pub answers: Vec<(&'static str, &'static str, Schema)>,
    /// Types that the schemas refer to, by name.
    pub definitions: serde_json::Map<String, serde_json::Value>,
}

/// Adds the schema of a type to those that are referred to.
type SchemaOf = fn(&mut SchemaGenerator) -> Schema;

/// The schemas of all commands, in the order in which `sesc --help` lists these.
pub fn all() -> Schemas {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let mut generator = settings.into_generator();
    let all: [(_, _, SchemaOf); 17] = [
        ("errors", "", Failure::json_schema),
        ("demo", "", demo::Answer::json_schema),
        ("inspect", "", WithSteps::<Inspection>::json_schema),
        ("plan", "", WithSteps::<Plan>::json_schema),
        ("simulate", "", simulate::Written::json_schema),
        ("fit", "", fit::FitReport::json_schema),
        (
            "fit",
            "Of data that cannot be used",
            fit::Unusable::json_schema,
        ),
        ("fit", "With `--partial`", super::fit::Gathered::json_schema),
        ("diagnose", "", DiagnoseReport::json_schema),
        ("effects", "", effects::Listed::json_schema),
        ("compare", "", WithSteps::<Comparison>::json_schema),
        (
            "compare",
            "Of a log that cannot be used",
            fit::Unusable::json_schema,
        ),
        ("predict", "", WithSteps::<Predictions>::json_schema),
        ("predict", "With `--out`", predict::Written::json_schema),
        ("generate", "", generate::Answer::json_schema),
        ("verify", "", WithSteps::<Verification>::json_schema),
        ("fleet", "", fleet::Answer::json_schema),
    ];
    let all = all.map(|(command, when, of)| (command, when, of(&mut generator)));
    Schemas {
        answers: all.into(),
        definitions: generator.take_definitions(true),
    }
}
