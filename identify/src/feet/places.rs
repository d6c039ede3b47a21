//! Where one sole is, seen from another: for recordings that have the contact of each by itself.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Vector3;
use sesc_model::{Model, Snapping};

use crate::logs::Soles;
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
}
