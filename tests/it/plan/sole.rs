//! The region of planned CoPs comes from the sole that the URDF has.

use sesc_test_support::command::{Folder, list, number, refused, says, stderr};
use sesc_test_support::trees::Urdf;

/// A pole on a foot of 0.2 m by 0.1 m; `collision` is the shape of the foot.
fn pole(collision: &str) -> String {
    Urdf::new("pole")
        .link_with("foot", 1.0, "0 0 0.02", collision)
        .link("shin", 1.0, "0 0 0.1")
        .link("top", 1.0, "0 0 0.2")
        .revolute("roll", ["foot", "shin"], "0 0 0.1", "1 0 0", 1.0)
        .revolute("pitch", ["shin", "top"], "0 0 0.1", "0 1 0", 1.0)
        .text()
}

/// Unless somebody says, the CoP stays in the inner part of the sole that the URDF has.
#[test]
fn the_sole_of_the_urdf_is_where_the_cop_stays() {
    let folder = Folder::empty();
    let plan = "plan pole.urdf --support foot --poses 5 --candidates 60 --sigmas 0 --out poses.csv";
    let planned = |urdf: String, more: &str| {
        folder.write("pole.urdf", urdf);
        folder.json(&format!("{plan} {more}"))
    };
    let shape = "<collision><origin xyz='0.03 0 0.01'/><geometry><box size='0.2 0.1 0.02'/>\
                 </geometry></collision>";
    let of_shape = planned(pole(shape), "");
    let corners = list(&of_shape, "/corners").iter();
    let mut x: Vec<f64> = corners.map(|corner| number(corner, "/0")).collect();
    x.sort_by(f64::total_cmp);
    let near = |x: f64, y: f64| (x - y).abs() < 1e-12;
    assert!(near(x[0], -0.07) && near(x[3], 0.13), "{x:?}");
    // 0.7 of the way from its middle to the edge of its narrower side.
    assert!(near(number(&of_shape, "/margin"), 0.015));
    for cop in list(&of_shape, "/cop") {
        let [x, y] = ["/0", "/1"].map(|axis| number(cop, axis));
        let inside = (x - 0.03).abs() < 0.085 + 1e-9 && y.abs() < 0.035 + 1e-9;
        assert!(inside, "{x} {y}");
    }
    let said = |plan: &serde_json::Value| plan["cop_region"].as_str().unwrap().to_string();
    assert!(said(&of_shape).ends_with("by the collision shapes of the support"));
    let given = planned(pole(shape), "--cop-box 0.02");
    assert_eq!(said(&given), "|x|, |y| <= 20.0 mm");
    // A box of 0.2 m by 0.1 m by 0.02 m and 1 kg: 0.7 of half its narrower side.
    let inertia = "<inertia ixx='0.000866667' iyy='0.003366667' izz='0.004166667' ixy='0' ixz='0' \
                   iyz='0'/>";
    let foot = "<inertial><origin xyz='0 0 0.02'/><mass value='1'/>";
    let urdf = pole("").replacen(foot, &format!("{foot}{inertia}"), 1);
    assert!(urdf.contains(inertia), "{urdf}");
    let by_inertia = "|x|, |y| <= 35.0 mm, by the inertia of the support, which has no shape";
    assert_eq!(said(&planned(urdf, "")), by_inertia);
    // Without either nothing tells how large the sole is.
    folder.write("pole.urdf", pole(""));
    folder.refuses(plan, &["of `foot`", "--cop-box (such as 0.0", "--sole"]);
}

/// An arm on its pedestal is planned as it is; one foot of four is told a size that would do.
#[test]
fn a_plan_that_fails_says_a_box_that_would_do() {
    let arm = Folder::with("arm6");
    let said = arm.stdout("plan arm6.urdf --support pedestal --poses 20 --out poses.csv");
    says(said, &["|x|, |y| <= 67.0 mm, by the inertia"]);
    let folder = Folder::with("quadruped");
    let plan = "plan quadruped.urdf --support lf_foot --poses 20 --out poses.csv";
    let output = folder.run(plan);
    let words = ["lets a tenth of them balance", "the robot has 4 feet"];
    refused(&output, &words);
    let said = stderr(&output);
    let (_, size) = said.split_once("--cop-box (").unwrap();
    let size = size.split(' ').next().unwrap();
    folder.stdout(&format!("{plan} --cop-box {size}"));
}

/// Two point feet of four have no soles that could lie flat: that is said, with the remedy, and
/// two that have soles are told what they can do.
#[test]
fn both_feet_of_a_robot_with_four_need_soles() {
    let folder = Folder::with("quadruped");
    let log = "--poses 60 --noise 0.0005 --out log.csv";
    folder.stdout(&format!("simulate quadruped.urdf --support lf_foot {log}"));
    let why = [
        "`lf_foot` and `rf_foot`",
        "2 of the robot's 4 feet",
        "no roll and no pitch",
        "`lf_foot_sole`",
    ];
    for command in [
        "fit quadruped.urdf --data log.csv",
        "diagnose quadruped.urdf --data log.csv",
        "plan quadruped.urdf --support lf_foot --cop-box 0.05 --poses 5 --out poses.csv",
    ] {
        let line = format!("{command} --both-feet --other-foot rf_foot");
        folder.refuses(&line, &why);
    }
    // The sidecar's word is no other.
    let sidecar = folder.read("log.csv.toml");
    let said = format!("both_feet = true\nother_foot = \"rf_foot\"\n{sidecar}");
    folder.write("log.csv.toml", said);
    folder.refuses("diagnose quadruped.urdf --data log.csv", &why);
    // Feet whose links say that they are soles.
    let text = folder.read("quadruped.urdf");
    folder.write("flat.urdf", text.replace("_foot\"", "_sole\""));
    folder.stdout(&format!("simulate flat.urdf --support lf_sole {log}"));
    for command in ["fit", "diagnose"] {
        let line = format!("{command} flat.urdf --data log.csv --both-feet --other-foot rf_sole");
        let soles = "`lf_sole` and `rf_sole`";
        let words = [soles, "the robot has 4 feet", "cannot be used"];
        says(stderr(&folder.run(&line)), &words);
    }
}
