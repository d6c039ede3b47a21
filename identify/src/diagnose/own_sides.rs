//! Where joints rest in a fit, kept beside what the log says of its postures.

use std::sync::Arc;

use sesc_model::effects::PostureContext;

/// The sides on which joints rest in a fit, where they are not those of the log's context.
#[derive(Debug, Clone)]
pub struct OwnSides {
    joints: Vec<usize>,
    /// Posture by posture.
    sides: Arc<Vec<f64>>,
}

impl OwnSides {
    /// The sides by which the context `own` of a fit differs from that of its log; robots have
    /// `dof` joints.
    pub fn of(layout: &PostureContext, dof: usize, log: &[f64], own: &[f64]) -> OwnSides {
        let postures = || (0..log.len()).step_by(layout.len());
        let differs = |joint: &usize| {
            let side = layout.side(*joint);
            postures().any(|at| own[at + side].to_bits() != log[at + side].to_bits())
        };
        let joints: Vec<usize> = (0..dof).filter(differs).collect();
        let sides = postures().flat_map(|at| joints.iter().map(move |j| own[at + layout.side(*j)]));
        OwnSides {
            sides: Arc::new(sides.collect()),
            joints,
        }
    }

    /// The context of the fit: that of its log with these sides in it.
    pub fn context(&self, layout: &PostureContext, log: &[f64]) -> Vec<f64> {
        let mut all = log.to_vec();
        let postures = all.chunks_exact_mut(layout.len());
        let own = self.sides.chunks_exact(self.joints.len().max(1));
        for (posture, sides) in postures.zip(own) {
            for (joint, side) in self.joints.iter().zip(sides) {
                posture[layout.side(*joint)] = *side;
            }
        }
        all
    }
}
