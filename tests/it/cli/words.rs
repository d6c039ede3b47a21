//! Words and numbers of consoles and pages: for people, each once, and lists of no more than eight
//! lines unless all are asked for.

use serde_json::Value;
use sesc_test_support::command::{Folder, ROOT, list, says};
use sesc_test_support::trees::Urdf;

const SERVOS: &str = "[default]\nzero = 512\nresolution = 1024\n";

/// A folder with the OP2 and a log of it with a knee that is off.
fn knee() -> Folder {
    Folder::with_log("--poses 60 --noise 0.0005 --seed 3 --hide joint_offset:r_knee=3deg")
}

/// Ticks are said of a robot that has servos: console, JSON and page alike.
#[test]
fn servo_lines_stand_only_where_servos_were_given() {
    let folder = knee();
    let said = |options: &str| {
        let command = format!("diagnose op2.urdf --data log.csv {options}");
        let text = folder.stdout(&format!("{command} --report page.html"));
        (text, folder.read("page.html"), folder.json(&command))
    };
    let zero = |json: &Value| json["steps"][0]["remedy"]["servo_zero"].clone();
    let (text, page, json) = said("");
    assert!(!text.contains("servo") && !page.contains("<dt>servo</dt>"));
    assert!(zero(&json).is_null());
    folder.write("servos.toml", SERVOS);
    let (text, page, json) = said("--servos servos.toml");
    says(text, &["  servo ", "zero 512 → 504"]);
    says(page, &["<dt>servo</dt>"]);
    assert_eq!(zero(&json)["before"], 512);
    // The settings of the robot give them, too.
    folder.write("sesc.toml", "servos = \"servos.toml\"\n");
    assert_eq!(zero(&said("").2)["before"], 512);
}

/// y = R p + o of a sensor that is turned and moved: p is R⁻¹ (y − o), the zero first.
#[test]
fn two_corrections_of_the_reading_say_which_is_applied_first() {
    let folder = Folder::with_log(
        "--poses 100 --range 30 --noise 0.0005 --seed 3 --hide sensor_rotation=6deg \
         --hide sensor_offset=12mm,-9mm",
    );
    let json = folder.json("diagnose op2.urdf --data log.csv");
    let remedy = |effect: &str| {
        let mut steps = list(&json, "/steps").iter();
        let step = steps.find(|step| step["effect"] == effect).expect(effect);
        step["remedy"]["sentence"].as_str().unwrap().to_string()
    };
    let [zero, turn] = ["sensor_offset", "sensor_rotation"].map(remedy);
    assert!(zero.ends_with("apply this one first"), "{zero}");
    let second = "apply this one second, to what the first gives";
    assert!(turn.ends_with(second), "{turn}");
    // One sign: the way and a size.
    says(&turn, &["turned clockwise by "]);
    assert!(!turn.contains('−'), "{turn}");
    says(
        json["sentence"].to_string(),
        &["With them the held-out error is"],
    );
}

/// What people read has a minus; what programs read, a hyphen.
#[test]
fn numbers_of_consoles_have_a_true_minus() {
    let folder = knee();
    folder.write("later.csv", folder.read("log.csv"));
    folder.write("later.csv.toml", folder.read("log.csv.toml"));
    let mut seen = 0;
    for command in [
        "inspect op2.urdf --support r_sole --long",
        "fit op2.urdf --data log.csv --long --urdf corrected.urdf",
        "diagnose op2.urdf --data log.csv --prior cad --long",
        "compare log.csv later.csv --urdf op2.urdf",
        "plan op2.urdf --support r_sole --poses 12 --candidates 60 --prior tight --out poses.csv",
        "effects ground_slope",
    ] {
        let text = folder.stdout(command);
        seen += text.matches('−').count();
        // Lines of a URDF are as they stand in it.
        for line in text.lines().filter(|line| !line.contains('<')) {
            let number = |part: &str| part.starts_with(|c: char| c.is_ascii_digit());
            let hyphen = [" -", "(-", "±-"]
                .iter()
                .any(|before| line.split(before).skip(1).any(number));
            assert!(!hyphen, "{command}: {line}");
        }
    }
    assert!(seen > 50, "{seen}");
    let predicted = folder.stdout("predict op2.urdf --data log.csv");
    assert!(predicted.contains(",-0.") && !predicted.contains('−'));
}

/// Twenty followers are one sentence, what is snapped and does not move is one line, and the end
/// sums up.
#[test]
fn lists_of_inspect_are_short_and_long_lists_all() {
    let folder = Folder::empty();
    let mut hand = Urdf::new("hand").link("palm", 1.0, "0 0 0");
    hand = hand.link("l0", 1.0, "0.1 0 0.1");
    hand = hand.revolute("j0", ["palm", "l0"], "0 0 0", "1 0 0", 1.0);
    for k in 1..=12 {
        let more = format!(
            "<origin xyz='0 0.0{k} 0' rpy='0 1.5707963268 0'/><axis xyz='0 0 1'/>\
             <mimic joint='j0'/><limit lower='-1' upper='1'/>"
        );
        let link = format!("l{k}");
        hand = hand.link(&link, 1.0, "0.1 0 0.1");
        hand = hand.joint(&format!("j{k}"), "revolute", ["palm", &link], &more);
    }
    folder.write("hand.urdf", hand.text());
    let inspect = "inspect hand.urdf --support palm";
    let short = folder.stdout(inspect);
    let long = folder.stdout(&format!("{inspect} --long"));
    let words: Vec<&str> = short.split_whitespace().collect();
    let tied = "mimic joints tie its angle to theirs";
    assert_eq!(words.join(" ").matches(tied).count(), 1, "{short}");
    let all = [
        " of this kind: `l",
        "snapped j1 and 11 more: ",
        "and 6 more: --long lists all",
    ];
    says(&short, &all);
    let told = long.matches(" cannot be told from earlier parameters");
    assert!(told.count() > 8, "{long}");
    assert_eq!(short.matches("snapped ").count(), 1, "{short}");
    assert_eq!(long.matches("snapped ").count(), 12, "{long}");
    assert!(!long.contains("--long"));
    assert!(short.lines().count() < 60 && short.lines().count() < long.lines().count());
    // Every other line of the headers of generated code moves the CoM.
    folder.stdout("generate hand.urdf --support palm --lang c --name hand --out c");
    assert_eq!(folder.read("c/hand.h").matches("snapped ").count(), 1);
    let summary = short
        .lines()
        .rfind(|line| line.starts_with("hand on palm: "));
    says(summary.unwrap(), &["14 bodies, 1 independent joint"]);
}

