//! From where a robot is seen, and how large.
//!
//! ```text
//! place = origin + scale (p · right, −p · up)        pixels, without perspective
//! ```

use super::super::super::svg::Place;
use sesc_identify::skeleton::{Placed, Skeleton};

/// Directions of a picture in the support frame, each of length one.
#[derive(Clone, Copy)]
pub struct Camera {
    pub right: [f64; 3],
    pub up: [f64; 3],
    /// From the robot to the viewer.
    pub near: [f64; 3],
}

/// From before the robot: its left is on the right.
pub const FRONT: Camera = Camera {
    right: [0.0, 1.0, 0.0],
    up: [0.0, 0.0, 1.0],
    near: [1.0, 0.0, 0.0],
};
/// From its right side: it looks to the right.
pub const SIDE: Camera = Camera {
    right: [1.0, 0.0, 0.0],
    up: [0.0, 0.0, 1.0],
    near: [0.0, -1.0, 0.0],
};
/// From before, its right and above: azimuth −40°, elevation 14°.
pub const CORNER: Camera = Camera {
    right: [0.642_787_6, 0.766_044_4, 0.0],
    up: [-0.185_322_5, 0.155_504_0, 0.970_295_7],
    near: [0.743_289_7, -0.623_694_1, 0.241_921_9],
};

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Camera {
    /// How near to the viewer a point is, m.
    pub fn depth(&self, point: [f64; 3]) -> f64 {
        dot(self.near, point)
    }

    /// Least and greatest coordinates of the picture, m: of all that is drawn of the robot and
    /// of the ground under it.
    pub fn extent<'s>(
        &self,
        skeleton: &'s Skeleton,
        placed: impl IntoIterator<Item = Placed<'s>>,
    ) -> [[f64; 2]; 2] {
        let mut ends = [[0.0_f64; 2]; 2];
        let mut hold = |point: [f64; 3], radius: f64| {
            for (axis, along) in [self.right, self.up].into_iter().enumerate() {
                let at = dot(point, along);
                if at.is_finite() {
                    ends[0][axis] = ends[0][axis].min(at - radius);
                    ends[1][axis] = ends[1][axis].max(at + radius);
                }
            }
        };
        for corner in &skeleton.sole {
            hold([corner[0], corner[1], 0.0], 0.0);
        }
        for placed in placed {
            for capsule in &skeleton.capsules {
                for end in placed.ends(capsule) {
                    hold(end, capsule.radius);
                }
            }
        }
        ends
    }
}

/// A camera that fits into a figure.
pub struct View {
    pub camera: Camera,
    /// Pixels per metre.
    pub scale: f64,
    /// Where the origin of the support frame is, pixels.
    pub origin: Place,
}

impl View {
    /// Everything within `extent` (m), in the middle between two edges and on a lower one, pixels.
    pub fn new(
        camera: Camera,
        [low, high]: [[f64; 2]; 2],
        scale: f64,
        [left, right, bottom]: [f64; 3],
    ) -> View {
        let middle = (low[0] + high[0]) / 2.0;
        View {
            camera,
            scale,
            origin: [
                (left + right) / 2.0 - scale * middle,
                bottom + scale * low[1],
            ],
        }
    }

    /// Where a point is drawn.
    pub fn at(&self, point: [f64; 3]) -> Place {
        [
            self.origin[0] + self.scale * dot(point, self.camera.right),
            self.origin[1] - self.scale * dot(point, self.camera.up),
        ]
    }
}

/// The largest scale at which all extents (m) fit into a box of this size, pixels per metre.
pub fn scale(extents: &[[[f64; 2]; 2]], size: [f64; 2]) -> f64 {
    let fits = extents.iter().flat_map(|[low, high]| {
        (0..2).map(move |axis| size[axis] / (high[axis] - low[axis]).max(1e-6))
    });
    fits.fold(f64::INFINITY, f64::min)
}
