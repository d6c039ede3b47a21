use std::collections::BTreeMap;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_model::{Information, Parameter, Quantity};

use super::*;
use crate::tests::says;

const N: usize = 12;

/// Rows over deviations of a log of the seed: some directions well known, some hardly.
fn rows(seed: u64) -> DMatrix<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    DMatrix::from_fn(30, N, |_, k| {
        random.random_range(-1.0..1.0) * 10_f64.powi(1 + k as i32 % 3)
    })
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    // Twelve uniform numbers add up to a variance of 1.
    (0..12).map(|_| random.random_range(-0.5..0.5)).sum()
}

/// The fit of `truth` by a log with noise of the seed.
fn fitted(truth: &[f64], seed: u64) -> ModelFile {
    let rows = rows(seed);
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0xabcd);
    let noise = DVector::from_fn(rows.nrows(), |_, _| normal(&mut random));
    let reading = &rows * DVector::from_row_slice(truth) + noise;
    let found = rows.clone().svd(true, true).solve(&reading, 0.0).unwrap();
    let mut file = empty();
    let parameter = |k: usize| Parameter {
        name: format!("link_{k}.x"),
        value: found[k],
        std: Some(0.0),
        source: None,
    };
    file.parameters = (0..N).map(parameter).collect();
    file.inform(Information::of(&rows));
    file
}

fn empty() -> ModelFile {
    let text = "robot = \"r\"\nhash = \"h\"\nsupport = \"foot\"\nparameters = []\n";
    ModelFile::parse(text, "a.toml").unwrap()
}

fn with_effect(mut file: ModelFile, target: &str, values: &[(&str, f64, f64)]) -> ModelFile {
    let quantity = |value: f64, std: f64| Quantity {
        value,
        std: Some(std),
    };
    let values = values.iter().map(|(name, value, std)| {
        let name = (*name).to_string();
        (name, quantity(*value, *std))
    });
    file.effects.push(EffectRecord {
        effect: "joint_offset".into(),
        target: target.into(),
        parameters: values.collect::<BTreeMap<_, _>>(),
        ..EffectRecord::default()
    });
    file
}

/// In 400 pairs without a change, chance makes about one in a hundred look like one; with a
/// change of one well known parameter by six deviations, nine in ten are seen.
#[test]
fn a_change_is_told_from_chance() {
    let truth = [0.3; N];
    let mut moved = truth;
    // Column 2 is known to about 1/(100 √30 · 0.58) each.
    moved[2] += 6.0 * 2_f64.sqrt() / (100.0 * 30_f64.sqrt() * 0.58);
    let (mut alarms, mut seen) = (0, 0);
    for seed in 0..400 {
        let pair = |truth: &[f64], other: &[f64]| {
            compare(&fitted(truth, 2 * seed), &fitted(other, 2 * seed + 1)).unwrap()
        };
        alarms += usize::from(pair(&truth, &truth).changed);
        seen += usize::from(pair(&truth, &moved).changed);
    }
    assert!(alarms <= 9, "{alarms}");
    assert!(seen > 360, "{seen}");
}

/// A parameter's own deviation of the difference is that of two independent fits.
#[test]
fn deviations_of_differences_hold() {
    let truth = [0.1; N];
    let mut squares = Vec::new();
    for seed in 0..300 {
        let found = compare(&fitted(&truth, 2 * seed), &fitted(&truth, 2 * seed + 1)).unwrap();
        let parameters = found.parameters.iter();
        squares.extend(parameters.map(|p| p.deviations.unwrap().powi(2)));
    }
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!((0.9..1.1).contains(&mean), "{mean}");
}

#[test]
fn effects_appear_go_and_change() {
    let offset = |value: f64| [("offset_rad", value, 0.001)];
    let before = with_effect(empty(), "knee", &offset(0.02));
    let before = with_effect(before, "hip", &offset(0.03));
    let before = with_effect(before, "toe", &offset(0.01));
    let after = with_effect(empty(), "hip", &offset(0.031));
    let after = with_effect(after, "toe", &offset(0.02));
    let after = with_effect(after, "elbow", &offset(0.05));
    let found = compare(&before, &after).unwrap();
    let targets = found.effects.iter().map(|e| &*e.target);
    assert_eq!(targets.collect::<Vec<_>>(), ["knee", "hip", "toe", "elbow"]);
    use Change::{Appeared, Changed, Gone, Same};
    let changes = found.effects.iter().map(|e| e.change);
    let changes: Vec<Change> = changes.collect();
    assert_eq!(changes, [Gone, Same, Changed, Appeared]);
    let toe = found.effects[2].parameters[0].deviations.unwrap();
    assert!((toe - 0.01 / (0.001 * 2_f64.sqrt())).abs() < 1e-9, "{toe}");
    assert!(found.changed);
}

#[test]
fn the_same_file_is_no_change() {
    let file = with_effect(fitted(&[0.2; N], 3), "knee", &[("offset_rad", 0.02, 0.001)]);
    let found = compare(&file, &file).unwrap();
    assert!(!found.changed);
    assert_eq!(found.chi2, 0.0);
    assert_eq!(found.chance, Some(1.0));
}

#[test]
fn models_of_other_robots_are_refused_by_name() {
    let mut other = fitted(&[0.2; N], 3);
    other.file = "b.toml".into();
    other.parameters[4].name = "arm.x".into();
    let refused = |other: &ModelFile| compare(&fitted(&[0.2; N], 3), other).unwrap_err();
    says(refused(&other), &["`arm.x`"]);
    let mut elsewhere = fitted(&[0.2; N], 3);
    elsewhere.support = "hand".into();
    says(refused(&elsewhere), &["`hand`", "`foot`"]);
}
