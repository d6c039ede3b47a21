//! What changed between two models of one robot, and whether it is more than chance.
//!
//! ```text
//! d = r_b − r_a        C = C_a + C_b        (C = (RᵀR)⁻¹ of each file's information)
//! C = Σ_k σ_k² u_k u_kᵀ        z_k = u_kᵀ d / σ_k
//! ```
//!
//! Where nothing changed, every z_k is a standard normal number, or less: a prior that both
//! share pulls both the same way. What is known best comes first, so that a change that two
//! good directions show is not lost among forty that nobody measured: Σ z_k² over the first
//! 1, 2, 4, … directions is held against χ², and the smallest probability, times how many
//! were looked at, is the chance of such a difference without a change.
//!
//! Effects are compared by name and target, value by value, in standard deviations of the
//! difference. Directions of which a file gives no deviation are left out and counted.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use sesc_model::{EffectRecord, ModelFile};
use statrs::distribution::{ChiSquared, ContinuousCDF as _, Normal};

use crate::Error;
use crate::diagnose::subject;
use crate::fit::population::inverse;
use crate::svd::symmetric_eigen;

/// A difference that chance makes more often than this is none. Chosen: it is the rate of false
/// alarms itself (closed form).
const CHANCE: f64 = 0.01;
/// A chance below this is said to be below it, for further digits of it mean nothing. Chosen: it
/// changes a sentence alone.
const LEAST_CHANCE: f64 = 1e-12;

/// A number in both models.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Difference {
    /// Its name, which for effects ends in the unit; base parameters are in m.
    pub name: String,
    /// In the first model; none where it is not there.
    pub before: Option<f64>,
    /// In the second.
    pub after: Option<f64>,
    /// Standard deviation of the difference.
    pub std: Option<f64>,
    /// The difference in standard deviations.
    pub deviations: Option<f64>,
}

impl Difference {
    fn new(name: &str, values: [Option<f64>; 2], std: Option<f64>) -> Difference {
        let [before, after] = values;
        let gap = before.zip(after).map(|(a, b)| (b - a).abs());
        // A gap of nothing is none, whatever its deviation.
        let deviations = |(gap, std): (f64, f64)| if gap == 0.0 { 0.0 } else { gap / std };
        Difference {
            name: name.to_string(),
            before,
            after,
            std,
            deviations: gap.zip(std).map(deviations),
        }
    }
}

/// What became of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Change {
    /// In the second model alone.
    Appeared,
    /// In the first model alone.
    Gone,
    /// In both, and different by more than chance.
    Changed,
    /// In both, and different by no more than chance.
    Same,
    /// In both, and different, without deviations to judge by.
    Unknown,
}

/// An effect of either model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EffectChange {
    /// Name of the effect: `joint_offset`.
    pub effect: String,
    /// Joint, link or cell; `-` for the whole robot.
    pub target: String,
    /// What became of it.
    pub change: Change,
    /// Its parameters.
    pub parameters: Vec<Difference>,
}

/// Two models of one robot, held against each other.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Comparison {
    /// Name of the robot.
    pub robot: String,
    /// Link on the ground.
    pub support: String,
    /// Whether both are of the same URDF.
    pub same_urdf: bool,
    /// Noise of a reading, m.
    pub noise_floor: [Option<f64>; 2],
    /// Whether both are of the same data.
    pub same_data: bool,
    /// Effects of either.
    pub effects: Vec<EffectChange>,
    /// Base parameters of either, m.
    pub parameters: Vec<Difference>,
    /// Base directions that both determine.
    pub directions: usize,
    /// Σ z² over them.
    pub chi2: f64,
    /// Chance of such a difference where nothing changed; none where no direction has deviations.
    pub chance: Option<f64>,
    /// Whether anything differs by more than chance.
    pub changed: bool,
    /// The result in sentences.
    pub sentence: String,
}

