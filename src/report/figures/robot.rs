//! The robot, made from its URDF alone: links as capsules, joints as dots, the CoM with its
//! projection on the ground, and the CoP of postures.
//!
//! A script finds parts by their attributes and moves them: `data-c` is the place of a
//! capsule, `data-j` that of a body whose joint a dot is.

#[cfg(test)]
mod tests;

use super::super::svg::{
    Anchor, BAND, BLUE, Color, Figure, GRID, INK, MUTED, NAME, ORANGE, PAPER, Place, text_width,
};
use sesc_identify::skeleton::{Capsule, Part, Placed, Skeleton};

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
        let scale = scale(&extents, [right - left, TALLEST]);
        let tall = extents.iter().map(|[low, high]| scale * (high[1] - low[1]));
        let bottom = top + tall.fold(LOWEST, f64::max);
        let posture = match self.postures.as_slice() {
            [[]] => "with all joints at zero".to_string(),
            several => format!("in one of {} postures", several.len()),
        };
        [0, 1].map(|k| {
            let name = ["From the front", "From its right"][k];
            let label = format!(
                "{name}: {} standing on {} {posture}, with its centre of mass",
                self.skeleton.robot, self.skeleton.support
            );
            let mut figure = Figure::new([WIDTH, bottom + UNDER], &label);
            figure.title(13.0, name);
            let view = View::new(cameras[k], extents[k], scale, [left, right, bottom]);
            self.draw(&mut figure, &view);
            let axis = [["its right", "its left"], ["back", "front"]][k];
            let low = bottom + 18.0;
            figure.note([left, low], Anchor::Start, MUTED, axis[0]);
            figure.note([right, low], Anchor::End, MUTED, axis[1]);
            if k == 0 {
                let length = bar(scale);
                let middle = (left + right) / 2.0;
                let ends = [-0.5, 0.5].map(|half| [middle + half * scale * length, low + 7.0]);
                figure.line(ends, INK, 1.5);
                let text = format!("{:.0} mm", 1e3 * length);
                figure.note([middle, low - 2.0], Anchor::Middle, INK, &text);
            }
            figure.finish()
        })
    }
}

/// A round length that a scale bar shows, m.
fn bar(scale: f64) -> f64 {
    let lengths = [2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01];
    let fits = |length: &f64| scale * length <= 90.0;
    lengths.into_iter().find(fits).unwrap_or(0.01)
}

// From where a robot is seen, and how large.
//
// ```text
// place = origin + scale (p · right, −p · up)        pixels, without perspective
// ```

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
    /// Capsules of the robot, the farthest from the viewer first.
    fn farthest_first<'s>(
        &self,
        skeleton: &'s Skeleton,
        placed: &Placed,
    ) -> Vec<(usize, &'s Capsule)> {
        let depth = |capsule: &Capsule| {
            let [a, b] = placed.ends(capsule).map(|end| dot(self.near, end));
            a + b
        };
        let mut all: Vec<(usize, &Capsule)> = skeleton.capsules.iter().enumerate().collect();
        all.sort_by(|(_, a), (_, b)| depth(a).total_cmp(&depth(b)));
        all
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
        let x = (left + right) / 2.0 - scale * (low[0] + high[0]) / 2.0;
        let origin = [x, bottom + scale * low[1]];
        View {
            camera,
            scale,
            origin,
        }
    }

    /// Where a point is drawn.
    pub fn at(&self, point: [f64; 3]) -> Place {
        [
            self.origin[0] + self.scale * dot(point, self.camera.right),
            self.origin[1] - self.scale * dot(point, self.camera.up),
        ]
    }

    /// A capsule with an edge of so many pixels around it.
    fn capsule(
        &self,
        figure: &mut Figure,
        ends: [[f64; 3]; 2],
        radius: f64,
        (color, edge): (Color, Color),
        wide: f64,
    ) {
        let ends = ends.map(|end| self.at(end));
        let width = (2.0 * self.scale * radius).max(2.0);
        figure.capsule(ends, width + wide, edge);
        figure.capsule(ends, width, color);
    }
}

/// The largest scale at which all extents (m) fit into a box of this size, pixels per metre.
pub fn scale(extents: &[[[f64; 2]; 2]], size: [f64; 2]) -> f64 {
    let fits = extents.iter().flat_map(|[low, high]| {
        (0..2).map(move |axis| size[axis] / (high[axis] - low[axis]).max(1e-6))
    });
    fits.fold(f64::INFINITY, f64::min)
}

