//! Where one sole is, seen from another: for recordings that have the contact of each by itself,
//! and for readings that are put together from both where a joint is off.
//!
//! ```text
//! y = (1 − s) p₁ + s T(q) p₂                         as the encoders q have the other sole
//!   = CoP(φ) − s Σ_j ∂(T p₂)/∂q_j (φ_j − q_j)        where its joints are at φ
//! ```

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Vector3;
use sesc_model::effects::PostureContext;
use sesc_model::{Model, Snapping};

use super::other::OtherFoot;
use crate::logs::{Frame, Soles};
use crate::observations::postures::Postures;
use crate::poses;
use crate::robot::Robot;

/// The soles of a robot, by its URDF.
pub(crate) struct Places {
    robot: Arc<Robot>,
    snapping: Snapping,
    /// The robot on each link that was asked about; none on what is no support.
    on: Mutex<HashMap<String, Option<Arc<Model>>>>,
}

impl Places {
    /// The soles of a robot, as readers of logs take them.
    pub fn of(robot: &Arc<Robot>, snapping: Snapping) -> Arc<dyn Soles> {
        Arc::new(Places {
            robot: Arc::clone(robot),
            snapping,
            on: Mutex::default(),
        })
    }

    fn model(&self, from: &str) -> Option<Arc<Model>> {
        let mut on = self.on.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = on.get(from) {
            return known.clone();
        }
        let model = self.robot.model(from, self.snapping, None).ok();
        let model = model.map(Arc::new);
        on.insert(from.to_string(), model.clone());
        model
    }
}

impl fmt::Debug for Places {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Places({})", self.robot.description.name)
    }
}

impl Soles for Places {
    fn seen(&self, q: &[f64], from: &str, of: &str, at: [f64; 2]) -> Option<[f64; 2]> {
        let model = self.model(from)?;
        let link = model.tree.links.iter().position(|link| link.name == of)?;
        let (body, place) = poses::of_link(&model, link)?;
        let mut bodies = Vec::new();
        poses::bodies(&model, q, &mut bodies);
        let sole = bodies.get(body)?.then(&place);
        let point = sole.point(&Vector3::new(at[0], at[1], 0.0));
        Some([point.x, point.y])
    }

    fn fixed(&self, from: &str, of: &str) -> Option<Frame> {
        let model = self.model(from)?;
        let link = model.tree.links.iter().position(|link| link.name == of)?;
        let (_, place) = poses::of_link(&model, link).filter(|(body, _)| *body == 0)?;
        let origin = place.point(&Vector3::zeros());
        let axis = |k: usize| (place.point(&Vector3::ith(k, 1.0)) - origin).into();
        Some(Frame {
            axes: [axis(0), axis(1), axis(2)],
            origin: origin.into(),
        })
    }
}

/// Step of differences, rad or m.
const STEP: f64 = 1e-5;

/// Tell each posture how its reading changes where joints are not where encoders have them, since
/// these place the contact of the other sole.
pub(crate) fn tell_contacts(data: &mut Postures, model: &Model, other: &OtherFoot) {
    let Some((body, place)) = poses::of_link(model, other.link) else {
        return;
    };
    let (layout, dof) = (PostureContext::of(model), model.dof());
    let mut bodies = Vec::new();
    // s T p₂
    let mut placed = |q: &[f64], [share, x, y]: [f64; 3]| {
        poses::bodies(model, q, &mut bodies);
        let sole = bodies[body].then(&place);
        sole.origin * share + sole.rotation * Vector3::new(x, y, 0.0)
    };
    let contexts = data.posture_context.chunks_exact_mut(layout.len());
    let postures = data.q.chunks_exact(dof.max(1)).zip(&data.other_contact);
    for ((q, contact), context) in postures.zip(contexts) {
        let mut moved = q.to_vec();
        for j in 0..dof {
            let mut at = |by: f64| {
                moved[j] = q[j] + by;
                let placed = placed(&moved, *contact);
                moved[j] = q[j];
                placed
            };
            let slope = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            for axis in 0..2 {
                context[layout.shift_slope(j, axis)] -= slope[axis];
            }
        }
    }
}
