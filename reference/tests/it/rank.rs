//! Regressor columns by definition, and how many of them data can tell apart.

use crate::common::{bushy, bushy_on_sole, postures, robot};
use nalgebra::{DMatrix, DVector};
use sesc_reference::{Reference, Robot, numeric_rank};

const TOLERANCE: f64 = 1e-9;
const XYZ: &[usize] = &[0, 1, 2];
const XY: &[usize] = &[0, 1];

/// Ranks of the standard columns: CoM rows, flat CoP rows.
fn ranks(robot: &Robot, support: &str) -> (usize, usize) {
    let reference = Reference::new(robot, support).unwrap();
    let postures = postures(&reference, 60);
    let rank = |axes| numeric_rank(&reference.stacked_columns(&postures, axes), TOLERANCE);
    (rank(XYZ), rank(XY))
}

#[test]
fn columns_are_the_com_of_unit_parameters() {
    let (robot, reference, _) = bushy_on_sole();
    for q in postures(&reference, 10) {
        let columns = reference.standard_columns(&q);
        for k in 0..columns.ncols() {
            assert_eq!(columns.column(k), reference.column_by_definition(&q, k));
        }
        for (l, link) in robot.links().iter().enumerate() {
            let orientation = reference.body_orientation(&link.name, &q).unwrap();
            assert_eq!(columns.fixed_columns::<3>(4 * l + 1), *orientation.matrix());
        }
        let parameters = reference.standard_parameters();
        let com = reference.com(&q);
        assert!((&columns * &parameters - com).norm() < 1e-15);
        assert!((reference.com_of(&q, parameters.as_slice()) - com).norm() < 1e-15);
    }
}

#[test]
fn rank_is_three_and_two_per_revolute_and_one_per_prismatic_joint() {
    // Five revolute joints (one of them a mimic) and one prismatic joint.
    let robot = bushy();
    for link in robot.links() {
        let expected = 3 + 2 * 5 + 1;
        let found = ranks(&robot, &link.name);
        assert_eq!(found, (expected, expected - 1), "{}", link.name);
    }
}

#[test]
fn ranks_of_small_robots_are_counted_by_hand() {
    let of = |links: &str, joints: &str, support: &str| {
        ranks(&robot(&format!("{links}\n{joints}")), support)
    };
    // Massless links count as well.
    let links = "link a 1 0 0 0\n<link name='b'/><link name='c'/>";
    let y = "<axis xyz='0 1 0'/>";
    for (joints, expected) in [
        // Parallel axes are told apart.
        (
            format!("revolute j a b|xyz='0 0 1'|{y}\nrevolute k b c|xyz='0 0 1'|{y}"),
            (7, 6),
        ),
        // A parallelogram: the second joint undoes the first and adds nothing.
        (
            format!(
                "revolute j a b|xyz='0 0 1'|{y}\n\
                 revolute k b c|xyz='0 0 1'|{y}<mimic joint='j' multiplier='-1'/>"
            ),
            (5, 4),
        ),
        // A vertical prismatic joint is not observable on flat ground, a leaning one is.
        (
            format!("prismatic lift a b||<axis xyz='0 0 1'/>\nrevolute turn b c||{y}"),
            (6, 4),
        ),
        (
            format!("prismatic lift a b||<axis xyz='0.1 0 1'/>\nrevolute turn b c||{y}"),
            (6, 5),
        ),
        // Fingers that slide in step count once.
        (
            format!(
                "prismatic left a b||{y}\n\
                 prismatic right a c||<axis xyz='0 -1 0'/><mimic joint='left'/>"
            ),
            (4, 3),
        ),
    ] {
        assert_eq!(of(links, &joints, "a"), expected, "{joints}");
    }
    // Fixed joints add nothing; the support's own body gives the three constants.
    let rigid = "link a 1 0.1 0.2 0.3\nlink b 1 0.1 0.2 0.3";
    let weld = "fixed weld a b | xyz='1 2 3' rpy='1 2 3'";
    assert_eq!(of(rigid, weld, "b"), (3, 2));
}

/// The CoM functions of robots with the same joints and any positive masses
/// fill a space of the rank's dimension, although their fractions sum to one.
#[test]
fn the_sum_to_one_costs_no_dimension() {
    let (robot, reference, _) = bushy_on_sole();
    let postures = postures(&reference, 40);
    let rows = reference.stacked_columns(&postures, XYZ);
    let own = reference.standard_parameters();
    // Move each parameter of a link a little; fractions keep their sum of one.
    let mut functions = Vec::new();
    for k in 0..own.len() {
        let mut parameters: DVector<f64> = own.map(|p| p * 0.99);
        if k % 4 == 0 {
            parameters[k] += 0.01;
        } else {
            parameters[k] += 0.02;
            parameters[4 * robot.link_index("sole").unwrap()] += 0.01;
        }
        let sum: f64 = parameters.iter().step_by(4).sum();
        assert!((sum - 1.0).abs() < 1e-15);
        assert!(
            parameters
                .iter()
                .step_by(4)
                .all(|fraction| *fraction >= 0.0)
        );
        functions.push(&rows * parameters - &rows * &own);
    }
    let span = DMatrix::from_columns(&functions);
    assert_eq!(numeric_rank(&span, TOLERANCE), 14);
    assert_eq!(numeric_rank(&rows, TOLERANCE), 14);
}

#[test]
fn rank_of_plain_matrices() {
    assert_eq!(numeric_rank(&DMatrix::zeros(3, 2), TOLERANCE), 0);
    assert_eq!(numeric_rank(&DMatrix::zeros(0, 2), TOLERANCE), 0);
    assert_eq!(numeric_rank(&DMatrix::identity(3, 5), TOLERANCE), 3);
    let close = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0 + 1e-6]);
    assert_eq!(numeric_rank(&close, TOLERANCE), 2);
    assert_eq!(numeric_rank(&close, 1e-5), 1);
}
