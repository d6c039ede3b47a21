//! Charts as data: panels with axes, and in each of them layers of marks, lines, boxes and words
//! in the units of its axes.
//!
//! ```text
//! place = edge + (value − low) / (high − low) · length
//! ```
//!
//! A value beyond the range of an axis is drawn at its edge; what is no number is left out.

use std::ops::Range;

use super::svg::{Anchor, Color, Figure, GRID, INK, MUTED, NAME, Place, Type, text_width};

/// Pixels around the plane of a panel: at its left unless names of rows are wider, over it, at
/// its right, and under it without labels, with them, and with the name of the axis.
const LEFT: f64 = 48.0;
const OVER: f64 = 32.0;
const RIGHT: f64 = 8.0;
const UNDER: [f64; 3] = [8.0, 20.0, 36.0];
/// Height of a line under all that.
const FOOT: f64 = 24.0;
/// From the upper edge of a panel, or of a chart, to the middle of its title.
const TITLE: f64 = 13.0;
/// Height of the title of a chart over its panels.
const HEADING: f64 = 28.0;

/// A chart: panels in rows.
#[derive(Default)]
pub(super) struct Plot {
    /// What it shows, in words.
    pub label: String,
    /// Pixels.
    pub width: f64,
    /// Over all panels, with the key of the first; where there is none, panels have their own.
    pub title: String,
    /// Panels side by side; 0 is one.
    pub columns: usize,
    pub panels: Vec<Panel>,
}

/// A plane with axes.
#[derive(Default)]
pub(super) struct Panel {
    pub title: String,
    /// Ranges of the axes; all that layers have of one where there is none.
    pub x: Option<Range<f64>>,
    pub y: Option<Range<f64>>,
    /// Written under the right end of the horizontal axis, with its unit.
    pub x_name: String,
    /// Written under all.
    pub foot: String,
    /// Ticks at most on each axis; 0 for an axis without labels and grid.
    pub ticks: [usize; 2],
    /// Pixels of the plane.
    pub height: f64,
    /// A unit is as long on both axes.
    pub is_map: bool,
    /// Names of rows from above, each a unit high: y goes from 0 down.
    pub rows: Vec<String>,
    /// What stands in its key before its series.
    pub key: Vec<(Mark, &'static str)>,
    /// What is drawn, one on the other.
    pub series: Vec<Series>,
    /// What is written where nothing is drawn.
    pub nothing: &'static str,
}

/// What is drawn at points, and its name in the key if it stands there.
pub(super) struct Series {
    name: String,
    mark: Mark,
    points: Vec<Point>,
}

/// What stands for a point; lengths in pixels.
#[derive(Clone, Copy)]
pub(super) enum Mark {
    /// A filled dot of a radius.
    Dot(Color, f64),
    /// A hollow dot.
    Ring(Color),
    /// A filled square of a side.
    Square(Color, f64),
    /// The edges of a square of a side.
    Frame(Color, f64),
    /// An upright stroke of a height and a width.
    Stroke(Color, [f64; 2]),
    /// A line of a width through all points.
    Line(Color, f64),
    /// Lines of a width, from a place to another.
    Segment(Color, f64),
    /// A box between two corners, of an opacity from 0 to 1.
    Box(Color, f64),
    /// An arrow from a place to a dot; a script that is told how much longer than they are arrows
    /// are drawn makes them shorter.
    Arrow(Color, Option<f64>),
    /// The words of a point, so many pixels beside it.
    Words(Color, Type, Anchor, [f64; 2]),
}

impl Mark {
    /// A dot of the usual size.
    pub(super) const fn dot(color: Color) -> Mark {
        Mark::Dot(color, 3.25)
    }

    /// A stroke of the usual size.
    pub(super) const fn stroke(color: Color) -> Mark {
        Mark::Stroke(color, [13.0, 2.5])
    }

    /// The same in a key, where all have one size, and half its width.
    fn in_key(self) -> (Mark, f64) {
        match self {
            Mark::Dot(color, _) => (Mark::dot(color), 4.5),
            Mark::Square(color, _) | Mark::Box(color, _) => (Mark::Square(color, 9.0), 4.5),
            Mark::Frame(color, _) => (Mark::Frame(color, 9.0), 4.5),
            Mark::Stroke(color, _) => (Mark::stroke(color), 2.0),
            Mark::Line(color, width) | Mark::Segment(color, width) => {
                (Mark::Segment(color, width), 9.0)
            }
            Mark::Arrow(color, _) => (Mark::Segment(color, 1.5), 9.0),
            Mark::Ring(_) | Mark::Words(..) => (self, 4.5),
        }
    }

