//! CoM, Jacobian and rows: one posture, batches, the tape.

use std::hint::black_box;
use std::time::Duration;

use sesc_identify::simulate::Simulator;
use sesc_model::Function;

use crate::ours::{self, One};
use crate::peers::{Answer, Batch, Peers, contestants};
use crate::turns::{Entry, Found, compare};

/// Postures of a batch: its rows stay in the second cache. Of 512, all columns of our C would meet
/// in the same lines of the first.
pub const POSTURES: usize = 528;
/// Where arrays of our C begin, bytes: a line of the cache, as our Rust's do.
const LINE: usize = 64;
/// Answers may differ by this much, m (and m/rad).
const AGREE_F64: f64 = 1e-9;
const AGREE_F32: f64 = 2e-5;

pub const FUNCTIONS: [(Function, &str); 4] = [
    (Function::Com, "CoM"),
    (Function::ComJacobian, "Jacobian 3×20"),
    (Function::RegressorFull, "full rows 3×60"),
    (Function::RegressorCop, "CoP rows 2×42"),
];

/// How a function is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mode {
    One,
    BatchF64,
    BatchF32,
    Tape,
}

pub const MODES: [(Mode, &str); 4] = [
    (Mode::One, "one posture, f64"),
    (Mode::BatchF64, "batch, f64"),
    (Mode::BatchF32, "batch, f32"),
    (Mode::Tape, "batch, f64, our tape"),
];

/// Where postures are drawn from.
pub struct Range {
    pub name: &'static str,
    q: Vec<f64>,
    q32: Vec<f32>,
    peers: Vec<f64>,
    peers32: Vec<f32>,
}

impl Range {
    /// The limits of the URDF, or those of `limits` (joint, lower, upper; rad).
    pub fn new(name: &'static str, peers: &Peers, limits: Option<&str>) -> Result<Range, String> {
        let mut dofs = ours::model().tree.dofs.clone();
        for line in limits.unwrap_or("").lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let [joint, lower, upper] = words[..] else {
                return Err(format!("limits.txt: cannot read `{line}`"));
            };
            let place = ours::JOINT_NAMES.iter().position(|name| *name == joint);
            let place = place.ok_or_else(|| format!("limits.txt: no joint {joint}"))?;
            let number = |text: &str| text.parse().map_err(|_| format!("limits.txt: `{line}`"));
            (dofs[place].lower, dofs[place].upper) = (number(lower)?, number(upper)?);
        }
        let q = Simulator::new(&dofs, None, 1).batch(POSTURES);
        let q32: Vec<f32> = q.iter().map(|x| *x as f32).collect();
        Ok(Range {
            name,
            peers: peers.reordered(&q),
            peers32: peers.reordered(&q32),
            q,
            q32,
        })
    }
}

/// Values that our function writes per posture.
fn width(function: Function) -> usize {
    match function {
        Function::Com => 3,
        Function::ComJacobian => 3 * ours::DOF,
        Function::RegressorFull => 3 * 63,
        _ => 2 * 43,
    }
}

/// A loop of calls, each result on the place of the last: what a controller does.
fn one<'a>(name: &str, f: One<f64>, q: &'a [f64], width: usize) -> Entry<'a> {
    let mut out = vec![0.0; width];
    Entry::new(name, move || {
        for q in q.chunks_exact(ours::DOF) {
            f(q.as_ptr(), out.as_mut_ptr());
            black_box(&mut out);
        }
    })
}

/// One call, all results kept.
fn batch<'a, T: Copy + 'a>(
    name: &str,
    f: Batch<T>,
    q: &'a [T],
    width: usize,
    zero: T,
) -> Entry<'a> {
    let mut out = vec![zero; width * POSTURES];
    Entry::new(name, move || {
        f(q.as_ptr(), POSTURES, out.as_mut_ptr());
        black_box(&mut out);
    })
}

/// Ours on blocks: the layout is the batch's own, on both sides.
fn blocks<'a>(mut batches: Box<dyn ours::Batches>) -> Entry<'a> {
    Entry::new("ours", move || batches.run())
}

