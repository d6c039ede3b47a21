//! Figures of the demo, after those of the SESC paper: rows in, SVG out.

use super::super::plot::{Mark, Panel, Point, outline, rule, segments, series, span, stacked};
use super::super::svg::{Anchor, BAND, BLUE, Color, INK, MUTED, ORANGE, SMALL};
use super::super::table::mm;
use super::super::{CopRow, DemoReport, Errors, HeightRow, LengthRow};
use super::{Bar, HALF, Length, bars, longest, to_mm};

/// What the error is made of, against readings and against the truth, and what noise or theory
/// set it: noise against readings, little against truth.
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
    let noisy = [
        Bar::new("new postures", measured_mae_m, MUTED),
        Bar::new("fitted postures", in_sample_mae_m, MUTED),
    ];
    let clean = [
        Bar::new(&base, clean_rmse_base_m, BLUE),
        Bar::new(&full, clean_rmse_full_m, BLUE),
    ];
    let [noise, theory] = [("noise alone", noise_mae_m), ("theory", theory_rmse_m)]
        .map(|(name, limit)| (format!("{name} {} mm", mm(limit)), limit));
    let lengths = noisy.iter().chain(&clean).map(|bar| bar.length_m);
    let longest = longest(lengths.chain([noise.1, theory.1]));
    let panel =
        |title, own, (name, limit): &(String, f64)| bars(title, own, (name, *limit), longest);
    let label = format!(
        "Bars: error against noisy readings {} mm, {}; error against the true CoP {} mm, {}",
        mm(measured_mae_m),
        noise.0,
        mm(clean_rmse_base_m),
        theory.0
    );
    let panels = vec![
        panel("Against noisy readings, mean |error|", &noisy, &noise),
        panel("Against the true CoP, new postures, RMS", &clean, &theory),
    ];
    stacked(620.0, label, panels)
}

// CoP over postures and on the ground (the paper's Figs. 3b and 7).

/// CAD is drawn where it differs from the truth by more than this, mm.
const VISIBLE_MM: f64 = 0.05;

/// One coordinate (0: x, 1: y) over postures, and its errors below. The page has the first row's
/// posture under the number `first`.
pub fn cop_over_postures(rows: &[CopRow], axis: usize, first: usize) -> String {
    let name = ["x", "y"][axis];
    let places = |of: fn(&CopRow, usize) -> f64| {
        let rows = rows.iter().zip(1..);
        rows.map(move |(row, k)| [f64::from(k), to_mm(of(row, axis))])
    };
    let dots = |mark, name: &str, of| {
        let points = places(of).zip(first..).map(|(at, k)| Point::posture(k, at));
        series(mark, points).named(name)
    };
    let differs = |row: &CopRow| to_mm(row.cad[axis] - row.truth[axis]).abs() > VISIBLE_MM;
    let cad = rows.iter().any(differs);
    let cad = cad.then(|| places(|row, axis| row.cad[axis]));
    let read = |row: &CopRow, axis: usize| row.measured[axis] - row.truth[axis];
    let found = |row: &CopRow, axis: usize| row.identified[axis] - row.truth[axis];
    let rests = rows.iter().flat_map(|row| {
        let rests = [read(row, axis), found(row, axis)].map(to_mm);
        [rests[0], -rests[0], rests[1], -rests[1]]
    });
    let identified = places(|row, axis| row.identified[axis]);
    let x = Some(0.0..(rows.len() + 1) as f64);
    let panels = vec![
        Panel {
            title: format!("CoP {name}, mm"),
            x: x.clone(),
            ticks: [6, 6],
            height: 172.0,
            series: vec![
                series(Mark::Line(BAND, 7.0), places(|row, axis| row.truth[axis])).named("truth"),
                series(Mark::Line(ORANGE, 1.25), cad.into_iter().flatten()).named("CAD"),
                dots(Mark::Ring(MUTED), "reading", |row, axis| row.measured[axis]),
                series(Mark::Line(BLUE, 1.75), identified).named("identified"),
            ],
            ..Panel::default()
        },
        Panel {
            title: format!("Error of CoP {name}, mm"),
            x,
            y: Some(span(rests)),
            x_name: "posture".to_string(),
            ticks: [6, 4],
            height: 88.0,
            series: vec![
                rule(1, 0.0, INK, 1.0),
                dots(Mark::Ring(MUTED), "reading", read),
                dots(Mark::dot(BLUE), "identified", found),
            ],
            ..Panel::default()
        },
    ];
    let label = format!(
        "CoP {name} over {} held-out postures, mm: reading, truth, identified",
        rows.len()
    );
    stacked(HALF, label, panels)
}

