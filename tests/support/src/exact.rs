//! Programs run by other arithmetic than the tape's: in `f32`, and in pairs of
//! doubles, beside which the rounding of a double shows.
//!
//! ```text
//! x = high + low      |low| <= ulp(high) / 2      relative error about 2^-104
//! ```

use std::collections::HashMap;
use std::sync::LazyLock;

use sesc_model::expr::Expr;
use sesc_model::program::Program;

/// What a program can be run in.
pub trait Number: Copy {
    /// The nearest number to `x`.
    fn of(x: f64) -> Self;
    /// self + other.
    fn add(self, other: Self) -> Self;
    /// self − other.
    fn sub(self, other: Self) -> Self;
    /// self · other.
    fn mul(self, other: Self) -> Self;
    /// self / other.
    fn div(self, other: Self) -> Self;
    /// −self.
    fn neg(self) -> Self;
    /// Sine and cosine of an angle, rad.
    fn sin_cos(self) -> (Self, Self);
    /// The nearest number in [-1, 1].
    fn clamp(self) -> Self;
    /// The larger of both.
    fn larger(self, other: Self) -> Self;
    /// To the power of `exponent`, for what is not negative.
    fn power(self, exponent: Self) -> Self;
}

impl Number for f32 {
    fn of(x: f64) -> f32 {
        x as f32
    }
    fn add(self, other: f32) -> f32 {
        self + other
    }
    fn sub(self, other: f32) -> f32 {
        self - other
    }
    fn mul(self, other: f32) -> f32 {
        self * other
    }
    fn div(self, other: f32) -> f32 {
        self / other
    }
    fn neg(self) -> f32 {
        -self
    }
    fn sin_cos(self) -> (f32, f32) {
        sesc_runtime::trig::sin_cos_f32(self)
    }
    fn clamp(self) -> f32 {
        f32::clamp(self, -1.0, 1.0)
    }
    fn larger(self, other: f32) -> f32 {
        sesc_runtime::Real::larger(self, other)
    }
    fn power(self, exponent: f32) -> f32 {
        sesc_runtime::power::power_f32(self, exponent)
    }
}

/// A program with operands by place.
pub struct Interpreter {
    steps: Vec<Step>,
    outputs: Vec<usize>,
}

#[derive(Clone, Copy)]
enum Step {
    Const(f64),
    Load(usize, usize),
    Add(usize, usize),
    Sub(usize, usize),
    Mul(usize, usize),
    Div(usize, usize),
    Neg(usize),
    Sin(usize),
    Cos(usize),
    Clamp(usize),
    Pow(usize, usize),
    Max(usize, usize),
}

impl Interpreter {
    /// An interpreter of the operations of `program`.
    pub fn new(program: &Program) -> Interpreter {
        let places: HashMap<_, usize> = program
            .iter()
            .enumerate()
            .map(|(k, (id, _))| (id, k))
            .collect();
        let step = |expr: Expr| match expr {
            Expr::Const(x) => Step::Const(x),
            Expr::Input { argument, index } => Step::Load(program.slot(argument), index as usize),
            Expr::Add(a, b) => Step::Add(places[&a], places[&b]),
            Expr::Sub(a, b) => Step::Sub(places[&a], places[&b]),
            Expr::Mul(a, b) => Step::Mul(places[&a], places[&b]),
            Expr::Div(a, b) => Step::Div(places[&a], places[&b]),
            Expr::Neg(a) => Step::Neg(places[&a]),
            Expr::Sin(a) => Step::Sin(places[&a]),
            Expr::Cos(a) => Step::Cos(places[&a]),
            Expr::Clamp(a) => Step::Clamp(places[&a]),
            Expr::Pow(a, b) => Step::Pow(places[&a], places[&b]),
            Expr::Max(a, b) => Step::Max(places[&a], places[&b]),
        };
        Interpreter {
            steps: program.nodes.iter().map(|node| step(node.expr)).collect(),
            outputs: program.outputs.iter().map(|id| places[id]).collect(),
        }
    }

    /// The results for one set of input arrays.
    pub fn run<T: Number>(&self, inputs: &[&[T]]) -> Vec<T> {
        let mut values: Vec<T> = Vec::with_capacity(self.steps.len());
        // Sine and cosine of an angle come together.
        let mut pairs: HashMap<usize, (T, T)> = HashMap::new();
        for step in &self.steps {
            let value = match *step {
                Step::Const(x) => T::of(x),
                Step::Load(array, index) => inputs[array][index],
                Step::Add(a, b) => values[a].add(values[b]),
                Step::Sub(a, b) => values[a].sub(values[b]),
                Step::Mul(a, b) => values[a].mul(values[b]),
                Step::Div(a, b) => values[a].div(values[b]),
                Step::Neg(a) => values[a].neg(),
                Step::Clamp(a) => values[a].clamp(),
                Step::Pow(a, b) => values[a].power(values[b]),
                Step::Max(a, b) => values[a].larger(values[b]),
                Step::Sin(a) => pairs.entry(a).or_insert_with(|| values[a].sin_cos()).0,
                Step::Cos(a) => pairs.entry(a).or_insert_with(|| values[a].sin_cos()).1,
            };
            values.push(value);
        }
        self.outputs.iter().map(|&k| values[k]).collect()
    }
}

/// An unevaluated sum of two doubles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Double {
    /// The nearest `f64`.
    pub high: f64,
    /// What it leaves.
    pub low: f64,
}

