//! What a page shows of the effect that is named, by what the virtual robot does.

use super::{Bench, OP2_URDF, diagnosed};
use crate::diagnose::Verdict;
use crate::diagnose::view::DiagnosisView;
use crate::robot::Robot;
use crate::skeleton::Skeleton;

/// Offset of the knee, rad.
const OFFSET: f64 = 0.05;

#[test]
fn the_named_joint_stands_first_and_its_gap_lies_on_a_straight_line() {
    let bench = Bench::op2();
    let q = bench.balanced(120, 3);
    let world = bench.world().joint_offset("r_knee", OFFSET).unwrap();
    let mut problem = bench.problem(bench.log(&world, &q, 3), "tight");
    let found = diagnosed(&mut problem);
    assert!(matches!(
        found.diagnosis.verdict,
        Verdict::Named | Verdict::Class
    ));
    assert_eq!(found.diagnosis.steps[0].target, "r_knee");
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let skeleton = Skeleton::of(&bench.model, &robot.description, None);
    let view = DiagnosisView::of(&problem, &found, skeleton);
    for trends in [&view.by_position, &view.by_moment] {
        assert!(trends[0].named && trends[0].joint == "r_knee");
        assert!(trends[1..].iter().all(|trend| !trend.named));
    }
    // By its share alone another joint would stand before it.
    let share = |k: usize| view.by_position[k].share[0];
    assert!(share(1) > share(0), "{} {}", share(1), share(0));
    assert_eq!(view.predicted.len(), 2);
    let dof = bench.model.dof();
    let plain = bench.world();
    for (axis, row) in view.predicted.iter().enumerate() {
        assert_eq!((row.axis, row.points.len()), (axis, 120));
        assert!(row.subject.contains("r_knee"), "{}", row.subject);
        let off = |k: usize| {
            let own = &q[k * dof..(k + 1) * dof];
            world.cop(own)[axis] - plain.cop(own)[axis]
        };
        let largest = (0..120).map(|k| off(k).abs()).fold(0.0, f64::max);
        for point in &row.points {
            // The offset is known to about a twentieth, masses to 0.2 %.
            let error = (point.change - off(point.posture)).abs();
            assert!(error < 0.06 * largest, "{axis}: {error:e}");
        }
    }
    // The knee turns about y: it moves x by millimetres, far more than the noise.
    let slope = view.predicted[0].slope;
    assert!((slope - 1.0).abs() < 0.1, "{slope}");
}
