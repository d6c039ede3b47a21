//! A robot as figures draw it: where bodies are in a posture, and how thick links look.
//!
//! ```text
//! T_i = T_parent(i) · (anchor_i + axis θ,  R_i Rot(axis, θ))        θ = factor q + offset
//! link = all points within a radius of a line            (a capsule)
//! CoM  = Σ m_i T_i c_i / Σ m_i
//! ```
//!
//! Everything comes from the URDF: capsules from collision geometry where a link has some,
//! else from its inertia, and bones from joint to joint.
//!
//! ```text
//! half edges of the box of the same inertia    h_i² = 3/(2 m) (I_j + I_k − I_i)
//! capsule of half edges h_1 ≥ h_2 ≥ h_3        radius √(h_2 h_3),  along h_1
//! ```

use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use sesc_model::Model;
use sesc_model::chain::Body;
use sesc_model::tree::Dof;
use sesc_model::urdf::{Description, Inertial};

use crate::plan::shapes::{Geometry, Solid, at, outline};
use crate::poses::{self, Pose};

/// What a capsule stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Part {
    /// The line from a joint to the next one.
    Bone,
    /// The material of a link.
    Link,
}

/// All points within a radius of a line.
#[derive(Debug, Clone, PartialEq)]
pub struct Capsule {
    /// Link that it belongs to; of a bone the one that the joint moves.
    pub link: String,
    /// Index of its body.
    pub body: usize,
    /// What it stands for.
    pub part: Part,
    /// Ends of the line in the body, m.
    pub ends: [[f64; 3]; 2],
    /// m
    pub radius: f64,
}

/// A robot on its support, as it is drawn.
#[derive(Debug, Clone)]
pub struct Skeleton {
    /// Name of the robot.
    pub robot: String,
    /// Hash of its URDF, in hexadecimal.
    pub hash: String,
    /// Link on the ground.
    pub support: String,
    /// Independent joints, in the order of postures.
    pub dofs: Vec<Dof>,
    /// Bodies; parents come first, the first one is on the ground.
    pub bodies: Vec<Body>,
    /// CoM of each in the body, m.
    pub coms: Vec<[f64; 3]>,
    /// What is drawn of them.
    pub capsules: Vec<Capsule>,
    /// Places of links in their bodies, in document order; those beyond a cut are left out.
    links: Vec<(String, usize, Pose)>,
    /// Outline of the sole in the support frame, m; empty where the URDF has no shape of it.
    pub sole: Vec<[f64; 2]>,
}

impl Skeleton {
    /// The robot of `model`; `folder` is where its meshes may be.
    ///
    /// ```
    /// use sesc_identify::robot::Robot;
    /// use sesc_identify::skeleton::Skeleton;
    /// use sesc_model::Snapping;
    /// # let urdf = "<robot name='rod'><link name='foot'/>\
    /// #     <joint name='hip' type='revolute'><parent link='foot'/><child link='leg'/>\
    /// #     <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
    /// #     <link name='leg'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial></link>\
    /// #     </robot>";
    /// let robot = Robot::parse(urdf, "rod.urdf")?;
    /// let model = robot.model("foot", Snapping::default(), None)?;
    /// let skeleton = Skeleton::of(&model, &robot.description, None);
    /// assert_eq!(skeleton.bodies.len(), 2, "foot and leg");
    /// # Ok::<(), sesc_identify::Error>(())
    /// ```
    pub fn of(model: &Model, description: &Description, folder: Option<&Path>) -> Skeleton {
        let geometry = Geometry::read(description, folder);
        let tree = &model.tree;
        Skeleton {
            robot: tree.robot.clone(),
            hash: tree.hash.clone(),
            support: tree.links[tree.support].name.clone(),
            dofs: tree.dofs.clone(),
            capsules: capsules(model, description, &geometry),
            sole: outline(model, &geometry),
            links: poses::links(model)
                .map(|(_, link, body, place)| (link.name.clone(), body, place))
                .collect(),
            bodies: model.chain.bodies.clone(),
            coms: coms(model),
        }
    }

    /// The body that a link belongs to.
    pub fn body_of(&self, link: &str) -> Option<usize> {
        self.in_body(link, [0.0; 3]).map(|(body, _)| body)
    }

    /// A point of a link (m) in its body.
    pub fn in_body(&self, link: &str, point: [f64; 3]) -> Option<(usize, [f64; 3])> {
        let (_, body, place) = self.links.iter().find(|(name, ..)| name == link)?;
        Some((*body, place.point(&point.into()).into()))
    }

    /// The body that a joint carries.
    pub fn carried_by(&self, joint: &str) -> Option<usize> {
        let carried = |body: &Body| body.joint.as_deref() == Some(joint);
        self.bodies.iter().position(carried)
    }

    /// The robot in posture `q`, rad or m; a joint that `q` is too short for stands at zero.
    pub fn place(&self, q: &[f64]) -> Placed<'_> {
        let poses = poses::bodies(&self.bodies, q);
        Placed {
            skeleton: self,
            poses,
        }
    }
}

/// A robot in a posture.
pub struct Placed<'s> {
    skeleton: &'s Skeleton,
    poses: Vec<Pose>,
}

