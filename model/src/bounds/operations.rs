//! Quotients, clamps, powers and maxima, which only effects need.
//!
//! ```text
//! |â/b̂ − a/b| ≤ (E(a) + |a/b| E(b)) / (min|b| − E(b))
//! |â^b̂ − a^b| ≤ sup |b a^(b−1)| E(a) + sup |ln a| a^b E(b)
//! ```
//!
//! with suprema over all that operands may be computed as. Where a base reaches
//! zero under a root, whose slope has no bound, the root's own continuity serves:
//! `|â^b − a^b| ≤ E(a)^b` for 0 < b ≤ 1. No bound, and no enclosure, is what comes
//! of a divisor that may be zero and of a base that may be negative.

use super::range::{Range, times};

/// Error of the power kernel, in ulp (runtime::power).
const POWER_ULPS: f64 = 1.0;

/// Nothing is known.
pub(super) const UNBOUNDED: Range = Range::new(f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY);

/// Enclosure of `a / b` and the error that operands carry into it.
pub(super) fn quotient(a: Range, b: Range) -> Option<Range> {
    let least = libm::fabs(b.lower).min(libm::fabs(b.upper)) - b.error;
    let apart = (b.lower > 0.0 || b.upper < 0.0) && least > 0.0;
    if !(apart && a.is_bounded() && b.is_bounded()) {
        return None;
    }
    let (lower, upper) = ends([
        a.lower / b.lower,
        a.lower / b.upper,
        a.upper / b.lower,
        a.upper / b.upper,
    ]);
    let error = (a.error + largest([lower, upper]) * b.error) / least;
    Some(Range::new(lower, upper, error))
}

/// The number in [-1, 1] nearest to `a`: no error grows, none exceeds the width.
pub(super) fn clamped(a: Range) -> Range {
    // What has no bound may be NaN, and stays so.
    if !a.error.is_finite() {
        return UNBOUNDED;
    }
    let [lower, upper] = [a.lower, a.upper].map(|end| end.clamp(-1.0, 1.0));
    Range::new(lower, upper, a.error.min(2.0))
}

/// The larger of `a` and `b`: it moves by no more than either.
pub(super) fn larger(a: Range, b: Range) -> Range {
    Range {
        lower: a.lower.max(b.lower),
        upper: a.upper.max(b.upper),
        // One that is never chosen brings no error along.
        error: match (a.lower - a.error - b.error, b.lower - a.error - b.error) {
            (least, _) if least > b.upper => a.error,
            (_, least) if least > a.upper => b.error,
            _ if a.is_bounded() && b.is_bounded() => a.error.max(b.error),
            _ => f64::INFINITY,
        },
    }
}

/// Enclosure of `a` to the power of `b`, and its error with the kernel's in
/// arithmetic of unit roundoff `unit`. The base is computed by operations that cannot round below
/// `floor`, which is zero or more, if there is such a number.
pub(super) fn power(a: Range, b: Range, floor: Option<f64>, unit: f64) -> Option<Range> {
    let computable = floor.is_some() || a.lower - a.error >= 0.0;
    if !(computable && a.lower >= 0.0 && a.is_bounded() && b.is_bounded()) {
        return None;
    }
    let (lower, upper) = ends(corners([a.lower, a.upper], [b.lower, b.upper]));
    // All that operands are and may be computed as.
    let base = [
        (a.lower - a.error).max(floor.unwrap_or(0.0)),
        a.upper + a.error,
    ];
    let exponent = [b.lower - b.error, b.upper + b.error];
    let by_base = match a.error {
        0.0 => 0.0,
        error => times(slope(base, exponent), error).min(root(base, exponent, error)),
    };
    let by_exponent = match b.error {
        0.0 => 0.0,
        error => times(bend(base, exponent), error),
    };
    let carried = by_base + by_exponent;
    // An ulp is at most twice the unit roundoff of its number.
    let own = 2.0 * POWER_ULPS * unit * (upper + carried);
    let found = Range::new(lower, upper, carried + own);
    found.is_bounded().then_some(found)
}

/// a^b at the corners of a box: it is monotone in each, so ends are among them.
fn corners(a: [f64; 2], b: [f64; 2]) -> [f64; 4] {
    [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| libm::pow(a[i], b[j]))
}

/// Least and largest of these.
pub(super) fn ends(values: [f64; 4]) -> (f64, f64) {
    let lower = values.iter().copied().fold(f64::INFINITY, f64::min);
    let upper = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (lower, upper)
}

fn largest(ends: [f64; 2]) -> f64 {
    libm::fabs(ends[0]).max(libm::fabs(ends[1]))
}

/// sup |b a^(b−1)|.
fn slope(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (_, steepest) = ends(corners(a, b.map(|b| b - 1.0)));
    times(largest(b), steepest)
}

