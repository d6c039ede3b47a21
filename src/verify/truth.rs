//! What the reference says of one posture, and how far the values of a function are from it.

use sesc_model::Function;
use sesc_reference::Reference;

use super::motion::JointMotion;

/// What the reference says of one posture.
pub(super) struct Truth {
    pub com: [f64; 3],
    /// The CoM that regressor rows give: of the robot with effects of the encoders alone.
    pub rows: [f64; 3],
    /// The CoP as the sensor reads it.
    pub cop: [f64; 2],
    /// The ZMP as joints move, where it is known.
    pub zmp: Option<[f64; 2]>,
    /// Row-major Jacobian and gravity moments, where they were taken.
    pub derivatives: Option<(Vec<f64>, Vec<f64>)>,
}

impl Truth {
    pub fn new(
        reference: &Reference,
        q: &[f64],
        joints: &JointMotion,
        differentiate: bool,
    ) -> Truth {
        let com = reference.com(q);
        let derivatives = differentiate.then(|| {
            let jacobian = reference.com_jacobian(q).transpose();
            let moments = -jacobian.column(2);
            (jacobian.as_slice().to_vec(), moments.as_slice().to_vec())
        });
        Truth {
            com: [com.x, com.y, com.z],
            rows: [com.x, com.y, com.z],
            cop: [com.x, com.y],
            zmp: Some(
                reference
                    .zmp(q, &joints.rates, &joints.accelerations)
                    .into(),
            ),
            derivatives,
        }
    }

    /// Largest difference between `values` of `function` and the truth, m; of rows by what
    /// they give times `params`, of a velocity by that of joints that move at `params`.
    pub fn difference(&self, function: Function, params: &[f64], values: &[f64]) -> f64 {
        let times = |row: &[f64]| -> f64 { row.iter().zip(params).map(|(a, b)| a * b).sum() };
        let explained =
            |rows: &[f64]| -> Vec<f64> { rows.chunks(params.len().max(1)).map(times).collect() };
        match (function, &self.derivatives) {
            (Function::Com, _) => largest(values, &self.com),
            (Function::Cop, _) => largest(values, &self.cop),
            (Function::Zmp, _) => self.zmp.map_or(0.0, |zmp| largest(values, &zmp)),
            // Not of a posture: nothing to compare.
            (Function::CorrectCop, _) => 0.0,
            (Function::Regressor | Function::RegressorCop | Function::RegressorFull, _) => {
                largest(&explained(values), &self.rows)
            }
            (Function::ComJacobian, Some((jacobian, _))) => largest(values, jacobian),
            (Function::GravityMoments, Some((_, moments))) => largest(values, moments),
            (Function::ComVelocity, Some((jacobian, _))) => largest(values, &explained(jacobian)),
            (Function::ComJacobian | Function::ComVelocity | Function::GravityMoments, None) => 0.0,
        }
    }
}

/// Largest |a − b| over the entries of `a`; NaN if there is one.
fn largest(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(x, y)| (x - y).abs());
    differences.fold(0.0, |most, x| if x.is_nan() || x > most { x } else { most })
}
