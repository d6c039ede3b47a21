//! Whole diagnoses: hidden effects are named, and indistinguishable ones are not.

use sesc_reference::World;

use super::{Bench, diagnosed, says};
use crate::diagnose::findings::Step;
use crate::diagnose::{Diagnosis, Suspect, Verdict};

const POSTURES: usize = 100;

fn of(bench: &Bench, world: &World, prior: &str, seed: u64) -> Diagnosis {
    let q = bench.balanced(POSTURES, 50 + seed);
    bench.diagnose(bench.log(world, &q, seed), prior).diagnosis
}

fn labels(found: &Diagnosis) -> Vec<String> {
    let label = |step: &Step| match step.target.as_str() {
        "-" => step.effect.to_string(),
        target => format!("{}:{target}", step.effect),
    };
    found.steps.iter().map(label).collect()
}

#[test]
fn what_is_planted_is_named_with_its_value() {
    let bench = Bench::op2();
    let world = || bench.world();
    for (seed, (label, value, world)) in [
        ("sensor_rotation", 0.1, world().sensor_rotation(0.1)),
        ("joint_scale:r_ank_roll", 1.2, {
            world().joint_scale("r_ank_roll", 1.2).unwrap()
        }),
        ("joint_compliance:all", 60.0, {
            world().joint_compliance_all(60.0).unwrap()
        }),
    ]
    .into_iter()
    .enumerate()
    {
        let found = of(&bench, &world, "tight", seed as u64);
        assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence);
        assert_eq!(labels(&found), [label]);
        assert_eq!(found.indistinguishable, [[label]]);
        assert!(!found.unexplained);
        let step = &found.steps[0];
        let quantity = step.parameters.values().next().unwrap();
        let pull = (quantity.value - value) / quantity.std;
        assert!(pull.abs() < 3.9, "{label}: {quantity:?}");
        assert!(step.evidence > 20.0 && step.rmse_after < step.rmse_before);
        assert_eq!(step.rmse_after, found.last.rmse);
        assert!((found.last.rmse / found.noise_floor - 1.0).abs() < 0.2);
    }
    let wired = world().joint_swap("r_knee", "l_knee").unwrap();
    let found = of(&bench, &wired, "tight", 9);
    assert_eq!(labels(&found), ["joint_swap:l_knee,r_knee"]);
    assert_eq!(found.verdict, Verdict::Named);
}

#[test]
fn where_nothing_is_planted_nothing_is_found() {
    let bench = Bench::op2();
    for seed in 0..6 {
        let found = of(&bench, &bench.world(), "tight", seed);
        assert_eq!(found.verdict, Verdict::None, "{}", found.sentence);
        assert!(found.steps.is_empty() && found.indistinguishable.is_empty());
        assert!(!found.unexplained);
        assert!((found.last.rmse / found.noise_floor - 1.0).abs() < 0.2);
    }
}

/// DESIGN, what masses absorb: an offset of the sensor and a payload leave nothing.
#[test]
fn free_masses_absorb_what_looks_like_mass() {
    let bench = Bench::op2();
    let payload = bench.world().payload("body_link", 0.3, [0.05, -0.04, 0.06]);
    for (seed, world) in [
        bench.world().sensor_offset([0.006, -0.004]),
        payload.unwrap(),
    ]
    .iter()
    .enumerate()
    {
        let free = of(&bench, world, "free", seed as u64);
        assert_eq!(free.verdict, Verdict::Absorbed, "{}", free.sentence);
        assert!(free.steps.is_empty() && !free.unexplained);
        assert!(free.absorbed_by_masses > 1e-3);
        // The same log, masses trusted.
        let tight = of(&bench, world, "tight", seed as u64);
        assert!(!tight.steps.is_empty(), "{}", tight.sentence);
    }
    // Half of it is left of backlash, and all of a turned sensor.
    let turned = of(&bench, &bench.world().sensor_rotation(0.2), "free", 2);
    assert_eq!(labels(&turned), ["sensor_rotation"], "{}", turned.sentence);
}

/// Offsets about parallel axes: the truth is in the class of explanations.
#[test]
fn parallel_axes_make_a_class_that_holds_the_truth() {
    let bench = Bench::op2();
    for (seed, (joint, offset)) in [
        ("r_ank_pitch", 0.008),
        ("r_knee", 0.012),
        ("r_ank_roll", 0.008),
    ]
    .into_iter()
    .enumerate()
    {
        let world = bench.world().joint_offset(joint, offset).unwrap();
        let found = of(&bench, &world, "tight", seed as u64);
        assert_eq!(found.verdict, Verdict::Class, "{joint}: {}", found.sentence);
        let truth = vec![format!("joint_offset:{joint}")];
        let class = &found.indistinguishable;
        assert!(class.contains(&truth), "{}", found.sentence);
        assert_eq!(found.indistinguishable[0], labels(&found));
        assert_eq!(found.class.len(), found.indistinguishable.len());
        assert_eq!(found.class[0].score_difference, 0.0);
        let behind = found.class.iter().map(|member| member.score_difference);
        assert!(behind.is_sorted());
    }
}

