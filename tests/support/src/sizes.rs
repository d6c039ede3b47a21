//! How large an effect is hidden: from barely visible to as large as happens.
//!
//! ```text
//! chi2(s) = Σ_{postures, axes} (gap(s) / σ)²          what a size s shows
//! s       = s_visible^(1-u) s_large^u                 log-uniform; chi2(s_visible) = 100
//! ```

use rand::seq::IndexedRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, UnitSphere};
use sesc_reference::{Robot, Track};

use crate::hidden::{ALL, Effect, Hidden, NOWHERE, hide_all};
use crate::stage::Stage;

/// What makes an effect visible: the goals count logs above it.
pub const VISIBLE: f64 = 100.0;
/// Below this nobody can say that anything is hidden.
pub const INVISIBLE: f64 = 10.0;

/// The total square of what the hidden show, over the noise.
pub fn chi2(stage: &Stage, hidden: &[Hidden], track: &Track, sigma: f64) -> f64 {
    let Ok(bent) = hide_all(stage.world(), hidden) else {
        return f64::NAN;
    };
    let (bent, straight) = (bent.readings(track), stage.world().readings(track));
    let gaps = bent.iter().zip(&straight);
    gaps.map(|(bent, straight)| {
        let [x, y] = [0, 1].map(|axis| (bent.cop[axis] - straight.cop[axis]) / sigma);
        x * x + y * y
    })
    .sum()
}

/// An effect of a random target and direction, as large as it may be.
pub fn large(effect: Effect, stage: &Stage, random: &mut ChaCha8Rng) -> Hidden {
    let seed = random.random();
    let target = target(effect, stage, random);
    let values = largest(effect, stage, &target, random);
    let begins = match effect {
        Effect::Cable => stage.middle(&target),
        _ => 0.0,
    };
    Hidden {
        effect,
        target,
        values,
        begins,
        seed,
    }
}

/// The same between visible and large; none where even the largest is not seen.
pub fn visible(
    hidden: Hidden,
    stage: &Stage,
    track: &Track,
    sigma: f64,
    random: &mut ChaCha8Rng,
) -> Option<Hidden> {
    let scaled = |s: f64| hidden.with(hidden.values.iter().map(|v| s * v).collect());
    let shown = |s: f64| chi2(stage, &[scaled(s)], track, sigma);
    let most = shown(1.0);
    // Not a number where springs are too soft to stand on.
    if most.is_nan() || most <= VISIBLE {
        return None;
    }
    if hidden.effect.parameters() == 0 {
        return Some(hidden);
    }
    let mut least = (VISIBLE / most).sqrt();
    for _ in 0..4 {
        least = (least * (VISIBLE / shown(least)).sqrt()).clamp(1e-4, 1.0);
    }
    let size = least.powf(1.0 - random.random::<f64>());
    Some(scaled(size))
        .filter(|hidden| chi2(stage, std::slice::from_ref(hidden), track, sigma) > 0.9 * VISIBLE)
}

fn target(effect: Effect, stage: &Stage, random: &mut ChaCha8Rng) -> String {
    let joints = stage.joint_names();
    let mut joint = || joints.choose(random).cloned().unwrap_or_default();
    match effect {
        Effect::CellGain | Effect::CellOffset | Effect::CellExponent | Effect::CellSaturation => {
            format!("fsr_{}", random.random_range(1..=4))
        }
        Effect::Payload | Effect::HangingLoad | Effect::ExternalForce => {
            let links = stage.robot.links().iter();
            let links: Vec<&str> = links
                .filter(|link| link.mass_kg > 0.0)
                .map(|link| link.name.as_str())
                .collect();
            links
                .choose(random)
                .map_or_else(String::new, |link| (*link).to_owned())
        }
        Effect::LooseMass => heaviest(&stage.robot),
        Effect::JointOffset | Effect::JointScale | Effect::JointSign => joint(),
        Effect::BendingLink | Effect::Cable | Effect::GearError => joint(),
        Effect::KneeSine => {
            let knee = |joint: &&String| stage.carries(joint) && joint.contains("knee");
            joints.iter().find(knee).cloned().unwrap_or_default()
        }
        Effect::JointSwap => {
            let mut pair = [joint(), joint()];
            while pair[0] == pair[1] {
                pair[1] = joint();
            }
            pair.join(",")
        }
        Effect::JointCompliance | Effect::Backlash => {
            let one = joint();
            if random.random_bool(0.4) {
                ALL.to_owned()
            } else {
                one
            }
        }
        _ => NOWHERE.to_owned(),
    }
}

