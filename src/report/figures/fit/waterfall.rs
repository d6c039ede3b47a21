//! From CAD's error to the fit's to the noise: what was gained and what is left.

use super::super::super::svg::{self, BLUE, INK, MUTED, ORANGE, Side, fill, line, note, px, title};
use super::super::super::table::mm;
use sesc_identify::fit::Identification;

const LEFT: f64 = 150.0;
const LONGEST: f64 = 330.0;
const THICK: f64 = 20.0;
const PITCH: f64 = 34.0;
const TOP: f64 = 34.0;

/// One bar per step, RMS per axis against readings.
pub fn waterfall(found: &Identification) -> String {
    let bars = [
        ("CAD", found.cad_rmse, MUTED),
        ("unseen postures", found.held_out_rmse, BLUE),
        ("fitted postures", found.in_sample_rmse, BLUE),
        ("noise alone", found.noise_floor, INK),
        ("model alone", found.expected_error_data, ORANGE),
    ];
    let label = format!(
        "RMS error per axis: CAD {} mm, on unseen postures {} mm, noise {} mm",
        mm(found.cad_rmse),
        mm(found.held_out_rmse),
        mm(found.noise_floor)
    );
    let height = TOP + PITCH * bars.len() as f64 + 4.0;
    svg::figure([600, height as u32], &label, |area| {
        title(area, "RMS error per axis", (px(2.0), px(13.0)))?;
        let finite = bars.iter().map(|bar| bar.1).filter(|x| x.is_finite());
        let longest = finite.fold(f64::MIN_POSITIVE, f64::max);
        let at = |length: f64| LEFT + LONGEST * length / longest;
        if found.noise_floor > 0.0 {
            let x = px(at(found.noise_floor));
            let places = vec![(x, px(TOP - 4.0)), (x, px(height - 6.0))];
            line(area, places, svg::BAND, 1.5)?;
        }
        for (k, (name, length, color)) in bars.into_iter().enumerate() {
            let upper = TOP + PITCH * k as f64;
            let middle = px(upper + THICK / 2.0);
            note(area, name, (px(LEFT - 10.0), middle), Side::Right, INK)?;
            let end = if length.is_finite() { at(length) } else { LEFT };
            fill(
                area,
                [(px(LEFT), px(upper)), (px(end), px(upper + THICK))],
                color,
            )?;
            let text = format!("{} mm", mm(length));
            let place = (px(end + 8.0), middle);
            svg::write(area, &text, place, Side::Left, 13.0, INK, true)?;
        }
        Ok(())
    })
}
