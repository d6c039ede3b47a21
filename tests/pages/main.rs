//! Scripts of pages without a browser: the robot that a script poses stands where the reference
//! has it. What a browser makes of pages is checked by `tests/pages/run`.

use std::fs;
use std::process::Command;

use sesc_reference::{Reference, Robot};

const POSE_JS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/report/script/pose.js");
/// Numbers of a page are rounded: angles to 1e-5 rad, lengths to 1e-7 m.
const CLOSE_M: f64 = 5e-5;

/// Prints where every body of every posture of a page is, and its CoM.
const PLACES: &str = r#"
const { place, centre } = require(process.argv[1]);
const data = JSON.parse(require('fs').readFileSync(process.argv[2], 'utf8'));
console.log(JSON.stringify(data.postures.map(({ q }) => {
  const frames = place(data.bodies, q);
  return { origins: frames.map((frame) => frame.origin), com: centre(data.bodies, frames) };
})));
"#;

/// Prints the hash of a page's own script, as a policy names it.
const HASH: &str = r#"
const script = require('fs').readFileSync(process.argv[1], 'utf8').split('<script>')[1].split('</script>')[0];
console.log('sha256-' + require('crypto').createHash('sha256').update(script).digest('base64'));
"#;

/// What a program for node prints.
fn node(program: &str, arguments: &[&str]) -> String {
    let node = Command::new("node")
        .args(["-e", program])
        .args(arguments)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&node.stderr);
    assert!(node.status.success(), "{said}");
    String::from_utf8(node.stdout).unwrap()
}

fn sesc(arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_sesc"))
        .args(arguments)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// Bodies' joints, by the titles of their dots.
fn joints(page: &str) -> Vec<(usize, String)> {
    let front = page.split("<svg ").nth(1).unwrap();
    let dots = front.split("<g data-j=\"").skip(1);
    let joint = |dot: &str| {
        let (body, rest) = dot.split_once('"').unwrap();
        let (_, title) = rest.split_once("<title>").unwrap();
        (
            body.parse().unwrap(),
            title.split_once('<').unwrap().0.to_string(),
        )
    };
    dots.map(joint).collect()
}

/// Robots with prismatic joints, mimics and rotated frames, and one walked against the URDF.
#[test]
fn a_script_poses_the_robot_as_the_reference_does() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    for (robot, support) in [
        ("op2/op2.urdf", "r_sole"),
        ("lift_base/lift_base.urdf", "grasp_frame"),
        ("skew_humanoid/skew_humanoid.urdf", "right_sole"),
    ] {
        let urdf = format!("{}/robots/{robot}", env!("CARGO_MANIFEST_DIR"));
        let (log, page, data) = (at("log.csv"), at("page.html"), at("data.json"));
        sesc(&[
            "simulate",
            &urdf,
            "--support",
            support,
            "--poses",
            "60",
            "--noise",
            "0.0005",
            "--out",
            &log,
        ]);
        sesc(&["fit", &urdf, "--data", &log, "--report", &page]);
        let hash = node(HASH, &[&page]);
        let page = fs::read_to_string(&page).unwrap();
        // A browser runs a script of the hash that the policy names, and no other.
        let policy = format!("script-src '{}'", hash.trim());
        assert!(page.contains(&policy), "SCRIPT_HASH is {hash}");
        let (_, json) = page
            .split_once("<script type=\"application/json\" id=\"robot\">")
            .unwrap();
        let (json, _) = json.split_once("</script>").unwrap();
        fs::write(&data, json).unwrap();
        let placed = node(PLACES, &[POSE_JS, &data]);
        let placed: serde_json::Value = serde_json::from_str(&placed).unwrap();
        let given: serde_json::Value = serde_json::from_str(json).unwrap();

        let text = fs::read_to_string(&urdf).unwrap();
        let reference = Reference::new(&Robot::from_urdf(&text).unwrap(), support).unwrap();
        let description = sesc_model::urdf::parse(&text, &urdf).unwrap();
        let links: Vec<&str> = description.link_names().collect();
        let postures = given["postures"].as_array().unwrap();
        assert_eq!(postures.len(), 60);
        let near = |own: &serde_json::Value, theirs: [f64; 3], what: &str| {
            for axis in 0..3 {
                let off = own[axis].as_f64().unwrap() - theirs[axis];
                assert!(off.abs() < CLOSE_M, "{robot}, {what}: {off}");
            }
        };
        for (posture, placed) in postures.iter().zip(placed.as_array().unwrap()) {
            let q: Vec<f64> = (posture["q"].as_array().unwrap().iter())
                .map(|q| q.as_f64().unwrap())
                .collect();
            near(&placed["com"], reference.com(&q).into(), "CoM");
            let poses = reference.link_poses(&q);
            for (body, joint) in joints(&page) {
                let own = description.joints.iter().find(|j| j.name == joint).unwrap();
                // A prismatic joint walked backwards moves away from its child's origin.
                if own.joint_type == sesc_model::urdf::JointType::Prismatic {
                    continue;
                }
                let child = links.iter().position(|link| *link == own.child).unwrap();
                let theirs = poses[child].translation.vector.into();
                near(&placed["origins"][body], theirs, &joint);
            }
        }
    }
}
