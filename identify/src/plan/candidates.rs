//! Postures that the robot can stand in, drawn by seed: what they have to respect, which is joint
//! limits, balance, the ground and the robot's own body, and how they come to it.
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
//!
//! # Clearance
//!
//! Nothing but the support body touches the ground:
//!
//! ```text
//! z of every shape and point of bodies i ≥ 1  ≥  clearance
//! ```
//!
//! A link with collision shapes is those; one without is its origin, its CoM
//! and the points of its joints. Bodies that are joined to the support body by
//! fixed joints are part of it and may touch, and so may the point of a joint
//! that the support body itself holds.
//!
//! # Both feet
//!
//! With both soles on one floor the legs are a closed chain:
//!
//! ```text
//! h(q) = (p_z, roll, pitch) of the other sole = 0        CoP(q) = u + λ p_xy(q)
//! q ← q + W Jᵀ (J W Jᵀ + ε)⁻¹ (0 − h, u + λ p_xy − CoP)        λ in (0, 1): from sole to sole
//! ```
//!
//! The CoP of both feet together may be wherever the hull of two soles is: that of the support,
//! and the same about the other sole.

use nalgebra::{DMatrix, Matrix2, Matrix3, Vector2, Vector3};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use sesc_model::effects::other_sole_by_joints;
use sesc_model::tape::{Tape, Values};
use sesc_model::{Function, Model};

use super::Request;
use super::collision::Collisions;
use super::limits::{Limits, move_by};
use super::shapes::{Geometry, Region, Solid};
use crate::evaluate::{Evaluator, FASTEST};
use crate::feet::{OtherFoot, ROWS};
use crate::poses::{self, Pose};
use crate::{Error, Message, Setting, message};

/// A robot on the ground, and what its postures have to respect.
pub struct Scene<'a> {
    /// The robot on its support.
    pub model: &'a Model,
    /// Joint limits.
    pub limits: &'a Limits,
    /// Where the CoP may be.
    pub region: &'a Region,
    /// Standard deviations of the CoP kept from the edge.
    pub sigmas: f64,
    /// S of the parameters' covariance S Sᵀ.
    pub uncertainty: DMatrix<f64>,
    /// What must stay clear of the ground.
    pub(super) clearance: Clearance,
    /// The other sole, where it has to lie on the floor, too.
    pub(super) both_feet: Option<BothFeet<'a>>,
    /// What must not collide.
    pub(super) collisions: Collisions,
}

impl<'a> Scene<'a> {
    /// A robot whose parameters are known, `clearance` (m) above the ground but for its support
    /// and the foot `other`.
    pub fn new(
        model: &'a Model,
        geometry: &Geometry,
        limits: &'a Limits,
        region: &'a Region,
        clearance: f64,
        other: Option<OtherFoot>,
    ) -> Scene<'a> {
        let rest = limits.rest();
        let both_feet = other.and_then(|other| BothFeet::new(model, other, &rest));
        let standing = both_feet.as_ref().map(|feet| feet.body);
        Scene {
            clearance: Clearance::new(model, geometry, clearance, standing),
            collisions: Collisions::new(model, geometry, &rest),
            uncertainty: DMatrix::zeros(model.base.params.len(), 0),
            sigmas: 0.0,
            both_feet,
            region,
            limits,
            model,
        }
    }
}

/// What must stay above the ground.
#[derive(Default)]
pub(super) struct Clearance {
    /// Least height, m.
    pub height: f64,
    parts: Vec<Part>,
    /// Links known by their shapes, and by points alone.
    pub by_shapes: usize,
    /// Links whose height follows from points.
    pub by_points: usize,
}

/// A solid of a link, or a point, which is a ball of no size.
struct Part {
    body: usize,
    link: usize,
    pose: Pose,
    solid: Solid,
}

impl Clearance {
    /// Look at the shapes of all links but those of the support body.
    ///
    /// Body `standing` stands on the floor, too.
    pub(super) fn new(
        model: &Model,
        geometry: &Geometry,
        height: f64,
        standing: Option<usize>,
    ) -> Clearance {
        let mut all = Clearance {
            height,
            ..Clearance::default()
        };
        let links = poses::links(model);
        for (link, about, body, place) in links.filter(|own| own.2 != 0 && Some(own.2) != standing)
        {
            let mut solids: Vec<(Pose, Solid)> = geometry.on(&about.name, place).collect();
            if solids.is_empty() {
                all.by_points += 1;
                let point = |origin| (Pose { origin, ..place }, Solid::Sphere { radius: 0.0 });
                let points = points(model, link, body, &place).into_iter();
                solids = points.map(point).collect();
            } else {
                all.by_shapes += 1;
            }
            all.parts
                .extend(solids.into_iter().map(|(pose, solid)| Part {
                    body,
                    link,
                    pose,
                    solid,
                }));
        }
        all
    }

