//! The rows of one robot in the order of its days.

use std::collections::{BTreeMap, BTreeSet};

use crate::fleet::row::{Absent, EffectFound, Row, Size, by_number};

/// Effect and target.
pub(super) type Key = (String, String);

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
    fn history<'r>((robot, mut rows): (&'r str, Vec<&'r Row>)) -> History<'r> {
        rows.sort_by(|a, b| by_number(&a.day, &b.day).then_with(|| a.urdf_hash.cmp(&b.urdf_hash)));
        History { robot, rows }
    }
    robots.into_iter().map(history).collect()
}

/// What a row says of an effect.
#[derive(Clone, Copy)]
pub(super) enum Said<'r> {
    /// It is in the explanation.
    Found(&'r EffectFound),
    /// It is in another explanation that the data allow as well.
    Possible,
    /// It is in none.
    No,
}

pub(super) fn said<'r>(row: &'r Row, (effect, target): &Key) -> Said<'r> {
    let is_it = |found: &&EffectFound| found.effect == *effect && found.target == *target;
    if let Some(found) = row.effects.iter().find(is_it) {
        return Said::Found(found);
    }
    if row.effects.iter().all(|found| found.instead.is_empty()) {
        return Said::No;
    }
    let label = label((effect, target));
    let effects = row.effects.iter();
    let mut instead = effects.flat_map(|found| found.instead.iter().flatten());
    match instead.any(|other| *other == label) {
        true => Said::Possible,
        false => Said::No,
    }
}

/// An effect of a row's explanation, if it is there.
pub(super) fn found<'r>(row: &'r Row, key: &Key) -> Option<&'r EffectFound> {
    match said(row, key) {
        Said::Found(found) => Some(found),
        Said::Possible | Said::No => None,
    }
}

/// An effect and its target as diagnoses write them: `effect:target`, or `effect`.
pub(super) fn label((effect, target): (&str, &str)) -> String {
    match target {
        "-" => effect.to_string(),
        target => format!("{effect}:{target}"),
    }
}

impl<'r> History<'r> {
    /// Rows that say something of the robot.
    pub fn usable(&self) -> impl Iterator<Item = &'r Row> {
        self.rows.iter().copied().filter(|row| row.is_usable())
    }

    /// Rows of which something came, whether it says something of the robot or not.
    pub fn with_results(&self) -> Vec<&'r Row> {
        let rows = self.rows.iter().copied();
        rows.filter(|row| row.has_result()).collect()
    }

    /// Rows whose numbers can be held against each other: of one URDF and support.
    pub fn stretches(&self) -> Vec<Vec<&'r Row>> {
        let mut stretches: BTreeMap<(&str, &str), Vec<&Row>> = BTreeMap::new();
        for row in self.usable() {
            let key = (row.urdf_hash.as_str(), row.support.as_str());
            stretches.entry(key).or_default().push(row);
        }
        stretches.into_values().collect()
    }

    /// Every effect of any explanation.
    pub fn keys(&self) -> BTreeSet<Key> {
        let effects = self.usable().flat_map(|row| &row.effects);
        effects
            .map(|found| (found.effect.clone(), found.target.clone()))
            .collect()
    }
}

/// What a parameter of an effect is without it, where that is not 0.
pub(super) fn absent<'r>(
    rows: impl Iterator<Item = &'r Row>,
    key: &Key,
    parameter: &str,
) -> Option<Absent> {
    let mut known = rows.filter_map(|row| found(row, key));
    known.find_map(|found| found.absent.get(parameter).copied())
}

/// The parameter of an effect that is largest beside its deviation.
pub(super) fn principal<'a>(found: impl Iterator<Item = &'a EffectFound>) -> Option<String> {
    let mut told: BTreeMap<&str, f64> = BTreeMap::new();
    let sizes = |found: &'a EffectFound| {
        let names = found.parameters.keys();
        names.filter_map(|name| Some((name, found.away(name)?)))
    };
    for (name, size) in found.flat_map(sizes) {
        *told.entry(name).or_default() += (size.value / size.std.max(f64::MIN_POSITIVE)).powi(2);
    }
    let best = told.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(name, _)| name.to_string())
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
pub(super) fn pooled(values: &[Size]) -> Option<(Size, f64)> {
    let known: Vec<Size> = values.iter().copied().filter(|v| v.std > 0.0).collect();
    if known.is_empty() {
        return None;
    }
    let mean = |tau2: f64| {
        let weight = |v: &Size| 1.0 / (v.std * v.std + tau2);
        let sum: f64 = known.iter().map(weight).sum();
        let value = known.iter().map(|v| weight(v) * v.value).sum::<f64>() / sum;
        (value, sum)
    };
    let (first, sum) = mean(0.0);
    let u = |v: &Size| 1.0 / (v.std * v.std);
    let q: f64 = known.iter().map(|v| u(v) * (v.value - first).powi(2)).sum();
    let squares: f64 = known.iter().map(|v| u(v) * u(v)).sum();
    let free = known.len() as f64 - 1.0;
    let tau2 = match known.len() {
        1 => 0.0,
        _ => ((q - free) / (sum - squares / sum)).max(0.0),
    };
    let (value, sum) = mean(tau2);
    let std = sum.sqrt().recip();
    Some((Size { value, std }, tau2.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_scatter_more_than_they_should_are_known_less_well() {
        let of = |values: &[f64]| {
            let sizes: Vec<Size> = values
                .iter()
                .map(|&value| Size { value, std: 0.1 })
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
}
