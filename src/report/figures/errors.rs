//! What the error is made of: noise against readings, little against truth.

use super::super::svg::{Anchor, BLUE, Color, Figure, INK, MUTED};
use super::super::table::mm;
use super::super::{DemoReport, Errors};
use super::bars::{Bar, Scale};

/// Left end of all bars and length of the longest, pixels.
const LEFT: f64 = 140.0;
const LONGEST: f64 = 390.0;

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
    let scale = Scale::new(lengths, LEFT, LONGEST);
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
        draw(&mut figure, group, top, &scale);
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

fn draw(figure: &mut Figure, group: &Group<'_>, top: f64, scale: &Scale) {
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
