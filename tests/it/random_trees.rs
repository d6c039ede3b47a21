//! Hundreds of random trees: every joint type, skewed axes, mimics, massless
//! links, deep chains, bushy hands, any support. The symbolic path against the
//! reference, and the closed-form counts against what comes out.

use std::path::{Path, PathBuf};

use sesc::inspect::{RankCheck, numeric_rank};
use sesc::verify::verify;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::program::Counts;
use sesc_model::tree::Motion;
use sesc_model::{Function, Given, Model, Snapping};
use sesc_test_support::trees::{Kind, Urdf, stripped, tree};

fn model(seed: u64, kind: Kind, snapping: Snapping) -> (Robot, Model, String) {
    let (text, links) = tree(seed, kind);
    let robot = Robot::parse(&text, &format!("random-{seed}.urdf")).unwrap();
    let support = links[(seed as usize * 7) % links.len()].clone();
    let model = robot.model(&support, snapping, None).unwrap();
    (robot, model, support)
}

fn counts(model: &Model, function: Function) -> Counts {
    model.program(function, Given::Positions).unwrap().counts()
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

/// `verify` covers the variants from sines and cosines where there are any: a
/// mimic that ties a prismatic joint to a revolute one, or halves an angle, leaves none.
/// Without snapping the proven bound is one of rounding, not of a mistake: it stays tiny.
#[test]
fn every_function_agrees_with_the_reference_from_angles_and_from_sines() {
    let mut from_sines = 0;
    for seed in 0..320 {
        let snapping = [Snapping::Off, Snapping::default()][seed as usize % 2];
        let (robot, model, support) = model(seed, mixed(seed), snapping);
        let found = verify(&robot, &model, 12, seed, &mut ()).unwrap();
        assert!(found.pass, "seed {seed} on {support}: {found:#?}");
        let picometre = seed % 2 == 1 || found.worst_error["com"] < 1e-12;
        assert!(picometre, "seed {seed}: {found:#?}");
        from_sines += usize::from(found.worst_error.contains_key("com_sc"));
    }
    let some = (100..300).contains(&from_sines);
    assert!(some, "{from_sines} of 320 trees");
}

/// Ranks by numbers are the symbolic counts: 3 + 2 per revolute joint + 1 per prismatic one,
/// whenever no angles are tied.
#[test]
fn numeric_ranks_and_the_closed_form_confirm_the_symbolic_count() {
    let mut checked = 0;
    for seed in 0..160 {
        let (_, model, support) = model(seed, mixed(seed), Snapping::default());
        let (rank, check) = numeric_rank(&model);
        assert_eq!(check, RankCheck::Agrees, "seed {seed} on {support}");
        let count = model.base.params.len();
        assert_eq!(rank.xyz, count, "seed {seed} on {support}");
        assert_eq!(rank.cop, model.base.rank_cop, "seed {seed} on {support}");
        let (mut expected, mut users) = (3, vec![0; model.dof()]);
        for body in &model.chain.bodies {
            let (by, own) = match &body.motion {
                Motion::Revolute { by, .. } => (by, 2),
                Motion::Prismatic { by, .. } => (by, 1),
                _ => continue,
            };
            users[by.dof] += 1;
            expected += own;
        }
        if users.iter().all(|n| *n <= 1) {
            assert_eq!(count, expected, "seed {seed}");
            checked += 1;
        }
    }
    assert!(checked > 20, "only {checked} trees had independent joints");
}

/// The reference knows nothing of base parameters; it ranks mass and first
/// moment of every link, as functions of posture.
#[test]
fn the_references_own_columns_have_the_same_ranks() {
    for seed in 0..120 {
        let kind = Kind {
            joints: 1 + seed as usize % 12,
            ..mixed(seed)
        };
        let (robot, model, support) = model(seed, kind, Snapping::default());
        let reference = sesc::verify::reference(&robot, &model).unwrap();
        let mut simulator = Simulator::new(&model.tree.dofs, None, seed + 1000);
        let postures: Vec<Vec<f64>> = (0..60).map(|_| simulator.posture()).collect();
        let rank = |axes: &[usize]| {
            let columns = reference.stacked_columns(&postures, axes);
            // The reference takes 1.5708 literally: what that tilts by counts as nothing.
            sesc_reference::numeric_rank(&columns, 2e-5)
        };
        let found = (rank(&[0, 1, 2]), rank(&[0, 1]));
        let claimed = (model.base.params.len(), model.base.rank_cop);
        assert_eq!(found, claimed, "seed {seed} on {support}");
    }
}

/// Followers geared down a thousandfold are parameters like any other.
#[test]
fn slow_followers_keep_their_parameters() {
    let motor = "<axis xyz='0 0 1'/><limit lower='-700' upper='700'/>";
    let geared = "<origin xyz='0.2 0 0.1'/><axis xyz='1 0 0'/><limit lower='-2' upper='2'/>\
                  <mimic joint='m' multiplier='0.002'/>";
    let mut gears = Urdf::new("gears").raw("<link name='base'/><link name='motor'/>");
    gears = gears.joint("m", "revolute", ["base", "motor"], motor);
    for links in [["base", "l0"], ["l0", "l1"], ["l1", "l2"], ["l2", "l3"]] {
        gears = gears.link(links[1], 1.0, "0.1 0.2 0.3");
        gears = gears.joint(&format!("of_{}", links[1]), "revolute", links, geared);
    }
    let robot = Robot::parse(&gears.text(), "gears.urdf").unwrap();
    let model = robot.model("base", Snapping::default(), None).unwrap();
    // The motor's own two, base's three, and two for each angle 1 to 4 times 0.002 m.
    assert_eq!(model.base.params.len(), 3 + 2 + 2 * 4);
    let found = verify(&robot, &model, 100, 1, &mut ()).unwrap();
    assert!(found.pass, "{found:#?}");
}

/// Every twist counts, however small: nearly parallel axes cost no more.
#[test]
fn hair_thin_twists_cost_at_most_four_more() {
    for tilt in ["1e-12", "1e-10", "5e-10", "2e-9", "1e-6"] {
        let mut hair = Urdf::new("hair").raw("<link name='l0'/>");
        for k in 0..20 {
            let [parent, child] = [k, k + 1].map(|k| format!("l{k}"));
            let more = format!(
                "<origin xyz='0 0.1 0.2' rpy='{tilt} 2.3e-10 0'/><axis xyz='0 0 1'/>\
                 <limit lower='-1' upper='1'/>"
            );
            hair = hair.link(&child, 1.0, "0 0 0");
            hair = hair.joint(&format!("j{k}"), "revolute", [&parent, &child], &more);
        }
        let robot = Robot::parse(&hair.text(), "hair.urdf").unwrap();
        let model = robot.model("l0", Snapping::Off, None).unwrap();
        let counts = counts(&model, Function::Com);
        assert!(counts.mul <= 160, "{tilt}: {counts:?}");
    }
}

/// Four multiplications a joint where axes are canonical, and at most four more where they are not.
#[test]
fn trees_cost_four_multiplications_a_joint_and_skewed_twists_four_more() {
    for seed in 0..100 {
        for canonical in [true, false] {
            let kind = Kind {
                joints: 1 + (seed as usize * 5) % 60,
                canonical,
                revolute: true,
                chained: [1.0, 0.7, 0.2, 0.0][seed as usize % 4],
            };
            let (_, model, _) = model(seed, kind, Snapping::default());
            let n = model.dof();
            let com = counts(&model, Function::Com);
            assert!(com.mul <= 8 * n, "seed {seed}: {com:?} for {n} joints");
            if canonical {
                assert!(com.mul <= 4 * n, "seed {seed}: {com:?} for {n} joints");
                assert!(com.add <= 5 * n, "seed {seed}: {com:?} for {n} joints");
                let rows = counts(&model, Function::RegressorCop);
                assert!(rows.mul <= 8 * n, "seed {seed}: {rows:?} for {n} joints");
            }
        }
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
    let (robot, model, _) = model(3, kind, Snapping::Off);
    let found = verify(&robot, &model, 1, 3, &mut ()).unwrap();
    assert!(found.pass, "{found:#?}");
}

/// `verify` reads whatever the model reads, though urdf-rs gives up on most of it.
#[test]
fn the_reference_reads_trees_that_lack_what_a_urdf_may_lack() {
    let mut given_up = 0;
    for seed in 0..200 {
        let (text, links) = tree(seed, mixed(seed));
        let text = stripped(&text, seed);
        given_up += usize::from(urdf_rs::read_from_string(&text).is_err());
        let robot = Robot::parse(&text, &format!("stripped-{seed}.urdf")).unwrap();
        let support = &links[(seed as usize * 7) % links.len()];
        let model = robot.model(support, Snapping::Off, None).unwrap();
        let found = verify(&robot, &model, 12, seed, &mut ()).unwrap();
        assert!(found.pass, "seed {seed} on {support}: {found:#?}\n{text}");
    }
    assert!(given_up > 150, "urdf-rs gave up on {given_up} of 200");
}

/// Every URDF of the repository that the model accepts.
#[test]
fn the_reference_reads_every_urdf() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["robots", "tests", "codegen/tests", "fuzz/seeds"];
    let mut folders: Vec<PathBuf> = folders.map(|folder| root.join(folder)).into();
    let mut read = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "urdf")
                && let Ok(robot) = Robot::read(&path)
            {
                read += 1;
                for support in robot.description.link_names() {
                    // A free joint may stand between a link and the masses.
                    let Ok(model) = robot.model(support, Snapping::default(), None) else {
                        continue;
                    };
                    let found = verify(&robot, &model, 3, 1, &mut ()).unwrap();
                    assert!(found.pass, "{} on {support}: {found:#?}", path.display());
                }
            }
        }
    }
    assert!(read >= 9, "{read} files");
}
