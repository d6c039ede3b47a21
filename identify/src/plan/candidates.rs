//! Postures that the robot can stand in, drawn by seed.
//!
//! ```text
//! q = q_rest + s (u − q_rest)        u uniform within the limits, s in (0, 1]
//! q ← q + W Jᵀ (J W Jᵀ)⁻¹ (t − CoP(q))        until CoP(q) = t, a point drawn on the sole
//! ```
//!
//! Uniform postures hardly ever balance. Each draw is therefore moved, by
//! Newton steps through the CoM Jacobian J, to a CoP drawn within the region;
//! joints move in proportion to their squared ranges (W) and stop at their
//! limits. Where what CAD does not know would still carry the CoP over the
//! edge, the target goes half way to the middle. Then come the ground and the
//! robot's own body. Every draw that fails is counted with its reason.
//!
//! Where too few are found, the message has the numbers and what would help.

use nalgebra::{DMatrix, Matrix2, Vector2};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use sesc_model::Function;

use super::Request;
use super::limits::move_by;
use super::region::Region;
use super::scene::Scene;
use crate::evaluate::Evaluator;
use crate::poses;
use crate::{Error, Message, Setting, message};

/// Close enough to the target, m.
const NEAR: f64 = 1e-5;

/// What became of the draws.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(rename = "Draws")
)]
pub struct Counts {
    /// Postures drawn.
    pub drawn: usize,
    /// Of these, balanced.
    pub balanced: usize,
    /// Of these, clear of the ground.
    pub clear: usize,
    /// Of these, free of self-collision.
    pub collision_free: usize,
    /// How far each of the first draws is out, m, until one balances.
    #[serde(skip)]
    pub(crate) misses: Vec<f64>,
    /// Mean deviation of the CoP, m.
    pub cop_std: f64,
    /// How often each link was the one near the ground.
    #[serde(skip)]
    pub low: Vec<usize>,
}

/// Up to `wanted` postures that respect `scene`, from at most `draws` draws, one after the other,
/// and what became of the draws; the same seed draws the same. Gives up where the first 10,000
/// bring none.
///
/// # Errors
/// That of `progress`, which hears how many are found.
pub fn sample(
    scene: &Scene,
    seed: u64,
    wanted: usize,
    draws: usize,
    mut progress: impl FnMut(usize) -> Result<(), Error>,
) -> Result<(Vec<f64>, Counts), Error> {
    let model = scene.model;
    let mut sampler = Sampler {
        cop: Evaluator::new(model, Function::Cop),
        jacobian: Evaluator::new(model, Function::ComJacobian),
        regressor: Evaluator::new(model, Function::RegressorCop),
        rng: ChaCha8Rng::seed_from_u64(seed),
        counts: Counts {
            low: vec![0; model.tree.links.len()],
            ..Counts::default()
        },
        scene,
    };
    let dof = model.dof();
    let mut found = Vec::new();
    loop {
        let drawn = sampler.counts.drawn;
        if found.len() >= wanted * dof || drawn >= draws || found.is_empty() && drawn >= 10_000 {
            break;
        }
        // Worked on together.
        let n = 256.min(draws - drawn);
        for q in sampler.block(n) {
            // Counts stop with the last candidate taken.
            if found.len() == wanted * dof {
                break;
            }
            sampler.counts.drawn += 1;
            if sampler.stands(&q) {
                found.extend_from_slice(&q.q);
            }
        }
        progress(found.len() / dof)?;
    }
    sampler.counts.cop_std /= sampler.counts.drawn.max(1) as f64;
    Ok((found, sampler.counts))
}

/// Draws candidates until there are enough.
struct Sampler<'a> {
    scene: &'a Scene<'a>,
    cop: Evaluator,
    jacobian: Evaluator,
    regressor: Evaluator,
    rng: ChaCha8Rng,
    /// What became of the draws so far.
    counts: Counts,
}

