//! A robot on its support link: kinematics, chain and base parameters.
//!
//! ```text
//! CoM(q) = r_0 + Σ_{i≥1} B_i(q) r_i
//! ```
//!
//! One pass through the stages of the kinematics; it knows no file and no effect.
//!
//! ```text
//! urdf → tree (re-rooted) → chain → frames → base parameters
//! ```

use nalgebra::{DVector, Matrix3};

use crate::Error;
use crate::base::{self, Base, Column};
use crate::chain::{self, Chain};
use crate::frames::{self, Frame};
use crate::names;
use crate::numeric;
use crate::snap::Snapping;
use crate::tree::{self, Tree};
use crate::urdf::Description;

/// A robot on its support link.
#[derive(Debug, Clone)]
pub struct Robot {
    /// Links and joints, re-rooted at the support.
    pub tree: Tree,
    /// The statically equivalent serial chain.
    #[doc(hidden)]
    pub chain: Chain,
    /// Canonical axes of each body.
    #[doc(hidden)]
    pub frames: Vec<Frame>,
    /// Base parameters: what data can determine.
    pub base: Base,
    /// Identifier stem of each body: its joint, made a legal and unique word.
    pub(crate) keys: Vec<String>,
}

impl Robot {
    /// Run all stages up to the base parameters.
    ///
    /// # Errors
    /// When there is no such link, no mass, or mass beyond a free joint.
    pub fn new(
        description: &Description,
        support: &str,
        snapping: Snapping,
    ) -> Result<Robot, Error> {
        let tree = tree::reroot(description, support, snapping)?;
        let chain = chain::expand(&tree);
        let frames = frames::choose(&chain);
        let base = base::group(&tree, &chain, &frames);
        let stems = chain
            .bodies
            .iter()
            .map(|body| body.joint.as_deref().unwrap_or(&body.name));
        let keys = names::unique(stems);
        Ok(Robot {
            tree,
            chain,
            frames,
            base,
            keys,
        })
    }

    /// Name of the support link.
    pub fn support(&self) -> &str {
        &self.tree.links[self.tree.support].name
    }

    /// Number of independent joints.
    pub fn dof(&self) -> usize {
        self.tree.dofs.len()
    }

    /// CAD values of the base parameters, m.
    pub fn cad_params(&self) -> Vec<f64> {
        self.base.params.iter().map(|param| param.cad).collect()
    }

    /// Height of the CAD CoM over the sole with every joint at zero (or at its
    /// nearest limit), m.
    pub fn cad_height(&self) -> f64 {
        let rest = |dof: &tree::Dof| 0.0_f64.max(dof.lower).min(dof.upper);
        let q: Vec<f64> = self.tree.dofs.iter().map(rest).collect();
        libm::fabs(self.com_by_sum(&q)[2])
    }

    /// How far the CoM can be from the support, m: Σ‖r_i‖ and every stroke.
    #[doc(hidden)]
    pub fn reach(&self) -> f64 {
        let reach = |body: &chain::Body| match (body.motion, body.s) {
            (tree::Motion::Prismatic { by, .. }, Some(s)) => {
                body.r.norm() + s * self.tree.stroke(&by)
            }
            _ => body.r.norm(),
        };
        self.chain.bodies.iter().map(reach).sum()
    }

    /// How far mass of the robot may be from the support, m: places of joints one after the
    /// other, and the largest link.
    #[doc(hidden)]
    pub fn extent(&self) -> f64 {
        let bodies = self.chain.bodies.iter();
        let to_joints = bodies.map(|body| match body.motion {
            tree::Motion::Prismatic { by, .. } => body.anchor.norm() + self.tree.stroke(&by),
            _ => body.anchor.norm(),
        });
        let links = self.tree.links.iter().zip(&self.chain.places);
        let inside = links.filter_map(|(link, place)| {
            let gyration = libm::fabs(link.inertia.trace()) / link.mass.max(1e-9);
            Some(place.as_ref()?.origin.norm() + link.com.norm() + libm::sqrt(gyration))
        });
        to_joints.sum::<f64>() + inside.fold(0.0, f64::max)
    }

    /// Largest Σ|factor| of the joints that one independent joint moves.
    #[doc(hidden)]
    pub fn largest_tie(&self) -> f64 {
        let mut sums = vec![1.0; self.dof()];
        for by in self
            .chain
            .bodies
            .iter()
            .filter_map(|b| b.motion.coordinate())
        {
            sums[by.dof] += libm::fabs(by.factor);
        }
        sums.into_iter().fold(1.0, f64::max)
    }

    /// A posture inside the limits with every joint off its ends and its middle,
    /// in steps of 2^-16: the same in every scalar.
    #[doc(hidden)]
    pub fn self_test_posture(&self) -> Vec<f64> {
        // Not the first of the sequence: some way in, no joint is near another.
        let mut postures = numeric::postures(&self.tree.dofs, 8);
        let coarse = |(x, dof): (f64, &tree::Dof)| {
            let rounded = libm::rint(x * 65536.0) / 65536.0;
            match (dof.lower..=dof.upper).contains(&rounded) {
                true => rounded,
                false => x,
            }
        };
        let posture = postures.nth(7).unwrap_or_default();
        posture
            .into_iter()
            .zip(&self.tree.dofs)
            .map(coarse)
            .collect()
    }

    /// The heaviest link, and where its x axis points in the support frame while every joint is
    /// at zero.
    #[doc(hidden)]
    pub fn heaviest_ahead(&self) -> Option<(&str, [f64; 3])> {
        let links = self.tree.links.iter().zip(&self.chain.places);
        let placed = links.filter_map(|(link, place)| Some((link, place.as_ref()?)));
        let (link, place) = placed.reduce(|most, next| match next.0.mass > most.0.mass {
            true => next,
            false => most,
        })?;
        let bodies = numeric::orientations(&self.chain, &vec![0.0; self.dof()]);
        let ahead = bodies[place.body] * place.orientation.column(0);
        Some((&link.name, ahead.into()))
    }

    /// CoM as the plain sum r_0 + Σ B_i r_i over full CAD parameters, m; by
    /// numeric rotations, without frames, expressions or programs.
    #[doc(hidden)]
    pub fn com_by_sum(&self, q: &[f64]) -> [f64; 3] {
        let cad = DVector::from_vec(self.chain.full_cad());
        let com = numeric::full_regressor(&self.chain, q) * cad;
        [com[0], com[1], com[2]]
    }

    /// Index of the base parameter on canonical axis `axis` of `body`.
    pub(crate) fn axis_param(&self, body: usize, axis: usize) -> Option<usize> {
        self.position(Column::Axis { body, axis })
    }

    /// Index of the base parameter s of a body on a prismatic joint.
    pub(crate) fn prismatic_param(&self, body: usize) -> Option<usize> {
        self.position(Column::Prismatic { body })
    }

    fn position(&self, column: Column) -> Option<usize> {
        // Parameters are in preorder of bodies: a binary search keeps 1000 joints linear.
        let key = |c: &Column| match *c {
            Column::Axis { body, axis } => (body, axis),
            Column::Prismatic { body } => (body, 3),
        };
        self.base
            .params
            .binary_search_by_key(&key(&column), |param| key(&param.column))
            .ok()
    }

    /// Canonical axes of body `i` in its link frame, as columns.
    pub(crate) fn axes(&self, i: usize) -> &Matrix3<f64> {
        &self.frames[i].axes
    }
}
