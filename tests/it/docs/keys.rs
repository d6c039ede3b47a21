//! What commands print with `--json` is what their schemas, and so docs/json.md, say.

use std::fs;

use serde_json::{Map, Value};
use sesc::cli::schema::{Schemas, all};
use sesc_test_support::command::{ROOT, folder};

use super::run_any;

/// A place in a value that is not as its schema says.
struct Check<'s> {
    definitions: &'s Map<String, Value>,
    faults: Vec<String>,
}

impl Check<'_> {
    fn value(&mut self, schema: &Value, value: &Value, at: &str) {
        if let Some(name) = schema["$ref"].as_str() {
            let name = name.rsplit('/').next().unwrap();
            return self.value(&self.definitions[name].clone(), value, at);
        }
        if let Some(any) = ["anyOf", "oneOf"]
            .iter()
            .find_map(|of| schema[of].as_array())
        {
            let fits = |one: &Value| {
                let mut check = Check {
                    definitions: self.definitions,
                    faults: Vec::new(),
                };
                check.value(one, value, at);
                check.faults.is_empty()
            };
            if !any.iter().any(fits) {
                self.faults
                    .push(format!("{at}: {value} is none of {any:?}"));
            }
            return;
        }
        let kind = match value {
            // A number that is not finite.
            Value::Null if schema["type"] == "number" => "number",
            Value::Null => "null",
            Value::Bool(_) => "boolean",
            Value::Number(_) if schema["type"].to_string().contains("integer") => "integer",
            Value::Number(_) => "number",
            Value::String(_) => "string",
            Value::Array(_) => "array",
            Value::Object(_) => "object",
        };
        let named = match &schema["type"] {
            Value::Array(kinds) => kinds.iter().any(|one| one == kind),
            one => one.is_null() || one == kind,
        };
        let listed = schema["enum"]
            .as_array()
            .is_none_or(|all| all.contains(value));
        let same = schema.get("const").is_none_or(|one| one == value);
        if !named || !listed || !same {
            self.faults.push(format!("{at}: {value} is not {schema}"));
        }
        match value {
            Value::Array(all) => {
                for one in all {
                    self.value(&schema["items"], one, &format!("{at}[]"));
                }
            }
            Value::Object(own) => self.object(schema, own, at),
            _ => {}
        }
    }

    fn object(&mut self, schema: &Value, object: &Map<String, Value>, at: &str) {
        for key in schema["required"].as_array().into_iter().flatten() {
            if !object.contains_key(key.as_str().unwrap()) {
                self.faults.push(format!("{at} has no {key}"));
            }
        }
        for (key, value) in object {
            let of = schema["properties"].get(key);
            match of.or_else(|| schema.get("additionalProperties")) {
                Some(of) => self.value(of, value, &format!("{at}.{key}")),
                None => self.faults.push(format!("{at}.{key} is in no schema")),
            }
        }
    }
}

/// Commands, and lines of the shell between them.
const LINES: &[&str] = &[
    "sesc demo",
    "sesc inspect op2.urdf --support r_sole",
    "sesc inspect op2.urdf --support none",
    "sesc verify op2.urdf --support r_sole --samples 20",
    "sesc plan op2.urdf --support r_sole --poses 10 --candidates 100 --out poses.csv",
    "sesc plan op2.urdf --support r_sole --both-feet --poses 5 --candidates 50 --out few.csv",
    "sesc simulate op2.urdf --support r_sole --poses 60 --noise 0.001 \
     --hide joint_offset:r_knee=3deg --out knee.csv",
    "sesc simulate op2.urdf --support r_sole --poses 600 --rate 50 --noise 0.0005 --out moving.csv",
    "sesc fit op2.urdf --data knee.csv --out model.toml --robust huber",
    "sesc fit op2.urdf --data knee.csv --physical --urdf corrected.urdf --report fit.html",
    "sesc fit op2.urdf --data moving.csv",
    "awk -F, -v OFS=, 'NR == 1 {for (i = 1; i <= NF; i++) if ($i ~ /^cop_[xy]$/) cop[i]} \
     NR > 1 {for (i in cop) $i = 0} 1' knee.csv > dead.csv; cp knee.csv.toml dead.csv.toml",
    "sesc fit op2.urdf --data dead.csv",
    "sesc fit op2.urdf --data knee.csv --partial knee.part",
    "sesc compare knee.csv dead.csv --urdf op2.urdf",
    "sesc diagnose op2.urdf --data dead.csv",
    "printf '[joints.r_knee]\nzero = 2048\n' > servos.toml",
    "sesc diagnose op2.urdf --data knee.csv --servos servos.toml --out found.toml --urdf found.urdf",
    "sesc effects",
    "sesc compare model.toml found.toml",
    "sesc predict op2.urdf --data poses.csv",
    "sesc predict op2.urdf --data poses.csv --out predicted.csv",
    "sesc generate op2.urdf --support r_sole --name op2_r_sole --out src",
    "mkdir logs; for k in 1 2 3; do cp knee.csv logs/r${k}_1.csv; \
     cp knee.csv.toml logs/r${k}_1.csv.toml; done; echo pose,cop_x > logs/r4_1.csv",
    "sesc fleet op2.urdf --data logs --out fleet.csv",
];

#[test]
fn what_commands_print_is_what_their_schemas_say() {
    let folder = folder();
    let at = folder.path();
    fs::copy(format!("{ROOT}/robots/op2/op2.urdf"), at.join("op2.urdf")).unwrap();
    let schemas: Schemas = all();
    let mut seen = vec![false; schemas.answers.len()];
    for line in LINES {
        if !line.starts_with("sesc ") {
            run_any(at, line);
            continue;
        }
        let printed = run_any(at, &format!("{line} --json"));
        let mut value: Value = serde_json::from_str(&printed).unwrap();
        assert_eq!(
            value.as_object_mut().unwrap().remove("schema"),
            Some(1.into())
        );
        let command = match value.get("error") {
            Some(_) => "errors",
            None => line.split(' ').nth(1).unwrap(),
        };
        // Of several cases that of which the value is.
        let mut best: Option<(usize, Vec<String>)> = None;
        for (k, (_, _, schema)) in schemas.answers.iter().enumerate() {
            if schemas.answers[k].0 == command {
                let definitions = &schemas.definitions;
                let mut check = Check {
                    definitions,
                    faults: Vec::new(),
                };
                check.value(schema.as_value(), &value, "");
                if best
                    .as_ref()
                    .is_none_or(|(_, least)| check.faults.len() < least.len())
                {
                    best = Some((k, check.faults));
                }
            }
        }
        let (k, faults) = best.unwrap();
        assert!(faults.is_empty(), "{line}:\n{}", faults.join("\n"));
        seen[k] = true;
    }
    for (seen, (command, case, _)) in seen.iter().zip(&schemas.answers) {
        assert!(seen, "no line prints {command} {case}");
    }
}
