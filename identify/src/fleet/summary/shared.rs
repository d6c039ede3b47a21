//! Effects that robots share: one batch of servos, one firmware, one error of the URDF.
//!
//! ```text
//! v_i = μ + b_i + e_i      b_i ~ N(0, τ²): the robot's own      e_i ~ N(0, s_i²): the estimate's
//! ```
//!
//! v_i is the size of one effect at one target in robot i over its days: that of the day's
//! explanation, else that of the effect as the whole explanation, which every row scores. μ is what
//! the robots share, and τ how far each is from it, both by empirical Bayes.
//!
//! Robots that share an effect are told from those that do not by a mixture:
//!
//! ```text
//! t₄(0, σ_i²)   a robot without it      σ_i² = s_i² + τ₀²     τ₀: what bodies of this fleet make of it
//! N(0, R²)      a part ω_i: a fault of its own                R: the largest size of this effect
//! N(μ, σ_i² + (DIFFER μ)²)    a part π: the group
//!
//! Λ(μ, π) = Σ_i ln (with the group) − Σ_i ln (without)
//! chance  = looks · |grid of μ| / max_μ mean_π exp Λ
//! ```
//!
//! A fault of another kind shows as a size of this effect, too, but the other effect explains that
//! robot better. So ω_i is [`OWN`] where another one does (by more than explanations of a class are
//! apart); else the part of robots with an explanation, at least [`OWN`], over the effects that are
//! looked at, [`ALIKE`] of which are about the same.
//!
//! exp Λ of one (μ, π) has the mean 1 where nothing is shared, so that it is as large by chance as
//! its inverse says (Markov); μ is looked for at the sizes of robots, as at places of a grid as wide as
//! robots of a group differ.
//! Of all effects whose chance is below [`FALSE_ALARM`] and whose evidence in the robots of the group
//! is above 0 in sum, the group with the largest
//!
//! ```text
//! Σ_i (Σ_d (E_id + 1 − ((v_id − μ)/σ_id)²) − max E_i − 2 ln ω)
//! ```
//!
//! with E_id the evidence of the effect in robot i on day d, and max E_i that of the effect which
//! explains the robot best, comes first: an effect that stands for another fits each robot, and worse.
//!
//! How far robots of a group are from what they share, and how well a few robots tell it:
//!
//! ```text
//! v_i ~ N(μ, s_i² + τ²)      w_i = 1/(s_i² + τ²)      μ̂ = Σ w_i v_i / Σ w_i
//! l(τ) = −½ (Σ ln(s_i² + τ²) + ln Σ w_i + Σ w_i (v_i − μ̂)²)        μ integrated out (REML)
//! 95 %:  2 (l(τ̂) − l(τ)) ≤ 3.84                                   profile likelihood
//! ```
//!
//! Robots of a group were chosen because they agree: the interval says what their numbers tell
//! and knows nothing of robots that were left out.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use sesc_model::text::listed;

use super::history::{History, Key, pooled, principal};
use super::{ALIKE, CLEARLY, DIFFER, FALSE_ALARM, OWN};
use crate::diagnose::words::{named, spoken};
use crate::diagnose::{CLASS_SCORE, Quantity, TOLD_APART};
use crate::fleet::row::{Absent, Row};
use crate::observations::noise::quantile;
use crate::observations::postures::range;

/// An effect that robots share.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Shared {
    /// Name of the effect: `joint_offset`.
    pub effect: String,
    /// Joint, link or cell; `-` for the whole.
    pub target: String,
    /// The parameter that `size` is of; its end is the unit.
    pub parameter: String,
    /// The robots.
    pub robots: Vec<String>,
    /// What they share.
    pub size: f64,
    /// Its standard deviation.
    pub std: f64,
    /// Standard deviation between the robots.
    pub own_std: f64,
    /// 95 % interval of `own_std`.
    pub own_std_interval: [f64; 2],
    /// Its size in each robot.
    pub members: Vec<SharedMember>,
    /// Effects with their targets that explain these robots about as well.
    pub instead: Vec<String>,
    /// Largest chance if nothing is shared.
    pub chance: f64,
    /// The same as a sentence.
    pub sentence: String,
}

/// What one robot of a group has of a shared effect, as its own days tell it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SharedMember {
    /// The robot.
    pub robot: String,
    /// The size over all its days.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// An effect in one robot over all its days.
