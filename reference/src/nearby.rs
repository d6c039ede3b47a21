//! Poses of all links in postures that differ from one by a single entry.
//!
//! ```text
//! P_child = P_parent L_j        L_j = origin_j · motion_j(q_j), of which a step changes its own
//! ```

use crate::joint::Pose;
use crate::robot::Robot;

/// A posture, and room for the ones beside it.
pub(crate) struct Nearby<'r> {
    robot: &'r Robot,
    q: &'r [f64],
    locals: Vec<Pose>,
    here: Vec<Pose>,
    poses: Vec<Pose>,
}

impl<'r> Nearby<'r> {
    pub fn new(robot: &'r Robot, q: &'r [f64]) -> Nearby<'r> {
        let here = robot.poses_in_root(q);
        Nearby {
            robot,
            q,
            locals: (0..robot.joints().len())
                .map(|j| robot.local(j, q))
                .collect(),
            poses: here.clone(),
            here,
        }
    }

    /// Poses in the frame of the root, with entry `dof` of the posture at `position`.
    pub fn with(&mut self, dof: usize, position: f64) -> &[Pose] {
        self.poses.copy_from_slice(&self.here);
        let mut q = None;
        let mut moved = vec![false; self.poses.len()];
        for &j in self.robot.order() {
            let joint = &self.robot.joints()[j];
            let own = self.robot.coordinates()[j].dof == Some(dof);
            if !own && !moved[joint.parent] {
                continue;
            }
            let local = match own {
                true => {
                    let q = q.get_or_insert_with(|| {
                        let mut q = self.q.to_vec();
                        q[dof] = position;
                        q
                    });
                    self.robot.local(j, q)
                }
                false => self.locals[j],
            };
            self.poses[joint.child] = self.poses[joint.parent] * local;
            moved[joint.child] = true;
        }
        &self.poses
    }
}
