//! Figures of the demo, after those of the SESC paper: rows in, SVG out.

use super::super::svg::{Anchor, Axes, BAND, BLUE, Color, Figure, GRID, HEADING, INK, MUTED, Mark};
use super::super::svg::{ORANGE, PAPER, Place, key, same_scale, span};
use super::super::table::mm;
use super::super::{CopRow, DemoReport, Errors, HeightRow, LengthRow};
use super::bars::{Bar, Scale};
use super::to_mm;
use sesc_model::text::apart;

// What the error is made of: noise against readings, little against truth.

/// Left end of all bars and length of the longest, pixels.
const BARS_LEFT: f64 = 140.0;
const BARS_LONGEST: f64 = 390.0;

/// Errors of one kind, and the mark that noise or theory sets them.
struct Group<'t> {
    heading: &'t str,
    bars: [Bar<'t>; 2],
    limit: (&'t str, f64),
}

/// Bars of the error against readings and against the truth.
pub fn errors(report: &DemoReport) -> String {
    let Errors {
        measured_mae_m,
        in_sample_mae_m,
        noise_mae_m,
        clean_rmse_base_m,
        clean_rmse_full_m,
        theory_rmse_m,
        ..
    } = report.errors;
    let base = format!("{} base parameters", report.base_params);
    let full = format!("all {} columns", report.full_params);
    let groups = [
        Group {
            heading: "Against noisy readings, mean |error|",
            bars: [
                bar("new postures", measured_mae_m, MUTED),
                bar("fitted postures", in_sample_mae_m, MUTED),
            ],
            limit: ("noise alone", noise_mae_m),
        },
        Group {
            heading: "Against the true CoP, new postures, RMS",
            bars: [
                bar(&base, clean_rmse_base_m, BLUE),
                bar(&full, clean_rmse_full_m, BLUE),
            ],
            limit: ("theory", theory_rmse_m),
        },
    ];
    let lengths = groups
        .iter()
        .flat_map(|g| [g.bars[0].length_m, g.bars[1].length_m, g.limit.1]);
    let scale = Scale::new(lengths, BARS_LEFT, BARS_LONGEST);
    let label = format!(
        "Bars: error against noisy readings {} mm, noise alone {} mm; \
         error against the true CoP {} mm, theory {} mm",
        mm(measured_mae_m),
        mm(noise_mae_m),
        mm(clean_rmse_base_m),
        mm(theory_rmse_m)
    );
    let mut figure = Figure::new([620.0, 222.0], &label);
    for (group, top) in groups.iter().zip([14.0, 130.0]) {
        draw_group(&mut figure, group, top, &scale);
    }
    figure.finish()
}

fn bar(name: &str, length_m: f64, color: Color) -> Bar<'_> {
    Bar {
        name,
        length_m,
        color,
        pale: false,
    }
}

fn draw_group(figure: &mut Figure, group: &Group<'_>, top: f64, scale: &Scale) {
    figure.title(top, group.heading);
    let (name, limit) = group.limit;
    for (k, bar) in group.bars.iter().enumerate() {
        let upper = top + 34.0 + 24.0 * k as f64;
        // The number stands beyond the mark of the limit, whichever is longer.
        let end = scale.at(bar.length_m).max(scale.at(limit));
        scale.bar(figure, [upper, 18.0], bar, end);
    }
    if limit.is_finite() {
        let x = scale.at(limit);
        figure.line([[x, top + 28.0], [x, top + 82.0]], INK, 2.0);
        let text = format!("{name} {} mm", mm(limit));
        figure.note([x, top + 20.0], Anchor::Middle, INK, &text);
    }
}

// CoP over postures and on the ground (the paper's Figs. 3b and 7).

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

// ‖r_i‖ from CAD and identified, body by body (the paper's Fig. 3a).

/// Height of a body's row, pixels.
const BODY_ROW: f64 = 20.0;
const BODIES_TOP: f64 = 32.0;
const BODIES_LEFT: f64 = 148.0;
const BODIES_RIGHT: f64 = 470.0;
/// Letters of a name that fit beside the plane.
const NAME: usize = 19;

/// All columns by pseudo-inverse: lengths that CAD does not share, where part
/// of the vector cannot be known.
pub fn lengths_full(rows: &[LengthRow]) -> String {
    draw_lengths(
        rows,
        "‖r‖ from all columns, mm",
        |row| [row.cad_m, row.full_m],
        |row| !row.unseen.is_empty(),
    )
}

