//! A support that is given by a link and the height of its frame over the sole.

use std::fs;

use serde_json::Value;
use sesc_test_support::command::{folder, op2, refused, sesc, stdout, write};
use sesc_test_support::feet::TwoFeet;
use sesc_test_support::stage::{Platform, Stage};

/// 33.5 mm below the frame of the link: by name, and as a link of the URDF.
const BY_HEIGHT: &str = "r_ank_roll_link@33.5mm";
const AS_LINK: &str = "below";
const LINES: &str = "<link name='below'/><joint name='to_below' type='fixed'>\
    <parent link='r_ank_roll_link'/><child link='below'/><origin xyz='0 0 -0.0335'/></joint>";

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&stdout(&sesc(arguments))).unwrap()
}

#[test]
fn every_command_takes_the_sole_of_a_link_as_a_link_in_the_sole() {
    let folder = folder();
    let with_link = fs::read_to_string(op2()).unwrap();
    let with_link = with_link.replace("</robot>", &format!("{LINES}</robot>"));
    let with_link = write(folder.path(), "with_link.urdf", &with_link);
    let own = op2();
    let robots = [(own.as_str(), BY_HEIGHT), (with_link.as_str(), AS_LINK)];
    let [by_height, as_link] = robots.map(|(urdf, support)| {
        let [log, model] = ["log.csv", "model.toml"].map(|name| {
            let path = folder.path().join(format!("{support}_{name}"));
            path.to_str().unwrap().to_string()
        });
        let on = ["--support", support];
        let command = |words: &[&str]| json(&[words, &on, &["--json"]].concat());
        let of_log = ["--data", log.as_str()];
        let simulated = [
            "simulate", urdf, "--poses", "60", "--seed", "4", "--noise", "0.0005",
        ];
        let hidden = ["--hide", "joint_offset:r_knee=2deg", "--out", log.as_str()];
        command(&[&simulated[..], &hidden].concat());
        // The sidecar names the support, and it alone does.
        let words = [
            &["fit", urdf, "--json", "--out", model.as_str()][..],
            &of_log,
        ]
        .concat();
        let fit = json(&words);
        let values = fit["parameters"].as_array().unwrap().iter();
        let values: Vec<f64> = values.map(|p| p["value"].as_f64().unwrap()).collect();
        let found = command(&[&["diagnose", urdf][..], &of_log].concat());
        let predicted =
            command(&[&["predict", urdf, "--model", model.as_str()][..], &of_log].concat());
        let verified = command(&[
            "verify",
            urdf,
            "--samples",
            "100",
            "--model",
            model.as_str(),
        ]);
        assert_eq!(verified["pass"], true);
        let readings = fs::read_to_string(&log).unwrap();
        (
            readings,
            values,
            found["sentence"].clone(),
            predicted["com_m"].clone(),
        )
    });
    assert_eq!(by_height, as_link);
    assert!(
        by_height.2.as_str().unwrap().contains("r_knee"),
        "{}",
        by_height.2
    );
}

#[test]
fn a_height_is_refused_where_it_cannot_be_one() {
    let folder = folder();
    let op2 = op2();
    let log = folder.path().join("log.csv");
    let log = log.to_str().unwrap();
    let words = [
        "simulate",
        &op2,
        "--poses",
        "5",
        "--support",
        BY_HEIGHT,
        "--out",
        log,
    ];
    stdout(&sesc(&words));
    let on = |words: &[&str], said: &[&str]| {
        refused(
            &sesc(&[&["inspect", op2.as_str()][..], words].concat()),
            said,
        );
    };
    on(
        &["--support", "r_foot@33mm"],
        &["no link `r_foot` to stand on"],
    );
    on(&["--support", "r_sole@0.50mm"], &["such as `r_sole@0.5mm`"]);
    let low = ["--support", "r_sole", "--sole-height"];
    on(&[&low[..], &["33.5"]].concat(), &["0.0335 for 33.5 mm"]);
    on(&[&low[..], &["nan"]].concat(), &["give a number of metres"]);
    on(
        &["--sole-height", "0.03"],
        &["name the link that has this sole by --support"],
    );
    // The other sole is given in the same way.
    let both = ["fit", &op2, "--data", log, "--support", BY_HEIGHT];
    let other = |name: &str| sesc(&[&both[..], &["--other-foot", name]].concat());
    refused(
        &other("l_ank_roll_link@3.0mm"),
        &["is no sole of a link", "`l_ank_roll_link@3mm`"],
    );
    refused(
        &other("l_ank_rol_link@3mm"),
        &["`l_ank_rol_link` is no link", "did you mean"],
    );
}

