//! Bars of lengths with their names and numbers: the waterfall of a fit or a diagnosis,
//! and the rows of other bar charts.

use super::super::svg::{Anchor, BAND, Color, Figure, GRID, INK, NUMBER, text_width};
use super::super::table::mm;
use sesc_model::text::apart;

/// Letters beside a bar, at most.
const NAME: usize = 33;
const THICK: f64 = 20.0;
const PITCH: f64 = 34.0;
const TOP: f64 = 34.0;
const WIDTH: f64 = 600.0;
/// Pixels for the number after the longest bar.
const ROOM: f64 = 84.0;

/// Where lengths end, all bars beginning at `left`.
pub struct Scale {
    left: f64,
    per_metre: f64,
}

impl Scale {
    /// The longest of some lengths, m, takes `longest` pixels.
    pub fn new(lengths: impl IntoIterator<Item = f64>, left: f64, longest: f64) -> Scale {
        let finite = lengths.into_iter().filter(|x| x.is_finite());
        let per_metre = longest / finite.fold(1e-12, f64::max);
        Scale { left, per_metre }
    }

    /// End of the bar of a length; of none where the length is no number.
    pub fn at(&self, length_m: f64) -> f64 {
        match length_m.is_finite() {
            true => self.left + self.per_metre * length_m,
            false => self.left,
        }
    }

    /// A bar with its name before it and its number behind `end`.
    pub fn bar(&self, figure: &mut Figure, [upper, thick]: [f64; 2], bar: &Bar<'_>, end: f64) {
        let middle = upper + thick / 2.0;
        figure.note([self.left - 10.0, middle], Anchor::End, INK, bar.name);
        let corners = [[self.left, upper], [self.at(bar.length_m), upper + thick]];
        figure.fill(corners, bar.color, 1.0);
        let text = format!("{} mm", mm(bar.length_m));
        figure.text([end + 8.0, middle], Anchor::Start, NUMBER, INK, &text);
    }
}

/// A bar and what it stands for.
pub struct Bar<'t> {
    pub name: &'t str,
    pub length_m: f64,
    pub color: Color,
    /// In a waterfall: what the bar above it had more stays as a pale bar.
    pub pale: bool,
}

/// Bars one below the other, with a line down from the end of `noise_m`.
pub fn waterfall(title: &str, bars: &[Bar<'_>], noise_m: f64) -> String {
    let words = bars
        .iter()
        .map(|bar| format!("{} {} mm", bar.name, mm(bar.length_m)));
    let label = format!("{title}: {}", words.collect::<Vec<_>>().join(", "));
    let names: Vec<&str> = bars.iter().map(|bar| bar.name).collect();
    let names = apart(&names, NAME);
    let bars = bars
        .iter()
        .zip(&names)
        .map(|(bar, name)| Bar { name, ..*bar });
    let bars: Vec<Bar<'_>> = bars.collect();
    let widths = names.iter().map(|name| text_width(name));
    let left = widths.fold(90.0, f64::max) + 12.0;
    let scale = Scale::new(bars.iter().map(|b| b.length_m), left, WIDTH - left - ROOM);
    let height = TOP + PITCH * bars.len() as f64 + 4.0;
    let mut figure = Figure::new([WIDTH, height], &label);
    figure.title(13.0, title);
    if noise_m > 0.0 {
        let x = scale.at(noise_m);
        figure.line([[x, TOP - 4.0], [x, height - 6.0]], BAND, 1.5);
    }
    for (k, bar) in bars.iter().enumerate() {
        let upper = TOP + PITCH * k as f64;
        let mut end = scale.at(bar.length_m);
        if bar.pale && k > 0 && scale.at(bars[k - 1].length_m) > end {
            let before = scale.at(bars[k - 1].length_m);
            figure.fill([[end, upper], [before, upper + THICK]], GRID, 1.0);
            end = before;
        }
        scale.bar(&mut figure, [upper, THICK], bar, end);
    }
    figure.finish()
}