/// The identifiable part alone: lengths that agree with CAD, but for the
/// body that stands, whose height is the constant flat CoP cannot tell.
pub fn lengths_base(rows: &[LengthRow]) -> String {
    draw_lengths(
        rows,
        "‖identifiable r‖, mm",
        |row| [row.base_cad_m, row.base_m],
        |row| row.joint.is_empty() && !row.unseen.is_empty(),
    )
}

fn draw_lengths(
    rows: &[LengthRow],
    title: &str,
    pair: fn(&LengthRow) -> [f64; 2],
    partly_unseen: fn(&LengthRow) -> bool,
) -> String {
    let count = rows.len().max(1) as f64;
    let bottom = BODIES_TOP + BODY_ROW * count;
    let label = format!("{title}: CAD and identified for {} bodies", rows.len());
    let mut figure = Figure::new([480.0, bottom + 24.0], &label);
    // Both figures of a page share the scale.
    let all = rows
        .iter()
        .flat_map(|r| [r.cad_m, r.full_m, r.base_cad_m, r.base_m]);
    let end = span(all.map(to_mm).chain([0.0])).end;
    let plane = Axes {
        title,
        x: 0.0..end,
        y: -count..0.0,
        x_name: "",
        ticks: [7, 0],
        edges: [BODIES_LEFT, BODIES_TOP, BODIES_RIGHT, bottom],
    }
    .draw(&mut figure);
    let names: Vec<&str> = rows.iter().map(|row| row.body.as_str()).collect();
    let names = apart(&names, NAME);
    for (k, row) in rows.iter().enumerate() {
        let at = |x: f64| plane.at([x, -(k as f64) - 0.5]);
        let [left, middle] = at(0.0);
        figure.line([at(0.0), at(end)], GRID, 1.0);
        figure.note([left - 8.0, middle], Anchor::End, INK, &names[k]);
        let lengths = pair(row).map(to_mm);
        let [cad, identified] = lengths.map(at);
        let (color, mark) = match partly_unseen(row) {
            true => (ORANGE, Mark::Ring(ORANGE)),
            false => (BLUE, Mark::Dot(BLUE)),
        };
        figure.line([cad, identified], color, 1.5);
        figure.mark(cad, Mark::Stroke(INK));
        // What is no number is not drawn.
        if lengths.iter().all(|length| length.is_finite()) {
            let [cad, found] = lengths;
            let words = format!("{} · CAD {cad:.2} mm, identified {found:.2} mm", row.body);
            figure.worded(&words, |figure| figure.mark(identified, mark));
        }
    }
    let cad = (Mark::Stroke(INK), "CAD");
    let dot = (Mark::Dot(BLUE), "identified");
    let marks = match rows.iter().filter(|row| partly_unseen(row)).count() {
        0 => vec![cad, dot],
        n if n == rows.len() => vec![cad, (Mark::Ring(ORANGE), "identified, partly unseen")],
        _ => vec![cad, dot, (Mark::Ring(ORANGE), "partly unseen")],
    };
    key(&mut figure, BODIES_RIGHT, BODIES_TOP - HEADING, &marks);
    figure.finish()
}

// CoM height over postures (the paper's Fig. 8): its shape is known, one
// constant is not.

const HEIGHT_SIZE: [f64; 2] = [480.0, 270.0];
const HEIGHT_EDGES: [f64; 4] = [44.0, 32.0, 474.0, 236.0];

/// The identified height with the constant of minimum norm, off by `offset_m`. The page has the
/// first row's posture under the number `first`.
pub fn height_level(rows: &[HeightRow], offset_m: f64, first: usize) -> String {
    let label = format!(
        "CoM height over {} postures: identified lies {} mm off the truth",
        rows.len(),
        mm(offset_m)
    );
    let mut figure = Figure::new(HEIGHT_SIZE, &label);
    let curves = draw_heights(
        &mut figure,
        rows,
        "CoM height as fitted, mm",
        (|row| row.identified, ORANGE),
        Some(0.0),
    );
    for (truth, identified) in curves[0].iter().zip(&curves[1]) {
        figure.line([*truth, *identified], ORANGE, 0.75);
    }
    dots(&mut figure, &curves[1], ORANGE, first);
    // The text stands under the curves where it has room.
    let lowest = curves.iter().flatten().map(|place| place[1]);
    let lowest = lowest
        .filter(|y| y.is_finite())
        .fold(HEIGHT_EDGES[1], f64::max);
    if HEIGHT_EDGES[3] - lowest > 48.0 {
        let (left, middle) = (HEIGHT_EDGES[0] + 20.0, (HEIGHT_EDGES[3] + lowest) / 2.0);
        let text = format!("on average {} mm apart:", mm(offset_m.abs()));
        figure.note([left, middle - 8.0], Anchor::Start, INK, &text);
        let text = "one constant that flat CoP cannot tell";
        figure.note([left, middle + 8.0], Anchor::Start, INK, text);
    }
    figure.finish()
}

