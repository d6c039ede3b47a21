//! A contact sheet: the robot in many postures, small, in the order to take them.

use super::super::super::svg::{Figure, GRID, INK, MUTED, PAPER};
use super::camera::{CORNER, View, scale};
use sesc_identify::skeleton::{Part, Skeleton};

/// Size of a picture, pixels.
const WIDTH: f64 = 112.0;
const TALLEST: f64 = 150.0;
const EDGES: [f64; 3] = [4.0, 18.0, 108.0];

/// A picture of each posture (rad or m), all at one scale.
pub fn sheet(skeleton: &Skeleton, postures: &[&[f64]]) -> Vec<String> {
    let extent = |q: &&[f64]| CORNER.extent(skeleton, [skeleton.place(q)]);
    let extents: Vec<[[f64; 2]; 2]> = postures.iter().map(extent).collect();
    let [left, top, right] = EDGES;
    let scale = scale(&extents, [right - left, TALLEST]);
    // All stand on one level, each in the middle of its picture.
    let ends = |pick: fn(f64, f64) -> f64, end: usize| {
        extents.iter().map(|extent| extent[end][1]).fold(0.0, pick)
    };
    let (low, high) = (ends(f64::min, 0), ends(f64::max, 1));
    let bottom = top + scale * (high - low);
    let picture = |(k, q): (usize, &&[f64])| {
        let [[west, _], [east, _]] = extents[k];
        let own = [[west, low], [east, high]];
        let view = View::new(CORNER, own, scale, [left, right, bottom]);
        let label = format!("posture {}", k + 1);
        let mut figure = Figure::plain([WIDTH, bottom + 6.0], &label);
        let placed = skeleton.place(q);
        let sole: Vec<_> = (skeleton.sole.iter())
            .map(|[x, y]| view.at([*x, *y, 0.0]))
            .collect();
        if sole.len() > 2 {
            figure.polygon(&sole, MUTED);
        }
        let mut order: Vec<(f64, usize)> = (skeleton.capsules.iter().enumerate())
            .filter(|(_, capsule)| capsule.part == Part::Link)
            .map(|(k, capsule)| {
                let [a, b] = placed.ends(capsule).map(|end| CORNER.depth(end));
                (a + b, k)
            })
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        for bone in skeleton.capsules.iter().filter(|c| c.part == Part::Bone) {
            let ends = placed.ends(bone).map(|end| view.at(end));
            figure.capsule(ends, 2.5, MUTED);
        }
        for (_, k) in order {
            let capsule = &skeleton.capsules[k];
            let ends = placed.ends(capsule).map(|end| view.at(end));
            let width = (2.0 * scale * capsule.radius).max(2.0);
            figure.capsule(ends, width + 1.6, MUTED);
            figure.capsule(ends, width, GRID);
        }
        let com = placed.com();
        let (at, foot) = (view.at(com), view.at([com[0], com[1], 0.0]));
        figure.dashed([at, foot], INK, 1.0);
        figure.dot(at, 3.4, PAPER);
        figure.dot(at, 2.4, INK);
        figure.finish()
    };
    postures.iter().enumerate().map(picture).collect()
}