struct Member<'r> {
    robot: &'r str,
    /// How far its parameter is from what it is without the effect.
    size: Quantity,
    /// The same on each day.
    days: Vec<Quantity>,
    /// Evidence of all days.
    evidence: f64,
    /// Evidence of the effect that explains the robot best.
    best: f64,
}

/// An effect at a target, in every robot that it is known of.
struct Candidate<'r> {
    key: Key<'r>,
    /// The parameter that stands for it, and what that is without it.
    parameter: (&'r str, Absent),
    /// Robots that no group holds yet.
    members: Vec<Member<'r>>,
    /// What bodies of this fleet make of the effect, a deviation.
    by_bodies: f64,
}

/// Robots that share an effect.
struct Group<'m, 'r> {
    members: Vec<&'m Member<'r>>,
    chance: f64,
    /// What the effect explains in them.
    sum: f64,
}

pub(super) fn shared(histories: &[History]) -> Vec<Shared> {
    let keys: BTreeSet<Key> = histories.iter().flat_map(History::scored).collect();
    let open = keys.into_iter().filter_map(|key| candidate(histories, key));
    let mut open: Vec<Candidate> = open.collect();
    // Evidence of the best effect of each robot, and the largest size of each effect.
    let (mut best, mut largest) = (BTreeMap::new(), BTreeMap::new());
    for Candidate { key, members, .. } in &open {
        for member in members {
            let best: &mut f64 = best.entry(member.robot).or_default();
            *best = best.max(member.evidence);
            let largest: &mut f64 = largest.entry(key.effect).or_default();
            *largest = largest.max(member.size.value.abs());
        }
    }
    for member in open.iter_mut().flat_map(|candidate| &mut candidate.members) {
        member.best = best[member.robot];
    }
    let looked_at = open.len().max(1) as f64;
    let own = histories.iter().filter(|history| history.has_effects());
    let own = own.count() as f64 / histories.len().max(1) as f64;
    let alike = own.max(OWN) * (ALIKE / looked_at).min(1.0);
    let mut found: Vec<Shared> = Vec::new();
    loop {
        // Whoever looks for a further group looks once more.
        let looks = (looked_at / ALIKE).max(1.0) * (1 + found.len()) as f64;
        let groups = open.iter().filter_map(|own| {
            let largest = largest[own.key.effect];
            Some((own, own.group(largest, histories.len(), alike, looks)?))
        });
        let Some((best, group)) = groups.max_by(|a, b| a.1.sum.total_cmp(&b.1.sum)) else {
            break;
        };
        let key = best.key;
        let robots: Vec<&str> = group.members.iter().map(|m| m.robot).collect();
        let as_well = open.iter().filter(|other| {
            let is_of_group = |m: &&Member| robots.contains(&m.robot);
            let of_group: Vec<&Member> = other.members.iter().filter(is_of_group).collect();
            let explained = other.explained(&of_group, alike);
            other.key != key && explained.is_some_and(|sum| sum + CLASS_SCORE > group.sum)
        });
        let instead = as_well.map(|other| other.key.label());
        let shared = best.shared(&group, instead.collect());
        for candidate in &mut open {
            let other = candidate.key;
            candidate.members.retain(|member| {
                let apart = || {
                    let robot = histories.iter().find(|own| own.robot == member.robot);
                    robot.is_some_and(|robot| never_together(robot, key, other))
                };
                !(robots.contains(&member.robot) && (other == key || apart()))
            });
        }
        found.push(shared);
    }
    found.sort_by(|a, b| {
        let size = b.robots.len().cmp(&a.robots.len());
        size.then(a.chance.total_cmp(&b.chance))
    });
    found
}

/// Whether no row of a robot is explained by both.
fn never_together(robot: &History, one: Key, other: Key) -> bool {
    let both = |row: &&Row| one.found(row).is_some() && other.found(row).is_some();
    !robot.rows.iter().any(both)
}