    /// Draw it from a place to another, which are mostly the same.
    fn draw(self, figure: &mut Figure, [from, to]: [Place; 2], words: &str) {
        let [x, y] = [0, 1].map(|axis| (from[axis] + to[axis]) / 2.0);
        let around = |side: f64| [-0.5 * side, 0.5 * side].map(|half| [x + half, y + half]);
        match self {
            Mark::Dot(color, radius) => figure.dot([x, y], radius, color),
            Mark::Ring(color) => figure.ring([x, y], color),
            Mark::Square(color, side) => figure.fill(around(side), color, 1.0),
            Mark::Frame(color, side) => figure.outline(around(side), color),
            Mark::Stroke(color, [height, width]) => {
                figure.line(around(height).map(|[_, y]| [x, y]), color, width);
            }
            Mark::Line(color, width) | Mark::Segment(color, width) => {
                figure.line([from, to], color, width);
            }
            Mark::Box(color, opacity) => figure.fill([from, to], color, opacity),
            Mark::Arrow(color, _) => {
                figure.arrow(from, to, color);
                figure.dot(to, 1.3, INK);
            }
            Mark::Words(color, font, anchor, [right, down]) => {
                figure.text([x + right, y + down], anchor, font, color, words);
            }
        }
    }
}

/// Where something is, in units of the axes, and what it stands for.
#[derive(Clone)]
pub(super) struct Point {
    /// Where it begins and ends.
    ends: [[f64; 2]; 2],
    /// The posture of the page that a pointer is shown.
    posture: Option<usize>,
    /// What a pointer is told, or what is written.
    words: String,
}

impl Point {
    /// From a place to another.
    pub(super) fn between(ends: [[f64; 2]; 2]) -> Point {
        Point {
            ends,
            posture: None,
            words: String::new(),
        }
    }

    /// A place that stands for posture `k` of the page.
    pub(super) fn posture(k: usize, at: [f64; 2]) -> Point {
        let mut point = Point::from(at);
        point.posture = Some(k);
        point
    }

    /// A place that stands for no posture, and what a pointer is told of it.
    pub(super) fn worded(words: impl Into<String>, at: [f64; 2]) -> Point {
        let mut point = Point::from(at);
        point.words = words.into();
        point
    }

    /// The same, coming from another place.
    pub(super) fn coming_from(self, from: [f64; 2]) -> Point {
        let ends = [from, self.ends[1]];
        Point { ends, ..self }
    }
}

impl From<[f64; 2]> for Point {
    fn from(at: [f64; 2]) -> Point {
        Point::between([at; 2])
    }
}

/// Points of one kind.
pub(super) fn series<P: Into<Point>>(mark: Mark, points: impl IntoIterator<Item = P>) -> Series {
    Series {
        name: String::new(),
        mark,
        points: points.into_iter().map(P::into).collect(),
    }
}

/// Lines from a place to another each.
pub(super) fn segments(
    color: Color,
    width: f64,
    ends: impl IntoIterator<Item = [[f64; 2]; 2]>,
) -> Series {
    let points = ends.into_iter().map(Point::between);
    series(Mark::Segment(color, width), points)
}

/// A line across the panel at a value of an axis (0: x, 1: y).
pub(super) fn rule(axis: usize, value: f64, color: Color, width: f64) -> Series {
    let ends = [f64::NEG_INFINITY, f64::INFINITY].map(|far| match axis {
        0 => [value, far],
        _ => [far, value],
    });
    segments(color, width, [ends])
}

/// The edges of a box.
pub(super) fn outline(color: Color, [[left, low], [right, high]]: [[f64; 2]; 2]) -> Series {
    let first = [left, low];
    let corners = [first, [right, low], [right, high], [left, high], first];
    series(Mark::Line(color, 1.0), corners)
}

/// A filled box between two corners, of an opacity from 0 to 1.
pub(super) fn area(color: Color, opacity: f64, corners: [[f64; 2]; 2]) -> Series {
    series(Mark::Box(color, opacity), [Point::between(corners)])
}

impl Series {
    /// The same with a name in the key.
    pub(super) fn named(self, name: impl Into<String>) -> Series {
        let name = name.into();
        Series { name, ..self }
    }