/// The CoP on the ground, seen from above, and the sole around the origin
/// (length, width, m). The page has the first row's posture under the number `first`.
pub fn cop_plane(rows: &[CopRow], sole_m: [f64; 2], first: usize) -> String {
    let half = sole_m.map(|length| to_mm(length) / 2.0);
    let dots = |mark, name: &str, pick: fn(&CopRow) -> [f64; 2]| {
        let points = rows.iter().zip(first..);
        let points = points.map(|(row, k)| Point::posture(k, pick(row).map(to_mm)));
        series(mark, points).named(name)
    };
    let apart = rows.iter();
    let apart = apart.map(|row| [row.truth, row.measured].map(|at| at.map(to_mm)));
    let panel = Panel {
        title: "CoP from above, mm".to_string(),
        x_name: "x, forward; y, left".to_string(),
        ticks: [7, 7],
        height: 334.0,
        is_map: true,
        series: vec![
            outline(INK, [half.map(|x| -x), half]).named("sole"),
            segments(BAND, 2.0, apart),
            dots(Mark::Ring(MUTED), "reading", |row| row.measured),
            dots(Mark::Ring(INK), "truth", |row| row.truth),
            dots(Mark::dot(BLUE), "identified", |row| row.identified),
        ],
        ..Panel::default()
    };
    let label = format!(
        "CoP of {} held-out postures on the ground, mm, with the outline of the sole",
        rows.len()
    );
    panel.alone(HALF, label)
}

// ‖r_i‖ from CAD and identified, body by body (the paper's Fig. 3a).

/// All columns by pseudo-inverse: lengths that CAD does not share, where part
/// of the vector cannot be known.
pub fn lengths_full(rows: &[LengthRow]) -> String {
    lengths(
        rows,
        "‖r‖ from all columns, mm",
        |row| [row.cad_m, row.full_m],
        |row| !row.unseen.is_empty(),
    )
}

/// The identifiable part alone: lengths that agree with CAD, but for the
/// body that stands, whose height is the constant flat CoP cannot tell.
pub fn lengths_base(rows: &[LengthRow]) -> String {
    lengths(
        rows,
        "‖identifiable r‖, mm",
        |row| [row.base_cad_m, row.base_m],
        |row| row.joint.is_empty() && !row.unseen.is_empty(),
    )
}

fn lengths(
    rows: &[LengthRow],
    title: &str,
    pair: fn(&LengthRow) -> [f64; 2],
    partly_unseen: fn(&LengthRow) -> bool,
) -> String {
    let lengths = rows.iter().map(|row| {
        let line @ [cad, found] = pair(row);
        Length {
            body: &row.body,
            cad,
            found,
            line,
            is_told: !partly_unseen(row),
            more: " mm".to_string(),
        }
    });
    let lengths: Vec<Length<'_>> = lengths.collect();
    let unseen = match rows.iter().all(partly_unseen) {
        true => "identified, partly unseen",
        false => "partly unseen",
    };
    let mut panel = super::lengths(title, &lengths, ["identified", unseen]);
    // Both figures of a page share the scale.
    let all = rows
        .iter()
        .flat_map(|r| [r.cad_m, r.full_m, r.base_cad_m, r.base_m]);
    panel.x = Some(0.0..span(all.map(to_mm).chain([0.0])).end);
    let label = format!("{title}: CAD and identified for {} bodies", rows.len());
    panel.alone(HALF, label)
}

// CoM height over postures (the paper's Fig. 8): its shape is known, one
// constant is not.