impl Sampler<'_> {
    /// Counts a draw; true for a candidate.
    fn stands(&mut self, drawn: &Drawn) -> bool {
        self.counts.cop_std += drawn.std;
        if drawn.violation > 0.0 {
            if self.counts.balanced == 0 {
                self.counts.misses.push(drawn.violation);
            }
            return false;
        }
        self.counts.balanced += 1;
        let bodies = poses::bodies(&self.scene.model.chain.bodies, &drawn.q);
        match self.scene.clearance.lowest(&bodies) {
            Some((height, link)) if height < self.scene.clearance.height => {
                self.counts.low[link] += 1;
                return false;
            }
            _ => self.counts.clear += 1,
        }
        if self.scene.collisions.first(&bodies).is_some() {
            return false;
        }
        self.counts.collision_free += 1;
        true
    }

    /// `n` draws, moved towards balance.
    fn block(&mut self, n: usize) -> Vec<Drawn> {
        let mut draws: Vec<Drawn> = (0..n).map(|_| self.draw()).collect();
        for _ in 0..3 {
            let mut open: Vec<usize> = (0..n).filter(|&k| draws[k].violation > 0.0).collect();
            for _ in 0..10 {
                open = self.step(&mut draws, open);
            }
            if let Some(feet) = &self.scene.both_feet {
                for drawn in draws.iter_mut().filter(|drawn| drawn.violation > 0.0) {
                    drawn.on_floor = feet.put_down(&mut drawn.q, &self.scene.limits.ranges);
                }
            }
            self.judge(&mut draws);
            let centre = self.scene.region.centre();
            for drawn in draws.iter_mut().filter(|drawn| drawn.violation > 0.0) {
                drawn.target = (drawn.target + centre) / 2.0;
            }
        }
        draws
    }

    fn draw(&mut self) -> Drawn {
        let rng = &mut self.rng;
        let mut within = |(low, high): (f64, f64)| low + (high - low) * rng.random::<f64>();
        // At least a fifth of the limits from rest.
        let spread = within((1.0, 0.2));
        let ranges = self
            .scene
            .limits
            .ranges
            .iter()
            .zip(self.scene.limits.rest());
        let q = ranges
            .map(|(&range, rest)| (rest + spread * (within(range) - rest)).clamp(range.0, range.1))
            .collect();
        let region = self.scene.region;
        let bounds = region.bounds();
        let mut points = (0..100).map(|_| Vector2::from(bounds.map(&mut within)));
        let target = points.find(|at| region.violation(*at, &Matrix2::zeros(), 0.0) <= 0.0);
        Drawn {
            q,
            target: target.unwrap_or_else(|| region.centre()),
            // From one sole to the other.
            share: match self.scene.both_feet {
                Some(_) => within((0.0, 1.0)),
                None => 0.0,
            },
            on_floor: true,
            violation: f64::INFINITY,
            std: 0.0,
        }
    }

    /// One Newton step of those not yet at their targets.
    fn step(&self, draws: &mut [Drawn], open: Vec<usize>) -> Vec<usize> {
        let dof = self.scene.model.dof();
        let q = open.iter().flat_map(|&k| &draws[k].q);
        let q: Vec<f64> = q.copied().collect();
        let cop = self.cop.run(&q, open.len());
        let jacobian = self.jacobian.run(&q, open.len());
        let ranges = &self.scene.limits.ranges;
        let mut still = Vec::with_capacity(open.len());
        for (i, k) in open.into_iter().enumerate() {
            let drawn = &mut draws[k];
            let miss = drawn.target - Vector2::new(cop[2 * i], cop[2 * i + 1]);
            let j = &jacobian[3 * dof * i..][..2 * dof];
            if let Some(feet) = &self.scene.both_feet {
                let miss = miss + drawn.share * feet.at(&drawn.q);
                let off = feet.step(&mut drawn.q, miss, j, ranges);
                if miss.norm().max(off) > NEAR {
                    still.push(k);
                }
            } else if miss.norm() > NEAR {
                let (x, y) = j.split_at(dof);
                move_by(&mut drawn.q, miss.into(), [x, y], 1e-6, ranges);
                still.push(k);
            }
        }
        still
    }

    /// How far each CoP is out, given what CAD does not know.
    fn judge(&self, draws: &mut [Drawn]) {
        let q = draws.iter().flat_map(|drawn| &drawn.q);
        let q: Vec<f64> = q.copied().collect();
        let n = draws.len();
        let cop = self.cop.run(&q, n);
        let p = self.scene.uncertainty.nrows();
        // As columns, φᵀ of one posture after the other.
        let rows = DMatrix::from_vec(p, 2 * n, self.regressor.run(&q, n));
        let spread = self.scene.uncertainty.tr_mul(&rows);
        for (k, drawn) in draws.iter_mut().enumerate() {
            let (x, y) = (spread.column(2 * k), spread.column(2 * k + 1));
            let covariance = Matrix2::new(x.dot(&x), x.dot(&y), x.dot(&y), y.dot(&y));
            let cop = Vector2::new(cop[2 * k], cop[2 * k + 1]);
            let own = self.scene.region;
            let beyond = |region: &Region| region.violation(cop, &covariance, self.scene.sigmas);
            let violation = match &self.scene.both_feet {
                None => Some(beyond(own)),
                Some(_) if !drawn.on_floor => None,
                Some(feet) => feet.region(own, &drawn.q).as_ref().map(beyond),
            };
            // What is not a number does not balance.
            let finite = violation.filter(|x| *x <= f64::MAX);
            drawn.violation = finite.unwrap_or(f64::INFINITY);
            drawn.std = (covariance.trace() / 2.0).sqrt();
        }
    }
}

