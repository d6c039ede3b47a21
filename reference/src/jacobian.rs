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

use nalgebra::{DVector, Matrix3xX, SVector, Vector1};

use crate::com::Reference;
use crate::nearby::Nearby;

/// The largest rotation of any link during a difference, rad (or m).
const STEP: f64 = 0.05;

impl Reference {
    /// The CoM Jacobian `∂CoM/∂q`: 3 rows in the support frame, one column per
    /// entry of the posture; m/rad, or m/m for prismatic joints. Accurate to
    /// 1e-10 of the robot's size.
    pub fn com_jacobian(&self, q: &[f64]) -> Matrix3xX<f64> {
        let mut jacobian = Matrix3xX::zeros(self.dof());
        let mut nearby = Nearby::new(&self.robot, q);
        for (j, mut column) in jacobian.column_iter_mut().enumerate() {
            column.copy_from(&self.differentiate(q, j, |x| self.com_at(nearby.with(j, x))));
        }
        jacobian
    }

    /// The moments of gravity on the joints, with gravity along −z of the
    /// support frame, per unit of weight `M g`: metres for revolute joints (no
    /// unit for prismatic ones). Moment `j` is what gravity does to joint `j`,
    /// `-∂U/∂q_j` with the potential energy `U(q) = Σ m_l z_l(q) / M`.
    pub fn gravity_moments(&self, q: &[f64]) -> DVector<f64> {
        let mut nearby = Nearby::new(&self.robot, q);
        let moments = (0..self.dof()).map(|j| {
            let energy = |x| Vector1::new(self.potential_energy_at(nearby.with(j, x)));
            -self.differentiate(q, j, energy).x
        });
        DVector::from_iterator(self.dof(), moments)
    }

    /// [`Reference::com_jacobian`] and [`Reference::gravity_moments`] from the same postures.
    pub fn derivatives(&self, q: &[f64]) -> (Matrix3xX<f64>, DVector<f64>) {
        let mut jacobian = Matrix3xX::zeros(self.dof());
        let mut moments = DVector::zeros(self.dof());
        let mut nearby = Nearby::new(&self.robot, q);
        for (j, mut column) in jacobian.column_iter_mut().enumerate() {
            let slopes = self.differentiate(q, j, |x| {
                let poses = nearby.with(j, x);
                self.com_at(poses).push(self.potential_energy_at(poses))
            });
            column.copy_from(&slopes.xyz());
            moments[j] = -slopes.w;
        }
        (jacobian, moments)
    }

    /// Potential energy per unit of weight: the sum over links of their mass
    /// fraction times the height of their centre of mass, m.
    pub fn potential_energy(&self, q: &[f64]) -> f64 {
        self.potential_energy_at(&self.robot.poses_in_root(q))
    }

    /// `∂f/∂q_j` by central differences, extrapolated twice; `f` of the entry `q_j`.
    fn differentiate<const N: usize>(
        &self,
        q: &[f64],
        j: usize,
        mut f: impl FnMut(f64) -> SVector<f64, N>,
    ) -> SVector<f64, N> {
        let followers = self.robot.coordinates().iter();
        let rate: f64 = followers
            .filter(|coordinate| coordinate.dof == Some(j))
            .map(|coordinate| coordinate.factor.abs())
            .sum();
        // At least one: joint j itself is among them.
        let h = STEP / rate;
        let mut central = |h: f64| {
            let (upper, lower) = (q[j] + h, q[j] - h);
            // The step that was taken, after rounding.
            (f(upper) - f(lower)) / (upper - lower)
        };
        let (d1, d2, d4) = (central(h), central(h / 2.0), central(h / 4.0));
        let (e1, e2) = ((d2 * 4.0 - d1) / 3.0, (d4 * 4.0 - d2) / 3.0);
        (e2 * 16.0 - e1) / 15.0
    }
}
