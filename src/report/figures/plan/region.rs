//! Where the CoP of the planned postures is, and where it may be.

use super::super::super::svg::{Anchor, Axes, BLUE, Figure, GRID, HEADING, INK, MUTED, Mark};
use super::super::super::svg::{key, same_scale, span};
use super::super::to_mm;
use sesc_identify::plan::Plan;

const EDGES: [f64; 4] = [40.0, 32.0, 334.0, 306.0];

/// The sole plane from above: a dot per posture, in their order along a thin line.
pub fn region(plan: &Plan) -> String {
    let label = format!(
        "CoP of {} planned postures on the sole, mm, within {}",
        plan.cop.len(),
        plan.cop_region
    );
    let mut figure = Figure::new([340.0, 340.0], &label);
    let reach = |axis: usize| {
        let points = plan.corners.iter().chain(&plan.cop);
        span(points.map(|point| to_mm(point[axis])))
    };
    let [x, y] = same_scale([reach(0), reach(1)], EDGES);
    let plane = Axes {
        title: "CoP from above, mm",
        x,
        y,
        x_name: "x, forward",
        ticks: [5, 6],
        edges: EDGES,
    }
    .draw(&mut figure);
    let place = [EDGES[0] + 6.0, EDGES[1] + 8.0];
    figure.note(place, Anchor::Start, MUTED, "y, left");
    let at = |point: &[f64; 2]| plane.at(point.map(to_mm));
    figure.line(plan.cop.iter().map(at), GRID, 1.0);
    let closed = plan.corners.iter().chain(plan.corners.first());
    figure.line(closed.map(at), INK, 1.5);
    for (k, point) in plan.cop.iter().enumerate() {
        figure.posture(k, |figure| figure.mark(at(point), Mark::Dot(BLUE)));
    }
    let marks = [(Mark::Dot(BLUE), "posture"), (Mark::Box(INK), "allowed")];
    key(&mut figure, EDGES[2], EDGES[1] - HEADING, &marks);
    figure.finish()
}
