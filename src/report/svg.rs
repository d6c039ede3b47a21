//! Figures as SVG, written element by element.
//!
//! Places are pixels from the upper left corner of the figure, to tenths, so that
//! equal rows give equal bytes. An element names its colour by a class, and the
//! figure brings the values of the classes for light and for dark pages along.
//! What has a coordinate that is no number is left out.

#[cfg(test)]
pub(super) mod tests;

use std::fmt::{self, Write as _};

use serde::Serialize;
use sesc_model::text::visible_lines;

/// A colour under its name on the page; the colours are few and can be told apart
/// without telling red from green.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Color {
    pub name: &'static str,
    /// Value on a light page.
    pub light: &'static str,
    /// Value on a dark page.
    pub dark: &'static str,
}

const fn color(name: &'static str, light: &'static str, dark: &'static str) -> Color {
    Color { name, light, dark }
}

/// Text, and what is true.
pub(super) const INK: Color = color("ink", "#1f2933", "#e6eaf0");
/// Axis labels and readings.
pub(super) const MUTED: Color = color("muted", "#646b78", "#a0aab8");
pub(super) const GRID: Color = color("grid", "#e3e7ec", "#2b333e");
/// A broad line that a thin one runs in.
pub(super) const BAND: Color = color("band", "#c3cad4", "#505c6c");
/// What was identified.
pub(super) const BLUE: Color = color("blue", "#0072b2", "#56b4e9");
/// What data cannot tell.
pub(super) const ORANGE: Color = color("orange", "#d55e00", "#f0a04b");
/// The card behind a figure, and the inside of hollow marks.
pub(super) const PAPER: Color = color("paper", "#ffffff", "#1a2028");

pub(super) const PALETTE: [Color; 7] = [INK, MUTED, GRID, BAND, BLUE, ORANGE, PAPER];

/// x to the right and y down, pixels.
pub(super) type Place = [f64; 2];

/// Which end of a text is at its place.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Size (pixels) and weight of a text.
#[derive(Clone, Copy)]
pub(super) struct Type {
    size: f64,
    bold: bool,
}

const fn plain(size: f64) -> Type {
    Type { size, bold: false }
}

const fn bold(size: f64) -> Type {
    Type { size, bold: true }
}

/// Numbers inside squares.
pub(super) const TINY: Type = plain(11.0);
/// Labels, names, keys.
pub(super) const SMALL: Type = plain(12.0);
/// The title of a small panel.
pub(super) const NAME: Type = bold(12.0);
/// A number that a bar stands for.
pub(super) const NUMBER: Type = bold(13.0);
const TITLE: Type = bold(13.5);

/// A figure under construction.
pub(super) struct Figure {
    svg: String,
}

