//! Roll, pitch, yaw of a unit quaternion, exact to rounding in every attitude.
//!
//! With `R = Rz(yaw) Ry(pitch) Rx(roll)` the half angles give
//!
//! ```text
//! w + y = (cos p/2 + sin p/2) cos (r-y)/2     x - z = (cos p/2 + sin p/2) sin (r-y)/2
//! w - y = (cos p/2 - sin p/2) cos (r+y)/2     x + z = (cos p/2 - sin p/2) sin (r+y)/2
//! ```
//!
//! so sum and difference of roll and yaw come from two `atan2`, the pitch from
//! the two lengths. Upright (pitch = ±90°) one pair vanishes and its angle is
//! free; no case needs a threshold. A scale of the quaternion cancels.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// None if the quaternion is zero.
pub(super) fn rpy_of_quaternion(quaternion: [f64; 4]) -> Option<[f64; 3]> {
    let largest = quaternion.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    if largest == 0.0 {
        return None;
    }
    // Keeps the sums below from overflowing.
    let [x, y, z, w] = quaternion.map(|v| v / largest);
    let pitch = 2.0 * libm::atan2(libm::hypot(w + y, x - z), libm::hypot(w - y, x + z)) - FRAC_PI_2;
    let half_sum = libm::atan2(x + z, w - y);
    let half_difference = libm::atan2(x - z, w + y);
    Some([
        wrapped(half_sum + half_difference),
        pitch,
        wrapped(half_sum - half_difference),
    ])
}

fn wrapped(angle: f64) -> f64 {
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Matrix = [[f64; 3]; 3];

    fn matrix_of_quaternion([x, y, z, w]: [f64; 4]) -> Matrix {
        let n = x * x + y * y + z * z + w * w;
        let s = 2.0 / n;
        [
            [
                1.0 - s * (y * y + z * z),
                s * (x * y - z * w),
                s * (x * z + y * w),
            ],
            [
                s * (x * y + z * w),
                1.0 - s * (x * x + z * z),
                s * (y * z - x * w),
            ],
            [
                s * (x * z - y * w),
                s * (y * z + x * w),
                1.0 - s * (x * x + y * y),
            ],
        ]
    }

    fn matrix_of_rpy([r, p, y]: [f64; 3]) -> Matrix {
        let ((sr, cr), (sp, cp), (sy, cy)) = (r.sin_cos(), p.sin_cos(), y.sin_cos());
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    }

    fn worst(quaternion: [f64; 4]) -> f64 {
        let rpy = rpy_of_quaternion(quaternion).expect("not zero");
        let (a, b) = (matrix_of_quaternion(quaternion), matrix_of_rpy(rpy));
        let entries = a.iter().flatten().zip(b.iter().flatten());
        entries.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
    }

    #[test]
    fn quarter_turns_are_exact() {
        let h = std::f64::consts::FRAC_1_SQRT_2;
        for axis in 0..3 {
            let (mut quaternion, mut rpy) = ([0.0, 0.0, 0.0, h], [0.0; 3]);
            (quaternion[axis], rpy[axis]) = (h, FRAC_PI_2);
            assert_eq!(rpy_of_quaternion(quaternion), Some(rpy));
        }
        assert_eq!(rpy_of_quaternion([0.0, 0.0, 0.0, 1.0]), Some([0.0; 3]));
        assert_eq!(rpy_of_quaternion([0.0; 4]), None);
    }

    /// Both sides round a handful of products of numbers up to 1.
    const TOLERANCE: f64 = 2e-15;

    #[test]
    fn rotation_survives_in_every_attitude() {
        let mut state = 7u64;
        let mut draw = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        for _ in 0..20_000 {
            let q = [draw(), draw(), draw(), draw()];
            assert!(worst(q) < TOLERANCE, "{q:?}");
            // Upright, and ever closer to it.
            let [roll, yaw] = [draw(), draw()];
            for off in [0.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-16] {
                let half = (FRAC_PI_2 - off) / 2.0;
                let ((sr, cr), (sp, cp), (sy, cy)) =
                    (roll.sin_cos(), half.sin_cos(), yaw.sin_cos());
                let q = [
                    sr * cp * cy - cr * sp * sy,
                    cr * sp * cy + sr * cp * sy,
                    cr * cp * sy - sr * sp * cy,
                    cr * cp * cy + sr * sp * sy,
                ];
                assert!(worst(q) < TOLERANCE, "{q:?}");
                assert!(worst(q.map(|v| -v * 1e3)) < TOLERANCE, "{q:?}");
            }
        }
        assert!(worst([3e307, -1e308, 9e307, 1.7e308].map(|v| v * 1e-160)) < TOLERANCE);
    }
}
