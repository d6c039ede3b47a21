//! What a function of generated Rust is from outside: parameters, result, documentation.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;

use sesc_model::expr::Argument;
use sesc_model::{Extent, Function, Given, Model};

/// Parameters of a function and the names to pass on.
pub(super) fn signature(
    function: Function,
    given: Given,
    rename: impl Fn(Argument) -> String,
) -> (TokenStream, Vec<Ident>) {
    let arguments = function.arguments(given);
    let idents: Vec<Ident> = arguments
        .iter()
        .map(|argument| Ident::new(&rename(*argument), Span::call_site()))
        .collect();
    let lens = arguments
        .iter()
        .map(|argument| extent(Extent::of(*argument)));
    (quote! { #(#idents: &[T; #lens]),* }, idents)
}

/// The type of a result.
pub(super) fn result(function: Function, given: Given) -> TokenStream {
    match given {
        Given::Direction => filled(function, None, &quote!(T)),
        _ => filled(function, function.rows(), &quote!(T)),
    }
}

/// A result of zeros.
pub(super) fn zeros(function: Function) -> TokenStream {
    filled(function, function.rows(), &quote!(T::from_f64(0.0)))
}

/// A vector, or as many as there are rows.
fn filled(function: Function, rows: Option<usize>, with: &TokenStream) -> TokenStream {
    let columns = extent(function.columns());
    let vector = quote!([#with; #columns]);
    match rows.map(Literal::usize_unsuffixed) {
        Some(rows) => quote!([#vector; #rows]),
        None => vector,
    }
}

/// A length as generated code names it.
fn extent(extent: Extent) -> TokenStream {
    match extent {
        Extent::Fixed(n) => {
            let n = Literal::usize_unsuffixed(n);
            quote!(#n)
        }
        Extent::Dof => quote!(DOF),
        Extent::BaseParams => quote!(BASE_PARAMS),
        Extent::FullParams => quote!(FULL_PARAMS),
    }
}

pub(super) fn documentation(model: &Model, function: Function, given: Given) -> String {
    let what = match function {
        Function::Cop if model.static_effects().next().is_some() => {
            "Reading of the CoP that a static posture foretells, with the effects at the top of \
             this file, m unless they change its unit."
        }
        Function::Com => "Centre of mass in the support frame, m: r_0 + Σ B_i(q) r_i.",
        Function::ComJacobian => "∂CoM/∂q, m/rad (m/m for sliding joints), one row per axis.",
        Function::GravityMoments => {
            "Moment of gravity about each joint, per kg of total mass and g: −∂CoM_z/∂q, m."
        }
        Function::Regressor => "Rows of the base regressor: CoM = rows · r.",
        Function::RegressorCop => "The x and y rows of the base regressor: CoP = rows · r.",
        Function::RegressorFull => {
            "Rows [B_0 B_1 …] of the full regressor, seed paper Eq. (5), in link frames."
        }
        Function::Cop => "Centre of pressure that a static posture shows on a level sole, m.",
        Function::CorrectCop => {
            "The CoP, m, that a reading (as `cop` foretells it) was made of: the effects of the \
             sensor taken back."
        }
    };
    match given {
        Given::Positions => format!(" {what}"),
        Given::SinesCosines => format!(
            " {what}\n\n From sines and cosines; a sliding joint passes its position in `sin`."
        ),
        Given::Direction => format!(
            " {what}\n\n Their combination `along` a direction of the support frame, no longer \
             than one, from sines and cosines as above."
        ),
    }
}

/// The name of a result that has rows, where it can be written in place: from joint
/// positions, as batches come.
pub(super) fn matrix(function: Function, given: Given) -> Option<Ident> {
    let name = match function {
        _ if given != Given::Positions => return None,
        Function::ComJacobian => "jacobian",
        Function::Regressor | Function::RegressorCop | Function::RegressorFull => "rows",
        _ => return None,
    };
    Some(Ident::new(name, Span::call_site()))
}
