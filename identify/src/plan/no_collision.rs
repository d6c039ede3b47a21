//! Without the feature `collision`: no body is watched.

use sesc_model::Model;

use super::geometry::Geometry;
use crate::poses::Pose;

/// Stands in for the collision check where the feature is off: nothing collides.
pub struct Collisions {
    /// Pairs of bodies that touch at rest: none is known.
    pub exempt: Vec<[String; 2]>,
}

impl Collisions {
    /// No pairs of bodies.
    pub fn new(_: &Model, _: &Geometry, _: &[f64]) -> Collisions {
        Collisions { exempt: Vec::new() }
    }

    /// No two bodies meet.
    pub fn first(&self, _: &[Pose]) -> Option<(usize, usize)> {
        None
    }

    /// Whether any bodies are watched.
    pub fn is_checked(&self) -> bool {
        false
    }

    /// What is watched, in words.
    pub fn sentence(&self) -> String {
        "not checked: built without the feature `collision`".to_string()
    }
}
