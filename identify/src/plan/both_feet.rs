//! Postures with both soles on one floor: a closed chain.
//!
//! ```text
//! h(q) = (p_z, roll, pitch) of the other sole = 0        CoP(q) = u + λ p_xy(q)
//! q ← q + W Jᵀ (J W Jᵀ + ε)⁻¹ (0 − h, u + λ p_xy − CoP)        λ in (0, 1): from sole to sole
//! ```
//!
//! The CoP of both feet together may be wherever the hull of two soles is: that of the support,
//! and the same about the other sole.

use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};
use sesc_model::Model;
use sesc_model::effects::other_sole_by_joints;
use sesc_model::tape::{Tape, Values};

use super::balance::Region;
use super::limits::{is_stuck, stride};
use crate::evaluate::FASTEST;
use crate::feet::{OtherFoot, ROWS};
use crate::poses::{self, Pose};

/// Soles that lie this well are on the floor, m and rad.
const ON_FLOOR: f64 = 1e-9;
/// Steps that put them there.
const STEPS: usize = 20;
/// A little damping where no joint moves an equation.
const DAMPING: f64 = 1e-9;
/// How far the soles may be from each other, as parts of how far they are at rest.
const APART: (f64, f64) = (0.75, 2.0);
/// The other foot stays on its side: within this angle's cosine of where it is at rest.
const BESIDE: f64 = 0.7;

/// The other sole of a robot on its support.
pub struct BothFeet<'m> {
    model: &'m Model,
    /// The sole.
    pub other: OtherFoot,
    /// Body of the chain that holds the other sole, which may touch the floor.
    pub body: usize,
    place: Pose,
    tape: Tape,
    rest: Vector2<f64>,
}

impl<'m> BothFeet<'m> {
    /// At rest in posture `rest`; none of a link that hangs on a joint nobody knows.
    pub fn new(model: &'m Model, other: OtherFoot, rest: &[f64]) -> Option<BothFeet<'m>> {
        let (body, link) = poses::of_link(model, other.link)?;
        let place = link.then(&Pose {
            rotation: Matrix3::identity(),
            origin: Vector3::new(0.0, 0.0, -other.below_m),
        });
        let mut feet = BothFeet {
            model,
            tape: Tape::new(&other_sole_by_joints(model, other.place())),
            other,
            body,
            place,
            rest: Vector2::zeros(),
        };
        feet.rest = feet.sole(rest).origin.xy();
        Some(feet)
    }

    /// The other sole's frame.
    fn sole(&self, q: &[f64]) -> Pose {
        let mut bodies = Vec::new();
        poses::bodies(self.model, q, &mut bodies);
        bodies[self.body].then(&self.place)
    }

    /// Where its origin is on the floor, m.
    pub fn at(&self, q: &[f64]) -> Vector2<f64> {
        self.sole(q).origin.xy()
    }

    /// Height, roll and pitch, and their slopes, a row each.
    fn lies(&self, q: &[f64]) -> (Vector3<f64>, DMatrix<f64>) {
        let width = 1 + q.len();
        let mut out = vec![0.0; ROWS * width];
        self.tape
            .run(&[Values::PerPosture(q)], 1, &mut out, FASTEST);
        let values = Vector3::from_fn(|row, _| out[row * width]);
        let slopes = DMatrix::from_fn(ROWS, q.len(), |row, j| out[row * width + 1 + j]);
        (values, slopes)
    }

    /// One step towards both soles on the floor and a CoP that is off by `miss` (m), whose
    /// slopes are `jacobian` (x row, y row); how far the soles are off it, m and rad.
    pub fn step(
        &self,
        q: &mut [f64],
        miss: Vector2<f64>,
        jacobian: &[f64],
        ranges: &[(f64, f64)],
    ) -> f64 {
        let (values, slopes) = self.lies(q);
        let rows = DMatrix::from_fn(ROWS + 2, q.len(), |row, j| match row {
            row if row < ROWS => slopes[(row, j)],
            row => jacobian[(row - ROWS) * q.len() + j],
        });
        let wanted = [-values[0], -values[1], -values[2], miss.x, miss.y];
        move_by(q, &DVector::from_column_slice(&wanted), &rows, ranges);
        values.amax()
    }

    /// Put the other sole on the floor, wherever the CoP goes: whether it is there.
    pub fn put_down(&self, q: &mut [f64], ranges: &[(f64, f64)]) -> bool {
        for _ in 0..STEPS {
            let (values, slopes) = self.lies(q);
            if values.amax() <= ON_FLOOR {
                return true;
            }
            let wanted = DVector::from_column_slice((-values).as_slice());
            move_by(q, &wanted, &slopes, ranges);
        }
        self.lies(q).0.amax() <= ON_FLOOR
    }

    /// Where the CoP may be: the hull of both soles' regions; none where the feet are too close,
    /// too far from each other, or crossed.
    pub fn region(&self, own: &Region, q: &[f64]) -> Option<Region> {
        let sole = self.sole(q);
        let at = sole.origin.xy();
        let (far, still) = (at.norm(), self.rest.norm());
        let fits = (APART.0 * still..=APART.1 * still).contains(&far)
            && at.dot(&self.rest) >= BESIDE * far * still
            && sole.rotation[(2, 2)] > 0.0;
        if !fits {
            return None;
        }
        let moved = own.corners.iter().map(|&[x, y]| {
            let corner = sole.point(&Vector3::new(x, y, 0.0));
            [corner.x, corner.y]
        });
        Region::hull(
            own.corners.iter().copied().chain(moved).collect(),
            own.margin,
        )
    }
}

/// Least motion, in parts of the ranges, that changes the equations of `rows` by `wanted`.
fn move_by(q: &mut [f64], wanted: &DVector<f64>, rows: &DMatrix<f64>, ranges: &[(f64, f64)]) {
    let weights = ranges.iter().map(|(low, high)| (high - low).powi(2));
    let mut weights: Vec<f64> = weights.collect();
    let mut steps = DVector::zeros(q.len());
    // Joints at a limit that would go further stay; the others do their part.
    for _ in 0..2 {
        let mut weighted = rows.clone();
        for (mut column, weight) in weighted.column_iter_mut().zip(&weights) {
            column *= *weight;
        }
        let mut gram = &weighted * rows.transpose();
        let damping = DAMPING * gram.trace() + f64::MIN_POSITIVE;
        for k in 0..gram.nrows() {
            gram[(k, k)] += damping;
        }
        let Some(factor) = gram.cholesky() else {
            return;
        };
        steps = weighted.tr_mul(&factor.solve(wanted));
        for (j, range) in ranges.iter().enumerate() {
            if is_stuck(q[j], steps[j], *range) {
                weights[j] = 0.0;
            }
        }
    }
    stride(q, steps.as_slice(), ranges);
}
