//! Parameters of a model file as constants.

use sesc_codegen::emit::c::Scalar;
use sesc_model::expr::Expr;
use sesc_model::program::{Counts, operands};
use sesc_model::{Function, Given, ModelFile};

use super::bounds::check;
use super::case::{Case, SCALARS};
use super::compiled::{Compiled, folder, parallel};
use super::draw::draw;
use super::entry::Entry;
use crate::COMPILERS;

fn baked(robot: &str, support: &str, change: impl Fn(usize, f64) -> f64) -> Case {
    let mut case = Case::robot(robot, support);
    let cad = case.model.cad_params();
    let values: Vec<f64> = cad.iter().enumerate().map(|(k, x)| change(k, *x)).collect();
    let file = ModelFile::from_values(&case.model, &values, None, "data");
    case.model = case.model.with_file(file).unwrap();
    case
}

#[test]
fn baked_functions_are_the_others_with_the_models_parameters() {
    let folder = folder("model");
    let mut jobs = Vec::new();
    for scalar in SCALARS {
        for (robot, support) in [
            ("op2", "r_sole"),
            ("lift_base", "hand"),
            ("two_link", "foot"),
        ] {
            jobs.push((robot, support, scalar));
        }
    }
    parallel(jobs, |(robot, support, scalar)| {
        let mut case = baked(robot, support, |k, x| x * 1.1 + 0.001 * (k % 3) as f64);
        case.functions = vec![Function::Com, Function::Cop];
        let compiled = Compiled::plain(&folder, &case, scalar, COMPILERS[0], "-O1");
        let entries = case.entries(scalar);
        let entries: Vec<&Entry> = entries.iter().filter(|entry| entry.baked).collect();
        // A prismatic and a revolute joint that follow one joint leave no functions of sines.
        assert!([4, 6].contains(&entries.len()), "{entries:?}");
        let drawn = draw(&case, 1_000, 47, &*compiled.hold());
        for (name, measured, proven) in check(&case, &compiled, &entries, &drawn) {
            println!("{robot} {scalar:?} {name}: {measured:.1e} of {proven:.1e} m");
        }
    });
}

/// Zeros of CAD vanish, products of constants fold.
#[test]
fn constants_fold_and_operations_fall() {
    let case = baked("op2", "r_sole", |_, x| x);
    let counts = |program: Option<sesc_model::program::Program>| program.unwrap().counts();
    let of = |function| {
        let argument = case.model.program(function, Given::Positions);
        let constant = case.model.baked_program(function, Given::Positions);
        for (_, node) in constant.as_ref().unwrap().iter() {
            let program = constant.as_ref().unwrap();
            let consts: Vec<f64> = operands(node.expr)
                .filter_map(|id| match program.expr(id) {
                    Expr::Const(x) => Some(x),
                    _ => None,
                })
                .collect();
            assert!(!consts.contains(&0.0), "{:?}", node.expr);
            assert!(consts.len() < 2, "{:?} folds", node.expr);
            let product = matches!(node.expr, Expr::Mul(..));
            assert!(
                !product || consts.iter().all(|x| x.abs() != 1.0),
                "{:?}",
                node.expr
            );
        }
        (counts(argument), counts(constant))
    };
    let (com, model_com) = of(Function::Com);
    let (cop, model_cop) = of(Function::Cop);
    println!("{com:?} {model_com:?}\n{cop:?} {model_cop:?}");
    assert!(
        model_com.mul <= com.mul && model_com.add < com.add,
        "{com:?} {model_com:?}"
    );
    assert!(
        model_cop.mul <= cop.mul && model_cop.add < cop.add,
        "{cop:?} {model_cop:?}"
    );
    let expected = |mul, add| Counts {
        mul,
        add,
        sin_cos: 20,
        ..model_com
    };
    assert_eq!(model_com, expected(80, 78));
    assert_eq!(
        model_cop,
        Counts {
            neg: model_cop.neg,
            ..expected(78, 76)
        }
    );
    // No parameter is left to pass.
    let package = case.package(Scalar::F32);
    assert!(
        package
            .header
            .contains("model_com(const op2_r_sole_real q[], op2_r_sole_real com[3]);")
    );
    assert!(
        package
            .header
            .contains("op2_r_sole_model_params[op2_r_sole_BASE_PARAMS];")
    );
}
