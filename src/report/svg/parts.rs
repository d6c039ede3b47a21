//! Parts of a figure of a robot.

use std::fmt::Write as _;

use super::{Anchor, Color, Figure, INK, PAPER, Place, Px, SMALL, Type, escaped};

impl Figure {
    /// A figure of a page that has others, from which it takes its colours: without style and
    /// ground of its own.
    pub fn plain(size: [f64; 2], label: &str) -> Figure {
        let [width, height] = size.map(f64::ceil);
        Figure {
            size,
            svg: format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
                 width=\"{width}\" height=\"{height}\" font-size=\"{}\" role=\"img\" \
                 aria-label=\"{}\">\n",
                SMALL.size,
                escaped(label)
            ),
        }
    }

    /// Elements that belong together; `attributes` are written as they are.
    pub fn group(&mut self, attributes: &str, draw: impl FnOnce(&mut Figure)) {
        let _ = writeln!(self.svg, "<g {attributes}>");
        draw(self);
        self.svg.push_str("</g>\n");
    }

    /// What stands for posture `k` of the page: a script finds it by this.
    pub fn posture(&mut self, k: usize, draw: impl FnOnce(&mut Figure)) {
        self.group(&format!("data-p=\"{k}\""), draw);
    }

    /// A mark that stands for no posture: a script tells a pointer these words.
    pub fn worded(&mut self, words: &str, draw: impl FnOnce(&mut Figure)) {
        self.group(&format!("data-v=\"{}\"", escaped(words)), draw);
    }

    /// What a pointer is told of the group that is being drawn.
    pub fn called(&mut self, name: &str) {
        let _ = writeln!(self.svg, "<title>{}</title>", escaped(name));
    }

    /// All points within half a width of a line.
    pub fn capsule(&mut self, ends: [Place; 2], width: f64, color: Color) {
        let [[a, b], [c, d]] = ends.map(|[x, y]| [Px(x), Px(y)]);
        self.element(
            &ends,
            format_args!(
                "<path class=\"{}\" d=\"M{a} {b}L{c} {d}\" stroke=\"currentColor\" \
                 stroke-width=\"{}\" stroke-linecap=\"round\"/>",
                color.name,
                Px(width)
            ),
        );
    }

    /// A dashed line.
    pub fn dashed(&mut self, ends: [Place; 2], color: Color, width: f64) {
        let [[a, b], [c, d]] = ends.map(|[x, y]| [Px(x), Px(y)]);
        self.element(
            &ends,
            format_args!(
                "<path class=\"{}\" d=\"M{a} {b}L{c} {d}\" stroke=\"currentColor\" \
                 stroke-width=\"{width}\" stroke-dasharray=\"3 3\"/>",
                color.name
            ),
        );
    }

    /// The sign of a centre of mass: a quartered disc.
    pub fn centre_of_mass(&mut self, [x, y]: Place) {
        const R: f64 = 7.0;
        self.dot([x, y], R + 1.5, PAPER);
        self.dot([x, y], R, INK);
        let quarter = |sx: f64, sy: f64| {
            let [from, to] = [[x + sx * (R - 1.5), y], [x, y + sy * (R - 1.5)]];
            let r = R - 1.5;
            format!(
                "M{} {}L{} {}A{r} {r} 0 0 1 {} {}Z",
                Px(x),
                Px(y),
                Px(from[0]),
                Px(from[1]),
                Px(to[0]),
                Px(to[1])
            )
        };
        let path = quarter(1.0, 1.0) + &quarter(-1.0, -1.0);
        self.element(
            &[[x, y]],
            format_args!(
                "<path class=\"{}\" d=\"{path}\" fill=\"currentColor\"/>",
                PAPER.name
            ),
        );
    }

    /// A line with a head where it is long enough for one.
    pub fn arrow(&mut self, tail: Place, tip: Place, color: Color) {
        /// Length of the head, and half its width, pixels.
        const HEAD: [f64; 2] = [5.5, 2.2];
        self.line([tail, tip], color, 1.25);
        let [x, y] = [tip[0] - tail[0], tip[1] - tail[1]];
        let length = x.hypot(y);
        if length < 1.6 * HEAD[0] {
            return;
        }
        let [x, y] = [x / length, y / length];
        let [back, side] = HEAD;
        let corner = |way: f64| {
            [
                tip[0] - back * x - way * side * y,
                tip[1] - back * y + way * side * x,
            ]
        };
        self.polygon(&[tip, corner(1.0), corner(-1.0)], color);
    }

    /// A text that stays readable on whatever is under it.
    pub fn haloed(&mut self, at: Place, anchor: Anchor, font: Type, color: Color, text: &str) {
        let attributes = format!(
            "class=\"{}\" stroke=\"currentColor\" stroke-width=\"5\" aria-hidden=\"true\"",
            PAPER.name
        );
        self.group(&attributes, |figure| {
            figure.text(at, anchor, font, PAPER, text);
        });
        self.text(at, anchor, font, color, text);
    }
}
