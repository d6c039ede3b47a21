//! How much of its range every joint uses, each in units of that range.

use super::super::super::svg::{
    self, BAND, BLUE, Frame, HEADING, INK, MUTED, Mark, Side, key, note, px,
};
use super::super::fit::shortened;
use sesc_identify::plan::joint_use::JointUse;

const ROW: f64 = 20.0;
const TOP: f64 = 32.0;
const LEFT: f64 = 236.0;
const RIGHT: f64 = 910.0;
/// Ticks that stay apart.
const MOST: usize = 120;

/// One row per joint: a band for what is allowed, a tick per posture.
pub fn joints(rows: &[JointUse]) -> String {
    let bottom = TOP + ROW * rows.len().max(1) as f64;
    let label = format!("Ranges of {} joints: allowed and used", rows.len());
    svg::figure([1000, (bottom + 10.0).ceil() as u32], &label, |area| {
        let plane = Frame {
            title: "Joint ranges",
            x: 0.0..1.0,
            y: -(rows.len().max(1) as f64)..0.0,
            x_name: "",
            ticks: [0, 0],
            edges: [LEFT, TOP, RIGHT, bottom],
        }
        .draw(area)?;
        for (k, row) in rows.iter().enumerate() {
            let y = -(k as f64) - 0.5;
            let (_, middle) = plane.place(0.0, y);
            let name = shortened(&row.joint);
            note(area, &name, (px(160.0), middle), Side::Right, INK)?;
            let [low, high] = row.limits.map(|limit| number(limit, row.sliding));
            note(area, &low, (px(LEFT - 10.0), middle), Side::Right, MUTED)?;
            note(area, &high, (px(RIGHT + 10.0), middle), Side::Left, MUTED)?;
            let wide = row.limits[1] - row.limits[0];
            let share = |value: f64| match wide > 0.0 {
                true => ((value - row.limits[0]) / wide).clamp(0.0, 1.0),
                false => 0.5,
            };
            plane.line([(0.0, y), (1.0, y)], BAND, 5.0)?;
            let used = row.used.map(share).map(|x| (x, y));
            plane.line(used, BLUE, 1.75)?;
            let step = row.values.len().div_ceil(MOST).max(1);
            for value in row.values.iter().step_by(step).filter(|x| x.is_finite()) {
                let (x, _) = plane.place(share(*value), y);
                let ends = vec![(x, middle - px(4.5)), (x, middle + px(4.5))];
                svg::line(area, ends, BLUE, 1.0)?;
            }
        }
        let marks = [
            (Mark::Line(BAND, 5.0), "allowed"),
            (Mark::Stroke(BLUE), "posture"),
        ];
        key(area, RIGHT, TOP - HEADING, &marks)
    })
}

/// A limit with its unit: degrees, or mm of a sliding joint.
fn number(limit: f64, sliding: bool) -> String {
    let (value, unit) = match sliding {
        true => (1e3 * limit, " mm"),
        false => (limit.to_degrees(), "°"),
    };
    let text = format!("{:.0}{unit}", value + 0.0);
    text.replace('-', "−")
}
