//! What a header says of a model file, and the program that stands a robot on it.

use std::fs;
use std::process::Command;

use sesc_reference::{Robot, World};

use super::user::*;
use sesc_test_support::command::{Folder, ROOT, list, op2, says};

/// A model of the OP2 with CAD's parameters and these effects.
fn model(folder: &Folder, effects: &str) {
    let json = folder.json("inspect op2.urdf --support r_sole");
    let mut model = format!(
        "robot = \"op2\"\nhash = {}\nsupport = \"r_sole\"\n",
        json["hash"]
    );
    for parameter in list(&json, "/parameters") {
        let (name, cad) = (&parameter["name"], &parameter["cad"]);
        model += &format!("[[parameters]]\nname = {name}\nvalue = {cad}\n");
    }
    folder.write("model.toml", model + effects);
}

const EFFECTS: &str = "
[[effects]]
effect = \"joint_offset\"
target = \"r_ank_pitch\"
parameters.offset_rad = { value = 0.05 }
[[effects]]
effect = \"ground_slope\"
parameters.slope_x = { value = 0.04 }
parameters.slope_y = { value = -0.02 }
[[effects]]
effect = \"sensor_gain\"
parameters.gain_x = { value = 1.2 }
parameters.gain_y = { value = 0.9 }
";

/// The firmware page's `stand` moves the ankles of the bent robot until its sensor reads what is
/// wanted; header and JSON say what `model_com` holds, and the encoder zero to add.
#[test]
fn the_program_of_the_firmware_page_stands_a_robot_on_a_corrected_model() {
    let folder = Folder::with("op2");
    model(&folder, EFFECTS);
    let answer = folder
        .json("generate op2.urdf --model model.toml --lang c --scalar f32 --name op2 --out .");
    let [zero] = &list(&answer, "/encoder_zeros")[..] else {
        panic!("{answer}")
    };
    assert_eq!(zero["joint"], "r_ank_pitch");
    assert_eq!(zero["add"], 0.05);
    let effects = list(&answer, "/effects").iter();
    let held: Vec<&str> = effects.map(|e| e["functions"].as_str().unwrap()).collect();
    assert_eq!(held, ["all", "cop", "cop"]);
    let held =
        "Holds: joint_offset of r_ank_pitch. Only model_cop holds: ground_slope, sensor_gain.";
    let said = [
        "encoder r_ank_pitch: add 0.05 rad to what it reads",
        "effect in cop ground_slope",
        held,
        "with them the CoM that balances is not the one of com or model_com",
        "void op2_model_com_jacobian(",
        "void op2_model_cop_jacobian(",
    ];
    says(words(&folder.read("op2.h")), &said);

    let page = fs::read_to_string(format!("{ROOT}/docs/firmware.md")).unwrap();
    let begin = "```c\n#include \"op2.h\"\n\n/* One step";
    let (_, rest) = page.split_once(begin).unwrap();
    let stand = rest.split_once("```").unwrap().0;
    let main = format!(
        "#include \"op2.h\"\n#include <stdio.h>\n/* One step{stand}\nint main(void) {{\n\
         float q[op2_DOF] = {{0}};\nconst float wanted[2] = {{0.015f, -0.004f}};\n\
         for (int k = 0; k < 8; k++) stand(q, wanted);\n\
         for (int j = 0; j < op2_DOF; j++) printf(\"%.9g\\n\", (double)q[j]);\n\
         return op2_selftest();\n}}\n"
    );
    folder.write("main.c", main);
    let mut cc = Command::new("cc");
    cc.args(["-std=c99", "main.c", "op2.c", "-o", "main"]);
    run(cc.current_dir(folder.path()));
    let printed = run(&mut Command::new(folder.join("main")));
    let q: Vec<f64> = printed.lines().map(|line| line.parse().unwrap()).collect();
    let world = World::new(&Robot::from_file(op2()).unwrap(), "r_sole").unwrap();
    let world = world.joint_offset("r_ank_pitch", 0.05).unwrap();
    let world = world.ground_slope([0.04, -0.02]).unwrap();
    let reading = world.sensor_gain([1.2, 0.9]).cop(&q);
    let off = (reading[0] - 0.015).hypot(reading[1] + 0.004);
    assert!(off < 1e-5, "{reading:?}");
}
