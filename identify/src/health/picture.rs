//! What a figure of a finding shows: one number of each row, which rows are meant, and how the
//! robot stood in them.

use crate::observations::postures::Postures;

/// Points that a figure shows, at most; evenly chosen of more.
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
    /// Every row that has points, once, in their order.
    pub rows: Vec<Row>,
    /// What other points and those of the finding are, where not rows.
    pub marks: Option<[String; 2]>,
}

/// A row of a log, and how the robot stood in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// From 1.
    pub number: usize,
    /// Number of its posture in the log.
    pub pose: i64,
    /// Joint by joint, rad or m.
    pub q: Vec<f64>,
}

impl Row {
    /// Posture `k` of those of a log.
    pub(crate) fn among(data: &Postures, k: usize) -> Row {
        let dof = data.q.len() / data.len().max(1);
        Row {
            number: k + 1,
            pose: data.pose[k],
            q: data.q[k * dof..(k + 1) * dof].to_vec(),
        }
    }
}

impl Picture {
    /// The value of each of so many rows.
    pub(super) fn of(
        title: &str,
        rows: usize,
        row: impl Fn(usize) -> Row,
        value: impl Fn(usize) -> f64,
        meant: impl Fn(usize) -> bool,
    ) -> Picture {
        Picture::chosen(title, rows, row, |k| [(value(k), meant(k))])
    }

    /// N values of each of so many rows, and whether the finding is about them; of at most
    /// [`MOST`] / N rows, evenly chosen.
    pub(crate) fn chosen<const N: usize>(
        title: &str,
        rows: usize,
        row: impl Fn(usize) -> Row,
        values: impl Fn(usize) -> [(f64, bool); N],
    ) -> Picture {
        let mut picture = Picture {
            title: title.to_string(),
            ..Picture::default()
        };
        for k in (0..rows).step_by((N * rows).div_ceil(MOST).max(1)) {
            let own = row(k);
            let point = |(value, meant)| (own.number, value, meant);
            picture.points.extend(values(k).map(point));
            picture.rows.push(own);
        }
        picture
    }

    /// What other points and those of the finding are.
    pub fn marks(&self) -> [&str; 2] {
        match &self.marks {
            Some([other, meant]) => [other, meant],
            None => MARKS,
        }
    }
}
