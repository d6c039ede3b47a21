//! The held-out error on its way from CAD, effect by effect, to the noise.

use super::super::super::svg::{
    self, BAND, BLUE, INK, MUTED, ORANGE, Side, fill, line, note, px, title,
};
use super::super::super::table::mm;
use super::shortened;
use sesc_identify::diagnose::view::{Stage, StageKind};

const LEFT: f64 = 236.0;
const LONGEST: f64 = 280.0;
const THICK: f64 = 20.0;
const PITCH: f64 = 34.0;
const TOP: f64 = 34.0;
/// Letters beside a bar.
const NAME: usize = 33;

/// One bar per stage; the part that a stage takes away stays as a pale bar.
pub fn waterfall(stages: &[Stage]) -> String {
    let words: Vec<String> = stages
        .iter()
        .map(|stage| format!("{} {} mm", stage.name, mm(stage.rmse)))
        .collect();
    let label = format!("Held-out RMS error: {}", words.join(", "));
    let height = TOP + PITCH * stages.len() as f64 + 4.0;
    svg::figure([600, height as u32], &label, |area| {
        title(area, "RMS error per axis, held out", (px(2.0), px(13.0)))?;
        let finite = stages.iter().map(|s| s.rmse).filter(|x| x.is_finite());
        let longest = finite.fold(f64::MIN_POSITIVE, f64::max);
        let at = |rmse: f64| match rmse.is_finite() {
            true => LEFT + LONGEST * rmse / longest,
            false => LEFT,
        };
        if let Some(noise) = stages.iter().find(|s| s.kind == StageKind::Noise) {
            let x = px(at(noise.rmse));
            let places = vec![(x, px(TOP - 4.0)), (x, px(height - 6.0))];
            line(area, places, BAND, 1.5)?;
        }
        for (k, stage) in stages.iter().enumerate() {
            let upper = TOP + PITCH * k as f64;
            let middle = px(upper + THICK / 2.0);
            let name = shortened(&stage.name, NAME);
            note(area, &name, (px(LEFT - 10.0), middle), Side::Right, INK)?;
            let bar = |from: f64, to: f64| [(px(from), px(upper)), (px(to), px(upper + THICK))];
            let end = at(stage.rmse);
            let mut after = end;
            if stage.kind == StageKind::Better && k > 0 && at(stages[k - 1].rmse) > end {
                after = at(stages[k - 1].rmse);
                fill(area, bar(end, after), svg::GRID)?;
            }
            let color = match stage.kind {
                StageKind::Cad => ORANGE,
                StageKind::Better => BLUE,
                StageKind::Noise => MUTED,
            };
            fill(area, bar(LEFT, end), color)?;
            let text = format!("{} mm", mm(stage.rmse));
            let place = (px(after + 8.0), middle);
            svg::write(area, &text, place, Side::Left, 13.0, INK, true)?;
        }
        Ok(())
    })
}
