//! How many independent samples the rows of logs are worth, and how that is said.

use serde::{Deserialize, Serialize};

use super::correlation::Correlation;
use super::repeats::Repeats;

/// How much logs are worth.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SampleCount {
    /// Rows of the logs.
    pub rows: usize,
    /// Independent rows on the worse axis.
    pub independent: usize,
    /// Integrated correlation time, s.
    pub correlation_s: f64,
    /// Whether independence is assumed; of logs without usable times.
    pub assumed: bool,
}

impl SampleCount {
    /// Rows that visits make worth fewer, where their times do not say so.
    pub fn by_visits(self, repeats: &Repeats) -> SampleCount {
        match repeats.rows_per_sample() {
            Some(rows) if self.independent == self.rows => SampleCount {
                independent: ((self.rows as f64 / rows).round() as usize).max(1),
                ..self
            },
            _ => self,
        }
    }

    /// The sentence that reports print.
    pub fn sentence(&self) -> String {
        let rows = self.rows;
        if self.independent < rows {
            let why = match self.correlation_s > 0.0 {
                true => format!("noise is correlated over {:.2} s", self.correlation_s),
                false => "visits of one posture differ by more than its readings".to_string(),
            };
            let worth = self.independent;
            return format!("{rows} rows, worth about {worth} independent ones: {why}");
        }
        match self.assumed {
            true => format!("{rows} rows, taken as independent: no times in order say otherwise"),
            false => format!("{rows} rows, as good as independent"),
        }
    }
}

/// The same while logs are summed up.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Sum {
    /// Rows of the logs.
    rows: u64,
    /// Rows' worth of independent samples.
    independent: f64,
    /// How long noise lasts, s: the longest of the logs.
    correlation_s: f64,
    /// Whether rows of a log without times were taken as independent.
    assumed: bool,
}

impl Sum {
    /// What no log has, in a file that was read.
    pub(crate) fn invalid_reason(&self, rows: f64) -> Option<String> {
        let valid = (self.rows as f64) <= rows
            && (0.0..=rows).contains(&self.independent)
            && (0.0..=rows).contains(&self.correlation_s);
        (!valid).then(|| "`samples` that no log gives".to_string())
    }

    /// Rows of one log; `timed` where its times run forward.
    pub fn push(&mut self, rows: u64, axes: &[Correlation; 2], timed: bool) {
        // The axis that has fewer independent samples.
        let is_first = axes[0].rows_per_sample > axes[1].rows_per_sample;
        let worst = axes[usize::from(!is_first)];
        self.rows += rows;
        self.independent += rows as f64 / worst.rows_per_sample;
        self.correlation_s = self.correlation_s.max(worst.time_s);
        self.assumed |= !timed;
    }

    /// Add those of other logs.
    pub fn merge(&mut self, other: &Sum) {
        self.rows += other.rows;
        self.independent += other.independent;
        self.correlation_s = self.correlation_s.max(other.correlation_s);
        self.assumed |= other.assumed;
    }

    /// What is said of `rows` rows.
    pub fn of(&self, rows: u64) -> SampleCount {
        // Rows whose log was never summed up count one each.
        let counted = self.independent + (rows - self.rows.min(rows)) as f64;
        SampleCount {
            rows: rows as usize,
            independent: (counted.round() as usize).max(1),
            correlation_s: self.correlation_s,
            assumed: self.assumed || self.rows < rows,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logs_add_up_and_say_what_was_assumed() {
        let axis = |rows_per_sample, time_s| Correlation {
            time_s,
            rows_per_sample,
            variance: 1.0,
            process: None,
        };
        let mut sum = Sum::default();
        sum.push(1000, &[axis(50.0, 0.25), axis(10.0, 0.05)], true);
        sum.push(400, &[Correlation::NONE; 2], true);
        let both = sum.of(1400);
        assert_eq!((both.rows, both.independent), (1400, 420));
        assert!(!both.assumed);
        let words = "1400 rows, worth about 420 independent";
        assert!(both.sentence().contains(words));
        let mut other = Sum::default();
        other.push(100, &[Correlation::NONE; 2], false);
        assert!(other.of(100).sentence().contains("taken as independent"));
        sum.merge(&other);
        assert!(sum.of(1500).assumed);
        assert_eq!(sum.of(1500).independent, 520);
    }
}
