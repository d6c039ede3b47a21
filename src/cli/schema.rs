//! JSON schemas of what commands print with `--json`.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use sesc_identify::diagnose::Diagnosis;
use sesc_identify::plan::Plan;

use super::{Failure, compare, demo, effects, generate, inspect, predict, simulate, verify};
use crate::report::{fit, fleet};

/// What commands print.
pub struct Schemas {
    /// Command, in which case it prints this, and the schema; the first is that of errors.
    pub answers: Vec<(&'static str, &'static str, Schema)>,
    /// Types that the schemas refer to, by name.
    pub definitions: serde_json::Map<String, serde_json::Value>,
}

/// The schemas of all commands, in the order in which `sesc --help` lists these.
pub fn all() -> Schemas {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let mut generator = settings.into_generator();
    let all: [(_, _, fn(&mut SchemaGenerator) -> Schema); 15] = [
        ("errors", "", Failure::json_schema),
        ("demo", "", demo::Answer::json_schema),
        ("inspect", "", inspect::Answer::json_schema),
        ("plan", "", Plan::json_schema),
        ("simulate", "", simulate::Written::json_schema),
        ("fit", "", fit::FitReport::json_schema),
        (
            "fit",
            "Of data that cannot be used",
            fit::Unusable::json_schema,
        ),
        ("diagnose", "", Diagnosis::json_schema),
        ("effects", "", effects::Listed::json_schema),
        ("compare", "", compare::Answer::json_schema),
        ("predict", "", predict::Answer::json_schema),
        ("predict", "With `--out`", predict::Written::json_schema),
        ("generate", "", generate::Answer::json_schema),
        ("verify", "", verify::Answer::json_schema),
        ("fleet", "", fleet::Answer::json_schema),
    ];
    let all = all.map(|(command, when, of)| (command, when, of(&mut generator)));
    Schemas {
        answers: all.into(),
        definitions: generator.take_definitions(true),
    }
}
