//! Static helpers that statements call; a source file holds those and no other.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fmt::Display;

use minijinja::context;
use minijinja::value::{Serde, Value};
use serde::Serialize;

use super::Scalar;

/// A function that the source file keeps to itself; its name follows the prefix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Helper {
    /// Sine and cosine of an angle.
    Sincos,
    /// Sine and cosine of an angle, or those that are given.
    Turn,
    /// Sine and cosine of a step of the table.
    Lookup,
    /// 64 bits to 32 with fewer bits below the point, rounded.
    Narrow,
    /// More bits below the point, in 64 bits. A macro: compilers fold the product with the
    /// sum around it, which they do not through a function.
    ShiftUp,
    /// Sums and differences in 32 bits that wrap, macros too.
    Add,
    Subtract,
    /// Into [-1, 1]; for effects alone, as is `Power`, which fixed point lacks.
    Clamp,
    Power,
    /// The larger of two, and in every lane.
    Larger,
    LargerLanes,
    /// Numbers of a block of postures from an array, and back.
    Load,
    Store,
    /// One number in every lane.
    Splat,
    /// The numbers of one posture among many, and back.
    Gather,
    Scatter,
    /// The same in every lane.
    SincosLanes,
    /// Two angles less quarter turns in every lane, and the sines and cosines of those.
    ReduceBoth,
    SincosBoth,
    ClampLanes,
    PowerLanes,
}

impl Helper {
    /// What its own body calls.
    fn calls(self, scalar: Scalar) -> &'static [Helper] {
        match (self, scalar) {
            (Helper::Sincos, Scalar::Fixed32) => &[Helper::Lookup, Helper::Narrow],
            (Helper::Turn, _) => &[Helper::Sincos],
            (Helper::ClampLanes, _) => &[Helper::Splat],
            _ => &[],
        }
    }
}

/// Spells calls, and keeps which helpers were called.
#[derive(Debug)]
pub(super) struct Calls<'n> {
    /// What names begin with.
    prefix: &'n str,
    called: RefCell<BTreeSet<Helper>>,
}

impl<'n> Calls<'n> {
    pub(super) fn new(prefix: &'n str) -> Calls<'n> {
        Calls {
            prefix,
            called: RefCell::default(),
        }
    }

    /// `PREFIX_word`
    pub(super) fn named(&self, word: impl Display) -> String {
        format!("{}_{word}", self.prefix)
    }

    /// A template calls it.
    pub(super) fn needs(&self, helper: Helper) {
        self.called.borrow_mut().insert(helper);
    }

    /// `PREFIX_helper(arguments)`
    pub(super) fn call(&self, helper: Helper, arguments: &str) -> String {
        self.needs(helper);
        format!("{}({arguments})", self.named(Value::from(Serde(helper))))
    }

    /// The helpers called so far and those that they call, as the templates ask for them.
    pub(super) fn texts(&self, scalar: Scalar) -> Value {
        let called = self.called.borrow();
        let more = called.iter().flat_map(|helper| helper.calls(scalar));
        let all: BTreeSet<Helper> = called.iter().chain(more).copied().collect();
        let (format, bits, suffix) = match scalar {
            Scalar::F64 => ("f64", "uint64_t", ""),
            Scalar::F32 => ("f32", "uint32_t", "f"),
            Scalar::Fixed32 => ("fixed", "", ""),
        };
        context! {
            called => Value::from(Serde(all)),
            format,
            bits,
            suffix,
            // The type that sines are computed in, and what ends the names for it.
            of => scalar.c_type(),
            lanes => "",
        }
    }
}
