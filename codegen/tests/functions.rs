//! Modules of chosen functions: each with the very text that it has in the whole module.

use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_model::{Function, Model, Snapping, urdf};

const OP2: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/op2/op2.urdf");

fn op2() -> Model {
    let robot = urdf::read(OP2.as_ref()).unwrap();
    Model::new(&robot, "r_sole", Snapping::default()).unwrap()
}

/// The functions of a module, from their first line to the brace that closes them.
fn functions(module: &str) -> Vec<String> {
    let mut all = Vec::new();
    let mut lines = module.lines();
    while let Some(first) = lines.next() {
        let text = first.trim_start();
        if !text.starts_with("fn ") && !text.starts_with("pub fn ") {
            continue;
        }
        let end = format!("{}}}", &first[..first.len() - text.len()]);
        let mut function = vec![first];
        for line in lines.by_ref() {
            function.push(line);
            if line == end {
                break;
            }
        }
        all.push(function.join("\n"));
    }
    all
}

/// The name of a function without what ends the names of its variants.
fn stem(function: &str) -> &str {
    let name = function.trim_start().trim_start_matches("pub ");
    let name = name.trim_start_matches("fn ").split('<').next().unwrap();
    let ends = ["_into", "_sc", "_along", "_core"];
    let end = ends.into_iter().find(|end| name.ends_with(end));
    name.trim_end_matches(end.unwrap_or_default())
}

#[test]
fn a_chosen_function_has_the_text_that_it_has_in_the_whole_module() {
    let model = op2();
    let whole = functions(&rust::module(&Facts::of(&model), "op2").unwrap());
    let known = Function::ALL.map(Function::name);
    assert!(whole.iter().all(|text| known.contains(&stem(text))));
    for chosen in Function::ALL {
        let facts = Facts::with(&model, &[chosen]);
        let module = rust::module(&facts, "op2").unwrap();
        let names = [Function::Com.name(), chosen.name()];
        let of_chosen = |text: &&String| names.contains(&stem(text));
        let expected: Vec<&String> = whole.iter().filter(of_chosen).collect();
        assert_eq!(functions(&module).iter().collect::<Vec<_>>(), expected);
        // Its header names the others.
        let header: Vec<&str> = module
            .lines()
            .take_while(|line| line.starts_with("//"))
            .collect();
        let header = header.join("\n");
        assert!(header.contains("\n// without        com"), "{header}");
    }
}

#[test]
fn all_functions_by_name_are_the_whole_module() {
    let model = op2();
    let module = |facts: &Facts| rust::module(facts, "op2").unwrap();
    let by_name = Facts::with(&model, &Function::ALL);
    assert!(module(&by_name) == module(&Facts::of(&model)));
}
