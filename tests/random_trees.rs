//! Hundreds of random trees: every joint type, skewed axes, mimics, massless
//! links, deep chains, bushy hands, any support. The symbolic path against the
//! reference, and the closed-form counts against what comes out.

mod common;

use common::{Kind, tree};
use sesc::inspect::numeric_rank;
use sesc::robot::Robot;
use sesc::verify::verify;
use sesc_codegen::tree::Motion;
use sesc_codegen::{Function, Given, Model, Snapping};

fn model(seed: u64, kind: Kind, snapping: Snapping) -> (Robot, Model, String) {
    let (text, links) = tree(seed, kind);
    let robot = Robot::parse(&text, &format!("random-{seed}.urdf")).unwrap();
    let support = links[(seed as usize * 7) % links.len()].clone();
    let model = robot.model(&support, snapping, None).unwrap();
    (robot, model, support)
}

/// Shapes from a single joint to a hundred, chains to bushes.
fn mixed(seed: u64) -> Kind {
    Kind {
        joints: [1, 2, 3, 5, 8, 13, 21, 40][seed as usize % 8],
        canonical: false,
        revolute: false,
        chained: [1.0, 0.8, 0.3, 0.0][(seed / 8) as usize % 4],
    }
}

#[test]
fn every_function_agrees_with_the_reference() {
    for seed in 0..320 {
        let snapping = if seed % 2 == 0 {
            Snapping::Off
        } else {
            Snapping::default()
        };
        let (robot, model, support) = model(seed, mixed(seed), snapping);
        let reference = robot.reference(&support).unwrap();
        let found = verify(&model, &reference, 12, seed, |_, _| {});
        assert!(found.pass, "seed {seed} on {support}: {found:#?}");
    }
}

/// The proven bound is a bound of rounding, not of a mistake: it stays tiny.
#[test]
fn without_snapping_com_agrees_to_a_picometre() {
    for seed in (0..320).step_by(2) {
        let (robot, model, support) = model(seed, mixed(seed), Snapping::Off);
        let reference = robot.reference(&support).unwrap();
        let found = verify(&model, &reference, 12, seed, |_, _| {});
        assert!(found.worst_error["com"] < 1e-12, "seed {seed}: {found:#?}");
    }
}

#[test]
fn numeric_ranks_confirm_the_symbolic_count() {
    for seed in 0..160 {
        let (_, model, support) = model(seed, mixed(seed), Snapping::default());
        let rank = numeric_rank(&model);
        assert_eq!(
            rank.xyz,
            model.base.params.len(),
            "seed {seed} on {support}"
        );
        assert_eq!(rank.cop, model.base.rank_cop, "seed {seed} on {support}");
    }
}

/// 3 + 2 per turning joint + 1 per slide, whenever no angles are tied.
#[test]
fn independent_joints_follow_the_closed_form() {
    let mut checked = 0;
    for seed in 0..160 {
        let (_, model, _) = model(seed, mixed(seed), Snapping::default());
        let motions: Vec<_> = model.chain.bodies.iter().map(|b| b.motion).collect();
        let turns = motions
            .iter()
            .filter(|m| matches!(m, Motion::Turn { .. }))
            .count();
        let slides = motions
            .iter()
            .filter(|m| matches!(m, Motion::Slide { .. }))
            .count();
        let mut users = vec![0; model.dof()];
        for motion in &motions {
            if let Motion::Turn { by, .. } | Motion::Slide { by, .. } = motion {
                users[by.dof] += 1;
            }
        }
        if users.iter().all(|n| *n <= 1) {
            assert_eq!(
                model.base.params.len(),
                3 + 2 * turns + slides,
                "seed {seed}"
            );
            checked += 1;
        }
    }
    assert!(checked > 20, "only {checked} trees had independent joints");
}

#[test]
fn canonical_trees_cost_four_multiplications_a_joint() {
    for seed in 0..100 {
        let kind = Kind {
            joints: 1 + (seed as usize * 5) % 60,
            canonical: true,
            revolute: true,
            chained: [1.0, 0.7, 0.2][seed as usize % 3],
        };
        let (_, model, _) = model(seed, kind, Snapping::default());
        let counts = model
            .program(Function::Com, Given::Positions)
            .unwrap()
            .counts();
        let n = model.dof();
        assert!(
            counts.mul <= 4 * n,
            "seed {seed}: {counts:?} for {n} joints"
        );
        assert!(
            counts.add <= 5 * n,
            "seed {seed}: {counts:?} for {n} joints"
        );
        let rows = model
            .program(Function::RegressorCop, Given::Positions)
            .unwrap()
            .counts();
        assert!(rows.mul <= 8 * n, "seed {seed}: {rows:?} for {n} joints");
    }
}

#[test]
fn skewed_twists_cost_at_most_four_more() {
    for seed in 0..100 {
        let kind = Kind {
            joints: 1 + (seed as usize * 5) % 60,
            canonical: false,
            revolute: true,
            chained: [1.0, 0.7, 0.2, 0.0][seed as usize % 4],
        };
        let (_, model, _) = model(seed, kind, Snapping::default());
        let counts = model
            .program(Function::Com, Given::Positions)
            .unwrap()
            .counts();
        assert!(counts.mul <= 8 * model.dof(), "seed {seed}: {counts:?}");
    }
}

/// Five hundred joints in one chain: nothing overflows, nothing is lost.
#[test]
fn a_chain_of_five_hundred_joints_agrees() {
    let kind = Kind {
        joints: 500,
        canonical: false,
        revolute: true,
        chained: 1.0,
    };
    let (robot, model, support) = model(3, kind, Snapping::Off);
    let reference = robot.reference(&support).unwrap();
    let found = verify(&model, &reference, 1, 3, |_, _| {});
    assert!(found.pass, "{found:#?}");
}