// One picture of a robot, the farthest parts first.

/// Arrows of CoMs are this long at most, pixels.
const ARROW: f64 = 46.0;

impl Pictured<'_> {
    fn draw(&self, figure: &mut Figure, view: &View) {
        let skeleton = self.skeleton;
        let q = self.postures.get(self.shown);
        let placed = skeleton.place(q.copied().unwrap_or_default());
        self.ground(figure, view);
        let Camera { right, up, near } = view.camera;
        let of = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
        let attributes = format!(
            "data-view=\"{} {} {} {:.3} {:.2} {:.2}\"",
            of(right),
            of(up),
            of(near),
            view.scale,
            view.origin[0],
            view.origin[1]
        );
        figure.group(&attributes, |figure| {
            for (k, capsule) in view.camera.farthest_first(skeleton, &placed) {
                let (ends, colors) = (placed.ends(capsule), self.colors(capsule));
                figure.group(&format!("data-c=\"{k}\""), |figure| {
                    view.capsule(figure, ends, capsule.radius, colors, 2.0);
                });
            }
            self.joints(figure, view, &placed);
            self.centre(figure, view, &placed);
        });
        self.moved(figure, view, &placed);
        self.names(figure, view, &placed);
    }

    /// The floor, and where on it the CoP was.
    fn ground(&self, figure: &mut Figure, view: &View) {
        let level = view.at([0.0; 3])[1];
        figure.fill([[EDGES[0], level], [EDGES[2], level + 5.0]], GRID, 1.0);
        let along = |[x, y]: &[f64; 2]| view.at([*x, *y, 0.0])[0];
        let sole = self.skeleton.sole.iter().map(along);
        let low = sole.clone().fold(f64::INFINITY, f64::min);
        let high = sole.fold(f64::NEG_INFINITY, f64::max);
        if high > low {
            figure.fill([[low, level], [high, level + 5.0]], MUTED, 1.0);
        }
        for at in &self.cop {
            figure.dot([along(at), level + 2.5], 1.2, INK);
        }
    }

    /// Colour of a capsule and of its edge.
    fn colors(&self, capsule: &Capsule) -> (Color, Color) {
        let marks = &self.marks;
        let moved = marks.moved.iter().find(|(link, _)| *link == capsule.link);
        match (capsule.part, moved) {
            (Part::Bone, _) => (BAND, MUTED),
            _ if marks.links.contains(&capsule.link) => (ORANGE, INK),
            (_, Some((_, by))) if *by >= 1.0 => (BLUE, INK),
            (_, Some((_, by))) if *by > 0.0 => (PALE, BLUE),
            _ => (GRID, MUTED),
        }
    }

    fn joints(&self, figure: &mut Figure, view: &View, placed: &Placed<'_>) {
        let marks = &self.marks;
        for (k, body) in self.skeleton.bodies.iter().enumerate() {
            let Some(joint) = &body.joint else {
                continue;
            };
            let at = view.at(placed.joint(k));
            let meant = marks.every_joint || marks.joints.iter().any(|(own, _)| *own == k);
            figure.group(&format!("data-j=\"{k}\""), |figure| {
                figure.called(joint);
                let dots: &[_] = match meant {
                    true => &[(8.5, PAPER), (7.0, ORANGE), (2.2, PAPER)],
                    false => &[(3.0, PAPER), (2.0, INK)],
                };
                for (radius, color) in dots {
                    figure.dot(at, *radius, *color);
                }
            });
        }
    }

    /// The CoM as it is drawn on blueprints, and the plumb line under it.
    fn centre(&self, figure: &mut Figure, view: &View, placed: &Placed<'_>) {
        let com = placed.com();
        let at = view.at(com);
        let foot = view.at([com[0], com[1], 0.0]);
        figure.group("data-drop=\"\"", |figure| {
            figure.dashed([at, foot], INK, 1.25);
        });
        figure.group("data-com=\"\"", |figure| figure.centre_of_mass(at));
    }

    /// Arrows from where CoMs were to where they are, drawn longer.
    fn moved(&self, figure: &mut Figure, view: &View, placed: &Placed<'_>) {
        let by = |[from, to]: &[[f64; 3]; 2]| [0, 1, 2].map(|axis| to[axis] - from[axis]);
        let arrows = &self.marks.arrows;
        let lengths = arrows
            .iter()
            .map(|(_, ends)| dot(by(ends), by(ends)).sqrt());
        let longest = lengths.fold(0.0, f64::max);
        if longest <= 0.0 || !longest.is_finite() {
            return;
        }
        let gain = ARROW / (view.scale * longest);
        for (body, ends @ [from, _]) in arrows {
            let tip = [0, 1, 2].map(|axis| from[axis] + gain * by(ends)[axis]);
            let [tail, tip] = [*from, tip].map(|end| [end, placed.point(*body, end)]);
            let ends = [tail[0], tip[0]].map(|[x, y, z]| format!("{x:.5} {y:.5} {z:.5}"));
            let attributes = format!("data-a=\"{body} {}\"", ends.join(" "));
            figure.group(&attributes, |figure| {
                figure.arrow(view.at(tail[1]), view.at(tip[1]), ORANGE);
            });
        }
    }

    /// Names of the joints and links that are meant, beside them and apart from each other.
    fn names(&self, figure: &mut Figure, view: &View, placed: &Placed<'_>) {
        let mut taken: Vec<f64> = Vec::new();
        let marks = &self.marks;
        // A joint is the origin of its body.
        let joints = marks.joints.iter();
        let joints = joints.map(|(body, name)| (*body, name, [0.0; 3]));
        let links = marks.links.iter().filter_map(|name| {
            let own = |capsule: &&Capsule| capsule.part == Part::Link && capsule.link == *name;
            let capsule = self.skeleton.capsules.iter().find(own)?;
            let [a, b] = capsule.ends;
            let middle = [0, 1, 2].map(|axis| (a[axis] + b[axis]) / 2.0);
            Some((capsule.body, name, middle))
        });
        for (body, name, point) in joints.chain(links) {
            let [at, mut y] = view.at(placed.point(body, point));
            let wide = text_width(name) * 1.08;
            let (x, anchor) = match at + 14.0 + wide < WIDTH - 4.0 {
                true => (at + 14.0, Anchor::Start),
                false => ((at - 14.0).max(wide + 4.0), Anchor::End),
            };
            while taken.iter().any(|other| (other - y).abs() < 15.0) {
                y += 15.0;
            }
            taken.push(y);
            let [px, py, pz] = point;
            let attributes = format!("data-n=\"{body} {px:.5} {py:.5} {pz:.5}\"");
            figure.group(&attributes, |figure| {
                figure.haloed([x, y], anchor, NAME, INK, name);
            });
        }
    }
}

