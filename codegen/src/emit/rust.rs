//! Rust from programs: one module per robot and support.
//!
//! ```text
//! constants, `mod joint`, unit struct | functions `com(q, r)` … | impl Robot for the struct
//! ```
//!
//! Bodies stand in the implementation of the runtime's hidden traits, forced inline: the
//! SIMD layer compiles them for registers that no call can carry. Without that, a posture of a
//! batch takes up to 41 times as long (`docs/dev/performance.md`, "Every set of instructions"). The
//! functions that a controller calls forward to them through the public traits and are inlined
//! where the compiler finds it worth while.
//!
//! Tokens are made by `quote`, checked by `syn`, printed by `prettyplease` (`printed`).

mod body;
mod constants;
mod core;
mod printed;
mod signature;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use self::core::Core;
use super::header;
use super::listing::{Listing, Results};
use super::shared::Shared;
use crate::Error;
use crate::emit::names;
use crate::error::Problem;
use crate::facts::Facts;
use crate::routines::{Routine, beyond, takes_context};
use body::Body;
use printed::Notes;
use sesc_model::expr::Argument;
use sesc_model::program::Program;
use sesc_model::{Function, Given};
use signature::{documentation, matrix, result, signature};

/// Version of the interface between generated code and `sesc-runtime`: the module of its
/// `__private` whose traits are implemented here. The runtime's `__interface!` fails to
/// compile where it has another.
const INTERFACE: usize = 1;

