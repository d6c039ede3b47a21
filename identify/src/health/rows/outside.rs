//! Readings where no CoP can be.
//!
//! ```text
//! box = hull(cells ∪ CoP by CAD), wider by max(0.15 m, 0.5 × its diameter)
//! ```
//!
//! A few such rows are left out. Where most are, the log is of another frame or unit:
//! readings that are CAD's but for a factor (millimetres) are an effect and no finding.

use super::Rows;
use super::screen::LeftOut;
use crate::health::criteria::{FOLLOWS, MARGIN_M, MARGIN_OF_CLOUD, MOST_OUTSIDE, OTHER_UNIT};
use crate::health::statistics::{left_by_plane, scatter};
use crate::health::{Finding, Kind, Picture};

pub(super) fn sole(rows: &Rows, left_out: &mut LeftOut) -> Option<Finding> {
    let everywhere = rows.cad.iter().chain(&rows.cad_of_degrees);
    let all: Vec<[f64; 2]> = everywhere.chain(&rows.places).copied().collect();
    let corner = |worse: fn(f64, f64) -> f64, start: f64| {
        [0, 1].map(|k| all.iter().map(|p| p[k]).fold(start, worse))
    };
    let (low, high) = (
        corner(f64::min, f64::INFINITY),
        corner(f64::max, f64::NEG_INFINITY),
    );
    let size = (high[0] - low[0]).hypot(high[1] - low[1]);
    if !size.is_finite() {
        return None;
    }
    let margin = MARGIN_M.max(MARGIN_OF_CLOUD * size);
    let sole = [low.map(|x| x - margin), high.map(|x| x + margin)];
    let inside = LeftOut {
        sole: Some(sole),
        ..LeftOut::default()
    };
    let beyond: Vec<usize> = (0..rows.len())
        .filter(|&k| !inside.keeps(rows.reading[k], &[]))
        .collect();
    let share = beyond.len() as f64 / rows.len().max(1) as f64;
    let furthest = |rows_of: &[usize]| {
        let far = rows_of
            .iter()
            .map(|&k| rows.reading[k][0].hypot(rows.reading[k][1]));
        far.fold(0.0, f64::max)
    };
    if beyond.is_empty() || share > MOST_OUTSIDE && follows(rows) {
        return None;
    }
    let (count, total) = (beyond.len(), rows.len());
    let seen = format!(
        "The CoP of {count} of {total} rows lies beyond the sole and every CoP that CAD predicts, up \
         to {:.2} m from the frame's origin",
        furthest(&beyond)
    );
    let sentence = match share > MOST_OUTSIDE {
        true => format!(
            "{seen}: check that the support frame lies on the sole and that the CoP is given in it, \
             in metres."
        ),
        false => {
            left_out.sole = Some(sole);
            format!("{seen}: these rows are left out; check the sensor's cable and the topic.")
        }
    };
    let length = |k: usize| 1e3 * rows.reading[k][0].hypot(rows.reading[k][1]);
    let title = "Distance of the CoP from the origin, mm";
    let picture = Picture::of(title, total, length, |k| {
        !inside.keeps(rows.reading[k], &[])
    });
    Some(Finding::new(Kind::CopOutsideSole, "-", sentence).showing(picture))
}

/// Whether readings are CAD's CoP in another unit.
fn follows(rows: &Rows) -> bool {
    let column = |all: &[[f64; 2]], k: usize| -> Vec<f64> { all.iter().map(|p| p[k]).collect() };
    let (x, y) = (column(&rows.cad, 0), column(&rows.cad, 1));
    (0..2).all(|k| {
        let read = column(&rows.reading, k);
        let larger = scatter(&read) > OTHER_UNIT * scatter(&x).max(scatter(&y));
        larger && left_by_plane(&read, [&x, &y]) < FOLLOWS * scatter(&read)
    })
}
