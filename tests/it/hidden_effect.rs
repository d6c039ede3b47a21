//! Hide an effect, ask the diagnoser, and the truth must come out: a part of
//! the study that the command `cargo xtask study` makes at length.

use rayon::prelude::*;
use serde_json::json;
use sesc_test_support::diagnoser::Diagnoser;
use sesc_test_support::hidden::{Effect, Hidden, NOWHERE, hide_all};
use sesc_test_support::judge::{Answer, Judgement, names, truth};
use sesc_test_support::refit::Refit;
use sesc_test_support::sizes::VISIBLE;
use sesc_test_support::stage::Platform;
use sesc_test_support::survey::{Outcome, ask, everything, questions};
use sesc_test_support::table::{Bound, Goal, goal_table, goals, mistakes};
use sesc_test_support::trial::{Choice, Question, Trial};

fn small() -> Choice {
    Choice {
        platforms: vec![Platform::Op2],
        only: None,
        body: false,
        long: false,
        held: 0.0,
    }
}

fn only(effect: Effect) -> Choice {
    Choice {
        only: Some(effect),
        ..small()
    }
}

/// Chi2 of a log against the world that made it, over its expectation.
fn left_over(trial: &Trial) -> f64 {
    let world = hide_all(trial.stage.world(), &trial.hidden).unwrap();
    let readings = world.readings(&trial.log.track());
    let found = trial.log.cop.iter().zip(&trial.log.sigma);
    let gaps = found.zip(&readings).flat_map(|((found, sigma), truth)| {
        [0, 1].map(|axis| (found[axis] - truth.cop[axis]) / sigma[axis])
    });
    gaps.map(|gap| gap * gap).sum::<f64>() / (2 * readings.len()) as f64
}

#[test]
fn every_effect_can_be_hidden_and_leaves_only_noise() {
    for effect in Effect::LIBRARY.into_iter().chain(Effect::OUTSIDE) {
        let question = if effect.is_outside() {
            Question::Outside
        } else {
            Question::Library(1)
        };
        let trial = Trial::draw(question, &only(effect), 5);
        assert_eq!(trial.hidden.len(), 1);
        assert_eq!(trial.hidden[0].effect, effect);
        assert!(trial.chi2 > 0.9 * VISIBLE, "{effect:?}: {}", trial.chi2);
        let left = left_over(&trial);
        // Ticks add 4 % here, a motion known by samples alone a little; 38
        // postures scatter by 16 %.
        assert!(
            (0.6..1.5).contains(&left),
            "{effect:?}: chi2 {left} a reading"
        );
    }
}

#[test]
fn every_robot_stands_on_its_sole() {
    for platform in [Platform::Op2, Platform::Skew, Platform::Plain] {
        let choice = Choice {
            platforms: vec![platform],
            ..small()
        };
        let trial = Trial::draw(Question::Nothing, &choice, 3);
        let edge = trial.stage.cells()[0][0];
        for cop in &trial.log.cop {
            assert!(cop.iter().all(|x| x.abs() < edge), "{platform:?}: {cop:?}");
        }
        assert!((0.6..1.5).contains(&left_over(&trial)));
    }
}

/// `fit` reads the same logs, and knows nothing of this study.
#[test]
fn logs_are_as_the_contract_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let (mut by_cells, mut by_cop) = (0, 0);
    for seed in 0..8 {
        let trial = Trial::draw(Question::Library(1), &only(Effect::CellGain), seed);
        let csv = trial.log.write(folder.path(), "log");
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_sesc"))
            .arg("fit")
            .arg(&trial.stage.urdf)
            .arg("--data")
            .arg(&csv)
            .arg("--json")
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let fit: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(fit["postures"], trial.postures.count());
        let floor = fit["noise_floor"].as_f64().unwrap();
        let expected: f64 = trial.log.sigma.iter().map(|sigma| sigma[0]).sum();
        let expected = expected / trial.log.sigma.len() as f64;
        assert!(
            (floor / expected - 1.0).abs() < 0.25,
            "noise floor {floor}, not {expected}"
        );
        let text = std::fs::read_to_string(&csv).unwrap();
        by_cells += usize::from(text.contains("fsr_4"));
        by_cop += usize::from(text.contains("cop_y"));
    }
    assert!(by_cells > 0 && by_cop > 0, "{by_cells} and {by_cop}");
}

fn hidden(effect: Effect, target: &str, values: &[f64]) -> Hidden {
    Hidden {
        effect,
        target: target.to_owned(),
        values: values.to_vec(),
        begins: 0.0,
        seed: 1,
    }
}

