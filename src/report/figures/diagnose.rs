//! Figures of a diagnosis: rows in, SVG out.
//!
//! Grey is what was measured, orange the simulation with CAD masses, blue the
//! simulation with what was missing; an outlier wears a box.

#[cfg(test)]
mod tests;

use super::super::svg::{
    Anchor, Axes, BLUE, Figure, GRID, HEADING, INK, MUTED, Mark, NAME, ORANGE,
};
use super::super::svg::{TINY, key, same_scale, span};
use super::super::table::mm;
use super::arrows::{Arrows, Gap};
use super::bars::{self, Bar};
use super::{shade, to_mm};
use sesc_identify::diagnose::view::{
    DiagnosisView, EDGE, Middle, Posture, Predicted, Regions, Spread, Stage, StageKind, Trend,
    chosen,
};
use sesc_model::text::apart;

/// Right edge of the planes of such a figure.
const RIGHT: f64 = 972.0;
/// Shade of what is many times the noise.
const DARKEST: f64 = 0.5;
/// Width of a figure that has a row of the page for itself, pixels.
const WIDE: f64 = 980.0;

/// Arrows to the measured CoP from CAD's simulation, and from the corrected one.
pub fn arrows(view: &DiagnosisView) -> [String; 2] {
    let arrows = of_view(view, &[]);
    [
        arrows.draw(0, "Simulated", ORANGE),
        arrows.draw(1, "Corrected", BLUE),
    ]
}

/// The same beside the robot, before the correction; cells that are meant are marked.
pub fn arrows_beside(view: &DiagnosisView, cells: &[usize]) -> String {
    of_view(view, cells).beside_the_robot("CoP on the ground")
}

fn of_view(view: &DiagnosisView, cells: &[usize]) -> Arrows {
    let gap = |row: &Posture| Gap {
        measured: row.measured,
        predicted: [row.simulated, row.corrected],
        outlier: row.outlier,
    };
    let places = view.cells.iter().enumerate();
    Arrows {
        gaps: view.postures.iter().map(gap).collect(),
        rms: view.rms_lengths,
        foot: view.foot,
        sole: view.skeleton.sole.clone(),
        cells: places.map(|(k, at)| (*at, cells.contains(&k))).collect(),
    }
}

/// The held-out error on its way from CAD, effect by effect, to the noise.
pub fn waterfall(stages: &[Stage]) -> String {
    let bars = stages.iter().map(|stage| Bar {
        name: &stage.name,
        length_m: stage.rmse,
        color: match stage.kind {
            StageKind::Cad => ORANGE,
            StageKind::Better => BLUE,
            StageKind::Noise => MUTED,
        },
        pale: stage.kind == StageKind::Better,
    });
    let bars: Vec<Bar<'_>> = bars.collect();
    let noise = stages.iter().find(|s| s.kind == StageKind::Noise);
    let noise = noise.map_or(0.0, |stage| stage.rmse);
    bars::waterfall("RMS error per axis, held out", &bars, noise)
}

// The CoP posture by posture: measured, simulated, corrected.

/// Postures that stay apart in one course_panel.
const COURSE_MOST: usize = 90;

/// x above, y below.
pub fn course(rows: &[Posture]) -> String {
    let few: Vec<(usize, &Posture)> = chosen(rows.len(), COURSE_MOST)
        .into_iter()
        .map(|k| (k, &rows[k]))
        .collect();
    let label = format!(
        "CoP of {} postures, mm: measured, simulated, corrected",
        few.len()
    );
    let which = match few.len() < rows.len() {
        true => format!("{} of {} postures, evenly chosen", few.len(), rows.len()),
        false => "posture, in the order of the log".to_string(),
    };
    let mut figure = Figure::new([WIDE, 484.0], &label);
    course_panel(&mut figure, &few, (0, ""), [32.0, 212.0]);
    course_panel(&mut figure, &few, (1, &which), [262.0, 442.0]);
    figure.finish()
}