fn answers(mut batches: Box<dyn ours::Batches>) -> Vec<f64> {
    batches.run();
    batches.answers()
}

/// Ours first, then every peer that has the function; answers are compared first.
pub fn measure(
    peers: &Peers,
    range: &Range,
    function: Function,
    mode: Mode,
    rounds: usize,
    slot: Duration,
) -> Result<Vec<Found>, String> {
    let width = width(function);
    let tape = ours::tape(function);
    let mut out = vec![0.0; width * POSTURES];
    let mut entries = vec![match mode {
        Mode::One => one("ours", ours::one(function), &range.q, width),
        Mode::BatchF64 => blocks(ours::batch_f64(function, &range.q)),
        Mode::BatchF32 => blocks(ours::batch_f32(function, &range.q32)),
        Mode::Tape => Entry::new("ours", || {
            tape(&range.q, &mut out);
            black_box(&mut out);
        }),
    }];
    ours_agrees(range, function, mode)?;
    for &(name, symbol, answer) in contestants(function) {
        let len = answer.len();
        let entry = match mode {
            Mode::One => {
                let Some(f) = peers.maybe::<One<f64>>(symbol) else {
                    continue;
                };
                agrees(
                    peers,
                    range,
                    name,
                    answer,
                    &each(f, &range.peers, len),
                    AGREE_F64,
                )?;
                one(name, f, &range.peers, len)
            }
            Mode::BatchF64 | Mode::Tape => {
                let Some(f) = peers.maybe::<Batch<f64>>(&format!("{symbol}_batch")) else {
                    continue;
                };
                let mut out = vec![0.0; len * POSTURES];
                f(range.peers.as_ptr(), POSTURES, out.as_mut_ptr());
                agrees(peers, range, name, answer, &out, AGREE_F64)?;
                batch(name, f, &range.peers, len, 0.0)
            }
            Mode::BatchF32 => {
                let Some(f) = peers.maybe::<Batch<f32>>(&format!("{symbol}_batch_f32")) else {
                    continue;
                };
                let mut out = vec![0.0f32; len * POSTURES];
                f(range.peers32.as_ptr(), POSTURES, out.as_mut_ptr());
                agrees(peers, range, name, answer, &wide(&out), AGREE_F32)?;
                batch(name, f, &range.peers32, len, 0.0)
            }
        };
        entries.push(entry);
    }
    let symbol = match function {
        Function::Com => "lanes_com_batch",
        Function::ComJacobian => "lanes_jacobian_batch",
        Function::RegressorFull => "lanes_full_batch",
        _ => "lanes_cop_batch",
    };
    match mode {
        Mode::BatchF64 => entries.push(columns(symbol, peers, &range.q, range, function, 0.0)?),
        Mode::BatchF32 => {
            let symbol = format!("{symbol}_f32");
            entries.push(columns(&symbol, peers, &range.q32, range, function, 0.0)?);
        }
        Mode::One | Mode::Tape => {}
    }
    Ok(compare(entries, rounds, slot))
}

/// Our C: entry k of posture i stands at k n + i, in postures and results.
fn columns<'a, T: Copy + Into<f64> + 'a>(
    symbol: &str,
    peers: &Peers,
    q: &[T],
    range: &Range,
    function: Function,
    zero: T,
) -> Result<Entry<'a>, String> {
    let f = peers.symbol::<Batch<T>>(symbol)?;
    let (mut from, at) = aligned(ours::DOF * POSTURES, zero);
    for (i, q) in q.chunks(ours::DOF).enumerate() {
        for (j, q) in q.iter().enumerate() {
            from[at + j * POSTURES + i] = *q;
        }
    }
    let width = width(function);
    let (mut out, to) = aligned(width * POSTURES, zero);
    f(from[at..].as_ptr(), POSTURES, out[to..].as_mut_ptr());
    let single = each(ours::one(function), &range.q, width);
    let columns: Vec<&[T]> = out[to..].chunks(POSTURES).take(width).collect();
    let rows: Vec<f64> = (0..POSTURES)
        .flat_map(|i| columns.iter().map(move |column| column[i].into()))
        .collect();
    let tolerance = match size_of::<T>() {
        4 => AGREE_F32,
        _ => AGREE_F64,
    };
    let apart = largest(&rows, &single);
    if apart.is_nan() || apart > tolerance {
        return Err(format!("our C and our Rust differ by {apart:.1e} in {function:?}"));
    }
    Ok(Entry::new("our C", move || {
        f(from[at..].as_ptr(), POSTURES, out[to..].as_mut_ptr());
        black_box(&mut out);
    }))
}