/// The identified height with its constant from CAD, magnified. The page has the first row's
/// posture under the number `first`.
pub fn height_shape(rows: &[HeightRow], first: usize) -> String {
    let label = format!(
        "CoM height over {} postures with the constant from CAD: identified follows the truth",
        rows.len()
    );
    let mut figure = Figure::new(HEIGHT_SIZE, &label);
    let title = "CoM height, constant from CAD, mm";
    let curves = draw_heights(&mut figure, rows, title, (|row| row.anchored, BLUE), None);
    dots(&mut figure, &curves[1], BLUE, first);
    figure.finish()
}

/// A dot for each posture on a curve.
fn dots(figure: &mut Figure, curve: &[Place], color: Color, first: usize) {
    for (at, k) in curve.iter().zip(first..) {
        figure.posture(k, |figure| figure.dot(*at, 2.4, color));
    }
}

/// The true curve and another one; returns the places of both. The axis reaches down
/// to `lowest`.
fn draw_heights(
    figure: &mut Figure,
    rows: &[HeightRow],
    title: &str,
    (pick, color): (fn(&HeightRow) -> f64, Color),
    lowest: Option<f64>,
) -> [Vec<Place>; 2] {
    let heights = rows.iter().flat_map(|row| [row.truth, pick(row)]);
    let plane = Axes {
        title,
        x: 0.0..(rows.len() + 1) as f64,
        y: span(heights.map(to_mm).chain(lowest)),
        x_name: "posture",
        ticks: [6, 6],
        edges: HEIGHT_EDGES,
    }
    .draw(figure);
    let curve = |pick: fn(&HeightRow) -> f64| -> Vec<Place> {
        let rows = rows.iter().zip(1..);
        rows.map(|(row, k)| plane.at([f64::from(k), to_mm(pick(row))]))
            .collect()
    };
    let curves = [curve(|row| row.truth), curve(pick)];
    figure.line(curves[0].iter().copied(), BAND, 7.0);
    figure.line(curves[1].iter().copied(), color, 1.75);
    let marks = [
        (Mark::Line(BAND, 7.0), "truth"),
        (Mark::Line(color, 1.75), "identified"),
    ];
    key(figure, HEIGHT_EDGES[2], HEIGHT_EDGES[1] - HEADING, &marks);
    curves
}

// How many parameters flat CoP tells apart: one square for each.

/// Squares side by side and their distance, pixels.
const PER_ROW: usize = 21;
const SQUARE_PITCH: f64 = 22.0;
const SQUARE: f64 = 17.0;
const SQUARES_TOP: f64 = 30.0;

/// One square per column: told by flat CoP, told by the height of the CoM
/// alone, told by nothing.
pub fn parameters(report: &DemoReport) -> String {
    let DemoReport {
        full_params,
        base_params,
        rank_cop,
        ..
    } = *report;
    let lost = full_params.saturating_sub(base_params);
    let height = base_params.saturating_sub(rank_cop);
    let rows = full_params.div_ceil(PER_ROW).max(1) as f64;
    let label = format!(
        "Of {full_params} parameters flat CoP tells {rank_cop} apart; {height} needs the CoM \
         height; {lost} only move to a neighbour"
    );
    let mut figure = Figure::new([480.0, SQUARES_TOP + SQUARE_PITCH * rows + 4.0], &label);
    let told = format!("{rank_cop} from flat CoP");
    let constant = format!("{height} height constant");
    let sums = format!("{lost} only in sums");
    let marks = [
        (Mark::Square(BLUE), told.as_str()),
        (Mark::Square(ORANGE), constant.as_str()),
        (Mark::Box(ORANGE), sums.as_str()),
    ];
    key(&mut figure, 460.0, 12.0, &marks);
    for k in 0..full_params {
        let x = 2.0 + SQUARE_PITCH * (k % PER_ROW) as f64;
        let y = SQUARES_TOP + SQUARE_PITCH * (k / PER_ROW) as f64;
        let square = |inset: f64| {
            let end = SQUARE - inset;
            [[x + inset, y + inset], [x + end, y + end]]
        };
        let color = if k < rank_cop { BLUE } else { ORANGE };
        figure.fill(square(0.0), color, 1.0);
        if k >= base_params {
            figure.fill(square(1.5), PAPER, 1.0);
        }
    }
    figure.finish()
}
