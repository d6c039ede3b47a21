//! Which parameters are known together but not apart: a map of correlations.

use super::super::super::svg::{Anchor, BLUE, Figure, GRID, INK, MUTED, Mark, ORANGE, key};
use super::super::shade;

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
    let mut figure = Figure::new([480.0, TOP + WIDE + 16.0], &label);
    let corner =
        |row: usize, column: usize| [LEFT + pitch * column as f64, TOP + pitch * row as f64];
    for (row, values) in matrix.iter().enumerate() {
        for (column, &value) in values.iter().enumerate().take(row) {
            if value.is_finite() && value.abs() > FAINT {
                let color = if value > 0.0 { BLUE } else { ORANGE };
                let corners = [corner(row, column), corner(row + 1, column + 1)];
                figure.fill(corners, color, shade(value.abs()));
            }
        }
        if row % 5 == 4 || row == 0 {
            let middle = TOP + pitch * (row as f64 + 0.5);
            let number = (row + 1).to_string();
            figure.note([LEFT - 8.0, middle], Anchor::End, MUTED, &number);
        }
    }
    let ends = [corner(0, 0), corner(n, 0), corner(n, n), corner(0, 0)];
    figure.line(ends, GRID, 1.0);
    figure.title(13.0, "Correlation of parameters");
    let marks = [
        (Mark::Square(BLUE), "grow together"),
        (Mark::Square(ORANGE), "one for the other"),
    ];
    key(&mut figure, 470.0, 13.0, &marks);
    if matrix.is_empty() {
        figure.note(
            [LEFT + 20.0, TOP + 20.0],
            Anchor::Start,
            INK,
            "no parameters",
        );
    }
    figure.finish()
}
