//! Bodies that stand once: functions of positions as those of their sines and cosines.
//!
//! ```text
//! sines(q) → (sin, cos) | com(q, r) = com_sc(sin, cos, r)
//! ```
//!
//! For robots with many joints, of which the compiler would read every body twice
//! (`sesc_model`'s programs of positions are of the same operations).

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::allow_names;
use super::signature::{matrix, result, signature};
use crate::emit::header;
use crate::facts::Facts;
use sesc_model::expr::Argument;
use sesc_model::{Function, Given};

/// The function that computes sines and cosines of all joints.
pub(super) fn sines(facts: &Facts) -> TokenStream {
    let prismatic = facts
        .dofs
        .iter()
        .enumerate()
        .filter(|(_, dof)| dof.prismatic);
    let positions = prismatic.map(|(j, _)| {
        let j = Literal::usize_unsuffixed(j);
        quote! { sin[#j] = q[#j]; }
    });
    let allow = allow_names();
    quote! {
        #[doc = " Sines and cosines of the joint angles; a prismatic joint passes its position in `sin`."]
        #allow
        #[inline(always)]
        fn sines<T: Real>(q: &[T; DOF]) -> ([T; DOF], [T; DOF]) {
            let (mut sin, mut cos) = (*q, *q);
            for j in 0..DOF {
                let (s, c) = q[j].sin_cos();
                sin[j] = s;
                cos[j] = c;
            }
            #(#positions)*
            (sin, cos)
        }
    }
}

/// A function of positions by that of sines and cosines.
pub(super) fn forward(function: Function, interface: usize) -> TokenStream {
    let (parameters, names) = signature(function, Given::Positions, own_name);
    let rest = names.iter().skip(1);
    let result = result(function, Given::Positions);
    let name = header::function_name(function, Given::SinesCosines);
    let (name, v) = (format_ident!("{name}"), format_ident!("v{interface}"));
    let value = quote! { <Self as #v::SinCosRobot>::#name(&sin, &cos #(, #rest)*) };
    match matrix(function, Given::Positions) {
        Some(matrix) => quote! { <T: Real>(#parameters, #matrix: &mut #result) {
            let (sin, cos) = sines(q);
            *#matrix = #value;
        } },
        None => quote! { <T: Real>(#parameters) -> #result {
            let (sin, cos) = sines(q);
            #value
        } },
    }
}

fn own_name(argument: Argument) -> String {
    argument.name().to_string()
}