    /// The lowest height, m, and the link that is there; `None` when nothing moves.
    pub(super) fn lowest(&self, bodies: &[Pose]) -> Option<(f64, usize)> {
        let height = |part: &Part| {
            let body = &bodies[part.body];
            let down = -part.pose.rotation.transpose() * body.rotation.row(2).transpose();
            body.point(&part.pose.origin).z - part.solid.reach(&down)
        };
        let heights = self.parts.iter().map(|part| (height(part), part.link));
        heights.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// In a few words.
    pub(super) fn sentence(&self) -> String {
        let mm = 1e3 * self.height;
        match (self.by_shapes, self.by_points) {
            (0, 0) => "nothing moves".to_string(),
            (0, points) => format!(
                "{mm:.1} mm for joints and CoMs of {points} links: they have no collision shapes, \
                 parts that reach beyond may touch"
            ),
            (shapes, 0) => format!("{mm:.1} mm for the collision shapes of {shapes} links"),
            (shapes, points) => format!(
                "{mm:.1} mm for the collision shapes of {shapes} links, and for joints and CoMs of \
                 {points} links without shapes"
            ),
        }
    }
}

/// Origin, CoM and joints of a link in its `body`, without what the support body holds.
fn points(model: &Model, link: usize, body: usize, place: &Pose) -> Vec<Vector3<f64>> {
    let about = &model.tree.links[link];
    let mut points = vec![place.origin];
    if about.mass > 0.0 {
        points.push(place.point(&about.com().into()));
    }
    for edge in &model.tree.edges {
        if edge.near == link {
            points.push(place.point(&edge.anchor().into()));
        }
        if edge.far == link {
            points.push(place.point(&edge.offset().into()));
        }
    }
    let held = model.chain.bodies[body].parent == Some(0);
    // The body's own origin is the point of the joint that carries it.
    points.retain(|point| !(held && point.norm() < 1e-9));
    points.dedup();
    points
}

/// Soles that lie this well are on the floor, m and rad.
const ON_FLOOR: f64 = 1e-9;
/// So little holds what no joint moves that soles come to lie so well.
const DAMPING: f64 = 1e-9;
/// How far the soles may be from each other, as parts of how far they are at rest.
const APART: (f64, f64) = (0.75, 2.0);
/// The other foot stays on its side: within this angle's cosine of where it is at rest.
const BESIDE: f64 = 0.7;

/// The other sole of a robot on its support.
pub(super) struct BothFeet<'m> {
    model: &'m Model,
    /// The sole.
    pub other: OtherFoot,
    /// Body of the chain that holds the other sole, which may touch the floor.
    pub body: usize,
    place: Pose,
    tape: Tape,
    rest: Vector2<f64>,
}

