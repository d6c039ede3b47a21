//! Parameters of a model file as constants; `bits` compiles and runs such functions.

use sesc_codegen::emit::c::Scalar;
use sesc_model::expr::Expr;
use sesc_model::program::{Counts, operands};
use sesc_model::{Function, Given};

use super::case::Case;

/// Zeros of CAD vanish, products of constants fold.
#[test]
fn constants_fold_and_operations_fall() {
    let mut case = Case::robot("op2", "r_sole");
    case.take_values(|_, x| x);
    for (function, mul, add) in [(Function::Com, 80, 78), (Function::Cop, 78, 76)] {
        let argument = case.model.program(function, Given::Positions).unwrap();
        let program = case.model.baked_program(function, Given::Positions);
        let program = program.unwrap();
        for (_, node) in program.iter() {
            let consts: Vec<f64> = operands(node.expr)
                .filter_map(|id| match program.expr(id) {
                    Expr::Const(x) => Some(x),
                    _ => None,
                })
                .collect();
            assert!(!consts.contains(&0.0), "{:?}", node.expr);
            assert!(consts.len() < 2, "{:?} folds", node.expr);
            let product = matches!(node.expr, Expr::Mul(..));
            let unit = consts.iter().any(|x| x.abs() == 1.0);
            assert!(!(product && unit), "{:?}", node.expr);
        }
        let (before, found) = (argument.counts(), program.counts());
        assert!(
            found.mul <= before.mul && found.add < before.add,
            "{before:?}"
        );
        let expected = Counts {
            mul,
            add,
            sin_cos: 20,
            ..found
        };
        assert_eq!(found, expected);
    }
    // No parameter is left to pass.
    let header = case.package(Scalar::F32).header;
    let call = "model_com(const op2_r_sole_real q[], op2_r_sole_real com[3]);";
    assert!(header.contains(call), "{header}");
    assert!(header.contains("op2_r_sole_model_params[op2_r_sole_BASE_PARAMS];"));
}
