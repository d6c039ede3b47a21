//! The gap on the sole, seen from above: arrows from where the CoP was simulated
//! to where it was measured.

use plotters::prelude::*;

use super::super::super::svg::{
    self, Area, BLUE, Drawn, Frame, HEADING, INK, MUTED, Mark, ORANGE, Place, Side, key, note, px,
    span,
};
use super::super::super::table::mm;
use super::super::cop::same_scale;
use super::super::to_mm;
use super::{boxed, dot};
use sesc_identify::diagnose::view::{DiagnosisView, Posture};

const EDGES: [f64; 4] = [48.0, 32.0, 472.0, 412.0];
/// Length of an arrow's head, and half its width, pixels.
const HEAD: [f64; 2] = [5.5, 2.2];

/// Arrows from CAD's simulation, or from the corrected one, at one scale.
pub fn arrows(view: &DiagnosisView, corrected: bool) -> String {
    let whose = if corrected { "corrected" } else { "simulated" };
    let label = format!(
        "Arrows from the {whose} to the measured CoP of {} postures",
        view.postures.len()
    );
    svg::figure([480, 448], &label, |area| draw(area, view, corrected))
}

fn from(row: &Posture, corrected: bool) -> [f64; 2] {
    if corrected {
        row.corrected
    } else {
        row.simulated
    }
}

/// RMS length of the arrows, m; outliers apart.
fn length(rows: &[Posture], corrected: bool) -> f64 {
    let kept = || rows.iter().filter(|row| !row.outlier);
    let square = |row: &Posture| {
        let at = from(row, corrected);
        (at[0] - row.measured[0]).powi(2) + (at[1] - row.measured[1]).powi(2)
    };
    (kept().map(square).sum::<f64>() / kept().count().max(1) as f64).sqrt()
}

/// How much longer arrows are drawn than gaps are: alike before and after.
fn gain(rows: &[Posture]) -> f64 {
    let longest = length(rows, false).max(length(rows, true));
    let finite = |axis: usize| {
        let values = rows.iter().map(move |row| row.measured[axis]);
        let ends = values.filter(|x| x.is_finite());
        ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
            [low.min(x), high.max(x)]
        })
    };
    let far = [finite(0), finite(1)]
        .iter()
        .map(|[low, high]| high - low)
        .fold(0.0, f64::max);
    let steps = [50.0, 20.0, 10.0, 5.0, 2.0];
    let fits = |gain: &f64| longest > 0.0 && gain * longest < 0.08 * far;
    steps.into_iter().find(fits).unwrap_or(1.0)
}

fn draw(area: &Area<'_>, view: &DiagnosisView, corrected: bool) -> Drawn {
    let rows = &view.postures;
    let gain = gain(rows);
    let tail = |row: &Posture, corrected: bool| {
        let at = from(row, corrected);
        [0, 1].map(|axis| to_mm(row.measured[axis] + gain * (at[axis] - row.measured[axis])))
    };
    let reach = |axis: usize| {
        let ends = rows.iter().flat_map(move |row| {
            [
                to_mm(row.measured[axis]),
                tail(row, false)[axis],
                tail(row, true)[axis],
            ]
        });
        let foot = view.foot.iter().flatten().map(move |at| to_mm(at[axis]));
        span(ends.chain(foot))
    };
    let [x, y] = same_scale([reach(0), reach(1)], EDGES);
    let plane = Frame {
        title: if corrected { "Corrected" } else { "Simulated" },
        x,
        y,
        x_name: "x, mm (y upwards)",
        ticks: [7, 7],
        edges: EDGES,
    }
    .draw(area)?;
    if let Some([low, high]) = view.foot {
        let [low, high] = [low, high].map(|at| at.map(to_mm));
        let corners = [low, [high[0], low[1]], high, [low[0], high[1]], low];
        plane.line(corners.map(|[x, y]| (x, y)), svg::BAND, 1.5)?;
        let (x, y) = plane.place(low[0], high[1]);
        let place = (x, y - px(9.0));
        note(area, "cells of the foot", place, Side::Left, MUTED)?;
    }
    let color = if corrected { BLUE } else { ORANGE };
    for row in rows {
        let [tail, tip] = [tail(row, corrected), row.measured.map(to_mm)];
        if tail.iter().chain(&tip).all(|x| x.is_finite()) {
            let [tail, tip] = [tail, tip].map(|[x, y]| plane.place(x, y));
            arrow(area, tail, tip, color)?;
            dot(area, tip, 1.3, INK)?;
            if row.outlier {
                boxed(area, tip, 5.0)?;
            }
        }
    }
    let length = mm(length(rows, corrected));
    let text = match gain > 1.0 {
        true => format!("{length} mm RMS of the length, drawn × {gain}"),
        false => format!("{length} mm RMS of the length"),
    };
    let marks = [(Mark::Line(color, 1.5), text.as_str())];
    key(area, EDGES[2], EDGES[1] - HEADING, &marks)
}

/// A line with a head where it is long enough for one.
fn arrow(area: &Area<'_>, tail: Place, tip: Place, color: RGBColor) -> Drawn {
    svg::line(area, vec![tail, tip], color, 1.25)?;
    let [x, y] = [f64::from(tip.0 - tail.0), f64::from(tip.1 - tail.1)];
    let length = x.hypot(y);
    if length < 1.6 * f64::from(px(HEAD[0])) {
        return Ok(());
    }
    let [x, y] = [x / length, y / length];
    let [back, side] = HEAD.map(|pixels| f64::from(px(pixels)));
    let corner = |way: f64| {
        (
            (f64::from(tip.0) - back * x - way * side * y).round() as i32,
            (f64::from(tip.1) - back * y + way * side * x).round() as i32,
        )
    };
    area.draw(&Polygon::new(
        vec![tip, corner(1.0), corner(-1.0)],
        color.filled(),
    ))
}
