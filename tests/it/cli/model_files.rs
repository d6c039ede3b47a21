//! Model files: whose parameters they are, and what they spare the user to say.

use sesc_test_support::command::Folder;

/// Two links in a folder with a log and `model.toml`, which stands on `foot`, all of it moved
/// 0.5 m along x.
fn shifted() -> (Folder, String) {
    let folder = Folder::with("two_link");
    let json = folder.json("inspect two_link.urdf --support foot");
    let hash = &json["hash"];
    let mut model = format!("robot = \"two_link\"\nhash = {hash}\nsupport = \"foot\"\n");
    for parameter in json["parameters"].as_array().unwrap() {
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
    let com_x = |line: &str| -> f64 {
        let text = folder.stdout(line);
        let row = text.lines().nth(1).unwrap();
        row.split(',').nth(1).unwrap().parse().unwrap()
    };
    let identified = com_x(&format!("{base} --model model.toml"));
    assert!((identified - com_x(base) - 0.5).abs() < 1e-15);
    folder.stdout("generate two_link.urdf --support foot --model model.toml --name m --out .");
    assert!(folder.read("m.rs").contains("MODEL_PARAMS"));
    let wrong = format!("{model}[information]\nfactor = [[1.0]]\n");
    for (text, words) in [
        (model.replace("hash = \"", "hash = \"0"), &["hash"][..]),
        (
            model.rsplit_once("[[").unwrap().0.to_string(),
            &["parameters"],
        ),
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