/// The OP2 without its links in the soles, on both feet: plans put both soles on the floor, and
/// the knee that is off is found as with these links.
#[test]
fn a_robot_without_links_in_its_soles_stands_on_both_feet() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let [poses, log] = ["poses.csv", "log.csv"].map(at);
    let mut bare = fs::read_to_string(op2()).unwrap();
    for side in ["l", "r"] {
        let begin = bare
            .find(&format!("<joint name=\"{side}_sole_fixed\""))
            .unwrap();
        let link = format!("<link name=\"{side}_sole\"/>");
        let end = bare.find(&link).unwrap() + link.len();
        bare.replace_range(begin..end, "");
    }
    let bare = write(folder.path(), "bare.urdf", &bare);
    let on = ["--support", "r_ank_roll_link", "--sole-height", "0.0335"];
    let plan = ["plan", &bare, "--both-feet", "--poses", "30"];
    let out = ["--candidates", "60", "--out", &poses, "--json"];
    let planned = json(&[&plan[..], &on, &out].concat());
    assert_eq!(planned["both_feet"]["other_foot"], "l_ank_roll_link@33.5mm");

    let stage = Stage::new(Platform::Op2);
    let feet = TwoFeet::new(&stage);
    let world = stage.world().joint_offset("l_knee", 0.026).unwrap();
    let text = fs::read_to_string(&poses).unwrap();
    let mut rows = text.lines();
    let mut logs = [0, 1].map(|_| format!("{},cop_x,cop_y\n", text.lines().next().unwrap()));
    rows.next();
    for row in rows {
        let joints: Vec<f64> = row.split(',').skip(1).map(|x| x.parse().unwrap()).collect();
        // The file has its angles to a microradian or so.
        let off = feet.lies(&joints).amax();
        assert!(off < 1e-5, "{off:e}");
        let q = TwoFeet::encoders(&world, &joints);
        let cop = world.cop(&q);
        let q: Vec<String> = q.iter().map(|x| format!("{x:.7}")).collect();
        let pose = row.split(',').next().unwrap();
        // The link in the right sole is 10.5 mm to the right of the ankle.
        for (log, y) in logs.iter_mut().zip([cop[1], cop[1] - 0.0105]) {
            *log += &format!("{pose},{},{:.6},{y:.6}\n", q.join(","), cop[0]);
        }
    }
    let [with, without] = logs;
    let found = |urdf: &str, text: &str, more: &[&str]| {
        fs::write(&log, text).unwrap();
        let words = [
            "diagnose", urdf, "--data", &log, "--noise", "0.003", "--json",
        ];
        json(&[&words[..], more].concat())
    };
    let own = found(&op2(), &with, &["--support", "r_sole", "--both-feet"]);
    let by_height = found(&bare, &without, &[&on[..], &["--both-feet"]].concat());
    let named = ["--other-foot", "l_ank_roll_link@33.5mm"];
    let by_name = found(&bare, &without, &[&on[..], &named].concat());
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
    let low = ["--other-foot", "l_ank_roll_link@53.5mm"];
    let low = found(&bare, &without, &[&on[..], &low].concat());
    let height = low["closure"]["before"]["height_m"].as_f64().unwrap();
    assert!((0.015..0.025).contains(&height.abs()), "{}", low["closure"]);
}

#[test]
fn inspect_names_the_sole_where_shapes_reach_below_the_frame() {
    let folder = folder();
    let with_shape = fs::read_to_string(op2()).unwrap();
    let shape = "<link name=\"r_sole\"><collision><origin xyz='0 0 0.01'/><geometry>\
        <box size='0.1 0.06 0.05'/></geometry></collision></link>";
    let with_shape = with_shape.replace("<link name=\"r_sole\"/>", shape);
    assert!(with_shape.contains(shape));
    let with_shape = write(folder.path(), "with_shape.urdf", &with_shape);
    let notes = |support: &str| {
        json(&["inspect", &with_shape, "--support", support, "--json"])["notes"].to_string()
    };
    let said = notes("r_sole");
    assert!(
        said.contains("reaches 15.0 mm below")
            && said.contains("its support link is `r_sole@15mm`"),
        "{said}"
    );
    // A sole of its own is not asked for another one.
    assert_eq!(notes("r_sole@15mm"), notes("l_sole"));
}