/// Compare two model files of one robot on one support.
///
/// ```
/// use sesc_identify::compare::compare;
/// use sesc_model::ModelFile;
///
/// let file = |mm: f64, name: &str| {
///     let text = format!(
///         "robot = \"rod\"\nhash = \"0000000000000000\"\nsupport = \"foot\"\n\
///          [[parameters]]\nname = \"leg.z\"\nvalue = {}\nstd = 0.0001\nsource = \"data\"\n",
///         mm / 1000.0
///     );
///     ModelFile::parse(&text, name)
/// };
/// let (monday, friday) = (file(100.0, "monday.toml")?, file(103.0, "friday.toml")?);
/// let found = compare(&monday, &friday).unwrap();
/// assert!(found.changed, "3 mm are 21 standard deviations of the difference");
/// # Ok::<(), sesc_model::Error>(())
/// ```
///
/// # Errors
/// Where the files are of different supports, or their base parameters have other names:
/// then they describe different robots.
pub fn compare(before: &ModelFile, after: &ModelFile) -> Result<Comparison, Error> {
    let refused = |reason: String| {
        let refused = sesc_model::Error::model_file(&after.file, reason);
        Err(Error::from(refused))
    };
    if before.support != after.support {
        return refused(format!(
            "stands on `{}`, {} on `{}`: identify both on one support",
            after.support, before.file, before.support
        ));
    }
    let names = [before, after].map(|file| -> BTreeSet<&str> {
        file.parameters.iter().map(|p| p.name.as_str()).collect()
    });
    if let Some(name) = names[0].symmetric_difference(&names[1]).next() {
        let (mut has, mut lacks) = (&before.file, &after.file);
        if names[1].contains(name) {
            (has, lacks) = (lacks, has);
        }
        return refused(format!(
            "base parameter `{name}` is in {has} and not in {lacks}: the two are models of \
             different robots"
        ));
    }
    let (parameters, squares) = masses(before, after);
    let chance = chance(&squares);
    let effects = effects(before, after);
    let is_same = |e: &EffectChange| matches!(e.change, Change::Same | Change::Unknown);
    let masses_changed = chance.is_some_and(|chance| chance < CHANCE);
    let hashes = [before, after].map(|file| -> BTreeSet<&str> {
        file.data.iter().map(|data| data.hash.as_str()).collect()
    });
    let mut comparison = Comparison {
        robot: after.robot.clone(),
        support: after.support.clone(),
        same_urdf: before.hash == after.hash,
        noise_floor: [before.noise_floor, after.noise_floor],
        same_data: !before.data.is_empty() && hashes[0] == hashes[1],
        changed: !effects.iter().all(is_same) || masses_changed,
        effects,
        parameters,
        directions: squares.len(),
        chi2: squares.iter().sum(),
        chance,
        sentence: String::new(),
    };
    comparison.sentence = sentence(&comparison);
    Ok(comparison)
}

/// The base parameters of two files, and z² along the directions that both determine.
fn masses(before: &ModelFile, after: &ModelFile) -> (Vec<Difference>, Vec<f64>) {
    let n = before.parameters.len();
    // Place of every parameter of the first file in the second.
    let place = |name: &str| after.parameters.iter().position(|own| own.name == name);
    let places = before.parameters.iter().filter_map(|p| place(&p.name));
    let places: Vec<usize> = places.collect();
    let (a, b) = (covariance(before), covariance(after));
    let total = DMatrix::from_fn(n, n, |i, k| a[(i, k)] + b[(places[i], places[k])]);
    let difference = |k: usize| {
        let (old, new) = (&before.parameters[k], &after.parameters[places[k]]);
        let std = Some(total[(k, k)].sqrt()).filter(|std| std.is_finite());
        Difference::new(&old.name, [old.value, new.value].map(Some), std)
    };
    let differences = (0..n).map(difference).collect();
    let known: Vec<usize> = (0..n).filter(|&k| total[(k, k)].is_finite()).collect();
    let gap = DVector::from_fn(known.len(), |at, _| {
        let k = known[at];
        after.parameters[places[k]].value - before.parameters[k].value
    });
    let total = total.select_rows(&known).select_columns(&known);
    (differences, squares(total, &gap))
}

/// Covariance of a file's base parameters; infinite where it gives no deviation.
fn covariance(file: &ModelFile) -> DMatrix<f64> {
    let n = file.parameters.len();
    let factor = file.information.as_ref().map(|i| &i.factor);
    let Some(factor) = factor.filter(|factor| factor.len() == n) else {
        let variances = file.parameters.iter().map(|p| p.std);
        let variances = variances.map(|std| std.map_or(f64::INFINITY, |std| std * std));
        return DMatrix::from_diagonal(&DVector::from_iterator(n, variances));
    };
    let inverse = inverse(factor);
    let mut found = &inverse * inverse.transpose();
    for k in (0..n).filter(|&k| factor[k][0] <= 0.0) {
        found[(k, k)] = f64::INFINITY;
    }
    found
}

/// z² along the axes of a covariance, those of the smallest variance first.
fn squares(covariance: DMatrix<f64>, gap: &DVector<f64>) -> Vec<f64> {
    if gap.is_empty() {
        return Vec::new();
    }
    let axes = symmetric_eigen(covariance);
    let largest = axes.eigenvalues.max();
    let mut order: Vec<usize> = (0..gap.len()).collect();
    order.sort_by(|i, k| axes.eigenvalues[*i].total_cmp(&axes.eigenvalues[*k]));
    let squares = order.into_iter().map(|k| {
        // Below this a variance is the rounding of larger ones.
        let variance = axes.eigenvalues[k].max(1e-15 * largest);
        axes.eigenvectors.column(k).dot(gap).powi(2) / variance
    });
    squares.filter(|square| square.is_finite()).collect()
}

