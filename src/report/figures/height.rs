//! CoM height over postures (the paper's Fig. 8): its shape is known, one
//! constant is not.

use super::super::HeightRow;
use super::super::svg::{
    self, BAND, BLUE, Frame, HEADING, INK, Mark, ORANGE, Side, key, note, px, span,
};
use super::super::table::mm;
use super::to_mm;

const SIZE: [u32; 2] = [480, 270];
const EDGES: [f64; 4] = [44.0, 32.0, 474.0, 236.0];

/// The identified height with the constant of minimum norm, off by `offset_m`.
pub fn height_level(rows: &[HeightRow], offset_m: f64) -> String {
    let label = format!(
        "CoM height over {} postures: identified lies {} mm off the truth",
        rows.len(),
        mm(offset_m)
    );
    svg::figure(SIZE, &label, |area| {
        let heights = rows.iter().flat_map(|row| [row.truth, row.identified]);
        let plane = Frame {
            title: "CoM height as fitted, mm",
            x: 0.0..(rows.len() + 1) as f64,
            y: span(heights.map(to_mm).chain([0.0])),
            x_name: "posture",
            ticks: [6, 6],
            edges: EDGES,
        }
        .draw(area)?;
        plane.line(curve(rows, |row| row.truth), BAND, 7.0)?;
        for ((x, truth), (_, identified)) in
            curve(rows, |row| row.truth).zip(curve(rows, |row| row.identified))
        {
            plane.line([(x, truth), (x, identified)], ORANGE, 0.75)?;
        }
        plane.line(curve(rows, |row| row.identified), ORANGE, 1.75)?;
        // The text stands under the curves where it has room.
        let (left, lowest) = plane.place(0.0, to_mm(lowest_m(rows)));
        if px(EDGES[3]) - lowest > px(48.0) {
            let text = format!("on average {} mm apart:", mm(offset_m.abs()));
            let middle = (px(EDGES[3]) + lowest) / 2;
            note(
                area,
                &text,
                (left + px(20.0), middle - px(8.0)),
                Side::Left,
                INK,
            )?;
            let text = "one constant that flat CoP cannot tell";
            note(
                area,
                text,
                (left + px(20.0), middle + px(8.0)),
                Side::Left,
                INK,
            )?;
        }
        let marks = [
            (Mark::Line(BAND, 7.0), "truth"),
            (Mark::Line(ORANGE, 1.75), "identified"),
        ];
        key(area, EDGES[2], EDGES[1] - HEADING, &marks)
    })
}

/// The identified height with its constant from CAD, magnified.
pub fn height_shape(rows: &[HeightRow]) -> String {
    let label = format!(
        "CoM height over {} postures with the constant from CAD: identified follows the truth",
        rows.len()
    );
    svg::figure(SIZE, &label, |area| {
        let heights = rows.iter().flat_map(|row| [row.truth, row.anchored]);
        let plane = Frame {
            title: "CoM height, constant from CAD, mm",
            x: 0.0..(rows.len() + 1) as f64,
            y: span(heights.map(to_mm)),
            x_name: "posture",
            ticks: [6, 6],
            edges: EDGES,
        }
        .draw(area)?;
        plane.line(curve(rows, |row| row.truth), BAND, 7.0)?;
        plane.line(curve(rows, |row| row.anchored), BLUE, 1.75)?;
        let marks = [
            (Mark::Line(BAND, 7.0), "truth"),
            (Mark::Line(BLUE, 1.75), "identified"),
        ];
        key(area, EDGES[2], EDGES[1] - HEADING, &marks)
    })
}

/// The lowest height drawn, or zero without any, m.
fn lowest_m(rows: &[HeightRow]) -> f64 {
    let heights = rows.iter().flat_map(|row| [row.truth, row.identified]);
    heights
        .filter(|height| height.is_finite())
        .reduce(f64::min)
        .unwrap_or(0.0)
}

fn curve(rows: &[HeightRow], pick: fn(&HeightRow) -> f64) -> impl Iterator<Item = (f64, f64)> {
    rows.iter()
        .enumerate()
        .map(move |(k, row)| ((k + 1) as f64, to_mm(pick(row))))
}
