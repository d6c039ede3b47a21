//! CoP over postures and on the ground (the paper's Figs. 3b and 7).

use super::super::CopRow;
use super::super::svg::{Anchor, Axes, BAND, BLUE, Figure, HEADING, INK, MUTED, Mark, ORANGE};
use super::super::svg::{key, same_scale, span};
use super::to_mm;

/// CAD is drawn where it differs from the truth by more than this, mm.
const VISIBLE_MM: f64 = 0.05;

type Pick = fn(&CopRow) -> [f64; 2];

/// One coordinate (0: x, 1: y) over postures, and its errors below. The page has the first row's
/// posture under the number `first`.
pub fn cop_over_postures(rows: &[CopRow], axis: usize, first: usize) -> String {
    let name = ["x", "y"][axis];
    let label = format!(
        "CoP {name} over {} held-out postures, mm: reading, truth, identified",
        rows.len()
    );
    let mut figure = Figure::new([480.0, 380.0], &label);
    curves(&mut figure, rows, axis, &format!("CoP {name}, mm"), first);
    let title = format!("Error of CoP {name}, mm");
    residuals(&mut figure, rows, axis, &title, first);
    figure.finish()
}

fn curves(figure: &mut Figure, rows: &[CopRow], axis: usize, title: &str, first: usize) {
    let of = |pick: Pick| {
        let rows = rows.iter().zip(1..);
        rows.map(move |(row, k)| [f64::from(k), to_mm(pick(row)[axis])])
    };
    let [measured, truth, cad, identified]: [Pick; 4] = [
        |row| row.measured,
        |row| row.truth,
        |row| row.cad,
        |row| row.identified,
    ];
    let all = [measured, truth, cad, identified].into_iter().flat_map(of);
    let plane = Axes {
        title,
        x: 0.0..(rows.len() + 1) as f64,
        y: span(all.map(|[_, value]| value)),
        x_name: "",
        ticks: [6, 6],
        edges: [44.0, 32.0, 474.0, 204.0],
    }
    .draw(figure);
    let places = |pick| of(pick).map(|point| plane.at(point));
    let mut both = of(cad).zip(of(truth));
    let cad_differs = both.any(|([_, cad], [_, truth])| (cad - truth).abs() > VISIBLE_MM);
    let mut marks = vec![
        (Mark::Ring(MUTED), "reading"),
        (Mark::Line(BAND, 7.0), "truth"),
        (Mark::Line(BLUE, 1.75), "identified"),
    ];
    figure.line(places(truth), BAND, 7.0);
    if cad_differs {
        marks.push((Mark::Line(ORANGE, 1.25), "CAD"));
        figure.line(places(cad), ORANGE, 1.25);
    }
    for (at, k) in places(measured).zip(first..) {
        figure.posture(k, |figure| figure.mark(at, Mark::Ring(MUTED)));
    }
    figure.line(places(identified), BLUE, 1.75);
    key(figure, 474.0, 32.0 - HEADING, &marks);
}

fn residuals(figure: &mut Figure, rows: &[CopRow], axis: usize, title: &str, first: usize) {
    let of = |pick: Pick| {
        let rows = rows.iter().zip(1..);
        rows.map(move |(row, k)| [f64::from(k), to_mm(pick(row)[axis] - row.truth[axis])])
    };
    let [measured, identified]: [Pick; 2] = [|row| row.measured, |row| row.identified];
    let values = of(measured).chain(of(identified));
    let end = (rows.len() + 1) as f64;
    let plane = Axes {
        title,
        x: 0.0..end,
        y: span(values.flat_map(|[_, value]| [value, -value])),
        x_name: "posture",
        ticks: [6, 4],
        edges: [44.0, 258.0, 474.0, 346.0],
    }
    .draw(figure);
    figure.line([[0.0, 0.0], [end, 0.0]].map(|at| plane.at(at)), INK, 1.0);
    let marks = [
        (Mark::Ring(MUTED), "reading"),
        (Mark::Dot(BLUE), "identified"),
    ];
    for ((mark, _), pick) in marks.iter().zip([measured, identified]) {
        for (point, k) in of(pick).zip(first..) {
            figure.posture(k, |figure| figure.mark(plane.at(point), *mark));
        }
    }
    key(figure, 474.0, 258.0 - HEADING, &marks);
}

/// The CoP on the ground, seen from above, and the sole around the origin
/// (length, width, m). The page has the first row's posture under the number `first`.
pub fn cop_plane(rows: &[CopRow], sole_m: [f64; 2], first: usize) -> String {
    const EDGES: [f64; 4] = [44.0, 32.0, 474.0, 366.0];
    let label = format!(
        "CoP of {} held-out postures on the ground, mm, with the outline of the sole",
        rows.len()
    );
    let mut figure = Figure::new([480.0, 400.0], &label);
    let half = sole_m.map(|length| to_mm(length) / 2.0);
    let reach = |axis: usize| {
        let points = rows
            .iter()
            .flat_map(move |row| [row.truth[axis], row.measured[axis], row.identified[axis]]);
        span(points.map(to_mm).chain([-half[axis], half[axis]]))
    };
    let [x, y] = same_scale([reach(0), reach(1)], EDGES);
    let plane = Axes {
        title: "CoP from above, mm",
        x,
        y,
        x_name: "x, forward",
        ticks: [7, 7],
        edges: EDGES,
    }
    .draw(&mut figure);
    let place = [EDGES[0] + 6.0, EDGES[1] + 8.0];
    figure.note(place, Anchor::Start, MUTED, "y, left");
    let corners = [half.map(|x| -x), half].map(|corner| plane.at(corner));
    figure.outline(corners, INK);
    let at = |point: [f64; 2]| plane.at(point.map(to_mm));
    for row in rows {
        figure.line([at(row.truth), at(row.measured)], BAND, 2.0);
    }
    let marks: [(Mark, &str, Pick); 3] = [
        (Mark::Ring(MUTED), "reading", |row| row.measured),
        (Mark::Ring(INK), "truth", |row| row.truth),
        (Mark::Dot(BLUE), "identified", |row| row.identified),
    ];
    for (mark, _, pick) in marks {
        for (row, k) in rows.iter().zip(first..) {
            figure.posture(k, |figure| figure.mark(at(pick(row)), mark));
        }
    }
    let mut names: Vec<(Mark, &str)> = marks.map(|(mark, name, _)| (mark, name)).into();
    names.push((Mark::Box(INK), "sole"));
    key(&mut figure, EDGES[2], EDGES[1] - HEADING, &names);
    figure.finish()
}
