//! Rust from programs: one module per robot and support.
//!
//! Tokens are made by `quote`, checked by `syn`, printed by `prettyplease`.
//! That printer drops comments, so section titles travel as marker statements
//! and become comment lines afterwards.

mod body;
pub mod free;
mod signature;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use super::header::{self, Row};
use super::listing::{Listing, Results};
use crate::Error;
use crate::emit::names;
use body::Body;
use sesc_model::expr::Argument;
use sesc_model::program::Program;
use sesc_model::{Function, Given, Model};
use signature::{documentation, matrix, result, signature, zeros};

/// The module for `model`, named `name`.
///
/// # Errors
/// When `name` is no Rust module name.
pub fn module(model: &Model, name: &str) -> Result<String, Error> {
    if !names::is_module_name(name) {
        return Err(Error::BadName {
            name: name.to_string(),
            suggestion: names::suggest(name),
        });
    }
    let rows = header::rows(model);
    let mut titles = Vec::new();
    let functions: Vec<TokenStream> = rows
        .iter()
        .map(|(row, program)| function(model, row, program, &mut titles))
        .collect();
    let constants = constants(model);
    let from_sines = rows
        .iter()
        .filter(|(row, _)| row.given == Given::SinesCosines);
    let corrects = rows
        .iter()
        .any(|(row, _)| row.function == Function::CorrectCop);
    let unit = unit_struct(
        model,
        name,
        from_sines.count() == Function::ALL.len(),
        corrects,
    );
    let items = quote! {
        use sesc_runtime::{Real, Sesc};
        #constants
        #unit
        #(#functions)*
    };
    let rows: Vec<Row> = rows.into_iter().map(|(row, _)| row).collect();
    printed(items, &header::lines(model, &rows), &titles)
}

/// Items below a comment, with the section titles that their markers stand for.
fn printed(items: TokenStream, about: &[String], titles: &[String]) -> Result<String, Error> {
    let file = syn::parse2(items).map_err(|error| Error::Emitted {
        reason: error.to_string(),
    })?;
    let printed = prettyplease::unparse(&file);
    let mut text = String::with_capacity(printed.len() + 4096);
    for line in about {
        text.push_str(format!("// {line}").trim_end());
        text.push('\n');
    }
    text.push('\n');
    let mut open = false; // inside an item's documentation and attributes
    for line in printed.lines() {
        let attached = line.starts_with("///") || line.starts_with("#[");
        let starts = attached || line.starts_with("pub ") || line.starts_with("impl");
        // The printer leaves no room between items.
        if starts && !open {
            text.push('\n');
        }
        open = attached;
        match section(line, titles) {
            Some(comment) => text.push_str(&comment),
            None => text.push_str(line),
        }
        text.push('\n');
    }
    Ok(text)
}

/// A marker statement `section!(k);` as the comment it stands for.
fn section(line: &str, titles: &[String]) -> Option<String> {
    let (indent, rest) = line.split_once("section!(")?;
    let number: usize = rest.strip_suffix(");")?.parse().ok()?;
    Some(format!("{indent}// {}", titles.get(number)?))
}