    fn draw(&self, figure: &mut Figure, plane: &Plane) {
        let places = self.points.iter();
        let places = places.map(|point| point.ends.map(|end| plane.at(end)));
        match self.mark {
            Mark::Line(color, width) => figure.line(places.map(|[at, _]| at), color, width),
            // As one element: of hundreds it is a third as long.
            Mark::Segment(color, width) => figure.lines(places, color, width),
            Mark::Stroke(color, [height, width]) => {
                let strokes =
                    places.map(|[[x, y], _]| [y - height / 2.0, y + height / 2.0].map(|y| [x, y]));
                figure.lines(strokes, color, width);
            }
            Mark::Arrow(_, gain) => {
                let attributes = match gain {
                    Some(gain) => format!("data-gain=\"{gain}\" {}", plane.attributes()),
                    None => "data-still=\"\"".to_string(),
                };
                figure.group(&attributes, |figure| self.draw_each(figure, places));
            }
            _ => self.draw_each(figure, places),
        }
    }

    fn draw_each(&self, figure: &mut Figure, places: impl Iterator<Item = [Place; 2]>) {
        for (point, ends) in self.points.iter().zip(places) {
            let draw = |figure: &mut Figure| self.mark.draw(figure, ends, &point.words);
            match point.posture {
                _ if !ends.iter().flatten().all(|x| x.is_finite()) => {}
                Some(k) => figure.group(&format!("data-p=\"{k}\""), draw),
                None if point.words.is_empty() || matches!(self.mark, Mark::Words(..)) => {
                    draw(figure);
                }
                None => figure.worded(&point.words, draw),
            }
        }
    }
}

impl Plot {
    /// The chart as SVG.
    pub(super) fn draw(&self) -> String {
        let columns = self.columns.max(1);
        let names = self.panels.iter().flat_map(|panel| &panel.rows);
        let names = names.map(|name| text_width(name) + 12.0);
        let left = names.fold(LEFT, f64::max);
        let is_titled = !self.title.is_empty();
        let top = if is_titled { HEADING } else { 0.0 };
        let lines = self.panels.chunks(columns);
        let heights = lines.clone().map(|line| {
            let heights = line.iter().map(Panel::outer_height);
            heights.fold(0.0, f64::max)
        });
        let height = top + heights.clone().sum::<f64>().max(OVER);
        let mut figure = Figure::new([self.width, height], &self.label);
        if is_titled {
            figure.title(TITLE, &self.title);
            let first = self.panels.iter().take(1).flat_map(Panel::series_key);
            key(&mut figure, self.width - RIGHT, TITLE, first);
        }
        let mut upper = top;
        for (line, height) in lines.zip(heights) {
            for (k, panel) in line.iter().enumerate() {
                let wide = self.width / columns as f64;
                let (x, y) = (wide * k as f64, upper + OVER);
                let edges = [x + left, y, x + wide - RIGHT, y + panel.height];
                panel.draw(&mut figure, edges, is_titled);
            }
            upper += height;
        }
        figure.finish()
    }
}

/// The chart of panels one below the other; `label` says in words what it shows.
pub(super) fn stacked(width: f64, label: String, panels: Vec<Panel>) -> String {
    Plot {
        label,
        width,
        panels,
        ..Plot::default()
    }
    .draw()
}

impl Panel {
    /// The chart that has this panel alone.
    pub(super) fn alone(self, width: f64, label: String) -> String {
        stacked(width, label, vec![self])
    }

    fn outer_height(&self) -> f64 {
        let under = match (self.x_name.is_empty(), self.ticks[0]) {
            (false, _) => UNDER[2],
            (true, 0) => UNDER[0],
            (true, _) => UNDER[1],
        };
        let foot = if self.foot.is_empty() { 0.0 } else { FOOT };
        OVER + self.height + under + foot
    }

    /// The key of its series.
    fn series_key(&self) -> impl Iterator<Item = (Mark, &str)> {
        let named = self.series.iter().filter(|own| !own.name.is_empty());
        let drawn = named.filter(|own| !own.points.is_empty());
        drawn.map(|own| (own.mark, own.name.as_str()))
    }

