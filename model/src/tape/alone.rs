//! One posture: number by number, its sines and cosines eight at a time.
//!
//! ```text
//! program ─▶ angles ─▶ sines, cosines ─▶ everything else
//! ```

use std::ops::Range;
use std::sync::Mutex;

use super::products::Steps;
use super::sources::{RegisterFill, inputs};
use super::step::{Operation, Step, larger};
use super::{Kernels, SHORT, Values};
use crate::program::Program;

/// Every place that 16 bits can name: an array of as many values is read at any of them without
/// a look at its length. Pages of memory that no place is on are never touched.
const PLACES: usize = 1 << 16;

/// Steps of one kind, one after the other.
#[derive(Debug, Clone)]
enum Run {
    /// `to`, x, y and w in 16 bits each, from the lowest: z = x y + w. One word is read for the
    /// four of them.
    Products(Vec<u64>),
    /// The same of programs with more values.
    WideProducts(Vec<[u32; 4]>),
    /// `[to, a, b]`
    Others(Operation, Vec<[u32; 3]>),
}

/// The steps of a program for one posture.
#[derive(Debug)]
pub(super) struct Alone {
    /// Angles that no sine is part of.
    angles: Vec<Run>,
    /// Sines and cosines of those.
    sines: Vec<[u32; 3]>,
    rest: Vec<Run>,
    /// Constants in their places, zero elsewhere.
    initial: Vec<f64>,
    /// What the last call left, with room for all [`PLACES`], empty before the first: constants
    /// are in theirs, and everything else is written before it is read. Calls at the same time
    /// have copies of `initial`.
    used: Mutex<Vec<f64>>,
    /// The places that the values of each argument go to.
    inputs: Vec<Range<usize>>,
    outputs: Vec<u32>,
}

impl Alone {
    pub(super) fn new(program: &Program, sources: &[RegisterFill]) -> Alone {
        let steps = Steps::new(program, sources);
        let [angles, sines, rest] = steps.parts;
        let is_near = steps.initial.len() <= PLACES;
        Alone {
            angles: runs(&angles, is_near),
            sines: sines.iter().filter_map(other).map(|(_, p)| p).collect(),
            rest: runs(&rest, is_near),
            used: Mutex::default(),
            initial: steps.initial,
            inputs: inputs(program),
            outputs: steps.outputs.iter().map(|k| place(*k)).collect(),
        }
    }

    /// Evaluate into `out`, with the bits of a block.
    pub(super) fn run(&self, arguments: &[Values], out: &mut [f64], kernels: Kernels) {
        match self.used.try_lock() {
            Ok(mut values) => {
                if values.is_empty() {
                    *values = roomy(&self.initial);
                }
                self.run_in(&mut values, arguments, out, kernels);
            }
            Err(_) => self.run_in(&mut self.initial.clone(), arguments, out, kernels),
        }
    }

    fn run_in(&self, values: &mut [f64], arguments: &[Values], out: &mut [f64], kernels: Kernels) {
        for (places, argument) in self.inputs.iter().zip(arguments) {
            let (Values::PerPosture(given) | Values::Shared(given)) = argument;
            values[places.clone()].copy_from_slice(&given[..places.len()]);
        }
        for run in &self.angles {
            run.on(values, kernels);
        }
        for some in self.sines.chunks(SHORT) {
            sin_cos(some, values, kernels);
        }
        for run in &self.rest {
            run.on(values, kernels);
        }
        for (to, place) in out.iter_mut().zip(&self.outputs) {
            *to = values[*place as usize];
        }
    }
}

impl Clone for Alone {
    fn clone(&self) -> Alone {
        Alone {
            angles: self.angles.clone(),
            sines: self.sines.clone(),
            rest: self.rest.clone(),
            initial: self.initial.clone(),
            used: Mutex::default(),
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
        }
    }
}

/// The same values with room for every place that 16 bits can name.
fn roomy(initial: &[f64]) -> Vec<f64> {
    let mut values = vec![0.0; PLACES.max(initial.len())];
    values[..initial.len()].copy_from_slice(initial);
    values
}

/// A place in 32 bits: half the memory of steps that are walked once a call.
fn place(k: usize) -> u32 {
    u32::try_from(k).expect("fewer than 2^32 values")
}

