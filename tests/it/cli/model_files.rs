//! Model files: whose parameters they are, and what they spare the user to say.

use sesc_test_support::command::{Folder, Sheet, list, says, stderr};

/// Two links in a folder with a log and `model.toml`, which stands on `foot`, all of it moved
/// 0.5 m along x.
fn shifted() -> (Folder, String) {
    let folder = Folder::with("two_link");
    let json = folder.json("inspect two_link.urdf --support foot");
    let hash = &json["hash"];
    let mut model = format!("robot = \"two_link\"\nhash = {hash}\nsupport = \"foot\"\n");
    for parameter in list(&json, "/parameters") {
        let name = &parameter["name"];
        let shift = if name == "foot.x" { 0.5 } else { 0.0 };
        let value = parameter["cad"].as_f64().unwrap() + shift;
        model += &format!("[[parameters]]\nname = {name}\nvalue = {value:?}\n");
    }
    folder.write("model.toml", &model);
    folder.write("bare.csv", "pose,ankle,knee\n1,0,0\n");
    (folder, model)
}

/// A model file moves predictions, and belongs to its robot and support.
#[test]
fn model_files_are_read_checked_and_baked_in() {
    let (folder, model) = shifted();
    let base = "predict two_link.urdf --support foot --data bare.csv";
    let com_x = |line: &str| Sheet::read(&folder.stdout(line)).numbers(&["com_x"])[0][0];
    let identified = com_x(&format!("{base} --model model.toml"));
    assert!((identified - com_x(base) - 0.5).abs() < 1e-15);
    folder.stdout("generate two_link.urdf --support foot --model model.toml --name m --out .");
    assert!(folder.read("m.rs").contains("MODEL_PARAMS"));
    let few = model.rsplit_once("[[").unwrap().0.to_string();
    let wrong = format!("{model}[information]\nfactor = [[1.0]]\n");
    for (text, words) in [
        (model.replace("hash = \"", "hash = \"0"), &["hash"][..]),
        (few, &["parameters"]),
        (wrong, &["information.factor needs", "fit again"]),
        (
            format!("{model}[[effects]]\neffect = \"warp\"\n"),
            &["warp"],
        ),
    ] {
        folder.write("other.toml", text);
        let line = format!("{base} --model other.toml");
        folder.refuses(&line, &[&["other.toml"], words].concat());
    }
}

/// The support comes from the flag, then from the log, then from the model file.
#[test]
fn a_model_file_says_what_stands_on_the_ground() {
    let (folder, _) = shifted();
    for command in [
        "generate two_link.urdf --name m --out src",
        "simulate two_link.urdf --poses 5 --out log.csv",
        "plan two_link.urdf --poses 2 --cop-box 1 --sigmas 0 --out poses.csv",
        "predict two_link.urdf --data bare.csv",
    ] {
        let with = format!("{command} --model model.toml");
        folder.stdout(&with);
        folder.refuses(command, &["no support link", "--support"]);
        let other = format!("{with} --support shank");
        folder.refuses(&other, &["model.toml", "`foot`", "`shank`"]);
    }
    for (file, text) in [
        ("src/m.rs", "support frame  foot"),
        ("log.csv.toml", "\"foot\""),
        ("poses.csv.toml", "\"foot\""),
    ] {
        assert!(folder.read(file).contains(text), "{file}");
    }
    // What the log says counts more than the model file: they must agree.
    folder.write("bare.toml", "support = \"shank\"\n");
    let line = "predict two_link.urdf --model model.toml --data bare.csv";
    folder.refuses(line, &["model.toml", "`foot`", "`shank`"]);
    let other = Folder::with("op2");
    other.write("model.toml", folder.read("model.toml"));
    let line = "simulate op2.urdf --poses 5 --model model.toml --out log.csv";
    other.refuses(line, &["model.toml", "hash"]);
}

