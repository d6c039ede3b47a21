//! Pages and console texts of small simulated logs.

use std::sync::Arc;

use sesc_model::{DataUsed, Function, Model, ModelFile, Snapping};

use super::{DiagnoseReport, page, parameters, text};
use crate::report::next_steps::{Worded, worded};
use crate::report::tests::{says, still};
use sesc_identify::diagnose::view::DiagnosisView;
use sesc_identify::diagnose::{Diagnosis, ExperimentProposal, Member, Verdict};
use sesc_identify::diagnose::{Request, diagnose};
use sesc_identify::evaluate::Evaluator;
use sesc_identify::logs::{LogSource, Sidecar, Table};
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;

const TWO_LINK: &str = include_str!("../../../robots/two_link/two_link.urdf");
const NOISE: f64 = 2e-4;

/// What is added to the CoP of posture `k` at these joint positions, m.
type Off = fn(usize, &[f64]) -> [f64; 2];

/// A log of readings that differ from CAD by `off` and noise.
fn log(model: &Model, count: usize, timed: bool, off: Off) -> Table {
    let dofs = &model.tree.dofs;
    let mut simulator = Simulator::new(dofs, Some(0.6), 3);
    let q = simulator.batch(count);
    let cop = Evaluator::new(model, Function::Cop).run(&q, count);
    let readings = q.chunks(dofs.len()).zip(cop.chunks(2)).enumerate();
    let readings = readings.flat_map(|(k, (q, cop))| {
        let extra = off(k, q);
        [0, 1].map(|axis| cop[axis] + extra[axis] + simulator.gauss(NOISE))
    });
    let readings: Vec<f64> = readings.collect();
    let column = |values: &[f64], from: usize, step: usize| -> Vec<f64> {
        values.iter().skip(from).step_by(step).copied().collect()
    };
    let mut log = Table::new("log.csv").integers("pose", (0..count as i64).collect::<Vec<_>>());
    if timed {
        log = log.numbers("t", (0..count).map(|k| 0.5 * k as f64).collect::<Vec<_>>());
    }
    for (j, dof) in dofs.iter().enumerate() {
        log = log.numbers(&dof.joint, column(&q, j, dofs.len()));
    }
    for (axis, name) in ["cop_x", "cop_y"].into_iter().enumerate() {
        log = log.numbers(name, column(&readings, axis, 2));
        log = log.numbers(&format!("{name}_std"), vec![NOISE; count]);
    }
    log
}

fn small((count, timed): (usize, bool), off: Off) -> (Diagnosis, DiagnosisView) {
    let robot = Robot::parse(TWO_LINK, "robot.urdf").unwrap();
    let model = robot.model("foot", Snapping::default(), None).unwrap();
    let log = LogSource::from(log(&model, count, timed, off)).with_sidecar(Sidecar {
        robot: Some("a<b>&c".into()),
        ..Sidecar::default()
    });
    let mut request = Request::new(Arc::new(robot), log);
    request.support = Some("foot".into());
    request.view = true;
    let report = diagnose(&request, &mut ()).unwrap();
    (report.diagnosis, report.view.unwrap())
}

/// The robot and data that a page names.
fn made() -> ModelFile {
    let robot = Robot::parse(TWO_LINK, "robot.urdf").unwrap();
    let model = robot.model("foot", Snapping::default(), None).unwrap();
    let mut made = ModelFile::from_values(&model, &model.params(), None, "cad");
    made.data.push(DataUsed {
        file: "mon<day>.csv".to_string(),
        hash: "00c0ffee".to_string(),
        rows: 7,
        times: None,
    });
    made
}

/// Next steps in words, each with a command.
fn next(found: &Diagnosis) -> Vec<Worded> {
    worded(&found.next_steps(), |_| Some("do <it>".to_string()))
}

/// What the console prints.
fn console(found: &Diagnosis) -> String {
    text(&printed(found, &next(found)), false)
}

fn printed<'a>(found: &'a Diagnosis, next_steps: &'a [Worded]) -> DiagnoseReport<'a> {
    DiagnoseReport {
        found,
        next_steps,
        model_use: None,
    }
}

