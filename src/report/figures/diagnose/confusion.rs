//! How far apart the explanations of a class are: what each pair would read
//! differently over this log.

use super::super::super::svg::{Anchor, BLUE, Figure, GRID, INK, MUTED, TINY};
use super::super::shade;
use super::regions::number;

/// Side of the map, pixels, and where it starts.
const SIDE: f64 = 400.0;
const LEFT: f64 = 44.0;
const TOP: f64 = 58.0;
/// Squares that have room for a number.
const NUMBERED: usize = 14;
const DARKEST: f64 = 0.5;

/// RMS differences in units of noise; what no such log tells apart is left white.
pub fn confusion(differences: &[Vec<f64>]) -> String {
    let n = differences.len();
    let pitch = SIDE / n.max(1) as f64;
    let label = format!("RMS difference between {n} explanations, in units of noise");
    let mut figure = Figure::new([480.0, TOP + SIDE + 16.0], &label);
    figure.title(13.0, "How far apart they are");
    figure.note([472.0, 13.0], Anchor::End, MUTED, "RMS difference ÷ noise");
    for (row, values) in differences.iter().enumerate() {
        for (column, &value) in values.iter().enumerate().take(n) {
            let [x, y] = [LEFT + pitch * column as f64, TOP + pitch * row as f64];
            let corners = [[x, y], [x + pitch, y + pitch]];
            if value.is_finite() && row != column {
                // Half the noise and more is seen in some hundred postures.
                figure.fill(corners, BLUE, shade(DARKEST * value / (value + 0.5)));
                if n <= NUMBERED {
                    let middle = [x + pitch / 2.0, y + pitch / 2.0];
                    let text = match value < 0.995 {
                        true => format!("{value:.2}"),
                        false => number(value),
                    };
                    figure.text(middle, Anchor::Middle, TINY, INK, &text);
                }
            }
            figure.outline(corners, GRID);
        }
        let middle = pitch * (row as f64 + 0.5);
        let name = (row + 1).to_string();
        figure.note([LEFT - 8.0, TOP + middle], Anchor::End, MUTED, &name);
        figure.note([LEFT + middle, TOP - 11.0], Anchor::Middle, MUTED, &name);
    }
    if n == 0 {
        let place = [LEFT + 20.0, TOP + 20.0];
        figure.note(place, Anchor::Start, INK, "nothing to tell apart");
    }
    figure.finish()
}