/// a + b and what rounding lost of it.
fn two_sum(a: f64, b: f64) -> Double {
    let high = a + b;
    let part = high - a;
    let low = (a - (high - part)) + (b - part);
    Double { high, low }
}

/// The same where |a| >= |b|.
fn quick_sum(a: f64, b: f64) -> Double {
    let high = a + b;
    Double {
        high,
        low: b - (high - a),
    }
}

fn two_product(a: f64, b: f64) -> Double {
    let high = a * b;
    Double {
        high,
        low: a.mul_add(b, -high),
    }
}

impl Double {
    /// self / divisor.
    pub fn over(self, divisor: f64) -> Double {
        let high = self.high / divisor;
        let rest = self.sub(two_product(high, divisor));
        quick_sum(high, (rest.high + rest.low) / divisor)
    }

    /// |self − x|.
    pub fn distance(self, x: f64) -> f64 {
        let difference = self.sub(Double::of(x));
        (difference.high + difference.low).abs()
    }
}

/// ln 2 in two doubles.
const LN_2: Double = Double {
    high: std::f64::consts::LN_2,
    low: 2.319_046_813_846_299_6e-17,
};

impl Double {
    /// e^self: a whole power of two, and a series on a sixteenth of the rest.
    fn exp(self) -> Double {
        let k = (self.high / LN_2.high).round();
        let rest = self.sub(LN_2.mul(Double::of(k)));
        let part = Double {
            high: rest.high / 16.0,
            low: rest.low / 16.0,
        };
        let inverse = INVERSE_FACTORIALS[..20].iter().rev();
        let series = inverse.fold(Double::of(0.0), |sum, c| sum.mul(part).add(*c));
        let power = (0..4).fold(series, |x, _| x.mul(x));
        let scale = k.exp2();
        Double {
            high: power.high * scale,
            low: power.low * scale,
        }
    }

    /// ln self, by Newton's rule on the exponential, which doubles the digits.
    fn ln(self) -> Double {
        let mut found = Double::of(self.high.ln());
        for _ in 0..2 {
            let ratio = self.mul(found.neg().exp());
            found = found.add(ratio.sub(Double::of(1.0)));
        }
        found
    }
}

/// π/2 in three doubles.
const RIGHT_ANGLE: [f64; 3] = [
    std::f64::consts::FRAC_PI_2,
    6.123233995736766e-17,
    -1.4973849048591833e-33,
];

/// 1/n! up to 29!, beyond which powers of π/4 vanish.
static INVERSE_FACTORIALS: LazyLock<Vec<Double>> = LazyLock::new(|| {
    let mut all = vec![Double::of(1.0)];
    for n in 1..=29 {
        all.push(all[n - 1].over(n as f64));
    }
    all
});

/// Σ r^n/n! over n = first, first + 2, …, with alternating signs.
fn series(square: Double, first: usize) -> Double {
    let minus = square.neg();
    (first..=29)
        .step_by(2)
        .collect::<Vec<_>>()
        .iter()
        .rev()
        .fold(Double::of(0.0), |sum, &n| {
            sum.mul(minus).add(INVERSE_FACTORIALS[n])
        })
}

impl Number for Double {
    fn of(x: f64) -> Double {
        Double { high: x, low: 0.0 }
    }

    fn add(self, other: Double) -> Double {
        let high = two_sum(self.high, other.high);
        let low = two_sum(self.low, other.low);
        let sum = quick_sum(high.high, high.low + low.high);
        quick_sum(sum.high, sum.low + low.low)
    }

    fn sub(self, other: Double) -> Double {
        self.add(other.neg())
    }

    fn mul(self, other: Double) -> Double {
        let product = two_product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        quick_sum(product.high, product.low + cross)
    }

    fn div(self, other: Double) -> Double {
        // Two digits of the quotient and a third for what they leave.
        let first = self.high / other.high;
        let rest = self.sub(other.mul(Double::of(first)));
        let second = rest.high / other.high;
        let rest = rest.sub(other.mul(Double::of(second)));
        quick_sum(first, second).add(Double::of(rest.high / other.high))
    }

    fn clamp(self) -> Double {
        match self.high {
            x if x > 1.0 || (x == 1.0 && self.low > 0.0) => Double::of(1.0),
            x if x < -1.0 || (x == -1.0 && self.low < 0.0) => Double::of(-1.0),
            _ => self,
        }
    }

    fn larger(self, other: Double) -> Double {
        match (self.high, self.low) < (other.high, other.low) {
            true => other,
            false => self,
        }
    }

    fn power(self, exponent: Double) -> Double {
        match self.high == 0.0 || exponent.high == 0.0 {
            true => Double::of(self.high.powf(exponent.high)),
            false => self.ln().mul(exponent).exp(),
        }
    }

    fn neg(self) -> Double {
        Double {
            high: -self.high,
            low: -self.low,
        }
    }

    fn sin_cos(self) -> (Double, Double) {
        let k = (self.high / RIGHT_ANGLE[0]).round();
        let r = RIGHT_ANGLE
            .iter()
            .fold(self, |rest, piece| rest.sub(two_product(k, *piece)));
        let square = r.mul(r);
        let (s, c) = (series(square, 1).mul(r), series(square, 0));
        match k.rem_euclid(4.0) as u8 {
            0 => (s, c),
            1 => (c, s.neg()),
            2 => (s.neg(), c.neg()),
            _ => (c.neg(), s),
        }
    }
}
