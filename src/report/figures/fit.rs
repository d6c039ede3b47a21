//! Figures of an identification: what was found, rows in, SVG out.

#[cfg(test)]
mod tests;

use super::super::svg::{
    Anchor, Axes, BAND, BLUE, Figure, GRID, HEADING, INK, MUTED, Mark, ORANGE,
};
use super::super::svg::{key, span};
use super::arrows::{Arrows, Gap};
use super::bars::{self, Bar};
use super::{shade, to_mm};
use sesc_identify::fit::residuals::{Residual, rms_lengths};
use sesc_identify::fit::{BodyLength, Identification, ParameterFound};
use sesc_model::text::apart;

/// Top and right edge of a plane.
const TOP: f64 = 32.0;
const RIGHT: f64 = 470.0;
/// Letters of a name that fit beside a plane.
const NAME: usize = 21;
/// Arrows that stay readable.
const MOST: usize = 400;

/// From CAD's error to the fit's to the noise: what was gained and what is left.
pub fn waterfall(found: &Identification) -> String {
    let bars = [
        ("CAD", found.cad_rmse, MUTED),
        ("unseen postures", found.held_out_rmse, BLUE),
        ("fitted postures", found.in_sample_rmse, BLUE),
        ("noise alone", found.noise_floor, INK),
        ("model alone", found.expected_error_data, ORANGE),
    ];
    let bars = bars.map(|(name, length_m, color)| Bar {
        name,
        length_m,
        color,
        pale: false,
    });
    bars::waterfall("RMS error per axis", &bars, found.noise_floor)
}

/// Rows that figures show.
pub fn some(rows: &[Residual]) -> impl Iterator<Item = &Residual> {
    rows.iter().step_by(rows.len().div_ceil(MOST).max(1))
}

/// CAD's residuals, as they stand beside the robot.
pub fn sole_beside(rows: &[Residual]) -> String {
    of_rows(rows).beside_the_robot("CoP on the ground")
}

/// Residuals where they were measured: CAD's and the fit's, at one scale.
pub fn sole(rows: &[Residual]) -> [String; 2] {
    let arrows = of_rows(rows);
    [
        arrows.draw(0, "CAD", MUTED),
        arrows.draw(1, "The fit", BLUE),
    ]
}

fn of_rows(rows: &[Residual]) -> Arrows {
    let gap = |row: &Residual| Gap {
        measured: row.measured,
        predicted: [row.cad, row.fitted],
        outlier: false,
    };
    Arrows {
        gaps: some(rows).map(gap).collect(),
        rms: rms_lengths(rows),
        foot: None,
        sole: Vec::new(),
        cells: Vec::new(),
    }
}

// ‖r_i‖ from CAD and identified, body by body, with one standard deviation.

/// Height of a body's row, pixels.
const BODY_ROW: f64 = 18.0;

/// One row per body, outward from the support.
pub fn bodies(rows: &[BodyLength]) -> String {
    let count = rows.len().max(1) as f64;
    let bottom = TOP + BODY_ROW * count;
    let label = format!("‖r‖ of {} bodies, mm: CAD and identified", rows.len());
    let mut figure = Figure::new([480.0, bottom + 24.0], &label);
    let ends = rows.iter().flat_map(|row| {
        let wide = row.std.unwrap_or(0.0);
        [row.cad, row.identified - wide, row.identified + wide]
    });
    let range = span(ends.map(to_mm).chain([0.0]));
    let low = range.start.min(0.0);
    let plane = Axes {
        title: "‖r‖ per body, mm",
        x: low..range.end,
        y: -count..0.0,
        x_name: "",
        ticks: [7, 0],
        edges: [158.0, TOP, RIGHT, bottom],
    }
    .draw(&mut figure);
    let names: Vec<&str> = rows.iter().map(|row| row.body.as_str()).collect();
    let names = apart(&names, NAME);
    for (k, row) in rows.iter().enumerate() {
        let at = |x: f64| plane.at([x, -(k as f64) - 0.5]);
        let [left, middle] = at(low);
        figure.line([at(low), at(range.end)], GRID, 1.0);
        figure.note([left - 8.0, middle], Anchor::End, INK, &names[k]);
        let found = to_mm(row.identified);
        figure.mark(at(to_mm(row.cad)), Mark::Stroke(INK));
        // What is no number is not drawn.
        if !found.is_finite() || !row.cad.is_finite() {
            continue;
        }
        let lengths = format!("CAD {:.2} mm, identified {found:.2}", to_mm(row.cad));
        let (words, mark) = match row.std.map(to_mm).filter(|wide| wide.is_finite()) {
            Some(wide) => {
                figure.line([at(found - wide), at(found + wide)], BLUE, 2.0);
                let words = format!("{} · {lengths} ± {wide:.2} mm", row.body);
                (words, Mark::Dot(BLUE))
            }
            None => {
                let words = format!("{} · {lengths} mm, which data do not tell", row.body);
                (words, Mark::Ring(ORANGE))
            }
        };
        figure.worded(&words, |figure| figure.mark(at(found), mark));
    }
    let mut marks = vec![
        (Mark::Stroke(INK), "CAD"),
        (Mark::Dot(BLUE), "identified ± std"),
    ];
    if rows.iter().any(|row| row.std.is_none()) {
        marks.push((Mark::Ring(ORANGE), "not told"));
    }
    key(&mut figure, RIGHT, TOP - HEADING, &marks);
    figure.finish()
}

