//! Which postures to reach once more, where nothing tells the noise, or what a posture that is
//! reached again differs by.
//!
//! ```text
//! k₁ = argmax ‖Y_k‖        k_i = argmax ‖Y_k − its part in span(Y_{k₁}, …, Y_{k_{i−1}})‖
//! ```
//!
//! Each next posture is the one whose regressor rows Y_k are furthest from those already
//! chosen: spread over the design, so that noise is seen wherever the robot stands.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use sesc_model::Model;

use super::correlation::step;
use super::postures::Postures;
use super::rows::CopRows;
use crate::NextStep;

/// Postures that are asked for.
pub(crate) const COUNT: usize = 5;
/// Rows closer in time than this are a recording, s: it has no postures to reach again.
const RECORDING_S: f64 = 1.0;

/// What a log does not tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Untold {
    /// The noise of a reading.
    Noise,
    /// What visits of one posture differ by: readings repeat within single visits alone.
    Visits,
}

/// Postures to be reached once more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Again {
    /// Their numbers in the log; in ascending order.
    pub poses: Vec<i64>,
    /// Why, and how.
    pub sentence: String,
}

impl Again {
    /// Choose postures to repeat, which tell what is `untold`, among those of `data`, by the rows
    /// of `model` without effects: fits and diagnoses ask for the same, whatever explains the
    /// log. None of recordings, nor of fewer postures than twice those that are asked for.
    pub(crate) fn of(untold: Untold, model: &Model, data: &Postures) -> Option<Again> {
        let rows = CopRows::new(model).of(&data.q, data.len(), None);
        Again::among(untold, &rows, &data.pose, data.t.as_deref())
    }

    /// The same in a log of `poses` whose regressor rows (two per posture) are `rows`, at times
    /// `t` (s).
    fn among(
        untold: Untold,
        rows: &DMatrix<f64>,
        poses: &[i64],
        t: Option<&[f64]>,
    ) -> Option<Again> {
        let recorded = t.and_then(step).is_some_and(|step| step < RECORDING_S);
        if recorded || poses.len() < 2 * COUNT {
            return None;
        }
        let chosen = spread(rows, COUNT);
        let mut poses: Vec<i64> = chosen.into_iter().map(|k| poses[k]).collect();
        poses.sort_unstable();
        poses.dedup();
        let names: Vec<String> = poses.iter().map(i64::to_string).collect();
        let poses_named = names.join(", ");
        let sentence = match untold {
            Untold::Noise => format!(
                "Nothing states the noise and no posture repeats: reach poses {poses_named} once \
                 more and log their readings under the same `pose`, so that noise is known from \
                 repeats"
            ),
            Untold::Visits => format!(
                "Readings repeat within single visits alone, which do not tell what a posture that \
                 is reached again differs by: reach poses {poses_named} once more, leaving each in \
                 between, and log their readings under the same `pose`"
            ),
        };
        Some(Again { poses, sentence })
    }

    /// The same as a step to take.
    pub(crate) fn step(&self) -> NextStep {
        NextStep::Repeat {
            poses: self.poses.clone(),
        }
    }

    /// What no log gives, in a file that was read.
    pub(crate) fn invalid_reason(&self) -> Option<String> {
        let valid = self.poses.len() <= COUNT && self.sentence.len() < 1000;
        (!valid).then(|| "`again` that no log gives".to_string())
    }
}

/// `count` of the postures whose rows (two each) are spread widest, the widest first.
pub(crate) fn spread(rows: &DMatrix<f64>, count: usize) -> Vec<usize> {
    let mut left = rows.clone();
    let postures = rows.nrows() / 2;
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < count.min(postures) {
        let size = |k: &usize| left.row(2 * k).norm_squared() + left.row(2 * k + 1).norm_squared();
        let open = (0..postures).filter(|k| !chosen.contains(k));
        let Some(next) = open.max_by(|a, b| size(a).total_cmp(&size(b))) else {
            break;
        };
        chosen.push(next);
        for row in [2 * next, 2 * next + 1] {
            let direction: DVector<f64> = left.row(row).transpose();
            let length = direction.norm();
            if length <= 1e-12 * (1.0 + rows.amax()) {
                continue;
            }
            let direction = direction / length;
            let along = &left * &direction;
            left.ger(-1.0, &along, &direction, 1.0);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows along e₁, e₂, e₃ of sizes 3, 2, 1, and copies of the first that are shorter.
    #[test]
    fn the_next_posture_is_the_one_that_is_least_like_those_chosen() {
        let sizes = [(0, 2.9), (1, 2.0), (0, 3.0), (2, 1.0), (0, 2.5), (1, 1.9)];
        let rows = DMatrix::from_fn(12, 3, |row, column| {
            let (direction, size) = sizes[row / 2];
            let is_along = row % 2 == 0 && column == direction;
            if is_along { size } else { 0.0 }
        });
        assert_eq!(spread(&rows, 3), [2, 1, 3]);
        assert_eq!(spread(&rows, 9).len(), 6);
    }

    #[test]
    fn recordings_and_short_logs_are_asked_for_nothing() {
        let rows = DMatrix::from_fn(40, 3, |row, column| ((7 * row + column) as f64).sin());
        let poses: Vec<i64> = (100..120).collect();
        let slow: Vec<f64> = (0..20).map(|k| 3.0 * f64::from(k)).collect();
        let fast: Vec<f64> = (0..20).map(|k| 0.01 * f64::from(k)).collect();
        let asked = Again::among(Untold::Noise, &rows, &poses, None).unwrap();
        assert_eq!(asked.poses.len(), COUNT);
        assert!(asked.poses.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(asked.poses.iter().all(|pose| poses.contains(pose)));
        let again = Again::among(Untold::Noise, &rows, &poses, Some(&slow));
        assert_eq!(again, Some(asked));
        let again = Again::among(Untold::Noise, &rows, &poses, Some(&fast));
        assert_eq!(again, None);
        assert_eq!(Again::among(Untold::Noise, &rows, &poses[..9], None), None);
        let of_visits = Again::among(Untold::Visits, &rows, &poses, None).unwrap();
        assert!(of_visits.sentence.contains("leaving each in between"));
    }
}
