//! The region of planned CoPs comes from the sole that the URDF has.

use sesc_test_support::command::{ROOT, folder, refused, sesc, stdout, write};

/// A pole on a foot of 0.2 m by 0.1 m; `collision` is the shape of the foot.
fn pole(collision: &str) -> String {
    let inertial =
        |z: f64| format!("<inertial><origin xyz='0 0 {z}'/><mass value='1'/></inertial>");
    let joint = |name: &str, parent: &str, child: &str, axis: &str| {
        format!(
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/>\
             <origin xyz='0 0 0.1'/><axis xyz='{axis}'/><limit lower='-1' upper='1'/></joint>"
        )
    };
    format!(
        "<robot name='pole'><link name='foot'>{}{collision}</link><link name='shin'>{}</link>\
         <link name='top'>{}</link>{}{}</robot>",
        inertial(0.02),
        inertial(0.1),
        inertial(0.2),
        joint("roll", "foot", "shin", "1 0 0"),
        joint("pitch", "shin", "top", "0 1 0")
    )
}

/// Unless somebody says, the CoP stays in the inner part of the sole that the URDF has.
#[test]
fn the_sole_of_the_urdf_is_where_the_cop_stays() {
    let folder = folder();
    let out = folder.path().join("poses.csv").display().to_string();
    let on_foot = |urdf: String, more: &[&str]| {
        let urdf = write(folder.path(), "pole.urdf", urdf);
        let line = ["plan", &urdf, "--support", "foot", "--poses", "5"];
        let rest = ["--candidates", "60", "--sigmas", "0", "--out", &out];
        sesc(&[&line[..], &rest, more].concat())
    };
    let planned = |urdf: String, more: &[&str]| -> serde_json::Value {
        let output = on_foot(urdf, &[&["--json"], more].concat());
        serde_json::from_str(&stdout(&output)).unwrap()
    };
    let plan = |collision: &str, more: &[&str]| planned(pole(collision), more);
    let shape = "<collision><origin xyz='0.03 0 0.01'/><geometry><box size='0.2 0.1 0.02'/>\
                 </geometry></collision>";
    let of_shape = plan(shape, &[]);
    let corners = of_shape["corners"].as_array().unwrap();
    let mut x: Vec<f64> = corners.iter().map(|c| c[0].as_f64().unwrap()).collect();
    x.sort_by(f64::total_cmp);
    assert!(
        (x[0] + 0.07).abs() < 1e-12 && (x[3] - 0.13).abs() < 1e-12,
        "{x:?}"
    );
    // 0.7 of the way from its middle to the edge of its narrower side.
    assert!((of_shape["margin"].as_f64().unwrap() - 0.015).abs() < 1e-12);
    for cop in of_shape["cop"].as_array().unwrap() {
        let [x, y] = [0, 1].map(|axis| cop[axis].as_f64().unwrap());
        assert!(
            (x - 0.03).abs() < 0.085 + 1e-9 && y.abs() < 0.035 + 1e-9,
            "{x} {y}"
        );
    }
    let said = |plan: &serde_json::Value| plan["cop_region"].as_str().unwrap().to_string();
    assert!(said(&of_shape).ends_with("by the collision shapes of the support"));
    // A box of 0.2 m by 0.1 m by 0.02 m and 1 kg: 0.7 of half its narrower side.
    let foot = "<inertial><origin xyz='0 0 0.02'/><mass value='1'/>";
    let inertia = "<inertia ixx='0.000866667' iyy='0.003366667' izz='0.004166667' ixy='0' ixz='0' \
                   iyz='0'/>";
    let solid = |inertia: &str| pole("").replacen("<mass value='1'/>", inertia, 1);
    let urdf = solid(&format!("<mass value='1'/>{inertia}"));
    assert!(urdf.contains(&format!("{foot}{inertia}")), "{urdf}");
    assert_eq!(
        said(&planned(urdf, &[])),
        "|x|, |y| <= 35.0 mm, by the inertia of the support, which has no shape"
    );
    // Without either nothing tells how large the sole is.
    refused(
        &on_foot(pole(""), &[]),
        &["of `foot`", "--cop-box (such as 0.0", "--sole"],
    );
    assert_eq!(
        said(&plan(shape, &["--cop-box", "0.02"])),
        "|x|, |y| <= 20.0 mm"
    );
}

