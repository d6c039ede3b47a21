//! A support that is given by a link and the height of its frame over the sole.

use sesc_test_support::command::Folder;
use sesc_test_support::feet::TwoFeet;
use sesc_test_support::stage::{Platform, Stage};

/// 33.5 mm below the frame of the link: by name, and as a link of the URDF.
const BY_HEIGHT: &str = "r_ank_roll_link@33.5mm";
const AS_LINK: &str = "below";
const LINES: &str = "<link name='below'/><joint name='to_below' type='fixed'>\
    <parent link='r_ank_roll_link'/><child link='below'/><origin xyz='0 0 -0.0335'/></joint>";

#[test]
fn every_command_takes_the_sole_of_a_link_as_a_link_in_the_sole() {
    let [by_height, as_link] = [(BY_HEIGHT, ""), (AS_LINK, LINES)].map(|(support, lines)| {
        let folder = Folder::with("op2");
        let urdf = folder.read("op2.urdf");
        folder.write(
            "op2.urdf",
            urdf.replace("</robot>", &format!("{lines}</robot>")),
        );
        let run = |command: &str, more: &str| {
            folder.json(&format!("{command} op2.urdf --support {support} {more}"))
        };
        let hidden = "--seed 4 --noise 0.0005 --hide joint_offset:r_knee=2deg";
        run("simulate", &format!("--poses 60 {hidden} --out log.csv"));
        // The sidecar names the support, and it alone does.
        let fit = folder.json("fit op2.urdf --data log.csv --out model.toml");
        let values = fit["parameters"].as_array().unwrap().iter();
        let values: Vec<f64> = values.map(|p| p["value"].as_f64().unwrap()).collect();
        let found = run("diagnose", "--data log.csv");
        let predicted = run("predict", "--model model.toml --data log.csv");
        let verified = run("verify", "--samples 100 --model model.toml");
        assert_eq!(verified["pass"], true);
        let said = found["sentence"].to_string();
        (
            folder.read("log.csv"),
            values,
            said,
            predicted["com_m"].clone(),
        )
    });
    assert_eq!(by_height, as_link);
    assert!(by_height.2.contains("r_knee"), "{}", by_height.2);
}

#[test]
fn a_height_is_refused_where_it_cannot_be_one() {
    let folder = Folder::with("op2");
    folder.stdout(&format!(
        "simulate op2.urdf --poses 5 --support {BY_HEIGHT} --out log.csv"
    ));
    // The other sole is given in the same way.
    folder.refuses_each(
        "inspect op2.urdf --support r_foot@33mm | no link `r_foot` to stand on
         inspect op2.urdf --support r_sole@0.50mm | such as `r_sole@0.5mm`
         inspect op2.urdf --support r_sole --sole-height 33.5 | 0.0335 for 33.5 mm
         inspect op2.urdf --support r_sole --sole-height nan | give a number of metres
         inspect op2.urdf --sole-height 0.03 | name the link that has this sole by --support
         fit op2.urdf --data log.csv --other-foot l_ank_roll_link@3.0mm
            | is no sole of a link | `l_ank_roll_link@3mm`
         fit op2.urdf --data log.csv --other-foot l_ank_rol_link@3mm
            | `l_ank_rol_link` is no link | did you mean",
    );
}

/// The OP2 without its links in the soles, on both feet: plans put both soles on the floor, and
/// the knee that is off is found as with these links.
#[test]
fn a_robot_without_links_in_its_soles_stands_on_both_feet() {
    let folder = Folder::with("op2");
    let mut bare = folder.read("op2.urdf");
    for side in ["l", "r"] {
        let begin = bare
            .find(&format!("<joint name=\"{side}_sole_fixed\""))
            .unwrap();
        let link = format!("<link name=\"{side}_sole\"/>");
        let end = bare.find(&link).unwrap() + link.len();
        bare.replace_range(begin..end, "");
    }
    folder.write("bare.urdf", &bare);
    let bare = "bare.urdf --support r_ank_roll_link --sole-height 0.0335";
    let options = "--both-feet --poses 30 --candidates 60 --out poses.csv";
    let planned = folder.json(&format!("plan {bare} {options}"));
    assert_eq!(planned["both_feet"]["other_foot"], "l_ank_roll_link@33.5mm");

    let stage = Stage::new(Platform::Op2);
    let feet = TwoFeet::new(&stage);
    let world = stage.world().joint_offset("l_knee", 0.026).unwrap();
    let with = feet.log_of_plan(&world, &folder.read("poses.csv"), [0.0; 2]);
    // The link in the right sole is 10.5 mm to the right of the ankle.
    let without = feet.log_of_plan(&world, &folder.read("poses.csv"), [0.0, -0.0105]);
    let found = |robot: &str, log: &str| {
        folder.write("log.csv", log);
        folder.json(&format!("diagnose {robot} --data log.csv --noise 0.003"))
    };
    let own = found("op2.urdf --support r_sole --both-feet", &with);
    let by_height = found(&format!("{bare} --both-feet"), &without);
    let by_name = found(
        &format!("{bare} --other-foot l_ank_roll_link@33.5mm"),
        &without,
    );
    assert_eq!(by_height["closure"], by_name["closure"]);
    assert_eq!(by_height["steps"][0]["target"], "l_knee", "{by_height}");
    let closure = &by_height["closure"];
    assert_eq!(closure["other_foot"], "l_ank_roll_link@33.5mm");
    assert_eq!(closure["closes"], true, "{closure}");
    for key in ["roll_rad", "pitch_rad"] {
        let [a, b] = [&own, &by_height].map(|found| found["closure"]["before"][key].as_f64());
        assert!((a.unwrap() - b.unwrap()).abs() < 1e-9, "{key}: {a:?} {b:?}");
    }

    // A sole that is 20 mm lower than the other foot's does not lie on one floor with it.
    let low = found(
        &format!("{bare} --other-foot l_ank_roll_link@53.5mm"),
        &without,
    );
    let height = low["closure"]["before"]["height_m"].as_f64().unwrap();
    assert!((0.015..0.025).contains(&height.abs()), "{}", low["closure"]);
}

#[test]
fn inspect_names_the_sole_where_shapes_reach_below_the_frame() {
    let folder = Folder::with("op2");
    let shape = "<link name=\"r_sole\"><collision><origin xyz='0 0 0.01'/><geometry>\
        <box size='0.1 0.06 0.05'/></geometry></collision></link>";
    let urdf = folder.read("op2.urdf");
    let with_shape = urdf.replace("<link name=\"r_sole\"/>", shape);
    assert!(with_shape.contains(shape));
    folder.write("op2.urdf", with_shape);
    let notes = |support: &str| {
        let found = folder.json(&format!("inspect op2.urdf --support {support}"));
        found["notes"].to_string()
    };
    let said = notes("r_sole");
    assert!(said.contains("reaches 15.0 mm below"), "{said}");
    assert!(said.contains("its support link is `r_sole@15mm`"), "{said}");
    // A sole of its own is not asked for another one.
    assert_eq!(notes("r_sole@15mm"), notes("l_sole"));
}
