//! The rows of one robot in the order of its days, and where a number of it changes.
//!
//! A number x_d with deviation s_d on each of D days is split at every day:
//!
//! ```text
//! z_k = (x̄_{≥k} − x̄_{<k}) / √(var x̄_{≥k} + var x̄_{<k})      x̄: weighted by 1/s²
//! ```
//!
//! The chance of the largest |z_k| is at most that of one, times D − 1 days, the numbers of a
//! robot and the robots of the fleet (Bonferroni); below [`FALSE_ALARM`] it is a change.
//!
//! The days before a change and those from it on are split again in the same way (binary
//! segmentation), unless a straight line explains them: a drift is one change. Each time the
//! chance counts twice as many numbers, so that a robot with a change gets a second one by
//! chance no more often than a sound robot gets its first.
//!
//! The day of a change has an interval: of all days on which the number may have stepped, each as
//! likely before, those of 95 % of the probability that they have in the light of the sizes,
//! exp(−χ²_k/2) with χ²_k of the two means; the day that is told is in it.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Range, RangeInclusive};

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

use super::{FALSE_ALARM, LEAST_FREEDOM, ONSET};
use crate::diagnose::{Quantity, subject};
use crate::fleet::row::{Absent, EffectFound, Row, by_number};
use crate::health::Finding;
use crate::observations::postures::range;

/// An effect at a target, of a row or a finding.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key<'r> {
    pub effect: &'r str,
    pub target: &'r str,
}

impl<'r> Key<'r> {
    fn of(found: &'r EffectFound) -> Key<'r> {
        Key {
            effect: &found.effect,
            target: &found.target,
        }
    }

    pub(super) fn of_finding(finding: &'r Finding) -> Key<'r> {
        Key {
            effect: finding.kind.name(),
            target: &finding.target,
        }
    }

    /// As diagnoses write it: `effect:target`, or `effect`.
    pub(super) fn label(self) -> String {
        match self.target {
            "-" => self.effect.to_string(),
            target => format!("{}:{target}", self.effect),
        }
    }

    /// The effect in sentences.
    pub(super) fn subject(self) -> String {
        subject(self.effect, self.target)
    }

    /// The effect in a row's explanation, if it is there.
    pub(super) fn found(self, row: &Row) -> Option<&EffectFound> {
        let mut effects = row.effects.explanation.iter();
        effects.find(|found| Key::of(found) == self)
    }

    /// Whether another explanation that the data allow as well has the effect.
    pub(super) fn is_possible(self, row: &Row) -> bool {
        let mut instead = row.effects.instead.iter().flatten();
        instead.any(|other| *other == self.label())
    }

    /// What a row says of the size of the effect: that of its explanation, else alone.
    pub(super) fn scored(self, row: &Row) -> Option<&EffectFound> {
        let mut all = row.effects.explanation.iter().chain(&row.effects.scores);
        all.find(|found| Key::of(found) == self)
    }
}

/// The effects of a row's explanation.
pub(super) fn explained(row: &Row) -> BTreeSet<Key<'_>> {
    row.effects.explanation.iter().map(Key::of).collect()
}

/// One robot.
pub(super) struct History<'r> {
    pub robot: &'r str,
    /// Its rows, sorted by day.
    pub rows: Vec<&'r Row>,
}

/// The robots of a fleet in the order of their names.
pub(super) fn histories(rows: &[Row]) -> Vec<History<'_>> {
    let mut robots: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in rows {
        robots.entry(&row.robot).or_default().push(row);
    }
    for rows in robots.values_mut() {
        rows.sort_by(|a, b| by_number(&a.day, &b.day).then_with(|| a.urdf_hash.cmp(&b.urdf_hash)));
    }
    let history = |(robot, rows)| History { robot, rows };
    robots.into_iter().map(history).collect()
}

