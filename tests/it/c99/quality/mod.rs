//! What the C is like to read, to compile and to trust.

mod compilers;
mod misra;
mod text;

use sesc_codegen::emit::c::Scalar;
use sesc_model::ModelFile;

use super::case::{Case, ROBOTS};

/// Robots, with and without a model file; one has long names.
fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = ROBOTS.iter().map(|(r, s)| Case::robot(r, s)).collect();
    cases.push(Case::robot("skew_humanoid", "right_sole"));
    cases.extend((0..4).map(|k| Case::random(740 + k, 3 + 4 * k as usize)));
    for (robot, support) in [
        ("op2", "l_sole"),
        ("lift_base", "base_link"),
        ("two_link", "foot"),
    ] {
        let mut case = Case::robot(robot, support);
        let file = ModelFile::from_values(&case.model, &case.model.cad_params(), None, "prior");
        case.model = case.model.with_file(file).unwrap();
        case.name += "_model";
        cases.push(case);
    }
    cases.push(estimating());
    cases.extend(Case::effects());
    cases.extend([4, 8, 16].map(|lanes| Case::robot("lift_base", "hand").of_many(lanes)));
    cases.push(exponent().of_many(8));
    cases
}

/// A robot with the estimator, which frees readings of a sensor effect and goes on from a fit.
fn estimating() -> Case {
    let mut case = Case::with_effect("sensor_rotation", "-", ("yaw_rad", 0.02)).informed();
    case.name = "two_link_estimator".to_string();
    case
}

/// A robot whose reading takes a power and is clamped.
fn exponent() -> Case {
    let mut case = Case::with_effect("cell_exponent", "fsr_2", ("exponent", 1.1));
    case.functions = sesc_model::Function::ALL.to_vec();
    case
}

/// Those that differ in kind.
fn few() -> Vec<Case> {
    let alike = ["humanoid_left", "plain", "quad", "arm", "op2_body"];
    let mut cases = cases();
    cases.retain(|case| !alike.iter().any(|name| case.name.contains(name)));
    cases
}

/// Every case in every scalar.
fn jobs(cases: &[Case]) -> Vec<(&Case, Scalar)> {
    let mut jobs = Vec::new();
    for case in cases {
        jobs.extend(case.scalars().iter().map(|scalar| (case, *scalar)));
    }
    jobs
}
