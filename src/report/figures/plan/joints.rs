//! How much of its range every joint uses, each in units of that range.

use super::super::super::svg::{Anchor, Axes, BAND, BLUE, Figure, HEADING, INK, MUTED, Mark, key};
use sesc_identify::plan::joint_use::JointUse;
use sesc_model::text::shortened;

const ROW: f64 = 20.0;
const TOP: f64 = 32.0;
const LEFT: f64 = 236.0;
const RIGHT: f64 = 910.0;
/// Letters of a joint before its row.
const NAME: usize = 23;
/// Ticks that stay apart.
const MOST: usize = 120;

/// One row per joint: a band for what is allowed, a tick per posture.
pub fn joints(rows: &[JointUse]) -> String {
    let count = rows.len().max(1) as f64;
    let bottom = TOP + ROW * count;
    let label = format!("Ranges of {} joints: allowed and used", rows.len());
    let mut figure = Figure::new([1000.0, bottom + 10.0], &label);
    let plane = Axes {
        title: "Joint ranges",
        x: 0.0..1.0,
        y: -count..0.0,
        x_name: "",
        ticks: [0, 0],
        edges: [LEFT, TOP, RIGHT, bottom],
    }
    .draw(&mut figure);
    for (k, row) in rows.iter().enumerate() {
        let at = |x: f64| plane.at([x, -(k as f64) - 0.5]);
        let [_, middle] = at(0.0);
        let name = shortened(&row.joint, NAME);
        figure.note([170.0, middle], Anchor::End, INK, &name);
        let [low, high] = row.limits.map(|limit| number(limit, row.prismatic));
        figure.note([LEFT - 10.0, middle], Anchor::End, MUTED, &low);
        figure.note([RIGHT + 10.0, middle], Anchor::Start, MUTED, &high);
        let wide = row.limits[1] - row.limits[0];
        let share = |value: f64| match wide > 0.0 {
            true => ((value - row.limits[0]) / wide).clamp(0.0, 1.0),
            false => 0.5,
        };
        figure.line([at(0.0), at(1.0)], BAND, 5.0);
        figure.line(row.used.map(|value| at(share(value))), BLUE, 1.75);
        let step = row.values.len().div_ceil(MOST).max(1);
        let ticks = row.values.iter().step_by(step).map(|value| {
            let [x, y] = at(share(*value));
            [[x, y - 4.5], [x, y + 4.5]]
        });
        figure.lines(ticks, BLUE, 1.0);
    }
    let marks = [
        (Mark::Line(BAND, 5.0), "allowed"),
        (Mark::Stroke(BLUE), "posture"),
    ];
    key(&mut figure, RIGHT, TOP - HEADING, &marks);
    figure.finish()
}

/// A limit with its unit: degrees, or mm of a prismatic joint.
fn number(limit: f64, prismatic: bool) -> String {
    let (value, unit) = match prismatic {
        true => (1e3 * limit, " mm"),
        false => (limit.to_degrees(), "°"),
    };
    let text = format!("{:.0}{unit}", value + 0.0);
    text.replace('-', "−")
}
