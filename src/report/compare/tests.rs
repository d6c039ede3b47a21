//! The page of two small models.

use sesc_identify::compare::compare;
use sesc_identify::robot::Robot;
use sesc_identify::skeleton::Skeleton;
use sesc_model::{ModelFile, Snapping};

use super::page;
use crate::report::next_steps::Worded;
use crate::report::tests::{says, still};

const TWO_LINK: &str = include_str!("../../../robots/two_link/two_link.urdf");

/// A model whose thigh is `mm` long, with an offset of the knee where there is one.
fn file(name: &str, mm: f64, offset: Option<f64>) -> ModelFile {
    let mut text = format!(
        "robot = \"two<link>\"\nhash = \"00c0ffee00c0ffee\"\nsupport = \"foot\"\n\
         [[parameters]]\nname = \"thigh.z\"\nvalue = {}\nstd = 0.0001\nsource = \"data\"\n\
         [[data]]\nfile = \"{name}.csv\"\nhash = \"1234\"\nrows = 40\ntimes = [1000000000.0, 1000000060.0]\n",
        mm / 1000.0
    );
    if let Some(offset) = offset {
        text += &format!(
            "[[effects]]\neffect = \"joint_offset\"\ntarget = \"knee\"\n\
             [effects.parameters.offset_rad]\nvalue = {offset}\nstd = 0.001\n"
        );
    }
    ModelFile::parse(&text, &format!("/a/folder/{name}.toml")).unwrap()
}

#[test]
fn the_page_says_what_changed_and_whether_it_is_more_than_chance() {
    let robot = Robot::parse(TWO_LINK, "robot.urdf").unwrap();
    let model = robot.model("foot", Snapping::default(), None).unwrap();
    let skeleton = Skeleton::of(&model, &robot.description, None);
    let monday = file("monday", 100.0, None);
    let friday = file("friday", 103.0, Some(0.05));
    let found = compare(&monday, &friday).unwrap();
    let steps = [Worded {
        what: "Check `knee`".to_string(),
        why: "it changed".to_string(),
        command: None,
    }];
    let made = |drawn| {
        let files = [&monday, &friday];
        page(&found, files, &steps, drawn, "sesc compare a b").unwrap()
    };
    let html = made(Some(&skeleton));
    let words = [
        "friday.toml differs from monday.toml by more than chance",
        "<td class=\"name\">appeared</td>",
        // 0.05 rad ± 0.001 rad.
        "2.865°",
        // 3 mm over 0.1 √2 mm.
        "<td>21.2</td>",
        "p &lt; 0.005",
        "monday.csv, 40 rows, hash 1234",
        "2001-09-09 01:46 to 2001-09-09 01:47 UTC",
        "<b>Check <code>knee</code></b>: it changed.",
        "hash 00c0ffee00c0ffee",
        "<pre>sesc compare a b</pre>",
        "Orange: <code>knee</code> (joint offset appeared).",
        "These effects appeared: an offset of knee (joint_offset:knee).",
        "<td class=\"name\">joint offset</td>",
        "two&lt;link&gt;",
    ];
    says(&html, &words);
    assert!(!html.contains("/a/folder") && !html.contains("two<link>") && !html.contains("NaN"));
    // Two of the robot, and the deviations.
    assert_eq!(html.matches("<svg ").count(), 3);
    still(&html, 2);
    assert_eq!(html, made(Some(&skeleton)));
    assert_eq!(made(None).matches("<svg ").count(), 1);
}

#[test]
fn nothing_changed_is_said_so() {
    let (monday, friday) = (file("monday", 100.0, None), file("friday", 100.1, None));
    let found = compare(&monday, &friday).unwrap();
    let html = page(&found, [&monday, &friday], &[], None, "sesc compare a b").unwrap();
    let words = [
        "Nothing changed by more than chance",
        "No effect, neither before nor after.",
    ];
    says(&html, &words);
}