/// Sizes, names, CAD values and the self-test vector.
fn constants(model: &Model) -> TokenStream {
    let [dof, base, full] = [
        model.dof(),
        model.base.params.len(),
        model.chain.full_params,
    ]
    .map(Literal::usize_unsuffixed);
    let joints = model.tree.dofs.iter().map(|dof| &dof.joint);
    let sliding = model.tree.dofs.iter().map(|dof| dof.prismatic);
    let params = model.base.params.iter().map(|param| &param.name);
    let cad = model.base.params.iter().map(|param| number(param.cad));
    let posture = model.self_test_posture();
    let com = model.com_by_sum(&posture).map(number);
    let posture = posture.iter().map(|x| number(*x));
    let allow = allow();
    let identified = model.file.as_ref().map(|file| {
        let values = file.values().into_iter().map(number);
        let doc = format!(
            " Identified base parameters, m, from a model file (source: {}).",
            header::printable(&file.source())
        );
        quote! {
            #[doc = #doc]
            #allow
            pub const MODEL_PARAMS: [f64; BASE_PARAMS] = [#(#values),*];
        }
    });
    quote! {
        /// Number of independent joints.
        #allow
        pub const DOF: usize = #dof;
        /// Number of base parameters: columns that data can tell apart.
        #allow
        pub const BASE_PARAMS: usize = #base;
        /// Number of SESC parameters r_0, r_1, … (and s of sliding joints).
        #allow
        pub const FULL_PARAMS: usize = #full;
        /// Joints in the order of `q`.
        #allow
        pub const JOINT_NAMES: [&str; DOF] = [#(#joints),*];
        /// Which joints slide: their `q` is in metres, the others' in radians.
        #allow
        pub const PRISMATIC: [bool; DOF] = [#(#sliding),*];
        /// Base parameters in the order of `r`: link and axis in its frame.
        #allow
        pub const PARAM_NAMES: [&str; BASE_PARAMS] = [#(#params),*];
        /// Base parameters from CAD, m.
        #allow
        pub const CAD_PARAMS: [f64; BASE_PARAMS] = [#(#cad),*];
        #identified
        /// A posture to test with.
        #allow
        pub const SELF_TEST_Q: [f64; DOF] = [#(#posture),*];
        /// The CoM there with `CAD_PARAMS`, m, summed body by body by the generator.
        #allow
        pub const SELF_TEST_COM: [f64; 3] = [#(#com),*];
    }
}

/// Generated items may go unused and hold numbers that lints would like to rename.
fn allow() -> TokenStream {
    quote! { #[allow(dead_code, clippy::all)] }
}

/// Names keep the spelling of the robot's: `FL_HAA` is a joint, not a style.
fn allow_names() -> TokenStream {
    quote! { #[allow(dead_code, non_snake_case, non_camel_case_types, clippy::all)] }
}

/// The unit struct and its traits, forwarding to the functions of the module.
fn unit_struct(model: &Model, name: &str, from_sines: bool, corrects: bool) -> TokenStream {
    let unit = Ident::new(&names::type_name(name), Span::call_site());
    let doc = format!(
        " Robot `{}` standing on `{}`.",
        header::printable(&model.tree.robot),
        header::printable(&model.tree.links[model.tree.support].name)
    );
    let forward = |given: Given| -> Vec<TokenStream> {
        let there = |function: &&Function| {
            given != Given::Direction || model.program(**function, given).is_some()
        };
        Function::ALL
            .iter()
            .filter(there)
            .map(|&function| {
                let name = format_ident!("{}", header::function_name(function, given));
                let (parameters, arguments) =
                    signature(function, given, |argument| argument.name().to_string());
                let result = result(function, given);
                let into = matrix(function, given).map(|matrix| {
                    let into = format_ident!("{name}_into");
                    quote! {
                        #[inline(always)]
                        fn #into<T: Real>(#parameters, #matrix: &mut #result) {
                            #into(#(#arguments,)* #matrix)
                        }
                    }
                });
                quote! {
                    #[inline(always)]
                    fn #name<T: Real>(#parameters) -> #result { #name(#(#arguments),*) }
                    #into
                }
            })
            .collect()
    };
    let methods = forward(Given::Positions);
    let (allow, names) = (allow(), allow_names());
    let sines = from_sines.then(|| {
        let methods = [Given::SinesCosines, Given::Direction].map(forward).concat();
        quote! {
            #allow
            impl sesc_runtime::SescFromSinCos<DOF, BASE_PARAMS, FULL_PARAMS> for #unit { #(#methods)* }
        }
    });
    let correction = corrects.then(|| {
        quote! {
            #allow
            impl sesc_runtime::CorrectCop for #unit {
                #[inline(always)]
                fn correct_cop<T: Real>(reading: &[T; 2]) -> [T; 2] { correct_cop(reading) }
            }
        }
    });
    quote! {
        #[doc = #doc]
        #names
        #[derive(Debug, Clone, Copy)]
        pub struct #unit;
        #allow
        impl Sesc<DOF, BASE_PARAMS, FULL_PARAMS> for #unit {
            const JOINT_NAMES: [&'static str; DOF] = JOINT_NAMES;
            const PRISMATIC: [bool; DOF] = PRISMATIC;
            const CAD_PARAMS: [f64; BASE_PARAMS] = CAD_PARAMS;
            #(#methods)*
        }
        #sines
        #correction
    }
}

fn function(model: &Model, row: &Row, program: &Program, titles: &mut Vec<String>) -> TokenStream {
    let matrix = matrix(row.function, row.given);
    let listing = match matrix {
        Some(_) => Listing::new(program, Results::AsTheyCome),
        None => Listing::new(program, Results::AtTheEnd),
    };
    let rename = |argument: Argument| match listing.reads(argument) {
        true => argument.name().to_string(),
        false => format!("_{}", argument.name()),
    };
    let (parameters, _) = signature(row.function, row.given, rename);
    let doc = documentation(model, row.function, row.given);
    let doc = doc.lines();
    let name = format_ident!("{}", header::function_name(row.function, row.given));
    let result = result(row.function, row.given);
    let body = Body::new(listing, matrix.clone()).statements(titles);
    let allow = allow_names();
    let Some(matrix) = matrix else {
        return quote! {
            #(#[doc = #doc])*
            #allow
            #[inline(always)]
            pub fn #name<T: Real>(#parameters) -> #result { #body }
        };
    };
    let into = format_ident!("{name}_into");
    let (given, arguments) = signature(row.function, row.given, |argument| {
        argument.name().to_string()
    });
    let zeros = zeros(row.function);
    let into_doc = format!(" [`{name}`], each number written as soon as it is there.");
    quote! {
        #(#[doc = #doc])*
        #allow
        #[inline(always)]
        pub fn #name<T: Real>(#given) -> #result {
            let mut #matrix = #zeros;
            #into(#(#arguments,)* &mut #matrix);
            #matrix
        }
        #[doc = #into_doc]
        #allow
        #[inline(always)]
        pub fn #into<T: Real>(#parameters, #matrix: &mut #result) { #body }
    }
}

/// A float that reads back to the same bits.
fn number(x: f64) -> TokenStream {
    if x < 0.0 {
        let x = Literal::f64_unsuffixed(-x);
        quote!(-#x)
    } else {
        let x = Literal::f64_unsuffixed(x);
        quote!(#x)
    }
}
