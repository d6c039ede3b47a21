//! Bodies that stand once, and how functions of positions and of sines and cosines call them.
//!
//! ```text
//! com(q, r) = com_core(angles of q, r)        com_sc(sin, cos, r) = com_core((sin, cos), r)
//! ```

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::body::Body;
use super::printed::Notes;
use super::signature::{matrix, result, signature};
use super::{INTERFACE, definition, number};
use crate::emit::listing::{Listing, Results};
use crate::emit::shared::{Shared, values};
use crate::routines::Routine;
use sesc_model::expr::{Argument, Id};
use sesc_model::program::Program;
use sesc_model::{Function, Given};

/// A body that two functions call.
pub(super) struct Core<'r> {
    shared: Shared,
    pub(super) function: Function,
    /// The programs of positions and of sines and cosines.
    programs: [&'r Program; 2],
    /// The type that it is a function of.
    unit: &'r Ident,
    dof: usize,
}

impl<'r> Core<'r> {
    /// `None` where the two functions have bodies of their own.
    pub(super) fn new(
        [positions, sines]: [&'r Routine; 2],
        unit: &'r Ident,
        dof: usize,
    ) -> Option<Core<'r>> {
        Some(Core {
            shared: Shared::new(positions.function, &positions.program, &sines.program)?,
            function: positions.function,
            programs: [&positions.program, &sines.program],
            unit,
            dof,
        })
    }

    fn name(&self) -> Ident {
        format_ident!("{}_core", self.function.name())
    }

    /// What it takes besides angles.
    fn others(&self) -> Vec<Argument> {
        let mut arguments = self.function.arguments(Given::Positions);
        let reads = self.shared.reads_positions;
        arguments.retain(|argument| reads || *argument != Argument::Positions);
        arguments
    }

    /// The body, as a function of the robot's type.
    pub(super) fn item(&self, notes: &mut Notes) -> TokenStream {
        let (name, v1) = (self.name(), format_ident!("v{INTERFACE}"));
        let angles = Some(quote! { angles: &impl #v1::Angles<T> });
        let result = result(self.function, Given::Positions);
        let written = (result, matrix(self.function, Given::Positions));
        let (core, others) = (&self.shared.core, self.others());
        let body = definition(core, (angles, &others), written, Some(&self.shared), notes);
        quote! { #[inline(always)] fn #name #body }
    }

    /// The function of positions or of sines and cosines that calls it.
    pub(super) fn caller(&self, given: Given) -> TokenStream {
        let (function, unit, name) = (self.function, self.unit, self.name());
        let (parameters, _) = signature(&function.arguments(given), None);
        let (statements, angles) = match given {
            Given::Positions => self.of_positions(),
            Given::SinesCosines | Given::Direction => self.of_sines(),
        };
        let others = self.others().into_iter().map(|argument| match argument {
            // A prismatic joint passes its position in `sin`.
            Argument::Positions if given == Given::SinesCosines => format_ident!("sin"),
            argument => format_ident!("{}", argument.name()),
        });
        let others: Vec<Ident> = others.collect();
        let written = matrix(function, Given::Positions);
        let (result, place) = (result(function, given), written.as_ref());
        match (place, given) {
            (Some(place), Given::Positions) => {
                quote! { <T: Real>(#(#parameters,)* #place: &mut #result) {
                    #statements
                    #unit::#name(#angles, #(#others,)* #place);
                } }
            }
            (Some(place), _) => {
                let (zero, rows) = (number(0.0), function.rows().map(Literal::usize_unsuffixed));
                let columns = super::signature::extent(function.columns());
                quote! { <T: Real>(#(#parameters),*) -> #result {
                    #statements
                    let mut #place = [[T::from_f64(#zero); #columns]; #rows];
                    #unit::#name(#angles, #(#others,)* &mut #place);
                    #place
                } }
            }
            (None, _) => quote! { <T: Real>(#(#parameters),*) -> #result {
                #statements
                #unit::#name(#angles #(, #others)*)
            } },
        }
    }

    /// Whether angle j is of joint j, for all joints.
    fn are_of_joints(&self) -> bool {
        let mut angles = self.shared.angles.iter().enumerate();
        self.shared.angles.len() == self.dof && angles.all(|(j, angle)| angle.joint == j)
    }

    /// Statements that bind the values of a program, spelled, and the values.
    fn values(program: &Program, ids: &[Id]) -> (Vec<TokenStream>, Vec<TokenStream>) {
        let program = values(program, ids);
        let listing = Listing::new(&program, Results::AtTheEnd);
        Body::new(listing, None, None).values()
    }

    /// Angles of positions: statements, then what the body is called with.
    fn of_positions(&self) -> (TokenStream, TokenStream) {
        let v1 = format_ident!("v{INTERFACE}");
        let angles = &self.shared.angles;
        let turned = angles
            .iter()
            .enumerate()
            .filter(|(_, a)| a.turned.is_some());
        let (places, ids): (Vec<Literal>, Vec<Id>) = turned
            .map(|(k, angle)| (Literal::usize_unsuffixed(k), angle.id))
            .unzip();
        if self.are_of_joints() && ids.is_empty() {
            return (quote!(), quote!(&#v1::Positions::new(q)));
        }
        let (statements, angles) = if self.are_of_joints() {
            let (statements, values) = Core::values(self.programs[0], &ids);
            let turned = quote! { let mut angles = *q; #(angles[#places] = #values;)* };
            (quote! { #(#statements)* #turned }, quote!(angles))
        } else {
            let ids: Vec<Id> = angles.iter().map(|angle| angle.id).collect();
            let (statements, values) = Core::values(self.programs[0], &ids);
            (quote!(#(#statements)*), quote!([#(#values),*]))
        };
        (statements, quote!(&#v1::Positions::new(&#angles)))
    }

    /// The same from sines and cosines.
    fn of_sines(&self) -> (TokenStream, TokenStream) {
        let angles = &self.shared.angles;
        let pairs = angles.iter().filter_map(|angle| angle.turned);
        let ids: Vec<Id> = pairs.flatten().flatten().collect();
        if self.are_of_joints() && ids.is_empty() {
            return (quote!(), quote!(&(sin, cos)));
        }
        let (statements, values) = Core::values(self.programs[1], &ids);
        let mut values = values.into_iter();
        let all: Vec<[TokenStream; 2]> = angles
            .iter()
            .map(|angle| {
                let joint = Literal::usize_unsuffixed(angle.joint);
                let turned = angle.turned.unwrap_or_default();
                let [sin, cos] = turned.map(|id| id.and_then(|_| values.next()));
                // One that the body does not need may be any.
                [
                    sin.unwrap_or_else(|| quote!(sin[#joint])),
                    cos.unwrap_or_else(|| quote!(cos[#joint])),
                ]
            })
            .collect();
        let pairs = all.iter().enumerate();
        let turned = if self.are_of_joints() {
            let pairs = pairs.filter(|(k, _)| angles[*k].turned.is_some());
            let pairs = pairs.map(|(k, [s, c])| {
                let k = Literal::usize_unsuffixed(k);
                quote! { (sin_of[#k], cos_of[#k]) = (#s, #c); }
            });
            quote! { let (mut sin_of, mut cos_of) = (*sin, *cos); #(#pairs)* }
        } else {
            let [sin, cos] = [0, 1].map(|of| pairs.clone().map(move |(_, pair)| &pair[of]));
            quote! { let (sin_of, cos_of) = ([#(#sin),*], [#(#cos),*]); }
        };
        (
            quote! { #(#statements)* #turned },
            quote!(&(&sin_of, &cos_of)),
        )
    }
}
