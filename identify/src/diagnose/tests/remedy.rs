//! What to change: signs and ticks by closed forms, sentences of every effect.

use std::f64::consts::TAU;

use sesc_model::effects::{Catalog, EffectContext, EncoderMap, instances};

use super::{Bench, HIP, off_hip, request, table};
use crate::NextStep;
use crate::diagnose::remedy::{Change, Servo, Step, changed};
use crate::diagnose::{Report, Suspect, Verdict, diagnose};

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
    let map = |scale: f64, offset: f64| EncoderMap { scale, offset };
    assert_eq!(Servo::default().corrected(map(0.0, 0.1)), None);
    // A positive offset lowers the zero of a servo that counts forward.
    for (sign, zero) in [(1, 2031), (-1, 2065)] {
        let old = Servo {
            sign,
            ..Servo::default()
        };
        let new = old.corrected(map(1.0, 1.517_f64.to_radians())).unwrap();
        assert_eq!(new.zero, zero);
    }
}

/// The report on the skewed robot whose hip is off.
fn report(servos: &[(&str, Servo)]) -> Report {
    let (q, data) = off_hip();
    let mut request = request(table(&q, &data));
    request.servos = servos.iter().map(|(j, s)| ((*j).to_string(), *s)).collect();
    diagnose(&request, &mut ()).unwrap()
}

#[test]
fn an_offset_is_told_by_sign_ticks_and_urdf_lines() {
    // Truth is reading plus offset in the robot that was bent.
    let bench = Bench::skew();
    let hidden = bench.world().joint_offset("hip", HIP).unwrap();
    let (told, truth) = (
        hidden.cop(&[0.2, -0.1]),
        bench.world().cop(&[0.2 + HIP, -0.1]),
    );
    assert!((0..2).all(|axis| (told[axis] - truth[axis]).abs() < 1e-12));

    let found = report(&[]);
    let step = &found.diagnosis.steps[0];
    let (remedy, estimate) = (&step.remedy, step.parameters["offset_rad"].value);
    assert_eq!((step.effect, step.target.as_str()), ("joint_offset", "hip"));
    let degrees = estimate.to_degrees();
    let said = format!("true angle of hip = reading + {degrees:.3}°");
    assert_eq!(remedy.sentence, said);
    let change = |before, after| Some(Change { before, after });
    // Nobody said that the robot has servos.
    assert_eq!(remedy.servo_zero, None);
    assert_eq!(remedy.servo_words(), [""; 0]);
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
    assert_eq!(remedy.servo_zero, change(500, after));
    assert_eq!(remedy.servo_words(), [format!("zero 500 → {after}")]);
    let other = &report(&[("knee", servo)]).diagnosis.steps[0].remedy;
    assert_eq!(other.servo_zero, None);
}

/// Lines of a URDF stay indented against each other.
#[test]
fn lines_of_a_urdf_keep_their_indentation() {
    let old = "<robot>\n  <link name='a'/>\n</robot>\n";
    let new =
        "<robot>\n  <link name='a'/>\n  <link name='b'>\n    <inertial/>\n  </link>\n</robot>\n";
    let change = changed(old, new).unwrap();
    assert_eq!(change.before, "");
    assert_eq!(change.after, "<link name='b'>\n  <inertial/>\n</link>");
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
            let has_digits = sentence.contains(|c: char| c.is_ascii_digit());
            let numbers = effect.parameters(&context, target);
            assert!(has_digits || numbers.is_empty(), "{sentence}");
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
    let mut advice = |suspects: Vec<Suspect>| {
        found.suspects = suspects;
        found.next_steps().swap_remove(0)
    };
    for joint in ["moment", "load", "position", "place in the log"] {
        let joint = joint.to_string();
        let position = Suspect::Position(joint.clone());
        assert_eq!(advice(vec![position]), NextStep::CheckJoint { joint });
    }
    let joint = "r_knee".to_string();
    let moment = Suspect::Moment(joint.clone());
    assert_eq!(advice(vec![moment]), NextStep::CheckLoad { joint });
    assert_eq!(advice(vec![Suspect::Place]), NextStep::CheckRecording);
    assert_eq!(advice(Vec::new()), NextStep::CheckContact);
}