/// A bench log of 100 postures of the OP2 with this hidden.
fn hiding(truth: Vec<Hidden>) -> Trial {
    Trial::of(truth, &small(), 1).unwrap()
}

fn said(steps: &[(&str, &str)], groups: serde_json::Value) -> Answer {
    let steps: Vec<serde_json::Value> = steps
        .iter()
        .map(|(effect, target)| json!({"effect": effect, "target": target}))
        .collect();
    let json = json!({
        "verdict": "named", "steps": steps, "indistinguishable": groups,
        "unexplained": false, "final": {"rmse": 0.0006}, "noise_floor": 0.0005,
    });
    Answer::read(&json).unwrap()
}

#[test]
fn answers_are_judged_by_name_target_and_group() {
    let trial = hiding(vec![hidden(Effect::JointSwap, "l_knee,head_pan", &[])]);
    let exact = Judgement::of(
        &said(&[("joint_swap", "head_pan,l_knee")], json!([])),
        &trial,
    );
    assert!(exact.exact && exact.name && exact.in_group && exact.class());
    assert!((exact.held_out - 1.2).abs() < 1e-12);
    let elsewhere = Judgement::of(&said(&[("joint_swap", "l_el,r_el")], json!([])), &trial);
    assert!(elsewhere.name && !elsewhere.exact && !elsewhere.class());
    let group = json!([["joint_sign:l_el"], ["joint_swap:l_knee,head_pan"]]);
    let grouped = Judgement::of(&said(&[("joint_sign", "l_el")], group), &trial);
    assert!(!grouped.name && grouped.in_group && !grouped.twin && grouped.class());
    let silent = Judgement::of(&said(&[], json!([])), &trial);
    assert!(silent.none && !silent.name && !silent.class());
}

#[test]
fn outliers_beside_backlash_are_no_mistake_but_elsewhere_are() {
    let loose = hiding(vec![hidden(Effect::Backlash, "all", &[0.01])]);
    let both = [("backlash", "all"), ("cop_outliers", "-")];
    assert!(Judgement::of(&said(&both, json!([])), &loose).exact);
    let shifted = hiding(vec![hidden(Effect::SensorOffset, NOWHERE, &[0.004, 0.002])]);
    let both = [("sensor_offset", "-"), ("cop_outliers", "-")];
    assert!(!Judgement::of(&said(&both, json!([])), &shifted).exact);
}

#[test]
fn two_of_a_kind_count_as_two() {
    let twice = [
        hidden(Effect::JointOffset, "r_knee", &[0.05]),
        hidden(Effect::JointOffset, "l_knee", &[0.1]),
    ];
    assert_eq!(names(&truth(&twice)), ["joint_offset", "joint_offset"]);
}

#[test]
fn equivalent_explanations_are_found_by_refit() {
    // Ankle roll and a slope about the same axis: 0.7 % apart.
    let trial = hiding(vec![hidden(Effect::JointOffset, "r_ank_roll", &[0.01])]);
    let slope = Judgement::of(&said(&[("ground_slope", "-")], json!([])), &trial);
    assert!(slope.twin && !slope.name);
    let gain = Judgement::of(&said(&[("sensor_gain", "-")], json!([])), &trial);
    assert!(!gain.twin);
    // More than one parameter more is no twin, however well it fits.
    let three = [("joint_offset", "r_ank_roll"), ("ground_slope", "-")];
    assert!(!Judgement::of(&said(&three, json!([])), &trial).twin);
}

#[test]
fn a_refit_finds_what_is_hidden_from_nothing() {
    for (truth, parameters) in [
        (hidden(Effect::JointCompliance, "all", &[1.0 / 120.0]), 1),
        (
            hidden(Effect::Payload, "r_el_link", &[0.1, 0.0, 0.0, 0.004]),
            4,
        ),
        (
            hidden(Effect::ExternalForce, "head_pan_link", &[0.2, 0.3, 0.1]),
            3,
        ),
        (hidden(Effect::CellSaturation, "fsr_1", &[0.12]), 1),
    ] {
        let trial = hiding(vec![truth.clone()]);
        let refit = Refit::new(&trial.stage, &trial.log, false);
        let (at_truth, found) = (
            refit.least(std::slice::from_ref(&truth)),
            refit.least_from_nothing(std::slice::from_ref(&truth)),
        );
        assert!(
            found < at_truth + 0.1,
            "{truth:?}: {found} against {at_truth}"
        );
        let expected = (200 - parameters) as f64;
        assert!((at_truth - expected).abs() < 5.0 * (2.0 * expected).sqrt());
    }
}

