//! A double pendulum, worked out by hand.
//!
//! Both joints turn about y, which carries z to (sin, 0, cos). With heights
//! measured from the stand, `s1 = sin q1`, `s12 = sin (q1 + q2)` and so on:
//!
//! ```text
//! M x = m0 x0 + m1 c1 s1 + m2 (l s1 + c2 s12)
//! M z = m0 z0 + m1 (h + c1 cos1) + m2 (h + l cos1 + c2 cos12)
//! ```

use crate::common::{postures, robot};
use nalgebra::{Matrix3x2, Vector3};
use sesc_reference::{Reference, Robot};

const HEIGHT: f64 = 0.9;
const LENGTH: f64 = 0.45;
const MASSES: [f64; 3] = [1.5, 0.8, 0.35];
const STAND: [f64; 3] = [0.03, 0.02, 0.4];
const C1: f64 = 0.21;
const C2: f64 = 0.17;

fn pendulum() -> Robot {
    let ([m0, m1, m2], [x, y, z]) = (MASSES, STAND);
    robot(&format!(
        "link stand {m0} {x} {y} {z}
         link upper {m1} 0 0 {C1}
         link lower {m2} 0 0 {C2}
         continuous first stand upper | xyz='0 0 {HEIGHT}' | <axis xyz='0 1 0'/>
         continuous second upper lower | xyz='0 0 {LENGTH}' | <axis xyz='0 1 0'/>"
    ))
}

/// CoM and its Jacobian by the formulas above.
fn by_hand(q: &[f64]) -> (Vector3<f64>, Matrix3x2<f64>) {
    let [m0, m1, m2] = MASSES;
    let total = m0 + m1 + m2;
    let (s1, c1) = q[0].sin_cos();
    let (s12, c12) = (q[0] + q[1]).sin_cos();
    let first = (m1 * C1 + m2 * LENGTH) / total;
    let second = m2 * C2 / total;
    let com = Vector3::new(
        m0 * STAND[0] / total + first * s1 + second * s12,
        m0 * STAND[1] / total,
        (m0 * STAND[2] + (m1 + m2) * HEIGHT) / total + first * c1 + second * c12,
    );
    let jacobian = Matrix3x2::new(
        first * c1 + second * c12,
        second * c12,
        0.0,
        0.0,
        -first * s1 - second * s12,
        -second * s12,
    );
    (com, jacobian)
}

#[test]
fn com_jacobian_and_moments_are_the_closed_forms() {
    let reference = Reference::new(&pendulum(), "stand").unwrap();
    assert_eq!(reference.joint_names(), ["first", "second"]);
    assert!((reference.total_mass() - MASSES.iter().sum::<f64>()).abs() < 1e-15);
    for q in postures(&reference, 200) {
        let (com, jacobian) = by_hand(&q);
        let error = reference.com(&q) - com;
        assert!(error.norm() < 1e-15, "{q:?}: {error}");
        let error = reference.com_jacobian(&q) - jacobian;
        assert!(error.norm() < 1e-12, "{q:?}: {error}");
        let moments = reference.gravity_moments(&q);
        for j in 0..2 {
            assert!((moments[j] + jacobian[(2, j)]).abs() < 1e-12, "{q:?}");
        }
    }
    // Leaning forward, both joints are driven further forward.
    let moments = reference.gravity_moments(&[0.2, 0.1]);
    assert!(moments[0] > 0.0 && moments[1] > 0.0);
}

#[test]
fn standing_on_the_far_end_turns_everything_back() {
    let robot = pendulum();
    let stand = Reference::new(&robot, "stand").unwrap();
    let lower = Reference::new(&robot, "lower").unwrap();
    for q in postures(&stand, 50) {
        // From the lower link: back along its own tilt, from its own origin.
        let com = by_hand(&q).0;
        let (s1, c1) = q[0].sin_cos();
        let (s12, c12) = (q[0] + q[1]).sin_cos();
        let (dx, dz) = (com.x - LENGTH * s1, com.z - HEIGHT - LENGTH * c1);
        let expected = Vector3::new(c12 * dx - s12 * dz, com.y, s12 * dx + c12 * dz);
        assert!((lower.com(&q) - expected).norm() < 1e-15);
    }
}
