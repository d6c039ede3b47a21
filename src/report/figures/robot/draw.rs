//! One picture of a robot, the farthest parts first.

use super::super::super::svg::{
    Anchor, BAND, BLUE, Color, Figure, GRID, INK, MUTED, NAME, ORANGE, PAPER, text_width,
};
use super::camera::View;
use super::{EDGES, Pictured, WIDTH};
use sesc_identify::skeleton::{Capsule, Part, Placed};

/// Arrows of CoMs are this long at most, pixels.
const ARROW: f64 = 46.0;

pub struct Drawing<'a, 's> {
    pub pictured: &'a Pictured<'s>,
    pub view: &'a View,
}

impl Drawing<'_, '_> {
    pub fn draw(&self, figure: &mut Figure) {
        let skeleton = self.pictured.skeleton;
        let q = self.pictured.postures.get(self.pictured.shown);
        let placed = skeleton.place(q.copied().unwrap_or_default());
        self.ground(figure);
        let camera = &self.view.camera;
        let (right, up, near) = (camera.right, camera.up, camera.near);
        let of = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
        let attributes = format!(
            "data-view=\"{} {} {} {:.3} {:.2} {:.2}\"",
            of(right),
            of(up),
            of(near),
            self.view.scale,
            self.view.origin[0],
            self.view.origin[1]
        );
        figure.group(&attributes, |figure| {
            let mut order: Vec<(f64, usize)> = (skeleton.capsules.iter().enumerate())
                .map(|(k, capsule)| (depth(self.view, &placed, capsule), k))
                .collect();
            order.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (_, k) in order {
                self.capsule(figure, &placed, k);
            }
            self.joints(figure, &placed);
            self.centre(figure, &placed);
        });
        self.moved(figure, &placed);
        self.names(figure, &placed);
    }

    /// The floor, and where on it the CoP was.
    fn ground(&self, figure: &mut Figure) {
        let level = self.view.at([0.0; 3])[1];
        figure.fill([[EDGES[0], level], [EDGES[2], level + 5.0]], GRID, 1.0);
        let sole = &self.pictured.skeleton.sole;
        let along: Vec<f64> = (sole.iter())
            .map(|[x, y]| self.view.at([*x, *y, 0.0])[0])
            .collect();
        let low = along.iter().copied().fold(f64::INFINITY, f64::min);
        let high = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if high > low {
            figure.fill([[low, level], [high, level + 5.0]], MUTED, 1.0);
        }
        for [x, y] in &self.pictured.cop {
            figure.dot([self.view.at([*x, *y, 0.0])[0], level + 2.5], 1.2, INK);
        }
    }

    fn capsule(&self, figure: &mut Figure, placed: &Placed<'_>, k: usize) {
        let capsule = &self.pictured.skeleton.capsules[k];
        let ends = placed.ends(capsule).map(|end| self.view.at(end));
        let width = (2.0 * self.view.scale * capsule.radius).max(2.0);
        let (color, edge) = self.colors(capsule);
        figure.group(&format!("data-c=\"{k}\""), |figure| {
            figure.capsule(ends, width + 2.0, edge);
            figure.capsule(ends, width, color);
        });
    }

    /// Colour of a capsule and of its edge.
    fn colors(&self, capsule: &Capsule) -> (Color, Color) {
        let marks = &self.pictured.marks;
        let moved = marks.moved.iter().find(|(link, _)| *link == capsule.link);
        match (capsule.part, moved) {
            (Part::Bone, _) => (BAND, MUTED),
            _ if marks.links.contains(&capsule.link) => (ORANGE, INK),
            (_, Some((_, by))) if *by >= 1.0 => (BLUE, INK),
            (_, Some((_, by))) if *by > 0.0 => (PALE, BLUE),
            _ => (GRID, MUTED),
        }
    }