fn course_panel(
    figure: &mut Figure,
    rows: &[(usize, &Posture)],
    (axis, x_name): (usize, &str),
    [top, bottom]: [f64; 2],
) {
    let of = |pick: fn(&Posture) -> [f64; 2]| {
        let rows = rows.iter().zip(1..);
        rows.map(move |((_, row), k)| [f64::from(k), to_mm(pick(row)[axis])])
    };
    let picks: [fn(&Posture) -> [f64; 2]; 3] =
        [|row| row.measured, |row| row.simulated, |row| row.corrected];
    let [measured, simulated, corrected] = picks;
    let plane = Axes {
        title: ["CoP x, mm", "CoP y, mm"][axis],
        x: 0.0..(rows.len() + 1) as f64,
        y: span(picks.into_iter().flat_map(of).map(|[_, value]| value)),
        x_name,
        ticks: [12, 6],
        edges: [48.0, top, RIGHT, bottom],
    }
    .draw(figure);
    let places = |pick| of(pick).map(|point| plane.at(point));
    // Neighbours in a log have nothing to do with each other: no lines between.
    let all = places(simulated)
        .zip(places(measured))
        .zip(places(corrected));
    for ((posture, row), ((from, to), corrected)) in rows.iter().zip(all) {
        figure.posture(*posture, |figure| {
            figure.line([from, to], ORANGE, 1.25);
            figure.mark(from, Mark::Dot(ORANGE));
            figure.mark(to, Mark::Ring(MUTED));
            if row.outlier {
                figure.boxed(to, 5.0);
            }
            figure.dot(corrected, 2.0, BLUE);
        });
    }
    let mut marks = vec![
        (Mark::Ring(MUTED), "measured"),
        (Mark::Dot(ORANGE), "simulated (CAD)"),
        (Mark::Dot(BLUE), "corrected"),
    ];
    if rows.iter().any(|(_, row)| row.outlier) {
        marks.push((Mark::Box(INK), "outlier"));
    }
    key(figure, RIGHT, top - HEADING, &marks);
}

// The gap in the order of the log: before and after.

/// Measured less simulated over time, or over the postures where none is logged.
pub fn rest(view: &DiagnosisView) -> String {
    let label = format!(
        "Measured less simulated CoP of {} postures over the log, mm: before and after",
        view.postures.len()
    );
    let mut figure = Figure::new([WIDE, 404.0], &label);
    rest_panel(&mut figure, view, 0, [32.0, 172.0]);
    rest_panel(&mut figure, view, 1, [222.0, 362.0]);
    figure.finish()
}

fn rest_panel(figure: &mut Figure, view: &DiagnosisView, axis: usize, [top, bottom]: [f64; 2]) {
    let rows = &view.postures;
    let of = |row: &Posture, from: [f64; 2]| to_mm(row.measured[axis] - from[axis]);
    let both = rows
        .iter()
        .flat_map(|row| [of(row, row.simulated), of(row, row.corrected)]);
    let along = span(rows.iter().map(|row| row.at));
    let plane = Axes {
        title: ["Gap in x, mm", "Gap in y, mm"][axis],
        x: along.clone(),
        y: span(both.chain([0.0])),
        x_name: match (axis, view.timed) {
            (0, _) => "",
            (_, true) => "time, s",
            (_, false) => "posture, in the order of the log",
        },
        ticks: [12, 5],
        edges: [48.0, top, RIGHT, bottom],
    }
    .draw(figure);
    let zero = [along.start, along.end].map(|x| plane.at([x, 0.0]));
    figure.line(zero, INK, 1.0);
    for (k, row) in rows.iter().enumerate() {
        let at = plane.at([row.at, of(row, row.simulated)]);
        figure.posture(k, |figure| figure.dot(at, 2.4, ORANGE));
    }
    for (k, row) in rows.iter().enumerate() {
        let at = plane.at([row.at, of(row, row.corrected)]);
        figure.posture(k, |figure| {
            figure.dot(at, 2.4, BLUE);
            if row.outlier {
                figure.boxed(at, 5.0);
            }
        });
    }
    let mut marks = vec![
        (Mark::Dot(ORANGE), "before: CAD"),
        (Mark::Dot(BLUE), "after: corrected"),
    ];
    if rows.iter().any(|row| row.outlier) {
        marks.push((Mark::Box(INK), "outlier"));
    }
    key(figure, RIGHT, top - HEADING, &marks);
}

