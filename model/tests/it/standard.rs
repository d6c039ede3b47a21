//! Base parameters as sums of masses and first moments; the same on every support.

use std::path::Path;

use nalgebra::DVector;
use sesc_model::standard::PER_LINK;
use sesc_model::{Model, Snapping, urdf};

const ROBOTS: [(&str, [&str; 2]); 4] = [
    ("op2", ["r_sole", "l_sole"]),
    ("quadruped", ["lf_foot", "rh_foot"]),
    ("lift_base", ["base_link", "hand"]),
    ("skew_humanoid", ["left_sole", "right_sole"]),
];

fn models(robot: &str, supports: [&str; 2]) -> [Model; 2] {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    let description = urdf::read(&root.join(format!("{robot}/{robot}.urdf"))).unwrap();
    supports.map(|support| Model::new(&description, support, Snapping::default()).unwrap())
}

#[test]
fn parameters_are_linear_in_masses_and_moments() {
    for (robot, supports) in ROBOTS {
        for model in models(robot, supports) {
            let theta = model.standard_cad();
            let masses: f64 = theta.iter().step_by(PER_LINK).sum();
            assert!((masses - 1.0).abs() < 1e-12, "{robot}: {masses}");
            let cad = DVector::from_vec(model.cad_params());
            let error = (model.standard_map() * theta - cad).amax();
            assert!(error < 1e-14, "{robot}: {error:.1e}");
        }
    }
}

/// Seen from either foot the parameters differ only by lengths of the URDF.
#[test]
fn both_feet_share_their_parameters() {
    for (robot, supports) in ROBOTS {
        let [left, right] = models(robot, supports);
        let shift = left.params_from(&right);
        assert!(shift.unexplained < 1e-12, "{robot}");
        let there = DVector::from_vec(right.cad_params());
        let here = DVector::from_vec(left.cad_params());
        let error = (&shift.matrix * there + &shift.offset - here).amax();
        assert!(error < 1e-13, "{robot}: {error:.1e}");
    }
}
