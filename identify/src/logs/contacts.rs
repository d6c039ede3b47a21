//! The CoP of two contacts together, from that of each.
//!
//! ```text
//! p = (1 − s) p₁ + s T(q) p₂        s = F₂ / (F₁ + F₂)
//! ```
//!
//! T places the other sole in the support frame; the robot knows it, a log does not.

use std::fmt::Debug;
use std::sync::Arc;

use super::block::Block;

/// Where soles are against each other.
pub trait Soles: Debug + Send + Sync {
    /// x and y of the point `at` (m) on the sole of link `of`, seen from link `from`, where joints
    /// are at `q` (rad or m); none where nothing that a log knows holds the two together.
    fn seen(&self, q: &[f64], from: &str, of: &str, at: [f64; 2]) -> Option<[f64; 2]>;

    /// Axes and origin (m) of link `of` in the frame of link `from`, where both are of one rigid
    /// body.
    fn fixed(&self, from: &str, of: &str) -> Option<Frame>;
}

/// Axes, as columns, and origin of a frame in another one, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Its axes in the other frame.
    pub axes: [[f64; 3]; 3],
    /// m
    pub origin: [f64; 3],
}

impl Frame {
    /// A point of this frame in the other one, m.
    pub fn placed(&self, own: [f64; 3]) -> [f64; 3] {
        let turned = self.turned(own);
        [0, 1, 2].map(|k| self.origin[k] + turned[k])
    }

    /// A vector in the other frame.
    pub fn turned(&self, own: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (0..3).map(|axis| self.axes[axis][k] * own[axis]).sum())
    }

    /// A wrench about the origin of this frame as one about that of the other.
    pub fn moved(&self, [force, torque]: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
        let (force, torque) = (self.turned(force), self.turned(torque));
        let at = self.origin;
        let of = |a: usize, b: usize| at[a] * force[b] - at[b] * force[a];
        let moment = [of(1, 2), of(2, 0), of(0, 1)];
        [force, [0, 1, 2].map(|k| torque[k] + moment[k])]
    }
}

/// Two links that both stand on the ground: the support, and the other.
#[derive(Debug, Clone)]
pub(super) struct Standing {
    pub soles: Arc<dyn Soles>,
    pub links: [String; 2],
}

/// What the other contact has of the load, and its CoP on its own sole, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Share {
    pub share: f64,
    pub cop: [f64; 2],
}

impl Standing {
    /// Add the other contact to readings of the support's, rows of a block from `first` on.
    pub fn join(&self, others: &[Share], block: &mut Block, first: usize) {
        let dof = block.q.len() / block.len().max(1);
        let Some(readings) = &mut block.reading else {
            return;
        };
        let [from, of] = &self.links;
        for (k, other) in others.iter().enumerate() {
            let row = first + k;
            let q = &block.q[row * dof..(row + 1) * dof];
            let seen = self.soles.seen(q, from, of, other.cop);
            if let (Some(seen), Some(own)) = (seen, readings.get_mut(row)) {
                let both = |axis: usize| own[axis] + other.share * (seen[axis] - own[axis]);
                *own = [both(0), both(1)];
            }
        }
        let weighed = |other: &Share| {
            let [x, y] = other.cop.map(|x| other.share * x);
            [other.share, x, y]
        };
        let contacts = block.other.get_or_insert_default();
        contacts.extend(others.iter().map(weighed));
    }
}
