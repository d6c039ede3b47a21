//! The CoM in postures that differ from one by a single entry.
//!
//! A joint moves all that hangs on it as one body, so that each of these postures costs no more
//! than the joints that its entry moves:
//!
//! ```text
//! Σ m_l P_l' c_l = Σ m_l P_l c_l + Σ_j (D_j − D_i) Σ_(l beyond j) m_l P_l c_l
//! D_j            = D_i P_parent L_j(q') P_child⁻¹
//! ```
//!
//! `j` are the joints that the entry moves, `i` the nearest of them between `j` and the root
//! (`D` is 1 where there is none), and `L_j` is the pose of the link beyond `j` in the frame of
//! the one before it.

use nalgebra::{Point3, Vector3};

use crate::com::Reference;
use crate::joint::Pose;

/// A posture from which single entries are moved.
pub(crate) struct Nearby<'r> {
    reference: &'r Reference,
    q: Vec<f64>,
    /// Poses of the links in the frame of the root.
    poses: Vec<Pose>,
    /// Each link and all that hangs on it.
    carried: Vec<Carried>,
    root: usize,
    /// The joint that carries each link; none carries the root.
    carrier: Vec<Option<usize>>,
}

/// Some links, at rest in the frame of the root.
#[derive(Clone, Copy)]
struct Carried {
    mass_kg: f64,
    /// `Σ m_l P_l c_l`
    first_moment_kg_m: Vector3<f64>,
}

impl Carried {
    /// Their first moment where `by` has moved them, kg m.
    fn moved(&self, by: &Pose) -> Vector3<f64> {
        by.rotation * self.first_moment_kg_m + by.translation.vector * self.mass_kg
    }
}

impl<'r> Nearby<'r> {
    pub(crate) fn new(reference: &'r Reference, q: &[f64]) -> Nearby<'r> {
        let robot = &reference.robot;
        let poses = robot.poses_in_root(q);
        let links = robot.links().iter().zip(&poses);
        let mut carried: Vec<Carried> = links
            .map(|(link, pose)| Carried {
                mass_kg: link.mass_kg,
                first_moment_kg_m: link.mass_kg * (pose * link.com_m).coords,
            })
            .collect();
        let mut carrier = vec![None; poses.len()];
        for &j in robot.joints_from_root().iter().rev() {
            let joint = &robot.joints()[j];
            let child = carried[joint.child];
            carried[joint.parent].mass_kg += child.mass_kg;
            carried[joint.parent].first_moment_kg_m += child.first_moment_kg_m;
            carrier[joint.child] = Some(j);
        }
        let root = carrier.iter().position(Option::is_none);
        Nearby {
            reference,
            q: q.to_vec(),
            poses,
            carried,
            root: root.expect("a tree has one link that nothing carries"),
            carrier,
        }
    }

    /// The CoM in the support frame with entry `dof` of the posture at each of `positions`, m.
    pub(crate) fn com<const N: usize>(
        &mut self,
        dof: usize,
        positions: [f64; N],
    ) -> [Vector3<f64>; N] {
        let robot = &self.reference.robot;
        let coordinates = robot.coordinates();
        let joints = robot.joints_from_root().iter().copied();
        // Each follows those between it and the root.
        let own: Vec<usize> = joints
            .filter(|&j| coordinates[j].dof == Some(dof))
            .collect();
        // The nearest of them between a link and the root, by its place among them.
        let nearest = |mut link: usize| loop {
            let j = self.carrier[link]?;
            if let Some(place) = own.iter().position(|&own| own == j) {
                return Some(place);
            }
            link = robot.joints()[j].parent;
        };
        let above: Vec<Option<usize>> = own
            .iter()
            .map(|&j| nearest(robot.joints()[j].parent))
            .collect();
        let above_support = nearest(self.reference.support);
        let rest = self.q[dof];
        let coms = positions.map(|position| {
            self.q[dof] = position;
            let mut moment = self.carried[self.root].first_moment_kg_m;
            // The motions D_j.
            let mut motions: Vec<Pose> = Vec::with_capacity(own.len());
            for (&j, above) in own.iter().zip(&above) {
                let joint = &robot.joints()[j];
                let (parent, child) = (&self.poses[joint.parent], &self.poses[joint.child]);
                let of_parent = above.map_or(Pose::identity(), |place| motions[place]);
                let motion = of_parent * parent * robot.local(j, &self.q) * child.inverse();
                let carried = &self.carried[joint.child];
                moment += carried.moved(&motion) - carried.moved(&of_parent);
                motions.push(motion);
            }
            let in_root = Point3::from(moment / self.reference.total_mass());
            let of_support = above_support.map_or(Pose::identity(), |place| motions[place]);
            let support = of_support * self.poses[self.reference.support];
            support.inverse_transform_point(&in_root).coords
        });
        self.q[dof] = rest;
        coms
    }
}
