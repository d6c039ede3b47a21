//! What a function of generated Rust is from outside: parameters, result, documentation.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;

use crate::emit::listing::Listing;
use crate::facts::Facts;
use sesc_model::expr::Argument;
use sesc_model::{Extent, Function, Given};

/// Parameters for these arguments and the names to pass on; those that a body does not read
/// begin with `_`.
pub(super) fn signature(
    arguments: &[Argument],
    body: Option<&Listing>,
) -> (Vec<TokenStream>, Vec<Ident>) {
    let parameter = |argument: &Argument| {
        let is_read = body.is_none_or(|body| body.reads(*argument));
        let name = format!("{}{}", if is_read { "" } else { "_" }, argument.name());
        let (name, len) = (
            Ident::new(&name, Span::call_site()),
            extent(Extent::of(*argument)),
        );
        (quote!(#name: &[T; #len]), name)
    };
    arguments.iter().map(parameter).unzip()
}

/// The type of a result.
pub(super) fn result(function: Function, given: Given) -> TokenStream {
    match given {
        Given::Direction => filled(function, None, &quote!(T)),
        _ => filled(function, function.rows(), &quote!(T)),
    }
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
pub(super) fn extent(extent: Extent) -> TokenStream {
    match extent {
        Extent::Fixed(n) => {
            let n = Literal::usize_unsuffixed(n);
            quote!(#n)
        }
        Extent::Dof => quote!(DOF),
        Extent::BaseParams => quote!(BASE_PARAMS),
        Extent::FullParams => quote!(FULL_PARAMS),
        Extent::Context => quote!(CONTEXT),
    }
}

pub(super) fn documentation(facts: &Facts, function: Function, given: Given) -> String {
    let [what, _] = function.sentences(facts.has_static_effects());
    let effects = facts.effects_sentence(function);
    let effects = effects.map_or(String::new(), |sentence| format!("\n\n {sentence}"));
    match given {
        Given::Positions => format!(" {what}{effects}"),
        Given::SinesCosines => format!(
            " {what}{effects}\n\n From sines and cosines; a prismatic joint passes its position in `sin`."
        ),
        // Hidden, documented in the runtime.
        Given::Direction => String::new(),
    }
}

/// The name of a result that has rows, where it can be written in place: from joint
/// positions, as batches come.
pub(super) fn matrix(function: Function, given: Given) -> Option<Ident> {
    let name = match function {
        _ if given != Given::Positions => return None,
        Function::ComJacobian | Function::CopJacobian => "jacobian",
        Function::Regressor | Function::RegressorCop | Function::RegressorFull => "rows",
        _ => return None,
    };
    Some(Ident::new(name, Span::call_site()))
}
