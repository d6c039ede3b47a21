//! What a posture has to respect: joint limits, balance, the ground, the robot's own body.

use nalgebra::DMatrix;
use sesc_model::Model;

use super::balance::Region;
use super::both_feet::BothFeet;
use super::clearance::Clearance;
use super::collision::Collisions;
use super::geometry::Geometry;
use super::limits::Limits;
use crate::feet::OtherFoot;

/// A robot on the ground, and what its postures have to respect.
pub struct Scene<'a> {
    /// The robot on its support.
    pub model: &'a Model,
    /// Joint limits.
    pub limits: &'a Limits,
    /// Where the CoP may be.
    pub region: &'a Region,
    /// Standard deviations of the CoP kept from the edge.
    pub sigmas: f64,
    /// S of the parameters' covariance S Sᵀ.
    pub uncertainty: DMatrix<f64>,
    /// What must stay clear of the ground.
    pub clearance: Clearance,
    /// The other sole, where it has to lie on the floor, too.
    pub both_feet: Option<BothFeet<'a>>,
    /// What must not collide.
    pub collisions: Collisions,
}

impl<'a> Scene<'a> {
    /// A robot whose parameters are known, `clearance` (m) above the ground but for its support
    /// and the foot `other`.
    pub fn new(
        model: &'a Model,
        geometry: &Geometry,
        limits: &'a Limits,
        region: &'a Region,
        clearance: f64,
        other: Option<OtherFoot>,
    ) -> Scene<'a> {
        let rest = limits.rest();
        let both_feet = other.and_then(|other| BothFeet::new(model, other, &rest));
        let standing = both_feet.as_ref().map(|feet| feet.body);
        Scene {
            clearance: Clearance::new(model, geometry, clearance, standing),
            collisions: Collisions::new(model, geometry, &rest),
            uncertainty: DMatrix::zeros(model.base.params.len(), 0),
            sigmas: 0.0,
            both_feet,
            region,
            limits,
            model,
        }
    }
}
