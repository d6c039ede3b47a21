//! Sums of several logs, machines or sessions together, and sums that no logs can have.

use sesc_model::standard::Shift;

use super::{Gathered, LogUsed};
use crate::feet::ClosureFound;
use crate::logs::Weight;
use crate::{Message, Setting, message};

/// Sums of a log are not larger, nor its rows more: what values within their bounds give.
const MOST_SUM: f64 = 1e60;
const MOST_ROWS: f64 = 1e15;

impl Gathered {
    /// The first sum that no logs can have, in a file that was read.
    pub(in crate::fit) fn invalid_reason(&self) -> Option<String> {
        let rows = self.readings as f64;
        let count = |name, n: u64| (name, n as f64, 0.0, MOST_ROWS);
        let sum = |name, x: f64, most: f64| (name, x, 0.0, most);
        let positive = |name, x: f64, most: f64| (name, x, f64::MIN_POSITIVE, most);
        let own = [
            count("readings", self.readings),
            sum("stated", self.stated, MOST_SUM),
            sum("trusted", self.trusted, rows),
            positive("consistency", self.consistency, 1.0),
            sum("averaged", self.averaged, rows),
            count("moved", self.moved),
            count("overfull", self.overfull),
            count("tiny", self.tiny),
            count("motion.rows_left_out", self.motion.rows_left_out),
        ];
        let logs = self.logs.iter().map(|log| count("rows", log.rows));
        let axes = self.axes.iter().map(|x| sum("axes", *x, MOST_SUM));
        let each = self
            .folds
            .iter()
            .map(|fold| positive("each", fold.each, MOST_SUM));
        let factors = self.folds.iter().flat_map(|fold| {
            let sums = [&fold.weighted, &*fold.plain()].map(|own| {
                let size = sum("triangle", own.largest(), MOST_SUM);
                [size, count("rows", own.rows())]
            });
            sums.into_iter().flatten()
        });
        let mut all = own
            .into_iter()
            .chain(logs)
            .chain(axes)
            .chain(each)
            .chain(factors);
        all.find(|(_, x, least, most)| !(*least..=*most).contains(x))
            .map(|(name, x, ..)| format!("`{name}` is {x:?}, which no log gives"))
            .or_else(|| self.repeats.invalid_reason(MOST_ROWS, MOST_SUM))
            .or_else(|| self.samples.invalid_reason(MOST_ROWS))
            .or_else(|| self.closure.as_ref()?.invalid_reason())
            .or_else(|| self.again.as_ref()?.invalid_reason())
    }

    /// Add what another machine or session of measurements gathered.
    ///
    /// # Errors
    /// When the parts differ in parameters, folds or stated deviations.
    pub fn merge(&mut self, other: Gathered) -> Result<(), Message> {
        let (here, there) = (self.params(), other.params());
        if here != there {
            return Err(format!("{here} parameters here, {there} there").into());
        }
        let (here, there) = (self.folds.len(), other.folds.len());
        if here != there {
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
        let known = |log: &&LogUsed| self.logs.iter().any(|own| own.hash == log.hash);
        if let Some(log) = other.logs.iter().find(known) {
            return Err(format!("{} is in both: its postures would count twice", log.file).into());
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
        let closures = self.closure.take().into_iter().chain(other.closure);
        self.closure = closures.reduce(ClosureFound::worse);
        let weights = self.weight.take().into_iter().chain(other.weight);
        self.weight = weights.reduce(Weight::farther);
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
