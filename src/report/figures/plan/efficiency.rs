//! The error to expect over the number of postures, planned and at random.

use super::super::super::svg::{Anchor, Axes, BLUE, Figure, HEADING, INK, MUTED, Mark, key, span};
use super::super::super::table::mm;
use super::super::to_mm;
use sesc_identify::plan::efficiency::Efficiency;

const EDGES: [f64; 4] = [44.0, 32.0, 470.0, 366.0];
/// Random postures that hardly tell all directions are off by anything: what is
/// higher than so many times the last of them is not drawn.
const HIGHEST: f64 = 6.0;

/// Planned postures and as many random ones of the same candidates.
pub fn efficiency(curve: &[Efficiency]) -> String {
    let label = match curve.last() {
        Some(last) => format!(
            "Expected error over the number of postures: {} mm of {} planned, {} mm of random ones",
            mm(last.planned),
            last.postures,
            mm(last.random)
        ),
        None => "Expected error over the number of postures: not known".to_string(),
    };
    let mut figure = Figure::new([480.0, 400.0], &label);
    let highest = curve.last().map_or(0.0, |last| HIGHEST * last.random);
    let of = |pick: fn(&Efficiency) -> f64| {
        let low = move |point: &&Efficiency| pick(point) <= highest;
        let place = move |point: &Efficiency| [point.postures as f64, to_mm(pick(point))];
        curve.iter().filter(low).map(place)
    };
    let (mut planned, mut random) = (of(|point| point.planned), of(|point| point.random));
    let both = || planned.clone().chain(random.clone());
    let x = span(both().map(|point| point[0]));
    let y = span(both().map(|point| point[1]).chain([0.0]));
    let plane = Axes {
        title: "Expected error of the CoP, mm",
        x: x.start.max(0.0)..x.end,
        y: y.start.max(0.0)..y.end,
        x_name: "postures",
        ticks: [6, 6],
        edges: EDGES,
    }
    .draw(&mut figure);
    if curve.is_empty() {
        let place = [EDGES[0] + 20.0, EDGES[1] + 20.0];
        let why = "these postures leave directions open";
        figure.note(place, Anchor::Start, MUTED, why);
        return figure.finish();
    }
    figure.line(random.clone().map(|point| plane.at(point)), MUTED, 1.75);
    figure.line(planned.clone().map(|point| plane.at(point)), BLUE, 1.75);
    // One number above its line, one below.
    let ends = [
        ("random", random.next_back(), Mark::Ring(MUTED), -13.0),
        ("planned", planned.next_back(), Mark::Dot(BLUE), 13.0),
    ];
    for (name, point, mark, beside) in ends {
        let Some(point) = point else { continue };
        let [right, middle] = plane.at(point);
        let text = format!("{} mm", mm(1e-3 * point[1]));
        let words = format!("{} {name} postures · {text} of error expected", point[0]);
        figure.worded(&words, |figure| figure.mark([right, middle], mark));
        figure.note([right, middle + beside], Anchor::End, INK, &text);
    }
    let marks = [
        (Mark::Line(MUTED, 1.75), "random"),
        (Mark::Line(BLUE, 1.75), "planned"),
    ];
    key(&mut figure, EDGES[2], EDGES[1] - HEADING, &marks);
    figure.finish()
}
