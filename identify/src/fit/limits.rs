//! Where masses can be at all.
//!
//! ```text
//! m_k lo ≤ m_k c_k ≤ m_k hi        linear in the mass m_k and the first moment m_k c_k
//! ```

use sesc_model::urdf::{self, Extent};

use crate::robot::Robot;

/// Least room of a generous box on each side, m.
const ROOM: f64 = 0.1;

/// Bounds of physical masses: none far below CAD's, and each CoM inside a box.
///
/// Where the URDF gives no shape of known size, the box is generous: around the link's
/// frame, its joints and CAD's CoM, and on each side as much again (`ROOM` at least).
/// Without it a mass of nothing could sit in the next town.
#[derive(Debug, Clone, Default)]
pub struct Limits {
    /// Extent of each link in document order, and what it is around, in words.
    boxes: Vec<(Extent, &'static str)>,
}

impl Limits {
    /// Those of the collision geometry of `robot`, generous ones elsewhere.
    ///
    /// # Errors
    /// When its text cannot be read.
    pub fn of(robot: &Robot) -> Result<Limits, crate::Error> {
        let extents = urdf::extents(&robot.description);
        let extents = extents.map_err(sesc_model::Error::from)?;
        let mut limits = Limits::generous(robot);
        for (k, extent) in extents.into_iter().enumerate() {
            if let (Some(extent), Some(own)) = (extent, limits.boxes.get_mut(k)) {
                // Shapes are simplified: a link's box may leave out CAD's own CoM.
                let com = robot.description.links[k].inertial.origin.xyz;
                *own = (extent.holding(com), "in the collision geometry");
            }
        }
        Ok(limits)
    }

    /// Generous ones for every link.
    pub fn generous(robot: &Robot) -> Limits {
        let description = &robot.description;
        let boxes = description.links.iter().map(|link| {
            let frame = Extent {
                low: [0.0; 3],
                high: [0.0; 3],
            };
            let mut extent = frame.holding(link.inertial.origin.xyz);
            for joint in description.joints.iter().filter(|j| j.parent == link.name) {
                extent = extent.holding(joint.origin.xyz);
            }
            let sides = [0, 1, 2].map(|axis| extent.high[axis] - extent.low[axis]);
            let room = sides.into_iter().fold(ROOM, f64::max);
            let wide = Extent {
                low: extent.low.map(|x| x - room),
                high: extent.high.map(|x| x + room),
            };
            (wide, "near the joints of the link")
        });
        Limits {
            boxes: boxes.collect(),
        }
    }

    /// Where the CoM of link `k` can be, and what that is around, in words.
    pub fn extent(&self, k: usize) -> Option<&(Extent, &'static str)> {
        self.boxes.get(k)
    }
}