    /// Draw it between these edges; one of several under a title has a small title and no key.
    fn draw(&self, figure: &mut Figure, edges: [f64; 4], is_one: bool) {
        let [left, top, right, bottom] = edges;
        let plane = self.plane(edges);
        for (value, label) in ticks(&plane.x, self.ticks[0]) {
            let [x, _] = plane.at([value, plane.y.start]);
            figure.line([[x, top], [x, bottom]], GRID, 1.0);
            // A label at the right end stays inside the figure.
            let middle = x.min(right + RIGHT - text_width(&label) / 2.0 - 1.0);
            figure.note([middle, bottom + 11.0], Anchor::Middle, MUTED, &label);
        }
        for (value, label) in ticks(&plane.y, self.ticks[1]) {
            let [_, y] = plane.at([plane.x.start, value]);
            figure.line([[left, y], [right, y]], GRID, 1.0);
            figure.note([left - 5.0, y], Anchor::End, MUTED, &label);
        }
        for (k, name) in self.rows.iter().enumerate() {
            let [_, middle] = plane.at([plane.x.start, -(k as f64) - 0.5]);
            figure.note([left - 8.0, middle], Anchor::End, INK, name);
            if self.ticks[0] > 0 {
                figure.line([[left, middle], [right, middle]], GRID, 1.0);
            }
        }
        figure.note([right, bottom + 25.5], Anchor::End, MUTED, &self.x_name);
        let foot = [left, bottom + UNDER[2] + FOOT / 2.0];
        figure.note(foot, Anchor::Start, MUTED, &self.foot);
        self.series.iter().for_each(|own| own.draw(figure, &plane));
        if self.series.iter().all(|own| own.points.is_empty()) {
            let place = [left + 20.0, top + 20.0];
            figure.note(place, Anchor::Start, MUTED, self.nothing);
        }
        let middle = top - OVER + TITLE;
        if is_one {
            figure.text([left, middle + 6.0], Anchor::Start, NAME, INK, &self.title);
            key(figure, right, middle + 6.0, self.key.iter().copied());
        } else {
            figure.title(middle, &self.title);
            let all = self.key.iter().copied().chain(self.series_key());
            key(figure, right, middle, all);
        }
    }

    fn plane(&self, edges: [f64; 4]) -> Plane {
        let points = || self.series.iter().flat_map(|own| &own.points);
        let all = |axis: usize| span(points().flat_map(|point| point.ends.map(|end| end[axis])));
        let rows = (!self.rows.is_empty()).then(|| -(self.rows.len() as f64)..0.0);
        let x = self.x.clone().unwrap_or_else(|| all(0));
        let y = self.y.clone().or(rows).unwrap_or_else(|| all(1));
        let [x, y] = match self.is_map {
            true => same_scale([x, y], edges),
            false => [x, y],
        };
        Plane { x, y, edges }
    }
}

/// Marks and what they mean, side by side, ending at `right` pixels and centred at `middle`.
fn key<'t>(
    figure: &mut Figure,
    right: f64,
    middle: f64,
    items: impl Iterator<Item = (Mark, &'t str)>,
) {
    const TO_NAME: f64 = 6.0;
    const TO_NEXT: f64 = 14.0;
    let mut right = right;
    let items: Vec<(Mark, &str)> = items.collect();
    for (mark, name) in items.into_iter().rev() {
        let (mark, half) = mark.in_key();
        let left = right - text_width(name);
        figure.note([left, middle], Anchor::Start, INK, name);
        let centre = left - TO_NAME - half;
        mark.draw(figure, [-half, half].map(|by| [centre + by, middle]), "");
        right = centre - half - TO_NEXT;
    }
}

/// The map from values to places.
struct Plane {
    x: Range<f64>,
    y: Range<f64>,
    /// Left, top, right and bottom.
    edges: [f64; 4],
}

impl Plane {
    /// The map as attributes, for a script.
    fn attributes(&self) -> String {
        let [left, top, right, bottom] = self.edges;
        format!(
            "data-plane=\"{left} {top} {right} {bottom} {:.4} {:.4} {:.4} {:.4}\"",
            self.x.start, self.x.end, self.y.start, self.y.end
        )
    }

