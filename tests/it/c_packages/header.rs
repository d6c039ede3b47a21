//! What a header tells: mass, limits, names, indices, ticks, costs.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use super::user::*;
use crate::c99::compiled::row;
use sesc_test_support::command::{ROOT, op2, says, write};
use sesc_test_support::trees::Urdf;

/// Joints that move by themselves, in the order of the document: name, lower, upper.
fn joints(urdf: &str) -> (Vec<(String, f64, f64)>, f64) {
    let text = fs::read_to_string(urdf).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let number = |node: roxmltree::Node, name: &str| -> f64 {
        node.attribute(name).unwrap().trim().parse().unwrap()
    };
    let child = |node: roxmltree::Node<'_, '_>, name: &str| {
        let mut children = node.children();
        children
            .find(|child| child.has_tag_name(name))
            .map(|child| child.id())
    };
    let mut joints = Vec::new();
    for joint in document
        .descendants()
        .filter(|node| node.has_tag_name("joint"))
    {
        let kind = joint.attribute("type").unwrap_or_default();
        if kind == "fixed" || child(joint, "mimic").is_some() {
            continue;
        }
        let name = joint.attribute("name").unwrap().to_string();
        joints.push(match kind {
            "continuous" => (name, f64::NEG_INFINITY, f64::INFINITY),
            _ => {
                let limit = document.get_node(child(joint, "limit").unwrap()).unwrap();
                (name, number(limit, "lower"), number(limit, "upper"))
            }
        });
    }
    let masses = document
        .descendants()
        .filter(|node| node.has_tag_name("mass"));
    (joints, masses.map(|node| number(node, "value")).sum())
}

/// Compile a program against the package and return the lines that it prints.
fn printed(folder: &Path, name: &str, statements: &str) -> Vec<String> {
    let main = format!(
        "#include \"{name}.h\"\n#include <math.h>\n#include <stdio.h>\n\n\
         int main(void)\n{{\n{statements}    return 0;\n}}\n"
    );
    let main = write(folder, "main.c", main);
    let source = format!("{name}.c");
    run(cc(&[&main, &source, "-lm", "-o", "main"]).current_dir(folder));
    let printed = run(&mut Command::new(folder.join("main")));
    printed.lines().map(str::to_string).collect()
}

#[test]
fn headers_tell_mass_limits_names_and_indices() {
    let lift = format!("{ROOT}/robots/lift_base/lift_base.urdf");
    for (urdf, support, name) in [(op2(), "r_sole", "op2"), (lift, "base_link", "lift")] {
        let (joints, mass) = joints(&urdf);
        assert!(joints.len() > 2);
        for scalar in ["f64", "f32", "fixed32"] {
            let folder = fresh(&format!("header_{name}_{scalar}"));
            let more = ["--scalar", scalar, "--name", name];
            generate(&folder, &urdf, support, &more);
            let unit = |quantity: &str| match scalar {
                "fixed32" => format!("ldexp(1.0, -{name}_{quantity}_FRACTION_BITS)"),
                _ => "1.0".to_string(),
            };
            let (of_mass, of_q) = (unit("TOTAL_MASS"), unit("Q"));
            let limit = |value: &str, extreme: &str, without: &str| match scalar {
                "fixed32" => format!("{value} == {extreme} ? {without} : {value} * {of_q}"),
                _ => value.to_string(),
            };
            let mut statements =
                format!("    printf(\"%.17g\\n\", {name}_total_mass_kg * {of_mass});\n");
            for (joint, ..) in &joints {
                let k = format!("{name}_JOINT_{}", joint.to_uppercase());
                let [lower, upper] =
                    ["lower", "upper"].map(|end| format!("{name}_joint_{end}[{k}]"));
                let lower = limit(&lower, "INT32_MIN", "-INFINITY");
                let upper = limit(&upper, "INT32_MAX", "INFINITY");
                statements += &format!(
                    "    printf(\"%d %s %.17g %.17g\\n\", (int){k}, {name}_joint_names[{k}], {lower}, \
                     {upper});\n"
                );
            }
            statements += &format!(
                "    for (int k = 0; k < {name}_BASE_PARAMS; k += 1) {{\n        \
                 printf(\"%s\\n\", {name}_param_names[k]);\n    }}\n"
            );
            let lines = printed(&folder, name, &statements);
            // What rounding to the scalar may take.
            let near = |x: f64, y: f64| x == y || (x - y).abs() <= 1e-7 * y.abs().max(1.0);
            let found = &lines[0];
            assert!(near(found.parse().unwrap(), mass), "{found} is not {mass}");
            for (k, (line, (joint, lower, upper))) in lines[1..].iter().zip(&joints).enumerate() {
                let words: Vec<&str> = line.split(' ').collect();
                assert_eq!(words[..2], [k.to_string().as_str(), joint], "{line}");
                let [low, high] = [2, 3].map(|at| words[at].parse::<f64>().unwrap());
                let is_near = near(low, *lower) && near(high, *upper);
                // Within the URDF's limits.
                let is_within = low >= *lower && high <= *upper;
                assert!(is_near && is_within, "{line}: {lower} {upper}");
            }
            let params = &lines[1 + joints.len()..];
            assert_eq!(params[0], format!("{support}.x"));
            // The same names stand beside the numbers.
            let source = fs::read_to_string(folder.join(format!("{name}.c"))).unwrap();
            for param in params {
                let named = format!(" /* {param} */");
                assert_eq!(source.matches(&named).count(), 2, "{param}");
            }
        }
    }
}