/// The page, after what holds for every page.
fn sound(found: &Diagnosis, view: &DiagnosisView) -> String {
    let (made, next) = (made(), next(found));
    let report = printed(found, &next);
    let html = page(&report, view, &made, "sesc diagnose 'a<b>.urdf'").unwrap();
    let again = page(&report, view, &made, "sesc diagnose 'a<b>.urdf'").unwrap();
    assert_eq!(html, again);
    let words = [
        &format!("two_link, hash {}", made.hash),
        "mon&lt;day&gt;.csv, 7 rows, hash 00c0ffee",
        "<pre>sesc diagnose &#x27;a&lt;b&gt;.urdf&#x27;</pre>",
        "<p class=\"made\">sesc ",
        "a&lt;b&gt;&amp;c",
        &found.log,
        &found.prior,
    ];
    says(&html, &words);
    assert!(!html.contains("a<b>"));
    for figure in html.split("<svg ").skip(1) {
        let figure = figure.split("</svg>").next().unwrap();
        assert!(!figure.contains("NaN") && !figure.contains("inf"));
    }
    let figures = still(&html, 2);
    once(&html, found);
    // Closed like XML, but for what HTML leaves open.
    let closed = figures
        .lines()
        .map(|line| match line.starts_with("<meta ") {
            true => line.replace('>', "/>"),
            false => line.replace("<!DOCTYPE html>", ""),
        });
    let closed = closed.collect::<Vec<_>>().join("\n");
    roxmltree::Document::parse(&closed).expect("a page is well-formed");
    html
}

/// The result stands once above the robot: effects in the title, sizes below it, errors in tiles.
fn once(html: &str, found: &Diagnosis) {
    let top = html.split("<body>").nth(1).unwrap();
    let top = top.split("<figure class=\"robot\">").next().unwrap();
    says(
        html,
        &["<dt>in words</dt><dd>Simulated and measured CoP differ by"],
    );
    assert!(
        !top.contains("Could not have been seen") && !top.contains("differ by"),
        "{top}"
    );
    for step in &found.steps {
        let sizes = parameters(step);
        let first = sizes
            .first()
            .map_or("none", |said| said.split_once(' ').unwrap().1);
        assert!(top.matches(first).count() < 2, "{first}: {top}");
        let caption = html.split("<figcaption>").nth(1).unwrap();
        let caption = caption.split("</figcaption>").next().unwrap();
        assert!(!caption.contains(first), "{caption}");
    }
}

/// Console, page and JSON say the same next steps; the sentences of JSON.
fn one_voice(found: &Diagnosis, html: &str) -> String {
    let next = next(found);
    assert!(!next.is_empty());
    let words = console(found);
    let words: String = words.split_whitespace().collect::<Vec<_>>().join(" ");
    let json = serde_json::to_value(printed(found, &next)).unwrap();
    assert_eq!(json["next_steps"], serde_json::to_value(&next).unwrap());
    let mut all = String::new();
    for step in next {
        let said = format!("{}: {}.", step.what, step.why);
        says(&words, &[&said]);
        says(html, &[step.what.split('`').next().unwrap()]);
        all += &said;
    }
    says(html, &["<code>do &lt;it&gt;</code>"]);
    all
}

#[test]
fn a_log_with_times_of_day_is_dated_by_them() {
    let (mut found, view) = small((12, true), |_, _| [0.0; 2]);
    // Every half second.
    assert_eq!(found.times, Some([0.0, 5.5]));
    assert!(!sound(&found, &view).contains("recorded"));
    found.times = Some([1_735_689_600.0, 1_735_693_260.0]);
    let words = "2025-01-01 00:00 to 2025-01-01 01:01 UTC";
    says(&sound(&found, &view), &[words]);
}