impl Figure {
    /// An empty figure of this width and height, pixels; `label` says in words what
    /// it shows.
    pub(super) fn new(size: [f64; 2], label: &str) -> Figure {
        let more = " font-family=\"sans-serif\" stroke-linejoin=\"round\"";
        let mut figure = Figure::begun(size, label, more);
        let rules = |value: fn(&Color) -> &'static str| {
            let rule = |color: &Color| format!("svg .{}{{color:{}}}", color.name, value(color));
            let rules: String = PALETTE.iter().map(rule).collect();
            format!("{rules}svg .hollow{{fill:{}}}", value(&PAPER))
        };
        let (light, dark) = (rules(|color| color.light), rules(|color| color.dark));
        let style = format!("{light}@media screen and (prefers-color-scheme:dark){{{dark}}}");
        let _ = writeln!(figure.svg, "<style>{style}</style>");
        figure.fill([[0.0; 2], size.map(f64::ceil)], PAPER, 1.0);
        figure
    }

    /// A figure of a page that has others, from which it takes its colours: without style and
    /// ground of its own.
    pub(super) fn plain(size: [f64; 2], label: &str) -> Figure {
        Figure::begun(size, label, "")
    }

    fn begun(size: [f64; 2], label: &str, more: &str) -> Figure {
        let [width, height] = size.map(f64::ceil);
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             width=\"{width}\" height=\"{height}\"{more} font-size=\"{}\" role=\"img\" \
             aria-label=\"{}\">\n",
            SMALL.size,
            escaped(label)
        );
        Figure { svg }
    }

    /// The text of the figure.
    pub(super) fn finish(self) -> String {
        self.svg + "</svg>\n"
    }

    /// An element, if its places are known.
    fn element(&mut self, name: &str, class: &str, places: &[Place], more: fmt::Arguments<'_>) {
        if places.iter().flatten().all(|x| x.is_finite()) {
            let _ = writeln!(self.svg, "<{name} class=\"{class}\" {more}/>");
        }
    }

    /// A line through places.
    pub(super) fn line(
        &mut self,
        places: impl IntoIterator<Item = Place>,
        color: Color,
        width: f64,
    ) {
        self.lines([places], color, width);
    }

    /// Lines through places each, as one element: of hundreds it is a third as long.
    pub(super) fn lines<P: IntoIterator<Item = Place>>(
        &mut self,
        lines: impl IntoIterator<Item = P>,
        color: Color,
        width: f64,
    ) {
        let mut path = String::new();
        for places in lines {
            let known = places.into_iter().filter(|[x, y]| (x + y).is_finite());
            for (k, [x, y]) in known.enumerate() {
                let step = if k == 0 { "M" } else { "L" };
                let _ = write!(path, "{step}{} {}", Px(x), Px(y));
            }
        }
        if !path.is_empty() {
            let stroke = format_args!(
                "d=\"{path}\" fill=\"none\" stroke=\"currentColor\" stroke-width=\"{width}\""
            );
            self.element("path", color.name, &[], stroke);
        }
    }

    /// A straight line with more attributes.
    fn stroke(&mut self, ends: [Place; 2], color: Color, width: f64, more: &str) {
        let [[a, b], [c, d]] = ends.map(|[x, y]| [Px(x), Px(y)]);
        let width = Px(width);
        let stroke = format_args!(
            "d=\"M{a} {b}L{c} {d}\" stroke=\"currentColor\" stroke-width=\"{width}\" {more}"
        );
        self.element("path", color.name, &ends, stroke);
    }

    /// All points within half a width of a line.
    pub(super) fn capsule(&mut self, ends: [Place; 2], width: f64, color: Color) {
        self.stroke(ends, color, width, "stroke-linecap=\"round\"");
    }

    /// A dashed line.
    pub(super) fn dashed(&mut self, ends: [Place; 2], color: Color, width: f64) {
        self.stroke(ends, color, width, "stroke-dasharray=\"3 3\"");
    }

    /// A filled polygon.
    pub(super) fn polygon(&mut self, places: &[Place], color: Color) {
        let points = places.iter();
        let points = points.map(|[x, y]| format!("{},{}", Px(*x), Px(*y)));
        let points = points.collect::<Vec<String>>().join(" ");
        let filled = format_args!("points=\"{points}\" fill=\"currentColor\"");
        self.element("polygon", color.name, places, filled);
    }

    /// A filled box between two corners; `opacity` from 0 to 1.
    pub(super) fn fill(&mut self, corners: [Place; 2], color: Color, opacity: f64) {
        let opacity = match opacity < 1.0 {
            true => format!(" fill-opacity=\"{opacity}\""),
            false => String::new(),
        };
        let filled = format_args!("{} fill=\"currentColor\"{opacity}", Corners(corners));
        self.element("rect", color.name, &corners, filled);
    }

    /// The edges of a box.
    pub(super) fn outline(&mut self, corners: [Place; 2], color: Color) {
        let edges = Corners(corners);
        let drawn = format_args!("{edges} fill=\"none\" stroke=\"currentColor\"");
        self.element("rect", color.name, &corners, drawn);
    }

    /// A filled dot.
    pub(super) fn dot(&mut self, at: Place, radius: f64, color: Color) {
        let [x, y] = at.map(Px);
        let filled = format_args!("cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"currentColor\"");
        self.element("circle", color.name, &[at], filled);
    }

    /// A hollow dot.
    pub(super) fn ring(&mut self, at: Place, color: Color) {
        let [x, y] = at.map(Px);
        let edge = format_args!(
            "cx=\"{x}\" cy=\"{y}\" r=\"3.75\" stroke=\"currentColor\" stroke-width=\"1.25\""
        );
        self.element("circle", &format!("{} hollow", color.name), &[at], edge);
    }

    /// One line of text, its middle at the height of the place; none without words.
    pub(super) fn text(&mut self, at: Place, anchor: Anchor, font: Type, color: Color, text: &str) {
        if text.is_empty() || !at.iter().all(|x| x.is_finite()) {
            return;
        }
        let mut style = match anchor {
            Anchor::Start => String::new(),
            Anchor::Middle => " text-anchor=\"middle\"".to_string(),
            Anchor::End => " text-anchor=\"end\"".to_string(),
        };
        if font.size != SMALL.size {
            let _ = write!(style, " font-size=\"{}\"", font.size);
        }
        if font.bold {
            style.push_str(" font-weight=\"bold\"");
        }
        let _ = writeln!(
            self.svg,
            "<text class=\"{}\" x=\"{}\" y=\"{}\" fill=\"currentColor\"{style}>{}</text>",
            color.name,
            Px(at[0]),
            // Digits stand on the line and are 0.7 of the size high.
            Px(at[1] + 0.35 * font.size),
            escaped(text)
        );
    }

    /// A small line of text.
    pub(super) fn note(&mut self, at: Place, anchor: Anchor, color: Color, text: &str) {
        self.text(at, anchor, SMALL, color, text);
    }

    /// A text that stays readable on whatever is under it.
    pub(super) fn haloed(
        &mut self,
        at: Place,
        anchor: Anchor,
        font: Type,
        color: Color,
        text: &str,
    ) {
        let attributes = format!(
            "class=\"{}\" stroke=\"currentColor\" stroke-width=\"5\" aria-hidden=\"true\"",
            PAPER.name
        );
        self.group(&attributes, |figure| {
            figure.text(at, anchor, font, PAPER, text);
        });
        self.text(at, anchor, font, color, text);
    }

    /// The title of a figure or panel, at its left edge.
    pub(super) fn title(&mut self, middle: f64, text: &str) {
        self.text([2.0, middle], Anchor::Start, TITLE, INK, text);
    }

    /// Elements that belong together; `attributes` are written as they are.
    pub(super) fn group(&mut self, attributes: &str, draw: impl FnOnce(&mut Figure)) {
        let _ = writeln!(self.svg, "<g {attributes}>");
        draw(self);
        self.svg.push_str("</g>\n");
    }

    /// A mark that stands for no posture: a script tells a pointer these words.
    pub(super) fn worded(&mut self, words: &str, draw: impl FnOnce(&mut Figure)) {
        self.group(&format!("data-v=\"{}\"", escaped(words)), draw);
    }

    /// What a pointer is told of the group that is being drawn.
    pub(super) fn called(&mut self, name: &str) {
        let _ = writeln!(self.svg, "<title>{}</title>", escaped(name));
    }

    /// The sign of a centre of mass: a quartered disc.
    pub(super) fn centre_of_mass(&mut self, at: Place) {
        const R: f64 = 7.0;
        const INSIDE: f64 = R - 1.5;
        self.dot(at, R + 1.5, PAPER);
        self.dot(at, R, INK);
        let quarter = |side: f64| {
            let [x, y] = at.map(Px);
            let [right, low] = at.map(|x| Px(x + side * INSIDE));
            format!("M{x} {y}L{right} {y}A{INSIDE} {INSIDE} 0 0 1 {x} {low}Z")
        };
        let path = quarter(1.0) + &quarter(-1.0);
        let filled = format_args!("d=\"{path}\" fill=\"currentColor\"");
        self.element("path", PAPER.name, &[at], filled);
    }

    /// A line with a head where it is long enough for one.
    pub(super) fn arrow(&mut self, tail: Place, tip: Place, color: Color) {
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
}

