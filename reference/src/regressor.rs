//! The regressor at the level of standard parameters, and its rank.
//!
//! With `μ_l = m_l / M` and `h_l = m_l c_l / M` Eq. (3) is linear in four
//! *standard parameters* per link,
//!
//! ```text
//! CoM(q) = Σ_l ( p_l(q) μ_l + R_l(q) h_l )
//! ```
//!
//! where `p_l` is the origin and `R_l` the orientation of link `l` in the
//! support frame. A column is by definition the CoM with one parameter one and
//! all others zero.
//!
//! # What the rank says
//!
//! Mass fractions sum to one, so the CoM functions of one mechanism are not a
//! linear space but an affine one. The support link's own columns settle the
//! difference: `p_support = 0` for every posture. Its fraction takes up
//! `1 - Σ_others μ` and changes nothing, so the sum to one is no constraint, and
//! the zero function (all mass at the support's origin) is among the CoM
//! functions. Hence
//!
//! * the CoM functions fill exactly the span of the standard columns. Masses
//!   that are positive fill an open part of it: bounds on them do not lower
//!   its dimension;
//! * `rank(standard columns)` over enough postures is the number of **base
//!   parameters**. The three constants of `r_0` are in it, as the columns
//!   `R_support = 1` of the support's first moment; nothing is to be added or
//!   taken away for the normalisation;
//! * every link counts, massless ones too, since a column does not ask what
//!   multiplies it.
//!
//! `p_l` is a sum of constant vectors rotated by the orientations on the way,
//! which the `R` columns span already, and of `R_parent a_j q_j` for the
//! prismatic joints on the way. The rank is therefore 3, and 2 more for every
//! revolute joint (of the rotated body's three columns the one along the axis
//! is a column of its parent), 1 more for every prismatic and 0 for every
//! fixed one. A mimic counts like any other joint of its kind, as long as the
//! tie brings no dependence of its own: the second of two joints about
//! parallel axes that rotate against each other (a parallelogram) adds nothing,
//! nor does the second of two gripper fingers that move in step.
//!
//! The x and y rows alone (CoP on flat ground) lose what lies along z in every
//! posture: always the constant z of `r_0`, so 1, and 1 more for every prismatic
//! joint that stays vertical, as a lift on the support does.

use nalgebra::{DMatrix, DVector, Matrix3xX, Rotation3, Vector3};

use crate::com::Reference;
use crate::error::Error;

/// Standard parameters per link: mass fraction, then first moment x, y, z.
const PER_LINK: usize = 4;

impl Reference {
    /// The standard columns: 3 rows in the support frame, 4 columns per link
    /// in the order of the file, `[p_l, R_l]`; `p_l` in metres. Columns of
    /// links whose place [is not known](Reference::is_placed) are zero.
    pub fn standard_columns(&self, q: &[f64]) -> Matrix3xX<f64> {
        let poses = self.link_poses(q);
        let mut columns = Matrix3xX::zeros(PER_LINK * poses.len());
        for (l, pose) in poses.iter().enumerate().filter(|&(l, _)| self.is_placed(l)) {
            columns.set_column(PER_LINK * l, &pose.translation.vector);
            columns
                .fixed_columns_mut::<3>(PER_LINK * l + 1)
                .copy_from(pose.rotation.matrix());
        }
        columns
    }

    /// The robot's own standard parameters `[μ_l, h_l]`: one mass fraction
    /// (no unit) and three first moments (m) per link.
    pub fn standard_parameters(&self) -> DVector<f64> {
        let links = self.robot.links();
        let mut parameters = DVector::zeros(PER_LINK * links.len());
        for (l, link) in links.iter().enumerate() {
            let fraction = link.mass_kg / self.total_mass();
            parameters[PER_LINK * l] = fraction;
            parameters
                .fixed_rows_mut::<3>(PER_LINK * l + 1)
                .copy_from(&(link.com_m.coords * fraction));
        }
        parameters
    }

    /// The CoM sum for any standard parameters, `Σ T_l [h_l; μ_l]`, m.
    ///
    /// # Panics
    /// Where there are not four parameters per link.
    pub fn com_of(&self, q: &[f64], parameters: &[f64]) -> Vector3<f64> {
        let poses = self.link_poses(q);
        assert_eq!(
            parameters.len(),
            PER_LINK * poses.len(),
            "four parameters per link"
        );
        let links = poses
            .iter()
            .zip(parameters.chunks_exact(PER_LINK))
            .enumerate();
        links
            .filter(|&(l, _)| self.is_placed(l))
            .map(|(_, (pose, p))| {
                let weighted = nalgebra::Vector4::new(p[1], p[2], p[3], p[0]);
                (pose.to_homogeneous() * weighted).xyz()
            })
            .sum()
    }

    /// Column `k` of the standard regressor by its definition: the CoM sum
    /// with parameter `k` one and all others zero.
    ///
    /// # Panics
    /// Where `k` is not below four times the number of links.
    pub fn column_by_definition(&self, q: &[f64], k: usize) -> Vector3<f64> {
        let mut unit = vec![0.0; PER_LINK * self.robot.links().len()];
        unit[k] = 1.0;
        self.com_of(q, &unit)
    }

    /// Standard columns of many postures on top of each other: the rows named
    /// by `axes` (`[0, 1, 2]` for CoM, `[0, 1]` for CoP on flat ground) of each
    /// posture in turn.
    pub fn stacked_columns(&self, postures: &[Vec<f64>], axes: &[usize]) -> DMatrix<f64> {
        let width = PER_LINK * self.robot.links().len();
        let mut rows = DMatrix::zeros(axes.len() * postures.len(), width);
        for (block, q) in postures.iter().enumerate() {
            let columns = self.standard_columns(q);
            for (row, &axis) in axes.iter().enumerate() {
                rows.set_row(axes.len() * block + row, &columns.row(axis));
            }
        }
        rows
    }

    /// The orientation `B` of a link in the support frame.
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`.
    pub fn body_orientation(&self, link: &str, q: &[f64]) -> Result<Rotation3<f64>, Error> {
        Ok(self.link_poses(q)[self.robot.link_index(link)?].rotation)
    }
}

/// The number of singular values above `tolerance` times the largest; zero for
/// a matrix of zeros. Columns should be of similar size. The matrix needs more
/// rows than the rank looked for, from postures that move every joint well;
/// `1e-9` then tells rounding (`1e-15`) from any direction worth a name.
///
/// # Panics
/// Where an entry is not finite.
pub fn numeric_rank(rows: &DMatrix<f64>, tolerance: f64) -> usize {
    assert!(
        rows.iter().all(|entry| entry.is_finite()),
        "a rank needs finite numbers"
    );
    if rows.is_empty() {
        return 0;
    }
    let values = rows.singular_values();
    let least = tolerance * values.max();
    values.iter().filter(|&&value| value > least).count()
}