struct Drawn {
    q: Vec<f64>,
    /// Where its CoP is to be, m; on two feet beside the `share` of the way to the other sole.
    target: Vector2<f64>,
    share: f64,
    /// Whether the other sole lies on the floor, where it has to.
    on_floor: bool,
    /// How far it is from balance, m; balanced at zero and below.
    violation: f64,
    /// Standard deviation of its CoP, m.
    std: f64,
}

/// What became of the draws, and which demand to relax.
pub(super) fn shortage(scene: &Scene, request: &Request, counts: &Counts) -> Message {
    let tree = &scene.model.tree;
    let Counts {
        drawn,
        balanced,
        clear,
        collision_free,
        ..
    } = counts;
    let support = scene.model.support();
    let wide_enough = wide_enough(request, counts);
    let numbers = format!(
        "of {drawn} postures drawn, {balanced} balance on `{support}`, {clear} of them keep clear of \
         the ground, {collision_free} of these of themselves; {} are wanted",
        request.poses
    );
    let remedy = if *balanced < request.poses.max(drawn / 1000) {
        let miss = match wide_enough.map(|(miss, _)| miss) {
            Some(miss) => format!(", the best one misses by {:.1} mm", 1e3 * miss),
            None => String::new(),
        };
        let strict = format!(
            "the CoP must stay within {}, by {} standard deviations ({:.1} mm each on average){miss}",
            request.region.sentence(),
            request.sigmas,
            1e3 * counts.cop_std,
        );
        let enough = wide_enough.map_or_else(String::new, |(_, half)| {
            format!(" ({half} lets a tenth of them balance, where the foot is so large)")
        });
        message![
            strict,
            ": give a larger ",
            Setting::CopBox,
            enough,
            " or the ",
            Setting::Sole,
            ", a ",
            Setting::Prior,
            " that knows more, or ",
            Setting::Limits,
            " that suit the support",
            request.robot.feet_note()
        ]
    } else if *clear < request.poses.max(balanced / 1000) {
        let worst = (0..counts.low.len())
            .max_by_key(|&link| counts.low[link])
            .unwrap_or(0);
        let low = format!(
            "asked is {}; most often `{}` is too low: give a smaller ",
            scene.clearance.sentence(),
            tree.links[worst].name
        );
        message![
            low,
            Setting::Clearance,
            ", narrower ",
            Setting::Limits,
            ", or a support whose z = 0 is its sole"
        ]
    } else if *collision_free < *clear {
        message!["give narrower ", Setting::Limits, ", or ask for fewer"]
    } else {
        message![
            "ask for fewer ",
            Setting::Poses,
            ", or allow more with ",
            Setting::Candidates
        ]
    };
    remedy.after(&format!("{numbers}\n  "))
}

/// How far the best draw is out, and half the side of a square that lets a tenth of the draws
/// balance, whole cm in m; none where some balance, or where both feet carry.
fn wide_enough(request: &Request, counts: &Counts) -> Option<(f64, f64)> {
    let finite = counts
        .misses
        .iter()
        .copied()
        .filter(|miss| miss.is_finite());
    let mut misses: Vec<f64> = finite.collect();
    misses.sort_by(f64::total_cmp);
    let nearest = misses.first().filter(|_| counts.balanced == 0)?;
    let ends = request.region.bounds();
    let half = ends.iter().flat_map(|(low, high)| [low.abs(), high.abs()]);
    let half = half.fold(0.0, f64::max) + misses[misses.len() / 10];
    Some((*nearest, (1e2 * half).ceil() / 1e2))
}
