//! Effects that robots share: one batch of servos, one firmware, one error of the URDF.
//!
//! ```text
//! v_i = μ + b_i + e_i      b_i ~ N(0, τ²): the robot's own      e_i ~ N(0, s_i²): the estimate's
//! ```
//!
//! v_i is the size of one effect at one target in robot i over its days. μ is what the robots
//! share, and τ how far each is from it, both by empirical Bayes.
//!
//! Whether k of n robots agree by chance is asked of the smallest window of width w that holds
//! them. If sizes were spread evenly over R (twice the largest of this effect anywhere in the
//! fleet), and faults over T targets, then
//!
//! ```text
//! p_sizes  = (n − 1) C(n, k) k (w/R)^(k−1)        some k of n agree so well
//! p_target = P(Binomial(N, 1/T) ≥ n)              so many have this target
//! p        = x (1 − ln x)    with x = p_sizes p_target, two independent chances
//! ```
//!
//! with N robots that have this effect at any target, and T one more than the targets seen. p,
//! times the number of effects and targets that were looked at, has to be below
//! [`FALSE_ALARM`].
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
use statrs::distribution::{Binomial, DiscreteCDF as _};
use statrs::function::gamma::ln_gamma;

use super::history::{History, Key, Said, absent, found, pooled, principal, said};
use super::{ALIKE, FALSE_ALARM, LEAST_WINDOW, MOST};
use crate::diagnose::subject;
use crate::diagnose::words::{NamedValue, spoken};
use crate::fleet::row::{Absent, Row, Size};
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
    size: Size,
}

/// Robots with an effect at a target.
struct Candidate<'r> {
    key: Key,
    parameter: String,
    /// What the parameter is without the effect, where that is not 0.
    absent: Option<Absent>,
    /// Robots that no group of this effect and target holds yet.
    members: Vec<Member<'r>>,
    /// Groups of this effect and target, and their robots.
    groups: usize,
    grouped: usize,
}

pub(super) fn shared(histories: &[History]) -> Vec<Shared> {
    let keys: BTreeSet<Key> = histories.iter().flat_map(History::keys).collect();
    let open = keys.into_iter().filter_map(|key| candidate(histories, key));
    let mut open: Vec<Candidate> = open.collect();
    let looked_at = open.iter().filter(|c| c.members.len() > 1).count().max(1);
    let scale = scales(&open);
    let mut found = Vec::new();
    // What most robots have is judged first: robots that it explains are not asked for what
    // could be in its place.
    loop {
        open.sort_by(|a, b| (b.members.len(), &a.key).cmp(&(a.members.len(), &b.key)));
        let Some(at) = (0..open.len()).find(|at| open[*at].members.len() > 1) else {
            break;
        };
        let mut candidate = open.remove(at);
        let (range, robots, targets) = scale[&candidate.key.0];
        let robots = robots - candidate.grouped;
        // Whoever looks for a second group looks once more.
        let looks = (looked_at * (1 + candidate.groups)) as f64;
        let Some(group) = group(&candidate, range, (robots, targets), looks) else {
            continue;
        };
        for other in &mut open {
            let Candidate { key, members, .. } = other;
            members.retain(|member| {
                let robot = histories.iter().find(|own| own.robot == member.robot);
                let apart = |robot| never_together(robot, &candidate.key, key);
                let is_of_group = group.robots.iter().any(|name| name == member.robot);
                !(is_of_group && robot.is_some_and(apart))
            });
        }
        // Robots with another size of the same may be a batch of their own.
        let holds = |member: &Member| group.robots.iter().any(|name| name == member.robot);
        candidate.members.retain(|member| !holds(member));
        candidate.groups += 1;
        candidate.grouped += group.robots.len();
        open.push(candidate);
        found.push(group);
    }
    found.sort_by(|a, b| {
        let size = b.robots.len().cmp(&a.robots.len());
        size.then(a.chance.total_cmp(&b.chance))
    });
    found
}

/// Whether no row of a robot is explained by both.
fn never_together(robot: &History, one: &Key, other: &Key) -> bool {
    let both = |row: &&Row| found(row, one).is_some() && found(row, other).is_some();
    !robot.rows.iter().any(both)
}