/// What no robot has is refused where a model file is read, by every command and by `build.rs`;
/// what is believed of none is warned of.
#[test]
fn effects_that_no_robot_has_are_refused_or_warned_of_by_every_command() {
    let (folder, model) = shifted();
    let effect = |name: &str, target: &str, values: &[(&str, &str)]| {
        let values = values.iter();
        let values = values.map(|(key, x)| format!("parameters.{key} = {{ value = {x} }}\n"));
        let values: String = values.collect();
        format!("[[effects]]\neffect = \"{name}\"\ntarget = \"{target}\"\n{values}")
    };
    let spring = |x: &str| effect("joint_compliance", "knee", &[("stiffness_nm_per_rad", x)]);
    let load_on = |link: &str, mass: &str, x: &str| {
        let at = [
            ("mass_kg", mass),
            ("x_m", x),
            ("y_m", "0.0"),
            ("z_m", "0.1"),
        ];
        effect("payload", link, &at)
    };
    let load = |mass: &str, x: &str| load_on("shank", mass, x);
    let gain = |x: &str| effect("sensor_gain", "-", &[("gain_x", x), ("gain_y", "1.0")]);
    let slope = |x: &str| effect("ground_slope", "-", &[("slope_x", x), ("slope_y", "0.0")]);
    let offset = effect("joint_offset", "knee", &[("offset_rad", "0.01")]);
    let commands = [
        "generate two_link.urdf --model other.toml --name m --out src",
        "generate two_link.urdf --model other.toml --lang c --name m --out src",
        "predict two_link.urdf --model other.toml --data bare.csv",
        "simulate two_link.urdf --model other.toml --poses 3 --out log.csv",
        "verify two_link.urdf --model other.toml --samples 10",
        "plan two_link.urdf --model other.toml --poses 3 --cop-box 1 --sigmas 0 --out poses.csv",
    ];
    let build = |text: &str| {
        let path = folder.write("other.toml", format!("{model}{text}"));
        let builder = sesc_codegen::Builder::new(folder.join("two_link.urdf")).support("foot");
        builder.model(path).out_dir(folder.join("out")).emit()
    };
    let two_loads = load("-2.0", "0.1") + &load_on("thigh", "-5.0", "0.0");
    let soft = "springs are too soft";
    // The shank weighs 3 kg; gravity's stiffness at the knee is 5 kg · 0.2 m · g = 9.8 Nm/rad.
    for (text, words) in [
        (
            load("-9.999999999999999", "0.1"),
            ["body of link `shank`", "nothing or less"],
        ),
        (load("-3.0", "0.1"), ["body of link `shank`", ""]),
        (two_loads, ["body of link `thigh`", ""]),
        (spring("1e-300"), [soft, "stiffness_nm_per_rad"]),
        (spring("5.0"), [soft, "1.96"]),
        (spring("10.0"), [soft, "0.98"]),
        (offset.repeat(2), ["joint_offset:knee", "twice"]),
        (offset.repeat(21), ["21 effects", "20 at most"]),
    ] {
        says(build(&text).unwrap_err().to_string(), &words);
        for command in commands {
            folder.refuses(command, &words);
        }
    }
    for (text, name) in [
        (gain("1e6"), "sensor_gain"),
        (slope("1e6"), "ground_slope"),
        (load("1.0", "1e6"), "payload:shank"),
    ] {
        build(&text).unwrap();
        for command in &commands[..4] {
            says(
                stderr(&folder.run(command)),
                &[name, "believed of no robot"],
            );
        }
    }
    // What robots have is taken without a word, and softer springs take more rounds.
    let text = spring("400.0") + &gain("1.1") + &load("-0.5", "0.1");
    build(&text).unwrap();
    assert!(!stderr(&folder.run(commands[2])).contains("believed"));
    let rounds = |x: &str| {
        folder.write("other.toml", format!("{model}{}", spring(x)));
        let said = folder.stdout("verify two_link.urdf --model other.toml --samples 200");
        let (before, _) = said.split_once(" rounds leave out").unwrap();
        before.rsplit(' ').next().unwrap().parse::<usize>().unwrap()
    };
    // 9.8/60 = 0.16 of what gravity bends is bent again; 9.8/25 = 0.39.
    assert_eq!((rounds("60.0"), rounds("25.0")), (4, 6));
}