/// Logs are no models.
#[test]
fn a_comparison_of_logs_speaks_of_no_model() {
    let folder = knee();
    folder.simulate("--poses 60 --noise 0.0005 --seed 4 --out sound.csv");
    let text = folder.stdout("compare sound.csv log.csv --urdf op2.urdf --report page.html");
    let appeared = "These effects appeared: an offset of r_knee (joint_offset:r_knee)";
    says(&text, &[appeared]);
    let page = folder.read("page.html");
    let (_, body) = page.split_once("<body>").unwrap();
    for said in [&text, body.split("<script").next().unwrap()] {
        assert!(!said.contains("second model") && !said.contains("either model"));
    }
    let json = folder.json("compare log.csv sound.csv --urdf op2.urdf");
    says(
        json["sentence"].to_string(),
        &["\"These effects are gone: an offset of"],
    );
}

/// Every command × every exit code that it has.
#[test]
fn every_way_out_of_every_command_prints_one_json_object() {
    let folder = knee();
    // A dead axis cannot be used.
    let mut dead = folder.sheet("log.csv");
    dead.set("cop_x", None, "0.01");
    folder.write("dead.csv", dead.to_string());
    folder.write("dead.csv.toml", folder.read("log.csv.toml"));
    folder.write("broken/r1_monday.csv", "nonsense\n");
    folder.write("bad.toml", "robot = 3\n");
    let bad = format!("{ROOT}/tests/bad_urdf/negative_mass.urdf");
    let table = "
        0 inspect op2.urdf --support r_sole
        2 inspect BAD --support r_sole
        2 inspect op2.urdf --support nothing
        2 inspect op2.urdf --support r_sole --long
        0 plan op2.urdf --support r_sole --poses 12 --candidates 60 --prior tight --out poses.csv
        2 plan op2.urdf --support r_sole --poses 0 --out poses.csv
        0 simulate op2.urdf --support r_sole --poses 20 --noise 0.0005 --out again.csv
        2 simulate op2.urdf --support r_sole --poses 20 --hide nothing:at=1 --out again.csv
        0 fit op2.urdf --data log.csv
        0 fit op2.urdf --data log.csv --partial own.part
        0 fit own.part --noise 0.0005
        1 fit op2.urdf --data dead.csv
        1 fit op2.urdf --data dead.csv --partial dead.part
        1 fit op2.urdf --data log.csv --fail-above 0.1
        2 fit op2.urdf --data missing.csv
        0 diagnose op2.urdf --data log.csv
        1 diagnose op2.urdf --data dead.csv
        1 diagnose op2.urdf --data log.csv --fail-above 0.1
        2 diagnose op2.urdf --data log.csv --prior nothing.toml
        0 effects
        2 effects nothing
        0 compare log.csv log.csv --urdf op2.urdf
        1 compare log.csv dead.csv --urdf op2.urdf
        1 compare dead.csv log.csv --urdf op2.urdf
        2 compare log.csv log.csv
        0 predict op2.urdf --data log.csv
        0 predict op2.urdf --data log.csv --out cop.csv
        2 predict op2.urdf --model bad.toml --data log.csv
        0 generate op2.urdf --support r_sole --lang rust --out rust
        2 generate op2.urdf --support r_sole --lang basic --out rust
        0 verify op2.urdf --support r_sole --samples 20
        2 verify op2.urdf --support r_sole --samples 0
        0 fleet op2.urdf --data log.csv --out fleet.csv
        1 fleet op2.urdf --data broken --out broken.csv --by robot,day
        2 fleet op2.urdf --data log.csv --out fleet.txt
        2 demo --nothing
        2 completions --nothing
        2 man --nothing
        2 nothing
    ";
    for line in table.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let (code, command) = line.split_once(' ').unwrap();
        let command = command.replace("BAD", &bad);
        let json = folder.json_of(code.parse().unwrap(), &command);
        assert_eq!(json["schema"], 1, "{command}");
        match code {
            "2" => assert!(json["error"]["message"].is_string(), "{command}"),
            "1" if command.contains("dead.csv") => {
                assert_eq!(json["verdict"], "unusable", "{command}");
                assert_eq!(json["health"][0]["kind"], "cop_axis_dead", "{command}");
            }
            _ => assert!(json["error"].is_null(), "{command}"),
        }
        if command.starts_with("compare") && code == "1" {
            assert_eq!(json["log"], "dead.csv");
        }
    }
}
