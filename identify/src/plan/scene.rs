//! What a posture has to respect: joint limits, balance, the ground, the robot's own body.
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

use nalgebra::{DMatrix, Matrix3, Vector2, Vector3};
use sesc_model::Model;
use sesc_model::effects::other_sole_by_joints;
use sesc_model::tape::{Tape, Values};

use super::collision::Collisions;
use super::limits::{Limits, move_by};
use super::region::Region;
use super::shapes::{Geometry, Solid};
use crate::evaluate::FASTEST;
use crate::feet::{OtherFoot, ROWS};
use crate::poses::{self, Pose};

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
    pub clearance: Clearance,
    /// The other sole, where it has to lie on the floor, too.
    pub both_feet: Option<BothFeet<'a>>,
    /// What must not collide.
    pub collisions: Collisions,
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
pub struct Clearance {
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
    pub fn new(
        model: &Model,
        geometry: &Geometry,
        height: f64,
        standing: Option<usize>,
    ) -> Clearance {
        let mut all = Clearance {
            height,
            parts: Vec::new(),
            by_shapes: 0,
            by_points: 0,
        };
        for (link, about, body, place) in poses::links(model) {
            if body == 0 || Some(body) == standing {
                continue;
            }
            let mut solids: Vec<(Pose, Solid)> = geometry.on(&about.name, place).collect();
            all.by_shapes += usize::from(!solids.is_empty());
            all.by_points += usize::from(solids.is_empty());
            if solids.is_empty() {
                let at = |origin| Pose { origin, ..place };
                let points = points(model, link, &place).into_iter();
                solids.extend(points.map(|point| (at(point), Solid::Sphere { radius: 0.0 })));
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
    pub fn lowest(&self, bodies: &[Pose]) -> Option<(f64, usize)> {
        let height = |part: &Part| {
            let body = &bodies[part.body];
            let down = -part.pose.rotation.transpose() * body.rotation.row(2).transpose();
            body.point(&part.pose.origin).z - part.solid.reach(&down)
        };
        let heights = self.parts.iter().map(|part| (height(part), part.link));
        heights.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// In a few words.
    pub fn sentence(&self) -> String {
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

/// Origin, CoM and joints of a link in its body, without what the support body holds.
fn points(model: &Model, link: usize, place: &Pose) -> Vec<Vector3<f64>> {
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
    let body = poses::of_link(model, link).map_or(0, |(body, _)| body);
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
pub struct BothFeet<'m> {
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
    pub fn new(model: &'m Model, other: OtherFoot, rest: &[f64]) -> Option<BothFeet<'m>> {
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
        feet.rest = feet.sole(rest).origin.xy();
        Some(feet)
    }

    /// The other sole's frame.
    fn sole(&self, q: &[f64]) -> Pose {
        let bodies = poses::bodies(&self.model.chain.bodies, q);
        bodies[self.body].then(&self.place)
    }

    /// Where its origin is on the floor, m.
    pub fn at(&self, q: &[f64]) -> Vector2<f64> {
        self.sole(q).origin.xy()
    }

    /// Height, roll and pitch, and their slopes, a row each.
    fn lies(&self, q: &[f64]) -> ([f64; ROWS], [Vec<f64>; ROWS]) {
        let width = 1 + q.len();
        let mut out = vec![0.0; ROWS * width];
        self.tape
            .run(&[Values::PerPosture(q)], 1, &mut out, FASTEST);
        let row = |k: usize| &out[k * width..(k + 1) * width];
        (
            [0, 1, 2].map(|k| row(k)[0]),
            [0, 1, 2].map(|k| row(k)[1..].to_vec()),
        )
    }

    /// One step towards both soles on the floor and a CoP that is off by `miss` (m), whose
    /// slopes are `jacobian` (x row, y row); how far the soles are off it, m and rad.
    pub fn step(
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
    pub fn put_down(&self, q: &mut [f64], ranges: &[(f64, f64)]) -> bool {
        for _ in 0..20 {
            let (lies, slopes) = self.lies(q);
            if Vector3::from(lies).amax() <= ON_FLOOR {
                return true;
            }
            let slopes = slopes.each_ref().map(Vec::as_slice);
            move_by(q, lies.map(|x| -x), slopes, DAMPING, ranges);
        }
        Vector3::from(self.lies(q).0).amax() <= ON_FLOOR
    }

    /// Where the CoP may be: the hull of both soles' regions; none where the feet are too close,
    /// too far from each other, or crossed.
    pub fn region(&self, own: &Region, q: &[f64]) -> Option<Region> {
        let sole = self.sole(q);
        let at = sole.origin.xy();
        let (far, still) = (at.norm(), self.rest.norm());
        let fits = (APART.0 * still..=APART.1 * still).contains(&far)
            && at.dot(&self.rest) >= BESIDE * far * still
            && sole.rotation[(2, 2)] > 0.0;
        if !fits {
            return None;
        }
        let moved = own.corners.iter().map(|&[x, y]| {
            let corner = sole.point(&Vector3::new(x, y, 0.0));
            [corner.x, corner.y]
        });
        Region::hull(
            own.corners.iter().copied().chain(moved).collect(),
            own.margin,
        )
    }
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
