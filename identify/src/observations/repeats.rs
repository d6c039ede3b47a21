//! Repeated readings of postures, visits of postures, and whether a fit leaves more than
//! they scatter.
//!
//! ```text
//! pure error     SS_pe = Σ_groups Σ (y − ȳ_group)²       df_pe = Σ (n_group − 1)
//! within visits  SS_w  = Σ_visits Σ (y − ȳ_visit)²       df_w = Σ (n_visit − 1)
//! of visits      SS_v  = SS_pe − SS_w = Σ n_visit (ȳ_visit − ȳ_group)²
//!                E[SS_v/df_v] = σ² + n σ_v²              n readings a visit
//! lack of fit    F = ((RSS − SS_pe) / (df − df_pe)) / (SS_pe / df_pe)
//! ```
//!
//! A posture that is reached again differs by σ_v, for which SS_v takes the place of SS_pe:
//! readings of one visit do not show it. Visits whose joints did not come back exactly are
//! compared by y − CoP_CAD(q).

use super::criteria::repeats::{FEWEST, LEAST_OF_AN_AXIS, SAID, UNALIKE, UNLIKELY};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF as _, FisherSnedecor};

/// Sums of squares about means, and their degrees of freedom.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Squares {
    /// Sums of squares of each axis, m².
    pub sum: [f64; 2],
    /// The same in units of each row's variance: stated ones, or 1 m².
    pub weighted: [f64; 2],
    /// Degrees of freedom of one axis.
    pub df: u64,
}

impl Squares {
    fn invalid_reason(&self, rows: f64, most: f64) -> Option<String> {
        let mut sums = self.sum.iter().chain(&self.weighted);
        let fits = |x: &f64| (0.0..=most).contains(x);
        let valid = sums.all(fits) && (self.df as f64) <= rows;
        (!valid).then(|| "sums of repeats that no log gives".to_string())
    }

    fn add(&mut self, other: &Squares) {
        for axis in 0..2 {
            self.sum[axis] += other.sum[axis];
            self.weighted[axis] += other.weighted[axis];
        }
        self.df += other.df;
    }

    /// Sum over both axes in units of the rows' variances, with degrees of freedom.
    pub fn both(&self) -> (f64, u64) {
        (self.weighted[0] + self.weighted[1], 2 * self.df)
    }

    /// Deviation of each axis over that of both: 1 unless they scatter unalike and that is no
    /// chance.
    pub fn by_axis(&self) -> [f64; 2] {
        let both = 0.5 * (self.weighted[0] + self.weighted[1]);
        if both <= 0.0 || self.df == 0 {
            return [1.0; 2];
        }
        let least = LEAST_OF_AN_AXIS * LEAST_OF_AN_AXIS;
        let shares = self
            .weighted
            .map(|own| (own / both).clamp(least, 2.0 - least));
        let ratio = shares[0].max(shares[1]) / shares[0].min(shares[1]);
        let df = self.df as f64;
        let chance = FisherSnedecor::new(df, df).map_or(1.0, |axes| 2.0 * axes.sf(ratio));
        match chance < UNALIKE {
            true => shares.map(f64::sqrt),
            false => [1.0; 2],
        }
    }

    /// Sum over both axes, m², with degrees of freedom.
    fn metres(&self) -> (f64, u64) {
        (self.sum[0] + self.sum[1], 2 * self.df)
    }

    fn less(&self, part: &Squares) -> Squares {
        let less = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|k| (a[k] - b[k]).max(0.0));
        Squares {
            sum: less(self.sum, part.sum),
            weighted: less(self.weighted, part.weighted),
            df: self.df - part.df.min(self.df),
        }
    }
}

/// Repeated readings of postures, summed as they come.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Repeats {
    /// About the means of postures.
    pub about_postures: Squares,
    /// About the means of visits.
    pub about_visits: Squares,
    /// Postures.
    pub postures: u64,
    /// Visits of postures, the first ones included.
    pub visits: u64,
    /// Rows.
    pub rows: u64,
}

/// What visits of one posture differ by, beside the noise of their readings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Visits {
    /// Visits of postures visited before.
    pub again: u64,
    /// Standard deviation between visits, m; zero where visits differ by no more than readings.
    pub std: f64,
    /// Standard deviation within a visit, m; none where each visit is one reading.
    pub readings_std: Option<f64>,
}

