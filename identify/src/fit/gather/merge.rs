//! Sums of several logs, machines or sessions together, and sums that no logs can have.

use sesc_model::standard::Shift;

use super::Gathered;
use crate::{Message, Setting, message};

/// Sums of a log are not larger, nor its rows more: what values within their bounds give.
const MOST_SUM: f64 = 1e60;
const MOST_ROWS: f64 = 1e15;

impl Gathered {
    /// The first sum that no logs can have, in a file that was read.
    pub(in crate::fit) fn invalid_reason(&self) -> Option<String> {
        let (rows, most) = (self.readings as f64, MOST_SUM);
        let within = |name: &str, x: f64, least: f64, most: f64| {
            let fits = (least..=most).contains(&x);
            (!fits).then(|| format!("`{name}` is {x:?}, which no log gives"))
        };
        let axes = self.axes.iter().find_map(|x| within("axes", *x, 0.0, most));
        let factors = self.folds.iter().find_map(|fold| {
            let sums = [&fold.weighted, &*fold.plain()].map(|sum| (sum.largest(), sum.rows()));
            sums.into_iter().find_map(|(size, rows)| {
                within("triangle", size, 0.0, most)
                    .or_else(|| within("rows", rows as f64, 0.0, MOST_ROWS))
            })
        });
        let each = self
            .folds
            .iter()
            .find_map(|fold| within("each", fold.each, f64::MIN_POSITIVE, most));
        let count = |name: &str, n: u64| within(name, n as f64, 0.0, MOST_ROWS);
        count("readings", self.readings)
            .or_else(|| within("stated", self.stated, 0.0, most))
            .or_else(|| within("trusted", self.trusted, 0.0, rows))
            .or_else(|| within("consistency", self.consistency, f64::MIN_POSITIVE, 1.0))
            .or_else(|| within("averaged", self.averaged, 0.0, rows))
            .or_else(|| count("moved", self.moved))
            .or_else(|| count("overfull", self.overfull))
            .or_else(|| count("tiny", self.tiny))
            .or_else(|| count("motion.rows_left_out", self.motion.rows_left_out))
            .or_else(|| self.logs.iter().find_map(|log| count("rows", log.rows)))
            .or(axes)
            .or(each)
            .or(factors)
            .or_else(|| self.repeats.invalid_reason(MOST_ROWS, most))
            .or_else(|| self.samples.invalid_reason(MOST_ROWS))
            .or_else(|| {
                self.closure
                    .as_ref()
                    .and_then(|found| found.invalid_reason())
            })
            .or_else(|| self.again.as_ref()?.invalid_reason())
    }

    /// Add what another machine or session of measurements gathered.
    ///
    /// # Errors
    /// When the parts differ in parameters, folds or stated deviations.
    pub fn merge(&mut self, other: Gathered) -> Result<(), Message> {
        if self.params() != other.params() {
            let (here, there) = (self.params(), other.params());
            return Err(format!("{here} parameters here, {there} there").into());
        }
        if self.folds.len() != other.folds.len() {
            let (here, there) = (self.folds.len(), other.folds.len());
            return Err(message![
                format!("{here} folds here, {there} there; gather all parts with the same "),
                Setting::Folds
            ]);
        }
        if self.readings > 0
            && other.readings > 0
            && self.has_deviations() != other.has_deviations()
        {
            return Err("one part states deviations of its readings, the other does not".into());
        }
        for log in &other.logs {
            if self.logs.iter().any(|own| own.hash == log.hash) {
                return Err(
                    format!("{} is in both: its postures would count twice", log.file).into(),
                );
            }
        }
        for (fold, more) in self.folds.iter_mut().zip(&other.folds) {
            fold.merge(more);
        }
        self.repeats.merge(&other.repeats);
        self.stated += other.stated;
        self.readings += other.readings;
        self.logs.extend(other.logs);
        self.down_weighted.extend(other.down_weighted);
        self.trusted += other.trusted;
        self.consistency = self.consistency.min(other.consistency);
        self.moved += other.moved;
        self.overfull += other.overfull;
        self.averaged += other.averaged;
        self.tiny += other.tiny;
        self.health.extend(other.health);
        self.samples.merge(&other.samples);
        self.motion.merge(&other.motion);
        self.closure = match (self.closure.take(), other.closure) {
            (Some(own), Some(other)) => Some(own.worse(other)),
            (own, other) => own.or(other),
        };
        self.plans.extend(other.plans);
        self.correlated |= other.correlated;
        for (sum, more) in self.axes.iter_mut().zip(other.axes) {
            *sum += more;
        }
        Ok(())
    }

    /// Rewrite the sums for the parameters of another support.
    pub fn shift(&mut self, shift: &Shift) {
        for fold in &mut self.folds {
            fold.weighted = fold.weighted.shifted(shift);
            fold.plain = fold.plain.as_ref().map(|plain| plain.shifted(shift));
        }
    }
}