    /// Where a pair of values lies.
    fn at(&self, [x, y]: [f64; 2]) -> Place {
        let [left, top, right, bottom] = self.edges;
        let share = |value: f64, range: &Range<f64>| {
            ((value - range.start) / (range.end - range.start)).clamp(0.0, 1.0)
        };
        let (x, y) = (share(x, &self.x), share(y, &self.y));
        [left + x * (right - left), bottom - y * (bottom - top)]
    }
}

/// Round values of a range with their labels, `most` at most: multiples of the smallest
/// step of 1, 2 or 5 times a power of ten that gives no more.
fn ticks(range: &Range<f64>, most: usize) -> Vec<(f64, String)> {
    let length = range.end - range.start;
    if most == 0 || !(length > 0.0 && length.is_finite()) {
        return Vec::new();
    }
    let finest = (length / most as f64).log10().floor() as i32 - 1;
    let steps = (finest..finest + 4).flat_map(|power| [1, 2, 5].map(|digit| (digit, power)));
    for (digit, power) in steps {
        // Powers are exact, products and quotients round once: alike on every machine.
        let scale = 10_f64.powi(power.abs());
        let value = |k: f64| match power < 0 {
            true => k * f64::from(digit) / scale,
            false => k * f64::from(digit) * scale,
        };
        let first = (range.start / value(1.0) - 1e-9).ceil();
        let count = ((range.end / value(1.0) + 1e-9).floor() - first + 1.0).max(0.0);
        if count <= most as f64 {
            let digits = usize::try_from(-power).unwrap_or(0);
            let labelled = |k| {
                let value = value(first + f64::from(k)) + 0.0;
                (value, format!("{value:.digits$}").replace('-', "−"))
            };
            return (0..count as u32).map(labelled).collect();
        }
    }
    Vec::new()
}

/// The smallest range over all finite values, a little wider, and wide enough for ticks
/// around a single value.
pub(super) fn span(values: impl IntoIterator<Item = f64>) -> Range<f64> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.into_iter().filter(|value| value.is_finite()) {
        (low, high) = (low.min(value), high.max(value));
    }
    if low > high {
        return 0.0..1.0;
    }
    let size = low.abs().max(high.abs());
    if high - low > 1e-3 * size.max(1e-3) {
        let margin = 0.06 * (high - low);
        return low - margin..high + margin;
    }
    let (middle, half) = ((low + high) / 2.0, (0.05 * size).max(1.0));
    middle - half..middle + half
}

/// Widen one of two ranges so that a unit is as long on both axes.
pub(super) fn same_scale(
    ranges: [Range<f64>; 2],
    [left, top, right, bottom]: [f64; 4],
) -> [Range<f64>; 2] {
    let sizes = [right - left, bottom - top];
    let per_pixel = |k: usize| (ranges[k].end - ranges[k].start) / sizes[k];
    let largest = per_pixel(0).max(per_pixel(1));
    [0, 1].map(|k| {
        let middle = (ranges[k].start + ranges[k].end) / 2.0;
        middle - largest * sizes[k] / 2.0..middle + largest * sizes[k] / 2.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(range: Range<f64>, most: usize) -> Vec<String> {
        let labelled = ticks(&range, most).into_iter();
        labelled.map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_and_as_many_as_fit() {
        assert_eq!(labels(0.0..27.0, 6), ["0", "5", "10", "15", "20", "25"]);
        assert_eq!(
            labels(-0.25..0.25, 5),
            ["−0.2", "−0.1", "0.0", "0.1", "0.2"]
        );
        assert_eq!(labels(-6.0..6.0, 7), ["−6", "−4", "−2", "0", "2", "4", "6"]);
        assert_eq!(labels(0.0..1e6, 3), ["0", "500000", "1000000"]);
        assert_eq!(labels(1e-7..9e-7, 2), ["0.0000005"]);
        assert_eq!(labels(0.0..1.0, 0), [""; 0]);
        for odd in [0.0..0.0, 1.0..0.0, 0.0..f64::INFINITY, f64::NAN..1.0] {
            assert!(ticks(&odd, 5).is_empty());
        }
    }

    #[test]
    fn spans_hold_all_finite_values_and_leave_room_around_one() {
        assert_eq!(span([0.0, 100.0, f64::NAN]), -6.0..106.0);
        assert_eq!(span([3.0]), 2.0..4.0);
        assert_eq!(span([-200.0]), -210.0..-190.0);
        assert_eq!(span([f64::INFINITY]), 0.0..1.0);
    }

    #[test]
    fn a_unit_is_as_long_on_both_axes() {
        let [x, y] = same_scale([0.0..10.0, 0.0..1.0], [0.0, 0.0, 100.0, 50.0]);
        assert_eq!((x, y), (0.0..10.0, -2.0..3.0));
    }
}