/// The module of a robot, named `name`.
///
/// # Errors
/// When `name` is no Rust module name or too long for a file.
pub fn module(facts: &Facts, name: &str) -> Result<String, Error> {
    names::MODULE.check(name)?;
    // Constants of parameters are for those who need not adapt them: C.
    let routines: Vec<&Routine> = facts.routines.iter().filter(|r| !r.baked).collect();
    if let Some(beyond) = beyond(routines.iter().copied(), f64::MAX) {
        let function = beyond.function.name();
        return Err(Problem::NotFinite { function }.into());
    }
    let unit = Ident::new(&names::type_name(name), Span::call_site());
    let mut notes = Notes::default();
    let constants = constants::items(facts, &mut notes);
    let doc = format!(
        " Robot `{}` standing on `{}`.",
        header::printable(facts.robot),
        header::printable(facts.support)
    );
    let struct_ = quote! {
        #[doc = #doc]
        #[allow(dead_code, non_camel_case_types)]
        #[derive(Debug, Clone, Copy)]
        pub struct #unit;
    };
    let robot = Robot::new(facts, unit, &routines, &mut notes);
    let in_context = in_context(facts, &mut notes);
    let (uses, functions, impls) = (robot.uses(), robot.functions(), robot.impls());
    let interface = Literal::usize_unsuffixed(INTERFACE);
    let items = quote! {
        #uses
        sesc_runtime::__interface!(#interface);
        #constants
        #struct_
        #functions
        #in_context
        #impls
    };
    let rows = facts.routines.iter();
    let rows: Vec<&Routine> = rows.filter(|r| !r.baked || is_in_context(r)).collect();
    let mut about = header::lines(facts, &rows);
    about.push(String::new());
    about.push(
        "method         statically equivalent serial chain (SESC); equations as numbered in".into(),
    );
    about.push(format!("               {}", header::PAPER));
    printed::file(items, &about, &notes)
}

/// Generated items may go unused.
fn allow_unused() -> TokenStream {
    quote! { #[allow(dead_code)] }
}

/// Names keep the spelling of the robot's: `FL_HAA` is a joint, not a style. Numbers are
/// written so that they read back to the same bits, which lints would shorten.
fn allow_names() -> TokenStream {
    quote! { #[allow(dead_code, non_snake_case, clippy::all)] }
}

/// The functions of a module, in the traits that they belong to.
struct Robot {
    unit: Ident,
    methods: Vec<Method>,
    /// All functions of the module can be had from sines and cosines.
    from_sines: bool,
    /// Bodies that functions of positions share with those of sines and cosines.
    cores: Vec<TokenStream>,
}

/// One function: what it is from outside, and what it does.
struct Method {
    function: Function,
    given: Given,
    doc: String,
    /// Parameters and result as the body sees them, then the body.
    body: TokenStream,
}

impl Robot {
    fn new(facts: &Facts, unit: Ident, routines: &[&Routine], notes: &mut Notes) -> Robot {
        let of_sines = |routine: &&&Routine| routine.given == Given::SinesCosines;
        let asked_for = Function::ALL.len() - facts.left_out.len();
        let from_sines = routines.iter().filter(of_sines).count() == asked_for;
        let of_positions = routines.iter().filter(|r| r.given == Given::Positions);
        let cores = of_positions.filter_map(|positions| {
            let mut sines = routines.iter().filter(of_sines);
            let sines = sines.find(|sines| sines.function == positions.function)?;
            Core::new([positions, sines], &unit, facts.dof())
        });
        let cores: Vec<Core> = cores.collect();
        let method = |routine: &&Routine| {
            let (function, given) = (routine.function, routine.given);
            let mut cores = cores.iter().filter(|_| given != Given::Direction);
            Method {
                function,
                given,
                doc: documentation(facts, function, given),
                body: match cores.find(|core| core.function == function) {
                    Some(core) => core.caller(given),
                    None => {
                        let arguments = function.arguments(given);
                        let result = (result(function, given), matrix(function, given));
                        definition(&routine.program, (None, &arguments), result, None, notes)
                    }
                },
            }
        };
        let methods = routines.iter().map(method).collect();
        Robot {
            methods,
            from_sines,
            cores: cores.iter().map(|core| core.item(notes)).collect(),
            unit,
        }
    }

    fn corrects(&self) -> bool {
        self.methods
            .iter()
            .any(|method| method.function == Function::CorrectCop)
    }

    fn uses(&self) -> TokenStream {
        let sines = self.from_sines.then(|| quote!(, SescFromSinCos as _));
        let corrects = self.corrects().then(|| quote!(CorrectCop as _,));
        let v1 = format_ident!("v{INTERFACE}");
        quote! {
            use sesc_runtime::__private::#v1;
            use sesc_runtime::{#corrects Real, Sesc as _ #sines};
        }
    }

    /// What a controller calls.
    fn functions(&self) -> TokenStream {
        let functions = self.methods.iter().filter_map(|method| {
            let Method {
                function, given, ..
            } = *method;
            if given == Given::Direction {
                return None;
            }
            let name = format_ident!("{}", header::function_name(function, given));
            let (parameters, arguments) = signature(&function.arguments(given), None);
            let (result, allow, unit) = (result(function, given), allow_unused(), &self.unit);
            let doc = method.doc.lines();
            let head = quote! { #(#[doc = #doc])* };
            Some(match given == Given::SinesCosines && !self.from_sines {
                // Not a method of a trait: some function of this robot takes more than sines.
                true => {
                    let (allow, body) = (allow_names(), &method.body);
                    quote! { #head #allow #[inline] pub fn #name #body }
                }
                false => quote! {
                    #head
                    #allow
                    #[inline]
                    pub fn #name<T: Real>(#(#parameters),*) -> #result { #unit::#name(#(#arguments),*) }
                },
            })
        });
        quote! { #(#functions)* }
    }

    /// What the runtime calls.
    fn impls(&self) -> TokenStream {
        let v1 = format_ident!("v{INTERFACE}");
        let unit = &self.unit;
        let implementation = |name: &str, constants: TokenStream, has: &dyn Fn(&Method) -> bool| {
            let name = format_ident!("{name}");
            let methods = self
                .methods
                .iter()
                .filter(|method| has(method))
                .map(|method| {
                    let name = method.name();
                    let body = &method.body;
                    quote! { #[inline(always)] fn #name #body }
                });
            let allow = allow_names();
            quote! { #allow impl #v1::#name for #unit { #constants #(#methods)* } }
        };
        let of_posture = |method: &Method| method.given == Given::Positions;
        let robot = implementation("Robot", constants::associated(&v1), &of_posture);
        let sines = self.from_sines.then(|| {
            implementation("SinCosRobot", quote!(), &|method| {
                method.given != Given::Positions
            })
        });
        let corrects = self
            .corrects()
            .then(|| implementation("SensorEffects", quote!(), &|_| false));
        let (allow, cores) = (allow_names(), &self.cores);
        let cores = (!cores.is_empty()).then(|| quote! { #allow impl #unit { #(#cores)* } });
        quote! { #robot #sines #corrects #cores }
    }
}

impl Method {
    /// Its name in the runtime's traits.
    fn name(&self) -> Ident {
        let name = header::function_name(self.function, self.given);
        match matrix(self.function, self.given) {
            Some(_) => format_ident!("{name}_into"),
            None => format_ident!("{name}"),
        }
    }
}

/// Whether a function of constant parameters takes a context: those alone are part of a module.
fn is_in_context(routine: &Routine) -> bool {
    routine.given == Given::Positions && takes_context(&routine.program)
}

/// `model_com` and `model_cop`, where effects depend on more than q.
fn in_context(facts: &Facts, notes: &mut Notes) -> TokenStream {
    let (allow, allow_names) = (allow_unused(), allow_names());
    let functions: Vec<TokenStream> = facts
        .routines
        .iter()
        .filter(|routine| is_in_context(routine))
        .map(|routine| {
            let arguments = [Argument::Positions, Argument::Context];
            let result = (result(routine.function, routine.given), None);
            let body = definition(&routine.program, (None, &arguments), result, None, notes);
            let name = format_ident!("model_{}", routine.function.name());
            let doc = documentation(facts, routine.function, routine.given);
            let doc = doc.lines();
            quote! {
                #(#[doc = #doc])*
                ///
                /// With the parameters of the model file, and what its effects depend on beside `q` in
                /// the order of `CONTEXT_NAMES`.
                #allow_names
                pub fn #name #body
            }
        })
        .collect();
    if functions.is_empty() {
        return quote!();
    }
    let count = Literal::usize_unsuffixed(facts.context.len());
    let names = facts.context.iter().map(|(name, _)| name);
    quote! {
        /// Number of what effects depend on beside `q` and `r`.
        #allow
        pub const CONTEXT: usize = #count;
        /// Time (s), side of approach (−1 to 1), columns of a log.
        #allow
        pub const CONTEXT_NAMES: [&str; CONTEXT] = [#(#names),*];
        #(#functions)*
    }
}

/// Parameters, result and statements of a function of these arguments, `angles` before them; a
/// matrix is written to its place as its entries come.
fn definition(
    program: &Program,
    (angles, arguments): (Option<TokenStream>, &[Argument]),
    (result, matrix): (TokenStream, Option<Ident>),
    shared: Option<&Shared>,
    notes: &mut Notes,
) -> TokenStream {
    let results = match matrix {
        Some(_) => Results::AsTheyCome,
        None => Results::AtTheEnd,
    };
    let listing = Listing::new(program, results);
    let (parameters, _) = signature(arguments, Some(&listing));
    let parameters = angles.into_iter().chain(parameters);
    let body = Body::new(listing, matrix.clone(), shared).statements(notes);
    match matrix {
        Some(matrix) => quote! { <T: Real>(#(#parameters,)* #matrix: &mut #result) { #body } },
        None => quote! { <T: Real>(#(#parameters),*) -> #result { #body } },
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