#[test]
fn a_named_effect_is_told_with_its_size_and_all_figures() {
    let (found, view) = small((60, true), |_, q| [0.02 * (q[0] + q[1]), 0.004]);
    assert!(!found.steps.is_empty(), "{}", found.sentence);
    let html = sound(&found, &view);
    let confusion = usize::from(found.class.len() > 1);
    // The robot and its gaps, ten figures, and a bar for each joint.
    let joints = view.skeleton.dofs.len();
    assert_eq!(html.matches("<svg ").count(), 3 + 11 + joints + confusion);
    let evidence = format!("Evidence {:.0}: with the effect", found.steps[0].evidence);
    let words = [
        "Gap in mm against the change that the named effect predicts",
        &evidence,
        "to be missing from 4 on",
    ];
    says(&html, &words);
    let labels = ["simulation misses", "time, s", "±", "CoP x, mm", "evidence"];
    says(&html, &labels);
    one_voice(&found, &html);
    // Part s of the correction: χ² of CAD at 0, of the explanation at 1.
    let [a, b, c] = view.chi2;
    let rms = [a, a + b + c].map(|chi2| (chi2 / view.chi2_readings as f64).sqrt());
    for (own, counted) in rms.into_iter().zip(view.spread.rms) {
        assert!((own - counted).abs() < 1e-9 * counted, "{own} {counted}");
    }
    // The slider ends at the χ² of the text.
    let left = &found.leftover;
    assert!(
        (a + b + c - left.chi2).abs() < 1e-6 * left.chi2,
        "{} {}",
        a + b + c,
        left.chi2
    );
    assert!((view.chi2_expected - left.expected).abs() < 1e-9 * left.expected);
    let stages = &view.stages;
    assert_eq!(stages[0].rmse, found.baseline.rmse);
    assert!(stages[stages.len() - 2].rmse < 0.5 * stages[0].rmse);
    assert!(view.spread.rms[1] < 2.0 && view.spread.rms[0] > 5.0);
    let words = [found.steps[0].effect, "before, mm", "held out"];
    says(&console(&found), &words);
}

#[test]
fn a_log_without_times_and_without_a_gap_is_shown_in_its_order() {
    let (found, view) = small((38, false), |_, _| [0.0; 2]);
    assert_eq!(found.verdict, Verdict::None, "{}", found.sentence);
    let html = sound(&found, &view);
    assert!(html.contains("posture, in the order of the log") && !html.contains("time, s"));
    assert!(html.contains("Simulation and measurement agree"));
    assert!(!view.timed && view.differences.is_empty());
    assert!(!console(&found).contains("Keep the corrected model"));
}

#[test]
fn a_single_posture_still_makes_a_page() {
    let (found, view) = small((1, false), |_, _| [0.0; 2]);
    let html = sound(&found, &view);
    assert!(html.contains("1 posture of log.csv"));
    assert!(view.by_position.iter().all(|t| t.share == [0.0; 2]));
}

#[test]
fn what_nothing_explains_is_called_so() {
    let (found, view) = small((100, true), |_, q| {
        [0.004 * (14.0 * q[1]).sin().signum(), 0.0]
    });
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.sentence);
    let html = sound(&found, &view);
    assert!(html.contains("What nothing explains") && html.contains("No known effect"));
    // What to check by hand, in every voice; no postures would tell anything.
    let all = one_voice(&found, &html);
    says(&all, &["`knee`", "edges of the foot sole", "link lengths"]);
    says(&all, &["Record the log once more"]);
    assert!(!all.contains("postures that tell most"));
    says(&found.next_postures.why, &["by hand"]);
    assert!(view.trends_of_rest);
    assert_eq!(view.by_position[0].joint, "knee");
}

#[test]
fn outliers_are_boxed() {
    let off: Off = |k, _| [if k % 17 == 4 { 0.02 } else { 0.0 }, 0.0];
    let (found, view) = small((80, true), off);
    assert!(!found.outliers.is_empty(), "{}", found.sentence);
    let html = sound(&found, &view);
    assert!(html.contains("outliers apart") && html.contains("poses 4, 21"));
    assert!(view.postures.iter().filter(|p| p.outlier).count() >= 4);
    assert!(console(&found).contains("poses 4, 21"));
}

