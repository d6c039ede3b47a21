//! Derivatives by differences: the CoM Jacobian and the gravity moments.
//!
//! ```text
//! D(h) = (f(q + h e_j) - f(q - h e_j)) / 2h = f' + a h² + b h⁴ + c h⁶ + …
//! E(h) = (4 D(h/2) - D(h)) / 3              removes a h²
//! F(h) = (16 E(h/2) - E(h)) / 15            removes b h⁴
//! ```
//!
//! For `f` made of sines of `q_j` what remains of `F` is `h⁶/322560` of the
//! size of `f`. With `h` = 0.05 that is 5e-14, and rounding adds as much again:
//! both far below the documented 1e-10. Where mimic joints move along with `q_j`,
//! `h` shrinks by the sum of their factors, so that no link rotates further.

use nalgebra::{DVector, Matrix3xX, Vector3};

use crate::com::Reference;
use crate::nearby::Nearby;

/// The largest rotation of any link during a difference, rad (or m).
const STEP: f64 = 0.05;

impl Reference {
    /// The CoM Jacobian `∂CoM/∂q`: 3 rows in the support frame, one column per
    /// entry of the posture; m/rad, or m/m for prismatic joints. Accurate to
    /// 1e-10 of the robot's size.
    ///
    /// # Panics
    /// Where `q` has not one entry per movable joint.
    pub fn com_jacobian(&self, q: &[f64]) -> Matrix3xX<f64> {
        let mut jacobian = Matrix3xX::zeros(self.dof());
        let mut nearby = Nearby::new(self, q);
        for (j, mut column) in jacobian.column_iter_mut().enumerate() {
            column.copy_from(&self.differentiate(&mut nearby, q[j], j));
        }
        jacobian
    }

    /// The moments of gravity on the joints, with gravity along −z of the
    /// support frame, per unit of weight `M g`: metres for revolute joints (no
    /// unit for prismatic ones). Moment `j` is what gravity does to joint `j`,
    /// `-∂U/∂q_j` with the potential energy `U(q) = Σ m_l z_l(q) / M`, which is
    /// the height of the CoM.
    ///
    /// # Panics
    /// As [`Reference::com_jacobian`].
    pub fn gravity_moments(&self, q: &[f64]) -> DVector<f64> {
        -self.com_jacobian(q).row(2).transpose()
    }

    /// `∂CoM/∂q_j` by central differences about `q_j` = `middle`, extrapolated twice.
    fn differentiate(&self, nearby: &mut Nearby, middle: f64, j: usize) -> Vector3<f64> {
        let followers = self.robot.coordinates().iter();
        let rate: f64 = followers
            .filter(|coordinate| coordinate.dof == Some(j))
            .map(|coordinate| coordinate.factor.abs())
            .sum();
        // At least one: joint j itself is among them.
        let h = STEP / rate;
        let [d1, d2, d4] = [h, h / 2.0, h / 4.0].map(|h| {
            let ends = [middle + h, middle - h];
            let [upper, lower] = nearby.com(j, ends);
            // The step that was taken, after rounding.
            (upper - lower) / (ends[0] - ends[1])
        });
        let (e1, e2) = ((d2 * 4.0 - d1) / 3.0, (d4 * 4.0 - d2) / 3.0);
        (e2 * 16.0 - e1) / 15.0
    }
}