impl Visits {
    /// The sentence that reports print.
    pub fn sentence(&self) -> String {
        let times = match self.again {
            1 => "1 posture was reached again".to_string(),
            n => format!("postures were reached again {n} times"),
        };
        match (self.std > 0.0, self.readings_std) {
            (true, Some(readings)) => format!(
                "{times}: visits of one posture differ by {:.2} mm per axis, readings of one \
                 visit by {:.2} mm",
                1e3 * self.std,
                1e3 * readings
            ),
            (true, None) => format!("{times} and differ by {:.2} mm per axis", 1e3 * self.std),
            (false, _) => format!("{times}, and visits differ by no more than their readings"),
        }
    }
}

/// Readings so far: mean and weighted mean.
#[derive(Debug, Clone, Default, PartialEq)]
struct Mean {
    count: f64,
    /// m
    mean: [f64; 2],
    weighted_mean: [f64; 2],
    /// Σ of weights, 1/m².
    weight: [f64; 2],
}

impl Mean {
    /// Take the readings of `other`, whose predicted reading is larger by `less` (m), for readings of
    /// this posture: sums of squares are about a mean that moves (Welford).
    fn join(&mut self, squares: &mut Squares, other: &Mean, less: [f64; 2]) {
        squares.df += u64::from(self.count > 0.0);
        let count = self.count + other.count;
        for (axis, less) in less.into_iter().enumerate() {
            let share = other.count / count;
            let away = other.mean[axis] - less - self.mean[axis];
            squares.sum[axis] += self.count * share * away * away;
            self.mean[axis] += share * away;
            let share = other.weight[axis] / (self.weight[axis] + other.weight[axis]);
            let away = other.weighted_mean[axis] - less - self.weighted_mean[axis];
            squares.weighted[axis] += self.weight[axis] * share * away * away;
            self.weighted_mean[axis] += share * away;
            self.weight[axis] += other.weight[axis];
        }
        self.count = count;
    }
}

/// Readings of one posture so far.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Group {
    all: Mean,
    /// Those of this visit, where it is not the first.
    visit: Option<Box<Mean>>,
    visits: u32,
}

impl Repeats {
    /// The first sum that no log has, in a file that was read.
    pub(crate) fn invalid_reason(&self, rows: f64, most: f64) -> Option<String> {
        let counts = [self.postures, self.visits, self.rows];
        let counted = counts.iter().all(|n| (*n as f64) <= rows);
        self.about_postures
            .invalid_reason(rows, most)
            .or_else(|| self.about_visits.invalid_reason(rows, most))
            .or_else(|| (!counted).then(|| "more repeats than a log has rows".to_string()))
    }

    /// A row of `group`, in its visit number `visit` (from 1), with its reading and, where
    /// stated, its deviation (1 elsewhere), m.
    pub fn push(&mut self, group: &mut Group, visit: u32, reading: [f64; 2], std: [f64; 2]) {
        self.postures += u64::from(group.visits == 0);
        if group.visits != visit {
            group.visit = (group.visits > 0).then(Box::default);
            group.visits = visit;
            self.visits += 1;
        }
        self.rows += 1;
        let row = Mean {
            count: 1.0,
            mean: reading,
            weighted_mean: reading,
            weight: std.map(|std| 1.0 / (std * std)),
        };
        match &mut group.visit {
            Some(own) => own.join(&mut self.about_visits, &row, [0.0; 2]),
            None => group
                .all
                .clone()
                .join(&mut self.about_visits, &row, [0.0; 2]),
        }
        group.all.join(&mut self.about_postures, &row, [0.0; 2]);
    }

