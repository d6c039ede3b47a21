//! Stamps of other rows, and a fault that begins late in a long log.

use std::collections::BTreeSet;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::health::Finding;
use sesc_identify::logs::LogSource;
use sesc_test_support::command::{Folder, says, stderr};
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::Recording;
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{self, fit_request, kinds, white};

/// An OP2 that swings at up to 0.4 Hz with noise of 0.5 mm.
fn swing(seconds: f64, rate: f64, seed: u64) -> Recording {
    let stage = Stage::new(Platform::Op2);
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let swing = Swing::new(0.4, 0.15, seconds);
    swing.record(&stage, stage.world(), white(5e-4), rate, random)
}

fn fitted(log: impl Into<LogSource>) -> Vec<Finding> {
    asked::fitted(&fit_request(&Stage::new(Platform::Op2), log)).health
}

/// Finds this of a recording, and nothing else.
fn finds(recording: &Recording, only: &[(&str, &str)]) {
    assert_eq!(kinds(&fitted(recording.table(true))), only);
}

#[test]
fn stamps_of_other_rows_are_seen() {
    let sound = swing(30.0, 50.0, 300);
    let n = sound.t.len();
    finds(&sound, &[]);
    let mut permuted = sound.clone();
    // 1500 and 617 have no common divisor.
    permuted.t = (0..n).map(|k| sound.t[(617 * k + 11) % n]).collect();
    finds(&permuted, &[("rows_shuffled", "t")]);
    let mut reversed = sound.clone();
    reversed.t.reverse();
    finds(&reversed, &[("rows_shuffled", "t")]);
    // Whole rows in another order, and one recording behind another.
    let mut rows = sound.clone();
    for k in 0..n {
        let from = (617 * k + 11) % n;
        rows.t[k] = sound.t[from];
        rows.q[k] = sound.q[from].clone();
        rows.cop[k] = sound.cop[from];
    }
    finds(&rows, &[]);
    let mut twice = sound.clone();
    let late = n / 2;
    let again: Vec<f64> = sound.t[..n - late].to_vec();
    twice.t[late..].copy_from_slice(&again);
    finds(&twice, &[]);
}

/// Rows 60,000 to 70,000 of 100,000 are frozen, those from 62,000 on lie beyond the sole.
#[test]
fn a_fault_that_begins_late_in_a_long_log_is_found() {
    let mut recording = swing(200.0, 500.0, 310);
    assert_eq!(recording.t.len(), 100_000);
    let last = recording.cop[60_000];
    recording.cop[60_000..70_000].fill(last);
    let csv = LogSource::bytes("log.csv", recording.csv(true).into_bytes());
    for log in [recording.table(true).into(), csv] {
        let found = fitted(log);
        assert_eq!(kinds(&found), [("cop_frozen", "-")]);
        says(&found[0].sentence, &["rows that were looked at"]);
        let picture = found[0].picture.as_ref().unwrap();
        let meant: Vec<usize> = picture.points.iter().filter(|p| p.2).map(|p| p.0).collect();
        let inside = |row: &usize| (60_001..=70_000).contains(row);
        assert!(meant.len() > 20 && meant.iter().all(inside), "{meant:?}");
        let numbers: BTreeSet<usize> = picture.points.iter().map(|p| p.0).collect();
        let shown = picture.rows.iter().map(|row| row.number);
        assert!(numbers.into_iter().eq(shown));
        for row in &picture.rows {
            assert_eq!(row.q, recording.q[row.number - 1], "row {}", row.number);
        }
    }
}

/// Rows that are 10 ms apart by stamps in ms are 10 s apart for who reads seconds.
#[test]
fn stamps_in_milliseconds_and_stamps_that_stand_still_are_warned_of() {
    let mut recording = swing(30.0, 100.0, 320);
    let folder = Folder::with("op2");
    let said = |recording: &Recording| {
        folder.write("log.csv", recording.csv(true));
        stderr(&folder.run("fit op2.urdf --support r_sole --data log.csv"))
    };
    let sound = said(&recording);
    assert!(!sound.contains("`t`"), "{sound}");
    recording.t.iter_mut().for_each(|t| *t *= 1e3);
    says(said(&recording), &["is `t` in ms?"]);
    recording.t.fill(3.0);
    says(said(&recording), &["`t` is 3 in every row"]);
}
