//! Rows that are left out, and what is found in the rest.

use std::sync::Arc;

use sesc_identify::diagnose::Verdict;
use sesc_identify::health::Finding;
use sesc_identify::robot::Robot;
use sesc_reference::World;
use sesc_test_support::command::says;
use sesc_test_support::stage::{Platform, Stage};

use super::log::{Log, NOISE_M, POSTURES};
use crate::asked::kinds;

/// An offset that is to be found in what is left.
const OFFSET: f64 = 0.05;

pub(super) fn hidden(w: World) -> World {
    w.joint_offset("r_ank_pitch", OFFSET).unwrap()
}

/// The kinds and targets of all findings; the rest is diagnosed as ever.
pub(super) fn found_beside(log: &Log) -> Vec<(String, String)> {
    let found = log.diagnose();
    let group = ["r_ank_pitch", "r_knee", "r_hip_pitch", "ground_slope"];
    let one = |all: &Vec<String>| all.len() == 1 && group.iter().any(|g| all[0].contains(g));
    let class = &found.indistinguishable;
    assert!(class.iter().any(one), "{class:?}");
    assert!(found.last.rmse < 3.0 * NOISE_M, "{}", found.last.rmse);
    owned(&found.health)
}

pub(super) fn only(kind: &str, target: &str) -> Vec<(String, String)> {
    vec![(kind.to_string(), target.to_string())]
}

/// Kinds of findings, and what each is of.
pub(super) fn owned(health: &[Finding]) -> Vec<(String, String)> {
    let named = kinds(health).into_iter();
    named
        .map(|(kind, target)| (kind.to_string(), target.to_string()))
        .collect()
}

#[test]
fn a_stretch_without_contact_is_left_out() {
    let mut log = Log::of("r_sole", &[], hidden, 60);
    log.cop[20..32].fill([0.0; 2]);
    assert_eq!(found_beside(&log), only("contact_lost", "-"));
}

#[test]
fn readings_far_beyond_the_sole_are_left_out() {
    let mut log = Log::of("r_sole", &[], hidden, 61);
    for k in [7, 21, 40, 66] {
        log.cop[k] = [1.7, -0.9];
    }
    assert_eq!(found_beside(&log), only("cop_outside_sole", "-"));
}

/// A box as large as the OP2's foot, beside it; a reading 0.19 m away may be an offset where
/// the sole is not known, and is none where it is.
#[test]
fn the_shape_of_the_sole_says_what_lies_beyond() {
    let mut log = Log::of("r_sole", &[], |w| w, 69);
    // Balanced: the cloud of CoPs is not what decides.
    log.q.iter_mut().flatten().for_each(|q| *q *= 0.1);
    let world = Stage::new(Platform::Op2).world();
    let at = world.cop(&log.q[0]);
    let pairs = log.cop.iter_mut().zip(&log.q).enumerate();
    for (k, (cop, q)) in pairs {
        let by = NOISE_M * (2.1 * k as f64).sin();
        *cop = world.cop(q).map(|x| x + by);
    }
    for k in [7, 30] {
        log.cop[k][0] = at[0] + 0.14;
    }
    assert_eq!(kinds(&log.diagnose().health), []);
    let shape = format!(
        "<link name='r_sole'><collision><origin xyz='{} {} 0.01'/><geometry>\
         <box size='0.104 0.066 0.02'/></geometry></collision></link>",
        at[0], at[1]
    );
    let text = log.robot.text().replace("<link name=\"r_sole\"/>", &shape);
    assert!(text.contains("collision"));
    log.robot = Arc::new(Robot::parse(&text, "op2.urdf").unwrap());
    let found = log.diagnose();
    assert_eq!(kinds(&found.health), [("cop_outside_sole", "-")]);
}

#[test]
fn a_frame_that_is_not_on_the_sole_is_asked_about() {
    let mut log = Log::of("r_sole", &[], |w| w, 62);
    log.cop.iter_mut().for_each(|y| y[0] += 1.2);
    let found = log.diagnose();
    assert_eq!(kinds(&found.health), [("cop_outside_sole", "-")]);
    says(&found.health[0].sentence, &["support frame"]);
}

#[test]
fn copied_rows_count_once() {
    let mut log = Log::of("r_sole", &[], hidden, 63);
    for k in 0..POSTURES / 2 {
        log.q.push(log.q[k].clone());
        log.cop.push(log.cop[k]);
    }
    assert_eq!(found_beside(&log), only("rows_copied", "-"));
    let found = log.diagnose();
    assert_eq!(found.postures, POSTURES);
    let samples = found.samples;
    assert_eq!([samples.rows, samples.independent], [POSTURES; 2]);
    // A fit counts them once, too, with stamps of their own.
    let found = log.fit();
    assert_eq!(found.samples.rows, POSTURES);
    assert_eq!(found.readings, POSTURES as u64);
}

