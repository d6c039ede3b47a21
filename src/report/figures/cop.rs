//! CoP over postures and on the ground (the paper's Figs. 3b and 7).

use super::super::CopRow;
use super::super::svg::{
    self, Area, BAND, BLUE, Drawn, Frame, HEADING, INK, MUTED, Mark, ORANGE, Side, key, note, px,
    span,
};
use super::to_mm;

/// CAD is drawn where it differs from the truth by more than this, mm.
const VISIBLE_MM: f64 = 0.05;

/// One coordinate (0: x, 1: y) over postures, and its errors below.
pub fn cop_over_postures(rows: &[CopRow], axis: usize) -> String {
    let name = ["x", "y"][axis];
    let label = format!(
        "CoP {name} over {} held-out postures, mm: reading, truth, identified",
        rows.len()
    );
    svg::figure([480, 380], &label, |area| {
        curves(area, rows, axis, &format!("CoP {name}, mm"))?;
        residuals(area, rows, axis, &format!("Error of CoP {name}, mm"))
    })
}

fn curves(area: &Area<'_>, rows: &[CopRow], axis: usize, heading: &str) -> Drawn {
    let of = |pick: fn(&CopRow) -> [f64; 2]| {
        rows.iter()
            .enumerate()
            .map(move |(k, row)| ((k + 1) as f64, to_mm(pick(row)[axis])))
    };
    let [measured, truth, cad, identified]: [fn(&CopRow) -> [f64; 2]; 4] = [
        |row| row.measured,
        |row| row.truth,
        |row| row.cad,
        |row| row.identified,
    ];
    let all = [measured, truth, cad, identified];
    let plane = Frame {
        title: heading,
        x: 0.0..(rows.len() + 1) as f64,
        y: span(all.into_iter().flat_map(of).map(|(_, value)| value)),
        x_name: "",
        ticks: [6, 6],
        edges: [44.0, 32.0, 474.0, 204.0],
    }
    .draw(area)?;
    let cad_differs = of(cad)
        .zip(of(truth))
        .any(|((_, cad), (_, truth))| (cad - truth).abs() > VISIBLE_MM);
    let mut marks = vec![
        (Mark::Ring(MUTED), "reading"),
        (Mark::Line(BAND, 7.0), "truth"),
        (Mark::Line(BLUE, 1.75), "identified"),
    ];
    plane.line(of(truth), BAND, 7.0)?;
    if cad_differs {
        marks.push((Mark::Line(ORANGE, 1.25), "CAD"));
        plane.line(of(cad), ORANGE, 1.25)?;
    }
    for (x, y) in of(measured) {
        plane.mark(x, y, Mark::Ring(MUTED))?;
    }
    plane.line(of(identified), BLUE, 1.75)?;
    key(area, 474.0, 32.0 - HEADING, &marks)
}

fn residuals(area: &Area<'_>, rows: &[CopRow], axis: usize, heading: &str) -> Drawn {
    let of = |pick: fn(&CopRow) -> [f64; 2]| {
        rows.iter()
            .enumerate()
            .map(move |(k, row)| ((k + 1) as f64, to_mm(pick(row)[axis] - row.truth[axis])))
    };
    let values = of(|row| row.measured)
        .chain(of(|row| row.identified))
        .map(|(_, value)| value);
    let extent = values.flat_map(|value| [value, -value]);
    let plane = Frame {
        title: heading,
        x: 0.0..(rows.len() + 1) as f64,
        y: span(extent),
        x_name: "posture",
        ticks: [6, 4],
        edges: [44.0, 258.0, 474.0, 346.0],
    }
    .draw(area)?;
    plane.line([(0.0, 0.0), ((rows.len() + 1) as f64, 0.0)], INK, 1.0)?;
    for (x, y) in of(|row| row.measured) {
        plane.mark(x, y, Mark::Ring(MUTED))?;
    }
    for (x, y) in of(|row| row.identified) {
        plane.mark(x, y, Mark::Dot(BLUE))?;
    }
    let marks = [
        (Mark::Ring(MUTED), "reading"),
        (Mark::Dot(BLUE), "identified"),
    ];
    key(area, 474.0, 258.0 - HEADING, &marks)
}

/// The CoP on the ground, seen from above, and the sole around the origin
/// (length, width, m).
pub fn cop_plane(rows: &[CopRow], sole_m: [f64; 2]) -> String {
    const EDGES: [f64; 4] = [44.0, 32.0, 474.0, 366.0];
    let label = format!(
        "CoP of {} held-out postures on the ground, mm, with the outline of the sole",
        rows.len()
    );
    svg::figure([480, 400], &label, |area| {
        let half = sole_m.map(|length| to_mm(length) / 2.0);
        let coordinates = |axis: usize| {
            let points = rows
                .iter()
                .flat_map(move |row| [row.truth[axis], row.measured[axis], row.identified[axis]]);
            points.map(to_mm).chain([-half[axis], half[axis]])
        };
        let [x, y] = same_scale([span(coordinates(0)), span(coordinates(1))], EDGES);
        let plane = Frame {
            title: "CoP from above, mm",
            x,
            y,
            x_name: "x, forward",
            ticks: [7, 7],
            edges: EDGES,
        }
        .draw(area)?;
        note(
            area,
            "y, left",
            (px(EDGES[0] + 6.0), px(EDGES[1] + 8.0)),
            Side::Left,
            MUTED,
        )?;
        let corners = [
            [-1.0, -1.0],
            [1.0, -1.0],
            [1.0, 1.0],
            [-1.0, 1.0],
            [-1.0, -1.0],
        ];
        plane.line(corners.map(|[i, j]| (i * half[0], j * half[1])), INK, 1.5)?;
        let at = |point: [f64; 2]| (to_mm(point[0]), to_mm(point[1]));
        for row in rows {
            plane.line([at(row.truth), at(row.measured)], BAND, 2.0)?;
        }
        for row in rows {
            let (x, y) = at(row.measured);
            plane.mark(x, y, Mark::Ring(MUTED))?;
        }
        for row in rows {
            let (x, y) = at(row.truth);
            plane.mark(x, y, Mark::Ring(INK))?;
        }
        for row in rows {
            let (x, y) = at(row.identified);
            plane.mark(x, y, Mark::Dot(BLUE))?;
        }
        let marks = [
            (Mark::Ring(MUTED), "reading"),
            (Mark::Ring(INK), "truth"),
            (Mark::Dot(BLUE), "identified"),
            (Mark::Box(INK), "sole"),
        ];
        key(area, EDGES[2], EDGES[1] - HEADING, &marks)
    })
}

/// Widen one of two ranges so that a millimetre is as long on both axes.
pub(super) fn same_scale(
    [x, y]: [std::ops::Range<f64>; 2],
    [left, top, right, bottom]: [f64; 4],
) -> [std::ops::Range<f64>; 2] {
    let sizes = [right - left, bottom - top];
    let per_pixel = ((x.end - x.start) / sizes[0]).max((y.end - y.start) / sizes[1]);
    let widen = |range: std::ops::Range<f64>, size: f64| {
        let middle = (range.start + range.end) / 2.0;
        middle - per_pixel * size / 2.0..middle + per_pixel * size / 2.0
    };
    [widen(x, sizes[0]), widen(y, sizes[1])]
}
