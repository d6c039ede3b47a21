//! Where the CoP of the planned postures is, and where it may be.

use super::super::super::svg::{
    self, BLUE, Frame, GRID, HEADING, INK, MUTED, Mark, Side, key, note, px, span,
};
use super::super::cop::same_scale;
use super::super::to_mm;
use sesc_identify::plan::Plan;

const EDGES: [f64; 4] = [44.0, 32.0, 474.0, 366.0];

/// The sole plane from above: a dot per posture, in their order along a thin line.
pub fn region(plan: &Plan) -> String {
    let label = format!(
        "CoP of {} planned postures on the sole, mm, within {}",
        plan.cop.len(),
        plan.cop_region
    );
    svg::figure([480, 400], &label, |area| {
        let along = |axis: usize| {
            let points = plan.corners.iter().chain(&plan.cop);
            span(points.map(|point| to_mm(point[axis])))
        };
        let [x, y] = same_scale([along(0), along(1)], EDGES);
        let plane = Frame {
            title: "CoP from above, mm",
            x,
            y,
            x_name: "x, forward",
            ticks: [7, 7],
            edges: EDGES,
        }
        .draw(area)?;
        let place = (px(EDGES[0] + 6.0), px(EDGES[1] + 8.0));
        note(area, "y, left", place, Side::Left, MUTED)?;
        let at = |point: &[f64; 2]| (to_mm(point[0]), to_mm(point[1]));
        plane.line(plan.cop.iter().map(at), GRID, 1.0)?;
        let closed = plan.corners.iter().chain(plan.corners.first());
        plane.line(closed.map(at), INK, 1.5)?;
        for point in &plan.cop {
            let (x, y) = at(point);
            plane.mark(x, y, Mark::Dot(BLUE))?;
        }
        let marks = [(Mark::Dot(BLUE), "posture"), (Mark::Box(INK), "allowed")];
        key(area, EDGES[2], EDGES[1] - HEADING, &marks)
    })
}
