//! What a figure of a finding shows: one number of each row, and which rows are meant.

/// Rows that a figure shows, at most; evenly chosen of more.
const MOST: usize = 500;

/// What two marks of a figure mean where nothing else is said of them.
const MARKS: [&str; 2] = ["row", "what the finding is about"];

/// One number over the rows of a log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Picture {
    /// What it is, with its unit.
    pub title: String,
    /// Rows from 1, values, and whether the finding is about the row.
    pub points: Vec<(usize, f64, bool)>,
    /// What other points and those of the finding are, where not rows.
    pub marks: Option<[String; 2]>,
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
            marks: None,
        }
    }

    /// Two values of every row: one that would be in order, and that of the finding.
    pub(super) fn of_two(
        title: &str,
        rows: usize,
        [sound, found]: [&dyn Fn(usize) -> f64; 2],
        marks: [&str; 2],
    ) -> Picture {
        let chosen = (0..rows).step_by((2 * rows).div_ceil(MOST).max(1));
        let both = |k: usize| [(k + 1, sound(k), false), (k + 1, found(k), true)];
        Picture {
            title: title.to_string(),
            points: chosen.flat_map(both).collect(),
            marks: Some(marks.map(str::to_string)),
        }
    }

    /// With the numbers of rows in their log.
    pub(super) fn numbered(mut self, number: impl Fn(usize) -> usize) -> Picture {
        for point in &mut self.points {
            point.0 = number(point.0 - 1);
        }
        self
    }

    /// What other points and those of the finding are.
    pub fn marks(&self) -> [&str; 2] {
        match &self.marks {
            Some([other, meant]) => [other, meant],
            None => MARKS,
        }
    }
}
