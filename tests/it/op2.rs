//! The OP2: facts about the robot, the paper and the cost of its code.

use sesc::OP2_URDF;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::robot::Robot;
use sesc_model::program::Counts;
use sesc_model::{Function, Given, Model, Snapping, numeric};

fn op2(support: &str) -> Model {
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    robot.model(support, Snapping::default(), None).unwrap()
}

fn posture(model: &Model, degrees: &[(&str, f64)]) -> Vec<f64> {
    let mut q = vec![0.0; model.dof()];
    for (joint, degrees) in degrees {
        let mut dofs = model.tree.dofs.iter();
        let place = dofs.position(|dof| dof.joint == *joint).expect(joint);
        q[place] = degrees.to_radians();
    }
    q
}

fn counts(model: &Model, function: Function) -> Counts {
    model.program(function, Given::Positions).unwrap().counts()
}

/// CoM in the right-sole and the body frame, as Pinocchio and MuJoCo agree.
#[test]
fn reference_poses_hold() {
    let squat = [
        ("r_hip_pitch", -30.0),
        ("l_hip_pitch", 30.0),
        ("r_knee", 60.0),
        ("l_knee", -60.0),
        ("r_ank_pitch", 30.0),
        ("l_ank_pitch", -30.0),
    ];
    let walk_start = [
        ("r_sho_pitch", -48.345),
        ("l_sho_pitch", 41.313),
        ("r_sho_roll", -17.873),
        ("l_sho_roll", 17.580),
        ("r_el", 29.300),
        ("l_el", -29.593),
        ("head_tilt", 40.0),
    ];
    let sole = [
        (&[][..], [-0.004057, 0.046476, 0.228231]),
        (&squat[..], [-0.000248, 0.046476, 0.208920]),
        (&walk_start[..], [-0.010976, 0.046488, 0.228602]),
    ];
    let body = [
        (&[][..], [-0.009057, -0.001024, -0.113469]),
        (&squat[..], [-0.005248, -0.001024, -0.107861]),
        (&walk_start[..], [-0.015976, -0.001012, -0.113098]),
    ];
    for (support, poses) in [("r_sole", sole), ("body_link", body)] {
        let model = op2(support);
        let mass = model.tree.mass;
        assert!((mass - 2.925325).abs() < 5e-7, "{mass}");
        let com = Evaluator::new(&model, Function::Com);
        for (degrees, expected) in poses {
            let found = com.run(&posture(&model, degrees), 1);
            for (x, y) in found.iter().zip(expected) {
                assert!((x - y).abs() < 1e-6, "{support} {degrees:?}: {found:?}");
            }
        }
    }
}

/// Eq. (5): the full columns are the orientations of the paper's chain, each the
/// product of rotations about the URDF's axes.
#[test]
fn the_full_form_is_the_papers_chain() {
    let model = op2("r_sole");
    let order = [
        "r_sole",
        "r_ank_pitch_link",
        "r_knee_link",
        "r_hip_pitch_link",
        "r_hip_roll_link",
        "r_hip_yaw_link",
        "body_link",
    ];
    let names: Vec<&str> = model.chain.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names[..7], order);
    let product = |body: &str| {
        let i = names.iter().position(|name| *name == body).unwrap();
        model.chain.orientation_products().swap_remove(i)
    };
    assert_eq!(product("r_sole"), "I");
    assert_eq!(product("r_ank_pitch_link"), "Rx(-r_ank_roll)");
    assert_eq!(product("r_knee_link"), "Rx(-r_ank_roll) Ry(r_ank_pitch)");
    assert_eq!(
        product("body_link"),
        "Rx(-r_ank_roll) Ry(r_ank_pitch) Ry(-r_knee) Ry(-r_hip_pitch) Rx(r_hip_roll) Rz(r_hip_yaw)"
    );
}

/// Base and full parameters describe the same robot.
#[test]
fn base_and_full_parameters_give_the_same_com() {
    for support in ["r_sole", "l_sole", "body_link", "head_tilt_link"] {
        let model = op2(support);
        let base = Evaluator::new(&model, Function::Com);
        for q in numeric::postures(&model.tree.dofs, 50) {
            let by_base = base.run(&q, 1);
            for (x, y) in by_base.iter().zip(model.com_by_sum(&q)) {
                assert!((x - y).abs() < 1e-15, "{support}: {by_base:?}");
            }
        }
    }
}

#[test]
fn operation_counts_stay_below_their_limits() {
    let model = op2("r_sole");
    let com = counts(&model, Function::Com);
    let [mul, add] = [com.mul, com.add].map(|count| count <= 80);
    assert!(mul && add && com.sin_cos == 20, "{com:?}");
    let jacobian = counts(&model, Function::ComJacobian);
    assert!(jacobian.mul <= 360 && jacobian.add <= 215, "{jacobian:?}");
    let zmp = counts(&model, Function::Zmp);
    assert!(zmp.mul <= 1396 && zmp.add <= 1251, "{zmp:?}");
    assert_eq!(zmp.other, 1);
    let rows = counts(&model, Function::RegressorCop);
    assert!(rows.mul <= 160, "{rows:?}");
}