/// Room for `len` numbers that begin at a line of the cache, and where that is.
fn aligned<T: Copy>(len: usize, zero: T) -> (Vec<T>, usize) {
    let room = vec![zero; len + LINE / size_of::<T>()];
    let start = room.as_ptr().align_offset(LINE);
    (room, start)
}

fn each(f: One<f64>, q: &[f64], width: usize) -> Vec<f64> {
    let mut out = vec![0.0; width * POSTURES];
    for (q, out) in q.chunks_exact(ours::DOF).zip(out.chunks_exact_mut(width)) {
        f(q.as_ptr(), out.as_mut_ptr());
    }
    out
}

fn wide(values: &[f32]) -> Vec<f64> {
    values.iter().map(|x| f64::from(*x)).collect()
}

/// A peer's answers against our function's.
fn agrees(
    peers: &Peers,
    range: &Range,
    name: &str,
    answer: Answer,
    out: &[f64],
    tolerance: f64,
) -> Result<(), String> {
    for (q, out) in range.q.chunks(ours::DOF).zip(out.chunks(answer.len())) {
        let difference = largest(&peers.meaning(answer, out), &Peers::expected(answer, q));
        if difference.is_nan() || difference > tolerance {
            return Err(format!(
                "{name} and ours differ by {difference:.1e} m in {answer:?}; {tolerance:e} is allowed"
            ));
        }
    }
    Ok(())
}

/// Our batches and the tape against our function of one posture; its rows times the
/// parameters against the CoM.
fn ours_agrees(range: &Range, function: Function, mode: Mode) -> Result<(), String> {
    let width = width(function);
    let single = each(ours::one(function), &range.q, width);
    let (out, tolerance) = match mode {
        Mode::One => (single.clone(), AGREE_F64),
        Mode::BatchF64 => (answers(ours::batch_f64(function, &range.q)), AGREE_F64),
        Mode::BatchF32 => (answers(ours::batch_f32(function, &range.q32)), AGREE_F32),
        Mode::Tape => {
            let mut out = vec![0.0; width * POSTURES];
            ours::tape(function)(&range.q, &mut out);
            (out, AGREE_F64)
        }
    };
    let params = match function {
        Function::RegressorFull => Some((3, ours::full_params())),
        Function::RegressorCop => Some((2, ours::base_params())),
        _ => None,
    };
    let mut worst = largest(&out, &single);
    if let Some((rows, params)) = params {
        for (q, matrix) in range.q.chunks(ours::DOF).zip(single.chunks(width)) {
            let com = Peers::expected(Answer::Com, q);
            let product = matrix.chunks(width / rows).map(|row| {
                let terms = row.iter().zip(&params).map(|(x, r)| x * r);
                terms.sum::<f64>()
            });
            worst = worst.max(largest(&product.collect::<Vec<f64>>(), &com[..rows]));
        }
    }
    if worst.is_nan() || worst > tolerance {
        return Err(format!(
            "our own answers differ by {worst:.1e} in {function:?}"
        ));
    }
    Ok(())
}

/// The largest difference; NaN if there is one.
pub fn largest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "answers of one length");
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    // By total order, in which NaN comes last.
    differences.max_by(f64::total_cmp).unwrap_or(0.0)
}
