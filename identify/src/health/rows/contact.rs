//! Stretches in which nothing stands on the sensor, and cells that are not plugged in.

use super::LogRows;
use super::screen::LeftOut;
use crate::health::criteria::{CAD_ELSEWHERE_M, FEW_ROWS, LOADED, MOST_LOST};
use crate::health::{Finding, Kind, Picture};
use crate::logs::LEAST_LOAD_N;

/// Rows without load, or with a CoP of exactly zero where CAD has it elsewhere.
pub(super) fn lost(rows: &LogRows, left_out: &mut LeftOut) -> Option<Finding> {
    let mut rules = LeftOut::default();
    if rows.cells > 0 {
        let mut totals: Vec<f64> = (0..rows.len())
            .map(|k| rows.force(k).iter().sum())
            .collect();
        totals.sort_by(f64::total_cmp);
        let typical = totals[totals.len() / 2];
        rules.least_load = Some((LOADED * typical).max(LEAST_LOAD_N));
    } else {
        let elsewhere = |k: usize| rows.cad[k][0].hypot(rows.cad[k][1]) > CAD_ELSEWHERE_M;
        let zero = |k: &usize| rows.reading[*k] == [0.0; 2] && elsewhere(*k);
        rules.zero = (0..rows.len()).filter(zero).count() >= FEW_ROWS;
    }
    let gone = |k: usize| !rules.keeps(rows.reading[k], rows.force(k));
    let lost: Vec<usize> = (0..rows.len()).filter(|&k| gone(k)).collect();
    let few = if rows.cells > 0 { 1 } else { FEW_ROWS };
    if lost.len() < few || lost.len() as f64 > MOST_LOST * rows.len() as f64 {
        return None;
    }
    let begins = |w: &&[usize]| w[1] > w[0] + 1;
    let stretches = 1 + lost.windows(2).filter(begins).count();
    (left_out.least_load, left_out.zero) = (rules.least_load, rules.zero);
    let what = match rows.cells {
        0 => "the CoP is exactly zero",
        _ => "next to nothing stands on the cells",
    };
    let share = 100.0 * lost.len() as f64 / rows.len() as f64;
    let finding = Finding::new(
        Kind::ContactLost,
        "-",
        format!(
            "In {} ({share:.0} %, {stretches} {}) {what}: the foot lost contact or the sensor \
             dropped out; they are left out. Check that the foot stands flat, and the sensor's cable.",
            rows.some(lost.len()),
            if stretches == 1 {
                "stretch"
            } else {
                "stretches"
            },
        ),
    );
    let length = |k: usize| 1e3 * rows.reading[k][0].hypot(rows.reading[k][1]);
    let load = |k: usize| rows.force(k).iter().sum::<f64>();
    let (title, value): (&str, &dyn Fn(usize) -> f64) = match rows.cells {
        0 => ("Distance of the CoP from the origin, mm", &length),
        _ => ("Load on all cells, N", &load),
    };
    let picture = Picture::of(title, rows.len(), |k| rows.row(k), value, gone);
    Some(finding.showing(picture))
}

/// Cells that never show a load while the others do.
pub(super) fn unplugged(rows: &LogRows) -> Vec<Finding> {
    let never = |cell: usize| {
        let mut loads = (0..rows.len()).map(|k| rows.force(k)[cell]);
        let first = loads.next().unwrap_or(0.0);
        loads.all(|load| load == first)
    };
    let dead: Vec<usize> = (0..rows.cells).filter(|&cell| never(cell)).collect();
    if rows.len() < FEW_ROWS || dead.len() == rows.cells {
        return Vec::new();
    }
    let sentence = |cell: usize| {
        format!(
            "fsr_{} shows {} N in every row while other cells change: it is not plugged in; \
             check its cable. Until then the CoP is that of the other cells.",
            cell + 1,
            rows.force(0)[cell]
        )
    };
    let of = |cell: usize| {
        let load = |k: usize| rows.force(k)[cell];
        let title = format!("Load on fsr_{}, N", cell + 1);
        let picture = Picture::of(&title, rows.len(), |k| rows.row(k), load, |_| true);
        Finding::new(
            Kind::ContactLost,
            &format!("fsr_{}", cell + 1),
            sentence(cell),
        )
        .showing(picture)
    };
    dead.into_iter().map(of).collect()
}