// How far each parameter moved, from CAD or from another day, in units of what it is known to.

const CHANGE_ROW: f64 = 15.0;
/// Rows that a page bears.
const CHANGES: usize = 48;

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
    rows.truncate(CHANGES);
    let count = rows.len().max(1) as f64;
    let bottom = TOP + CHANGE_ROW * count;
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
    let names: Vec<&str> = rows.iter().map(|(name, _)| *name).collect();
    let names = apart(&names, NAME);
    for (k, (name, change)) in rows.iter().enumerate() {
        let at = |x: f64| plane.at([x, -(k as f64) - 0.5]);
        let [left, middle] = at(range.start);
        figure.note([left - 8.0, middle], Anchor::End, INK, &names[k]);
        figure.line([at(0.0), at(*change)], BLUE, 2.0);
        let words = format!("{name} · {change:+.1} standard deviations").replace('-', "−");
        figure.worded(&words, |figure| figure.mark(at(*change), Mark::Dot(BLUE)));
    }
    let marks = [(Mark::Square(GRID), "±2: may be chance")];
    key(&mut figure, RIGHT, TOP - HEADING, &marks);
    figure.finish()
}

// Which parameters are known together but not apart: a map of correlations.

/// Side of the map, pixels, and where it starts.
const MAP_WIDE: f64 = 420.0;
const MAP_LEFT: f64 = 50.0;
const MAP_TOP: f64 = 40.0;
/// Weaker ones are left blank.
const FAINT: f64 = 0.1;

/// The triangle of correlations, one square per pair, numbered as in the table.
pub fn correlation(matrix: &[Vec<f64>]) -> String {
    let n = matrix.len().max(1);
    let pitch = MAP_WIDE / n as f64;
    let label = format!("Correlations between {} parameters", matrix.len());
    let mut figure = Figure::new([480.0, MAP_TOP + MAP_WIDE + 16.0], &label);
    let corner = |row: usize, column: usize| {
        [
            MAP_LEFT + pitch * column as f64,
            MAP_TOP + pitch * row as f64,
        ]
    };
    for (row, values) in matrix.iter().enumerate() {
        for (column, &value) in values.iter().enumerate().take(row) {
            if value.is_finite() && value.abs() > FAINT {
                let color = if value > 0.0 { BLUE } else { ORANGE };
                let corners = [corner(row, column), corner(row + 1, column + 1)];
                figure.fill(corners, color, shade(value.abs()));
            }
        }
        if row % 5 == 4 || row == 0 {
            let middle = MAP_TOP + pitch * (row as f64 + 0.5);
            let number = (row + 1).to_string();
            figure.note([MAP_LEFT - 8.0, middle], Anchor::End, MUTED, &number);
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
            [MAP_LEFT + 20.0, MAP_TOP + 20.0],
            Anchor::Start,
            INK,
            "no parameters",
        );
    }
    figure.finish()
}