// The gap against what an effect predicts of it: a pair of panels an effect, x and y, with
// the straight line on which the gap lies if the effect explains all of it.

/// Panels side by side, their left edges, size of a plane, and from one row to the next, pixels.
const PREDICTED_LEFT: [f64; 2] = [52.0, 548.0];
const PREDICTED_PLANE: [f64; 2] = [420.0, 150.0];
const PREDICTED_PITCH: f64 = 222.0;
const PREDICTED_TOP: f64 = 62.0;
/// Letters of a subject over its predicted_panel.
const PREDICTED_LETTERS: usize = 44;

/// A pair of panels for each effect, mm.
pub fn predicted(rows: &[Predicted]) -> String {
    let label = format!(
        "Gap against what the named effects predict of it, mm: {}",
        rows.iter()
            .step_by(2)
            .map(|row| row.subject.as_str())
            .collect::<Vec<_>>()
            .join("; ")
    );
    let lines = rows.len().div_ceil(2).max(1);
    let height = PREDICTED_TOP + PREDICTED_PITCH * lines as f64 - 12.0;
    let mut figure = Figure::new([WIDE, height], &label);
    figure.title(
        13.0,
        "Gap in mm against the change that the named effect predicts",
    );
    let marks = [
        (Mark::Dot(ORANGE), "a posture"),
        (Mark::Line(INK, 1.0), "gap = predicted change"),
        (Mark::Line(BLUE, 1.75), "line that fits best"),
    ];
    key(&mut figure, WIDE - 8.0, 13.0, &marks);
    let names: Vec<&str> = rows.iter().map(|row| row.subject.as_str()).collect();
    let names = apart(&names, PREDICTED_LETTERS);
    for (k, row) in rows.iter().enumerate() {
        predicted_panel(
            &mut figure,
            row,
            &names[k],
            [
                PREDICTED_LEFT[k % 2],
                PREDICTED_TOP + PREDICTED_PITCH * (k / 2) as f64,
            ],
        );
    }
    if rows.is_empty() {
        figure.note(
            [PREDICTED_LEFT[0], PREDICTED_TOP],
            Anchor::Start,
            MUTED,
            "no effect changes readings",
        );
    }
    figure.finish()
}

fn predicted_panel(figure: &mut Figure, row: &Predicted, name: &str, [left, top]: [f64; 2]) {
    let kept = || row.points.iter().filter(|p| !p.outlier);
    let along = span(row.points.iter().map(|p| to_mm(p.change)).chain([0.0]));
    // Outliers would flatten the rest: they stay at the edge. The lines are in sight.
    let gaps = kept().map(|p| to_mm(p.gap));
    let range = span(gaps.chain(kept().map(|p| to_mm(p.change))).chain([0.0]));
    let inside = 0.03 * (range.end - range.start);
    let (low, high) = (range.start + inside, range.end - inside);
    let plane = Axes {
        title: "",
        x: along.clone(),
        y: range.clone(),
        x_name: &match row.slope.is_finite() {
            true => format!("predicted change, mm; slope {:.2}", row.slope),
            false => "predicted change, mm".to_string(),
        },
        ticks: [7, 5],
        edges: [
            left,
            top,
            left + PREDICTED_PLANE[0],
            top + PREDICTED_PLANE[1],
        ],
    }
    .draw(figure);
    let name = format!("{} ({})", name, ["x", "y"][row.axis]);
    figure.text([left, top - HEADING + 6.0], Anchor::Start, NAME, INK, &name);
    let ends = [along.start.max(range.start), along.end.min(range.end)];
    figure.line(ends.map(|x| plane.at([x, x])), INK, 1.0);
    for point in &row.points {
        let at = plane.at([to_mm(point.change), to_mm(point.gap).clamp(low, high)]);
        figure.posture(point.posture, |figure| {
            figure.dot(at, 2.2, ORANGE);
            if point.outlier {
                figure.boxed(at, 4.0);
            }
        });
    }
    // Cut where it leaves the predicted_panel.
    let fitted = |x: f64| [x, (row.slope * x).clamp(range.start, range.end)];
    figure.line(
        [along.start, along.end].map(|x| plane.at(fitted(x))),
        BLUE,
        1.75,
    );
}

