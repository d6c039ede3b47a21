//! Readings that stay the same to the last digit while the joints move: a stale message.
//!
//! ```text
//! y_k = y_{k−1} = …   over a run of rows in which CAD moves the CoP by more than noise and steps
//! ```
//!
//! A sensor that is slower than the joints holds each reading for a few rows: a run is frozen
//! if it is several times as long as others are.

use super::LogRows;
use super::digits::{key, reading_of, step};
use super::screen::LeftOut;
use crate::health::criteria::{
    FEW_ROWS, FROZEN_LONGER, FROZEN_MOVES, FROZEN_MOVES_M, FROZEN_STEPS, MOST_LOST,
};
use crate::health::{Finding, Kind, Picture};
use crate::observations::postures::range;

/// What may freeze: one axis of the CoP, or the cells together.
struct Channel {
    values: Vec<u64>,
    /// CoP by CAD of what it shows, m.
    cad: Vec<[f64; 2]>,
    /// CAD moves it by more than this in a frozen run, m.
    least: f64,
    /// Runs that show one of these are clipped.
    ends: [u64; 2],
}

/// A run of rows: the first, and one past the last.
type Run = (usize, usize);

pub(super) fn stretches(rows: &LogRows, left_out: &mut LeftOut) -> Option<Finding> {
    let n = rows.len();
    let kept = rows.kept(left_out);
    let mut frozen = vec![[false; 2]; n];
    let mut first: Option<(Run, f64)> = None;
    let mut count = 0;
    let channels = channels(rows, &kept);
    for (number, channel) in channels.iter().enumerate() {
        for (run, moved) in channel.frozen() {
            count += 1;
            for &k in &kept[run.0..run.1] {
                frozen[k][number] = true;
            }
            left_out.frozen.insert((number, channel.values[run.0]));
            if first.is_none_or(|(known, _)| run.1 - run.0 > known.1 - known.0) {
                first = Some(((kept[run.0], kept[run.1 - 1] + 1), moved));
            }
        }
    }
    let ((from, to), moved) = first?;
    let is_frozen = |k: usize| frozen[k][0] || frozen[k][1];
    let rows_frozen = (0..n).filter(|&k| is_frozen(k)).count();
    let on = |axis: usize| (0..n).filter(|&k| frozen[k][axis]).count();
    // Target of the finding, what stays, and the axis that shows it. A stretch of both axes was
    // counted on each.
    let (target, what, axis, stretches) = match (rows.cells > 0, on(0), on(1)) {
        (true, ..) => ("-", "loads of the cells stay", 0, count),
        (_, _, 0) => ("x", "cop_x stays", 0, count),
        (_, 0, _) => ("y", "cop_y stays", 1, count),
        _ => ("-", "CoP stays", 0, count / 2),
    };
    let title = ["CoP x, mm", "CoP y, mm"][axis];
    let reading = |k: usize| 1e3 * rows.reading[k][axis];
    let picture = Picture::of(title, n, |k| rows.row(k), reading, is_frozen);
    let share = 100.0 * rows_frozen as f64 / n as f64;
    if rows_frozen as f64 > MOST_LOST * n as f64 {
        left_out.frozen.clear();
        let sentence = format!(
            "In {rows_frozen} of {} the {what} the same to the last digit while CAD moves \
             the CoP by up to {:.1} mm: check that the sensor is on and that its topic is the \
             right one.",
            rows.total(),
            1e3 * moved
        );
        let finding = Finding::new(Kind::CopConstant, "-", sentence);
        return Some(finding.showing(picture));
    }
    let stretches = match stretches {
        0 | 1 => "one stretch".to_string(),
        several => format!("{several} stretches"),
    };
    let sentence = format!(
        "In {} ({share:.0} %, {stretches}; the longest is rows {} to {}) the \
         {what} the same to the last digit while the joints move it by {:.1} mm: the message is \
         stale; these rows are left out. Check the sensor's driver and how its topic was recorded.",
        rows.some(rows_frozen),
        rows.number[from],
        rows.number[to - 1],
        1e3 * moved
    );
    Some(Finding::new(Kind::CopFrozen, target, sentence).showing(picture))
}

fn channels(rows: &LogRows, kept: &[usize]) -> Vec<Channel> {
    let noise = FROZEN_MOVES * rows.noise.unwrap_or(0.0);
    let least = noise.max(FROZEN_MOVES_M);
    if rows.cells > 0 {
        let values = |&k: &usize| key(&[], &reading_of(rows.reading[k], rows.force(k)));
        return vec![Channel {
            values: kept.iter().map(values).collect(),
            cad: kept.iter().map(|&k| rows.cad[k]).collect(),
            least,
            ends: [0; 2],
        }];
    }
    let of = |axis: usize| {
        let alone = |at: [f64; 2]| [0, 1].map(|k| if k == axis { at[k] } else { 0.0 });
        let values: Vec<f64> = kept.iter().map(|&k| rows.reading[k][axis]).collect();
        let (low, high) = range(values.iter().copied());
        Channel {
            least: least.max(FROZEN_STEPS * step(&values).unwrap_or(0.0)),
            ends: [low.to_bits(), high.to_bits()],
            values: values.iter().map(|x| x.to_bits()).collect(),
            cad: kept.iter().map(|&k| alone(rows.cad[k])).collect(),
        }
    };
    vec![of(0), of(1)]
}

impl Channel {
    /// Frozen runs, and how far CAD moves the CoP in each, m.
    fn frozen(&self) -> Vec<(Run, f64)> {
        let n = self.values.len();
        let starts = (0..n).filter(|&k| k == 0 || self.values[k] != self.values[k - 1]);
        let starts: Vec<usize> = starts.collect();
        let ends = starts.iter().skip(1).copied().chain([n]);
        let runs: Vec<Run> = starts.iter().copied().zip(ends).collect();
        let mut lengths: Vec<usize> = runs.iter().map(|run| run.1 - run.0).collect();
        lengths.sort_unstable();
        // A channel that never moves is another finding.
        let Some(&typical) = lengths.get(lengths.len() / 2).filter(|_| runs.len() > 1) else {
            return Vec::new();
        };
        let longest = FEW_ROWS.max(FROZEN_LONGER * typical);
        let moved = |run: &Run| {
            let own = &self.cad[run.0..run.1];
            let [x, y] = [0, 1].map(|axis| {
                let (low, high) = range(own.iter().map(|p| p[axis]));
                high - low
            });
            x.hypot(y)
        };
        runs.into_iter()
            .filter(|run| run.1 - run.0 > longest && !self.is_clipped(run, n))
            .map(|run| (run, moved(&run)))
            .filter(|(_, moved)| *moved > self.least)
            .collect()
    }

    /// Whether a run shows an end of the channel that other rows show, too.
    fn is_clipped(&self, run: &Run, n: usize) -> bool {
        let value = self.values[run.0];
        let outside = (0..run.0).chain(run.1..n);
        self.ends.contains(&value) && outside.filter(|&k| self.values[k] == value).count() > 0
    }
}
