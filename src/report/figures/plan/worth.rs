//! The error to expect over the number of postures, planned and at random.

use super::super::super::svg::{
    self, BLUE, Frame, HEADING, INK, MUTED, Mark, Side, key, note, px, span,
};
use super::super::super::table::mm;
use super::super::to_mm;
use sesc_identify::plan::worth::Worth;

const EDGES: [f64; 4] = [44.0, 32.0, 474.0, 366.0];
/// Random postures that hardly tell all directions are off by anything: what is
/// higher than so many times the last of them is not drawn.
const HIGHEST: f64 = 6.0;

/// Planned postures and as many random ones of the same candidates.
pub fn worth(curve: &[Worth]) -> String {
    let label = match curve.last() {
        Some(last) => format!(
            "Expected error over the number of postures: {} mm of {} planned, {} mm of random ones",
            mm(last.planned),
            last.postures,
            mm(last.random)
        ),
        None => "Expected error over the number of postures: not known".to_string(),
    };
    svg::figure([480, 400], &label, |area| {
        let highest = curve.last().map_or(0.0, |last| HIGHEST * last.random);
        let of = |pick: fn(&Worth) -> f64| {
            let low = move |worth: &&Worth| pick(worth) <= highest;
            let point = move |worth: &Worth| (worth.postures as f64, to_mm(pick(worth)));
            curve.iter().filter(low).map(point)
        };
        let (mut planned, mut random) = (of(|worth| worth.planned), of(|worth| worth.random));
        let both: Vec<(f64, f64)> = planned.clone().chain(random.clone()).collect();
        let x = span(both.iter().map(|point| point.0));
        let y = span(both.iter().map(|point| point.1).chain([0.0]));
        let plane = Frame {
            title: "Expected error of the CoP, mm",
            x: x.start.max(0.0)..x.end,
            y: y.start.max(0.0)..y.end,
            x_name: "postures",
            ticks: [6, 6],
            edges: EDGES,
        }
        .draw(area)?;
        if curve.is_empty() {
            let place = (px(EDGES[0] + 20.0), px(EDGES[1] + 20.0));
            let why = "these postures leave directions open";
            return note(area, why, place, Side::Left, MUTED);
        }
        plane.line(random.clone(), MUTED, 1.75)?;
        plane.line(planned.clone(), BLUE, 1.75)?;
        // One number above its line, one below.
        let ends = [
            (random.next_back(), Mark::Ring(MUTED), -13.0),
            (planned.next_back(), Mark::Dot(BLUE), 13.0),
        ];
        for (point, mark, beside) in ends {
            let Some((x, y)) = point else { continue };
            plane.mark(x, y, mark)?;
            let (right, middle) = plane.place(x, y);
            let text = format!("{} mm", mm(1e-3 * y));
            note(area, &text, (right, middle + px(beside)), Side::Right, INK)?;
        }
        let marks = [
            (Mark::Line(MUTED, 1.75), "random"),
            (Mark::Line(BLUE, 1.75), "planned"),
        ];
        key(area, EDGES[2], EDGES[1] - HEADING, &marks)
    })
}
