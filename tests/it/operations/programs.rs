//! Programs made by hand: what effects will ask of quotients, clamps, powers and maxima.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_model::bounds::Input;
use sesc_model::expr::{Argument, Graph, Id};
use sesc_model::program::{Array, Program, Shape};

/// A program of the arrays x (`q`) and y (`r`), with the ranges of what they hold.
pub(super) struct Case {
    pub name: &'static str,
    pub program: Program,
    /// ∂ outputs / ∂ x[0], ∂ x[1], …
    pub derivatives: Vec<Program>,
    pub ranges: [Vec<[f64; 2]>; 2],
}

/// Corners of the foot, m.
const CELLS: [[f64; 2]; 4] = [
    [0.041, 0.025],
    [0.041, -0.025],
    [-0.041, -0.025],
    [-0.041, 0.025],
];

impl Case {
    fn new(
        name: &'static str,
        ranges: [Vec<[f64; 2]>; 2],
        build: impl Fn(&mut Graph, &[Id], &[Id]) -> Vec<Id>,
    ) -> Case {
        let program = |of: Option<usize>| {
            let mut g = Graph::default();
            let x: Vec<Id> = (0..ranges[0].len())
                .map(|k| g.input(Argument::Positions, k))
                .collect();
            let y: Vec<Id> = (0..ranges[1].len())
                .map(|k| g.input(Argument::Parameters, k))
                .collect();
            let mut outputs = build(&mut g, &x, &y);
            if let Some(k) = of {
                outputs = g.derivative(&outputs, x[k]);
            }
            let inputs = vec![
                Array::new(Argument::Positions, ranges[0].len()),
                Array::new(Argument::Parameters, ranges[1].len()),
            ];
            Program::new(g, inputs, Shape::Vector(outputs.len()), &outputs)
        };
        Case {
            name,
            program: program(None),
            derivatives: (0..ranges[0].len()).map(|k| program(Some(k))).collect(),
            ranges,
        }
    }

    pub(super) fn inputs(&self) -> [Vec<Input>; 2] {
        let exact = |[lower, upper]: &[f64; 2]| Input::exact(*lower, *upper);
        [0, 1].map(|k| self.ranges[k].iter().map(exact).collect())
    }

    /// Random rows of x and y, numbers of an `f32`.
    pub(super) fn rows(&self, count: usize) -> Vec<[Vec<f64>; 2]> {
        let mut rng = ChaCha8Rng::seed_from_u64(31);
        let mut draw = |[lower, upper]: &[f64; 2]| {
            let x = lower + rng.random::<f64>() * (upper - lower);
            f64::from(x as f32)
        };
        (0..count)
            .map(|_| [0, 1].map(|k| self.ranges[k].iter().map(&mut draw).collect()))
            .collect()
    }
}

/// The gains `g`, exponent and saturation of four cells; the mean of their places.
fn weighed(g: &mut Graph, loads: &[Id], gains: &[Id]) -> Vec<Id> {
    let zero = g.constant(0.0);
    let (mut moments, mut sum) = ([zero; 2], zero);
    for ((load, gain), place) in loads.iter().zip(gains).zip(CELLS) {
        let term = g.mul(*load, *gain);
        sum = g.add(sum, term);
        for (moment, at) in moments.iter_mut().zip(place) {
            let at = g.constant(at);
            let part = g.mul(at, term);
            *moment = g.add(*moment, part);
        }
    }
    moments.map(|moment| g.div(moment, sum)).to_vec()
}

pub(super) fn cases() -> Vec<Case> {
    let loads = || vec![[4.0, 6.0]; 4];
    vec![
        Case::new("gains", [loads(), vec![[0.8, 1.2]; 4]], weighed),
        // Unloaded cells among them: the root's slope at zero has no bound.
        Case::new(
            "exponents",
            [
                vec![[0.0, 20.0], [0.5, 20.0]],
                vec![[0.85, 1.2], [1.5, 2.5]],
            ],
            |g, x, y| {
                let first = g.pow(x[0], y[0]);
                let second = g.pow(x[1], y[1]);
                let load = g.mul(x[0], x[1]);
                let both = g.pow(load, y[0]);
                let sum = g.add(first, second);
                let third = g.div(first, sum);
                vec![first, second, both, third]
            },
        ),
        Case::new("saturation", [loads(), vec![[4.5, 5.5]; 4]], |g, x, y| {
            let held: Vec<Id> = (0..4)
                .map(|k| {
                    let part = g.div(x[k], y[k]);
                    let inside = g.clamp(part);
                    g.mul(inside, y[k])
                })
                .collect();
            let one = g.constant(1.0);
            weighed(g, &held, &[one; 4])
        }),
        Case::new(
            "backlash",
            [vec![[-1.5, 1.5]; 2], vec![[0.0, 0.02], [0.1, 0.3]]],
            |g, x, y| {
                let (s, c) = (g.sin(x[0]), g.cos(x[1]));
                let torque = g.dot(&[s, c], &[y[1], y[1]]);
                let steep = g.constant(1e9);
                let steep = g.mul(steep, torque);
                let sign = g.clamp(steep);
                let half = g.constant(0.5);
                let half = g.mul(half, y[0]);
                let play = g.mul(half, sign);
                let angle = g.add(x[0], play);
                let (s, c) = (g.sin(angle), g.cos(angle));
                vec![s, c, sign]
            },
        ),
        Case::new(
            "hat",
            [vec![[-1.5, 1.5]; 2], vec![[-0.4, 0.1], [0.2, 0.6]]],
            |g, x, y| {
                let ramp = g.sub(x[0], y[0]);
                let zero = g.constant(0.0);
                let ramp = g.max(ramp, zero);
                let size = g.abs(x[1]);
                let hat = g.sub(y[1], size);
                let hat = g.max(hat, zero);
                let both = g.mul(ramp, hat);
                let (s, larger) = (g.sin(x[1]), g.max(x[0], x[1]));
                let third = g.mul(s, larger);
                vec![ramp, hat, both, third]
            },
        ),
    ]
}

/// The operations by themselves, for whatever numbers there are.
pub(super) fn bare() -> Case {
    let any = || vec![[f64::NEG_INFINITY, f64::INFINITY]];
    Case::new("bare", [any(), any()], |g, x, y| {
        let (quotient, inside) = (g.div(x[0], y[0]), g.clamp(x[0]));
        let (power, larger) = (g.pow(x[0], y[0]), g.max(x[0], y[0]));
        vec![quotient, inside, power, larger]
    })
}

/// Numbers at every edge, and their pairs.
pub(super) fn edges() -> Vec<[Vec<f64>; 2]> {
    let mut all = vec![
        0.0, 1e-40, 1e-45, 0.5, 0.9999999, 1.0, 1.0000001, 1.5, 2.0, 3.0,
    ];
    all.extend([
        10.0,
        127.0,
        128.0,
        150.0,
        1e9,
        1e30,
        3e38,
        f64::INFINITY,
        f64::NAN,
    ]);
    all.extend([
        1e-310,
        5e-324,
        1e-300,
        1e300,
        f64::MAX,
        f64::MIN_POSITIVE,
        1023.0,
        1024.0,
        1074.0,
    ]);
    let negative: Vec<f64> = all.iter().map(|x| -x).collect();
    all.extend(negative);
    let pairs = all
        .iter()
        .flat_map(|x| all.iter().map(|y| [vec![*x], vec![*y]]));
    pairs.collect()
}
