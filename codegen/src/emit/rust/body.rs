//! The statements of one function: a listing, spelled in Rust.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use super::number;
use crate::emit::header;
use crate::emit::listing::{Line, Listing, Strength};
use sesc_model::expr::{Expr, Id};
use sesc_model::program::{Program, Shape};

/// A listing, spelled in Rust.
pub(super) struct Body<'p> {
    listing: Listing<'p>,
    /// The matrix that results are written to; without one they are the value of the body.
    matrix: Option<Ident>,
}

impl<'p> Body<'p> {
    pub(super) fn new(listing: Listing<'p>, matrix: Option<Ident>) -> Body<'p> {
        Body { listing, matrix }
    }

    pub(super) fn statements(&self, titles: &mut Vec<String>) -> TokenStream {
        let mut statements: Vec<TokenStream> = self.constants();
        for line in &self.listing.lines {
            statements.push(match *line {
                Line::Title(title) => {
                    let number = Literal::usize_unsuffixed(titles.len());
                    titles.push(header::printable(title));
                    quote! { section!(#number); }
                }
                Line::SinCos { angle, sin, cos } => self.sin_cos(angle, [sin, cos]),
                Line::Let(id) => {
                    let (value, _) = self.expression(self.program().expr(id));
                    let name = self.name(id).expect("a statement binds a name");
                    quote! { let #name = #value; }
                }
                Line::Result(k) => match &self.matrix {
                    Some(matrix) => self.entry(matrix, k),
                    None => continue,
                },
            });
        }
        let value = self.matrix.is_none().then(|| self.value());
        quote! { #(#statements)* #value }
    }

    fn program(&self) -> &'p Program {
        self.listing.program
    }

    fn name(&self, id: Id) -> Option<Ident> {
        let name = self.listing.name(id)?;
        Some(Ident::new(name, Span::call_site()))
    }

    /// Sine and cosine of one angle, even when only one of them is needed.
    fn sin_cos(&self, angle: Id, pair: [Option<Id>; 2]) -> TokenStream {
        let (value, strength) = self.operand(angle);
        let value = parenthesised(value, strength, Strength::Atom);
        let [s, c] = pair.map(|id| match id.and_then(|id| self.name(id)) {
            Some(name) => quote!(#name),
            None => quote!(_),
        });
        quote! { let (#s, #c) = #value.sin_cos(); }
    }

    /// An operand: its name, or its expression written out.
    fn operand(&self, id: Id) -> (TokenStream, Strength) {
        match self.name(id) {
            Some(name) => (quote!(#name), Strength::Atom),
            None => self.expression(self.program().expr(id)),
        }
    }

    fn expression(&self, expr: Expr) -> (TokenStream, Strength) {
        let at = |id: Id, least: Strength| {
            let (value, strength) = self.operand(id);
            parenthesised(value, strength, least)
        };
        match expr {
            Expr::Const(x) => (constant(x), Strength::Atom),
            Expr::Input { argument, index } => {
                let array = format_ident!("{}", argument.name());
                let index = Literal::usize_unsuffixed(index as usize);
                (quote!(#array[#index]), Strength::Atom)
            }
            // A sum on the right keeps its parentheses: rounding depends on the order.
            Expr::Add(a, b) => {
                if let Some(fused) = self.fused(a, b, false) {
                    return (fused, Strength::Atom);
                }
                let (a, b) = (at(a, Strength::Sum), at(b, Strength::Product));
                (quote!(#a + #b), Strength::Sum)
            }
            Expr::Sub(a, b) => {
                if let Some(fused) = self.fused(a, b, true) {
                    return (fused, Strength::Atom);
                }
                let (a, b) = (at(a, Strength::Sum), at(b, Strength::Product));
                (quote!(#a - #b), Strength::Sum)
            }
            Expr::Mul(a, b) => {
                let (a, b) = (at(a, Strength::Product), at(b, Strength::Sign));
                (quote!(#a * #b), Strength::Product)
            }
            Expr::Neg(a) => {
                let a = at(a, Strength::Atom);
                (quote!(-#a), Strength::Sign)
            }
            Expr::Div(a, b) => {
                let (a, b) = (at(a, Strength::Product), at(b, Strength::Sign));
                (quote!(#a / #b), Strength::Product)
            }
            Expr::Clamp(a) => {
                let a = at(a, Strength::Atom);
                (quote!(#a.clamp_unit()), Strength::Atom)
            }
            Expr::Pow(a, b) => {
                let (a, b) = (at(a, Strength::Atom), at(b, Strength::Sum));
                (quote!(#a.power(#b)), Strength::Atom)
            }
            Expr::Sin(a) => {
                let a = at(a, Strength::Atom);
                (quote!(#a.sin_cos().0), Strength::Atom)
            }
            Expr::Cos(a) => {
                let a = at(a, Strength::Atom);
                (quote!(#a.sin_cos().1), Strength::Atom)
            }
        }
    }

    /// The factors of a product that only the sum at hand uses, a constant last.
    fn factors(&self, id: Id) -> Option<[Id; 2]> {
        match self.program().expr(id) {
            Expr::Mul(a, b) if self.listing.name(id).is_none() => {
                let constant = |id| matches!(self.program().expr(id), Expr::Const(_));
                Some(if constant(a) { [b, a] } else { [a, b] })
            }
            _ => None,
        }
    }

    /// `a ± b` where one is a product: one rounding fewer where the machine can.
    fn fused(&self, a: Id, b: Id, minus: bool) -> Option<TokenStream> {
        let atom = |id: Id| {
            let (value, strength) = self.operand(id);
            parenthesised(value, strength, Strength::Atom)
        };
        let (negated, [x, y], term) = match (self.factors(a), self.factors(b)) {
            (Some(factors), _) => (false, factors, b),
            (None, Some(factors)) => (minus, factors, a),
            (None, None) => return None,
        };
        let x = atom(x);
        let x = if negated { quote!((-#x)) } else { x };
        let y = self.operand(y).0;
        let term = match minus && !negated {
            true => {
                let term = atom(term);
                quote!(-#term)
            }
            false => self.operand(term).0,
        };
        Some(quote!(#x.mul_plus(#y, #term)))
    }

    /// Names of the constants that results repeat.
    fn constants(&self) -> Vec<TokenStream> {
        let outputs = &self.program().outputs;
        let there = |x: f64| {
            let is = |id: &Id| self.program().expr(*id) == Expr::Const(x);
            outputs.iter().any(is)
        };
        let named = [(0.0, "zero"), (1.0, "one")].into_iter();
        named
            .filter(|(x, _)| there(*x))
            .map(|(x, name)| {
                let (name, value) = (format_ident!("{name}"), constant(x));
                quote! { let #name = #value; }
            })
            .collect()
    }

    /// Result `k`, written to its place.
    fn entry(&self, matrix: &Ident, k: usize) -> TokenStream {
        let value = self.output(self.program().outputs[k]);
        let Shape::Matrix { cols, .. } = self.program().shape else {
            unreachable!("vectors are values")
        };
        let [row, col] = [k / cols, k % cols].map(Literal::usize_unsuffixed);
        quote! { #matrix[#row][#col] = #value; }
    }

    fn output(&self, id: Id) -> TokenStream {
        match self.program().expr(id) {
            Expr::Const(0.0) => quote!(zero),
            Expr::Const(1.0) => quote!(one),
            _ => self.operand(id).0,
        }
    }

    /// The array of results.
    fn value(&self) -> TokenStream {
        let outputs = &self.program().outputs;
        let entry = |id: &Id| self.output(*id);
        match self.program().shape {
            Shape::Vector(_) => {
                let entries = outputs.iter().map(entry);
                quote! { [#(#entries),*] }
            }
            Shape::Matrix { rows, cols } => {
                let rows = (0..rows).map(|k| {
                    let entries = outputs[k * cols..(k + 1) * cols].iter().map(entry);
                    quote! { [#(#entries),*] }
                });
                quote! { [#(#rows),*] }
            }
        }
    }
}

fn parenthesised(value: TokenStream, strength: Strength, least: Strength) -> TokenStream {
    if strength < least {
        quote!((#value))
    } else {
        value
    }
}

/// A constant of the working precision.
fn constant(x: f64) -> TokenStream {
    let x = number(x);
    quote!(T::from_f64(#x))
}