/// Smallest probability of Σ z² over the first 1, 2, 4, … directions, times their number.
fn chance(squares: &[f64]) -> Option<f64> {
    let all = squares.len();
    let doubled = std::iter::successors(Some(1), |k| Some(2 * k));
    let counts = doubled.take_while(|k| *k < all);
    let counts: Vec<usize> = counts.chain((all > 0).then_some(all)).collect();
    let of = |count: &usize| {
        let sum: f64 = squares[..*count].iter().sum();
        ChiSquared::new(*count as f64).map(|law| law.sf(sum)).ok()
    };
    let least = counts.iter().filter_map(of).reduce(f64::min)?;
    Some((least * counts.len() as f64).min(1.0))
}

fn effects(before: &ModelFile, after: &ModelFile) -> Vec<EffectChange> {
    fn record<'f>(file: &'f ModelFile, own: &EffectRecord) -> Option<&'f EffectRecord> {
        let is_it = |x: &&EffectRecord| x.effect == own.effect && x.target == own.target;
        file.effects.iter().find(is_it)
    }
    let fresh = after.effects.iter();
    let fresh = fresh.filter(|new| record(before, new).is_none());
    let all = before.effects.iter().chain(fresh);
    let change = |own| effect(own, [before, after].map(|file| record(file, own)));
    all.map(change).collect()
}

/// What became of an effect, of which `own` is a record.
fn effect(own: &EffectRecord, records: [Option<&EffectRecord>; 2]) -> EffectChange {
    let both = records.iter().flatten();
    let names: BTreeSet<&String> = both.flat_map(|r| r.parameters.keys()).collect();
    let difference = |name: &String| {
        let [a, b] = records.map(|record| record?.parameters.get(name).copied());
        let std = match (a, b) {
            (Some(a), Some(b)) => a.std.zip(b.std).map(|(a, b)| a.hypot(b)),
            (one, other) => one.or(other).and_then(|only| only.std),
        };
        Difference::new(name, [a, b].map(|x| x.map(|x| x.value)), std)
    };
    let parameters: Vec<Difference> = names.into_iter().map(difference).collect();
    EffectChange {
        effect: own.effect.clone(),
        target: own.target.clone(),
        change: match records {
            [None, _] => Change::Appeared,
            [_, None] => Change::Gone,
            _ => change(&parameters),
        },
        parameters,
    }
}

/// What the values of an effect that both models have come to.
fn change(parameters: &[Difference]) -> Change {
    let judged = parameters.iter().filter_map(|p| p.deviations);
    let most = judged.clone().fold(0.0, f64::max);
    let count = judged.count();
    // Two-sided, for as many values as are looked at.
    let normal = Normal::standard();
    let chance = 2.0 * normal.sf(most) * count.max(1) as f64;
    let unjudged = |p: &Difference| p.deviations.is_none() && p.before != p.after;
    match (chance < CHANCE, parameters.iter().any(unjudged)) {
        (true, _) => Change::Changed,
        (false, true) => Change::Unknown,
        (false, false) => Change::Same,
    }
}

impl Comparison {
    /// The base parameters that differ most, in deviations, the largest first.
    pub fn largest(&self) -> Vec<&Difference> {
        let of = |p: &Difference| p.deviations.unwrap_or(0.0);
        let judged = self.parameters.iter().filter(|p| of(p) > 0.0);
        let mut judged: Vec<&Difference> = judged.collect();
        judged.sort_by(|a, b| of(b).total_cmp(&of(a)));
        judged.truncate(5);
        judged
    }
}

fn sentence(found: &Comparison) -> String {
    let mut said = Vec::new();
    for (change, what) in [
        (Change::Appeared, "These effects appeared:"),
        (Change::Gone, "These effects are gone:"),
        (Change::Changed, "These effects differ by more than chance:"),
        (Change::Same, "These effects differ by no more than chance:"),
        (
            Change::Unknown,
            "These effects differ, and no deviations are known to judge them by:",
        ),
    ] {
        let own = found.effects.iter().filter(|e| e.change == change);
        let own: Vec<String> = own.map(|e| subject(&e.effect, &e.target)).collect();
        if !own.is_empty() {
            said.push(format!("{what} {}.", own.join(", ")));
        }
    }
    said.push(match found.chance {
        None => {
            "Deviations of the masses' parameters are not known, so these are not judged.".into()
        }
        Some(_) if found.chi2 == 0.0 => "The masses' parameters are the same.".into(),
        Some(chance) if chance < CHANCE => format!(
            "The masses' parameters differ by more than chance: without a change a difference \
             like this has a probability {}.",
            match chance < LEAST_CHANCE {
                true => format!("below {LEAST_CHANCE:e}"),
                false => format!("of {chance:.1e}"),
            }
        ),
        Some(chance) => format!(
            "The masses' parameters differ by no more than chance: without a change a difference \
             like this has a probability of {:.0} %.",
            100.0 * chance
        ),
    });
    if found.same_data {
        said.push(
            "Both were identified from the same data, so chance made the same errors in both."
                .into(),
        );
    }
    if !found.same_urdf {
        said.push("The two are of different URDFs; parameters are compared by name.".into());
    }
    said.join(" ")
}

#[cfg(test)]
mod tests;
