//! Sizes, names, limits, CAD values and the self-test vector of a module.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::printed::Notes;
use super::{allow_unused, number};
use crate::emit::header;
use crate::facts::Facts;
use sesc_model::names;
use sesc_model::tree::Dof;

/// The constants of the module.
pub(super) fn items(facts: &Facts, notes: &mut Notes) -> TokenStream {
    let allow = allow_unused();
    let numbers = quote! { #[allow(dead_code, clippy::all)] };
    let names = facts.param_names();
    let sizes = [facts.dof(), names.len(), facts.model.chain.full_params];
    let [dof, base, full] = sizes.map(Literal::usize_unsuffixed);
    let joints = facts.dofs.iter().map(|dof| &dof.joint);
    let prismatic = facts.dofs.iter().map(|dof| dof.prismatic);
    let [lower, upper] = [0, 1].map(|end| {
        let limits = facts.dofs.iter();
        notes.numbers(limits.map(|dof| (dof.limits()[end], dof.joint.as_str())))
    });
    let mut by_param =
        |values: &[f64]| notes.numbers(values.iter().copied().zip(names.iter().copied()));
    let cad = by_param(&facts.model.cad_params());
    let mass = number(facts.model.total_mass_kg());
    let posture = facts.self_test.posture.iter().map(|x| number(*x));
    let com = facts.self_test.com.map(number);
    let joint_module = joint_module(facts);
    let identified = facts.identified.as_ref().map(|identified| {
        let values = by_param(&identified.values);
        let std = identified.std.as_deref().map(|std| {
            let std = by_param(std);
            quote! {
                /// Their standard deviations, m; infinite where nothing is known.
                #numbers
                pub const MODEL_STD: [f64; BASE_PARAMS] = #std;
            }
        });
        let information = identified.information.as_ref().map(|information| {
            let factor = information.iter().map(|x| number(*x));
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
            header::printable(&identified.source)
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
        /// Total mass from CAD, kg: gravity moments times this and g are N m; a motor applies the opposite.
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
fn joint_module(facts: &Facts) -> TokenStream {
    let word = |dof: &Dof| match names::word(&dof.joint) {
        word if word.starts_with(|c: char| c.is_ascii_digit()) => format!("J{word}"),
        word => word,
    };
    let words: Vec<String> = facts.dofs.iter().map(word).collect();
    let words = names::constants(words.iter().map(String::as_str));
    let indices = words.iter().enumerate().map(|(j, word)| {
        let (word, j) = (format_ident!("{word}"), Literal::usize_unsuffixed(j));
        quote! { pub const #word: usize = #j; }
    });
    quote! {
        /// Index of every joint in `q`.
        #[allow(dead_code, missing_docs, non_upper_case_globals)]
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
