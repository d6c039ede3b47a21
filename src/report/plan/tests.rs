//! The page of a small plan.

use sesc_model::Snapping;

use super::page;
use crate::OP2_URDF;
use crate::report::table::mm;
use sesc_identify::fit::prior::Prior;
use sesc_identify::plan::balance::Region;
use sesc_identify::plan::{Plan, Request, plan};
use sesc_identify::robot::Robot;

fn small(prior: &str, poses: usize) -> Plan {
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let region = Region::sole("0.05,0.03; -0.05,0.03; -0.05,-0.03; 0.04,-0.03", 0.002).unwrap();
    let prior = Prior::named(prior, &model).unwrap();
    let mut request = Request::new(robot, model, poses, region);
    request.candidates = Some(120);
    request.sigmas = 0.0;
    request.prior = prior;
    request.clearance = 0.0;
    plan(&request, &mut ()).unwrap()
}

#[test]
fn the_page_stands_alone_says_the_numbers_and_escapes_names() {
    let mut found = small("cad", 25);
    found.robot = "op<2>".to_string();
    found.joints[3].joint = "<hip>".to_string();
    found.joints[3].used = [0.0, 0.0];
    let html = page(&found, "poses.csv", "sesc plan 'a<b>.urdf'").unwrap();
    for words in [
        "op&lt;2&gt;",
        "<code>&lt;hip&gt;</code>",
        "sesc plan &#x27;a&lt;b&gt;.urdf&#x27;",
        &format!("{} mm off", mm(found.expected_error.unwrap())),
        &format!(
            "random ones, {} mm",
            mm(found.expected_error_random.unwrap())
        ),
        "a sole of 4 corners",
        "25 postures to take, of 120",
    ] {
        assert!(html.contains(words), "{words}");
    }
    assert_eq!(html.matches("<svg ").count(), 3);
    // A dot per posture in the sole plane and one in its key, a ring and a dot at the
    // ends of the curves.
    assert_eq!(html.matches("<circle").count(), 25 + 1 + 2);
    assert!(!html.contains("NaN") && !html.contains("op<2>") && !html.contains("<hip>"));
    let outside = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for reference in ["http", "src=", "href", "@import", "url(", "<script"] {
        assert!(!outside.contains(reference), "{reference}");
    }
    assert_eq!(
        html,
        page(&found, "poses.csv", "sesc plan 'a<b>.urdf'").unwrap()
    );
}

/// Too few postures for a fit without a prior: no number is made up.
#[test]
fn a_plan_that_leaves_directions_open_says_so() {
    let found = small("free", 10);
    assert!(found.expected_error.is_none() && found.curve.is_empty());
    let html = page(&found, "poses.csv", "sesc plan").unwrap();
    assert!(html.contains("10 postures tell 20 of 42 directions"));
    assert!(html.contains("these postures leave directions open"));
    let told = small("free", 30);
    assert_eq!(told.curve[0].postures, 21);
    let last = told.curve.last().unwrap();
    assert_eq!(Some(last.planned), told.expected_error);
    assert_eq!(Some(last.random), told.expected_error_random);
}