/// An end is an end by the side on which values stop, not by its sign: a channel that is clipped
/// from below at a positive value keeps the rest.
#[test]
fn a_clipped_channel_is_named_by_its_column() {
    let mut above = Log::of("r_sole", &[], hidden, 64);
    let mut below = above.clone();
    let mut x: Vec<f64> = above.cop.iter().map(|y| y[0]).collect();
    x.sort_by(f64::total_cmp);
    let end = x[POSTURES - 10];
    above.cop.iter_mut().for_each(|y| y[0] = y[0].min(end));
    assert_eq!(found_beside(&above), only("channel_saturated", "cop_x"));
    let positive = x.iter().position(|x| *x > 0.0).unwrap();
    let least = positive.max(10);
    assert!(least < POSTURES / 2, "{least}");
    below.cop.iter_mut().for_each(|y| y[0] = y[0].max(x[least]));
    assert_eq!(found_beside(&below), only("channel_saturated", "cop_x"));
    let found = below.diagnose();
    assert_eq!(found.postures, POSTURES - least - 1);
}

#[test]
fn coarse_steps_of_a_channel_are_said_and_fine_ones_are_not() {
    let mut log = Log::of("r_sole", &[], hidden, 65);
    let fine = log.clone();
    log.stated = Some(NOISE_M);
    let rows = log.cop.iter_mut();
    rows.for_each(|y| y[1] = (y[1] / 0.004).round() * 0.004);
    let found = log.diagnose();
    assert_eq!(kinds(&found.health), [("channel_saturated", "cop_y")]);
    assert_ne!(found.verdict, Verdict::Unexplained, "{}", found.sentence);
    // Where nobody states the noise, it is what masses leave less what steps are of that.
    log.stated = None;
    let found = log.diagnose();
    assert_eq!(kinds(&found.health), [("channel_saturated", "cop_y")]);
    let mut log = fine;
    let rows = log.cop.iter_mut();
    rows.for_each(|y| *y = y.map(|x| (x / 1e-4).round() * 1e-4));
    assert_eq!(found_beside(&log), []);
}

#[test]
fn noise_that_is_far_too_large_is_said() {
    let mut log = Log::of("r_sole", &[], |w| w, 66);
    log.stated = Some(NOISE_M);
    assert!(log.diagnose().health.is_empty());
    log.stated = Some(5.0 * NOISE_M);
    let found = log.diagnose();
    assert_eq!(kinds(&found.health), [("noise_overstated", "-")]);
    says(&found.health[0].sentence, &["1.50 mm"]);
}

/// Four cells, of which one is unplugged, or all are lifted for a while.
#[test]
fn cells_without_load_are_named() {
    let mut log = Log::of("r_sole", &[], |w| w, 67);
    let (a, b) = (0.12, 0.12);
    log.places = vec![[a, b], [a, -b], [-a, -b], [-a, b]];
    // Loads of a rectangle of cells by bilinear shares.
    let share = |x: f64, half: f64| 0.5 * (1.0 + x / half);
    let loads = |[x, y]: [f64; 2]| -> Vec<f64> {
        let (x, y) = (share(x, a), share(y, b));
        [x * y, x * (1.0 - y), (1.0 - x) * (1.0 - y), (1.0 - x) * y]
            .map(|f| 29.0 * f)
            .to_vec()
    };
    log.cells = log.cop.iter().map(|y| loads(*y)).collect();
    assert!(log.diagnose().health.is_empty());
    let mut lifted = log.clone();
    let rows = lifted.cells[30..45].iter_mut();
    rows.for_each(|row| row.fill(0.0));
    let found = lifted.diagnose();
    assert_eq!(kinds(&found.health), [("contact_lost", "-")]);
    assert_eq!(found.verdict, Verdict::None);
    assert_eq!(found.postures, POSTURES - 15);
    log.cells.iter_mut().for_each(|row| row[1] = 0.0);
    let found = log.diagnose();
    assert_eq!(kinds(&found.health), [("contact_lost", "fsr_2")]);
}

/// The noise is not known: it is taken from what is left, and columns are looked at all the same.
#[test]
fn broken_columns_are_seen_without_a_known_noise() {
    let mut log = Log::of("r_sole", &[], |w| w, 68);
    log.noise_is_given = false;
    assert!(log.diagnose().health.is_empty());
    let mut dead = log.clone();
    dead.cop.iter_mut().for_each(|y| *y = [0.01, -0.02]);
    let stuck = log.stuck("r_knee", 0.1);
    for (log, only) in [
        (dead, ("cop_constant", "-")),
        (stuck, ("encoder_stuck", "r_knee")),
    ] {
        assert_eq!(kinds(&log.diagnose().health), [only]);
    }
}