impl<'r> History<'r> {
    /// Rows that say something of the robot.
    pub(super) fn usable(&self) -> impl Iterator<Item = &'r Row> {
        self.rows.iter().copied().filter(|row| row.is_usable())
    }

    /// Whether most of its usable rows have effects in their explanation.
    pub(super) fn has_effects(&self) -> bool {
        let has = |row: &&Row| !row.effects.explanation.is_empty();
        2 * self.usable().filter(has).count() > self.usable().count()
    }

    /// Rows of which something came, whether it says something of the robot or not.
    pub(super) fn with_results(&self) -> Vec<&'r Row> {
        let rows = self.rows.iter().copied();
        rows.filter(|row| row.has_result()).collect()
    }

    /// Rows whose numbers can be held against each other: of one URDF and support.
    pub(super) fn stretches(&self) -> Vec<Vec<&'r Row>> {
        let mut stretches: BTreeMap<(&str, &str), Vec<&Row>> = BTreeMap::new();
        for row in self.usable() {
            let key = (row.urdf_hash.as_str(), row.support.as_str());
            stretches.entry(key).or_default().push(row);
        }
        stretches.into_values().collect()
    }

    /// Every effect that a row has a size of.
    pub(super) fn scored(&self) -> BTreeSet<Key<'r>> {
        let effects = self.usable().map(|row| &row.effects);
        let effects = effects.flat_map(|own| own.explanation.iter().chain(&own.scores));
        effects.map(Key::of).collect()
    }

    /// Every effect of any explanation.
    pub(super) fn keys(&self) -> BTreeSet<Key<'r>> {
        self.usable().flat_map(explained).collect()
    }
}

/// The parameter of an effect that is largest beside its deviation; of a mass itself, wherever it
/// is; and what it is without the effect.
pub(super) fn principal<'r>(
    found: impl Iterator<Item = &'r EffectFound>,
) -> Option<(&'r str, Absent)> {
    // How clearly rows tell it.
    let mut told: BTreeMap<&str, (f64, Absent)> = BTreeMap::new();
    for found in found {
        for (name, size) in &found.parameters {
            let absent = found.absent(name);
            let Quantity { value, std } = absent.away(*size);
            let (told, _) = told.entry(name).or_insert((0.0, absent));
            *told += (value / std.max(f64::MIN_POSITIVE)).powi(2);
        }
    }
    let mass = told.iter().find(|(name, _)| name.ends_with("_kg"));
    let largest = || told.iter().max_by(|a, b| a.1.0.total_cmp(&b.1.0));
    let (name, (_, absent)) = mass.or_else(largest)?;
    Some((name, *absent))
}

/// Mean of values with deviations of their own, which scatter by more if they do.
///
/// ```text
/// μ = Σ w_i x_i / Σ w_i     w_i = 1/(s_i² + τ²)     τ² = max(0, (Q − (n−1)) / (Σ u_i − Σ
/// u_i²/Σ u_i))
/// ```
///
/// with u_i = 1/s_i² and Q = Σ u_i (x_i − x̄)² (DerSimonian and Laird 1986). Gives μ with its
/// deviation, and τ.
pub(super) fn pooled(values: &[Quantity]) -> Option<(Quantity, f64)> {
    let known: Vec<Quantity> = values.iter().copied().filter(|v| v.std > 0.0).collect();
    let weight = |v: &Quantity, tau2: f64| 1.0 / (v.std * v.std + tau2);
    let mean = |tau2: f64| {
        let sum: f64 = known.iter().map(|v| weight(v, tau2)).sum();
        let value = known.iter().map(|v| weight(v, tau2) * v.value).sum::<f64>() / sum;
        (value, sum)
    };
    let (first, sum) = mean(0.0);
    let square = |v: &Quantity| weight(v, 0.0) * (v.value - first).powi(2);
    let q: f64 = known.iter().map(square).sum();
    let squares: f64 = known.iter().map(|v| weight(v, 0.0).powi(2)).sum();
    let tau2 = match known.len() {
        0 => return None,
        1 => 0.0,
        n => ((q - (n as f64 - 1.0)) / (sum - squares / sum)).max(0.0),
    };
    let (value, sum) = mean(tau2);
    let std = sum.sqrt().recip();
    Some((Quantity { value, std }, tau2.sqrt()))
}

/// A number by day.
pub(super) struct Course<'r> {
    pub rows: Vec<&'r Row>,
    pub sizes: Vec<Quantity>,
}