/// An effect in the robots whose rows score it.
fn candidate<'r>(histories: &[History<'r>], key: Key<'r>) -> Option<Candidate<'r>> {
    let rows = histories.iter().flat_map(History::usable);
    let parameter = principal(rows.filter_map(|row| key.scored(row)))?;
    let member = |history: &History<'r>| {
        let scores = history.usable().filter_map(|row| key.scored(row));
        let scores = scores.filter_map(|own| Some((own.away(parameter.0)?, own.evidence)));
        let (sizes, evidence): (Vec<Quantity>, Vec<f64>) = scores.unzip();
        let (size, _) = pooled(&sizes)?;
        Some(Member {
            robot: history.robot,
            size,
            days: sizes,
            evidence: evidence.iter().sum(),
            best: 0.0,
        })
    };
    let members: Vec<Member> = histories.iter().filter_map(member).collect();
    let mut sizes: Vec<f64> = members.iter().map(|m| m.size.value).collect();
    // In robots whose rows do not score it, it is none. Half of all normal numbers are within 0.674
    // deviations; what most robots share is no spread.
    sizes.resize(histories.len(), 0.0);
    let middle = quantile(sizes.iter().copied(), 0.5)?;
    let spread = quantile(sizes.iter().map(|size| (size - middle).abs()), 0.5)? / 0.674_490;
    let by_bodies = spread.powi(2) - quantile(members.iter().map(|m| m.size.std), 0.5)?.powi(2);
    (members.len() > 1).then_some(Candidate {
        key,
        parameter,
        members,
        by_bodies: by_bodies.max(0.0).sqrt(),
    })
}

/// Student's law of four degrees of freedom, of scale σ, as [`density`] without 1/√2π: bodies make
/// more large sizes than a normal law has (12 of 200 sound fleets had a group with eight degrees, 2
/// with four).
fn heavy(x: f64, std: f64) -> f64 {
    0.939_985_6 * (1.0 + 0.25 * (x / std).powi(2)).powf(-2.5) / std
}

/// `exp(−x²/2σ²)/σ`
fn density(x: f64, std: f64) -> f64 {
    (-0.5 * (x / std).powi(2)).exp() / std
}

