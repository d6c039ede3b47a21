//! What to change: signs and ticks by closed forms, sentences of every effect.

use std::f64::consts::TAU;
use std::sync::Arc;

use sesc_model::effects::{Catalog, EffectContext, EncoderMap, instances};

use super::{Bench, NOISE, SKEW};
use crate::diagnose::remedy::{Change, Servo, Step};
use crate::diagnose::{Report, Request, Suspect, Verdict, diagnose};
use crate::logs::Table;
use crate::next_steps::NextStep;
use crate::robot::Robot;

/// q = s u (n − z)
fn reading(servo: Servo, ticks: f64) -> f64 {
    f64::from(servo.sign) * servo.per_tick() * (ticks - f64::from(servo.zero))
}

#[test]
fn a_corrected_servo_reads_the_true_angle() {
    let steps = [
        Step::TicksPerTurn(4096.0),
        Step::TicksPerTurn(1000.0),
        Step::MetresPerTick(1e-5),
    ];
    for step in steps {
        for (zero, sign) in [(2048, 1), (2050, -1), (-7, 1)] {
            let old = Servo { zero, sign, step };
            for (scale, offset) in [(1.0, 0.0265), (1.0, -0.3), (0.93, 0.1), (-1.0, 0.02)] {
                let new = old.corrected(EncoderMap { scale, offset }).unwrap();
                // A whole zero leaves half a tick.
                let most = 0.501 * new.per_tick();
                for ticks in [0.0, 100.0, 2048.0, 4000.0] {
                    let truth = scale * reading(old, ticks) + offset;
                    let off = (reading(new, ticks) - truth).abs();
                    assert!(off <= most, "{old:?} {scale} {offset}: {off:e}");
                }
            }
        }
    }
    let nowhere = EncoderMap {
        scale: 0.0,
        offset: 0.1,
    };
    assert_eq!(Servo::default().corrected(nowhere), None);
}

#[test]
fn a_positive_offset_lowers_the_zero_of_a_servo_that_counts_forward() {
    let offset = 1.517_f64.to_radians();
    let map = EncoderMap { scale: 1.0, offset };
    let zero = |servo: Servo| servo.corrected(map).unwrap().zero;
    assert_eq!(zero(Servo::default()), 2031);
    let backwards = Servo {
        sign: -1,
        ..Servo::default()
    };
    assert_eq!(zero(backwards), 2065);
}

const OFFSET: f64 = 0.05;

/// The skewed robot whose hip stands 0.05 rad further than its encoder reads.
fn report(servos: &[(&str, Servo)]) -> Report {
    let bench = Bench::skew();
    let q = bench.postures(60, 3);
    let world = bench.world().joint_offset("hip", OFFSET).unwrap();
    let data = bench.log(&world, &q, 3);
    let column = |values: &[f64], from: usize| -> Vec<f64> {
        values.iter().skip(from).step_by(2).copied().collect()
    };
    let log = Table::new("log.csv")
        .numbers("hip", column(&q, 0))
        .numbers("knee", column(&q, 1))
        .numbers("cop_x", column(&data.reading, 0))
        .numbers("cop_y", column(&data.reading, 1));
    let robot = Robot::parse(SKEW, "skew.urdf").unwrap();
    let mut request = Request::new(Arc::new(robot), log);
    request.support = Some("foot".into());
    request.noise = Some(NOISE);
    request.floor = 0.0;
    request.corrected_urdf = true;
    request.servos = servos.iter().map(|(j, s)| ((*j).to_string(), *s)).collect();
    diagnose(&request, &mut ()).unwrap()
}

