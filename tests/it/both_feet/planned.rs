//! Plans on both feet, and what commands say of the logs that they ask for.

use std::sync::Arc;

use sesc_identify::plan;
use sesc_identify::plan::Region;
use sesc_model::Snapping;
use sesc_test_support::command::{Folder, list, number, says};
use sesc_test_support::feet::TwoFeet;
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::robot;

/// Postures of a plan on both feet: the other sole lies on the floor by the reference's link
/// poses, the CoP is between the soles, and all is within the limits.
#[test]
fn planned_postures_keep_both_soles_on_the_floor() {
    for platform in [Platform::Op2, Platform::Skew] {
        let stage = Stage::new(platform);
        let robot = robot(&stage);
        let model = Arc::new(robot.model(stage.support, Snapping::Off, None).unwrap());
        let half = 0.02 * stage.size;
        let region = Region::square(half, 0.0).unwrap();
        let mut request = plan::Request::new(robot, model.clone(), 12, region);
        request.candidates = Some(60);
        request.feet.both = Some(true);
        let found = plan::plan(&request, &mut ()).unwrap();
        let feet = found.both_feet.as_ref().unwrap();
        // Every joint of the legs but the hips' yaw, which lifts nothing at rest alone.
        assert!(feet.offsets.len() >= 10, "{feet:?}");
        assert!(feet.offsets.iter().all(|o| o.std > 0.0), "{feet:?}");
        let virtual_feet = TwoFeet::new(&stage);
        let world = stage.world();
        let (mut low, mut high) = (1.0_f64, 0.0_f64);
        for q in found.postures() {
            let off = virtual_feet.lies(q).amax();
            assert!(off < 1e-8, "{off:e}");
            for (dof, q) in model.tree.dofs.iter().zip(q) {
                let within = dof.lower - 1e-9..=dof.upper + 1e-9;
                assert!(within.contains(q), "{}", dof.joint);
            }
            let at = virtual_feet.place(q);
            let cop = world.cop(q);
            // Within the soles' squares, the box about both.
            for axis in 0..2 {
                let (low, high) = (at[axis].min(0.0), at[axis].max(0.0));
                let within = low - 1.5 * half..=high + 1.5 * half;
                assert!(within.contains(&cop[axis]), "{cop:?} {at:?}");
            }
            let share = (cop[0] * at[0] + cop[1] * at[1]) / (at[0] * at[0] + at[1] * at[1]);
            (low, high) = (low.min(share), high.max(share));
        }
        assert!(low < 0.3 && high > 0.7, "shares {low:.2} to {high:.2}");
        let sidecar = found.sidecar();
        assert_eq!(sidecar.both_feet, Some(true));
        assert_eq!(sidecar.other_foot.as_ref(), Some(&feet.other_foot));
    }
}

/// The command line: flags, JSON, text and page of a log that a plan on both feet asked for.
#[test]
fn commands_take_both_feet_and_say_what_the_soles_say() {
    let folder = Folder::with("op2");
    let options = "--both-feet --poses 30 --candidates 60 --out poses.csv";
    let said = folder.stdout(&format!("plan op2.urdf --support r_sole {options}"));
    says(
        said,
        &["soles            both soles on the floor, `l_sole` the other"],
    );
    // The robot's l_knee is 1.5° further than its encoder says: angles of the plan are true.
    let stage = Stage::new(Platform::Op2);
    let world = stage.world().joint_offset("l_knee", 0.026).unwrap();
    let log = TwoFeet::new(&stage).log_of_plan(&world, &folder.read("poses.csv"), [0.0; 2]);
    folder.write("log.csv", log);
    let diagnose = "diagnose op2.urdf --data log.csv --support r_sole --noise 0.003";
    let json = folder.json(&format!("{diagnose} --other-foot l_sole"));
    assert_eq!(json["steps"][0]["target"], "l_knee", "{json}");
    let closure = &json["closure"];
    assert_eq!(closure["other_foot"], "l_sole");
    assert_eq!(closure["closes"], true);
    // A foot that its ankle rolls by ρ is pitched by cos ρ of it.
    let before = number(closure, "/before/pitch_rad");
    assert!((0.018..0.027).contains(&before), "{closure}");
    assert!(number(closure, "/after/pitch_rad") < 1e-3, "{closure}");
    for part in ["noise", "tolerance"] {
        for key in ["roll_rad", "pitch_rad", "height_m"] {
            assert!(number(closure, &format!("/{part}/{key}")) > 0.0);
        }
    }
    let text = folder.stdout(&format!("{diagnose} --both-feet --report page.html"));
    says(text, &["soles            l_sole off that of r_sole by"]);
    let soles = "<dt>soles</dt><dd>l_sole off that of r_sole by";
    says(folder.read("page.html"), &[soles]);
    let fit = diagnose.replace("diagnose", "fit");
    let json = folder.json(&format!("{fit} --both-feet"));
    let mut joints = list(&json, "/closure/explained_by").iter();
    assert!(joints.any(|o| o["joint"] == "l_knee"), "{json}");
    folder.refuses_each(&format!(
        "{diagnose} --other-foot toe | --other-foot LINK `toe` is no link of the robot | l_sole"
    ));
}
