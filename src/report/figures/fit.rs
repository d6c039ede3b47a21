//! Figures of an identification: what was found, rows in, SVG out.

#[cfg(test)]
mod tests;

use super::super::plot::{Mark, Panel, Point, area, rule, segments, series, span};
use super::super::robot::Shown;
use super::super::svg::{BAND, BLUE, GRID, INK, MUTED, ORANGE};
use super::arrows::Arrows;
use super::{Bar, HALF, Length, pairs, shade, to_mm};
use sesc_identify::fit::residuals::{Residual, rms_lengths};
use sesc_identify::fit::{BodyLength, Identification, ParameterFound};
use sesc_model::text::apart;

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
    let bars = bars.map(|(name, length_m, color)| Bar::new(name, length_m, color));
    super::waterfall("RMS error per axis", &bars, found.noise_floor)
}

/// Rows that figures show, as the page shows them.
pub fn postures(rows: &[Residual]) -> Vec<Shown> {
    let some = rows.iter().step_by(rows.len().div_ceil(MOST).max(1));
    some.map(|row| Shown {
        pose: row.pose,
        q: row.q.clone(),
        measured: Some(row.measured),
        predicted: Some([row.cad, row.fitted]),
        ..Shown::default()
    })
    .collect()
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

fn of_rows(rows: &[Residual]) -> Arrows<'_> {
    Arrows {
        postures: postures(rows),
        rms: rms_lengths(rows),
        ..Arrows::default()
    }
}

// ‖r_i‖ from CAD and identified, body by body, with one standard deviation.

/// One row per body, outward from the support.
pub fn bodies(rows: &[BodyLength]) -> String {
    let lengths = rows.iter().map(|row| {
        let std = row.std.filter(|std| std.is_finite());
        let wide = std.unwrap_or(0.0);
        Length {
            body: &row.body,
            cad: row.cad,
            found: row.identified,
            line: [row.identified - wide, row.identified + wide],
            is_told: std.is_some(),
            more: match std {
                Some(std) => format!(" ± {:.2} mm", to_mm(std)),
                None => " mm, which data do not tell".to_string(),
            },
        }
    });
    let lengths: Vec<Length<'_>> = lengths.collect();
    let names = ["identified ± std", "not told"];
    let mut panel = super::lengths("‖r‖ per body, mm", &lengths, names);
    panel.series.push(rule(0, 0.0, GRID, 1.0));
    let label = format!("‖r‖ of {} bodies, mm: CAD and identified", rows.len());
    panel.alone(HALF, label)
}

// How far each parameter moved, from CAD or from another day, in units of what it is known to.

/// Rows that a page bears.
const CHANGES: usize = 48;

/// How far a parameter is from CAD, in its standard deviations.
pub fn moved(parameter: &ParameterFound) -> Option<f64> {
    let std = parameter.std.filter(|std| *std > 0.0)?;
    Some((parameter.value - parameter.cad) / std)
}

/// One bar per parameter, the largest changes first.
pub fn changes(parameters: &[ParameterFound]) -> String {
    let rows = parameters.iter();
    let rows = rows.filter_map(|own| Some((own.name.as_str(), moved(own)?)));
    deviations("Change from CAD, std", rows.collect())
}

/// One bar per name, the largest deviations first.
pub fn deviations(title: &str, mut rows: Vec<(&str, f64)>) -> String {
    rows.retain(|row| row.1.is_finite());
    rows.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    rows.truncate(CHANGES);
    let names: Vec<&str> = rows.iter().map(|(name, _)| *name).collect();
    let low = -(rows.len() as f64);
    let bars = || {
        rows.iter()
            .zip(0..)
            .map(|(own, k)| (own, -f64::from(k) - 0.5))
    };
    let ends = bars().map(|((name, change), y)| {
        let words = format!("{name} · {change:+.1} standard deviations").replace('-', "−");
        Point::worded(words, [*change, y])
    });
    let bars = bars().map(|((_, change), y)| [0.0, *change].map(|x| [x, y]));
    let panel = Panel {
        title: title.to_string(),
        x: Some(span(rows.iter().map(|row| row.1).chain([-2.2, 2.2]))),
        ticks: [7, 0],
        rows: apart(&names, NAME),
        height: 15.0 * rows.len().max(1) as f64,
        series: vec![
            // Within two deviations a change may be chance.
            area(GRID, 1.0, [[-2.0, 0.0], [2.0, low]]).named("±2: may be chance"),
            rule(0, 0.0, BAND, 1.0),
            segments(BLUE, 2.0, bars),
            series(Mark::dot(BLUE), ends),
        ],
        ..Panel::default()
    };
    let label = format!("{title}: {} parameters in standard deviations", rows.len());
    panel.alone(HALF, label)
}

/// Weaker correlations are left blank.
const FAINT: f64 = 0.1;

/// Which parameters are known together but not apart: the triangle of correlations, one square per
/// pair, numbered as in the table.
pub fn correlation(matrix: &[Vec<f64>]) -> String {
    let square = |row: usize, column: usize| {
        let value = *matrix[row].get(column).filter(|_| column < row)?;
        let opacity = shade(value.abs());
        let color = if value > 0.0 { BLUE } else { ORANGE };
        (value.abs() > FAINT).then(|| (color, opacity, String::new()))
    };
    let mut panel = pairs("Correlation of parameters", matrix.len(), square);
    panel.key = vec![
        (Mark::Square(BLUE, 9.0), "grow together"),
        (Mark::Square(ORANGE, 9.0), "one for the other"),
    ];
    let end = matrix.len() as f64;
    let triangle = [[0.0, 0.0], [0.0, -end], [end, -end], [0.0, 0.0]];
    panel.series.push(series(Mark::Line(GRID, 1.0), triangle));
    let label = format!("Correlations between {} parameters", matrix.len());
    panel.alone(HALF, label)
}
