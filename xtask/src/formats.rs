//! Tables of docs/formats.md and docs/json.md, written from those that readers and commands use:
//! tables of columns and keys, and types with their documentation.

use std::path::{Path, PathBuf};

use sesc::Error;
use sesc::cli::robot_keys;
use sesc_identify::logs::{COLUMNS, Column, Need, SIDECAR_KEYS};
use sesc_identify::plan::limits;

use crate::keys::{Key, Keys, Place, TABLE};

/// The pages whose tables are written.
const FORMATS: &str = "docs/formats.md";
const JSON: &str = "docs/json.md";

/// Files of TOML: the table's name, and the type that reads it.
const FILES: [(&str, Place); 4] = [
    ("model file", ("model/src/model/file.rs", "ModelFile")),
    ("prior", ("identify/src/tolerances.rs", "Tolerances")),
    (
        "population",
        ("identify/src/fit/population.rs", "Population"),
    ),
    ("servos", ("codegen/src/emit/c/servos.rs", "Servos")),
];

/// The header of a part file.
const PART: Place = ("identify/src/fit/part.rs", "Part");

/// What a command prints: when, where it prints several things, and the type that says it.
type Answers = &'static [(&'static str, Place)];

/// What each command prints with `--json`, in the order in which they are listed.
const ANSWERS: [(&str, Answers); 12] = [
    ("demo", &[("", ("src/cli/demo.rs", "Answer"))]),
    ("inspect", &[("", ("src/cli/inspect.rs", "Answer"))]),
    ("plan", &[("", ("identify/src/plan/report.rs", "Plan"))]),
    ("simulate", &[("", ("src/cli/simulate.rs", "Written"))]),
    (
        "fit",
        &[
            ("", ("src/report/fit/mod.rs", "FitReport")),
            (
                "Of data that cannot be used",
                ("src/report/fit/mod.rs", "Unusable"),
            ),
        ],
    ),
    (
        "diagnose",
        &[("", ("identify/src/diagnose/findings.rs", "Diagnosis"))],
    ),
    ("effects", &[("", ("src/cli/effects.rs", "Listed"))]),
    ("compare", &[("", ("src/cli/compare.rs", "Answer"))]),
    (
        "predict",
        &[
            ("", ("src/cli/predict.rs", "Answer")),
            ("With `--out`", ("src/cli/predict.rs", "Written")),
        ],
    ),
    ("generate", &[("", ("src/cli/generate.rs", "Answer"))]),
    ("verify", &[("", ("src/cli/verify.rs", "Answer"))]),
    ("fleet", &[("", ("src/report/fleet/mod.rs", "Answer"))]),
];

/// What every command prints where it fails.
const FAILURE: Place = ("src/cli/mod.rs", "Failure");

/// The pages with their tables as the code has them.
pub(crate) fn pages(root: &Path) -> Result<Vec<(PathBuf, String)>, Error> {
    let failed = |reason: String| Error::Usage(format!("tables of formats: {reason}"));
    let json = Keys::read(root, "object").map_err(failed)?;
    let toml = json.called(TABLE);
    let mut of_formats = vec![
        ("columns", columns()),
        ("sidecar", sidecar()),
        ("sesc.toml", options()),
        ("limits", columns_of_limits()),
        ("part file", keys(&json.of(PART).map_err(failed)?)),
    ];
    for (name, place) in FILES {
        of_formats.push((name, keys(&toml.of(place).map_err(failed)?)));
    }
    let mut answers = String::new();
    for (command, several) in ANSWERS {
        answers += &format!("## `{command}`\n\n");
        for (when, place) in several {
            if !when.is_empty() {
                answers += &format!("{when}:\n\n");
            }
            answers += &(keys(&json.of(*place).map_err(failed)?) + "\n");
        }
    }
    let of_json = [
        ("errors", keys(&json.of(FAILURE).map_err(failed)?)),
        ("answers", answers.trim_end().to_string() + "\n"),
    ];
    Ok(vec![
        page(root, FORMATS, &of_formats)?,
        page(root, JSON, &of_json)?,
    ])
}

/// A page with each table in its place.
fn page(root: &Path, name: &str, tables: &[(&str, String)]) -> Result<(PathBuf, String), Error> {
    let failed = |message: String| Error::Usage(format!("{name}: {message}"));
    let mut text =
        std::fs::read_to_string(root.join(name)).map_err(|error| failed(error.to_string()))?;
    for (place, table) in tables {
        text = replaced(&text, place, table)
            .ok_or_else(|| failed(format!("no place for the table `{place}`")))?;
    }
    Ok((PathBuf::from(name), text))
}

/// Keys of a format, a row each.
fn keys(keys: &[Key]) -> String {
    let rows = keys.iter().map(|key| {
        let Key {
            path,
            value,
            meaning,
        } = key;
        row(&[&format!("`{path}`"), value, meaning])
    });
    row(&["key", "value", ""]) + "|---|---|---|\n" + &rows.collect::<String>()
}

fn columns_of_limits() -> String {
    let rows = limits::columns().into_iter().map(|(names, meaning)| {
        let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        row(&[&names.join(", "), meaning])
    });
    row(&["column", ""]) + "|---|---|\n" + &rows.collect::<String>()
}

/// `text` with `table` between the marks of its name.
fn replaced(text: &str, name: &str, table: &str) -> Option<String> {
    let begin = format!("<!-- cargo regen: {name} -->\n");
    let (before, rest) = text.split_once(&begin)?;
    let (_, after) = rest.split_once("<!-- end -->")?;
    Some(format!("{before}{begin}\n{table}\n<!-- end -->{after}"))
}

fn row(cells: &[&str]) -> String {
    // An empty cell is no reason for two spaces.
    let cells = cells.iter().map(|cell| match *cell {
        "" => " ".to_string(),
        cell => format!(" {cell} "),
    });
    format!("|{}|\n", cells.collect::<Vec<_>>().join("|"))
}

fn columns() -> String {
    let mut out = row(&["column", "unit", ""]) + "|---|---|---|\n";
    for Column {
        names,
        unit,
        meaning,
        need,
        ..
    } in COLUMNS
    {
        let names: Vec<String> = names
            .iter()
            .map(|name| match *name {
                "JOINT" => "a joint's name".to_string(),
                "fsr_k" => "`fsr_1`, `fsr_2`, …".to_string(),
                "fsr_k_std" => "`fsr_1_std`, `fsr_2_std`, …".to_string(),
                name => format!("`{name}`"),
            })
            .collect();
        let need = match need {
            Need::Always => " (required)",
            Need::Reading => " (one kind of reading is required where the command needs readings)",
            _ => "",
        };
        out += &row(&[&names.join(", "), unit, &format!("{meaning}{need}")]);
    }
    out
}

fn sidecar() -> String {
    let rows = SIDECAR_KEYS.map(|(key, meaning)| row(&[&format!("`{key}`"), meaning]));
    row(&["key", ""]) + "|---|---|\n" + &rows.concat()
}

fn options() -> String {
    let mut out = row(&["key", "value", "commands that take it"]) + "|---|---|---|\n";
    for (key, value, commands) in robot_keys() {
        let commands: Vec<String> = commands.iter().map(|name| format!("`{name}`")).collect();
        out += &row(&[&format!("`{key}`"), value, &commands.join(", ")]);
    }
    out
}