#[test]
fn goals_are_counted() {
    let outcome = |name: bool, held_out: f64| Outcome {
        question: Question::Library(1),
        effects: vec![Effect::GroundSlope],
        description: String::new(),
        chi2: 200.0,
        seed: 1,
        judgement: Judgement {
            name,
            exact: name,
            in_group: true,
            held_out,
            ..Judgement::default()
        },
        seconds: 0.0,
    };
    let counted = goals(&[outcome(true, 1.0), outcome(false, 1.2)]);
    let found = |what: &str| -> &Goal {
        counted
            .iter()
            .find(|goal| goal.what.contains(what))
            .unwrap()
    };
    assert_eq!(found("one effect: named exactly").found(), 0.5);
    assert!(!found("one effect: named exactly").is_met());
    assert!(found("one effect: truth inside").is_met());
    assert_eq!(found("one effect: held out").met, 1);
    assert!(found("known effects: unexplained").is_met());
    assert_eq!(found("two effects: class").of, 0);
    let table = goal_table(&counted);
    // Named exactly, and postures put aside.
    assert_eq!(table.matches("MISSED").count(), 2, "{table}");
    let asked = questions(50, &everything());
    let single = asked
        .iter()
        .filter(|question| **question == Question::Library(1));
    assert_eq!(single.count(), 25);
}

fn diagnoser() -> Diagnoser {
    Diagnoser {
        sesc: env!("CARGO_BIN_EXE_sesc").into(),
    }
}

/// The study itself, cut short: every question, the OP2, at most 200 postures.
/// Of so few logs a share may lie two standard deviations from its goal. What
/// is outside the library and barely shows is imitated by what is inside.
#[test]
fn the_truth_comes_out() {
    const LOGS: usize = 60;
    const SEED: u64 = 1;
    let folder = tempfile::tempdir().unwrap();
    let asked: Vec<(Question, u64)> = questions(LOGS, &small()).into_iter().zip(SEED..).collect();
    let outcomes: Vec<Outcome> = asked
        .into_par_iter()
        .map(|(question, seed)| {
            let trial = Trial::draw(question, &small(), seed);
            ask(&diagnoser(), &trial, folder.path()).unwrap()
        })
        .collect();
    let found = goals(&outcomes);
    let told = format!("{}\n{}", goal_table(&found), mistakes(&outcomes));
    for goal in &found {
        let (share, sign) = match goal.bound {
            Bound::Least(share) if share < 1.0 => (share, 1.0),
            Bound::Most(share) => (share, -1.0),
            _ => continue,
        };
        let of = goal.of as f64;
        let slack = 2.0 * (share * (1.0 - share) * of).sqrt();
        let short = sign * (share * of - goal.met as f64);
        assert!(short <= slack, "{}\n{told}", goal.what);
    }
}

/// Tests effects as strong as those of the open logs that no effect of the library is like.
#[test]
fn unmodelled_effects_stay_unexplained() {
    let unmodelled = [
        hidden(Effect::KneeSine, "r_knee", &[0.006]),
        hidden(Effect::LooseMass, "body_link", &[0.25]),
    ];
    unmodelled.par_iter().for_each(|unmodelled| {
        let folder = tempfile::tempdir().unwrap();
        let asked = |seeds: std::ops::Range<u64>| -> Vec<Outcome> {
            let outcomes = seeds.map(|seed| {
                let trial = Trial::of(vec![unmodelled.clone()], &small(), seed).unwrap();
                ask(&diagnoser(), &trial, folder.path()).unwrap()
            });
            outcomes.collect()
        };
        let explained = |told: &[Outcome]| {
            let is = |told: &&Outcome| !told.judgement.unexplained;
            told.iter().filter(is).count()
        };
        // A third log is asked about where one of two has an explanation.
        let mut told = asked(0..2);
        if explained(&told) == 1 {
            told.extend(asked(2..3));
        }
        assert!(explained(&told) <= 1, "{}", mistakes(&told));
    });
}

/// A gear whose error is a wave is no effect of the list, and a function at its joint.
#[test]
fn a_wave_of_a_gear_is_found_as_a_wave_of_its_encoder() {
    let folder = tempfile::tempdir().unwrap();
    let wave = hidden(Effect::GearError, "r_knee", &[0.05]);
    for seed in 0..2 {
        let trial = Trial::of(vec![wave.clone()], &small(), seed).unwrap();
        let told = ask(&diagnoser(), &trial, folder.path()).unwrap();
        let said = &told.judgement.said;
        assert_eq!(
            said,
            "encoder_ripple:r_knee",
            "{}",
            mistakes(std::slice::from_ref(&told))
        );
    }
}
