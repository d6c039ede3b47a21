//! Joint velocities and accelerations that the ZMP is compared at.
//!
//! ```text
//! |c̈| ≤ Σ|r| (Σ|q̈| + 2 (Σ|q̇|)²) ≤ g/2
//! ```
//!
//! Inside the ranges that its bound holds for, and so slow that the ground surely carries
//! half of the weight, whatever the posture and the parameters.

use sesc_model::Model;
use sesc_model::inertia::GRAVITY;

/// How the joints move, in the order of `q`.
#[derive(Debug, Clone)]
pub struct JointMotion {
    /// rad/s or m/s
    pub rates: Vec<f64>,
    /// rad/s² or m/s²
    pub accelerations: Vec<f64>,
    /// No link is turned or moved by more than this, `|α| + |ω|²`, 1/s².
    stir: f64,
}

impl JointMotion {
    /// With `share(j)` of what joint `j` may do.
    pub fn new(model: &Model, share: impl Fn(usize) -> f64) -> JointMotion {
        let dofs = model.tree.dofs.iter().enumerate();
        let (rates, accelerations): (Vec<f64>, Vec<f64>) = dofs
            .map(|(j, dof)| {
                let share = share(j);
                (
                    share.abs() * dof.moderate_speed(),
                    share * dof.moderate_acceleration(),
                )
            })
            .unzip();
        let tie = model.largest_tie();
        let sum = |x: &[f64]| tie * x.iter().map(|x| x.abs()).sum::<f64>();
        let stir = sum(&accelerations) + 2.0 * sum(&rates).powi(2);
        let reach: f64 = model.param_limits.iter().sum();
        let slower = (0.5 * GRAVITY / (reach * stir)).min(1.0);
        JointMotion {
            rates: rates.iter().map(|x| x * slower.sqrt()).collect(),
            accelerations: accelerations.iter().map(|x| x * slower).collect(),
            stir: stir * slower,
        }
    }

    /// No two joints alike.
    pub fn of(model: &Model) -> JointMotion {
        let turn = |j: usize| if j.is_multiple_of(2) { 1.0 } else { -1.0 };
        JointMotion::new(model, |j| turn(j) / (1.0 + j as f64))
    }

    /// How far snapped right angles may move the ZMP, m: turning what is below a joint by ε
    /// moves the CoM by what is `snapped` there, and changes its acceleration and the angular
    /// momentum by ε of what they are.
    pub(super) fn snapped(&self, model: &Model, snapped: f64) -> f64 {
        let (reach, far, least) = (model.reach(), model.extent(), 0.5 * GRAVITY);
        let arm = (reach + far) * reach * self.stir / least;
        snapped * (1.0 + 4.0 * self.stir * (reach + far + arm) / least)
    }
}

/// Joint velocities that the velocity of the CoM is compared at, rad/s or m/s: no two alike.
pub(super) fn velocities(dof: usize) -> Vec<f64> {
    (0..dof).map(|j| 1.0 / (1.0 + j as f64)).collect()
}