/// Pixels that a small text may take, in a broad font.
pub(super) fn text_width(text: &str) -> f64 {
    let letters = text.chars().map(|c| match c {
        'i' | 'j' | 'l' | 't' | 'f' | 'r' | 'I' | ' ' | '.' | ',' | ':' | '(' | ')' | '|' => 0.38,
        'm' | 'w' | 'M' | 'W' | '%' | '…' => 0.95,
        c if c.is_uppercase() => 0.72,
        _ => 0.62,
    });
    SMALL.size * letters.sum::<f64>()
}

/// A coordinate: tenths of a pixel, whole ones without a point.
#[derive(Clone, Copy)]
struct Px(f64);

impl fmt::Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Adding zero takes the sign from a negative zero.
        write!(f, "{}", (10.0 * self.0).round() / 10.0 + 0.0)
    }
}

/// Two opposite corners as the attributes of a rectangle.
struct Corners([Place; 2]);

impl fmt::Display for Corners {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.0;
        write!(
            f,
            "x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"",
            Px(a[0].min(b[0])),
            Px(a[1].min(b[1])),
            Px((a[0] - b[0]).abs()),
            Px((a[1] - b[1]).abs())
        )
    }
}

/// `text` so that markup reads it as text; what is hidden is spelled out, as in terminals.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in visible_lines(text).chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
