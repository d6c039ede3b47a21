//! The gap against what an effect predicts of it: a pair of panels an effect, x and y, with
//! the straight line on which the gap lies if the effect explains all of it.

use super::super::super::svg::{Anchor, Axes, BLUE, Figure, HEADING, INK, MUTED, Mark, NAME};
use super::super::super::svg::{ORANGE, key, span};
use super::super::to_mm;
use super::WIDE;
use sesc_identify::diagnose::view::Predicted;
use sesc_model::text::shortened;

/// Panels side by side, their left edges, size of a plane, and from one row to the next, pixels.
const LEFT: [f64; 2] = [52.0, 548.0];
const PLANE: [f64; 2] = [420.0, 150.0];
const PITCH: f64 = 222.0;
const TOP: f64 = 62.0;
/// Letters of a subject over its panel.
const LETTERS: usize = 44;

/// A pair of panels for each effect, mm.
pub fn predicted(rows: &[Predicted]) -> String {
    let label = format!(
        "Gap against what the named effects predict of it, mm: {}",
        rows.iter()
            .step_by(2)
            .map(|row| row.subject.as_str())
            .collect::<Vec<_>>()
            .join("; ")
    );
    let lines = rows.len().div_ceil(2).max(1);
    let height = TOP + PITCH * lines as f64 - 12.0;
    let mut figure = Figure::new([WIDE, height], &label);
    figure.title(
        13.0,
        "Gap in mm against the change that the named effect predicts",
    );
    let marks = [
        (Mark::Dot(ORANGE), "a posture"),
        (Mark::Line(INK, 1.0), "gap = predicted change"),
        (Mark::Line(BLUE, 1.75), "line that fits best"),
    ];
    key(&mut figure, WIDE - 8.0, 13.0, &marks);
    for (k, row) in rows.iter().enumerate() {
        panel(
            &mut figure,
            row,
            [LEFT[k % 2], TOP + PITCH * (k / 2) as f64],
        );
    }
    if rows.is_empty() {
        figure.note(
            [LEFT[0], TOP],
            Anchor::Start,
            MUTED,
            "no effect changes readings",
        );
    }
    figure.finish()
}

fn panel(figure: &mut Figure, row: &Predicted, [left, top]: [f64; 2]) {
    let kept = || row.points.iter().filter(|p| !p.outlier);
    let along = span(row.points.iter().map(|p| to_mm(p.change)).chain([0.0]));
    // Outliers would flatten the rest: they stay at the edge. The lines are in sight.
    let gaps = kept().map(|p| to_mm(p.gap));
    let range = span(gaps.chain(kept().map(|p| to_mm(p.change))).chain([0.0]));
    let inside = 0.03 * (range.end - range.start);
    let (low, high) = (range.start + inside, range.end - inside);
    let plane = Axes {
        title: "",
        x: along.clone(),
        y: range.clone(),
        x_name: &match row.slope.is_finite() {
            true => format!("predicted change, mm; slope {:.2}", row.slope),
            false => "predicted change, mm".to_string(),
        },
        ticks: [7, 5],
        edges: [left, top, left + PLANE[0], top + PLANE[1]],
    }
    .draw(figure);
    let name = format!(
        "{} ({})",
        shortened(&row.subject, LETTERS),
        ["x", "y"][row.axis]
    );
    figure.text([left, top - HEADING + 6.0], Anchor::Start, NAME, INK, &name);
    let ends = [along.start.max(range.start), along.end.min(range.end)];
    figure.line(ends.map(|x| plane.at([x, x])), INK, 1.0);
    for point in &row.points {
        let at = plane.at([to_mm(point.change), to_mm(point.gap).clamp(low, high)]);
        figure.posture(point.posture, |figure| {
            figure.dot(at, 2.2, ORANGE);
            if point.outlier {
                figure.boxed(at, 4.0);
            }
        });
    }
    // Cut where it leaves the panel.
    let fitted = |x: f64| [x, (row.slope * x).clamp(range.start, range.end)];
    figure.line(
        [along.start, along.end].map(|x| plane.at(fitted(x))),
        BLUE,
        1.75,
    );
}
