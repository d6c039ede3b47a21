//! Rows of the log that is read now, on their way to folds: whole where they are
//! independent, freed of their correlation where they are not.

use super::timing::Timing;
use crate::logs::Block;
use crate::observations::correlation::{Independent, Whitener};
use crate::observations::rows::Rows;

/// State between the blocks of a log.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stream {
    pub timing: Timing,
    /// Rows so far.
    pub rows: usize,
    /// Rows in motion, and the square sum of what it adds to their readings, m².
    pub moving: (usize, f64),
    whiteners: Option<[Whitener; 2]>,
}

impl Default for Stream {
    fn default() -> Stream {
        Stream::new(&Timing::NONE)
    }
}

impl Stream {
    pub fn new(timing: &Timing) -> Stream {
        let processes = timing.correlation.map(|axis| axis.process);
        let whiteners = processes.map(|process| Whitener::new(process.unwrap_or_default()));
        Stream {
            whiteners: processes.iter().any(Option::is_some).then_some(whiteners),
            timing: timing.clone(),
            rows: 0,
            moving: (0, 0.0),
        }
    }

    /// Whether rows are freed of their correlation.
    pub fn whitens(&self) -> bool {
        self.whiteners.is_some()
    }

    /// Numbers of the blocks of time that rows are in, where those are held out.
    pub fn keys(&self, block: &Block) -> Option<Vec<i64>> {
        let ((start, length), t) = (self.timing.blocks?, block.t.as_ref()?);
        Some(
            t.iter()
                .map(|t| ((t - start) / length).floor() as i64)
                .collect(),
        )
    }

    /// Fold of a key.
    pub fn fold(&self, key: i64, folds: usize) -> usize {
        match self.timing.blocks {
            Some(_) => key.rem_euclid(folds as i64) as usize,
            None => drawn(key, folds),
        }
    }

    /// The independent rows that a block's rows complete: each has a time, the key that deals it
    /// to its fold, deviations, m or in units of both axes' RMS, and a trust, 0 to 1.
    pub fn push(
        &mut self,
        t: &[f64],
        rows: &Rows,
        keys: &[i64],
        std: &[[f64; 2]],
        trust: &[f64],
    ) -> Vec<Independent> {
        let params = rows.matrix.columns;
        let Timing { axes, freed, .. } = &self.timing;
        let (mut row, mut ended) = (vec![0.0; params + 1], Vec::new());
        for (k, &t) in t.iter().enumerate() {
            for (axis, whitener) in self.whiteners.iter_mut().flatten().enumerate() {
                let weight = axes[axis] / freed[axis] / std[k][axis];
                for (to, from) in row.iter_mut().zip(rows.matrix.row(2 * k + axis)) {
                    *to = from * weight;
                }
                row[params] = rows.reading[2 * k + axis] * weight;
                ended.extend(whitener.push(t, keys[k], &row, trust[k]));
            }
        }
        ended
    }

    /// The independent rows that the end of the log completes.
    pub fn end(&mut self) -> Vec<Independent> {
        self.whiteners
            .iter_mut()
            .flatten()
            .flat_map(Whitener::end)
            .collect()
    }
}

/// A pseudo-random fold for a key, the same on every machine.
fn drawn(key: i64, folds: usize) -> usize {
    let mut x = (key as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) % folds as u64) as usize
}
