//! The page of a small plan.

use sesc_model::Snapping;

use super::{page, text};
use crate::OP2_URDF;
use crate::report::next_steps::{WithSteps, Worded, worded};
use crate::report::table::mm;
use crate::report::tests::{says, still};
use sesc_identify::NextStep;
use sesc_identify::fit::prior::Prior;
use sesc_identify::plan::Region;
use sesc_identify::plan::{Plan, Request, plan};
use sesc_identify::robot::Robot;
use sesc_identify::skeleton::Skeleton;

fn small(prior: &str, poses: usize) -> (Plan, Skeleton) {
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let region = Region::sole("0.05,0.03; -0.05,0.03; -0.05,-0.03; 0.04,-0.03", 0.002).unwrap();
    let prior = Prior::named(prior, &model).unwrap();
    let mut request = Request::new(robot, model, poses, region);
    request.candidates = Some(120);
    request.sigmas = 0.0;
    request.prior = prior;
    request.clearance = 0.0;
    let skeleton = Skeleton::of(&request.model, &request.robot.description, None);
    (plan(&request, &mut ()).unwrap(), skeleton)
}

fn next(found: &Plan) -> Vec<Worded> {
    worded(&found.next_steps(), |_| None)
}

#[test]
fn the_page_stands_alone_says_the_numbers_and_escapes_names() {
    let (mut found, mut skeleton) = small("cad", 25);
    skeleton.dofs[3].joint = "</script><hip>\u{2028}".to_string();
    found.robot = "op<2>".to_string();
    found.joints[3].joint = "<hip>".to_string();
    found.joints[3].used = [0.0, 0.0];
    let next = next(&found);
    let made = || {
        page(
            &found,
            &next,
            &skeleton,
            "poses.csv",
            "sesc plan 'a<b>.urdf'",
        )
        .unwrap()
    };
    let html = made();
    let words = [
        "op&lt;2&gt;",
        "<code>&lt;hip&gt;</code>",
        "sesc plan &#x27;a&lt;b&gt;.urdf&#x27;",
        &format!(
            "predicts the CoP to {} mm",
            mm(found.expected_error.unwrap())
        ),
        &format!(
            "a fit to random ones to {} mm",
            mm(found.expected_error_random.unwrap())
        ),
        "a sole of 4 corners",
        "25 postures to take, of 120",
        &format!("hash {}</dd>", found.hash),
        "<code>cop_x</code>",
        "Fit the log",
        "<span>1 next</span>",
        "\\u003c/script\\u003e\\u003chip\\u003e\\\\u{2028}",
    ];
    says(&html, &words);
    // What to record, under which names, in every voice.
    let said = text(&found, &next);
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    let json = serde_json::to_value(WithSteps {
        found: &found,
        next_steps: &next,
    });
    let json = json.unwrap();
    let record = "`cop_x`, `cop_y` (m, in the frame of `r_sole`)";
    for (k, words) in [record, "Fit the log"].into_iter().enumerate() {
        let step = &next[k];
        says(&step.what, &[words]);
        says(&said, &[&format!("{}: {}.", step.what, step.why)]);
        assert_eq!(json["next_steps"][k]["what"], step.what.as_str());
    }
    let steps = found.next_steps();
    let support = Some("r_sole".to_string());
    assert_eq!(steps[1], NextStep::Fit { support });
    // Without shapes nothing is said of collisions but that they are not checked.
    assert!(!found.collision_checked && !said.contains("self-collision"));
    says(&said, &["not checked"]);
    // Two of the robot, three of the plan, and a contact sheet.
    assert_eq!(html.matches("<svg ").count(), 2 + 3 + 25);
    // A dot per posture in the sole plane.
    assert_eq!(html.matches("<g data-p=").count(), 25);
    assert_eq!(html.matches("<li data-p=").count(), 25);
    // The first posture is marked, and each says what it teaches.
    let first = &found.lessons[0];
    assert_eq!(found.lessons.len(), 25);
    assert!(found.lessons.iter().all(|own| own.after < own.before));
    let said = format!("from {} to {} mm", mm(first.before), mm(first.after));
    says(&html, &[&said]);
    assert_eq!(html.matches("<small>").count(), 25 + 2);
    assert!(!html.contains("NaN") && !html.contains("op<2>") && !html.contains("<hip>"));
    still(&html, 2);
    assert_eq!(html, made());
}

/// Too few postures for a fit without a prior: no number is made up.
#[test]
fn a_plan_that_leaves_directions_open_says_so() {
    let (found, skeleton) = small("free", 10);
    assert!(found.expected_error.is_none() && found.curve.is_empty());
    let html = page(&found, &next(&found), &skeleton, "poses.csv", "sesc plan").unwrap();
    let open = "these postures leave directions open";
    says(&html, &["10 postures tell 20 of 42 directions", open]);
    let (told, _) = small("free", 30);
    assert_eq!(told.curve[0].postures, 21);
    let last = told.curve.last().unwrap();
    assert_eq!(Some(last.planned), told.expected_error);
    assert_eq!(Some(last.random), told.expected_error_random);
}
