//! The gap against what a joint does: six small panels, the strongest first.

use super::super::super::svg::{
    self, Area, BLUE, Drawn, Frame, HEADING, INK, MUTED, Mark, ORANGE, Side, key, note, px, title,
    write,
};
use super::super::to_mm;
use super::{boxed, dot, room, shortened};
use sesc_identify::diagnose::view::Trend;

/// Panels side by side.
const COLUMNS: usize = 2;
/// Left edge of the first, width of a plane, and from one to the next, pixels.
const LEFT: f64 = 40.0;
const PLANE: [f64; 2] = [188.0, 96.0];
const PITCH: [f64; 2] = [236.0, 162.0];
const TOP: f64 = 60.0;
/// Letters of a joint over its panel.
const NAME: usize = 22;

/// Residuals against `what` of the joints, mm.
pub fn trends(rows: &[Trend], what: &str) -> String {
    let label = format!(
        "Gap against {what} of {} joints, mm: before and after",
        rows.len()
    );
    let lines = rows.len().div_ceil(COLUMNS).max(1);
    let height = TOP + PITCH[1] * lines as f64 - 24.0;
    svg::figure([480, height as u32], &label, |area| {
        title(area, &format!("Against the {what}"), (px(2.0), px(13.0)))?;
        let marks = [(Mark::Dot(ORANGE), "before"), (Mark::Dot(BLUE), "after")];
        key(area, 472.0, 13.0, &marks)?;
        for (k, row) in rows.iter().enumerate() {
            let corner = [
                LEFT + PITCH[0] * (k % COLUMNS) as f64,
                TOP + PITCH[1] * (k / COLUMNS) as f64,
            ];
            panel(area, row, corner)?;
        }
        if rows.is_empty() {
            let place = (px(LEFT), px(TOP));
            note(area, "no joints", place, Side::Left, MUTED)?;
        }
        Ok(())
    })
}

fn panel(area: &Area<'_>, row: &Trend, [left, top]: [f64; 2]) -> Drawn {
    let [right, bottom] = [left + PLANE[0], top + PLANE[1]];
    // Outliers would flatten the rest: they stay at the edge.
    let kept = row.points.iter().filter(|p| !p.outlier);
    let kept = kept.flat_map(|p| [p.before, p.after]).map(to_mm);
    let mut range = room(kept.chain([0.0]));
    if row.points.iter().any(|p| p.outlier) {
        let more = 0.08 * (range.end - range.start);
        range = range.start - more..range.end + more;
    }
    let inside = 0.05 * (range.end - range.start);
    let within = |value: f64| to_mm(value).clamp(range.start + inside, range.end - inside);
    let along = room(row.points.iter().map(|p| p.at));
    let x_name = format!(
        "{}: {:.0} % before, {:.0} % after",
        row.unit,
        100.0 * row.share[0].max(0.0),
        100.0 * row.share[1].max(0.0)
    );
    let plane = Frame {
        title: "",
        x: along.clone(),
        y: range.clone(),
        x_name: &x_name,
        ticks: [5, 4],
        edges: [left, top, right, bottom],
    }
    .draw(area)?;
    let name = format!("{} ({})", shortened(&row.joint, NAME), ["x", "y"][row.axis]);
    let place = (px(left), px(top - HEADING + 6.0));
    write(area, &name, place, Side::Left, 12.0, INK, true)?;
    plane.line([(along.start, 0.0), (along.end, 0.0)], INK, 1.0)?;
    for point in row.points.iter().filter(|p| p.at.is_finite()) {
        for (value, color) in [(point.before, ORANGE), (point.after, BLUE)] {
            if value.is_finite() {
                dot(area, plane.place(point.at, within(value)), 1.4, color)?;
            }
        }
        if point.outlier && point.after.is_finite() {
            boxed(area, plane.place(point.at, within(point.after)), 3.5)?;
        }
    }
    for (pick, color) in [(0, ORANGE), (1, BLUE)] {
        let mean = |m: &sesc_identify::diagnose::view::Middle| {
            (m.at, to_mm(if pick == 0 { m.before } else { m.after }))
        };
        plane.line(row.means.iter().map(mean), color, 1.75)?;
    }
    Ok(())
}
