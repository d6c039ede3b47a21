//! How many parameters flat CoP tells apart: one square for each.

use super::super::DemoReport;
use super::super::svg::{BLUE, Figure, Mark, ORANGE, PAPER, key};

/// Squares side by side and their distance, pixels.
const PER_ROW: usize = 21;
const PITCH: f64 = 22.0;
const SQUARE: f64 = 17.0;
const TOP: f64 = 30.0;

/// One square per column: told by flat CoP, told by the height of the CoM
/// alone, told by nothing.
pub fn parameters(report: &DemoReport) -> String {
    let DemoReport {
        full_params,
        base_params,
        rank_cop,
        ..
    } = *report;
    let lost = full_params.saturating_sub(base_params);
    let height = base_params.saturating_sub(rank_cop);
    let rows = full_params.div_ceil(PER_ROW).max(1) as f64;
    let label = format!(
        "Of {full_params} parameters flat CoP tells {rank_cop} apart; {height} needs the CoM \
         height; {lost} only move to a neighbour"
    );
    let mut figure = Figure::new([480.0, TOP + PITCH * rows + 4.0], &label);
    let told = format!("{rank_cop} from flat CoP");
    let constant = format!("{height} height constant");
    let sums = format!("{lost} only in sums");
    let marks = [
        (Mark::Square(BLUE), told.as_str()),
        (Mark::Square(ORANGE), constant.as_str()),
        (Mark::Box(ORANGE), sums.as_str()),
    ];
    key(&mut figure, 460.0, 12.0, &marks);
    for k in 0..full_params {
        let x = 2.0 + PITCH * (k % PER_ROW) as f64;
        let y = TOP + PITCH * (k / PER_ROW) as f64;
        let square = |inset: f64| {
            let end = SQUARE - inset;
            [[x + inset, y + inset], [x + end, y + end]]
        };
        let color = if k < rank_cop { BLUE } else { ORANGE };
        figure.fill(square(0.0), color, 1.0);
        if k >= base_params {
            figure.fill(square(1.5), PAPER, 1.0);
        }
    }
    figure.finish()
}
