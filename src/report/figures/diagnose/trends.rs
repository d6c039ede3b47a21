//! The gap against what a joint does: six small panels, joints that the explanation names
//! first and marked, then the strongest.

use super::super::super::svg::{Anchor, Axes, BLUE, Figure, HEADING, INK, MUTED, Mark, NAME};
use super::super::super::svg::{ORANGE, key, span};
use super::super::to_mm;
use sesc_identify::diagnose::view::{Middle, Trend};
use sesc_model::text::shortened;

/// Panels side by side.
const COLUMNS: usize = 2;
/// Left edge of the first, size of a plane, and from one to the next, pixels.
const LEFT: f64 = 40.0;
const PLANE: [f64; 2] = [188.0, 96.0];
const PITCH: [f64; 2] = [236.0, 162.0];
const TOP: f64 = 60.0;
/// Letters of a joint over its panel.
const LETTERS: usize = 22;

/// Residuals against `what` of the joints, mm.
pub fn trends(rows: &[Trend], what: &str) -> String {
    let label = format!(
        "Gap against {what} of {} joints, mm: before and after",
        rows.len()
    );
    let lines = rows.len().div_ceil(COLUMNS).max(1);
    let height = TOP + PITCH[1] * lines as f64 - 24.0;
    let mut figure = Figure::new([480.0, height], &label);
    figure.title(13.0, &format!("Gap in mm against the {what}"));
    let marks = [(Mark::Dot(ORANGE), "before"), (Mark::Dot(BLUE), "after")];
    key(&mut figure, 472.0, 13.0, &marks);
    for (k, row) in rows.iter().enumerate() {
        let corner = [
            LEFT + PITCH[0] * (k % COLUMNS) as f64,
            TOP + PITCH[1] * (k / COLUMNS) as f64,
        ];
        panel(&mut figure, row, corner);
    }
    if rows.is_empty() {
        figure.note([LEFT, TOP], Anchor::Start, MUTED, "no joints");
    }
    figure.finish()
}

fn panel(figure: &mut Figure, row: &Trend, [left, top]: [f64; 2]) {
    // Outliers would flatten the rest: they stay at the edge.
    let kept = row.points.iter().filter(|p| !p.outlier);
    let kept = kept.flat_map(|p| [p.before, p.after]).map(to_mm);
    let mut range = span(kept.chain([0.0]));
    if row.points.iter().any(|p| p.outlier) {
        let more = 0.08 * (range.end - range.start);
        range = range.start - more..range.end + more;
    }
    let inside = 0.05 * (range.end - range.start);
    let (low, high) = (range.start + inside, range.end - inside);
    let along = span(row.points.iter().map(|p| p.at));
    let [before, after] = row.share.map(|share| 100.0 * share.max(0.0));
    let plane = Axes {
        title: "",
        x: along.clone(),
        y: range,
        x_name: &format!("{}: {before:.0} % before, {after:.0} % after", row.unit),
        ticks: [5, 4],
        edges: [left, top, left + PLANE[0], top + PLANE[1]],
    }
    .draw(figure);
    let axis = ["x", "y"][row.axis];
    // What is named is marked at the other end of the line.
    let letters = if row.named { LETTERS - 10 } else { LETTERS };
    let name = format!("{} ({axis})", shortened(&row.joint, letters));
    let place = [left, top - HEADING + 6.0];
    figure.text(place, Anchor::Start, NAME, INK, &name);
    if row.named {
        // Letters in orange are too pale to read.
        let [right, middle] = [left + PLANE[0], place[1]];
        key(figure, right, middle, &[(Mark::Square(ORANGE), "named")]);
    }
    let zero = [along.start, along.end].map(|x| plane.at([x, 0.0]));
    figure.line(zero, INK, 1.0);
    for point in &row.points {
        let at = |value: f64| plane.at([point.at, to_mm(value).clamp(low, high)]);
        figure.posture(point.posture, |figure| {
            figure.dot(at(point.before), 1.4, ORANGE);
            figure.dot(at(point.after), 1.4, BLUE);
            if point.outlier {
                figure.boxed(at(point.after), 3.5);
            }
        });
    }
    type Pick = fn(&Middle) -> f64;
    let picks: [(Pick, _); 2] = [(|m| m.before, ORANGE), (|m| m.after, BLUE)];
    for (pick, color) in picks {
        let means = row.means.iter().map(|m| plane.at([m.at, to_mm(pick(m))]));
        figure.line(means, color, 1.75);
    }
}
