//! Load cells under the sole, and what each may have of its own.
//!
//! ```text
//! f_k  = a + b x_k + c y_k               equal springs under a stiff plate
//! f_k' = gain_k sat_k(f_k) + zero_k      sat_k(f) = W (f/W)^e, then F tanh(f/F)
//! p'   = Σ f_k' p_k / Σ f_k'
//! ```
//!
//! `a, b, c` carry the load at its place. A cell that would have to pull lifts
//! off and the others carry it, as long as the CoP lies between them; outside
//! the cells' outline some must pull. `W` is the weight that the URDF gives
//! the robot.

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::error::{Error, Problem};

use super::World;
use super::statics::{GRAVITY, above_zero};

/// The cells under a sole; there may be none.
#[derive(Debug, Clone, Default)]
pub(super) struct Cells(Vec<Cell>);

#[derive(Debug, Clone)]
struct Cell {
    at_m: Vector2<f64>,
    gain: f64,
    zero_n: f64,
    exponent: f64,
    saturation_n: f64,
}

impl Cells {
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The faulty cells' loads, N; none where there are no cells.
    pub(super) fn loads(&self, cop_m: Vector2<f64>, total_n: f64, weight_n: f64) -> Vec<f64> {
        let loads = split(&self.places(), cop_m, total_n);
        let cells = self.0.iter().zip(loads);
        cells
            .map(|(cell, load)| cell.feel(load, weight_n))
            .collect()
    }

    /// The loads that true cells would report with this CoP, N.
    pub(super) fn true_loads(&self, cop_m: Vector2<f64>, total_n: f64) -> Vec<f64> {
        split(&self.places(), cop_m, total_n)
    }

    fn places(&self) -> Vec<Vector2<f64>> {
        self.0.iter().map(|cell| cell.at_m).collect()
    }

    /// The CoP that loads stand for, m.
    pub(super) fn cop_of(&self, loads: &[f64]) -> Vector2<f64> {
        let moment: Vector2<f64> = self
            .0
            .iter()
            .zip(loads)
            .map(|(cell, load)| cell.at_m * *load)
            .sum();
        moment / loads.iter().sum::<f64>()
    }
}

impl Cell {
    fn feel(&self, load_n: f64, weight_n: f64) -> f64 {
        let mut felt = load_n;
        if self.exponent != 1.0 {
            felt = (felt / weight_n).abs().powf(self.exponent) * weight_n * felt.signum();
        }
        if self.saturation_n.is_finite() {
            felt = self.saturation_n * (felt / self.saturation_n).tanh();
        }
        self.gain * felt + self.zero_n
    }
}

/// A stiff plate on equal springs that cannot pull.
fn split(places: &[Vector2<f64>], cop_m: Vector2<f64>, total_n: f64) -> Vec<f64> {
    let glued = plate(places, &vec![true; places.len()], cop_m, total_n);
    let Some(glued) = glued else {
        return vec![0.0; places.len()];
    };
    let mut loads = glued.clone();
    let mut touching = vec![true; places.len()];
    // Rounding alone must not lift a cell off.
    while let Some((cell, _)) = loads
        .iter()
        .enumerate()
        .filter(|(_, load)| **load < -1e-12 * total_n.abs())
        .min_by(|a, b| a.1.total_cmp(b.1))
    {
        touching[cell] = false;
        match plate(places, &touching, cop_m, total_n) {
            Some(next) => loads = next,
            None => return glued,
        }
    }
    loads
}

fn plate(
    places: &[Vector2<f64>],
    touching: &[bool],
    cop_m: Vector2<f64>,
    total_n: f64,
) -> Option<Vec<f64>> {
    let mut stiffness = Matrix3::zeros();
    for (place, _) in places.iter().zip(touching).filter(|(_, on)| **on) {
        let row = Vector3::new(1.0, place.x, place.y);
        stiffness += row * row.transpose();
    }
    let load = Vector3::new(1.0, cop_m.x, cop_m.y) * total_n;
    let size = stiffness[(0, 0)];
    let spread = (stiffness[(1, 1)] + stiffness[(2, 2)]) / size.max(1.0);
    if stiffness.determinant() <= 1e-9 * size * (size * spread) * (size * spread) {
        return None;
    }
    let [a, b, c]: [f64; 3] = stiffness.lu().solve(&load)?.into();
    let loads = places.iter().zip(touching);
    Some(
        loads
            .map(|(place, on)| {
                if *on {
                    a + b * place.x + c * place.y
                } else {
                    0.0
                }
            })
            .collect(),
    )
}

impl World {
    /// The sole stands on cells at these places of the support frame, true
    /// ones; they replace earlier cells.
    ///
    /// # Errors
    /// `ErrorKind::Cells` where they cannot carry a load.
    pub fn cells(mut self, places_m: &[[f64; 2]]) -> Result<Self, Error> {
        let places: Vec<Vector2<f64>> = places_m.iter().copied().map(Vector2::from).collect();
        let all = vec![true; places.len()];
        if plate(&places, &all, Vector2::zeros(), 1.0).is_none() {
            return Err(Problem::Cells {
                count: places.len(),
            }
            .into());
        }
        let cell = |at_m| Cell {
            at_m,
            gain: 1.0,
            zero_n: 0.0,
            exponent: 1.0,
            saturation_n: f64::INFINITY,
        };
        self.cells = Cells(places.into_iter().map(cell).collect());
        Ok(self)
    }

    /// Cell `k` (from 1, as in `fsr_1`) reports `gain` times its load.
    ///
    /// # Errors
    /// `ErrorKind::UnknownCell`.
    pub fn cell_gain(mut self, k: usize, gain: f64) -> Result<Self, Error> {
        self.cell(k)?.gain *= gain;
        Ok(self)
    }

    /// Cell `k` (from 1) reports `zero_n` newtons too much.
    ///
    /// # Errors
    /// `ErrorKind::UnknownCell`.
    pub fn cell_offset(mut self, k: usize, zero_n: f64) -> Result<Self, Error> {
        self.cell(k)?.zero_n += zero_n;
        Ok(self)
    }

    /// Cell `k` (from 1) reports `W (f/W)^exponent` of its load `f`, with `W`
    /// the robot's weight as its URDF has it.
    ///
    /// # Errors
    /// `ErrorKind::UnknownCell`; `ErrorKind::Value` unless it is above zero.
    pub fn cell_exponent(mut self, k: usize, exponent: f64) -> Result<Self, Error> {
        self.cell(k)?.exponent *= above_zero("exponent", exponent)?;
        Ok(self)
    }

    /// Cell `k` (from 1) reports `F tanh(f/F)` of its load `f`: never more
    /// than `limit_n` newtons.
    ///
    /// # Errors
    /// `ErrorKind::UnknownCell`; `ErrorKind::Value` unless it is above zero.
    pub fn cell_saturation(mut self, k: usize, limit_n: f64) -> Result<Self, Error> {
        self.cell(k)?.saturation_n = above_zero("largest load", limit_n)?;
        Ok(self)
    }

    /// The weight that the URDF gives the robot, N: what [`World::cell_exponent`]
    /// counts loads in.
    pub fn nominal_weight(&self) -> f64 {
        self.nominal_kg * GRAVITY
    }

    fn cell(&mut self, k: usize) -> Result<&mut Cell, Error> {
        let count = self.cells.0.len();
        k.checked_sub(1)
            .and_then(|at| self.cells.0.get_mut(at))
            .ok_or(Problem::UnknownCell { cell: k, count }.into())
    }
}