/// Bound on |â^b − a^b| for |â − a| ≤ `error` and b > 0, without the slope at zero.
fn root(a: [f64; 2], b: [f64; 2], error: f64) -> f64 {
    if b[0] <= 0.0 {
        return f64::INFINITY;
    }
    // Exponents up to one by continuity, those beyond by their slope.
    let below = match b[0] < 1.0 {
        true => libm::pow(error, b[0]).max(libm::pow(error, b[1].min(1.0))),
        false => 0.0,
    };
    let beyond = match b[1] > 1.0 {
        true => slope(a, [b[0].max(1.0), b[1]]) * error,
        false => 0.0,
    };
    below.max(beyond)
}

/// sup |ln a| a^b: at a corner, or inside at most 1/(e |b|).
fn bend(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (_, highest) = ends(corners(a, b));
    let widest = times(largest(a.map(libm::log)), highest);
    if b[0] <= 0.0 {
        return widest;
    }
    let at_top = libm::fabs(libm::log(a[1])) * libm::pow(a[1], b[0]).max(libm::pow(a[1], b[1]));
    let inside = 1.0 / (core::f64::consts::E * b[0]);
    widest.min(at_top.max(inside))
}

#[cfg(test)]
mod tests {
    use super::*;

    const U: f64 = 1.1102230246251565e-16;

    fn range(lower: f64, upper: f64, error: f64) -> Range {
        Range::new(lower, upper, error)
    }

    #[test]
    fn a_divisor_must_stay_away_from_zero() {
        let a = range(-1.0, 3.0, 1e-10);
        let found = quotient(a, range(2.0, 4.0, 1e-9)).unwrap();
        assert_eq!((found.lower, found.upper), (-0.5, 1.5));
        assert!(found.error >= (1e-10 + 1.5e-9) / 2.0 && found.error < 1e-9);
        for b in [
            range(0.0, 1.0, 0.0),
            range(-1.0, 1.0, 0.0),
            range(1e-9, 1.0, 1e-9),
            range(1.0, f64::INFINITY, 0.0),
            range(1.0, 2.0, f64::INFINITY),
        ] {
            assert!(quotient(a, b).is_none(), "{b:?}");
        }
        assert!(quotient(UNBOUNDED, range(1.0, 2.0, 0.0)).is_none());
    }

    #[test]
    fn a_clamp_hides_what_is_large_but_not_what_has_no_bound() {
        let found = clamped(range(-7.0, 0.5, 300.0));
        assert_eq!((found.lower, found.upper, found.error), (-1.0, 0.5, 2.0));
        assert_eq!(clamped(range(0.0, 0.5, 1e-9)).error, 1e-9);
        assert!(clamped(UNBOUNDED).error.is_infinite());
        assert!(clamped(range(0.0, 1.0, f64::NAN)).error.is_infinite());
    }

    /// Every base, exponent and error against a walk through them.
    #[test]
    fn powers_err_by_no_more_than_their_bound() {
        for (a, b) in [
            (range(0.5, 3.0, 1e-3), range(0.9, 1.1, 0.0)),
            (range(0.0, 3.0, 1e-3), range(0.4, 0.9, 1e-4)),
            (range(0.0, 2.0, 1e-3), range(0.7, 1.6, 1e-3)),
            (range(0.0, 0.3, 1e-2), range(1.5, 2.5, 0.0)),
            (range(0.2, 0.4, 1e-3), range(-2.0, -0.5, 1e-3)),
            (range(0.2, 5.0, 0.0), range(-1.0, 2.0, 1e-2)),
        ] {
            let found = power(a, b, Some(0.0), U).unwrap();
            let walk = |r: Range| {
                (0..=40).map(move |k| r.lower + (r.upper - r.lower) * f64::from(k) / 40.0)
            };
            let mut worst: f64 = 0.0;
            for (x, y) in walk(a).flat_map(|x| walk(b).map(move |y| (x, y))) {
                let exact = libm::pow(x, y);
                assert!(exact >= found.lower - 1e-15 && exact <= found.upper + 1e-15);
                for (dx, dy) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    let x = (x + dx * a.error).max(0.0);
                    worst = worst.max(libm::fabs(libm::pow(x, y + dy * b.error) - exact));
                }
            }
            let tight = worst <= found.error && found.error <= 20.0 * worst;
            assert!(tight, "{a:?} {b:?}: {worst:e} {:e}", found.error);
        }
    }

    #[test]
    fn powers_without_a_bound_have_none() {
        let near_one = range(0.9, 1.1, 0.0);
        assert!(power(range(-1e-9, 1.0, 0.0), near_one, Some(0.0), U).is_none());
        assert!(power(range(0.0, 1.0, 1e-9), near_one, None, U).is_none());
        assert!(power(range(0.0, 1.0, 1e-9), near_one, Some(0.0), U).is_some());
        assert!(power(range(0.0, 1.0, 0.0), range(-1.0, 1.0, 0.0), Some(0.0), U).is_none());
        assert!(power(UNBOUNDED, near_one, Some(0.0), U).is_none());
    }
}
