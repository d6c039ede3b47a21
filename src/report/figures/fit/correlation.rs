//! Which parameters are known together but not apart: a map of correlations.

use plotters::prelude::*;

use super::super::super::svg::{self, BLUE, GRID, INK, MUTED, ORANGE, Side, key, note, px};

/// Side of the map, pixels, and where it starts.
const WIDE: f64 = 420.0;
const LEFT: f64 = 50.0;
const TOP: f64 = 40.0;
/// Weaker ones are left blank.
const FAINT: f64 = 0.1;

/// The triangle of correlations, one square per pair, numbered as in the table.
pub fn correlation(matrix: &[Vec<f64>]) -> String {
    let n = matrix.len().max(1);
    let pitch = WIDE / n as f64;
    let label = format!("Correlations between {} parameters", matrix.len());
    svg::figure([480, (TOP + WIDE + 16.0) as u32], &label, |area| {
        let corner = |row: usize, column: usize| {
            (
                px(LEFT + pitch * column as f64),
                px(TOP + pitch * row as f64),
            )
        };
        for (row, values) in matrix.iter().enumerate() {
            for (column, &value) in values.iter().enumerate().take(row) {
                if value.is_finite() && value.abs() > FAINT {
                    let color = if value > 0.0 { BLUE } else { ORANGE };
                    // Steps, so that equal shades are equal bytes.
                    let shade = (value.abs().min(1.0) * 20.0).round() / 20.0;
                    area.draw(&Rectangle::new(
                        [corner(row, column), corner(row + 1, column + 1)],
                        color.mix(shade).filled(),
                    ))?;
                }
            }
            if row % 5 == 4 || row == 0 {
                let middle = px(TOP + pitch * (row as f64 + 0.5));
                let number = (row + 1).to_string();
                note(area, &number, (px(LEFT - 8.0), middle), Side::Right, MUTED)?;
            }
        }
        let ends = [corner(0, 0), corner(n, 0), corner(n, n), corner(0, 0)];
        svg::line(area, ends.to_vec(), GRID, 1.0)?;
        svg::title(area, "Correlation of parameters", (px(2.0), px(13.0)))?;
        let marks = [
            (svg::Mark::Square(BLUE), "grow together"),
            (svg::Mark::Square(ORANGE), "one for the other"),
        ];
        key(area, 470.0, 13.0, &marks)?;
        if matrix.is_empty() {
            let place = (px(LEFT + 20.0), px(TOP + 20.0));
            note(area, "no parameters", place, Side::Left, INK)?;
        }
        Ok(())
    })
}
