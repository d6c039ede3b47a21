//! Tables of docs/formats.md, written from those that readers and commands use.

use std::path::{Path, PathBuf};

use sesc::Error;
use sesc::cli::robot_keys;
use sesc_identify::logs::{COLUMNS, Column, Need, SIDECAR_KEYS};

/// The page whose tables are written.
const PAGE: &str = "docs/formats.md";

/// The page with its tables as the code has them.
pub(crate) fn page(root: &Path) -> Result<(PathBuf, String), Error> {
    let failed = |message: String| Error::Usage(format!("{PAGE}: {message}"));
    let path = root.join(PAGE);
    let mut text = std::fs::read_to_string(path).map_err(|error| failed(error.to_string()))?;
    for (name, table) in [
        ("columns", columns()),
        ("sidecar", sidecar()),
        ("sesc.toml", options()),
    ] {
        text = replaced(&text, name, &table)
            .ok_or_else(|| failed(format!("no place for the table `{name}`")))?;
    }
    Ok((PathBuf::from(PAGE), text))
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
