//! Leaves out of a crate's description what `#[doc(hidden)]` hides.
//!
//! rustdoc by itself also drops what a hidden module holds and a shown one passes on: it names
//! such an item and nothing of it. So it is asked for everything, and hidden items are taken
//! out of the modules, types and implementations that hold them.

use std::collections::BTreeSet;

use serde_json::{Value, json};

/// Take hidden items out of `crate_`, the JSON of rustdoc.
pub fn leave_hidden_out(crate_: &mut Value) {
    let Some(index) = crate_["index"].as_object_mut() else {
        return;
    };
    let is_hidden = |item: &Value| {
        let attributes = item["attrs"].as_array().into_iter().flatten();
        attributes
            .into_iter()
            .any(|one| one.to_string().contains("doc(hidden)"))
    };
    let id = |item: &Value| item["id"].as_u64();
    let mut hidden: BTreeSet<u64> = index
        .values()
        .filter(|i| is_hidden(i))
        .filter_map(id)
        .collect();
    let passes_on_hidden = |item: &&Value| {
        let of = item["inner"]["use"]["id"].as_u64();
        of.is_some_and(|of| hidden.contains(&of))
    };
    let uses: Vec<u64> = index
        .values()
        .filter(passes_on_hidden)
        .filter_map(id)
        .collect();
    hidden.extend(uses);
    // What implements a hidden item of a trait carries no attribute of its own.
    let holds = |item: &Value, kind: &str| -> Vec<u64> {
        let items = item["inner"][kind]["items"]
            .as_array()
            .into_iter()
            .flatten();
        items.filter_map(Value::as_u64).collect()
    };
    let mut implemented = Vec::new();
    for item in index.values() {
        let of = &item["inner"]["impl"]["trait"]["id"];
        let Some(of) = of.as_u64().and_then(|of| index.get(&of.to_string())) else {
            continue;
        };
        let name = |id: &u64| index.get(&id.to_string()).map(|item| item["name"].clone());
        let of_trait = holds(of, "trait")
            .into_iter()
            .filter(|id| hidden.contains(id));
        let names: Vec<Value> = of_trait.filter_map(|id| name(&id)).collect();
        let own = holds(item, "impl").into_iter();
        implemented.extend(own.filter(|id| name(id).is_some_and(|name| names.contains(&name))));
    }
    hidden.extend(implemented);
    for item in index.values_mut() {
        leave_out(&mut item["inner"], &hidden);
    }
}

/// Lists of numbers in the description of an item are those of items that it holds.
fn leave_out(value: &mut Value, hidden: &BTreeSet<u64>) {
    let is_hidden = |item: &Value| item.as_u64().is_some_and(|id| hidden.contains(&id));
    match value {
        Value::Array(items) => {
            items.iter_mut().for_each(|item| leave_out(item, hidden));
            items.retain(|item| !is_hidden(item));
        }
        Value::Object(entries) => {
            for (name, entry) in entries {
                match (name.as_str(), &mut *entry) {
                    // Fields of a tuple keep their places.
                    ("tuple", Value::Array(fields)) => {
                        for field in fields.iter_mut().filter(|field| is_hidden(field)) {
                            *field = Value::Null;
                        }
                    }
                    ("plain", Value::Object(plain)) => {
                        let fields = plain.get("fields").and_then(Value::as_array);
                        if fields.is_some_and(|fields| fields.iter().any(is_hidden)) {
                            plain.insert("has_stripped_fields".to_string(), json!(true));
                        }
                        leave_out(entry, hidden);
                    }
                    _ => leave_out(entry, hidden),
                }
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_items_go_and_what_is_passed_on_of_hidden_modules_stays() {
        let hides = json!([{"other": "#[doc(hidden)]"}]);
        let mut crate_ = json!({"index": {
            "0": {"id": 0, "attrs": [], "inner": {"module": {"items": [1, 2, 3, 6]}}},
            "1": {"id": 1, "attrs": hides, "inner": {"module": {"items": [4, 5]}}},
            "2": {"id": 2, "attrs": [], "inner": {"use": {"name": "Tape", "id": 4}}},
            "3": {"id": 3, "attrs": [], "inner": {"use": {"name": "Node", "id": 5}}},
            "4": {"id": 4, "attrs": [], "inner": {"struct": {
                "kind": {"plain": {"fields": [7, 8], "has_stripped_fields": false}}}}},
            "5": {"id": 5, "attrs": hides, "inner": {"struct": {"kind": {"tuple": [7, 8]}}}},
            "6": {"id": 6, "attrs": [], "inner": {"struct": {"kind": {"tuple": [7, 8]}}}},
            "7": {"id": 7, "attrs": hides, "inner": {}},
            "8": {"id": 8, "attrs": [], "inner": {}},
            "9": {"id": 9, "attrs": [], "inner": {"trait": {"items": [10]}}},
            "10": {"id": 10, "name": "ones", "attrs": hides, "inner": {}},
            "11": {"id": 11, "attrs": [], "inner": {"impl": {"trait": {"id": 9}, "items": [12, 8]}}},
            "12": {"id": 12, "name": "ones", "attrs": [], "inner": {}},
        }});
        leave_hidden_out(&mut crate_);
        let of = |id: &str| crate_["index"][id]["inner"].clone();
        assert_eq!(of("0"), json!({"module": {"items": [2, 6]}}));
        assert_eq!(
            of("4"),
            json!({"struct": {"kind": {"plain": {"fields": [8], "has_stripped_fields": true}}}})
        );
        assert_eq!(
            of("11"),
            json!({"impl": {"trait": {"id": 9}, "items": [8]}})
        );
        assert_eq!(of("6"), json!({"struct": {"kind": {"tuple": [null, 8]}}}));
    }
}
