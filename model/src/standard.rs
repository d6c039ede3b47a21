//! Standard parameters: what each link weighs and where, as parts of the whole.
//!
//! ```text
//! θ = (m_k / M, m_k c_k / M) of every link k        r = W θ        Σ m_k / M = 1
//! ```
//!
//! `c_k` in the link's own frame, M the mass of the robot. Base parameters are
//! linear in θ by lengths of the URDF alone, so tolerances of CAD carry over to
//! them, and parameters seen from two supports are affine in each other.

use nalgebra::{DMatrix, DMatrixViewMut, DVector};

use crate::robot::Robot;

/// Entries of θ per link: mass fraction, then first moment x, y, z.
pub const PER_LINK: usize = 4;

impl Robot {
    /// W: base parameters × 4 per link of [`crate::tree::Tree::links`].
    ///
    /// Columns of links beyond a cut are zero.
    pub fn standard_map(&self) -> DMatrix<f64> {
        let full = self.full_of_standard();
        let mut map = DMatrix::zeros(self.base.params.len(), full.ncols());
        for (row, param) in self.base.params.iter().enumerate() {
            for &(k, weight) in &param.terms {
                for column in 0..full.ncols() {
                    map[(row, column)] += weight * full[(k, column)];
                }
            }
        }
        map
    }

    /// CAD values of θ: mass fractions and first moments (m), link by link.
    pub fn standard_cad(&self) -> DVector<f64> {
        let total = self.tree.mass;
        let links = self.tree.links.iter().zip(&self.chain.places);
        let values = links.flat_map(|(link, place)| {
            let share = if place.is_some() {
                link.mass / total
            } else {
                0.0
            };
            [
                share,
                share * link.com.x,
                share * link.com.y,
                share * link.com.z,
            ]
        });
        DVector::from_iterator(PER_LINK * self.tree.links.len(), values)
    }

    /// Full parameters as linear forms of θ: the sums of `chain`, link by link.
    fn full_of_standard(&self) -> DMatrix<f64> {
        let mut map = DMatrix::zeros(self.chain.full_params, PER_LINK * self.chain.places.len());
        for link in 0..self.chain.places.len() {
            self.add_full_of_link(link, &mut map.columns_mut(PER_LINK * link, PER_LINK));
        }
        map
    }

    /// Base parameters of `self` from those of the same robot on another support:
    /// `r = matrix · r_other + offset`, by lengths of the URDF alone.
    ///
    /// Returns the largest entry that no such map explains besides: rounding,
    /// unless `other` is another robot.
    pub fn params_from(&self, other: &Robot) -> Shift {
        let (own, theirs) = (self.standard_map(), other.standard_map());
        let (rows, columns) = (theirs.nrows() + 1, theirs.ncols());
        // [W_other; masses] θ = [r_other; 1], and every row of W_own is a sum of its rows.
        let mut known = DMatrix::zeros(rows, columns);
        known.rows_mut(0, rows - 1).copy_from(&theirs);
        for (k, place) in other.chain.places.iter().enumerate() {
            known[(rows - 1, PER_LINK * k)] = if place.is_some() { 1.0 } else { 0.0 };
        }
        let (q, r) = known.transpose().qr().unpack();
        let right = (&own * &q).transpose();
        let sums = r.solve_upper_triangular(&right);
        let sums = sums.unwrap_or_else(|| DMatrix::zeros(rows, own.nrows()));
        let sums = sums.transpose();
        Shift {
            unexplained: (&sums * &known - &own).amax(),
            matrix: sums.columns(0, rows - 1).into_owned(),
            offset: sums.column(rows - 1).into_owned(),
        }
    }

    /// The four columns of W that belong to one link.
    pub fn standard_map_of(&self, link: usize) -> DMatrix<f64> {
        let mut full = DMatrix::zeros(self.chain.full_params, PER_LINK);
        self.add_full_of_link(link, &mut full.columns_mut(0, PER_LINK));
        let mut map = DMatrix::zeros(self.base.params.len(), PER_LINK);
        for (row, param) in self.base.params.iter().enumerate() {
            for &(k, weight) in &param.terms {
                for column in 0..PER_LINK {
                    map[(row, column)] += weight * full[(k, column)];
                }
            }
        }
        map
    }

    fn add_full_of_link(&self, link: usize, map: &mut DMatrixViewMut<f64>) {
        let bodies = &self.chain.bodies;
        let Some(place) = &self.chain.places[link] else {
            return;
        };
        let row = bodies[place.body].column;
        for m in 0..3 {
            map[(row + m, 0)] += place.origin[m];
            for n in 0..3 {
                map[(row + m, 1 + n)] += place.orientation[(m, n)];
            }
        }
        // Its mass is carried through every joint on the way to the support.
        let mut at = place.body;
        while let Some(parent) = bodies[at].parent {
            if bodies[at].s.is_some() {
                map[(bodies[at].column + 3, 0)] += 1.0;
            }
            for m in 0..3 {
                map[(bodies[parent].column + m, 0)] += bodies[at].anchor[m];
            }
            at = parent;
        }
    }
}

/// How base parameters change with the support: `r = matrix · r_other + offset`.
#[derive(Debug, Clone)]
pub struct Shift {
    /// Base parameters of one support in terms of those of the other.
    pub matrix: DMatrix<f64>,
    /// m (mass fractions for prismatic joints)
    pub offset: DVector<f64>,
    /// Largest coefficient left over.
    pub unexplained: f64,
}
