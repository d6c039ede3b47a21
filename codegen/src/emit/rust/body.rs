//! The statements of one function: a listing, spelled in Rust.
//!
//! `a * b + c` is `a.mul_plus(b, c)`, whose nesting reads inside out: each stands in a
//! statement of its own, under the name of what it is a part of.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use super::number;
use super::printed::Notes;
use crate::emit::listing::{Line, Listing, Strength};
use crate::emit::shared::Shared;
use sesc_model::expr::{Expr, Id};
use sesc_model::program::{Program, Shape};

/// A listing, spelled in Rust.
pub(super) struct Body<'p> {
    listing: Listing<'p>,
    /// The matrix that results are written to; without one they are the value of the body.
    matrix: Option<Ident>,
    /// Where sines and cosines come from an argument, the angles there.
    shared: Option<&'p Shared>,
    statements: Vec<TokenStream>,
    /// Parts that got names of their own: `p1`, `p2`, …
    parts: usize,
}

/// Where an expression stands, and so whether it may be a `mul_plus`.
#[derive(Clone, Copy)]
enum Place<'n> {
    /// In a statement: it may.
    Open,
    /// In a `mul_plus`: one that is needed here is bound before, to this name or a new one.
    Inside(Option<&'n Ident>),
}

impl<'p> Body<'p> {
    pub(super) fn new(
        listing: Listing<'p>,
        matrix: Option<Ident>,
        shared: Option<&'p Shared>,
    ) -> Body<'p> {
        Body {
            listing,
            matrix,
            shared,
            statements: Vec::new(),
            parts: 0,
        }
    }

    pub(super) fn statements(mut self, notes: &mut Notes) -> TokenStream {
        self.statements = self.constants();
        for line in std::mem::take(&mut self.listing.lines) {
            let statement = match line {
                Line::Title(title) => notes.section(title),
                Line::SinCos { angle, sin, cos } => self.sin_cos(angle, [sin, cos]),
                Line::Let(id) => {
                    let name = self.name(id).expect("a statement binds a name");
                    let (value, _) =
                        self.expression(self.program().expr(id), Place::Open, Some(&name));
                    quote! { let #name = #value; }
                }
                Line::Result(k) => match self.matrix.clone() {
                    Some(matrix) => self.entry(&matrix, k),
                    None => continue,
                },
            };
            self.statements.push(statement);
        }
        let value = self.matrix.is_none().then(|| self.value());
        let statements = self.statements;
        quote! { #(#statements)* #value }
    }

    /// What the values of a program need, then the values.
    pub(super) fn values(mut self) -> (Vec<TokenStream>, Vec<TokenStream>) {
        for line in std::mem::take(&mut self.listing.lines) {
            if let Line::Let(id) = line {
                let name = self.name(id).expect("a statement binds a name");
                let expr = self.program().expr(id);
                let (value, _) = self.expression(expr, Place::Open, Some(&name));
                self.statements.push(quote! { let #name = #value; });
            }
        }
        let outputs = self.program().outputs.iter();
        let values = outputs.map(|id| self.operand(*id, Place::Open, Strength::Sum));
        let values = values.collect();
        (self.statements, values)
    }

    fn program(&self) -> &'p Program {
        self.listing.program
    }

    fn name(&self, id: Id) -> Option<Ident> {
        let name = self.listing.name(id)?;
        Some(Ident::new(name, Span::call_site()))
    }

    /// Sine and cosine of one angle, even when only one of them is needed.
    fn sin_cos(&mut self, angle: Id, pair: [Option<Id>; 2]) -> TokenStream {
        let value = match self.shared {
            Some(shared) => {
                let place = Literal::usize_unsuffixed(shared.place(angle));
                quote!(angles.sin_cos(#place))
            }
            None => {
                let value = self.operand(angle, Place::Open, Strength::Atom);
                quote!(#value.sin_cos())
            }
        };
        let [s, c] = pair.map(|id| match id.and_then(|id| self.name(id)) {
            Some(name) => quote!(#name),
            None => quote!(_),
        });
        quote! { let (#s, #c) = #value; }
    }

    /// An operand: its name, or its expression written out.
    fn operand(&mut self, id: Id, place: Place, least: Strength) -> TokenStream {
        if let Some(name) = self.name(id) {
            return quote!(#name);
        }
        let (value, strength) = self.expression(self.program().expr(id), place, None);
        match strength < least {
            true => quote!((#value)),
            false => value,
        }
    }

    /// An expression; `whole` is the name that all of it gets.
    fn expression(
        &mut self,
        expr: Expr,
        place: Place,
        whole: Option<&Ident>,
    ) -> (TokenStream, Strength) {
        // The name is for a sum that continues as the next one, not for two in one place.
        let inner = match place {
            Place::Open => Place::Open,
            Place::Inside(_) => Place::Inside(None),
        };
        match expr {
            Expr::Const(x) => (constant(x), Strength::Atom),
            Expr::Input { argument, index } => {
                let array = format_ident!("{}", argument.name());
                let index = Literal::usize_unsuffixed(index as usize);
                (quote!(#array[#index]), Strength::Atom)
            }
            // A sum on the right keeps its parentheses: rounding depends on the order.
            Expr::Add(a, b) | Expr::Sub(a, b) => {
                let minus = matches!(expr, Expr::Sub(..));
                if let Some(product) = self.product_in(a, b, minus) {
                    return (self.mul_plus(product, place, whole), Strength::Atom);
                }
                // One `mul_plus` a statement.
                let after = match self.is_written_out(a) {
                    true => Place::Inside(None),
                    false => inner,
                };
                let a = self.operand(a, inner, Strength::Sum);
                let b = self.operand(b, after, Strength::Product);
                match minus {
                    true => (quote!(#a - #b), Strength::Sum),
                    false => (quote!(#a + #b), Strength::Sum),
                }
            }
            Expr::Mul(a, b) | Expr::Div(a, b) => {
                let a = self.operand(a, inner, Strength::Product);
                let b = self.operand(b, inner, Strength::Sign);
                let value = match expr {
                    Expr::Mul(..) => quote!(#a * #b),
                    _ => quote!(#a / #b),
                };
                (value, Strength::Product)
            }
            Expr::Neg(a) => {
                let a = self.operand(a, inner, Strength::Atom);
                (quote!(-#a), Strength::Sign)
            }
            Expr::Pow(a, b) | Expr::Max(a, b) => {
                let is_power = matches!(expr, Expr::Pow(..));
                let method = format_ident!("{}", if is_power { "power" } else { "larger" });
                let a = self.operand(a, inner, Strength::Atom);
                let b = self.operand(b, inner, Strength::Sum);
                (quote!(#a.#method(#b)), Strength::Atom)
            }
            Expr::Clamp(a) | Expr::Sin(a) | Expr::Cos(a) => {
                let a = self.operand(a, inner, Strength::Atom);
                let value = match expr {
                    Expr::Sin(_) => quote!(#a.sin_cos().0),
                    Expr::Cos(_) => quote!(#a.sin_cos().1),
                    _ => quote!(#a.clamp_unit()),
                };
                (value, Strength::Atom)
            }
        }
    }

    /// Whether a node stands for an operation that has no name.
    fn is_written_out(&self, id: Id) -> bool {
        let leaf = matches!(self.program().expr(id), Expr::Const(_) | Expr::Input { .. });
        !leaf && self.listing.name(id).is_none()
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
    fn product_in(&self, a: Id, b: Id, minus: bool) -> Option<ProductSum> {
        let (subtract, factors, term) = match (self.factors(a), self.factors(b)) {
            (Some(factors), _) => ([false, minus], factors, b),
            (None, Some(factors)) => ([minus, false], factors, a),
            (None, None) => return None,
        };
        Some(ProductSum {
            factors,
            term,
            subtract,
        })
    }

    fn mul_plus(&mut self, sum: ProductSum, place: Place, whole: Option<&Ident>) -> TokenStream {
        let whole = match place {
            Place::Open => whole,
            Place::Inside(name) => name,
        };
        let [x, y] = sum.factors;
        let x = self.operand(x, Place::Inside(None), Strength::Atom);
        let y = self.operand(y, Place::Inside(None), Strength::Sum);
        let least = match sum.subtract[1] {
            true => Strength::Atom,
            false => Strength::Sum,
        };
        let term = self.operand(sum.term, Place::Inside(whole), least);
        let [x, term] = [(x, sum.subtract[0]), (term, sum.subtract[1])]
            .map(|(x, minus)| if minus { quote!(-#x) } else { x });
        let x = if sum.subtract[0] { quote!((#x)) } else { x };
        let value = quote!(#x.mul_plus(#y, #term));
        if let Place::Open = place {
            return value;
        }
        let name = whole.cloned().unwrap_or_else(|| {
            self.parts += 1;
            format_ident!("p{}", self.parts)
        });
        self.statements.push(quote! { let #name = #value; });
        quote!(#name)
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
    fn entry(&mut self, matrix: &Ident, k: usize) -> TokenStream {
        let value = self.output(self.program().outputs[k]);
        let Shape::Matrix { cols, .. } = self.program().shape else {
            unreachable!("vectors are values")
        };
        let [row, col] = [k / cols, k % cols].map(Literal::usize_unsuffixed);
        quote! { #matrix[#row][#col] = #value; }
    }

    fn output(&mut self, id: Id) -> TokenStream {
        match self.program().expr(id) {
            Expr::Const(0.0) => quote!(zero),
            Expr::Const(1.0) => quote!(one),
            _ => self.operand(id, Place::Open, Strength::Sum),
        }
    }

    /// The array of results; rows get names.
    fn value(&mut self) -> TokenStream {
        let outputs = &self.program().outputs;
        let Shape::Matrix { rows, cols } = self.program().shape else {
            let entries: Vec<_> = outputs.iter().map(|id| self.output(*id)).collect();
            return quote! { [#(#entries),*] };
        };
        let names = (0..rows).map(|k| match ["x", "y", "z"].get(k) {
            Some(axis) if rows <= 3 => format_ident!("row_{axis}"),
            _ => format_ident!("row_{k}"),
        });
        let names: Vec<Ident> = names.collect();
        for (k, name) in names.iter().enumerate() {
            // A row is empty where nothing moves.
            let row = &outputs[k * cols..(k + 1) * cols];
            let entries: Vec<_> = row.iter().map(|id| self.output(*id)).collect();
            self.statements
                .push(quote! { let #name = [#(#entries),*]; });
        }
        quote! { [#(#names),*] }
    }
}

/// `±x·y ± term`.
struct ProductSum {
    factors: [Id; 2],
    term: Id,
    /// Whether the product and the term count negatively.
    subtract: [bool; 2],
}

/// A constant of the working precision.
fn constant(x: f64) -> TokenStream {
    let x = number(x);
    quote!(T::from_f64(#x))
}
