//! How far apart the explanations of a class are: what each pair would read
//! differently over this log.

use plotters::prelude::*;

use super::super::super::svg::{self, BLUE, GRID, INK, MUTED, Side, note, px, title, write};
use super::outline;
use super::regions::number;

/// Side of the map, pixels, and where it starts.
const SIDE: f64 = 400.0;
const LEFT: f64 = 44.0;
const TOP: f64 = 58.0;
/// Squares that have room for a number.
const NUMBERED: usize = 14;
const DARKEST: f64 = 0.8;

/// RMS differences in units of noise; white is what no such log tells apart.
pub fn confusion(differences: &[Vec<f64>]) -> String {
    let n = differences.len();
    let pitch = SIDE / n.max(1) as f64;
    let label = format!("RMS difference between {n} explanations, in units of noise");
    svg::figure([480, (TOP + SIDE + 16.0) as u32], &label, |area| {
        title(area, "How far apart they are", (px(2.0), px(13.0)))?;
        let place = (px(472.0), px(13.0));
        note(area, "RMS difference ÷ noise", place, Side::Right, MUTED)?;
        let corner = |row: usize, column: usize| {
            (
                px(LEFT + pitch * column as f64),
                px(TOP + pitch * row as f64),
            )
        };
        for (row, values) in differences.iter().enumerate() {
            for (column, &value) in values.iter().enumerate().take(n) {
                let ends = [corner(row, column), corner(row + 1, column + 1)];
                if value.is_finite() && row != column {
                    // Half the noise and more is seen in some hundred postures.
                    let shade = DARKEST * value / (value + 0.5);
                    let shade = (shade * 20.0).round() / 20.0;
                    area.draw(&Rectangle::new(ends, BLUE.mix(shade).filled()))?;
                    if n <= NUMBERED {
                        let [from, to] = ends;
                        let middle = ((from.0 + to.0) / 2, (from.1 + to.1) / 2);
                        let text = match value < 0.995 {
                            true => format!("{value:.2}"),
                            false => number(value),
                        };
                        write(area, &text, middle, Side::Middle, 11.0, INK, false)?;
                    }
                }
                outline(area, ends, GRID)?;
            }
            let middle = pitch * (row as f64 + 0.5);
            let name = (row + 1).to_string();
            let left = (px(LEFT - 8.0), px(TOP + middle));
            note(area, &name, left, Side::Right, MUTED)?;
            let above = (px(LEFT + middle), px(TOP - 11.0));
            note(area, &name, above, Side::Middle, MUTED)?;
        }
        if n == 0 {
            let place = (px(LEFT + 20.0), px(TOP + 20.0));
            note(area, "nothing to tell apart", place, Side::Left, INK)?;
        }
        Ok(())
    })
}
