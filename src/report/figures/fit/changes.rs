//! How far each parameter moved, from CAD or from another day, in units of what it is known to.

use super::super::super::svg::{Anchor, Axes, BAND, BLUE, Figure, GRID, HEADING, INK, Mark};
use super::super::super::svg::{key, span};
use super::NAME;
use sesc_identify::fit::ParameterFound;
use sesc_model::text::shortened;

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
    let rows = parameters.iter();
    let rows = rows.filter_map(|parameter| Some((parameter.name.as_str(), change(parameter)?)));
    deviations("Change from CAD, std", rows.collect())
}

/// One bar per name, the largest deviations first.
pub fn deviations(title: &str, mut rows: Vec<(&str, f64)>) -> String {
    rows.retain(|row| row.1.is_finite());
    rows.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    rows.truncate(MOST);
    let count = rows.len().max(1) as f64;
    let bottom = TOP + ROW * count;
    let label = format!("{title}: {} parameters in standard deviations", rows.len());
    let mut figure = Figure::new([480.0, bottom + 24.0], &label);
    let range = span(rows.iter().map(|row| row.1).chain([-2.2, 2.2]));
    let plane = Axes {
        title,
        x: range.clone(),
        y: -count..0.0,
        x_name: "",
        ticks: [7, 0],
        edges: [158.0, TOP, RIGHT, bottom],
    }
    .draw(&mut figure);
    // Within two deviations a change may be chance.
    figure.fill(
        [[-2.0, 0.0], [2.0, -count]].map(|at| plane.at(at)),
        GRID,
        1.0,
    );
    figure.line(
        [[0.0, 0.0], [0.0, -count]].map(|at| plane.at(at)),
        BAND,
        1.0,
    );
    for (k, (name, change)) in rows.iter().enumerate() {
        let at = |x: f64| plane.at([x, -(k as f64) - 0.5]);
        let [left, middle] = at(range.start);
        let short = shortened(name, NAME);
        figure.note([left - 8.0, middle], Anchor::End, INK, &short);
        figure.line([at(0.0), at(*change)], BLUE, 2.0);
        let words = format!("{name} · {change:+.1} standard deviations").replace('-', "−");
        figure.worded(&words, |figure| figure.mark(at(*change), Mark::Dot(BLUE)));
    }
    let marks = [(Mark::Square(GRID), "±2: may be chance")];
    key(&mut figure, RIGHT, TOP - HEADING, &marks);
    figure.finish()
}
