//! Fleets of rows that are drawn, not diagnosed: what is known of them is known exactly.

use std::collections::BTreeMap;
use std::ops::RangeBounds;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use super::super::{Summary, summary};
use crate::diagnose::{Quantity, Verdict};
use crate::fleet::row::{EffectFound, Effects, Row};

/// Deviation of a drawn offset, rad, and of a drawn parameter, m.
pub(super) const STD: f64 = 0.001;
pub(super) const PARAMS: usize = 43;

/// Parameters that have nothing to do with each other.
fn independent() -> Vec<f64> {
    let row = |i: usize| (0..=i).map(move |j| if i == j { STD * STD } else { 0.0 });
    (0..PARAMS).flat_map(row).collect()
}

/// Joints whose offset every row scores.
const SCORED: usize = 30;

/// An offset of a joint as the whole explanation.
fn scored(joint: &str, value: f64) -> EffectFound {
    EffectFound {
        effect: "joint_offset".into(),
        target: joint.into(),
        parameters: [("offset_rad".to_string(), Quantity { value, std: STD })].into(),
        absent: BTreeMap::new(),
        evidence: (value / STD).powi(2) - 10.0,
    }
}

pub(super) struct Drawn {
    pub random: ChaCha8Rng,
    pub rows: Vec<Row>,
}

impl Drawn {
    /// A row for each robot and day, parameters with noise alone.
    pub(super) fn fleet(robots: usize, days: usize, seed: u64) -> Drawn {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut of_scores = ChaCha8Rng::seed_from_u64(!seed);
        let mut rows = Vec::new();
        for robot in 0..robots {
            for day in 1..=days {
                let mut normal = |_| -> f64 { StandardNormal.sample(&mut random) };
                rows.push(Row {
                    robot: format!("r{robot:02}"),
                    day: day.to_string(),
                    urdf_hash: "a".into(),
                    support: "sole".into(),
                    postures: 60,
                    independent: 60,
                    verdict: Some(Verdict::None),
                    params: (0..PARAMS).map(|k| STD * normal(k)).collect(),
                    std: vec![Some(STD); PARAMS],
                    covariance: independent(),
                    effects: Effects {
                        scores: (0..SCORED)
                            .map(|k| {
                                scored(
                                    &format!("j{k}"),
                                    STD * of_scores.sample::<f64, _>(StandardNormal),
                                )
                            })
                            .collect(),
                        ..Effects::default()
                    },
                    ..Row::default()
                });
            }
        }
        Drawn { random, rows }
    }

    pub(super) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    /// Rows of a robot on some days.
    pub(super) fn rows(
        &mut self,
        robot: usize,
        days: impl RangeBounds<usize>,
    ) -> impl Iterator<Item = &mut Row> {
        let name = format!("r{robot:02}");
        let is_on = move |day: &str| days.contains(&day.parse::<usize>().unwrap());
        let rows = self.rows.iter_mut();
        rows.filter(move |row| row.robot == name && is_on(&row.day))
    }

    /// An offset of a robot's joint on some days.
    pub(super) fn offset(
        &mut self,
        robot: usize,
        joint: &str,
        size: f64,
        days: impl RangeBounds<usize>,
    ) {
        for k in 0..self.rows.len() {
            let value = size + STD * self.normal();
            let row = &mut self.rows[k];
            let day: usize = row.day.parse().unwrap();
            if row.robot != format!("r{robot:02}") || !days.contains(&day) {
                continue;
            }
            row.verdict = Some(Verdict::Named);
            // What is fitted without effects takes the offset for masses elsewhere.
            row.params[7] += value;
            let found = scored(joint, value);
            row.effects.scores.insert(0, found.clone());
            row.effects.explanation.push(EffectFound {
                evidence: 100.0,
                ..found
            });
        }
    }

    pub(super) fn summary(&self) -> Summary {
        summary(&self.rows, None)
    }
}
