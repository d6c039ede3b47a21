//! Static helpers that statements call; a source file holds those and no other.

use std::cell::RefCell;
use std::collections::BTreeSet;

use minijinja::{Value, context};

use super::Scalar;

/// A function that the source file keeps to itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
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
    /// Its name after the prefix.
    fn name(self) -> &'static str {
        match self {
            Helper::Sincos => "sincos",
            Helper::Turn => "turn",
            Helper::Lookup => "lookup",
            Helper::Narrow => "narrow",
            Helper::ShiftUp => "shift_up",
            Helper::Add => "add",
            Helper::Subtract => "subtract",
            Helper::Clamp => "clamp",
            Helper::Power => "power",
            Helper::Larger => "larger",
            Helper::LargerLanes => "larger_lanes",
            Helper::Load => "load",
            Helper::Store => "store",
            Helper::Splat => "splat",
            Helper::Gather => "gather",
            Helper::Scatter => "scatter",
            Helper::SincosLanes => "sincos_lanes",
            Helper::ReduceBoth => "reduce_both",
            Helper::SincosBoth => "sincos_both",
            Helper::ClampLanes => "clamp_lanes",
            Helper::PowerLanes => "power_lanes",
        }
    }

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
    pub(super) fn named(&self, word: &str) -> String {
        format!("{}_{word}", self.prefix)
    }

    /// `PREFIX_helper(arguments)`
    pub(super) fn call(&self, helper: Helper, arguments: &str) -> String {
        self.called.borrow_mut().insert(helper);
        format!("{}_{}({arguments})", self.prefix, helper.name())
    }

    /// The helpers called so far and those that they call, as the templates ask for them.
    pub(super) fn texts(&self, scalar: Scalar) -> Value {
        let called = self.called.borrow();
        let more = called.iter().flat_map(|helper| helper.calls(scalar));
        let all: BTreeSet<Helper> = called.iter().chain(more).copied().collect();
        let has = |helper| all.contains(&helper);
        let (of, bits, suffix) = match scalar {
            Scalar::F64 => ("f64", "uint64_t", ""),
            Scalar::F32 => ("f32", "uint32_t", "f"),
            Scalar::Fixed32 => ("fixed", "", ""),
        };
        let template = |of_what: &str| format!("{of_what}_{of}.c");
        context! {
            has_kernel => has(Helper::Sincos),
            has_turn => has(Helper::Turn),
            has_table => has(Helper::Lookup),
            has_narrow => has(Helper::Narrow),
            has_shift_up => has(Helper::ShiftUp),
            has_add => has(Helper::Add),
            has_subtract => has(Helper::Subtract),
            has_clamp => has(Helper::Clamp),
            has_power => has(Helper::Power),
            has_larger => has(Helper::Larger),
            has_larger_lanes => has(Helper::LargerLanes),
            has_load => has(Helper::Load),
            has_store => has(Helper::Store),
            has_splat => has(Helper::Splat),
            has_gather => has(Helper::Gather),
            has_scatter => has(Helper::Scatter),
            has_sincos_lanes => has(Helper::SincosLanes),
            has_both_lanes => has(Helper::SincosBoth),
            has_clamp_lanes => has(Helper::ClampLanes),
            has_power_lanes => has(Helper::PowerLanes),
            kernel => template("kernel"),
            steps => template("steps"),
            reduction => template("reduction"),
            series => template("series"),
            // The type that sines are computed in, and what ends the names for it.
            of => scalar.c_type(),
            lanes => "",
            clamp => match scalar {
                Scalar::Fixed32 => "clamp_fixed.c",
                Scalar::F64 | Scalar::F32 => "clamp.c",
            },
            power => template("power"),
            bits,
            suffix,
        }
    }
}
