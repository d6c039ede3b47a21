//! What a figure of a finding shows: one number of each row, and which rows are meant.

/// Rows that a figure shows, at most; evenly chosen of more.
const MOST: usize = 500;

/// One number over the rows of a log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Picture {
    /// What it is, with its unit.
    pub title: String,
    /// Rows from 1, values, and whether the finding is about the row.
    pub points: Vec<(usize, f64, bool)>,
}

impl Picture {
    /// The value of every row.
    pub(super) fn of(
        title: &str,
        rows: usize,
        value: impl Fn(usize) -> f64,
        meant: impl Fn(usize) -> bool,
    ) -> Picture {
        let chosen = (0..rows).step_by(rows.div_ceil(MOST).max(1));
        Picture {
            title: title.to_string(),
            points: chosen.map(|k| (k + 1, value(k), meant(k))).collect(),
        }
    }
}