// The gap against what a joint does: six small panels, joints that the explanation names
// first and marked, then the strongest.

/// Panels side by side.
const TREND_COLUMNS: usize = 2;
/// Left edge of the first, size of a plane, and from one to the next, pixels.
const TREND_LEFT: f64 = 40.0;
const TREND_PLANE: [f64; 2] = [188.0, 96.0];
const TREND_PITCH: [f64; 2] = [236.0, 162.0];
const TREND_TOP: f64 = 60.0;
/// Letters of a joint over its trend_panel.
const TREND_LETTERS: usize = 22;

/// Residuals against `what` of the joints, mm.
pub fn trends(rows: &[Trend], what: &str) -> String {
    let label = format!(
        "Gap against {what} of {} joints, mm: before and after",
        rows.len()
    );
    let lines = rows.len().div_ceil(TREND_COLUMNS).max(1);
    let height = TREND_TOP + TREND_PITCH[1] * lines as f64 - 24.0;
    let mut figure = Figure::new([480.0, height], &label);
    figure.title(13.0, &format!("Gap in mm against the {what}"));
    let marks = [(Mark::Dot(ORANGE), "before"), (Mark::Dot(BLUE), "after")];
    key(&mut figure, 472.0, 13.0, &marks);
    let names: Vec<&str> = rows.iter().map(|row| row.joint.as_str()).collect();
    let [names, beside_mark] = [TREND_LETTERS, TREND_LETTERS - 9].map(|most| apart(&names, most));
    for (k, row) in rows.iter().enumerate() {
        let corner = [
            TREND_LEFT + TREND_PITCH[0] * (k % TREND_COLUMNS) as f64,
            TREND_TOP + TREND_PITCH[1] * (k / TREND_COLUMNS) as f64,
        ];
        // What is named is marked at the other end of the line.
        let name = if row.named {
            &beside_mark[k]
        } else {
            &names[k]
        };
        trend_panel(&mut figure, row, name, corner);
    }
    if rows.is_empty() {
        figure.note([TREND_LEFT, TREND_TOP], Anchor::Start, MUTED, "no joints");
    }
    figure.finish()
}

fn trend_panel(figure: &mut Figure, row: &Trend, name: &str, [left, top]: [f64; 2]) {
    // Outliers would flatten the rest: they stay at the edge.
    let kept = row.points.iter().filter(|p| !p.outlier);
    let kept = kept.flat_map(|p| [p.before, p.after]).map(to_mm);
    let mut range = span(kept.chain([0.0]));
    if row.points.iter().any(|p| p.outlier) {
        let more = 0.08 * (range.end - range.start);
        range = range.start - more..range.end + more;
    }
    let inside = 0.05 * (range.end - range.start);
    let (low, high) = (range.start + inside, range.end - inside);
    let along = span(row.points.iter().map(|p| p.at));
    let [before, after] = row.share.map(|share| 100.0 * share.max(0.0));
    let plane = Axes {
        title: "",
        x: along.clone(),
        y: range,
        x_name: &format!("{}: {before:.0} % before, {after:.0} % after", row.unit),
        ticks: [5, 4],
        edges: [left, top, left + TREND_PLANE[0], top + TREND_PLANE[1]],
    }
    .draw(figure);
    let axis = ["x", "y"][row.axis];
    let name = format!("{name} ({axis})");
    let place = [left, top - HEADING + 6.0];
    figure.text(place, Anchor::Start, NAME, INK, &name);
    if row.named {
        // Letters in orange are too pale to read.
        let [right, middle] = [left + TREND_PLANE[0], place[1]];
        key(figure, right, middle, &[(Mark::Square(ORANGE), "named")]);
    }
    let zero = [along.start, along.end].map(|x| plane.at([x, 0.0]));
    figure.line(zero, INK, 1.0);
    for point in &row.points {
        let at = |value: f64| plane.at([point.at, to_mm(value).clamp(low, high)]);
        figure.posture(point.posture, |figure| {
            figure.dot(at(point.before), 1.4, ORANGE);
            figure.dot(at(point.after), 1.4, BLUE);
            if point.outlier {
                figure.boxed(at(point.after), 3.5);
            }
        });
    }
    type Pick = fn(&Middle) -> f64;
    let picks: [(Pick, _); 2] = [(|m| m.before, ORANGE), (|m| m.after, BLUE)];
    for (pick, color) in picks {
        let means = row.means.iter().map(|m| plane.at([m.at, to_mm(pick(m))]));
        figure.line(means, color, 1.75);
    }
}