impl<'m> BothFeet<'m> {
    /// At rest in posture `rest`; none of a link that hangs on a joint nobody knows.
    pub(super) fn new(model: &'m Model, other: OtherFoot, rest: &[f64]) -> Option<BothFeet<'m>> {
        let (body, link) = poses::of_link(model, other.link)?;
        let place = link.then(&Pose {
            rotation: Matrix3::identity(),
            origin: Vector3::new(0.0, 0.0, -other.below_m),
        });
        let mut feet = BothFeet {
            model,
            tape: Tape::new(&other_sole_by_joints(model, other.place())),
            other,
            body,
            place,
            rest: Vector2::zeros(),
        };
        feet.rest = feet.at(rest);
        Some(feet)
    }

    /// The other sole's frame.
    fn sole(&self, q: &[f64]) -> Pose {
        let bodies = poses::bodies(&self.model.chain.bodies, q);
        bodies[self.body].then(&self.place)
    }

    /// Where its origin is on the floor, m.
    pub(super) fn at(&self, q: &[f64]) -> Vector2<f64> {
        self.sole(q).origin.xy()
    }

    /// Height, roll and pitch, and their slopes, a row each.
    fn lies(&self, q: &[f64]) -> ([f64; ROWS], [Vec<f64>; ROWS]) {
        let width = 1 + q.len();
        let mut out = vec![0.0; ROWS * width];
        self.tape
            .run(&[Values::PerPosture(q)], 1, &mut out, FASTEST);
        let row = |k: usize| &out[k * width..(k + 1) * width];
        let rows = [0, 1, 2].map(row);
        (rows.map(|row| row[0]), rows.map(|row| row[1..].to_vec()))
    }

    /// One step towards both soles on the floor and a CoP that is off by `miss` (m), whose
    /// slopes are `jacobian` (x row, y row); how far the soles are off it, m and rad.
    pub(super) fn step(
        &self,
        q: &mut [f64],
        miss: Vector2<f64>,
        jacobian: &[f64],
        ranges: &[(f64, f64)],
    ) -> f64 {
        let ([height, roll, pitch], [a, b, c]) = self.lies(q);
        let (x, y) = jacobian.split_at(q.len());
        let wanted = [-height, -roll, -pitch, miss.x, miss.y];
        move_by(q, wanted, [&a, &b, &c, x, y], DAMPING, ranges);
        Vector3::new(height, roll, pitch).amax()
    }

    /// Put the other sole on the floor, wherever the CoP goes: whether it is there.
    pub(super) fn put_down(&self, q: &mut [f64], ranges: &[(f64, f64)]) -> bool {
        for _ in 0..20 {
            let (lies, slopes) = self.lies(q);
            if Vector3::from(lies).amax() <= ON_FLOOR {
                break;
            }
            let slopes = slopes.each_ref().map(Vec::as_slice);
            move_by(q, lies.map(|x| -x), slopes, DAMPING, ranges);
        }
        Vector3::from(self.lies(q).0).amax() <= ON_FLOOR
    }

    /// Where the CoP may be: the hull of both soles' regions; none where the feet are too close,
    /// too far from each other, or crossed.
    pub(super) fn region(&self, own: &Region, q: &[f64]) -> Option<Region> {
        let sole = self.sole(q);
        let at = sole.origin.xy();
        let (far, still) = (at.norm(), self.rest.norm());
        let fits = (APART.0 * still..=APART.1 * still).contains(&far)
            && at.dot(&self.rest) >= BESIDE * far * still
            && sole.rotation[(2, 2)] > 0.0;
        let moved = own.corners.iter().map(|&[x, y]| {
            let corner = sole.point(&Vector3::new(x, y, 0.0));
            [corner.x, corner.y]
        });
        let both = own.corners.iter().copied().chain(moved).collect();
        fits.then(|| Region::hull(both, own.margin)).flatten()
    }
}

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
    let goes_on = |found: &[f64], drawn: usize| {
        found.len() < wanted * dof && drawn < draws && (!found.is_empty() || drawn < 10_000)
    };
    while goes_on(&found, sampler.counts.drawn) {
        // Worked on together.
        let n = 256.min(draws - sampler.counts.drawn);
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
        let clearance = &self.scene.clearance;
        let lowest = clearance.lowest(&bodies);
        if let Some((_, link)) = lowest.filter(|(height, _)| *height < clearance.height) {
            self.counts.low[link] += 1;
            return false;
        }
        self.counts.clear += 1;
        let is_free = self.scene.collisions.first(&bodies).is_none();
        self.counts.collision_free += usize::from(is_free);
        is_free
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
        let (limits, region) = (self.scene.limits, self.scene.region);
        let feet = self.scene.both_feet.as_ref();
        let mut draw = |(&range, rest): (&(f64, f64), f64)| {
            (rest + spread * (within(range) - rest)).clamp(range.0, range.1)
        };
        let q = limits.ranges.iter().zip(limits.rest()).map(&mut draw);
        let q = q.collect();
        let mut points = (0..100).map(|_| Vector2::from(region.bounds().map(&mut within)));
        let target = points.find(|at| region.violation(*at, &Matrix2::zeros(), 0.0) <= 0.0);
        Drawn {
            q,
            target: target.unwrap_or_else(|| region.centre()),
            // From one sole to the other.
            share: feet.map_or(0.0, |_| within((0.0, 1.0))),
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
    let (drawn, balanced, clear) = (counts.drawn, counts.balanced, counts.clear);
    let free = counts.collision_free;
    let support = scene.model.support();
    let numbers = format!(
        "of {drawn} postures drawn, {balanced} balance on `{support}`, {clear} of them keep clear of \
         the ground, {free} of these of themselves; {} are wanted",
        request.poses
    );
    let remedy = if balanced < request.poses.max(drawn / 1000) {
        let mut strict = format!(
            "the CoP must stay within {}, by {} standard deviations ({:.1} mm each on average)",
            request.region.sentence(),
            request.sigmas,
            1e3 * counts.cop_std,
        );
        let mut enough = String::new();
        if let Some((miss, half)) = wide_enough(request, counts) {
            strict += &format!(", the best one misses by {:.1} mm", 1e3 * miss);
            enough = format!(" ({half} lets a tenth of them balance, where the foot is so large)");
        }
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
    } else if clear < request.poses.max(balanced / 1000) {
        let worst = (0..counts.low.len()).max_by_key(|&link| counts.low[link]);
        let low = format!(
            "asked is {}; most often `{}` is too low: give a smaller ",
            scene.clearance.sentence(),
            scene.model.tree.links[worst.unwrap_or(0)].name
        );
        message![
            low,
            Setting::Clearance,
            ", narrower ",
            Setting::Limits,
            ", or a support whose z = 0 is its sole"
        ]
    } else if free < clear {
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
    let misses = counts.misses.iter().copied();
    let mut misses: Vec<f64> = misses.filter(|miss| miss.is_finite()).collect();
    misses.sort_by(f64::total_cmp);
    let nearest = misses.first().filter(|_| counts.balanced == 0)?;
    let ends = request.region.bounds();
    let half = ends.iter().flat_map(|(low, high)| [low.abs(), high.abs()]);
    let half = half.fold(0.0, f64::max) + misses[misses.len() / 10];
    Some((*nearest, (1e2 * half).ceil() / 1e2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;

    fn model(shape: &str) -> (Model, Geometry) {
        let urdf = format!(
            r#"<robot name="r"><link name="foot"/>
            <link name="leg"><inertial><origin xyz="0 0 0.3"/><mass value="1"/></inertial>{shape}</link>
            <link name="tip"><inertial><mass value="1"/></inertial></link>
            <joint name="ankle" type="continuous"><parent link="foot"/><child link="leg"/><axis xyz="0 1 0"/></joint>
            <joint name="top" type="continuous"><parent link="leg"/><child link="tip"/><origin xyz="0 0 1"/>
              <axis xyz="0 1 0"/></joint></robot>"#
        );
        let robot = Robot::parse(&urdf, "r.urdf").unwrap();
        let model = robot
            .model("foot", sesc_model::Snapping::default(), None)
            .unwrap();
        (model, Geometry::read(&robot.description, None))
    }

    #[test]
    fn points_and_shapes_are_measured_from_the_sole() {
        let (plain, geometry) = model("");
        let clearance = Clearance::new(&plain, &geometry, 0.005, None);
        assert_eq!((clearance.by_shapes, clearance.by_points), (0, 2));
        let bodies = poses::bodies(&plain.chain.bodies, &[0.0, 0.0]);
        // The ankle lies on the ground and is the foot's; the CoM of the leg is next.
        let (z, link) = clearance.lowest(&bodies).unwrap();
        assert!((z - 0.3).abs() < 1e-15 && plain.tree.links[link].name == "leg");
        let bodies = poses::bodies(&plain.chain.bodies, &[2.0, 0.0]);
        let (z, _) = clearance.lowest(&bodies).unwrap();
        assert!((z - 2f64.cos()).abs() < 1e-15);

        let cylinder = r#"<collision><origin xyz="0 0 0.5"/><geometry>
            <cylinder radius="0.1" length="0.8"/></geometry></collision>"#;
        let (solid, geometry) = model(cylinder);
        let clearance = Clearance::new(&solid, &geometry, 0.005, None);
        assert_eq!((clearance.by_shapes, clearance.by_points), (1, 1));
        let bodies = poses::bodies(&solid.chain.bodies, &[0.0, 0.0]);
        assert!((clearance.lowest(&bodies).unwrap().0 - 0.1).abs() < 1e-15);
        let q = 1.0f64;
        let bodies = poses::bodies(&solid.chain.bodies, &[q, 0.0]);
        let expected = 0.5 * q.cos() - 0.4 * q.cos() - 0.1 * q.sin();
        assert!((clearance.lowest(&bodies).unwrap().0 - expected).abs() < 1e-15);
    }
}