/// An arm on its pedestal is planned as it is; one foot of four is told a size that would do.
#[test]
fn a_plan_that_fails_says_a_box_that_would_do() {
    let folder = folder();
    let out = folder.path().join("poses.csv").display().to_string();
    let plan = |robot: &str, support: &str, more: &[&str]| {
        let urdf = format!("{ROOT}/robots/{robot}/{robot}.urdf");
        let on = ["--support", support, "--poses", "20", "--out", &out];
        sesc(&[&["plan", &urdf][..], &on, more].concat())
    };
    let said = stdout(&plan("arm6", "pedestal", &[]));
    assert!(
        said.contains("|x|, |y| <= 67.0 mm, by the inertia"),
        "{said}"
    );
    let output = plan("quadruped", "lf_foot", &[]);
    let words = ["lets a tenth of them balance", "the robot has 4 feet"];
    refused(&output, &words);
    let said = String::from_utf8(output.stderr).unwrap();
    let (_, size) = said.split_once("--cop-box (").unwrap();
    let size = size.split(' ').next().unwrap();
    stdout(&plan("quadruped", "lf_foot", &["--cop-box", size]));
}

/// Two point feet of four have no soles that could lie flat: that is said, with the remedy, and
/// two that have soles are told what they can do.
#[test]
fn both_feet_of_a_robot_with_four_need_soles() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let log = at("log.csv");
    let points = format!("{ROOT}/robots/quadruped/quadruped.urdf");
    let simulate = ["simulate", &points, "--support", "lf_foot", "--poses", "60"];
    stdout(&sesc(
        &[&simulate[..], &["--noise", "0.0005", "--out", &log]].concat(),
    ));
    let other = |name| ["--both-feet", "--other-foot", name];
    let why = [
        "`lf_foot` and `rf_foot`",
        "2 of the robot's 4 feet",
        "no roll and no pitch",
        "`lf_foot_sole`",
    ];
    for command in ["fit", "diagnose"] {
        let line = [command, &points, "--data", &log];
        refused(&sesc(&[&line[..], &other("rf_foot")].concat()), &why);
    }
    let poses = ["--poses", "5", "--out", &at("poses.csv")];
    let line = ["plan", &points, "--support", "lf_foot", "--cop-box", "0.05"];
    refused(
        &sesc(&[&line[..], &other("rf_foot"), &poses].concat()),
        &why,
    );
    // The sidecar's word is no other.
    let sidecar = std::fs::read_to_string(format!("{log}.toml")).unwrap();
    let said = format!("both_feet = true\nother_foot = \"rf_foot\"\n{sidecar}");
    write(folder.path(), "log.csv.toml", said);
    refused(&sesc(&["diagnose", &points, "--data", &log]), &why);
    write(folder.path(), "log.csv.toml", sidecar);
    // Feet whose links say that they are soles.
    let text = std::fs::read_to_string(&points).unwrap();
    let flat = write(
        folder.path(),
        "flat.urdf",
        text.replace("_foot\"", "_sole\""),
    );
    let simulate = ["simulate", &flat, "--support", "lf_sole", "--poses", "60"];
    let log = at("flat.csv");
    stdout(&sesc(
        &[&simulate[..], &["--noise", "0.0005", "--out", &log]].concat(),
    ));
    for command in ["fit", "diagnose"] {
        let line = [command, &flat, "--data", &log];
        let output = sesc(&[&line[..], &other("rf_sole")].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        for words in [
            "`lf_sole` and `rf_sole`",
            "the robot has 4 feet",
            "cannot be used",
        ] {
            assert!(said.contains(words), "{command}: {said}");
        }
    }
}