#[test]
fn an_offset_is_told_by_sign_ticks_and_urdf_lines() {
    // Truth is reading plus offset in the robot that was bent.
    let bench = Bench::skew();
    let hidden = bench.world().joint_offset("hip", OFFSET).unwrap();
    let (told, truth) = (
        hidden.cop(&[0.2, -0.1]),
        bench.world().cop(&[0.2 + OFFSET, -0.1]),
    );
    assert!((0..2).all(|axis| (told[axis] - truth[axis]).abs() < 1e-12));

    let found = report(&[]);
    let step = &found.diagnosis.steps[0];
    let (remedy, estimate) = (&step.remedy, step.parameters["offset_rad"].value);
    assert_eq!((step.effect, step.target.as_str()), ("joint_offset", "hip"));
    assert_eq!(
        remedy.sentence,
        format!(
            "true angle of hip = reading + {:.3}°",
            estimate.to_degrees()
        )
    );
    let after = (2048.0 - estimate * 4096.0 / TAU).round() as i32;
    let change = Change {
        before: 2048,
        after,
    };
    assert_eq!(remedy.servo_zero, Some(change));
    assert_eq!(remedy.servo_words(), [format!("zero 2048 → {after}")]);
    // The elements after are those of the corrected URDF.
    let urdf = remedy.urdf.as_ref().unwrap();
    assert!(urdf.before.starts_with("<origin xyz='0 0 0.1'"), "{urdf:?}");
    let corrected = found.corrected_urdf.unwrap().text;
    assert!(corrected.contains(&urdf.after) && !corrected.contains(&urdf.before));
    assert_eq!(urdf.line, 1);
    assert_eq!(remedy.not_in_urdf, None);
    assert_eq!(found.diagnosis.left_out_of_urdf, Some(Vec::new()));

    let servo = Servo {
        zero: 500,
        sign: -1,
        step: Step::TicksPerTurn(1024.0),
    };
    let remedy = &report(&[("hip", servo)]).diagnosis.steps[0].remedy;
    let after = (500.0 + estimate * 1024.0 / TAU).round() as i32;
    let change = Change { before: 500, after };
    assert_eq!(remedy.servo_zero, Some(change));
}

#[test]
fn every_effect_says_what_to_change() {
    let bench = Bench::op2();
    let cells = [[0.04, 0.02], [0.04, -0.02], [-0.04, -0.02], [-0.04, 0.02]];
    let context = EffectContext::new(&bench.model, &cells, true, Catalog::standard());
    let mut said = std::collections::HashSet::new();
    for instance in instances(&context) {
        let (effect, target) = (instance.effect, &instance.target);
        for factor in [1.0, -1.0] {
            let scales = instance.scales(&context);
            let unknowns: Vec<f64> = scales.iter().map(|x| factor * x).collect();
            let values = effect.values(&context, target, &unknowns);
            let sentence = effect.remedy(&context, target, &values);
            let label = instance.label(&context);
            assert!(!sentence.contains("held by the model file"), "{label}");
            assert!(!sentence.contains("NaN"), "{label}: {sentence}");
            // What it acts on, what becomes of it, and sizes with their sign.
            let name = context.spoken_name(target);
            let names: Vec<&str> = name.split(',').collect();
            let whole = matches!(name.as_str(), "-") || !effect.label_has_target();
            let way = matches!(target, sesc_model::effects::Target::Way(_));
            if !whole && !way {
                assert!(names.iter().all(|n| sentence.contains(n)), "{sentence}");
            }
            let numbers = effect.parameters(&context, target).len();
            if numbers > 0 {
                assert!(
                    sentence.contains(|c: char| c.is_ascii_digit()),
                    "{sentence}"
                );
            }
            let held = effect.urdf_edit(&name, &|_| 0.1).is_some();
            assert!(held || !effect.urdf_gap().is_empty());
            said.insert(effect.id());
        }
    }
    assert_eq!(said.len(), context.catalog.iter().len());
}

/// Joints may be called like words of the sentences.
#[test]
fn the_name_of_a_joint_chooses_no_advice() {
    let mut found = report(&[]).diagnosis;
    found.verdict = Verdict::Unexplained;
    for joint in ["moment", "load", "position", "place in the log"] {
        let joint = joint.to_string();
        found.suspects = vec![Suspect::Position(joint.clone())];
        assert_eq!(found.next_steps()[0], NextStep::CheckJoint { joint });
    }
    let joint = "r_knee".to_string();
    found.suspects = vec![Suspect::Moment(joint.clone())];
    assert_eq!(found.next_steps()[0], NextStep::CheckLoad { joint });
    found.suspects = vec![Suspect::Place];
    assert_eq!(found.next_steps()[0], NextStep::CheckRecording);
    found.suspects.clear();
    assert_eq!(found.next_steps()[0], NextStep::CheckContact);
}
