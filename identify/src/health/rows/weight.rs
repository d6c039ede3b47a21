//! What the sensor weighs, where a log has its total force.
//!
//! ```text
//! m(t) = ⟨f_z⟩ / (g + ⟨c̈_z⟩)        ⟨c̈_z⟩ = (c_z(t + h) − 2 c_z(t) + c_z(t − h)) / h²
//! ```
//!
//! ⟨⟩ is a mean under a triangle of half width h, for which CAD's second difference is exact: no
//! acceleration is read. Rows that stand by themselves have their own force, and no c̈_z.
//!
//! ```text
//! held     m < 0.92 min(median m, CAD): a hand, a tether, a second contact, a fall
//! levels   two values of m with little between them: a load that was put on or off
//! mass     mean of m ± hypot(scatter of the means of ten stretches / √10, 0.5 % of it)
//! ```

use std::ops::Range;

use sesc_model::inertia::GRAVITY;
use sesc_model::text::listed;
use sesc_model::{Function, Model};

use super::LogRows;
use super::screen::LeftOut;
use crate::evaluate::Evaluator;
use crate::health::criteria::weight::{
    APART_S, CLEARLY, HALF_S, HELD, LEVELS, LEVELS_APART, NOISE, PLATE, SHORTEST_S, STRETCHES,
};
use crate::health::criteria::{FEW_ROWS, FORCE_UNLIKE};
use crate::health::view::{mean, scatter};
use crate::health::{Finding, Kind};
use crate::logs::{Quantity, Weight, keep_some};
use crate::observations::noise::quantile;
use crate::observations::postures::range;

/// Rows of a log with what stands on the sensor in each.
pub(super) struct Weighed<'r> {
    rows: &'r LogRows,
    /// Mass of the URDF, kg.
    cad: f64,
    /// Rows in which something stands on the sensor.
    own: Vec<usize>,
    /// kg, of each of these.
    mass: Vec<f64>,
}