/// The identified height with the constant of minimum norm, off by `offset_m`. The page has the
/// first row's posture under the number `first`.
pub fn height_level(rows: &[HeightRow], offset_m: f64, first: usize) -> String {
    let pick = |row: &HeightRow| row.identified;
    let mut panel = heights(rows, "CoM height as fitted, mm", (pick, ORANGE), first);
    let both = |row: &HeightRow| [row.truth, row.identified].map(to_mm);
    let apart = rows.iter().zip(1..);
    let apart = apart.map(|(row, k)| both(row).map(|height| [f64::from(k), height]));
    panel.series.push(segments(ORANGE, 0.75, apart));
    panel.series.push(rule(1, 0.0, BAND, 1.0));
    // The text stands under the curves where it has room.
    let all = rows
        .iter()
        .flat_map(both)
        .filter(|height| height.is_finite());
    let [low, high] = [f64::min, f64::max].map(|pick| all.clone().reduce(pick).unwrap_or(0.0));
    if low > 0.3 * high {
        let apart = format!("on average {} mm apart:", mm(offset_m.abs()));
        for (down, said) in [
            (-8.0, apart.as_str()),
            (8.0, "one constant that flat CoP cannot tell"),
        ] {
            let beside = Mark::Words(INK, SMALL, Anchor::Start, [20.0, down]);
            let said = Point::worded(said, [0.0, low / 2.0]);
            panel.series.push(series(beside, [said]));
        }
    }
    let label = format!(
        "CoM height over {} postures: identified lies {} mm off the truth",
        rows.len(),
        mm(offset_m)
    );
    panel.alone(HALF, label)
}

/// The identified height with its constant from CAD, magnified. The page has the first row's
/// posture under the number `first`.
pub fn height_shape(rows: &[HeightRow], first: usize) -> String {
    let title = "CoM height, constant from CAD, mm";
    let panel = heights(rows, title, (|row| row.anchored, BLUE), first);
    let label = format!(
        "CoM height over {} postures with the constant from CAD: identified follows the truth",
        rows.len()
    );
    panel.alone(HALF, label)
}

/// The true curve, and another one with a dot for each posture.
fn heights(
    rows: &[HeightRow],
    title: &str,
    (pick, color): (fn(&HeightRow) -> f64, Color),
    first: usize,
) -> Panel {
    let curve = |pick: fn(&HeightRow) -> f64| {
        let rows = rows.iter().zip(1..);
        rows.map(move |(row, k)| [f64::from(k), to_mm(pick(row))])
    };
    let dots = curve(pick).zip(first..);
    let dots = dots.map(|(at, k)| Point::posture(k, at));
    Panel {
        title: title.to_string(),
        x: Some(0.0..(rows.len() + 1) as f64),
        x_name: "posture".to_string(),
        ticks: [6, 6],
        height: 204.0,
        series: vec![
            series(Mark::Line(BAND, 7.0), curve(|row| row.truth)).named("truth"),
            series(Mark::Line(color, 1.75), curve(pick)).named("identified"),
            series(Mark::Dot(color, 2.4), dots),
        ],
        ..Panel::default()
    }
}

/// Squares side by side.
const PER_ROW: usize = 21;

/// How many parameters flat CoP tells apart: one square per column, told by flat CoP, told by the
/// height of the CoM alone, told by nothing.
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
    let squares = |range: std::ops::Range<usize>| {
        range.map(|k| {
            let [x, y] = [k % PER_ROW, k / PER_ROW].map(|k| k as f64);
            Point::from([x + 0.5, -y - 0.5])
        })
    };
    let (seen, sums) = (Mark::Square(BLUE, 17.0), Mark::Frame(ORANGE, 16.0));
    let panel = Panel {
        x: Some(0.0..PER_ROW as f64),
        y: Some(-rows..0.0),
        height: 22.0 * rows,
        series: vec![
            series(seen, squares(0..rank_cop)).named(format!("{rank_cop} from flat CoP")),
            series(Mark::Square(ORANGE, 17.0), squares(rank_cop..base_params))
                .named(format!("{height} height constant")),
            series(sums, squares(base_params..full_params)).named(format!("{lost} only in sums")),
        ],
        ..Panel::default()
    };
    let label = format!(
        "Of {full_params} parameters flat CoP tells {rank_cop} apart; {height} needs the CoM \
         height; {lost} only move to a neighbour"
    );
    panel.alone(HALF, label)
}
