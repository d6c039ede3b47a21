//! Files, robots and recordings as other people and programs have them, each with what is right.
//!
//! `tests/strangers/` has the inputs: `post.urdf` is a post on one leg of four joints, `wraps.urdf`
//! the same with a waist that turns without end.

use std::fs;

use serde_json::Value;
use sesc_test_support::command::{Folder, ROOT, json, list, number, op2, says, stderr, texts};
use sesc_test_support::trees::Urdf;

/// A folder with the files of a case and the robots that several share.
fn case(name: &str) -> Folder {
    let folder = Folder::with("op2");
    let inputs = format!("{ROOT}/tests/strangers");
    for from in [inputs.clone(), format!("{inputs}/{name}")] {
        for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
            if entry.path().is_file() {
                let name = entry.file_name().into_string().unwrap();
                folder.write(&name, fs::read(entry.path()).unwrap());
            }
        }
    }
    folder
}

/// Nothing is missing, and what is left is the noise of half a millimetre.
fn is_healthy(answer: &Value) {
    assert_eq!(answer["verdict"], "none", "{answer}");
    let left = number(answer, "/final/rmse");
    assert!((4e-4..6e-4).contains(&left), "{left}");
}

#[test]
fn headers_of_other_programs_are_read_or_told() {
    let folder = case("headers_of_other_programs");
    for log in [
        "comments.csv",
        "excel_sep.csv",
        "units_in_names.csv",
        "units_row.csv",
    ] {
        let found = folder.json(&format!("fit post.urdf --data {log}"));
        assert_eq!(found["postures"], 10, "{log}");
    }
    folder.refuses_each(
        r#"fit post.urdf --data suffix.csv | suffix.csv:1: no column for joint `ankle` | columns = { "ankle_pos" = "ankle", "roll_pos" = "roll"
        fit post.urdf --data plotjuggler.csv | columns = { "/joint_states/ankle/position" = "ankle"
        fit post.urdf --data blanks.txt | blanks.txt:1: | divided by blanks; write commas"#,
    );
    // The line that is proposed does it.
    let log = "pose,ankle_pos,roll_pos,waist_pos,shoulder_pos,cop_x,cop_y,ankle_vel\n\
               0,0.1,0,0,0,0.01,0,1\n1,0,0.1,0,0,0.01,0,1\n";
    folder.write("named.csv", log);
    let asked = stderr(&folder.run("fit post.urdf --support sole --data named.csv"));
    let line = &asked[asked.find("columns = {").unwrap()..];
    folder.write("named.csv.toml", line.trim());
    let found = folder.json("fit post.urdf --support sole --data named.csv");
    assert_eq!(found["postures"], 2);
    // A first line of numbers is not taken for names.
    folder.write("bare.csv", "0.1,0.2,0.3\n0.4,0.5,0.6\n");
    folder.refuses_each(
        "fit post.urdf --support sole --data bare.csv
            | bare.csv:1: the first line has numbers, not the names of columns",
    );
    // Units are brought to SI: the same log in degrees, milliseconds and millimetres.
    let si = folder.json("fit post.urdf --data units_in_names.csv");
    let mut scaled = folder.sheet("units_in_names.csv");
    for name in scaled.names.clone() {
        let factor = match &name {
            name if name.ends_with("[rad]") => 180.0 / std::f64::consts::PI,
            name if name.ends_with("[m]") => 1000.0,
            _ => continue,
        };
        for (row, x) in scaled.numbers(&[&name]).concat().iter().enumerate() {
            scaled.set(&name, Some(row), &(factor * x).to_string());
        }
    }
    let text = scaled.to_string().replace("[rad]", "[deg]");
    folder.write("scaled.csv", text.replace("[m]", "[mm]"));
    folder.write("scaled.csv.toml", folder.read("units_in_names.csv.toml"));
    let other = folder.json("fit post.urdf --data scaled.csv");
    for k in 0..5 {
        let path = format!("/parameters/{k}/value");
        let (a, b) = (number(&si, &path), number(&other, &path));
        assert!((a - b).abs() < 1e-9, "{path}: {a} {b}");
    }
}

#[test]
fn tables_of_numpy_have_whole_numbers_and_a_marked_header() {
    let folder = case("numpy_savetxt");
    for log in ["default.csv", "with_header.csv"] {
        let found = folder.json(&format!("fit post.urdf --data {log}"));
        assert_eq!(found["postures"], 12, "{log}");
        // 72 rows with a noise of 1 mm, told by the repeats.
        let noise = number(&found, "/noise_floor");
        assert!((7e-4..12e-4).contains(&noise), "{noise}");
    }
}

#[test]
fn parquet_of_every_writer_is_read() {
    let folder = case("parquet_group_of_no_rows");
    for log in ["log", "null_std", "none_std"] {
        let found = folder.json(&format!("fit post.urdf --data {log}.parquet"));
        assert_eq!(found["postures"], 40, "{log}");
    }
    let said = folder.said("fit post.urdf --data null_std.parquet");
    says(
        said,
        &["without a value, and not used: `cop_x_std`, `cop_y_std`"],
    );
    folder.refuses_each(
        "fit post.urdf --data empty.parquet | no postures below the header
        fit post.urdf --data encrypted.parquet | the Parquet file is encrypted; decrypt it first
        fit post.urdf --data encrypted_open_footer.parquet | the Parquet file is encrypted",
    );
}

#[test]
fn files_of_other_formats_are_told_what_they_are() {
    let folder = Folder::with("two_link");
    for (name, bytes, words) in [
        ("a.bag", &b"#ROSBAG V2.0\n"[..], "mcap convert a.bag a.mcap"),
        ("a.db3", b"SQLite format 3\0", "mcap convert a.db3 a.mcap"),
        (
            "a.mcap.zst",
            b"\x28\xb5\x2f\xfd\0\0\0\0",
            "zstd -d a.mcap.zst",
        ),
        ("a.mat", b"MATLAB 5.0 MAT-file", "writetable"),
        ("a.npy", b"\x93NUMPY\x01\0", "numpy.savetxt('a.csv'"),
        ("a.xlsx", b"PK\x03\x04\0\0\0\0", "save the sheet as CSV"),
        ("a.feather", b"ARROW1\0\0", "to_parquet('a.parquet')"),
    ] {
        folder.write(name, bytes);
        let line = format!("fit two_link.urdf --support foot --data {name}");
        folder.refuses(&line, &[words]);
    }
    folder.write("bag/metadata.yaml", "");
    folder.write("bag/bag_0.mcap", "");
    let bag = "fit two_link.urdf --support foot --data bag";
    folder.refuses(bag, &["`bag_0.mcap`"]);
}

/// A value that a message or row does not have costs that value.
#[test]
fn missing_values_cost_themselves() {
    let folder = case("nan_position");
    let log = "fit post.urdf --data one_nan_in_seven.mcap";
    let without = "190 of 1324 joint states name a joint without its position";
    says(folder.said(log), &[without]);
    assert_eq!(folder.json(log)["postures"], 24);
    let folder = case("positions_empty");
    let log = "fit post.urdf --data velocity_only_too.mcap";
    says(folder.said(log), &["662 of 1986 joint states"]);
    assert_eq!(folder.json(log)["postures"], 24);
    // In a table: one row misses a joint, one its reading, one has no number of its posture.
    let folder = case("numpy_savetxt");
    let mut holes = folder.sheet("default.csv");
    for (row, field, value) in [(1, 1, "nan"), (4, 6, ""), (7, 0, "NA")] {
        holes.rows[row][field] = value.to_string();
    }
    folder.write("holes.csv", holes.to_string());
    folder.write("holes.csv.toml", folder.read("default.csv.toml"));
    let line = "fit post.urdf --data holes.csv";
    let holes = "3 of 72 rows have no value of a column and are left out";
    says(folder.said(line), &[holes, "(the first is row 3)"]);
    assert_eq!(folder.json(line)["samples"]["rows"], 69);
}

#[test]
fn zeros_of_a_second_publisher_are_left_out() {
    let folder = case("two_publishers_zeros");
    let line = "fit post.urdf --data zeros_at_4_hz.mcap";
    let zeros = "joint states are of another sender or a glitch";
    says(folder.said(line), &[zeros, "and are left out"]);
    let found = folder.json(line);
    assert_eq!(found["postures"], 24);
    let noise = number(&found, "/noise_floor");
    assert!((4e-4..6e-4).contains(&noise), "{noise}");
}

/// A table in which one row leaps and comes back.
#[test]
fn joints_that_leap_are_a_finding() {
    let folder = case("continuous_joint_wraps");
    let mut leaps = folder.sheet("unwrapped.csv");
    leaps.set("shoulder", Some(199), "2.5");
    folder.write("leaps.csv", leaps.to_string());
    folder.write("leaps.csv.toml", folder.read("unwrapped.csv.toml"));
    let found = folder.json("diagnose wraps.urdf --data leaps.csv");
    let kinds = list(&found, "/health").iter();
    let leaps = kinds.filter(|finding| finding["kind"] == "joint_leaps");
    let targets: Vec<&Value> = leaps.map(|finding| &finding["target"]).collect();
    assert_eq!(targets, ["shoulder"], "{}", found["health"]);
    let sound = folder.json("diagnose wraps.urdf --data unwrapped.csv");
    assert_eq!(list(&sound, "/health").len(), 0);
}

#[test]
fn angles_that_wrap_are_those_that_do_not() {
    for (case_name, end) in [
        ("continuous_joint_wraps", "csv"),
        ("continuous_joint_wraps_mcap", "mcap"),
    ] {
        let folder = case(case_name);
        let [plain, wrapped] = ["unwrapped", "wrapped"]
            .map(|log| folder.json(&format!("diagnose wraps.urdf --data {log}.{end}")));
        is_healthy(&plain);
        is_healthy(&wrapped);
        for path in ["/baseline/rmse", "/noise_floor", "/motion/share/value"] {
            let (a, b) = (number(&plain, path), number(&wrapped, path));
            assert!((a - b).abs() < 1e-6 * a.abs(), "{end} {path}: {a} {b}");
        }
    }
}

#[test]
fn times_of_other_names_are_read_and_coarse_ones_told() {
    let folder = case("time_column_called_time");
    for name in [
        "time",
        "__time",
        "timestamp",
        "Time",
        "%time",
        "t [s]",
        "time_s",
    ] {
        let text = folder.read("log.csv").replacen("time", name, 1);
        folder.write("named.csv", text);
        folder.write("named.csv.toml", folder.read("log.csv.toml"));
        is_healthy(&folder.json("diagnose post.urdf --data named.csv"));
    }
    let text = folder.read("log.csv").replacen("time", "number", 1);
    folder.write("none.csv", text);
    folder.write("none.csv.toml", folder.read("log.csv.toml"));
    let none = folder.said("diagnose post.urdf --data none.csv");
    says(none, &["the log has no column `t`: motion is not counted"]);
    let coarse = case("time_is_coarse").said("diagnose post.urdf --data tenths.csv");
    let few = "`t` has too few digits, and motion is not counted";
    says(coarse, &["share the stamp of the row above", few]);
}

#[test]
fn frames_of_recordings_are_settled_for_every_command() {
    let folder = case("frame_id_is_support");
    let fit = folder.json("fit post.urdf --data log.mcap");
    assert_eq!(fit["support"], "sole");
    let found = folder.json("diagnose post.urdf --data log.mcap");
    assert_eq!(found["verdict"], "none");
    // A CoM 0.48 m above the sole, as the frame says; above the trunk it would be elsewhere.
    let predicted = folder.json("predict post.urdf --data log.mcap");
    let height = number(&predicted, "/com_m/0/2");
    assert!((0.4..0.5).contains(&height), "{height}");
    let folder = case("unknown_frame_id");
    for command in ["fit", "diagnose"] {
        let said = folder.said(&format!("{command} post.urdf --data log.mcap"));
        let frame = "the frame `ankle_ft_sensor`, which the URDF does not have";
        says(said, &[frame, "origin of `sole`"]);
    }
    // With the frame in the URDF, 20 mm in front of the sole, the wrench is moved: nothing is off.
    let sensor = "<link name='ankle_ft_sensor'/><joint name='to_sensor' type='fixed'><parent \
                  link='sole'/><child link='ankle_ft_sensor'/><origin xyz='0.02 0 0'/></joint></robot>";
    let urdf = folder.read("post.urdf").replace("</robot>", sensor);
    folder.write("sensor.urdf", urdf);
    let found = folder.json("diagnose sensor.urdf --data log.mcap");
    assert_eq!(found["verdict"], "none", "{}", found["sentence"]);
}

#[test]
fn gains_and_units_are_named_over_their_range() {
    let folder = case("gain_of_three");
    for gain in [2.3, 3.0] {
        let found = folder.json(&format!("diagnose post.urdf --data gain_{gain}.csv"));
        assert_eq!(found["verdict"], "named", "{}", found["sentence"]);
        assert_eq!(found["steps"][0]["effect"], "sensor_gain");
        for axis in ["gain_x", "gain_y"] {
            let value = number(&found, &format!("/steps/0/parameters/{axis}/value"));
            assert!((value / gain - 1.0).abs() < 0.01, "{value}");
        }
    }
    let folder = case("kgf_with_newton_metres");
    let found = folder.json("diagnose op2.urdf --data log.csv");
    assert_ne!(found["verdict"], "none");
    let step = &found["steps"][0];
    assert_eq!([&step["effect"], &step["target"]], ["units", "-"]);
    let units = "forces in kgf and moments in N m";
    says(found["sentence"].to_string(), &[units]);
}

/// Inertias that no body has are not believed: a healthy robot that moves is healthy.
#[test]
fn placeholder_inertias_blame_no_joint() {
    let folder = case("placeholder_inertia");
    for urdf in ["post", "inertia_0.1", "inertia_1.0"] {
        let line = format!("diagnose {urdf}.urdf --support sole --data log.csv");
        is_healthy(&folder.json(&line));
    }
    is_healthy(&folder.json("diagnose op2_0.001.urdf --support r_sole --data op2.csv.gz"));
    let one = folder.said("inspect inertia_1.0.urdf --support sole");
    says(
        one,
        &["link `foot`: its inertia has a radius of gyration of 1.00 m"],
    );
    let many = folder.said("inspect op2_0.001.urdf --support r_sole");
    let placeholder = "a placeholder; motion counts the link as a point; also";
    says(many, &["21 of this kind", placeholder]);
    let sound = folder.said(&format!("inspect {} --support r_sole", op2()));
    assert!(!sound.contains("inertia"), "{sound}");
    for ([xx, yy, zz], words) in [
        ([-1, 1, 1], "has a negative principal moment"),
        ([1, 1, 3], "more than the sum of the other two"),
    ] {
        let inertia = format!(
            "<inertial><mass value='9'/><inertia ixx='{xx}' iyy='{yy}' izz='{zz}' ixy='0' ixz='0' \
             iyz='0'/></inertial>"
        );
        let robot = Urdf::new("r").raw(&format!("<link name='a'>{inertia}</link>"));
        let robot = robot.link("b", 0.001, "0 0 0");
        let robot = robot.joint("j", "continuous", ["a", "b"], "<origin xyz='0 0 9'/>");
        folder.write("odd.urdf", robot.text());
        let said = folder.said("inspect odd.urdf --support a");
        says(said, &[words, "is it in grams?"]);
    }
}

#[test]
fn a_support_whose_z_is_not_up_is_said_by_every_command() {
    let folder = case("support_z_not_up");
    let z = &[
        "241 mm along x",
        "does x point up?",
        "<origin xyz=\"-0.03 0 0\" rpy=\"0 1.5707963267948966 0\"/>",
    ];
    for line in [
        "inspect robot.urdf --support foot",
        "generate robot.urdf --support foot --lang c --name x --out x",
        "simulate robot.urdf --support foot --poses 9 --out s.csv",
        "verify robot.urdf --support foot",
        "predict robot.urdf --support foot --data log.csv",
    ] {
        let said = folder.said(line);
        says(&said, z);
        assert!(!said.contains("foot@50mm"), "{said}");
    }
    for support in ["foot", "foot@50mm"] {
        for command in ["fit", "diagnose"] {
            let line = format!("{command} robot.urdf --support {support} --data log.csv");
            let found = folder.json_of(1, &line);
            assert_eq!(found["health"][0]["kind"], "frame_turned", "{line}");
            says(found["health"][0].to_string(), &["its x axis points up"]);
        }
    }
    // The lines that are proposed are those of the robot that made the log.
    let said = folder.said("inspect robot.urdf --support foot");
    let start = said.find("<link name=\"foot_sole\"/>").unwrap();
    let end = said.find("</joint>").unwrap() + "</joint>".len();
    let lines = format!("{}</robot>", &said[start..end]);
    let urdf = folder.read("robot.urdf").replace("</robot>", &lines);
    folder.write("mended.urdf", urdf);
    is_healthy(&folder.json("diagnose mended.urdf --support foot_sole --data log.csv"));
}

#[test]
fn rotations_of_what_has_no_mass_are_not_noted() {
    let folder = case("notes_on_massless_frames");
    assert_eq!(folder.said("inspect robot.urdf --support sole"), "");
}

/// Five rows of a robot whose ankle is off by 1.2° tell nothing.
#[test]
fn a_log_that_is_too_short_is_no_clean_bill_of_health() {
    let folder = Folder::with("plain_humanoid");
    for poses in [5, 8, 12] {
        folder.stdout(&format!(
            "simulate plain_humanoid.urdf --support left_sole --poses {poses} --noise 0.0005 --hide \
             joint_offset:left_ankle_pitch=1.2deg --seed 3 --out log.csv"
        ));
        // Nothing states the noise.
        let mut log = folder.sheet("log.csv");
        log.keep(|name| !name.ends_with("_std"));
        folder.write("log.csv", log.to_string());
        let found = folder.json("diagnose plain_humanoid.urdf --data log.csv");
        assert_eq!(found["verdict"], "too_short", "{}", found["sentence"]);
        assert_eq!(list(&found, "/steps").len(), 0);
        let text = folder.stdout("diagnose plain_humanoid.urdf --data log.csv");
        assert!(!text.contains("Keep this log"), "{text}");
        says(found["sentence"].to_string(), &["The log is too short"]);
    }
}

/// A trunk on one leg, carried through `world` by joints that no robot has encoders of.
const VIRTUAL_BASE: &str = r#"<robot name="vb">
  <link name="world"/><link name="b1"/><link name="b2"/>
  <link name="trunk"><inertial><origin xyz="0 0 0.1"/><mass value="3"/><inertia ixx="1e-2" iyy="1e-2" izz="1e-2" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="foot"><inertial><origin xyz="0.01 0 0.01"/><mass value="1"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="base_x" type="prismatic"><parent link="world"/><child link="b1"/><axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="0" velocity="9"/></joint>
  <joint name="base_z" type="prismatic"><parent link="b1"/><child link="b2"/><axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="0" velocity="9"/></joint>
  <joint name="base_pitch" type="continuous"><parent link="b2"/><child link="trunk"/><axis xyz="0 1 0"/></joint>
  <joint name="hip" type="revolute"><parent link="trunk"/><child link="foot"/><origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint>
</robot>
"#;

#[test]
fn a_virtual_base_needs_no_column_and_makes_no_argument() {
    let folder = Folder::with("op2");
    folder.write("robot.urdf", VIRTUAL_BASE);
    folder.write("poses.csv", "pose,hip\n0,0.2\n1,-0.3\n");
    let on = "robot.urdf --support foot";
    // Of the trunk alone: 0.75 (0.1 + 0.4) along the leg, and a quarter of the foot's CoM.
    let found = folder.json(&format!("predict {on} --data poses.csv"));
    for (k, hip) in [0.2_f64, -0.3].into_iter().enumerate() {
        let [x, z] = [0, 2].map(|axis| number(&found, &format!("/com_m/{k}/{axis}")));
        assert!((x - 0.0025 + 0.375 * hip.sin()).abs() < 1e-12, "{x}");
        assert!((z - 0.0025 - 0.375 * hip.cos()).abs() < 1e-12, "{z}");
    }
    let dropped = "`base_x`, `base_z`, `base_pitch` dropped: nothing beyond them has mass";
    says(folder.said(&format!("inspect {on}")), &[dropped]);
    assert_eq!(folder.json(&format!("inspect {on}"))["dof"], 1);
    let verified = folder.json(&format!("verify {on} --samples 100"));
    assert_eq!(verified["pass"], true);
    folder.said(&format!("generate {on} --lang c --name vb --out src"));
    says(folder.read("src/vb.h"), &["vb_DOF 1"]);
    let log = "--poses 60 --noise 0.0005 --seed 1 --out log.csv";
    folder.said(&format!("simulate {on} {log}"));
    let log = folder.sheet("log.csv");
    assert_eq!(log.names[..3], ["pose", "hip", "cop_x"]);
    let read = |robot: &str| {
        let fit = folder.json(&format!("fit {robot} --data log.csv"));
        assert_eq!(fit["postures"], 60);
        let found = folder.json(&format!("diagnose {robot} --data log.csv"));
        assert_eq!(found["verdict"], "none");
    };
    // The support by option, by sidecar, by a column.
    folder.write("log.csv.toml", "");
    read(on);
    folder.write("log.csv.toml", "support = \"foot\"\n");
    read("robot.urdf");
    folder.write("log.csv.toml", "");
    let with = |support: &str| {
        let mut log = log.clone();
        log.add("support", |_| support.to_string());
        log
    };
    folder.write("log.csv", with("foot").to_string());
    read("robot.urdf");
    // Who stands on the base itself, as an arm on its rail, has all joints.
    assert_eq!(folder.json("inspect robot.urdf --support world")["dof"], 4);
    folder.refuses_each(
        "predict robot.urdf --support world --data poses.csv
            | no column for joint `base_x`, `base_z`, `base_pitch`",
    );
    folder.write("log.csv", with("world").to_string());
    for command in ["predict", "fit", "diagnose"] {
        let line = format!("{command} robot.urdf --data log.csv");
        folder.refuses(&line, &["no column for joint `base_x`"]);
    }
    let mut mixed = with("foot");
    mixed.rows.extend(with("world").rows);
    folder.write("log.csv", mixed.to_string());
    for command in ["predict", "fit"] {
        let line = format!("{command} robot.urdf --data log.csv");
        folder.refuses(&line, &["stand on `world`", "--support"]);
    }
    let rail = "base_x,base_z,base_pitch,hip";
    folder.write("rail.csv", format!("support,{rail}\nworld,0.5,0,0,0.2\n"));
    folder.stdout("predict robot.urdf --data rail.csv");
    folder.write("rail.csv", format!("pose,{rail}\n0,0.5,0,0,0.2\n"));
    folder.write("rail.csv.toml", "support = \"world\"\n");
    folder.stdout("predict robot.urdf --data rail.csv");
}

/// Whether the force of a log is a finding of both commands: nothing, or these words.
fn force_is(folder: &Folder, line: &str, words: Option<&str>) {
    for command in ["fit", "diagnose"] {
        let found = folder.json(&format!("{command} {line}"));
        match words {
            None => assert_eq!(list(&found, "/health").len(), 0, "{}", found["health"]),
            Some(words) => {
                assert_eq!(found["health"][0]["kind"], "force_unlike_weight");
                says(found["health"][0].to_string(), &[words]);
            }
        }
    }
}

/// A total force that is not the weight is a question with the likely cause.
#[test]
fn a_total_force_that_is_not_the_weight_is_a_finding() {
    let folder = case("kgf_with_newton_metres");
    let simulate = "simulate op2.urdf --support r_sole --poses 60 --range 20 --noise 0.0005";
    folder.said(&format!("{simulate} --out s.csv"));
    let read = sesc_reference::Robot::from_file(op2()).unwrap();
    let mass: f64 = read.links().iter().map(|link| link.mass_kg).sum();
    let weight = 9.80665 * mass;
    for (force, words) in [
        (weight, None),
        (-1.2 * weight, None),
        (mass, Some("kgf")),
        (weight / 4.4482, Some("lbf")),
        (0.5 * weight, Some("the other foot")),
        (37.0 * weight, Some("counts")),
    ] {
        let mut log = folder.sheet("s.csv");
        log.add("fz", |_| force.to_string());
        folder.write("log.csv", log.to_string());
        force_is(&folder, "op2.urdf --data log.csv --support r_sole", words);
    }
}

/// The same of foot cells and of a recording: here a robot of other masses takes the place of
/// another force.
#[test]
fn cells_and_recordings_that_do_not_carry_the_weight_are_a_finding() {
    let folder = case("frame_id_is_support");
    let urdf = folder.read("post.urdf");
    let masses = ["0.8", "1", "2", "3"];
    let weighs = |factor: f64| {
        masses.iter().fold(urdf.clone(), |text, mass| {
            let heavy = factor * mass.parse::<f64>().unwrap();
            let [own, other] = [mass.to_string(), format!("{heavy:?}")];
            let attribute = |mass: &str| format!("mass value=\"{mass}\"");
            text.replace(&attribute(&own), &attribute(&other))
        })
    };
    let simulate = "simulate post.urdf --support sole --poses 60 --range 8 --noise 0.0005";
    folder.said(&format!("{simulate} --out s.csv"));
    let weight = 7.8 * 9.80665;
    // Cells at the corners of a sheet of 0.4 m in place of the last two columns, the CoP.
    let corners = [[0.2, 0.2], [0.2, -0.2], [-0.2, -0.2], [-0.2, 0.2]];
    let mut table = folder.sheet("s.csv");
    let cop = table.cop();
    table.keep(|name| !name.starts_with("cop_"));
    for (cell, [a, b]) in corners.into_iter().enumerate() {
        let load = |[x, y]: [f64; 2]| 0.25 * weight * (1.0 + x / a) * (1.0 + y / b);
        table.add(&format!("fsr_{}", cell + 1), |k| load(cop[k]).to_string());
    }
    folder.write("cells.csv", table.to_string());
    let side = format!("support = \"sole\"\ncells = {corners:?}\n");
    folder.write("cells.csv.toml", side);
    for (factor, words) in [
        (1.0, None),
        (9.80665, Some("it is in kgf")),
        (2.0, Some("the other foot carries as much")),
    ] {
        folder.write("post.urdf", weighs(factor));
        for log in ["cells.csv", "log.mcap"] {
            force_is(&folder, &format!("post.urdf --data {log}"), words);
        }
    }
}

/// A CoP that no sole can carry, in all rows of a log.
#[test]
fn a_log_beyond_the_sole_is_a_finding() {
    let folder = case("kgf_with_newton_metres");
    let shape = "<link name=\"r_sole\"><collision><geometry><box size=\"0.104 0.066 0.002\"/>\
                 </geometry></collision></link>";
    let text = folder.read("op2.urdf");
    folder.write("op2.urdf", text.replace("<link name=\"r_sole\"/>", shape));
    for command in ["fit", "diagnose"] {
        let answer = folder.json(&format!("{command} op2.urdf --data log.csv"));
        let mut found = list(&answer, "/health").iter();
        let beyond = found.find(|found| found["kind"] == "cop_outside_sole");
        says(
            beyond.unwrap().to_string(),
            &["beyond the sole", "another unit"],
        );
    }
}

/// Warnings of the terminal are part of the result, each once.
#[test]
fn warnings_stand_in_json_and_on_the_page_once() {
    let folder = case("two_publishers_zeros");
    for command in ["fit", "diagnose"] {
        let line = format!("{command} post.urdf --data zeros_at_4_hz.mcap");
        let stderr = folder.said(&format!("{line} --report page.html"));
        let told = stderr
            .lines()
            .filter_map(|line| line.strip_prefix("warning: "));
        let told: Vec<&str> = told.collect();
        assert!(!told.is_empty(), "{stderr}");
        let answer = folder.json(&line);
        let warnings = texts(&answer, "/warnings");
        let page = folder.read("page.html");
        for warning in told {
            let same = warnings.iter().filter(|other| **other == warning);
            assert_eq!(same.count(), 1, "{warning}: {warnings:?}");
            let start = warning.split(['`', '<', '\'', '&']).next().unwrap();
            assert_eq!(page.matches(start).count(), 1, "{start}");
        }
    }
}

/// A CoP that is metres away in no unit is refused by all commands alike.
#[test]
fn absurd_readings_are_refused_by_every_command() {
    let folder = case("numpy_savetxt");
    let mut far = folder.sheet("default.csv");
    for name in ["cop_x", "cop_y"] {
        for (row, x) in far.numbers(&[name]).concat().iter().enumerate() {
            far.set(name, Some(row), &(1e8 * x + 1e8).to_string());
        }
    }
    folder.write("far.csv", far.to_string());
    folder.write("far.csv.toml", folder.read("default.csv.toml"));
    for line in [
        "fit post.urdf --data far.csv",
        "diagnose post.urdf --data far.csv",
        "compare default.csv far.csv --urdf post.urdf",
    ] {
        folder.refuses(line, &["far.csv", "m from the origin of the sole"]);
    }
    let fleet = "fleet post.urdf --data far.csv --support foot --out f.csv --json";
    let fleet = json(&folder.run(fleet));
    let error = fleet["failed"][0]["error"].to_string();
    says(error, &["m from the origin of the sole"]);
}