impl<'r> Course<'r> {
    /// The sizes of a number on the days of these rows.
    pub(super) fn of(days: impl Iterator<Item = (&'r Row, Quantity)>) -> Course<'r> {
        let (rows, sizes) = days.unzip();
        Course { rows, sizes }
    }

    /// The name of a day.
    pub(super) fn day(&self, place: usize) -> &'r str {
        &self.rows[place].day
    }

    /// The sizes on the day before a step, and on the last day that is so.
    pub(super) fn sizes_of(&self, step: &Step) -> [Quantity; 2] {
        [step.days.start, step.days.end].map(|next| self.sizes[next - 1])
    }
}

/// A change of a course.
pub(super) struct Step {
    /// Days since the change up to the next one.
    pub days: Range<usize>,
    /// Places of the first and the last day on which it may have come, at 95 %.
    pub first: RangeInclusive<usize>,
    /// The most that chance would make of it.
    pub chance: f64,
}

/// Degrees of freedom of the deviations of all rows together.
pub(super) fn freedom(rows: &[&Row]) -> f64 {
    let of =
        |row: &&Row| (2.0 * row.independent as f64 - row.params.len() as f64).max(LEAST_FREEDOM);
    rows.iter().map(of).sum()
}

/// Where a number changes, day after day. `tests` are the numbers that are looked at, besides
/// days.
pub(super) fn steps(course: &Course, tests: f64) -> Vec<Step> {
    let (days, freedom) = (course.sizes.len(), freedom(&course.rows));
    // Of two kinds of numbers.
    let looks = 2.0 * tests * (days as f64 - 1.0);
    let mut steps: Vec<Step> = Vec::new();
    let mut parts = vec![(0..days, looks)];
    while let Some((part, looks)) = parts.pop() {
        let sizes = &course.sizes[part.clone()];
        let again = part.len() < days;
        if again && is_straight(sizes) {
            continue;
        }
        let Some((onset, ln_p)) = split(sizes, freedom) else {
            continue;
        };
        let chance = (ln_p + looks.ln()).exp().min(1.0);
        if chance < FALSE_ALARM {
            let first = days_of_95_percent(sizes);
            let (first, last) = (onset.min(*first.start()), onset.max(*first.end()));
            let onset = part.start + onset;
            steps.push(Step {
                days: onset..part.end,
                first: part.start + first..=part.start + last,
                chance,
            });
            parts.extend([part.start..onset, onset..part.end].map(|part| (part, 2.0 * looks)));
        }
    }
    steps.sort_by_key(|step| step.days.start);
    for k in 1..steps.len() {
        steps[k - 1].days.end = steps[k].days.start;
    }
    steps
}

/// Whether a straight line over the days, weighted by 1/s², explains the sizes.
fn is_straight(sizes: &[Quantity]) -> bool {
    let days = sizes.iter().enumerate().map(|(day, size)| {
        let weight = 1.0 / (size.std * size.std);
        (day as f64, size.value, weight)
    });
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| days.clone().map(|(t, x, w)| w * of(t, x)).sum::<f64>();
    let weight = sum(&|_, _| 1.0);
    let (mean_t, mean_x) = (sum(&|t, _| t) / weight, sum(&|_, x| x) / weight);
    let slope = sum(&|t, x| (t - mean_t) * (x - mean_x)) / sum(&|t, _| (t - mean_t).powi(2));
    let line = |t: f64| mean_x + slope * (t - mean_t);
    let chi2 = sum(&|t, x| (x - line(t)).powi(2));
    // Two days always lie on a line.
    let law = ChiSquared::new(sizes.len() as f64 - 2.0);
    law.is_ok_and(|law| tail(&law, chi2) > FALSE_ALARM) || sizes.len() < 3
}

/// Where sizes can be split best: the place of the first day on which it is so, and ln p of that.
fn split(sizes: &[Quantity], freedom: f64) -> Option<(usize, f64)> {
    // Means of the days before each day, and of those from it on.
    let before = means(sizes.iter());
    let mut after = means(sizes.iter().rev());
    after.reverse();
    let gap = |later: Quantity, k: usize| {
        let before: Quantity = before[k - 1];
        (later.value - before.value) / later.std.hypot(before.std)
    };
    let z = |k: usize| gap(after[k], k);
    let best = (1..sizes.len()).max_by(|a, b| z(*a).abs().total_cmp(&z(*b).abs()))?;
    let of = |k: usize| {
        let own = gap(sizes[k], k);
        own.abs() > ONSET && own.signum() == z(best).signum()
    };
    // A drift is split best in its middle, and begins before.
    let onset = (1..=best).find(|k| of(*k)).unwrap_or(best);
    let law = StudentsT::new(0.0, 1.0, freedom.max(LEAST_FREEDOM)).ok()?;
    let p = 2.0 * tail(&law, z(best).abs());
    let ln_p = p.max(f64::MIN_POSITIVE).ln();
    z(best).is_finite().then_some((onset, ln_p))
}

/// The first and the last of the days that have 95 % of the probability of a step.
fn days_of_95_percent(sizes: &[Quantity]) -> RangeInclusive<usize> {
    let left = |of: &[Quantity]| {
        let mean = means(of.iter()).pop().map_or(0.0, |mean| mean.value);
        let square = |size: &Quantity| ((size.value - mean) / size.std).powi(2);
        of.iter().map(square).sum::<f64>()
    };
    let chi2 = (1..sizes.len()).map(|k| left(&sizes[..k]) + left(&sizes[k..]));
    let chi2: Vec<f64> = chi2.collect();
    let (least, _) = range(chi2.iter().copied());
    let weights = chi2.iter().map(|chi2| (-0.5 * (chi2 - least)).exp());
    let mut days: Vec<(usize, f64)> = (1..).zip(weights).collect();
    days.sort_by(|a, b| b.1.total_cmp(&a.1));
    let all: f64 = days.iter().map(|(_, weight)| weight).sum();
    let mut held = 0.0;
    let likeliest = days.iter().take_while(|(_, weight)| {
        let before = held;
        held += weight;
        before <= 0.95 * all
    });
    let ends = |(first, last): (usize, usize), day: usize| (first.min(day), last.max(day));
    let likeliest = likeliest.map(|(day, _)| *day);
    let (first, last) = likeliest.fold((sizes.len(), 0), ends);
    first..=last
}

/// Chance of `x` or more. Numbers that come from a file may be anything, of which laws take those
/// alone that are finite and not too large to be squared.
pub(super) fn tail(law: &impl ContinuousCDF<f64, f64>, x: f64) -> f64 {
    if x.is_nan() {
        1.0
    } else {
        law.sf(x.clamp(-1e100, 1e100))
    }
}

/// Means weighted by 1/s² of the first number, of the first two, and so on.
pub(super) fn means<'s>(sizes: impl Iterator<Item = &'s Quantity>) -> Vec<Quantity> {
    let (mut sum, mut weights) = (0.0, 0.0);
    let mean = |size: &Quantity| {
        let weight = 1.0 / (size.std * size.std);
        weights += weight;
        sum += weight * size.value;
        Quantity {
            value: sum / weights,
            std: weights.sqrt().recip(),
        }
    };
    sizes.map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    #[test]
    fn values_that_scatter_more_than_they_should_are_known_less_well() {
        let of = |values: &[f64]| {
            let sizes: Vec<Quantity> = values
                .iter()
                .map(|&value| Quantity { value, std: 0.1 })
                .collect();
            pooled(&sizes).unwrap()
        };
        let (mean, tau) = of(&[1.0, 1.05, 0.95, 1.0]);
        assert!((mean.value - 1.0).abs() < 1e-12 && tau == 0.0);
        assert!((mean.std - 0.05).abs() < 1e-12);
        // Q = 100 · 2 = 200, of 1 that was to be expected: τ² = 199 / 100.
        let (mean, tau) = of(&[0.0, 2.0]);
        assert!((tau * tau - 1.99).abs() < 1e-9, "{tau}");
        assert!((mean.std - 1.0).abs() < 1e-9, "{}", mean.std);
    }

    /// The day of a step is within its interval in 95 % of the courses of twelve days, and small
    /// steps have longer ones.
    #[test]
    fn intervals_of_days_hold_the_day() {
        let mut random = ChaCha8Rng::seed_from_u64(31);
        let mut lengths = Vec::new();
        for step in [1.0, 2.0, 4.0] {
            let (mut held, mut length) = (0, 0);
            for _ in 0..1000 {
                let day = random.random_range(1..12);
                let noise = |_| -> f64 { StandardNormal.sample(&mut random) };
                let course: Vec<f64> = (0..12).map(noise).collect();
                let size = |(k, noise): (usize, &f64)| Quantity {
                    value: 1e-3 * (noise + if k < day { 0.0 } else { step }),
                    std: 1e-3,
                };
                let sizes: Vec<Quantity> = course.iter().enumerate().map(size).collect();
                let days = days_of_95_percent(&sizes);
                held += usize::from(days.contains(&day));
                length += days.end() - days.start() + 1;
            }
            println!("step of {step} deviations: {held} of 1000 hold, {length} days in all");
            assert!((935..=1000).contains(&held), "{step}: {held}");
            lengths.push(length);
        }
        assert!(lengths[0] > lengths[1] && lengths[1] > 3 * lengths[2]);
    }
}