    /// Take postures that were reached again under another number for visits of the `first` one of
    /// each; `predicted` is the CoP that CAD predicts in postures, x, y, x, y, … (m).
    pub fn join_visits<'g>(
        &mut self,
        first: &[usize],
        group: impl Fn(usize) -> &'g Group,
        predicted: &[f64],
    ) {
        let own = |k: usize| &group(k).all;
        let mut joined: Vec<Mean> = (0..first.len()).map(|k| own(k).clone()).collect();
        for (k, to) in first.iter().copied().enumerate() {
            // Rows that a robust fit rejects are none.
            if to < k && joined[to].count > 0.0 && own(k).count > 0.0 {
                let less = [0, 1].map(|axis| predicted[2 * k + axis] - predicted[2 * to + axis]);
                joined[to].join(&mut self.about_postures, own(k), less);
                self.postures -= 1;
            }
        }
    }

    /// Add what another part of the data gathered.
    pub fn merge(&mut self, other: &Repeats) {
        self.about_postures.add(&other.about_postures);
        self.about_visits.add(&other.about_visits);
        self.postures += other.postures;
        self.visits += other.visits;
        self.rows += other.rows;
    }

    /// Sums of squares of visits about their postures' means.
    pub fn of_visits(&self) -> Squares {
        self.about_postures.less(&self.about_visits)
    }

    /// Whether visits of one posture differ by more than readings of one visit do; `None`
    /// where that cannot be told.
    fn differ(&self) -> Option<bool> {
        let (visits, df) = self.of_visits().both();
        let (readings, df_readings) = self.about_visits.both();
        if df < SAID || df_readings < SAID {
            return None;
        }
        let ratio = visits / df as f64 / (readings / df_readings as f64).max(f64::MIN_POSITIVE);
        let distribution = FisherSnedecor::new(df as f64, df_readings as f64).ok()?;
        Some(distribution.sf(ratio) < UNLIKELY)
    }

    /// Whether the scatter of visits takes the place of that of readings: they differ, and
    /// are enough.
    pub fn by_visits(&self) -> bool {
        2 * self.of_visits().df >= FEWEST && self.differ() == Some(true)
    }

    /// What shows the noise: repeats, or visits where these differ.
    pub fn pure(&self) -> Squares {
        match self.by_visits() {
            true => self.of_visits(),
            false => self.about_postures,
        }
    }

    /// Deviation of a reading about the mean of its posture where visits differ, m: its own
    /// noise and its visit's.
    pub fn of_reading(&self) -> Option<f64> {
        let visits = self.visits().filter(|_| self.by_visits())?;
        Some(visits.readings_std.unwrap_or(0.0).hypot(visits.std))
    }

    /// Rows per independent one where visits differ: their mean square over a reading's
    /// variance.
    pub fn rows_per_sample(&self) -> Option<f64> {
        let (sum, df) = self.of_visits().metres();
        let reading = self.of_reading().filter(|reading| *reading > 0.0)?;
        Some((sum / df as f64 / (reading * reading)).max(1.0))
    }

    /// What visits differ by; `None` where no posture was visited again.
    pub fn visits(&self) -> Option<Visits> {
        let (visits, df) = self.of_visits().metres();
        if df == 0 {
            return None;
        }
        let (readings, df_readings) = self.about_visits.metres();
        let square = visits / df as f64;
        let own = (df_readings > 0).then(|| readings / df_readings as f64);
        let per_visit = self.rows as f64 / self.visits as f64;
        let beside = match (own, self.differ()) {
            (Some(own), Some(true)) => (square - own).max(0.0) / per_visit,
            // Single readings: their noise and the visits' are one.
            (None, _) => square,
            _ => 0.0,
        };
        Some(Visits {
            again: self.visits - self.postures,
            std: beside.sqrt(),
            readings_std: own.map(f64::sqrt),
        })
    }
}

/// Does a fit leave more than noise?
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LackOfFit {
    /// Mean square of residual over noise.
    pub ratio: f64,
    /// Degrees of freedom of the residual.
    pub df: f64,
    /// Degrees of freedom of the noise; none where its size is stated.
    pub df_noise: Option<f64>,
    /// Chance by noise alone.
    pub p_value: f64,
}