/// The convention of each joint: zero, sign, and ticks a turn or metres a tick.
fn convention(header: &str) -> BTreeMap<String, (i32, i32, f64, String)> {
    let lines = header
        .lines()
        .skip_while(|line| !line.starts_with(" *     joint "));
    let lines = lines.skip(1).take_while(|line| *line != " *");
    let row = |line: &str| {
        let words: Vec<&str> = line[2..].split_whitespace().collect();
        let [joint, zero, sign, scale, unit @ ..] = words.as_slice() else {
            panic!("{line}")
        };
        let (zero, sign) = (zero.parse().unwrap(), sign.parse().unwrap());
        let row = (zero, sign, scale.parse().unwrap(), unit.join(" "));
        (joint.to_string(), row)
    };
    lines.map(row).collect()
}

#[test]
fn the_tick_convention_of_each_joint_stands_in_the_header() {
    for name in ["op2_r_sole", "op2_r_sole_fixed"] {
        let header = fs::read_to_string(format!("{ROOT}/generated/c/{name}.h")).unwrap();
        let convention = convention(&header);
        assert_eq!(convention.len(), 20);
        for (joint, row) in convention {
            let usual = (2048, 1, 4096.0, "ticks a turn".to_string());
            assert_eq!(row, usual, "{joint}");
        }
    }
    let folder = fresh("ticks");
    let lift = format!("{ROOT}/robots/lift_base/lift_base.urdf");
    let (joints, _) = joints(&lift);
    let servos = format!(
        "[default]\nzero = -77\nresolution = 1228.8\nmetres_per_tick = 3.3e-4\n\
         [joints.{}]\nsign = -1\nzero = 5\n",
        joints[0].0
    );
    let servos = write(&folder, "servos.toml", servos);
    for scalar in ["f64", "f32", "fixed32"] {
        let more = ["--scalar", scalar, "--servos", &servos, "--name", "lift"];
        generate(&folder, &lift, "base_link", &more);
        let header = fs::read_to_string(folder.join("lift.h")).unwrap();
        let convention = convention(&header);
        assert_eq!(convention.len(), joints.len());
        let first = &convention[&joints[0].0];
        assert_eq!((first.0, first.1), (5, -1));
        for (joint, (_, _, scale, unit)) in &convention {
            let expected = match unit.as_str() {
                "ticks a turn" => 1228.8,
                "m a tick" => 3.3e-4,
                _ => panic!("{joint}: {unit}"),
            };
            assert_eq!(*scale, expected, "{joint}");
        }
        assert!(convention.values().any(|row| row.3 == "m a tick"));
    }
}

/// Columns of a function's row: mul, add, sin_cos, look_up.
fn costs(header: &str, function: &str) -> [usize; 4] {
    let row = row(header, function);
    std::array::from_fn(|k| row[k].parse().unwrap())
}

#[test]
fn look_ups_of_ticks_are_counted() {
    for name in ["op2_r_sole", "op2_r_sole_fixed"] {
        let header = fs::read_to_string(format!("{ROOT}/generated/c/{name}.h")).unwrap();
        let [mul, add, ..] = costs(&header, "com_sc");
        assert_eq!(costs(&header, "com_sc")[2..], [0, 0]);
        assert_eq!(costs(&header, "com_ticks"), [mul, add, 0, 20]);
        assert_eq!(costs(&header, "com")[2..], [20, 0]);
    }
    // A resolution that no step of the table divides goes through the angle.
    let folder = fresh("look_ups");
    let servos = "[joints.r_knee]\nresolution = 300.5\n";
    let servos = write(&folder, "servos.toml", servos);
    let more = ["--scalar", "f32", "--servos", &servos, "--name", "op2"];
    generate(&folder, &op2(), "r_sole", &more);
    let header = fs::read_to_string(folder.join("op2.h")).unwrap();
    assert_eq!(costs(&header, "com_ticks")[2..], [1, 19]);
}

/// The trunk of `turned` looks along y of its foot; standing on the other side of a joint changes
/// nothing of that.
#[test]
fn headers_say_which_way_axes_point_and_what_ticks_out_of_range_give() {
    let folder = fresh("axes");
    let robot = Urdf::new("turned")
        .link("foot", 1.0, "0 0 0")
        .link("trunk", 2.0, "0 0 1");
    let hip = "<origin rpy='0 0 1.5707963267948966'/><axis xyz='0 1 0'/>\
               <limit lower='-1' upper='1'/>";
    let robot = robot.joint("hip", "revolute", ["foot", "trunk"], hip);
    let urdf = write(&folder, "turned.urdf", robot.text());
    let header = |more: &[&str]| {
        let more = [&["--name", "turned"], more].concat();
        generate(&folder, &urdf, "foot", &more);
        words(&fs::read_to_string(folder.join("turned.h")).unwrap())
    };
    let said = "z up from the ground, x and y in the sole plane; joints turn by the right-hand rule \
                about their URDF axes; with all at 0, x of trunk points along (0.00, 1.00, 0.00)";
    let turn = "a whole turn more is the same angle, for every int32_t";
    says(header(&["--scalar", "f32"]), &[said, turn]);
    let servos = write(&folder, "servos.toml", "[default]\nresolution = 300.5\n");
    for (scalar, beyond) in [
        ("f32", "angles beyond 1024 rad give NaN"),
        ("f64", "angles beyond 2^20 rad give NaN"),
        (
            "fixed32",
            "what 32 bits do not hold wraps to another posture",
        ),
    ] {
        let found = header(&["--scalar", scalar, "--servos", &servos]);
        says(found, &[&format!("{beyond}. Nothing is undefined.")]);
    }
}
