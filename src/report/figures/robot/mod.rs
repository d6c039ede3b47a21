//! The robot, made from its URDF alone: links as capsules, joints as dots, the CoM with its
//! projection on the ground, and the CoP of postures.
//!
//! A script finds parts by their attributes and moves them: `data-c` is the place of a
//! capsule, `data-j` that of a body whose joint a dot is.

mod camera;
mod draw;
mod sheet;
#[cfg(test)]
mod tests;

use super::super::svg::{Anchor, Figure, INK, MUTED};
use camera::{Camera, FRONT, SIDE, View};
use draw::Drawing;
use sesc_identify::skeleton::Skeleton;

pub use sheet::sheet;

/// Size of a picture and what it keeps free at its edges, pixels.
const WIDTH: f64 = 320.0;
const TALLEST: f64 = 306.0;
const EDGES: [f64; 3] = [14.0, 34.0, 306.0];
/// What is beside it is not higher.
const LOWEST: f64 = 276.0;
/// Under the robot: the floor, its sides and a scale.
const UNDER: f64 = 30.0;

/// What a figure points at.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Marks {
    /// Bodies whose joint is meant, with a name.
    pub joints: Vec<(usize, String)>,
    /// Links that are meant.
    pub links: Vec<String>,
    /// Every joint is meant.
    pub every_joint: bool,
    /// How far links moved, 0 to 1.
    pub moved: Vec<(String, f64)>,
    /// CoMs that moved, from and to in a body, m.
    pub arrows: Vec<(usize, [[f64; 3]; 2])>,
}

/// The robot in one posture.
pub struct Pictured<'s> {
    /// What is drawn.
    pub skeleton: &'s Skeleton,
    /// All postures that it may be shown in, rad or m.
    pub postures: Vec<&'s [f64]>,
    /// The one that is drawn.
    pub shown: usize,
    /// CoP of postures, m.
    pub cop: Vec<[f64; 2]>,
    /// What is pointed at.
    pub marks: Marks,
}

impl Pictured<'_> {
    /// From before and from its right side, at one scale.
    pub fn views(&self) -> [String; 2] {
        let cameras = [FRONT, SIDE];
        let all = || self.postures.iter().map(|q| self.skeleton.place(q));
        let extents = cameras.map(|camera: Camera| camera.extent(self.skeleton, all()));
        let [left, top, right] = EDGES;
        let scale = camera::scale(&extents, [right - left, TALLEST]);
        let tall = extents.iter().map(|[low, high]| scale * (high[1] - low[1]));
        let bottom = top + tall.fold(LOWEST, f64::max);
        let picture = |k: usize| {
            let name = ["From the front", "From its right"][k];
            let posture = match self.postures.as_slice() {
                [[]] => "with all joints at zero".to_string(),
                several => format!("in one of {} postures", several.len()),
            };
            let label = format!(
                "{name}: {} standing on {} {posture}, with its centre of mass",
                self.skeleton.robot, self.skeleton.support
            );
            let mut figure = Figure::new([WIDTH, bottom + UNDER], &label);
            figure.title(13.0, name);
            let view = View::new(cameras[k], extents[k], scale, [left, right, bottom]);
            let drawing = Drawing {
                pictured: self,
                view: &view,
            };
            drawing.draw(&mut figure);
            let axis = [["its right", "its left"], ["back", "front"]][k];
            let low = bottom + 18.0;
            figure.note([left, low], Anchor::Start, MUTED, axis[0]);
            figure.note([right, low], Anchor::End, MUTED, axis[1]);
            if k == 0 {
                let length = bar(scale);
                let middle = (left + right) / 2.0;
                let half = scale * length / 2.0;
                figure.line(
                    [[middle - half, low + 7.0], [middle + half, low + 7.0]],
                    INK,
                    1.5,
                );
                let text = format!("{:.0} mm", 1e3 * length);
                figure.note([middle, low - 2.0], Anchor::Middle, INK, &text);
            }
            figure.finish()
        };
        [picture(0), picture(1)]
    }
}

/// A round length that a scale bar shows, m.
fn bar(scale: f64) -> f64 {
    let lengths = [2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01];
    let fits = |length: &f64| scale * length <= 90.0;
    lengths.into_iter().find(fits).unwrap_or(0.01)
}