/// F test against repeated readings: sums of squares in the same units.
pub(crate) fn lack_of_fit(residual_sum: f64, df: f64, repeats: (f64, u64)) -> Option<LackOfFit> {
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
pub(crate) fn against_stated(residual_sum: f64, df: f64) -> Option<LackOfFit> {
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
        let rows = [
            (0, 1, 5.0),
            (1, 1, 0.0),
            (2, 1, 100.0),
            (0, 2, 3.0),
            (1, 2, 4.0),
        ];
        let mut groups = vec![Group::default(); 3];
        let mut repeats = Repeats::default();
        for (group, visit, x) in rows {
            repeats.push(&mut groups[group], visit, [x, 7.0], [1.0, 1.0]);
        }
        assert_eq!((repeats.postures, repeats.visits, repeats.rows), (3, 5, 5));
        let (sum, df) = repeats.pure().both();
        assert_eq!(df, 4);
        assert!((sum - 10.0).abs() < 1e-12);
        assert!((repeats.pure().metres().0 - 10.0).abs() < 1e-12);
        // Each visit is one reading.
        assert_eq!(repeats.of_visits(), repeats.pure());
    }

    /// Σ w (y − ȳ)² with ȳ = Σ w y / Σ w.
    #[test]
    fn readings_count_by_their_stated_variances() {
        let (mut group, mut repeats) = (Group::default(), Repeats::default());
        for (x, std) in [(1.0, 0.5), (4.0, 1.0), (2.0, 2.0)] {
            repeats.push(&mut group, 1, [x, 0.0], [std, 1.0]);
        }
        // Weights 4, 1, 1/4; mean 34/21.
        let mean = 34.0 / 21.0;
        let sum: f64 = [(1.0, 4.0), (4.0, 1.0), (2.0, 0.25)]
            .map(|(x, w): (f64, f64)| w * (x - mean).powi(2))
            .iter()
            .sum();
        assert!((repeats.about_postures.weighted[0] - sum).abs() < 1e-12);
    }

    /// Eight postures, three visits of five readings each: σ 0.1, σ_v 2 about a mean.
    #[test]
    fn visits_differ_by_more_than_their_readings() {
        let mut repeats = Repeats::default();
        let (mut of_visits, mut within) = (0.0, 0.0);
        for posture in 0..8_u32 {
            let mut group = Group::default();
            let shift = |visit: u32| 2.0 * f64::from((7 * posture + 3 * visit * visit) % 5) - 4.0;
            let mean = (1..=3).map(shift).sum::<f64>() / 3.0;
            for visit in 1..=3 {
                of_visits += 5.0 * (shift(visit) - mean).powi(2);
                for k in 0..5_i32 {
                    let noise = 0.1 * (f64::from(k) - 2.0);
                    within += noise * noise;
                    repeats.push(&mut group, visit, [shift(visit) + noise; 2], [1.0; 2]);
                }
            }
        }
        let (found, df) = repeats.of_visits().both();
        assert_eq!(df, 32);
        assert!((found - 2.0 * of_visits).abs() < 1e-9 * of_visits);
        assert!((repeats.about_visits.sum[0] - within).abs() < 1e-9);
        assert!(repeats.by_visits());
        let visits = repeats.visits().unwrap();
        let own = within / (8.0 * 3.0 * 4.0);
        assert_eq!(visits.again, 16);
        assert!((visits.readings_std.unwrap() - own.sqrt()).abs() < 1e-9);
        assert!((visits.std.powi(2) - (of_visits / 16.0 - own) / 5.0).abs() < 1e-9);
    }

    /// F(0.975; 10, 10) = 3.717: two-sided, 5 % of alike axes scatter further apart.
    #[test]
    fn axes_have_noises_of_their_own_where_they_scatter_unalike() {
        let squares = |x: f64, y: f64| Squares {
            sum: [x, y],
            weighted: [x, y],
            df: 10,
        };
        assert_eq!(squares(3.6, 1.0).by_axis(), [1.0; 2]);
        let [x, y] = squares(1.0, 4.0).by_axis();
        assert!((x - 0.4_f64.sqrt()).abs() < 1e-12 && (y - 1.6_f64.sqrt()).abs() < 1e-12);
        assert_eq!(squares(0.0, 0.0).by_axis(), [1.0; 2]);
        assert_eq!(Squares::default().by_axis(), [1.0; 2]);
        // An axis that reads one value does not count without end.
        assert_eq!(squares(0.0, 1.0).by_axis()[0], LEAST_OF_AN_AXIS);
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
