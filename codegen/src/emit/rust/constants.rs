//! Sizes, names, limits, CAD values and the self-test vector of a module.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::printed::Notes;
use super::{allow_unused, number};
use crate::emit::header;
use sesc_model::{Model, names};

/// The constants of the module.
pub(super) fn items(model: &Model, notes: &mut Notes) -> TokenStream {
    let allow = allow_unused();
    let numbers = quote! { #[allow(dead_code, clippy::all)] };
    let [dof, base, full] = [
        model.dof(),
        model.base.params.len(),
        model.chain.full_params,
    ]
    .map(Literal::usize_unsuffixed);
    let dofs = &model.tree.dofs;
    let joints = dofs.iter().map(|dof| &dof.joint);
    let prismatic = dofs.iter().map(|dof| dof.prismatic);
    let mut by_joint = |value: &dyn Fn(usize) -> f64| {
        notes.numbers((0..dofs.len()).map(|j| (value(j), dofs[j].joint.as_str())))
    };
    // A range that only postures are drawn from is no limit.
    let lower = by_joint(&|j| match dofs[j].continuous {
        true => f64::NEG_INFINITY,
        false => dofs[j].lower,
    });
    let upper = by_joint(&|j| match dofs[j].continuous {
        true => f64::INFINITY,
        false => dofs[j].upper,
    });
    let params = model.base.params.iter();
    let names = params.clone().map(|param| &param.name);
    let cad = notes.numbers(params.clone().map(|param| (param.cad, param.name.as_str())));
    let mass = number(model.tree.mass);
    let posture = model.self_test_posture();
    let com = model.com_by_sum(&posture).map(number);
    let posture = posture.iter().map(|x| number(*x));
    let joint_module = joint_module(model);
    let identified = model.file.as_ref().map(|file| {
        let mut by_param = |values: Vec<f64>| {
            let values = values.into_iter().zip(params.clone());
            notes.numbers(values.map(|(value, param)| (value, param.name.as_str())))
        };
        let values = by_param(file.values());
        let known = file.parameters.iter().any(|param| param.std.is_some());
        let std = known.then(|| {
            let std = file.parameters.iter().map(|param| param.std);
            let std = by_param(std.map(|std| std.unwrap_or(f64::INFINITY)).collect());
            quote! {
                /// Their standard deviations, m; infinite where nothing is known.
                #numbers
                pub const MODEL_STD: [f64; BASE_PARAMS] = #std;
            }
        });
        let information = file.information.as_ref().map(|information| {
            let factor = information.packed().into_iter().map(number);
            quote! {
                /// How well they are known together, for `Estimator::resume`: R with RᵀR their
                /// inverse covariance, row by row from the diagonal on, 1/m.
                #numbers
                pub const MODEL_INFORMATION: [f64; BASE_PARAMS * (BASE_PARAMS + 1) / 2] =
                    [#(#factor),*];
            }
        });
        let doc = format!(
            " Identified base parameters, m, from a model file (source: {}).",
            header::printable(&file.source())
        );
        quote! {
            #[doc = #doc]
            #numbers
            pub const MODEL_PARAMS: [f64; BASE_PARAMS] = #values;
            #std
            #information
        }
    });
    quote! {
        /// Number of independent joints.
        #allow
        pub const DOF: usize = #dof;
        /// Number of base parameters: columns that data can tell apart.
        #allow
        pub const BASE_PARAMS: usize = #base;
        /// Number of SESC parameters r_0, r_1, … (and s of prismatic joints).
        #allow
        pub const FULL_PARAMS: usize = #full;
        /// Joints in the order of `q`.
        #allow
        pub const JOINT_NAMES: [&str; DOF] = [#(#joints),*];
        #joint_module
        /// Which joints are prismatic: their `q` is in metres, the others' in radians.
        #allow
        pub const PRISMATIC: [bool; DOF] = [#(#prismatic),*];
        /// Lower joint limits, rad (m at prismatic joints).
        #numbers
        pub const JOINT_LOWER: [f64; DOF] = #lower;
        /// Upper joint limits, rad (m at prismatic joints).
        #numbers
        pub const JOINT_UPPER: [f64; DOF] = #upper;
        /// Total mass from CAD, kg: gravity moments times this and g are in N m.
        #numbers
        pub const TOTAL_MASS_KG: f64 = #mass;
        /// Base parameters in the order of `r`: link and axis in its frame.
        #allow
        pub const PARAM_NAMES: [&str; BASE_PARAMS] = [#(#names),*];
        /// Base parameters from CAD, m.
        #numbers
        pub const CAD_PARAMS: [f64; BASE_PARAMS] = #cad;
        #identified
        /// A posture to test with.
        #numbers
        pub const SELF_TEST_Q: [f64; DOF] = [#(#posture),*];
        /// The CoM there with `CAD_PARAMS`, m, summed body by body by the generator.
        #numbers
        pub const SELF_TEST_COM: [f64; 3] = [#(#com),*];
    }
}

/// An index for every joint.
fn joint_module(model: &Model) -> TokenStream {
    let upper = |name: &str| {
        let name = name.to_uppercase();
        match name.starts_with(|c: char| c.is_ascii_digit()) {
            true => format!("J{name}"),
            false => name,
        }
    };
    let words: Vec<String> = model
        .tree
        .dofs
        .iter()
        .map(|dof| upper(&dof.joint))
        .collect();
    let words = names::unique(words.iter().map(String::as_str));
    let indices = words.iter().enumerate().map(|(j, word)| {
        let (word, j) = (format_ident!("{word}"), Literal::usize_unsuffixed(j));
        quote! { pub const #word: usize = #j; }
    });
    quote! {
        /// Index of every joint in `q`.
        #[allow(dead_code, non_upper_case_globals)]
        pub mod joint { #(#indices)* }
    }
}

/// Types and constants of the runtime's trait, forwarding to those of the module.
pub(super) fn associated(v1: &Ident) -> TokenStream {
    quote! {
        type Dof = #v1::Const<DOF>;
        type Base = #v1::Const<BASE_PARAMS>;
        type Full = #v1::Const<FULL_PARAMS>;
        const JOINT_NAMES: [&'static str; DOF] = JOINT_NAMES;
        const PRISMATIC: [bool; DOF] = PRISMATIC;
        const JOINT_LOWER: [f64; DOF] = JOINT_LOWER;
        const JOINT_UPPER: [f64; DOF] = JOINT_UPPER;
        const TOTAL_MASS_KG: f64 = TOTAL_MASS_KG;
        const CAD_PARAMS: [f64; BASE_PARAMS] = CAD_PARAMS;
    }
}