    fn joints(&self, figure: &mut Figure, placed: &Placed<'_>) {
        let marks = &self.pictured.marks;
        for (k, body) in self.pictured.skeleton.bodies.iter().enumerate() {
            let Some(joint) = &body.joint else {
                continue;
            };
            let at = self.view.at(placed.joint(k));
            let meant = marks.every_joint || marks.joints.iter().any(|(own, _)| *own == k);
            figure.group(&format!("data-j=\"{k}\""), |figure| {
                figure.called(joint);
                match meant {
                    true => {
                        figure.dot(at, 8.5, PAPER);
                        figure.dot(at, 7.0, ORANGE);
                        figure.dot(at, 2.2, PAPER);
                    }
                    false => {
                        figure.dot(at, 3.0, PAPER);
                        figure.dot(at, 2.0, INK);
                    }
                }
            });
        }
    }

    /// The CoM as it is drawn on blueprints, and the plumb line under it.
    fn centre(&self, figure: &mut Figure, placed: &Placed<'_>) {
        let com = placed.com();
        let at = self.view.at(com);
        let foot = self.view.at([com[0], com[1], 0.0]);
        figure.group("data-drop=\"\"", |figure| {
            figure.dashed([at, foot], INK, 1.25);
        });
        figure.group("data-com=\"\"", |figure| figure.centre_of_mass(at));
    }

    /// Arrows from where CoMs were to where they are, drawn longer.
    fn moved(&self, figure: &mut Figure, placed: &Placed<'_>) {
        let arrows = &self.pictured.marks.arrows;
        let length = |[from, to]: &[[f64; 3]; 2]| {
            (0..3)
                .map(|axis| (to[axis] - from[axis]).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let longest = arrows
            .iter()
            .map(|(_, ends)| length(ends))
            .fold(0.0, f64::max);
        if longest <= 0.0 || !longest.is_finite() {
            return;
        }
        let gain = ARROW / (self.view.scale * longest);
        for (body, [from, to]) in arrows {
            let tip = [0, 1, 2].map(|axis| from[axis] + gain * (to[axis] - from[axis]));
            let [tail, tip] = [*from, tip].map(|end| [end, placed.point(*body, end)]);
            let ends = [tail[0], tip[0]].map(|[x, y, z]| format!("{x:.5} {y:.5} {z:.5}"));
            let attributes = format!("data-a=\"{body} {}\"", ends.join(" "));
            figure.group(&attributes, |figure| {
                figure.arrow(self.view.at(tail[1]), self.view.at(tip[1]), ORANGE);
            });
        }
    }

    /// Names of the joints and links that are meant, beside them and apart from each other.
    fn names(&self, figure: &mut Figure, placed: &Placed<'_>) {
        let mut taken: Vec<f64> = Vec::new();
        let marks = &self.pictured.marks;
        // A joint is the origin of its body.
        let joints = marks.joints.iter();
        let joints = joints.map(|(body, name)| (*body, name, [0.0; 3]));
        let links = marks.links.iter().filter_map(|name| {
            let own = |capsule: &&Capsule| capsule.part == Part::Link && capsule.link == *name;
            let capsule = self.pictured.skeleton.capsules.iter().find(own)?;
            let [a, b] = capsule.ends;
            let middle = [0, 1, 2].map(|axis| (a[axis] + b[axis]) / 2.0);
            Some((capsule.body, name, middle))
        });
        for (body, name, point) in joints.chain(links) {
            let at = self.view.at(placed.point(body, point));
            let wide = text_width(name) * 1.08;
            let left = at[0] + 14.0 + wide < WIDTH - 4.0;
            let x = match left {
                true => at[0] + 14.0,
                false => (at[0] - 14.0).max(wide + 4.0),
            };
            let mut y = at[1];
            while taken.iter().any(|other| (other - y).abs() < 15.0) {
                y += 15.0;
            }
            taken.push(y);
            let anchor = if left { Anchor::Start } else { Anchor::End };
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

/// How near the middle of a capsule is; bones lie behind what is around them.
fn depth(view: &View, placed: &Placed<'_>, capsule: &Capsule) -> f64 {
    let [a, b] = placed.ends(capsule).map(|end| view.camera.depth(end));
    (a + b) / 2.0
}