/// Robots whose rows have an effect most of the time.
fn candidate<'r>(histories: &[History<'r>], key: Key) -> Option<Candidate<'r>> {
    let rows = histories.iter().flat_map(History::usable);
    let parameter = principal(rows.filter_map(|row| found(row, &key)))?;
    let member = |history: &History<'r>| {
        let (mut rows, mut possible, mut sizes) = (0, 0, Vec::new());
        for row in history.usable() {
            rows += 1;
            match said(row, &key) {
                Said::Found(found) => {
                    possible += 1;
                    sizes.extend(found.away(&parameter));
                }
                Said::Possible => possible += 1,
                Said::No => {}
            }
        }
        let lasts = possible as f64 >= MOST * rows as f64;
        let (size, _) = pooled(&sizes).filter(|_| lasts)?;
        Some(Member {
            robot: history.robot,
            size,
        })
    };
    let members: Vec<Member> = histories.iter().filter_map(member).collect();
    let rows = histories.iter().flat_map(History::usable);
    let absent = absent(rows, &key, &parameter);
    (!members.is_empty()).then_some(Candidate {
        key,
        parameter,
        absent,
        members,
        groups: 0,
        grouped: 0,
    })
}

/// For every effect: how far its sizes reach, how many robots have it, at how many targets.
fn scales(all: &[Candidate]) -> BTreeMap<String, (f64, usize, usize)> {
    let mut scales: BTreeMap<String, (f64, usize, usize)> = BTreeMap::new();
    for candidate in all {
        let (range, robots, targets) = scales.entry(candidate.key.0.clone()).or_default();
        let sizes = candidate.members.iter().map(|m| m.size.value.abs());
        *range = sizes.fold(*range, |range, size| range.max(2.0 * size));
        *robots += candidate.members.len();
        *targets += 1;
    }
    scales
}

/// The robots of a candidate that agree most clearly, if that is beyond chance.
fn group(
    candidate: &Candidate,
    range: f64,
    (robots, targets): (usize, usize),
    looked_at: f64,
) -> Option<Shared> {
    let mut members: Vec<&Member> = candidate.members.iter().collect();
    members.sort_by(|a, b| a.size.value.total_cmp(&b.size.value));
    let n = members.len();
    // Sums of the deviations of the first members.
    let mut sums = vec![0.0];
    sums.extend(members.iter().scan(0.0, |sum, member| {
        *sum += member.size.std;
        Some(*sum)
    }));
    let mut best: Option<(f64, usize, usize)> = None;
    for i in 0..n {
        for j in i + 1..n {
            let of = &members[i..=j];
            let (low, high) = (of[0].size.value, of[of.len() - 1].size.value);
            let middle = 0.5 * (low + high).abs();
            if high - low > ALIKE * middle {
                break;
            }
            let std = (sums[j + 1] - sums[i]) / of.len() as f64;
            let width = (high - low).max(LEAST_WINDOW * std);
            let chance = ln_chance(n, of.len(), width / range, robots, targets);
            if best.is_none_or(|(least, ..)| chance < least) {
                best = Some((chance, i, j));
            }
        }
    }
    let (ln_chance, i, j) = best?;
    let chance = (ln_chance.exp() * looked_at).min(1.0);
    if chance > FALSE_ALARM {
        return None;
    }
    let sizes: Vec<Size> = members[i..=j].iter().map(|m| m.size).collect();
    let (size, own_std) = pooled(&sizes)?;
    let own_std_interval = interval(&sizes, own_std).unwrap_or([0.0, own_std]);
    // As people know the parameter, and not from what it is without the effect.
    let back = |away: Size| candidate.absent.map_or(away, |absent| absent.back(away));
    let spread = |std: f64| back(Size { std, ..size }).std;
    let (own_std, own_std_interval) = (spread(own_std), own_std_interval.map(spread));
    let size = back(size);
    let of_group = members[i..=j].iter().map(|member| {
        let size = back(member.size);
        SharedMember {
            robot: member.robot.to_string(),
            value: size.value,
            std: size.std,
        }
    });
    let mut of_group: Vec<SharedMember> = of_group.collect();
    of_group.sort_by(|a, b| a.robot.cmp(&b.robot));
    let robots: Vec<String> = of_group.iter().map(|member| member.robot.clone()).collect();
    let (effect, target) = candidate.key.clone();
    let said = size.named(&candidate.parameter);
    let own = own_in_words(&candidate.parameter, own_std, own_std_interval);
    let sentence = format!(
        "{} robots share {}: {said}; {own}. Chance would make such a group in {} fleets.",
        robots.len(),
        subject(&effect, &target),
        one_in(chance)
    );
    Some(Shared {
        effect,
        target,
        parameter: candidate.parameter.clone(),
        robots,
        size: size.value,
        std: size.std,
        own_std,
        own_std_interval,
        members: of_group,
        chance,
        sentence,
    })
}