impl<'r> Candidate<'r> {
    /// The robots that share the effect most clearly, of so many `robots`, if that is beyond chance;
    /// `largest` is its largest size anywhere.
    fn group(&self, largest: f64, robots: usize, alike: f64, looks: f64) -> Option<Group<'_, 'r>> {
        let members = &self.members;
        let std = |m: &Member| self.std(m);
        let without = members.iter().map(|m| {
            let is_other = m.evidence + TOLD_APART < m.best;
            let own = if is_other { OWN } else { alike };
            (1.0 - own) * heavy(m.size.value, std(m)) + own * density(m.size.value, largest)
        });
        let without: Vec<f64> = without.collect();
        // Of each robot: the density in a group at `at` over that outside of it.
        let ratios = |at: f64| -> Vec<f64> {
            let of_group = |m: &Member| density(m.size.value - at, std(m).hypot(DIFFER * at));
            let pairs = members.iter().zip(&without);
            pairs.map(|(m, without)| of_group(m) / without).collect()
        };
        let width = quantile(members.iter().map(std), 0.5)?;
        // Robots whose size is all alike are looked at once.
        let mut places: Vec<f64> = members.iter().map(|m| m.size.value).collect();
        places.retain(|at| at.abs() > width);
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| (*a - *b).abs() < 0.5 * width.max(DIFFER * b.abs()));
        let doubled = (1..).map(|k| 2.0_f64.powi(k) / robots as f64);
        let parts = doubled.take_while(|part| *part < 1.0).chain([1.0 - OWN]);
        let parts: Vec<f64> = parts.collect();
        // The mean over π, and the likeliest one.
        let by_part = |at: f64| {
            let ratios = ratios(at);
            let likelihood = |part: &f64| -> f64 {
                let of = |ratio: &f64| (1.0 - part + part * ratio).ln();
                // Robots of which nothing is known are not of it.
                let unknown = (robots - members.len()) as f64 * (1.0 - part).ln();
                ratios.iter().map(of).sum::<f64>() + unknown
            };
            let all: Vec<f64> = parts.iter().map(likelihood).collect();
            let best = (0..parts.len()).max_by(|a, b| all[*a].total_cmp(&all[*b]))?;
            let sum: f64 = all.iter().map(|own| (own - all[best]).exp()).sum();
            Some((all[best] + (sum / parts.len() as f64).ln(), at, parts[best]))
        };
        let scored = places.into_iter().filter_map(by_part);
        let (most, at, part) = scored.max_by(|a, b| a.0.total_cmp(&b.0))?;
        // ∫ dμ / max(σ, DIFFER μ), to both sides.
        let near = (width / DIFFER).min(largest);
        let places = 2.0 * (near / width + (largest / near).ln() / DIFFER);
        let chance = (looks * places.max(1.0) * (-most).exp()).min(1.0);
        // A robot that may as well have none of it is not told.
        let belongs = |(m, ratio): &(&Member, f64)| {
            part * ratio > 1.0 - part && m.size.value.abs() > CLEARLY * std(m)
        };
        let chosen = members.iter().zip(ratios(at)).filter(belongs);
        let chosen: Vec<&Member> = chosen.map(|(m, _)| m).collect();
        // What no robot's log asks for, in sum, is a bound of a search or the noise of a few days.
        let evidence = chosen.iter().map(|m| m.evidence).sum::<f64>();
        if chance > FALSE_ALARM || chosen.len() < 2 || evidence <= 0.0 {
            return None;
        }
        Some(Group {
            chance,
            sum: self.explained(&chosen, alike)?,
            members: chosen,
        })
    }

    /// How much better the effect explains these robots if they share it than each is explained by
    /// the best of its own.
    fn explained(&self, members: &[&Member], alike: f64) -> Option<f64> {
        let sizes: Vec<Quantity> = members.iter().map(|m| m.size).collect();
        let (shared, _) = pooled(&sizes)?;
        let of = |m: &&Member| {
            let own = self.by_bodies.hypot(DIFFER * shared.value);
            let misfit = |day: &Quantity| ((day.value - shared.value) / day.std.hypot(own)).powi(2);
            let days = m.days.iter().map(|day| 1.0 - misfit(day)).sum::<f64>();
            m.evidence + days - m.best - 2.0 * alike.ln()
        };
        Some(members.iter().map(of).sum())
    }

    /// How well the size in a robot is known as one that robots may share.
    fn std(&self, member: &Member) -> f64 {
        member.size.std.hypot(self.by_bodies)
    }

    /// What the robots of a group share.
    fn shared(&self, group: &Group, instead: Vec<String>) -> Shared {
        let sizes: Vec<Quantity> = group.members.iter().map(|m| m.size).collect();
        let (size, own_std) = pooled(&sizes).unwrap_or_default();
        let own_std_interval = interval(&sizes, own_std).unwrap_or([0.0, own_std]);
        // As people know the parameter, and not from what it is without the effect.
        let (name, absent) = self.parameter;
        let back = |away: Quantity| absent.back(away);
        let spread = |std: f64| back(Quantity { std, ..size }).std;
        let (own_std, own_std_interval) = (spread(own_std), own_std_interval.map(spread));
        let size = back(size);
        let of_robot = |member: &&Member| {
            let Quantity { value, std } = back(member.size);
            let robot = member.robot.to_string();
            SharedMember { robot, value, std }
        };
        let mut members: Vec<SharedMember> = group.members.iter().map(of_robot).collect();
        members.sort_by(|a, b| a.robot.cmp(&b.robot));
        let robots: Vec<String> = members.iter().map(|member| member.robot.clone()).collect();
        let said = named(name, size.value, size.std);
        let own = own_in_words(name, own_std, own_std_interval);
        let mut as_well = String::new();
        if !instead.is_empty() {
            as_well = format!("As well explained by {}. ", listed(&instead, 4));
        }
        let sentence = format!(
            "{} robots share {}: {said}; {own}. {as_well}Chance would make such a group in {} fleets.",
            robots.len(),
            self.key.subject(),
            one_in(group.chance)
        );
        Shared {
            effect: self.key.effect.to_string(),
            target: self.key.target.to_string(),
            parameter: name.to_string(),
            robots,
            size: size.value,
            std: size.std,
            own_std,
            own_std_interval,
            members,
            instead,
            chance: group.chance,
            sentence,
        }
    }
}

/// How far robots are from what they share, with its 95 % interval.
fn own_in_words(parameter: &str, own_std: f64, [low, high]: [f64; 2]) -> String {
    let [own, low, high] = [own_std, low, high].map(|value| {
        let said = spoken(parameter, value, 0.0);
        said.split(" ±").next().unwrap_or(&said).to_string()
    });
    if own_std > 0.0 {
        format!("each differs from it by {own} RMS (95 %: {low} to {high})")
    } else {
        format!("they differ by no more than their uncertainty (95 %: at most {high} RMS)")
    }
}