impl<'r> Weighed<'r> {
    /// Rows that stay by these rules; none of a log without total force, or where that is not the
    /// weight. The sum of foot cells is not calibrated, and weighs nothing.
    pub(super) fn new(rows: &'r LogRows, model: &Model, rules: &LeftOut) -> Option<Weighed<'r>> {
        let load = rows.block.load.as_ref()?;
        let own = rows.kept(rules);
        let gravity = |k: &usize| match &rows.block.gravity {
            Some(all) => -all[*k][2],
            None => GRAVITY,
        };
        let force: Vec<f64> = own.iter().map(|k| load[*k].abs() / gravity(k)).collect();
        let ratio = quantile(force.iter().copied(), 0.5)? / model.tree.mass;
        if own.len() < FEW_ROWS || !(1.0 / FORCE_UNLIKE..FORCE_UNLIKE).contains(&ratio) {
            return None;
        }
        let com = Evaluator::new(model, Function::Com).fastest();
        let com = com.run(&rows.block.q, rows.len());
        let height: Vec<f64> = own.iter().map(|k| com[3 * k + 2]).collect();
        let t = rows.block.t.as_ref();
        let t: Option<Vec<f64>> = t.map(|t| own.iter().map(|k| t[*k]).collect());
        let pose = |k: usize| rows.block.pose[own[k]];
        let follows = |k: usize| match &t {
            Some(t) => (0.0..APART_S).contains(&(t[k] - t[k - 1])),
            None => pose(k) == pose(k - 1),
        };
        let mut weighed = Weighed {
            rows,
            cad: model.tree.mass,
            mass: Vec::with_capacity(own.len()),
            own: own.clone(),
        };
        let mut start = 0;
        for end in 1..=own.len() {
            if end == own.len() || !follows(end) || own[end] != own[end - 1] + 1 {
                weighed.run(start..end, t.as_deref(), &force, &height);
                start = end;
            }
        }
        Some(weighed)
    }

    /// Weigh rows that follow each other.
    fn run(&mut self, run: Range<usize>, t: Option<&[f64]>, force: &[f64], height: &[f64]) {
        let (force, height) = (&force[run.clone()], &height[run.clone()]);
        let t = t.map_or(&[][..], |t| &t[run]);
        let span = t.last().unwrap_or(&0.0) - t.first().unwrap_or(&0.0);
        let half = HALF_S.min(0.5 * span);
        if half < SHORTEST_S {
            self.mass.extend(force.iter().map(|_| mean(force)));
            return;
        }
        let at = |time: f64| {
            let k = t.partition_point(|own| *own < time).clamp(1, t.len() - 1);
            let part = (time - t[k - 1]) / (t[k] - t[k - 1]).max(f64::MIN_POSITIVE);
            height[k - 1] + part.clamp(0.0, 1.0) * (height[k] - height[k - 1])
        };
        for own in t {
            let middle = own.clamp(t[0] + half, t[t.len() - 1] - half);
            let first = t.partition_point(|other| *other < middle - half);
            let (mut sum, mut weights) = (0.0, 0.0);
            for (other, force) in t.iter().zip(force).skip(first) {
                let weight = 1.0 - (other - middle).abs() / half;
                if *other > middle && weight <= 0.0 {
                    break;
                }
                sum += weight.max(0.0) * force;
                weights += weight.max(0.0);
            }
            let bend = at(middle + half) - 2.0 * at(middle) + at(middle - half);
            let gain = bend / (half * half) / GRAVITY;
            // No robot falls faster than half as fast as it can, or CAD's joints leap.
            self.mass.push(sum / weights / (1.0 + gain).max(0.5));
        }
    }

    /// Places of neighbouring rows in the log, and how many they are, of rows that are `meant`.
    fn stretches(&self, meant: &[bool]) -> Vec<Range<usize>> {
        let places: Vec<usize> = (0..meant.len()).filter(|k| meant[*k]).collect();
        let stretches = places.chunk_by(|a, b| *b == a + 1);
        let ends = stretches.map(|own| own[0]..own[own.len() - 1] + 1);
        ends.collect()
    }

    /// These stretches in words.
    fn named(&self, stretches: &[Range<usize>]) -> String {
        let number = |k: usize| self.rows.number(self.own[k]);
        let named = stretches.iter();
        let named = named.map(|own| format!("{} to {}", number(own.start), number(own.end - 1)));
        listed(named, 4)
    }

    fn finding(&self, kind: Kind, sentence: String, meant: &[bool]) -> Finding {
        let is_meant = |k: usize| self.own.binary_search(&k).is_ok_and(|at| meant[at]);
        let load = |k: usize| self.rows.load(k);
        let about = (kind, "-", sentence);
        self.rows.finding(about, "Total force, N", load, is_meant)
    }

    /// Take out the stretches in which something else carries the robot.
    pub(super) fn held(&mut self, left_out: &mut LeftOut) -> Option<Finding> {
        let typical = quantile(self.mass.iter().copied(), 0.5)?;
        let least = typical.min(self.cad);
        let steps = self.mass.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        // Differences of two normal values have 0.95 of their deviation as median.
        let noise = quantile(steps, 0.5)? / 0.95;
        let most = least - (HELD * least).max(NOISE * noise);
        let meant: Vec<bool> = self.mass.iter().map(|mass| *mass < most).collect();
        let count = meant.iter().filter(|meant| **meant).count();
        if count == 0 {
            return None;
        }
        let stretches = self.stretches(&meant);
        let line = |k: usize| self.rows.block.line[self.own[k]];
        let held = |own: &Range<usize>| line(own.start)..=line(own.end - 1);
        left_out.held.extend(stretches.iter().map(held));
        let low = 100.0 * range(self.mass.iter().copied()).0 / least;
        let sentence = format!(
            "In {} ({:.0} %; {}) the total force is less than the weight, down to {low:.0} % of it: \
             something else carries the rest (a hand, a tether, a second contact), or the robot \
             falls; they are left out.",
            self.rows.some(count),
            100.0 * count as f64 / self.rows.len() as f64,
            self.named(&stretches),
        );
        let finding = self.finding(Kind::ContactLost, sentence, &meant);
        let free: Vec<bool> = meant.iter().map(|meant| !meant).collect();
        keep_some(&mut self.own, 1, &free);
        keep_some(&mut self.mass, 1, &free);
        Some(finding)
    }

    /// What the log weighs, and a finding where that has two levels.
    pub(super) fn weight(&self) -> (Option<Weight>, Option<Finding>) {
        if self.mass.len() < STRETCHES {
            return (None, None);
        }
        let long = self.mass.chunks(self.mass.len().div_ceil(STRETCHES));
        let means: Vec<f64> = long.map(mean).collect();
        let value = mean(&self.mass);
        let uncertainty = scatter(&means) / (means.len() as f64 - 1.0).max(1.0).sqrt();
        let levels = self.levels();
        let apart = levels.as_ref().map_or(0.0, |(apart, _)| 0.5 * apart);
        let weight = Weight {
            mass_kg: Quantity {
                value,
                std: uncertainty.hypot(PLATE * value).hypot(apart),
            },
            urdf_kg: self.cad,
        };
        (Some(weight), levels.map(|(_, finding)| finding))
    }

    /// How far two levels are apart, kg, with what is said of them.
    fn levels(&self) -> Option<(f64, Finding)> {
        let at = |part: f64| quantile(self.mass.iter().copied(), part);
        let mut middle = 0.5 * (at(0.02)? + at(0.98)?);
        let of = |middle: f64| {
            let (high, low): (Vec<f64>, Vec<f64>) = self.mass.iter().partition(|x| **x > middle);
            [low, high]
        };
        for _ in 0..LEVELS {
            let [low, high] = of(middle);
            middle = 0.5 * (mean(&low) + mean(&high));
        }
        let [low, high] = of(middle);
        let count = low.len().min(high.len());
        let apart = mean(&high) - mean(&low);
        let within = scatter(&low).hypot(scatter(&high));
        let clear = apart > CLEARLY * self.cad && apart > LEVELS_APART * within;
        if !clear || count < STRETCHES {
            return None;
        }
        let meant: Vec<bool> = self.mass.iter().map(|mass| *mass > middle).collect();
        let sentence = format!(
            "The total force has two levels: {:.3} kg in rows {}, {:.3} kg in the others: a load of \
             {apart:.3} kg was on the robot in a part of the log. A payload is one of the whole \
             log: split it there, and take each part by itself.",
            mean(&high),
            self.named(&self.stretches(&meant)),
            mean(&low),
        );
        let finding = self.finding(Kind::ForceUnlikeWeight, sentence, &meant);
        Some((apart, finding))
    }
}
