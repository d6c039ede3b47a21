//! Where the sole is, by the collision shapes of what stands on the ground.
//!
//! ```text
//! box = hull of the shapes of all links fixed to the support, in its frame, seen from above
//! ```

use sesc_model::Model;
use sesc_model::urdf::extents;

use crate::robot::Robot;

/// Least and greatest corner of the sole, m; none where the URDF has no shapes there but meshes.
pub(super) fn corners(robot: &Robot, model: &Model) -> Option<[[f64; 2]; 2]> {
    let description = &robot.description;
    let boxes = extents(description).ok()?;
    let mut corners: Option<[[f64; 2]; 2]> = None;
    for (name, extent) in description.link_names().zip(boxes) {
        let link = model.tree.links.iter().position(|link| link.name == name);
        let place = link.and_then(|link| model.chain.places[link]);
        let (Some(extent), Some(place)) = (extent, place) else {
            continue;
        };
        if place.body != 0 {
            continue;
        }
        let (rows, origin) = (place.orientation(), place.origin());
        for corner in 0..8 {
            let local = [0, 1, 2].map(|axis| match corner >> axis & 1 {
                0 => extent.low[axis],
                _ => extent.high[axis],
            });
            let at = [0, 1].map(|axis| {
                let turned = rows[axis].iter().zip(local).map(|(a, b)| a * b);
                origin[axis] + turned.sum::<f64>()
            });
            corners = Some(match corners {
                None => [at, at],
                Some([low, high]) => [
                    [0, 1].map(|axis| low[axis].min(at[axis])),
                    [0, 1].map(|axis| high[axis].max(at[axis])),
                ],
            });
        }
    }
    corners
}
