//! One program by itself: a function that knows no robot.

use proc_macro2::{Ident, Literal, Span};
use quote::quote;

use super::printed::{self, Notes};
use super::{Body, allow_names};
use crate::Error;
use crate::emit::header;
use crate::emit::listing::{Listing, Results};
use crate::emit::names;
use sesc_model::program::{Program, Shape};

/// `pub fn name<T: Real>(inputs…) -> …` for `program`, as the text of a module.
///
/// # Errors
/// When `name` is no name for a function.
pub fn function(program: &Program, name: &str) -> Result<String, Error> {
    if !names::is_module_name(name) {
        return Err(Error::BadName {
            name: name.to_string(),
            suggestion: names::suggest(name),
        });
    }
    let listing = Listing::new(program, Results::AtTheEnd);
    let parameters = program.inputs.iter().map(|array| {
        let array_name = match listing.reads(array.argument) {
            true => array.argument.name().to_string(),
            false => format!("_{}", array.argument.name()),
        };
        let ident = Ident::new(&array_name, Span::call_site());
        let len = Literal::usize_unsuffixed(array.len);
        quote! { #ident: &[T; #len] }
    });
    let parameters: Vec<_> = parameters.collect();
    let result = match program.shape {
        Shape::Vector(n) => {
            let n = Literal::usize_unsuffixed(n);
            quote! { [T; #n] }
        }
        Shape::Matrix { rows, cols } => {
            let [rows, cols] = [rows, cols].map(Literal::usize_unsuffixed);
            quote! { [[T; #cols]; #rows] }
        }
    };
    let mut notes = Notes::default();
    let body = Body::new(listing, None).statements(&mut notes);
    let (ident, allow) = (Ident::new(name, Span::call_site()), allow_names());
    let items = quote! {
        use sesc_runtime::Real;
        /// The program, unrolled.
        #allow
        pub fn #ident<T: Real>(#(#parameters),*) -> #result { #body }
    };
    let counts = program.counts();
    let about = [
        header::GENERATOR.to_string(),
        String::new(),
        format!(
            "operations     {} mul, {} add, {} sin_cos{}",
            counts.mul,
            counts.add,
            counts.sin_cos,
            header::others(counts)
        ),
    ];
    printed::file(items, &about, &notes)
}
