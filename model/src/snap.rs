//! Right angles that a URDF writes as decimals.
//!
//! Files say 1.5708 for π/2. Taken literally such an angle is a generic
//! rotation and costs multiplications; taken as the quarter turn it was meant
//! to be, it is a permutation. Each of roll, pitch and yaw within
//! [`Snapping::Within`] of k·π/2 becomes exact; the change is recorded.
//! A decimal right angle that is further off (3.14, 1.57) is left as written
//! and reported.

use nalgebra::{Matrix3, Vector3};

/// Below this, entries of products of rotations are rounding noise and are
/// set to the exact 0 or ±1 they stand for (a few ulp of 1).
const ROUNDING: f64 = 1e-15;

/// An angle this close to a non-zero quarter turn was probably meant to be
/// one, and is worth a note when it is too far off to be snapped.
const NEARLY: f64 = 1e-2;

/// Whether decimals of right angles are made exact.
///
/// ```
/// use sesc_model::Snapping;
///
/// // 1.5708 is 4e-6 rad off a quarter turn, and is one.
/// assert_eq!(Snapping::default(), Snapping::Within(1e-5));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Snapping {
    /// Snap angles within this many radians of a quarter turn.
    Within(f64),
    /// Take every number literally.
    Off,
}

impl Default for Snapping {
    fn default() -> Self {
        Snapping::Within(1e-5)
    }
}

/// A rotation or direction, with what snapping did to it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Snapped<T> {
    pub value: T,
    /// Angle between the written and the exact value, rad; 0 if untouched.
    pub error: f64,
    /// Distance to the quarter turn it was not snapped to, rad.
    pub nearly: Option<f64>,
}

/// Sine and cosine of `angle`, exact when it is snapped to a quarter turn.
fn sin_cos(angle: f64, snapping: Snapping) -> (Snapped<(f64, f64)>, bool) {
    let quarters = libm::rint(angle / std::f64::consts::FRAC_PI_2);
    let off = libm::fabs(angle - quarters * std::f64::consts::FRAC_PI_2);
    let exact = matches!(snapping, Snapping::Within(tolerance) if off <= tolerance);
    if exact {
        let value = match (quarters as i64).rem_euclid(4) {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        };
        let snapped = Snapped {
            value,
            error: off,
            nearly: None,
        };
        return (snapped, true);
    }
    let nearly = (quarters != 0.0 && off <= NEARLY).then_some(off);
    let snapped = Snapped {
        value: libm::sincos(angle),
        error: 0.0,
        nearly,
    };
    (snapped, false)
}

/// URDF rotation: roll about x, then pitch about y, then yaw about z, fixed axes.
pub(crate) fn rotation(rpy: [f64; 3], snapping: Snapping) -> Snapped<Matrix3<f64>> {
    let angles = rpy.map(|angle| sin_cos(angle, snapping).0);
    let [(sr, cr), (sp, cp), (sy, cy)] = angles.map(|a| a.value);
    let matrix = Matrix3::new(
        cy * cp,
        cy * sp * sr - sy * cr,
        cy * sp * cr + sy * sr,
        sy * cp,
        sy * sp * sr + cy * cr,
        sy * sp * cr - cy * sr,
        -sp,
        cp * sr,
        cp * cr,
    );
    Snapped {
        value: matrix.map(tidy),
        error: angles.iter().map(|a| a.error).sum(),
        nearly: angles.iter().filter_map(|a| a.nearly).reduce(f64::max),
    }
}

/// Unit vector along a joint axis.
pub(crate) fn direction(axis: Vector3<f64>, snapping: Snapping) -> Snapped<Vector3<f64>> {
    // Scaled first, so that neither 1e-200 nor 1e200 under- or overflows.
    let unit = (axis / axis.amax()).normalize();
    let largest = unit.iamax();
    let mut exact = Vector3::zeros();
    exact[largest] = unit[largest].signum();
    let off = (unit - exact).norm();
    match snapping {
        Snapping::Within(tolerance) if off <= tolerance => Snapped {
            value: exact,
            error: off,
            nearly: None,
        },
        _ => Snapped {
            value: unit.map(tidy),
            error: 0.0,
            nearly: None,
        },
    }
}

/// Rotation by `angle` about the unit vector `axis` (Rodrigues).
pub(crate) fn about(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(angle);
    let k = axis.cross_matrix();
    (Matrix3::identity() + k * s + k * k * (1.0 - c)).map(tidy)
}

/// The coordinate axis that the unit vector `axis` lies on, exactly.
pub(crate) fn aligned(axis: &Vector3<f64>) -> Option<usize> {
    let zeros = axis.iter().filter(|x| **x == 0.0).count();
    (zeros == 2).then(|| axis.iamax())
}

/// Whole quarter turns (0 to 3) and the rest, at most an eighth of a turn.
pub(crate) fn quarters(angle: f64) -> (i64, f64) {
    let quarter = std::f64::consts::FRAC_PI_2;
    let whole = libm::rint(angle / quarter);
    let rest = angle - whole * quarter;
    let rest = if libm::fabs(rest) < 1e-15 { 0.0 } else { rest };
    ((whole as i64).rem_euclid(4), rest)
}

/// Entries within rounding of 0 or ±1 become exact.
pub(crate) fn tidy(x: f64) -> f64 {
    if libm::fabs(x) < ROUNDING {
        0.0
    } else if libm::fabs(libm::fabs(x) - 1.0) < ROUNDING {
        x.signum()
    } else {
        x
    }
}

#[cfg(test)]
#[allow(clippy::approx_constant)] // decimals of right angles are the point
mod tests {
    use super::*;

    #[test]
    fn decimals_of_right_angles_become_exact() {
        let snapped = rotation([1.5708, 0.0, -1.5708], Snapping::default());
        let exact = Matrix3::new(0., 0., -1., -1., 0., 0., 0., 1., 0.);
        assert_eq!(snapped.value, exact);
        assert!((snapped.error - 2.0 * 3.673205103e-6).abs() < 1e-14);
    }

    #[test]
    fn a_sloppy_half_turn_is_reported_and_left_alone() {
        let near = rotation([0.0, 0.0, 3.14], Snapping::default());
        assert_eq!(near.error, 0.0);
        assert!((near.nearly.unwrap() - 1.5926535897931e-3).abs() < 1e-12);
        assert!((near.value[(1, 0)] - 1.5926529164868282e-3).abs() < 1e-15);
    }

    #[test]
    fn off_takes_numbers_literally() {
        let literal = rotation([1.5708, 0.0, 0.0], Snapping::Off);
        assert_eq!(literal.value[(1, 1)], libm::cos(1.5708));
        assert_eq!(literal.error, 0.0);
    }

    #[test]
    fn tiny_and_huge_axes_have_a_direction() {
        for scale in [1e-200, 1e200] {
            let axis = Vector3::new(3.0 * scale, 0.0, -4.0 * scale);
            let unit = direction(axis, Snapping::Off).value;
            assert!((unit - Vector3::new(0.6, 0.0, -0.8)).norm() < 1e-15);
        }
    }
}