fn heaviest(robot: &Robot) -> String {
    let links = robot.links().iter();
    let most = links.max_by(|a, b| a.mass_kg.total_cmp(&b.mass_kg));
    most.map_or_else(String::new, |link| link.name.clone())
}

/// Values as large as they come.
pub fn largest(effect: Effect, stage: &Stage, target: &str, random: &mut ChaCha8Rng) -> Vec<f64> {
    let world = stage.world();
    let weight = world.nominal_weight();
    let length = stage.size;
    let mut around = |size: f64| size * (2.0 * random.random::<f64>() - 1.0);
    match effect {
        Effect::SensorOffset => vec![around(0.012 * length), around(0.012 * length)],
        Effect::SensorDrift => vec![around(0.010 * length), around(0.010 * length)],
        Effect::SensorGain => vec![around(0.15), around(0.15)],
        Effect::SensorRotation => vec![0.2 * around(1.0).signum()],
        Effect::CellGain => vec![0.3 * around(1.0).signum()],
        Effect::CellOffset => vec![0.1 * weight * around(1.0).signum()],
        Effect::CellExponent => vec![0.25 * around(1.0).signum()],
        // A cell full at a quarter of the weight.
        Effect::CellSaturation => vec![4.0 / weight],
        Effect::GroundSlope => vec![around(0.07), around(0.07)],
        Effect::Payload | Effect::HangingLoad => payload(effect, stage, target, random),
        Effect::ExternalForce => {
            let direction: [f64; 3] = UnitSphere.sample(random);
            direction.map(|x| 0.07 * weight * x).to_vec()
        }
        Effect::JointOffset => vec![0.12 * around(1.0).signum()],
        Effect::JointScale => vec![0.2 * around(1.0).signum()],
        Effect::JointSign | Effect::JointSwap | Effect::Units => Vec::new(),
        // Bends a few degrees under the largest load of a balanced posture.
        Effect::JointCompliance if target == ALL => vec![0.03 / largest_moment(stage, None)],
        Effect::JointCompliance => vec![0.06 / largest_moment(stage, Some(target))],
        Effect::Cable => vec![0.5],
        Effect::BendingLink => vec![0.05 / largest_moment(stage, None)],
        Effect::Backlash if target == ALL => vec![0.015],
        Effect::Backlash => vec![0.06],
        Effect::TimeDelay => vec![0.15 * around(1.0).signum()],
        Effect::MassDistribution => vec![0.25],
        Effect::CopOutliers => vec![0.010 * length],
        Effect::KneeSine => vec![0.008 * length],
        Effect::LooseMass => vec![0.1 * weight / sesc_reference::GRAVITY],
        Effect::GearError => vec![0.06],
    }
}

/// What a joint carries at most in balanced postures, or the joint that carries
/// most, N m.
fn largest_moment(stage: &Stage, joint: Option<&str>) -> f64 {
    let world = stage.world();
    let names = stage.joint_names();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let moments = stage.balanced(20, &mut random).into_iter().flat_map(|q| {
        let moments = names.iter().zip(world.joint_moments(&q));
        let asked = moments.filter(|(name, _)| joint.is_none_or(|joint| joint == name.as_str()));
        asked.map(|(_, moment)| moment.abs()).collect::<Vec<_>>()
    });
    // A joint that carries nothing is not soft either.
    moments.fold(1e-3, f64::max)
}

/// A mass on a link, somewhere within a hand of its CoM; or one missing.
fn payload(effect: Effect, stage: &Stage, target: &str, random: &mut ChaCha8Rng) -> Vec<f64> {
    let links = stage.robot.links().iter();
    let link = links.clone().find(|link| link.name == target);
    let (own_kg, com) = link.map_or((0.0, [0.0; 3]), |link| {
        (link.mass_kg, [link.com_m.x, link.com_m.y, link.com_m.z])
    });
    let total_kg: f64 = links.map(|link| link.mass_kg).sum();
    let missing = effect == Effect::Payload && random.random_bool(0.35);
    let (mass, reach) = if missing {
        (-(0.6 * own_kg).min(0.1 * total_kg), 0.01)
    } else {
        (0.1 * total_kg, 0.06)
    };
    let direction: [f64; 3] = UnitSphere.sample(random);
    let mut values = vec![mass];
    values.extend([0, 1, 2].map(|i| mass * (com[i] + reach * stage.size * direction[i])));
    values
}
