//! Readings that are put together from the contacts of both feet, where a joint is off.
//!
//! ```text
//! y = (1 − s) p₁ + s T(q) p₂                         as the encoders q have the other sole
//!   = CoP(φ) − s Σ_j ∂(T p₂)/∂q_j (φ_j − q_j)        where its joints are at φ
//! ```

use nalgebra::Vector3;
use sesc_model::Model;
use sesc_model::effects::PostureContext;

use super::other::OtherFoot;
use crate::observations::postures::Postures;
use crate::poses;

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