/// How far robots are from what they share, with its 95 % interval.
fn own_in_words(parameter: &str, own_std: f64, [low, high]: [f64; 2]) -> String {
    let say = |value: f64| {
        let said = spoken(&NamedValue {
            name: parameter,
            value,
            std: 0.0,
        });
        said.split(" ±").next().unwrap_or(&said).to_string()
    };
    match own_std > 0.0 {
        true => format!(
            "each differs from it by {} RMS (95 %: {} to {})",
            say(own_std),
            say(low),
            say(high)
        ),
        false => format!(
            "they differ by no more than their uncertainty (95 %: at most {} RMS)",
            say(high)
        ),
    }
}

/// `1 of 1000`, or of as many more.
pub(super) fn one_in(chance: f64) -> String {
    match chance {
        p if p < 1e-9 => "less than 1 of a billion".to_string(),
        p => format!("1 of {:.0}", 1.0 / p),
    }
}

/// ln of the probability above.
fn ln_chance(n: usize, k: usize, part: f64, robots: usize, targets: usize) -> f64 {
    let ln_factorial = |x: usize| ln_gamma(x as f64 + 1.0);
    let choose = ln_factorial(n) - ln_factorial(k) - ln_factorial(n - k);
    let within = (k as f64 - 1.0) * part.clamp(1e-12, 1.0).ln();
    let sizes = (n as f64 - 1.0).ln() + choose + (k as f64).ln() + within;
    let law = Binomial::new(1.0 / (targets as f64 + 1.0), robots as u64);
    let target = law.map_or(0.0, |law| law.sf(n as u64 - 1).max(1e-300).ln());
    let both = sizes.min(0.0) + target.min(0.0);
    both + (1.0 - both).ln()
}

/// 95 % interval of τ around an estimate of it; none of fewer than two values.
fn interval(values: &[Size], estimate: f64) -> Option<[f64; 2]> {
    let known: Vec<Size> = values.iter().copied().filter(|v| v.std > 0.0).collect();
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
    let end = |inside: f64, outside: f64| {
        let (mut inside, mut outside) = (inside, outside);
        // To a part of 10⁻¹².
        for _ in 0..40 {
            let middle = 0.5 * (inside + outside);
            match is_in(likelihood(&known, middle)) {
                true => inside = middle,
                false => outside = middle,
            }
        }
        inside
    };
    let low = below.map_or(0.0, |at| end(points[at + 1].0, points[at].0));
    let high = above.map_or(most, |at| end(points[at - 1].0, points[at].0));
    // The estimate is by moments, and may be a little outside.
    Some([low.min(estimate), high.max(estimate)])
}

fn likelihood(values: &[Size], tau: f64) -> f64 {
    let variance = |v: &Size| v.std * v.std + tau * tau;
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
                let values: Vec<Size> = (0..8)
                    .map(|k| {
                        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                        let std = 1.0 + k as f64 / 7.0;
                        Size {
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
        let size = |value: f64| Size { value, std: 0.1 };
        assert_eq!(interval(&[size(1.0)], 0.0), None);
        let [low, high] = interval(&[size(1.0), size(1.0)], 0.0).unwrap();
        assert!(low == 0.0 && (0.1..1.0).contains(&high), "{high}");
        let [_, wide] = interval(&[size(1.0), size(2.0)], 0.7).unwrap();
        assert!(wide > 2.0, "{wide}");
    }
}
