//! Masses and inertias that no body of a link's size has.
//!
//! ```text
//! λ₁ ≥ 0,  λ₃ ≤ λ₁ + λ₂        of every body
//! √(λ₃/m) ≤ the diagonal of the link's shape, and ≤ the length of the robot's longest chain
//! one inertia on most links, of unlike masses: a placeholder
//! ```

use std::collections::HashMap;

use nalgebra::{Matrix3, Vector3};

use super::description::{Description, Link};

/// Rounding of printed inertias breaks the triangle inequality by less, as a part of λ₃.
const ROUNDING: f64 = 0.02;
/// A mass so many times as heavy as all links beside it was hardly given in kg.
const HEAVIER: f64 = 1000.0;

impl Description {
    /// Links whose inertia no body of their mass and size has, each with the reason; in document
    /// order. Motion counts such a link as a point at its centre of mass.
    pub fn refuted_inertias(&self) -> Vec<(usize, String)> {
        let size = self.longest_chain();
        let placeholder = self.placeholder();
        let of = |k: usize, link: &Link| {
            let own = link.inertial;
            let has = own.mass_kg > 0.0 && own.inertia.iter().any(|entry| *entry != 0.0);
            if !has {
                return None;
            }
            let [xx, xy, xz, yy, yz, zz] = own.inertia;
            let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
            let mut own_values: Vec<f64> =
                inertia.symmetric_eigenvalues().iter().copied().collect();
            own_values.sort_by(f64::total_cmp);
            let [least, middle, most] = own_values[..] else {
                return None;
            };
            let radius = (most.max(0.0) / own.mass_kg).sqrt();
            let shape = self.shapes.get(k).copied().flatten().map(|shape| {
                let size = Vector3::from(shape.high) - Vector3::from(shape.low);
                size.norm()
            });
            Some(if least < -ROUNDING * most || most <= 0.0 {
                format!("has a negative principal moment, {least:.1e} kg m²")
            } else if most > (1.0 + ROUNDING) * (least + middle) {
                format!(
                    "has a principal moment of {most:.1e} kg m², more than the sum of the other two"
                )
            } else if size.is_some_and(|size| radius > size) {
                format!("has a radius of gyration of {radius:.2} m, longer than the robot's chains")
            } else if shape.is_some_and(|size| radius > size) {
                format!("has a radius of gyration of {radius:.2} m, larger than its shape")
            } else if placeholder == Some(own.inertia) {
                "is that of most links, whatever their mass: a placeholder".to_string()
            } else {
                return None;
            })
        };
        let links = self.links.iter().enumerate();
        links
            .filter_map(|(k, link)| Some((k, of(k, link)?)))
            .collect()
    }

    /// The inertia that more than half of the links with mass have, three at least, and not all
    /// of one mass.
    fn placeholder(&self) -> Option<[f64; 6]> {
        let mut masses: HashMap<[u64; 6], (Vec<f64>, [f64; 6])> = HashMap::new();
        let heavy = self.links.iter().map(|link| link.inertial);
        let heavy = heavy.filter(|own| own.mass_kg > 0.0);
        let count = heavy.clone().count();
        for own in heavy {
            let key = own.inertia.map(f64::to_bits);
            let of = masses.entry(key).or_insert((Vec::new(), own.inertia));
            of.0.push(own.mass_kg);
        }
        let most = masses.into_values().max_by_key(|(own, _)| own.len());
        let (own, inertia) = most.filter(|(own, _)| own.len() > 2 && 2 * own.len() > count)?;
        own.iter().any(|mass| *mass != own[0]).then_some(inertia)
    }

    /// The length of the longest chain of joints from the root, m: no robot is larger than twice
    /// that, and none of its links turns about more. None of a robot whose joints all are in one
    /// point.
    fn longest_chain(&self) -> Option<f64> {
        let length = |xyz: [f64; 3]| Vector3::from(xyz).norm();
        let carrier: HashMap<&str, usize> = self
            .joints
            .iter()
            .enumerate()
            .map(|(k, joint)| (joint.child.as_str(), k))
            .collect();
        let mut reach: HashMap<&str, f64> = HashMap::new();
        let mut longest = 0.0_f64;
        for link in &self.links {
            // Up to a link whose distance is known, and down again.
            let mut path = Vec::new();
            let mut at = link.name.as_str();
            while let (None, Some(&joint)) = (reach.get(at), carrier.get(at)) {
                path.push(joint);
                at = &self.joints[joint].parent;
            }
            let mut far = reach.get(at).copied().unwrap_or(0.0);
            reach.insert(at, far);
            for joint in path.into_iter().rev().map(|joint| &self.joints[joint]) {
                far += length(joint.origin.xyz);
                reach.insert(&joint.child, far);
            }
            longest = longest.max(far + length(link.inertial.origin.xyz));
        }
        (longest > 0.0).then_some(longest)
    }

    /// What is doubtful about masses and inertias, for notes.
    pub(super) fn doubts(&self) -> Vec<String> {
        let refuted = self.refuted_inertias().into_iter().map(|(k, why)| {
            let link = &self.links[k].name;
            format!(
                "{}: link `{link}`: its inertia {why}; motion counts the link as a point",
                self.file
            )
        });
        let index: HashMap<&str, usize> = self.link_names().zip(0..).collect();
        let mut beside = vec![0.0_f64; self.links.len()];
        for joint in &self.joints {
            let ends = [
                index.get(joint.parent.as_str()),
                index.get(joint.child.as_str()),
            ];
            if let [Some(&parent), Some(&child)] = ends {
                for (own, other) in [(parent, child), (child, parent)] {
                    beside[own] = beside[own].max(self.links[other].inertial.mass_kg);
                }
            }
        }
        let heavy = self.links.iter().zip(&beside).filter_map(|(link, beside)| {
            let mass = link.inertial.mass_kg;
            (*beside > 0.0 && mass > HEAVIER * beside).then(|| {
                format!(
                    "{}: link `{}`: its mass of {mass} kg is {:.0} times that of every link beside it; \
                     is it in grams?",
                    self.file,
                    link.name,
                    mass / beside
                )
            })
        });
        refuted.chain(heavy).collect()
    }
}
