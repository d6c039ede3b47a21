//! What the reference says of a posture, and the joint velocities and accelerations that the ZMP is
//! compared at.
//!
//! ```text
//! |c̈| ≤ Σ|r| (Σ|q̈| + 2 (Σ|q̇|)²) ≤ g/2
//! ```
//!
//! Inside the ranges that its bound holds for, and so slow that the ground surely carries
//! half of the weight, whatever the posture and the parameters.

use sesc_model::inertia::GRAVITY;
use sesc_model::{Function, Model};
use sesc_reference::Reference;

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
        let dofs = || model.tree.dofs.iter().enumerate();
        let rates = dofs().map(|(j, dof)| share(j).abs() * dof.moderate_speed());
        let rates: Vec<f64> = rates.collect();
        let accelerations = dofs().map(|(j, dof)| share(j) * dof.moderate_acceleration());
        let accelerations: Vec<f64> = accelerations.collect();
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

/// What the reference says of one posture; what is not known has no numbers.
#[derive(Default)]
pub(super) struct Truth {
    pub com: [f64; 3],
    /// The CoM that regressor rows give: of the robot with effects of the encoders alone.
    pub rows: [f64; 3],
    /// The CoP as the sensor reads it.
    pub cop: [f64; 2],
    /// The ZMP as joints move.
    pub zmp: Option<[f64; 2]>,
    /// Derivatives with respect to what encoders read, row-major, where they were taken.
    pub com_jacobian: Vec<f64>,
    pub cop_jacobian: Vec<f64>,
    pub moments: Vec<f64>,
}

impl Truth {
    pub(super) fn new(
        reference: &Reference,
        q: &[f64],
        joints: &JointMotion,
        differentiate: bool,
    ) -> Truth {
        let com: [f64; 3] = reference.com(q).into();
        let zmp = reference.zmp(q, &joints.rates, &joints.accelerations);
        let mut truth = Truth {
            com,
            rows: com,
            cop: [com[0], com[1]],
            zmp: Some(zmp.into()),
            ..Truth::default()
        };
        if differentiate {
            let jacobian = reference.com_jacobian(q).transpose();
            truth.com_jacobian = jacobian.as_slice().to_vec();
            truth.cop_jacobian = jacobian.as_slice()[..2 * q.len()].to_vec();
            truth.moments = jacobian.column(2).iter().map(|x| -x).collect();
        }
        truth
    }

    /// Largest difference between `values` of `function` and the truth, m; of rows by what
    /// they give times `params`, of a velocity by that of joints that move at `params`.
    pub(super) fn difference(&self, function: Function, params: &[f64], values: &[f64]) -> f64 {
        let times = |row: &[f64]| -> f64 { row.iter().zip(params).map(|(a, b)| a * b).sum() };
        let explained =
            |rows: &[f64]| -> Vec<f64> { rows.chunks(params.len().max(1)).map(times).collect() };
        match function {
            Function::Com => largest(values, &self.com),
            Function::Cop => largest(values, &self.cop),
            Function::Zmp => largest(values, self.zmp.as_slice().as_flattened()),
            // Not of a posture: nothing to compare.
            Function::CorrectCop => 0.0,
            Function::Regressor | Function::RegressorCop | Function::RegressorFull => {
                largest(&explained(values), &self.rows)
            }
            Function::ComJacobian => largest(values, &self.com_jacobian),
            Function::CopJacobian => largest(values, &self.cop_jacobian),
            Function::GravityMoments => largest(values, &self.moments),
            Function::ComVelocity => largest(values, &explained(&self.com_jacobian)),
        }
    }
}

/// Largest |a − b| over the entries of `a`; NaN if there is one.
fn largest(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(x, y)| (x - y).abs());
    differences.fold(0.0, |most, x| if x.is_nan() || x > most { x } else { most })
}