/// A payload on the foot reads as an offset and a gain of the sensor do, which leave the CoM
/// where CAD has it: the class says how far that is from where it is with the payload.
#[test]
fn a_class_says_how_far_its_coms_are_apart() {
    let bench = Bench::op2();
    let (plain, carrying) = (bench.world(), bench.world());
    let carrying = carrying.payload("r_ank_roll_link", 0.15, [0.05, -0.04, 0.0]);
    let carrying = carrying.unwrap();
    let found = of(&bench, &carrying, "tight", 3);
    let q = bench.balanced(POSTURES, 53);
    let postures = q.chunks_exact(bench.model.dof());
    let squares = postures.map(|q| (carrying.com(q) - plain.com(q)).norm_squared());
    let moved = (squares.sum::<f64>() / POSTURES as f64).sqrt();
    let member = |effects: &[&str]| {
        let member = found.class.iter().find(|m| m.effects == effects);
        member.unwrap().com_apart.unwrap()
    };
    assert_eq!(found.class[0].com_apart, Some(0.0));
    let sensor = member(&["sensor_offset", "sensor_gain"]);
    let off = (sensor - moved).abs();
    assert!(off < 0.15 * moved, "{sensor} is not {moved}");
    let payload = member(&["payload:r_ank_roll_link"]);
    assert!(payload < 0.15 * moved, "{payload} of {moved}");
    says(&found.sentence, &["do not agree on the CoM"]);
    // Which of two joints in a row is off by 0.5° makes less than 1 mm.
    let knee = bench.world().joint_offset("r_knee", 0.008).unwrap();
    let found = of(&bench, &knee, "tight", 1);
    assert!(found.class.iter().all(|m| m.com_apart.unwrap() < 1e-3));
    assert!(!found.sentence.contains("do not agree"));
}

/// Four of the list, and noise is all that they leave: imitation is more likely.
#[test]
fn a_crowd_of_effects_is_no_explanation() {
    let bench = Bench::op2();
    let world = bench
        .world()
        .sensor_rotation(0.1)
        .joint_offset("r_knee", 0.05)
        .and_then(|world| world.joint_offset("r_hip_roll", 0.06))
        .and_then(|world| world.joint_offset("l_hip_pitch", 0.2))
        .unwrap();
    let found = of(&bench, &world, "tight", 1);
    assert_eq!(found.steps.len(), 4, "{}", found.sentence);
    assert!(found.leftover.chi2 < 1.15 * found.leftover.expected);
    assert!(found.suspects.is_empty());
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.sentence);
    assert!(found.unexplained && found.indistinguishable.len() == 1);
}

/// Jumps of the CoP with the knee, as no effect and no function makes them.
#[test]
fn what_is_not_in_the_list_stays_unexplained_and_names_its_joint() {
    let bench = Bench::op2();
    let q = bench.balanced(POSTURES, 60);
    let knee = bench.joint("r_knee");
    let data = bench.read(&bench.world(), &q, 1, |_, q| {
        [5e-3, -4e-3].map(|a| a * (14.0 * q[knee]).sin().signum())
    });
    let found = diagnosed(&mut bench.problem(data, "tight")).diagnosis;
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.sentence);
    assert!(found.unexplained);
    let first = Suspect::Position("r_knee".to_string());
    assert_eq!(found.suspects.first(), Some(&first), "{:?}", found.suspects);
    let words = "goes most with the position of r_knee";
    says(&found.sentence, &[words]);
    assert!(found.leftover.suspect_share > 0.5, "{:?}", found.leftover);
}

/// On one foot the joints of its leg carry most of the mass: from which size on their offsets show
/// is said of them, and which offsets do not show of those that show least.
#[test]
fn what_could_not_have_been_seen_is_told_from_what_shows() {
    let bench = Bench::op2();
    let found = of(&bench, &bench.world(), "tight", 1);
    let bearing = found.detectable.iter().map(|own| own.target.as_str());
    let bearing: Vec<&str> = bearing.collect();
    assert_eq!(bearing.len(), 6, "{bearing:?}");
    assert!(
        bearing.iter().all(|joint| joint.starts_with("r_")),
        "{bearing:?}"
    );
    let sizes = |all: &[crate::diagnose::findings::Blind]| -> Vec<f64> {
        all.iter().map(|own| own.from).collect()
    };
    assert!(sizes(&found.detectable).is_sorted());
    assert!(sizes(&found.blind).iter().rev().is_sorted());
    let [best, worst, blind] = [&found.detectable[0], &found.detectable[5], &found.blind[0]];
    // 0.1° and not 0°: two digits.
    assert!(
        best.size.ends_with('°') && !best.size.starts_with("0°"),
        "{}",
        best.size
    );
    says(
        &found.sentence,
        &[
            &format!("{} shows offsets from {} on", best.target, best.size),
            &format!("{} from {} on.", worst.target, worst.size),
            &format!(
                "Could not have been seen: offsets of {} up to {}",
                blind.target, blind.size
            ),
        ],
    );
    assert!(!found.lead.contains("Could not"), "{}", found.lead);
    assert!(found.sentence.contains(&found.lead), "{}", found.lead);
}

/// The title of a page has the effects: below it stand their sizes, and what else may be.
#[test]
fn a_lead_does_not_repeat_the_title_and_the_table_of_errors() {
    let bench = Bench::op2();
    let world = bench.world().joint_offset("r_knee", 0.05).unwrap();
    let found = of(&bench, &world, "tight", 4);
    let said = &found.lead;
    says(said, &["Offset 2.8", "° ± 0.0"]);
    assert!(
        !said.contains("r_knee (offset") && !said.contains("RMS"),
        "{said}"
    );
    assert!(!said.contains("held-out"), "{said}");
    if found.class.len() > 1 {
        // Others have their label beside them.
        let other = &found.class[1];
        says(&found.sentence, &[&other.subjects]);
        says(&other.subjects, &[&format!("({})", other.effects[0])]);
    }
}
