//! Whether the data of a robot changed where its explanation did.
//!
//! An explanation is chosen among many, and another one is chosen on another day by chance. What
//! is fitted without effects is no choice: an effect that comes moves base parameters, or leaves
//! a gap that they do not follow.
//!
//! ```text
//! parameters   max_k |θ̄_k,after − θ̄_k,before| / √(var + var)  against Student's law, times n
//! gap          Σν e²/Σν after over before   against Fisher's law, to both sides
//! ```

use statrs::distribution::{ContinuousCDF as _, FisherSnedecor, StudentsT};

use super::course::{freedom, means};
use super::criteria::changes::BORNE_OUT;
use crate::fleet::row::{Row, Size, by_number};

/// Whether days from `first` on differ from those before in what is fitted without effects.
/// Deviations are as fits say: how days scatter is not known of a fleet of which most changed.
pub(super) fn is_borne_out(rows: &[&Row], first: &str) -> bool {
    let is_before = |row: &&&Row| by_number(&row.day, first).is_lt();
    let before: Vec<&Row> = rows.iter().filter(is_before).copied().collect();
    let after: Vec<&Row> = rows.iter().filter(|row| !is_before(row)).copied().collect();
    let least = chance_of_parameters(&before, &after).min(chance_of_gaps(&before, &after));
    // Of two kinds of numbers.
    2.0 * least < BORNE_OUT
}

/// A parameter of a row with its widened deviation.
pub(super) fn size(row: &Row, k: usize, widening: &[f64]) -> Option<Size> {
    let (value, std) = (*row.params.get(k)?, (*row.std.get(k)?)?);
    let wide = widening.get(k).copied().unwrap_or(1.0);
    (std > 0.0).then_some(Size {
        value,
        std: wide * std,
    })
}

/// The chance that base parameters differ so much where none changed.
fn chance_of_parameters(before: &[&Row], after: &[&Row]) -> f64 {
    let count = before.iter().chain(after).map(|row| row.params.len()).max();
    let count = count.unwrap_or(0);
    let mean = |rows: &[&Row], k: usize| {
        let sizes: Vec<Size> = rows.iter().filter_map(|row| size(row, k, &[])).collect();
        means(sizes.iter()).pop()
    };
    let gap = |k: usize| {
        let (one, other) = (mean(before, k)?, mean(after, k)?);
        Some((one.value - other.value).abs() / one.std.hypot(other.std))
    };
    let largest = (0..count).filter_map(gap).fold(0.0, f64::max);
    let free = freedom(before) + freedom(after);
    let law = StudentsT::new(0.0, 1.0, free);
    law.map_or(1.0, |law| count as f64 * 2.0 * law.sf(largest))
}

/// The chance that held-out gaps differ so much where nothing changed.
fn chance_of_gaps(before: &[&Row], after: &[&Row]) -> f64 {
    let pooled = |rows: &[&Row]| {
        let known = rows
            .iter()
            .filter_map(|row| Some((*row, row.held_out_rmse?)));
        let (mut squares, mut free) = (0.0, 0.0);
        for (row, rmse) in known {
            let own = freedom(&[row]);
            squares += own * rmse * rmse;
            free += own;
        }
        (free > 0.0).then_some((squares / free, free))
    };
    let (Some((one, free_one)), Some((other, free_other))) = (pooled(before), pooled(after)) else {
        return 1.0;
    };
    let (larger, smaller) = match one > other {
        true => ((one, free_one), (other, free_other)),
        false => ((other, free_other), (one, free_one)),
    };
    if smaller.0 <= 0.0 {
        return if larger.0 > 0.0 { 0.0 } else { 1.0 };
    }
    let law = FisherSnedecor::new(larger.1, smaller.1);
    law.map_or(1.0, |law| 2.0 * law.sf(larger.0 / smaller.0))
}
