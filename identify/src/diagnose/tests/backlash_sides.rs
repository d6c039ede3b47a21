//! Dead bands: the side of gravity, and of postures that hold on both.

use sesc_model::effects::PostureContext;

use super::{Bench, gauss, term, values};
use crate::diagnose::problem::backlash_sides::settle;

const JOINT: &str = "r_ank_pitch";

/// Every loose joint ends where the virtual robot's does.
#[test]
fn gravity_puts_joints_where_they_slide_to() {
    let bench = Bench::op2();
    let (dof, width) = (bench.model.dof(), 0.01);
    let q = bench.balanced(60, 7);
    let problem = bench.certain(bench.log(&bench.world(), &q, 1));
    let world = bench.world().backlash_all(width).unwrap();
    let all = [term(&problem, "backlash", "all")];
    let sides = settle(&problem, &all, &[width], false).remove(0);
    assert!(sides.flipped.is_empty());
    assert_eq!(sides.penalty, 0.0);
    let layout = PostureContext::of(&bench.model);
    let (mut told, mut wrong) = (0, 0);
    for (k, q) in q.chunks(dof).enumerate() {
        let stands = world.true_posture(q);
        for joint in 0..dof {
            let slid = (stands[joint] - q[joint]) / (width / 2.0);
            // Some come to rest within their bands, where nothing moves them.
            if slid.abs() > 0.999 {
                let side = sides.posture_context[k * layout.len() + layout.side(joint)];
                told += 1;
                wrong += usize::from((side - slid).abs() > 1e-2);
            }
        }
    }
    assert!(told > 50 * dof, "{told}");
    // Where moments are next to zero, another order of settling ends elsewhere.
    assert!(100 * wrong < told, "{wrong} of {told}");
}

/// An ankle that carries is an inverted pendulum: where its moment reverses within
/// the band, both ends hold. The reading shows which one a posture took.
#[test]
fn readings_tell_the_side_where_both_hold() {
    let bench = Bench::op2();
    let (dof, joint, width) = (bench.model.dof(), bench.joint(JOINT), 0.03);
    let world = bench.world();
    for seed in 0..4 {
        let q = bench.balanced(150, 20 + seed);
        let mut gauss = gauss(seed);
        let moved = |q: &[f64], side: f64| {
            let mut q = q.to_vec();
            q[joint] += side * width / 2.0;
            q
        };
        // Per posture: the side it takes, and whether that is gravity's from the middle.
        let takes: Vec<(f64, bool, bool)> = q
            .chunks(dof)
            .map(|q| {
                let moment = |side: f64| world.joint_moments(&moved(q, side))[joint];
                let gravity = moment(0.0).signum();
                let both = moment(-1.0) < 0.0 && moment(1.0) > 0.0;
                let side = if both { gauss().signum() } else { gravity };
                (side, side != gravity, both)
            })
            .collect();
        assert!(takes.iter().filter(|t| t.2).count() > 5);
        let data = bench.read(&world, &q, seed, |k, q| {
            let (cop, bent) = (world.cop(q), world.cop(&moved(q, takes[k].0)));
            [bent[0] - cop[0], bent[1] - cop[1]]
        });
        let problem = bench.certain(data);
        let own = [term(&problem, "backlash", JOINT)];
        let fit = problem.fit(&own, None);
        let found = &values(&problem, &fit)[0];
        let pull = (found.value - width) / found.std;
        assert!(pull.abs() < 3.5, "{seed}: {found:?}");
        let flipped: Vec<usize> = (0..takes.len()).filter(|&k| takes[k].1).collect();
        assert!(!flipped.is_empty());
        // Nine deviations lie between the sides; next to even odds a few are
        // settled by gravity of masses known to half a millimetre.
        let told = flipped
            .iter()
            .filter(|k| fit.blocks[0].flipped.contains(k))
            .count();
        let wrong = fit.blocks[0]
            .flipped
            .iter()
            .filter(|k| !flipped.contains(k))
            .count();
        assert!(told + 1 >= flipped.len(), "{seed}: {told} of {flipped:?}");
        assert!(
            wrong <= 1,
            "{seed}: {:?} beside {flipped:?}",
            fit.blocks[0].flipped
        );
        let layout = PostureContext::of(&bench.model);
        assert!(fit.blocks[0].sides.is_some());
        let posture_context = problem.posture_contexts(Some(&fit)).swap_remove(0);
        let agree = (0..takes.len())
            .filter(|k| posture_context[k * layout.len() + layout.side(joint)] == takes[*k].0)
            .count();
        assert!(agree + 2 >= takes.len(), "{seed}: {agree}");
    }
}
