//! docs/json.md: the keys of all that commands print, from the schemas of the printed types.
//!
//! A type of its own has a table of its own, once; its name stands as the value of each key that
//! holds one.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Map, Value};
use sesc::cli::schema::{Schemas, all};

/// What stands above the tables.
const HEAD: &str = "# JSON of commands

With `--json` every command but `completions` and `man` prints one object. It begins with `schema`, a number that grows when keys change their meaning; more keys may come without it.

Units are SI unless a key says otherwise; errors of the CoP are per axis. A number that is not finite is `null`. `[…]` is a list, `{…}` a map from names, `?` marks what may be `null` or missing, and a link leads to the [type](#types) of an object or word.

`cargo regen` writes this page from the types that are printed.
";

type Object = Map<String, Value>;

/// The page.
pub(crate) fn page() -> String {
    let Schemas {
        answers,
        definitions,
    } = all();
    let mut out = HEAD.to_string();
    let mut last = "";
    for (command, case, schema) in &answers {
        let schema = schema.as_value();
        if *command != last {
            let _ = write!(out, "\n## `{command}`\n");
        }
        if !case.is_empty() {
            let _ = write!(out, "\n{case}:\n");
        }
        last = command;
        out += &table(schema);
    }
    out += "\n## Types\n";
    let definitions: BTreeMap<_, _> = definitions.iter().collect();
    for (name, schema) in definitions {
        let _ = write!(out, "\n### {name}\n");
        out += &match schema.get("properties") {
            Some(_) => table(schema),
            None => format!("\n{}\n", words(schema).join(", ")),
        };
    }
    out
}

/// Keys of an object, a row each.
fn table(schema: &Value) -> String {
    let mut rows = String::from("\n|key|value||\n|---|---|---|\n");
    keys(schema, "", &mut rows);
    rows
}

fn keys(schema: &Value, prefix: &str, rows: &mut String) {
    let nothing = Object::new();
    let properties = schema["properties"].as_object().unwrap_or(&nothing);
    let always = |key: &str| {
        let required = schema["required"].as_array();
        required.is_some_and(|all| all.iter().any(|own| own == key))
    };
    for (key, of) in properties {
        let (of, value, or_null) = shape(of);
        let mark = if or_null || !always(key) { "?" } else { "" };
        let meaning = plain(of["description"].as_str().unwrap_or_default());
        let _ = writeln!(rows, "|`{prefix}{key}`|{value}{mark}|{meaning}|");
        if of.get("properties").is_some() {
            keys(of, &format!("{prefix}{key}."), rows);
        }
    }
}

/// What a value is, in short, and whether it may be `null`; with the schema that describes it.
fn shape(of: &Value) -> (&Value, String, bool) {
    if let Some(any) = of["anyOf"].as_array() {
        let null = |one: &&Value| one["type"] == "null";
        let inner = any.iter().find(|one| !null(one)).map(shape);
        return (of, inner.map_or_else(String::new, |inner| inner.1), true);
    }
    if let Some(name) = of["$ref"].as_str() {
        let name = name.rsplit('/').next().unwrap_or(name);
        return (of, format!("[{name}](#{})", name.to_lowercase()), false);
    }
    let inner = |key: &str| of.get(key).map(|of| shape(of).1).unwrap_or_default();
    let kinds: Vec<&str> = match &of["type"] {
        Value::Array(all) => all.iter().filter_map(Value::as_str).collect(),
        one => one.as_str().into_iter().collect(),
    };
    let value = match kinds.first().copied().unwrap_or_default() {
        "array" if of.get("prefixItems").is_some() => {
            let all = of["prefixItems"].as_array().into_iter().flatten();
            format!(
                "[{}]",
                all.map(|of| shape(of).1).collect::<Vec<_>>().join(",")
            )
        }
        "array" => format!("[{}]", inner("items")),
        "object" if of.get("additionalProperties").is_some() => {
            format!("{{{}}}", inner("additionalProperties"))
        }
        "string" if of.get("enum").is_some() => words(of).join("\\|"),
        "string" => "text".to_string(),
        kind => kind.to_string(),
    };
    (of, value, kinds.contains(&"null"))
}

/// The words that a value may be.
fn words(schema: &Value) -> Vec<String> {
    let named = |of: &Value| of.as_str().map(|word| format!("`{word}`"));
    let cases = schema["oneOf"].as_array().into_iter().flatten();
    let cases = cases.flat_map(|case| match case["enum"].as_array() {
        Some(all) => all.iter().filter_map(named).collect(),
        None => named(&case["const"]).into_iter().collect::<Vec<_>>(),
    });
    let plain = schema["enum"].as_array().into_iter().flatten();
    plain.filter_map(named).chain(cases).collect()
}

/// The first clause of a documentation, on one line and without links into the code.
fn plain(text: &str) -> String {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let ends = [
        "; ",
        ". ",
        ": ",
        " (",
        ", where ",
        ", which ",
        ", in which ",
    ];
    let end = ends.iter().filter_map(|end| text.find(end)).min();
    let clause = text[..end.unwrap_or(text.len())].trim_end_matches('.');
    let clause = clause.replace("[`", "`").replace("`]", "`");
    clause.replace('|', "\\|")
}