/// A link that moved a little.
const PALE: Color = BAND;

// A contact sheet: the robot in many postures, small, in the order to take them.

/// Size of a picture, pixels.
const SHEET_WIDTH: f64 = 112.0;
const SHEET_TALLEST: f64 = 150.0;
const SHEET_EDGES: [f64; 3] = [4.0, 18.0, 108.0];

/// A picture of each posture (rad or m), all at one scale.
pub fn sheet(skeleton: &Skeleton, postures: &[&[f64]]) -> Vec<String> {
    let extent = |q: &&[f64]| CORNER.extent(skeleton, [skeleton.place(q)]);
    let extents: Vec<[[f64; 2]; 2]> = postures.iter().map(extent).collect();
    let [left, top, right] = SHEET_EDGES;
    let scale = scale(&extents, [right - left, SHEET_TALLEST]);
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
        let mut figure = Figure::plain([SHEET_WIDTH, bottom + 6.0], &label);
        let placed = skeleton.place(q);
        let sole = skeleton.sole.iter().map(|[x, y]| view.at([*x, *y, 0.0]));
        let sole: Vec<Place> = sole.collect();
        if sole.len() > 2 {
            figure.polygon(&sole, MUTED);
        }
        for bone in skeleton.capsules.iter().filter(|c| c.part == Part::Bone) {
            let ends = placed.ends(bone).map(|end| view.at(end));
            figure.capsule(ends, 2.5, MUTED);
        }
        for (_, capsule) in CORNER.farthest_first(skeleton, &placed) {
            if capsule.part == Part::Link {
                let ends = placed.ends(capsule);
                view.capsule(&mut figure, ends, capsule.radius, (GRID, MUTED), 1.6);
            }
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
