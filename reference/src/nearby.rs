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
    /// What each link and all that hangs on it weigh.
    carried: Vec<Weight>,
    root: usize,
    /// The joint that carries each link; none carries the root.
    carrier: Vec<Option<usize>>,
}

/// Some links, at rest in the frame of the root.
#[derive(Clone, Copy)]
struct Weight {
    mass_kg: f64,
    /// `Σ m_l P_l c_l`, kg m.
    moment: Vector3<f64>,
}

impl Weight {
    /// Its moment where `by` has moved the links.
    fn moved(&self, by: &Pose) -> Vector3<f64> {
        by.rotation * self.moment + by.translation.vector * self.mass_kg
    }
}

impl<'r> Nearby<'r> {
    pub fn new(reference: &'r Reference, q: &[f64]) -> Nearby<'r> {
        let robot = &reference.robot;
        let poses = robot.poses_in_root(q);
        let links = robot.links().iter().zip(&poses);
        let mut carried: Vec<Weight> = links
            .map(|(link, pose)| Weight {
                mass_kg: link.mass_kg,
                moment: link.mass_kg * (pose * link.com_m).coords,
            })
            .collect();
        let mut carrier = vec![None; poses.len()];
        for &j in robot.joints_from_root().iter().rev() {
            let joint = &robot.joints()[j];
            let Weight { mass_kg, moment } = carried[joint.child];
            carried[joint.parent].mass_kg += mass_kg;
            carried[joint.parent].moment += moment;
            carrier[joint.child] = Some(j);
        }
        Nearby {
            reference,
            q: q.to_vec(),
            poses,
            carried,
            // A tree has one link that nothing carries.
            root: carrier.iter().position(Option::is_none).unwrap_or(0),
            carrier,
        }
    }

    /// The CoM in the support frame with entry `dof` of the posture at each of `positions`, m.
    pub fn com<const N: usize>(&mut self, dof: usize, positions: [f64; N]) -> [Vector3<f64>; N] {
        let robot = &self.reference.robot;
        let coordinates = robot.coordinates();
        let joints = robot.joints_from_root().iter().copied();
        // Each follows those between it and the root.
        let own: Vec<usize> = joints
            .filter(|&j| coordinates[j].dof == Some(dof))
            .collect();
        let nearest = |mut link: usize| loop {
            let j = self.carrier[link]?;
            if let Some(place) = own.iter().position(|&own| own == j) {
                return Some(place);
            }
            link = robot.joints()[j].parent;
        };
        let before: Vec<Option<usize>> = own
            .iter()
            .map(|&j| nearest(robot.joints()[j].parent))
            .collect();
        let below_support = nearest(self.reference.support);
        let rest = self.q[dof];
        let coms = positions.map(|position| {
            self.q[dof] = position;
            let mut moment = self.carried[self.root].moment;
            let mut moved: Vec<Pose> = Vec::with_capacity(own.len());
            let at =
                |moved: &[Pose], place: Option<usize>| place.map_or(Pose::identity(), |i| moved[i]);
            for (&j, &before) in own.iter().zip(&before) {
                let joint = &robot.joints()[j];
                let (parent, child) = (&self.poses[joint.parent], &self.poses[joint.child]);
                let before = at(&moved, before);
                let by = before * parent * robot.local(j, &self.q) * child.inverse();
                let carried = &self.carried[joint.child];
                moment += carried.moved(&by) - carried.moved(&before);
                moved.push(by);
            }
            let in_root = Point3::from(moment / self.reference.total_mass());
            let support = at(&moved, below_support) * self.poses[self.reference.support];
            support.inverse_transform_point(&in_root).coords
        });
        self.q[dof] = rest;
        coms
    }
}