// Residuals in units of noise: counted, against the normal curve.

const SPREAD_EDGES: [f64; 4] = [48.0, 32.0, 472.0, 246.0];
/// Points of the curve.
const CURVE_POINTS: usize = 121;

/// Bars after, a stepped line before, the curve of pure noise.
pub fn spread(rows: &Spread) -> String {
    let label = format!(
        "{} residuals in units of noise: before and after",
        rows.count
    );
    let width = 2.0 * EDGE / rows.after.len().max(1) as f64;
    let normal = |x: f64| {
        rows.count as f64 * width * (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt()
    };
    let mut figure = Figure::new([480.0, 320.0], &label);
    let most = rows.before.iter().chain(&rows.after).max();
    let most = most.map_or(0.0, |&count| count as f64);
    let plane = Axes {
        title: "Residuals per bin",
        x: -EDGE..EDGE,
        y: 0.0..1.08 * most.max(normal(0.0)).max(1.0),
        x_name: "(measured − simulated) ÷ noise",
        ticks: [7, 5],
        edges: SPREAD_EDGES,
    }
    .draw(&mut figure);
    let left = |k: usize| -EDGE + width * k as f64;
    for (k, &count) in rows.after.iter().enumerate().filter(|(_, n)| **n > 0) {
        let [low, high] = [[left(k), 0.0], [left(k + 1), count as f64]].map(|at| plane.at(at));
        figure.fill(
            [[low[0] + 0.5, low[1]], [high[0] - 0.5, high[1]]],
            BLUE,
            1.0,
        );
    }
    let steps = rows.before.iter().enumerate();
    let steps = steps.flat_map(|(k, &n)| [[left(k), n as f64], [left(k + 1), n as f64]]);
    figure.line(steps.map(|at| plane.at(at)), ORANGE, 1.75);
    let curve =
        (0..CURVE_POINTS).map(|k| -EDGE + 2.0 * EDGE * k as f64 / (CURVE_POINTS - 1) as f64);
    figure.line(curve.map(|x| plane.at([x, normal(x)])), INK, 1.75);
    let marks = [
        (Mark::Line(ORANGE, 1.75), "before"),
        (Mark::Square(BLUE), "after"),
        (Mark::Line(INK, 1.75), "noise alone"),
    ];
    key(
        &mut figure,
        SPREAD_EDGES[2],
        SPREAD_EDGES[1] - HEADING,
        &marks,
    );
    let said = format!(
        "Beyond ±{EDGE:.0}: {} before, {} after. RMS: {} before, {} after.",
        rows.beyond[0],
        rows.beyond[1],
        mm(1e-3 * rows.rms[0]),
        mm(1e-3 * rows.rms[1])
    );
    figure.note([SPREAD_EDGES[0], 302.0], Anchor::Start, MUTED, &said);
    figure.finish()
}

// Where on the sole the gap is: RMS in units of noise, square by square.

const REGION_EDGES: [f64; 4] = [48.0, 32.0, 472.0, 412.0];

/// The map before or after.
pub fn regions(rows: &Regions, after: bool) -> String {
    let when = if after { "after" } else { "before" };
    let label = format!(
        "RMS gap {when}, in units of noise, in {} squares of the sole",
        rows.squares.len()
    );
    let mut figure = Figure::new([480.0, 448.0], &label);
    let reach = |axis: usize| {
        let corners = rows.squares.iter().map(move |s| s.corner[axis]);
        let ends = corners.flat_map(|low| [low, low + rows.side]);
        span(ends.map(to_mm))
    };
    let [x, y] = same_scale([reach(0), reach(1)], REGION_EDGES);
    let plane = Axes {
        title: if after { "Corrected" } else { "Simulated" },
        x,
        y,
        x_name: "x, mm (y upwards)",
        ticks: [7, 7],
        edges: REGION_EDGES,
    }
    .draw(&mut figure);
    let place = [REGION_EDGES[2], REGION_EDGES[1] - HEADING];
    figure.note(place, Anchor::End, MUTED, "RMS ÷ noise, per square");
    for square in &rows.squares {
        let rms = square.rms[usize::from(after)];
        if !rms.is_finite() {
            continue;
        }
        let corners = [0.0, rows.side].map(|by| plane.at(square.corner.map(|at| to_mm(at + by))));
        // Noise alone is left white.
        let part = DARKEST * (1.0 - 1.0 / rms.max(1.0));
        let color = if after { BLUE } else { ORANGE };
        figure.fill(corners, color, shade(part));
        figure.outline(corners, GRID);
        let [low, high] = corners;
        let middle = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0];
        figure.text(middle, Anchor::Middle, TINY, INK, &number(rms));
    }
    if rows.squares.is_empty() {
        figure.note([68.0, 52.0], Anchor::Start, MUTED, "no readings");
    }
    figure.finish()
}