#[test]
fn a_class_of_twenty_is_numbered_and_mapped() {
    let (mut found, mut view) = small((38, false), |_, _| [0.004, 0.0]);
    let member = |k: usize| Member {
        effects: vec![format!("joint_offset:a<{k}>"), "ground_slope".to_string()],
        subjects: format!("an offset of a<{k}> (joint_offset:a<{k}>)"),
        score_difference: 0.4 * k as f64,
        com_apart: None,
        sentence: format!("An offset of a<{k}>"),
    };
    found.verdict = Verdict::Class;
    found.class = (0..20).map(member).collect();
    let row = |k: usize| (0..20_i32).map(move |i| 0.1 * f64::from((i - k as i32).abs()));
    view.differences = (0..20).map(|k| row(k).collect()).collect();
    found.next_postures.why = "Turn the robot.".to_string();
    found.next_postures.file = Some("/a/folder/next.csv".to_string());
    found.next_postures.experiments = vec![ExperimentProposal {
        what: "the robot turned <round>".to_string(),
        splits: 7,
        separations: vec![f64::INFINITY; 19],
    }];
    let html = sound(&found, &view);
    says(
        &html,
        &["turned &lt;round&gt;", "7 of 19", "<code>next.csv</code>"],
    );
    assert!(!html.contains("/a/folder"));
    says(&html, &["20 complete explanations", "How far apart"]);
    // The threshold of criteria, with its odds: e^5.
    let odds = "worse by more than 10 units of χ², odds of more than 148 to 1";
    says(&html, &[odds, "19 others that look alike"]);
    says(
        &console(&found),
        &[
            "cannot tell apart",
            "an offset of a<7> (joint_offset:a<7>)\nand 12 more: --long lists all",
        ],
    );
    let all = text(&printed(&found, &[]), true);
    says(&all, &["an offset of a<19> (joint_offset:a<19>)\n"]);
    assert!(!all.contains("--long"));
}

/// Rows of findings are postures of the page behind those of its slider, and every dot of a
/// finding's figure is one of them.
#[test]
fn dots_of_findings_pose_the_robot() {
    const ROWS: usize = 80;
    let far: Off = |k, _| [if k % 10 == 3 { 5.0 } else { 0.0 }, 0.0];
    let (found, view) = small((ROWS, true), far);
    assert_eq!(found.health[0].kind.name(), "cop_outside_sole");
    let html = sound(&found, &view);
    let figure = html.split("<figure class=\"health\">").nth(1).unwrap();
    let figure = figure.split("</figure>").next().unwrap();
    let dots = figure.split("data-p=\"").skip(1);
    let dots = dots.map(|rest| rest.split('"').next().unwrap().parse().unwrap());
    // Rows that the finding is about are drawn on the others.
    let mut dots: Vec<usize> = dots.collect();
    dots.sort_unstable();
    let first = view.postures.len();
    assert_eq!(dots, (first..first + ROWS).collect::<Vec<usize>>());
    assert!(!figure.contains("data-v"));

    let (_, data) = html.split_once("id=\"robot\">").unwrap();
    let data = data.split("</script>").next().unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["slider"], first);
    let postures = data["postures"].as_array().unwrap();
    assert_eq!(postures.len(), first + ROWS);
    let dofs = &view.skeleton.dofs;
    let q = Simulator::new(dofs, Some(0.6), 3).batch(ROWS);
    for (k, posture) in postures[first..].iter().enumerate() {
        assert_eq!(posture["pose"], k);
        assert_eq!(posture["row"], format!("row {}", k + 1));
        let said = posture["said"][0].as_str().unwrap();
        let (title, value) = said.split_once("mm: ").unwrap();
        assert_eq!(title, "Distance of the CoP from the origin, ");
        let value: f64 = value.parse().unwrap();
        assert_eq!(value > 4000.0, k % 10 == 3, "{said}");
        for (joint, own) in posture["q"].as_array().unwrap().iter().enumerate() {
            let off = own.as_f64().unwrap() - q[k * dofs.len() + joint];
            assert!(off.abs() <= 0.51e-4, "{off}");
        }
    }
}