/// `1 of 1000`, or of as many more.
pub(super) fn one_in(chance: f64) -> String {
    if chance < 1e-9 {
        "less than 1 of a billion".to_string()
    } else {
        format!("1 of {:.0}", 1.0 / chance)
    }
}

/// 95 % interval of τ around an estimate of it; none of fewer than two values.
fn interval(values: &[Quantity], estimate: f64) -> Option<[f64; 2]> {
    let known: Vec<Quantity> = values.iter().copied().filter(|v| v.std > 0.0).collect();
    if known.len() < 2 {
        return None;
    }
    let (low, high) = range(known.iter().map(|v| v.value));
    let (least, widest) = range(known.iter().map(|v| v.std));
    let most = 1e3 * (high - low + widest);
    let first = 1e-3 * least;
    let step = (most / first).ln() / (399.0);
    let points = (0..400).map(|k| first * (step * f64::from(k)).exp());
    let points = std::iter::once(0.0).chain(points);
    let points: Vec<(f64, f64)> = points.map(|tau| (tau, likelihood(&known, tau))).collect();
    let best = (0..points.len()).max_by(|&a, &b| points[a].1.total_cmp(&points[b].1))?;
    let top = points[best].1;
    // 95 % of χ² with one degree of freedom.
    let level = top - 0.5 * 3.841_458_820_694_124;
    let is_in = |l: f64| l >= level;
    // The ends of the interval are between a point that is in it and the next that is not.
    let below = (0..best).rev().find(|at| !is_in(points[*at].1));
    let above = (best..points.len()).find(|at| !is_in(points[*at].1));
    let end = |mut inside: f64, mut outside: f64| {
        // To a part of 10⁻¹².
        for _ in 0..40 {
            let middle = 0.5 * (inside + outside);
            if is_in(likelihood(&known, middle)) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    };
    let low = below.map_or(0.0, |at| end(points[at + 1].0, points[at].0));
    let high = above.map_or(most, |at| end(points[at - 1].0, points[at].0));
    // The estimate is by moments, and may be a little outside.
    Some([low.min(estimate), high.max(estimate)])
}

fn likelihood(values: &[Quantity], tau: f64) -> f64 {
    let variance = |v: &Quantity| v.std * v.std + tau * tau;
    let sum: f64 = values.iter().map(|v| 1.0 / variance(v)).sum();
    let mean = values.iter().map(|v| v.value / variance(v)).sum::<f64>() / sum;
    let each = values.iter().map(|v| {
        let variance = variance(v);
        variance.ln() + (v.value - mean).powi(2) / variance
    });
    -0.5 * (each.sum::<f64>() + sum.ln())
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::super::history::pooled;
    use super::*;

    /// Eight robots, deviations of 1 to 2, drawn 400 times for each spread between robots.
    #[test]
    fn ninety_five_percent_of_intervals_hold_the_spread_between_robots() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        for tau in [0.0, 1.0, 5.0] {
            let mut held = 0;
            for _ in 0..400 {
                let values: Vec<Quantity> = (0..8)
                    .map(|k| {
                        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                        let std = 1.0 + k as f64 / 7.0;
                        Quantity {
                            value: 30.0 + tau * normal() + std * normal(),
                            std,
                        }
                    })
                    .collect();
                let (_, estimate) = pooled(&values).unwrap();
                let [low, high] = interval(&values, estimate).unwrap();
                assert!(low <= estimate && estimate <= high && high.is_finite());
                held += usize::from(low <= tau && tau <= high);
            }
            // 380 of 400 are expected; at 0 there is nothing below, and more hold it.
            assert!((364..=400).contains(&held), "{tau}: {held} of 400");
        }
    }

    #[test]
    fn two_robots_tell_little_and_one_tells_nothing() {
        let size = |value: f64| Quantity { value, std: 0.1 };
        assert_eq!(interval(&[size(1.0)], 0.0), None);
        let [low, high] = interval(&[size(1.0), size(1.0)], 0.0).unwrap();
        assert!(low == 0.0 && (0.1..1.0).contains(&high), "{high}");
        let [_, wide] = interval(&[size(1.0), size(2.0)], 0.7).unwrap();
        assert!(wide > 2.0, "{wide}");
    }
}