/// Two digits where they fit into a square.
fn number(value: f64) -> String {
    match value {
        v if v < 9.95 => format!("{v:.1}"),
        v if v < 999.5 => format!("{v:.0}"),
        _ => "> 999".to_string(),
    }
}

// How far apart the explanations of a class are: what each pair would read
// differently over this log.

/// Side of the map, pixels, and where it starts.
const MAP_SIDE: f64 = 400.0;
const MAP_LEFT: f64 = 44.0;
const MAP_TOP: f64 = 58.0;
/// Squares that have room for a number.
const NUMBERED: usize = 14;

/// RMS differences in units of noise; what no such log tells apart is left white.
pub fn confusion(differences: &[Vec<f64>]) -> String {
    let n = differences.len();
    let pitch = MAP_SIDE / n.max(1) as f64;
    let label = format!("RMS difference between {n} explanations, in units of noise");
    let mut figure = Figure::new([480.0, MAP_TOP + MAP_SIDE + 16.0], &label);
    figure.title(13.0, "How far apart they are");
    figure.note([472.0, 13.0], Anchor::End, MUTED, "RMS difference ÷ noise");
    for (row, values) in differences.iter().enumerate() {
        for (column, &value) in values.iter().enumerate().take(n) {
            let [x, y] = [
                MAP_LEFT + pitch * column as f64,
                MAP_TOP + pitch * row as f64,
            ];
            let corners = [[x, y], [x + pitch, y + pitch]];
            if value.is_finite() && row != column {
                // Half the noise and more is seen in some hundred postures.
                figure.fill(corners, BLUE, shade(DARKEST * value / (value + 0.5)));
                if n <= NUMBERED {
                    let middle = [x + pitch / 2.0, y + pitch / 2.0];
                    let text = match value < 0.995 {
                        true => format!("{value:.2}"),
                        false => number(value),
                    };
                    figure.text(middle, Anchor::Middle, TINY, INK, &text);
                }
            }
            figure.outline(corners, GRID);
        }
        let middle = pitch * (row as f64 + 0.5);
        let name = (row + 1).to_string();
        figure.note(
            [MAP_LEFT - 8.0, MAP_TOP + middle],
            Anchor::End,
            MUTED,
            &name,
        );
        figure.note(
            [MAP_LEFT + middle, MAP_TOP - 11.0],
            Anchor::Middle,
            MUTED,
            &name,
        );
    }
    if n == 0 {
        let place = [MAP_LEFT + 20.0, MAP_TOP + 20.0];
        figure.note(place, Anchor::Start, INK, "nothing to tell apart");
    }
    figure.finish()
}
