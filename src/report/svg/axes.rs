//! Panels of a figure: axes with ticks, and where values lie between them.
//!
//! ```text
//! place = edge + (value − low) / (high − low) · length
//! ```

use std::ops::Range;

use super::{Anchor, Figure, GRID, MUTED, Place, text_width};

/// Height of a panel's title and key over its plane, pixels.
pub const HEADING: f64 = 19.0;

/// A panel of a figure: its place, ranges and names.
pub struct Axes<'t> {
    pub title: &'t str,
    pub x: Range<f64>,
    pub y: Range<f64>,
    /// Written under the right end of the horizontal axis, with its unit.
    pub x_name: &'t str,
    /// Ticks at most on each axis; 0 for an axis without labels and grid.
    pub ticks: [usize; 2],
    /// Left, top, right and bottom edge of the plane, pixels.
    pub edges: [f64; 4],
}

/// A drawn panel: the map from values to places.
pub struct Plane {
    x: Range<f64>,
    y: Range<f64>,
    edges: [f64; 4],
}

impl Axes<'_> {
    /// Draw grid, labels, title and name.
    pub fn draw(self, figure: &mut Figure) -> Plane {
        let [left, top, right, bottom] = self.edges;
        let plane = Plane {
            x: self.x,
            y: self.y,
            edges: self.edges,
        };
        for (value, label) in ticks(&plane.x, self.ticks[0]) {
            let [x, _] = plane.at([value, plane.y.start]);
            figure.line([[x, top], [x, bottom]], GRID, 1.0);
            // A label at the right end stays inside the figure.
            let middle = x.min(figure.size[0] - text_width(&label) / 2.0 - 1.0);
            figure.note([middle, bottom + 11.0], Anchor::Middle, MUTED, &label);
        }
        for (value, label) in ticks(&plane.y, self.ticks[1]) {
            let [_, y] = plane.at([plane.x.start, value]);
            figure.line([[left, y], [right, y]], GRID, 1.0);
            figure.note([left - 5.0, y], Anchor::End, MUTED, &label);
        }
        if !self.title.is_empty() {
            figure.title(top - HEADING, self.title);
        }
        if !self.x_name.is_empty() {
            figure.note([right, bottom + 25.5], Anchor::End, MUTED, self.x_name);
        }
        plane
    }
}

impl Plane {
    /// The map as attributes, for a script.
    pub fn attributes(&self) -> String {
        let [left, top, right, bottom] = self.edges;
        format!(
            "data-plane=\"{left} {top} {right} {bottom} {:.4} {:.4} {:.4} {:.4}\"",
            self.x.start, self.x.end, self.y.start, self.y.end
        )
    }

    /// Where a pair of values lies.
    pub fn at(&self, [x, y]: [f64; 2]) -> Place {
        let [left, top, right, bottom] = self.edges;
        let share =
            |range: &Range<f64>, value: f64| (value - range.start) / (range.end - range.start);
        [
            left + share(&self.x, x) * (right - left),
            bottom - share(&self.y, y) * (bottom - top),
        ]
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
pub fn span(values: impl IntoIterator<Item = f64>) -> Range<f64> {
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
pub fn same_scale(
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
