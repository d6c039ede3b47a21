//! What the error is made of: noise against readings, little against truth.

use plotters::style::RGBColor;

use super::super::svg::{self, Area, BLUE, Drawn, INK, MUTED, Side, fill, line, note, px, title};
use super::super::table::mm;
use super::super::{DemoReport, Errors};

/// Left end of all bars and length of the longest, pixels.
const LEFT: f64 = 140.0;
const LONGEST: f64 = 390.0;
const THICK: f64 = 18.0;

/// Errors of one kind, and the mark that noise or theory sets them.
struct Group<'t> {
    heading: &'t str,
    bars: [(String, f64); 2],
    color: RGBColor,
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
    let groups = [
        Group {
            heading: "Against noisy readings, mean |error|",
            bars: [
                ("new postures".to_string(), measured_mae_m),
                ("fitted postures".to_string(), in_sample_mae_m),
            ],
            color: MUTED,
            limit: ("noise alone", noise_mae_m),
        },
        Group {
            heading: "Against the true CoP, new postures, RMS",
            bars: [
                (
                    format!("{} base parameters", report.base_params),
                    clean_rmse_base_m,
                ),
                (
                    format!("all {} columns", report.full_params),
                    clean_rmse_full_m,
                ),
            ],
            color: BLUE,
            limit: ("theory", theory_rmse_m),
        },
    ];
    let lengths = groups
        .iter()
        .flat_map(|g| [g.bars[0].1, g.bars[1].1, g.limit.1]);
    let longest = lengths
        .filter(|length| length.is_finite())
        .fold(1e-9, f64::max);
    let label = format!(
        "Bars: error against noisy readings {} mm, noise alone {} mm; \
         error against the true CoP {} mm, theory {} mm",
        mm(measured_mae_m),
        mm(noise_mae_m),
        mm(clean_rmse_base_m),
        mm(theory_rmse_m)
    );
    svg::figure([620, 222], &label, |area| {
        groups
            .iter()
            .zip([14.0, 130.0])
            .try_for_each(|(group, top)| draw(area, group, top, longest))
    })
}

fn draw(area: &Area<'_>, group: &Group<'_>, top: f64, longest: f64) -> Drawn {
    let at = |length: f64| LEFT + LONGEST * length / longest;
    title(area, group.heading, (px(2.0), px(top)))?;
    for (k, (name, length)) in group.bars.iter().enumerate() {
        let upper = top + 34.0 + k as f64 * (THICK + 6.0);
        let middle = px(upper + THICK / 2.0);
        note(area, name, (px(LEFT - 10.0), middle), Side::Right, INK)?;
        if length.is_finite() {
            fill(
                area,
                [(px(LEFT), px(upper)), (px(at(*length)), px(upper + THICK))],
                group.color,
            )?;
        }
        let text = format!("{} mm", mm(*length));
        // Beyond the mark of the limit, whichever is longer.
        let end = [*length, group.limit.1]
            .into_iter()
            .filter(|x| x.is_finite())
            .fold(0.0, f64::max);
        svg::write(
            area,
            &text,
            (px(at(end) + 8.0), middle),
            Side::Left,
            13.0,
            INK,
            true,
        )?;
    }
    let (name, limit) = group.limit;
    if limit.is_finite() {
        let x = px(at(limit));
        line(
            area,
            vec![(x, px(top + 28.0)), (x, px(top + 40.0 + 2.0 * THICK + 6.0))],
            INK,
            2.0,
        )?;
        let text = format!("{name} {} mm", mm(limit));
        note(area, &text, (x, px(top + 20.0)), Side::Middle, INK)?;
    }
    Ok(())
}
