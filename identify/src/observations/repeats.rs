//! Repeated readings of postures, and whether a fit leaves more than they scatter.
//!
//! ```text
//! pure error     SS_pe = Σ_groups Σ (y − ȳ_group)²       df_pe = Σ (n_group − 1)
//! lack of fit    F = ((RSS − SS_pe) / (df − df_pe)) / (SS_pe / df_pe)
//! ```

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF as _, FisherSnedecor};

/// Repeated readings of postures, summed as they come.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Repeats {
    /// Σ over groups and axes of squared distances from the group's mean, m².
    pub sum: f64,
    /// The same in units of each row's stated variance.
    pub weighted_sum: f64,
    /// Degrees of freedom, both axes.
    pub df: u64,
    /// Groups of rows.
    #[serde(rename = "groups")]
    pub postures: u64,
}

/// Readings of one posture so far.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Group {
    pub count: f64,
    /// m
    mean: [f64; 2],
    weighted_mean: [f64; 2],
    /// Σ of weights, 1/m².
    weight: [f64; 2],
}

impl Repeats {
    /// A row of `group` with its reading and, where stated, its deviation (1 elsewhere), m.
    pub fn push(&mut self, group: &mut Group, reading: [f64; 2], std: [f64; 2]) {
        match group.count {
            0.0 => self.postures += 1,
            _ => self.df += 2,
        }
        // Welford: sums of squares about a mean that moves. Nothing is added to
        // them by the first row of a group.
        group.count += 1.0;
        for axis in 0..2 {
            let weight = 1.0 / (std[axis] * std[axis]);
            let away = reading[axis] - group.mean[axis];
            group.mean[axis] += away / group.count;
            self.sum += away * (reading[axis] - group.mean[axis]);
            let away = reading[axis] - group.weighted_mean[axis];
            group.weight[axis] += weight;
            group.weighted_mean[axis] += away * (weight / group.weight[axis]);
            self.weighted_sum += weight * away * (reading[axis] - group.weighted_mean[axis]);
        }
    }

    /// Add what another part of the data gathered.
    pub fn merge(&mut self, other: &Repeats) {
        self.sum += other.sum;
        self.weighted_sum += other.weighted_sum;
        self.df += other.df;
        self.postures += other.postures;
    }

    /// Sum of squares about the means, in units of stated variances where those are
    /// meant (m² else), and its degrees of freedom.
    pub fn pure(&self, stated: bool) -> (f64, u64) {
        let sum = if stated { self.weighted_sum } else { self.sum };
        (sum, self.df)
    }

    /// Standard deviation of a reading on one axis, m; `None` without repeats.
    pub fn deviation(&self) -> Option<f64> {
        (self.df > 0).then(|| (self.sum / self.df as f64).sqrt())
    }
}

/// Does a fit leave more than noise?
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LackOfFit {
    /// Mean square of what the fit leaves beyond noise, in units of the noise's.
    pub ratio: f64,
    /// Degrees of freedom of what the fit leaves.
    pub df: f64,
    /// Degrees of freedom of the noise; none where its size is stated.
    pub df_noise: Option<f64>,
    /// Chance of such a ratio from noise alone.
    pub p_value: f64,
}

/// F test against repeated readings: sums of squares in the same units.
pub fn lack_of_fit(residual_sum: f64, df: f64, repeats: (f64, u64)) -> Option<LackOfFit> {
    let (pure, df_pure) = (repeats.0, repeats.1 as f64);
    let df_rest = df - df_pure;
    if !(df_pure >= 1.0 && df_rest >= 1.0 && pure > 0.0) {
        return None;
    }
    let ratio = ((residual_sum - pure).max(0.0) / df_rest) / (pure / df_pure);
    let distribution = FisherSnedecor::new(df_rest, df_pure).ok()?;
    Some(LackOfFit {
        ratio,
        df: df_rest,
        df_noise: Some(df_pure),
        p_value: distribution.sf(ratio),
    })
}

/// χ² test against stated deviations: `residual_sum` in units of their squares.
pub fn against_stated(residual_sum: f64, df: f64) -> Option<LackOfFit> {
    let distribution = ChiSquared::new(df).ok().filter(|_| df >= 1.0)?;
    Some(LackOfFit {
        ratio: residual_sum / df,
        df,
        df_noise: None,
        p_value: distribution.sf(residual_sum),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_give_the_pure_error_in_whatever_order_they_come() {
        // About their means 1, −1 and 2, −2 on x, nothing on y.
        let rows = [(0, 5.0), (1, 0.0), (2, 100.0), (0, 3.0), (1, 4.0)];
        let mut groups = vec![Group::default(); 3];
        let mut repeats = Repeats::default();
        for (group, x) in rows {
            repeats.push(&mut groups[group], [x, 7.0], [1.0, 1.0]);
        }
        assert_eq!(repeats.postures, 3);
        assert_eq!(repeats.df, 4);
        assert!((repeats.sum - 10.0).abs() < 1e-12);
        assert!((repeats.weighted_sum - 10.0).abs() < 1e-12);
        assert!((repeats.deviation().unwrap() - 2.5_f64.sqrt()).abs() < 1e-12);
    }

    /// Σ w (y − ȳ)² with ȳ = Σ w y / Σ w.
    #[test]
    fn readings_count_by_their_stated_variances() {
        let (mut group, mut repeats) = (Group::default(), Repeats::default());
        for (x, std) in [(1.0, 0.5), (4.0, 1.0), (2.0, 2.0)] {
            repeats.push(&mut group, [x, 0.0], [std, 1.0]);
        }
        // Weights 4, 1, 1/4; mean 34/21.
        let mean = 34.0 / 21.0;
        let sum: f64 = [(1.0, 4.0), (4.0, 1.0), (2.0, 0.25)]
            .map(|(x, w): (f64, f64)| w * (x - mean).powi(2))
            .iter()
            .sum();
        assert!((repeats.weighted_sum - sum).abs() < 1e-12);
    }

    /// Critical values from tables: F(0.95; 5, 10) = 3.3258, χ²(0.95; 10) = 18.307.
    #[test]
    fn tests_match_their_tables() {
        let f = lack_of_fit(10.0 + 5.0 * 3.3258, 15.0, (10.0, 10)).unwrap();
        assert!((f.ratio - 3.3258).abs() < 1e-12);
        assert!((f.p_value - 0.05).abs() < 1e-4);
        assert!((against_stated(18.307, 10.0).unwrap().p_value - 0.05).abs() < 1e-4);
    }
}
