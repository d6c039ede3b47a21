//! How far each parameter moved from CAD, in units of what it is known to.

use super::super::super::svg::{
    self, BAND, BLUE, Frame, GRID, HEADING, INK, Mark, Side, fill, key, note, px, span,
};
use super::shortened;
use sesc_identify::fit::identification::ParameterFound;

const ROW: f64 = 15.0;
const TOP: f64 = 32.0;
const RIGHT: f64 = 470.0;
/// Rows that a page bears.
const MOST: usize = 48;

/// One bar per parameter, the largest changes first.
pub fn changes(parameters: &[ParameterFound]) -> String {
    let change = |parameter: &ParameterFound| {
        let std = parameter.std.filter(|std| *std > 0.0)?;
        Some((parameter.value - parameter.cad) / std).filter(|change| change.is_finite())
    };
    let mut rows: Vec<(&str, f64)> = parameters
        .iter()
        .filter_map(|parameter| Some((parameter.name.as_str(), change(parameter)?)))
        .collect();
    rows.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    rows.truncate(MOST);
    let bottom = TOP + ROW * rows.len().max(1) as f64;
    let size = [480, (bottom + 24.0).ceil() as u32];
    let label = format!(
        "Change from CAD of {} parameters in standard deviations",
        rows.len()
    );
    svg::figure(size, &label, |area| {
        let range = span(rows.iter().map(|row| row.1).chain([-2.2, 2.2]));
        let plane = Frame {
            title: "Change from CAD, std",
            x: range.clone(),
            y: -(rows.len().max(1) as f64)..0.0,
            x_name: "",
            ticks: [7, 0],
            edges: [148.0, TOP, RIGHT, bottom],
        }
        .draw(area)?;
        // Within two deviations a change may be chance.
        let (corner, other) = (
            plane.place(-2.0, 0.0),
            plane.place(2.0, -(rows.len() as f64)),
        );
        fill(area, [corner, other], GRID)?;
        plane.line([(0.0, 0.0), (0.0, -(rows.len() as f64))], BAND, 1.0)?;
        for (k, (name, change)) in rows.iter().enumerate() {
            let y = -(k as f64) - 0.5;
            let (left, middle) = plane.place(range.start, y);
            let place = (left - px(8.0), middle);
            note(area, &shortened(name), place, Side::Right, INK)?;
            plane.line([(0.0, y), (*change, y)], BLUE, 2.0)?;
            plane.mark(*change, y, Mark::Dot(BLUE))?;
        }
        let marks = [(Mark::Square(GRID), "±2: may be chance")];
        key(area, RIGHT, TOP - HEADING, &marks)
    })
}