fn other(step: &Step) -> Option<(Operation, [u32; 3])> {
    match *step {
        Step::Other(operation, places) => Some((operation, places.map(place))),
        Step::Product(_) => None,
    }
}

fn runs(steps: &[Step], is_near: bool) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for step in steps {
        match (runs.last_mut(), *step) {
            (Some(Run::Products(all)), Step::Product(places)) => all.push(near(places)),
            (Some(Run::WideProducts(all)), Step::Product(places)) => all.push(places.map(place)),
            (Some(Run::Others(last, all)), Step::Other(own, places)) if *last == own => {
                all.push(places.map(place));
            }
            (_, Step::Product(places)) if is_near => runs.push(Run::Products(vec![near(places)])),
            (_, Step::Product(places)) => runs.push(Run::WideProducts(vec![places.map(place)])),
            (_, Step::Other(own, places)) => {
                runs.push(Run::Others(own, vec![places.map(place)]));
            }
        }
    }
    runs
}

/// Places in 16 bits each, the first in the lowest.
fn near(places: [usize; 4]) -> u64 {
    let places = places.map(|k| u16::try_from(k).expect("fewer than 2^16 values"));
    let packed = places.iter().rev();
    packed.fold(0, |word, &k| word << 16 | u64::from(k))
}

/// The same four again.
#[inline(always)]
fn places(word: u64) -> [usize; 4] {
    [word, word >> 16, word >> 32, word >> 48].map(|k| usize::from(k as u16))
}

impl Run {
    fn on(&self, values: &mut [f64], kernels: Kernels) {
        match self {
            Run::Products(all) => match <&mut [f64; PLACES]>::try_from(&mut *values) {
                Ok(values) => products_anywhere(all, values),
                Err(_) => products(all, values, |word| places(*word)),
            },
            Run::WideProducts(all) => products(all, values, |four| four.map(|k| k as usize)),
            Run::Others(Operation::Div, all) => each(all, values, |x, y| x / y),
            Run::Others(Operation::Clamp, all) => each(all, values, |x, _| x.clamp(-1.0, 1.0)),
            Run::Others(Operation::Max, all) => each(all, values, larger),
            Run::Others(Operation::Pow, all) => each(all, values, |x, y| {
                let mut power = [0.0; SHORT];
                (kernels.power)(&[x; SHORT], &[y; SHORT], &mut power);
                power[0]
            }),
            // Each may be an angle made of the sine before.
            Run::Others(Operation::SinCos, all) => {
                for one in all.chunks(1) {
                    sin_cos(one, values, kernels);
                }
            }
        }
    }
}

/// Steps that are written out one after the other in a turn of the loop.
const AT_ONCE: usize = 4;

/// The same where any 16 bits are a place: no step has to compare four of them with the number of
/// values.
fn products_anywhere(all: &[u64], values: &mut [f64; PLACES]) {
    let mut step = |word: &u64| {
        let [to, x, y, w] = places(*word);
        values[to] = values[x] * values[y] + values[w];
    };
    let (turns, rest) = all.as_chunks::<AT_ONCE>();
    for turn in turns {
        turn.iter().for_each(&mut step);
    }
    rest.iter().for_each(step);
}

#[inline(always)]
fn products<P>(all: &[P], values: &mut [f64], places: impl Fn(&P) -> [usize; 4]) {
    for four in all {
        let [to, x, y, w] = places(four);
        // Rounded twice: no fused operation, which would have other bits.
        values[to] = values[x] * values[y] + values[w];
    }
}

#[inline(always)]
fn each(all: &[[u32; 3]], values: &mut [f64], f: impl Fn(f64, f64) -> f64) {
    for places in all {
        let [to, a, b] = places.map(|k| k as usize);
        values[to] = f(values[a], values[b]);
    }
}

/// Sines and cosines of up to [`SHORT`] angles.
fn sin_cos(places: &[[u32; 3]], values: &mut [f64], kernels: Kernels) {
    let (mut angles, mut sines, mut cosines) = ([0.0; SHORT], [0.0; SHORT], [0.0; SHORT]);
    for (angle, [_, a, _]) in angles.iter_mut().zip(places) {
        *angle = values[*a as usize];
    }
    (kernels.sin_cos)(&angles, &mut sines, &mut cosines);
    for (([to, _, also], sine), cosine) in places.iter().zip(sines).zip(cosines) {
        values[*to as usize] = sine;
        values[*also as usize] = cosine;
    }
}