impl Placed<'_> {
    /// A point of a body in the support frame, m.
    pub fn point(&self, body: usize, point: [f64; 3]) -> [f64; 3] {
        self.poses[body].point(&point.into()).into()
    }

    /// The joint that carries a body, in the support frame, m.
    pub fn joint(&self, body: usize) -> [f64; 3] {
        self.poses[body].origin.into()
    }

    /// Ends of a capsule in the support frame, m.
    pub fn ends(&self, capsule: &Capsule) -> [[f64; 3]; 2] {
        capsule.ends.map(|end| self.point(capsule.body, end))
    }

    /// Centre of mass of the robot in the support frame, m.
    pub fn com(&self) -> [f64; 3] {
        let bodies = self.skeleton.bodies.iter().zip(&self.skeleton.coms);
        let points = bodies.zip(&self.poses);
        mean(points.map(|((body, com), pose)| (body.mass, pose.point(&(*com).into()))))
    }
}

/// The mean of points, each with its weight; zero where nothing has any.
fn mean(points: impl Iterator<Item = (f64, Vector3<f64>)>) -> [f64; 3] {
    let none = (0.0, Vector3::zeros());
    let (mass, sum) = points.fold(none, |all, (m, point)| (all.0 + m, all.1 + point * m));
    if mass > 0.0 {
        (sum / mass).into()
    } else {
        [0.0; 3]
    }
}

/// CoM of each body, m.
fn coms(model: &Model) -> Vec<[f64; 3]> {
    let mut links = vec![Vec::new(); model.chain.bodies.len()];
    for (_, link, body, place) in poses::links(model) {
        links[body].push((link.mass, place.point(&link.com().into())));
    }
    links.into_iter().map(|own| mean(own.into_iter())).collect()
}

/// All capsules of a robot.
fn capsules(model: &Model, description: &Description, geometry: &Geometry) -> Vec<Capsule> {
    let bodies = &model.chain.bodies;
    let size = size(bodies);
    let mut capsules = Vec::new();
    for body in bodies {
        let length = Vector3::from(body.anchor()).norm();
        let parent = body.parent.filter(|_| length > 0.01 * size);
        if let Some(parent) = parent {
            capsules.push(Capsule {
                link: body.name.clone(),
                body: parent,
                part: Part::Bone,
                ends: [[0.0; 3], body.anchor()],
                radius: 0.013 * size,
            });
        }
    }
    for (k, link, body, place) in poses::links(model) {
        let solids = geometry.on(&link.name, place);
        let mut found: Vec<_> = solids
            .map(|(pose, solid)| of_solid(&pose, &solid))
            .collect();
        let inertial = &description.links[k].inertial;
        if found.is_empty() && inertial.mass_kg > 0.0 {
            found.push(of_inertia(&place, inertial, 0.2 * size));
        }
        for (ends, radius) in found {
            capsules.push(Capsule {
                link: link.name.clone(),
                body,
                part: Part::Link,
                radius: match body {
                    0 => above_ground(ends, radius),
                    _ => radius,
                },
                ends: ends.map(Into::into),
            });
        }
    }
    capsules
}

/// A thinner radius for what stands, where a box of the same inertia would reach into the
/// ground.
fn above_ground(ends: [Vector3<f64>; 2], radius: f64) -> f64 {
    let lowest = ends[0].z.min(ends[1].z);
    radius.min(lowest.max(0.4 * radius))
}

/// How far joints are apart at most, along the chain, m.
fn size(bodies: &[Body]) -> f64 {
    let mut reach: Vec<f64> = Vec::new();
    for body in bodies {
        let before = body.parent.map_or(0.0, |parent| reach[parent]);
        reach.push(before + Vector3::from(body.anchor()).norm());
    }
    let longest = reach.iter().copied().fold(0.0, f64::max);
    if longest > 0.0 { longest } else { 0.1 }
}

fn of_solid(pose: &Pose, solid: &Solid) -> ([Vector3<f64>; 2], f64) {
    match *solid {
        Solid::Box(half) => along(pose, half),
        Solid::Cylinder { radius, half } => {
            let line = (half - radius).max(0.0);
            (line_along(pose, Vector3::z() * line), radius)
        }
        Solid::Capsule { radius, half } => (line_along(pose, Vector3::z() * half), radius),
        Solid::Sphere { radius } => ([pose.origin; 2], radius),
    }
}

/// A capsule as long as a box, and as thick on average.
fn along(pose: &Pose, half: Vector3<f64>) -> ([Vector3<f64>; 2], f64) {
    let longest = half.imax();
    let others = half.product() / half[longest].max(f64::MIN_POSITIVE);
    let radius = others.max(0.0).sqrt();
    let mut line = Vector3::zeros();
    line[longest] = (half[longest] - radius).max(0.0);
    (line_along(pose, line), radius)
}

fn line_along(pose: &Pose, half: Vector3<f64>) -> [Vector3<f64>; 2] {
    [pose.point(&-half), pose.point(&half)]
}

fn of_inertia(place: &Pose, inertial: &Inertial, most: f64) -> ([Vector3<f64>; 2], f64) {
    let mass = inertial.mass_kg;
    let frame = place.then(&at(&inertial.origin));
    let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
    let eigen = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigen();
    let total = eigen.eigenvalues.sum();
    let half = eigen
        .eigenvalues
        .map(|own| (1.5 / mass * (total - 2.0 * own)).max(0.0).sqrt().min(most));
    let pose = Pose {
        rotation: frame.rotation * eigen.eigenvectors,
        ..frame
    };
    let (ends, radius) = along(&pose, half);
    if radius > 0.0 && radius.is_finite() {
        return (ends, radius);
    }
    // No inertia, or one of a rod or a point: a ball of the same mass, of 1500 kg/m³.
    let ball = (0.75 * mass / (std::f64::consts::PI * 1500.0)).cbrt();
    ([pose.origin; 2], ball.min(most))
}

#[cfg(test)]
mod tests;
