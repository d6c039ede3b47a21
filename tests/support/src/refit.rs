//! What the best of an explanation would leave over: its parameters refitted on
//! the virtual robot itself.
//!
//! ```text
//! chi2(v) = Σ ((y - cop(v)) / σ)²      Levenberg-Marquardt, differences of 1e-4 of each scale
//! ```
//!
//! Where postures read wrong, a posture counts at most 20.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_reference::Track;

use crate::hidden::{Effect, Hidden, hide_all};
use crate::log::Log;
use crate::sizes;
use crate::stage::Stage;

/// A posture cannot count more where outliers are about.
const CAPPED: f64 = 20.0;
const STEPS: usize = 30;

/// A log and the robot that its reader knows.
pub struct Refit<'a> {
    stage: &'a Stage,
    log: &'a Log,
    track: Track,
    robust: bool,
}

impl<'a> Refit<'a> {
    /// Fits of `log`, which `robust` makes robust against outliers.
    pub fn new(stage: &'a Stage, log: &'a Log, robust: bool) -> Self {
        Self {
            stage,
            log,
            track: log.track(),
            robust,
        }
    }

    /// The least chi2 near these values.
    pub fn least(&self, hidden: &[Hidden]) -> f64 {
        let hidden: Vec<Hidden> = hidden
            .iter()
            .filter(|hidden| hidden.effect != Effect::CopOutliers)
            .cloned()
            .collect();
        let scales = self.scales(&hidden);
        let mut at: Vec<f64> = hidden.iter().flat_map(|h| h.values.clone()).collect();
        let Some(mut gaps) = self.gaps(&hidden, &at) else {
            return f64::INFINITY;
        };
        let (mut best, mut damping) = (self.cost(&gaps), 1e-3);
        for _ in 0..STEPS {
            if at.is_empty() {
                break;
            }
            let jacobian = self.jacobian(&hidden, &at, &scales, &gaps);
            let before = best;
            for _ in 0..8 {
                let step = self.step(&jacobian, &gaps, damping);
                let next: Vec<f64> = (0..at.len()).map(|i| at[i] + scales[i] * step[i]).collect();
                let tried = self.gaps(&hidden, &next);
                if let Some(tried) = tried.filter(|tried| self.cost(tried) < best) {
                    (best, at, gaps) = (self.cost(&tried), next, tried);
                    damping *= 0.2;
                    break;
                }
                damping *= 6.0;
            }
            if before - best < 1e-3 {
                break;
            }
        }
        best
    }

    /// The least chi2 from nothing: every effect starts small.
    pub fn least_from_nothing(&self, hidden: &[Hidden]) -> f64 {
        let starts = [0.05, -0.05].map(|size| {
            let small = hidden.iter().map(|hidden| {
                let scale = self.scales(std::slice::from_ref(hidden));
                hidden.with(match hidden.effect {
                    Effect::Payload | Effect::HangingLoad => {
                        let com = self.com_of(&hidden.target);
                        let mass = size * scale[0];
                        vec![mass, mass * com[0], mass * com[1], mass * com[2]]
                    }
                    Effect::JointCompliance | Effect::Backlash | Effect::CellSaturation => {
                        vec![size.abs() * scale[0]]
                    }
                    _ => scale.iter().map(|scale| 0.01 * size * scale).collect(),
                })
            });
            self.least(&small.collect::<Vec<_>>())
        });
        starts[0].min(starts[1])
    }

    fn com_of(&self, link: &str) -> [f64; 3] {
        let links = self.stage.robot.links().iter();
        let link = links.into_iter().find(|found| found.name == link);
        link.map_or([0.0; 3], |link| link.com_m.coords.into())
    }

    /// How large each value gets.
    fn scales(&self, hidden: &[Hidden]) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let mut scales = Vec::new();
        for hidden in hidden {
            let large = sizes::largest(hidden.effect, self.stage, &hidden.target, &mut random);
            let most = large.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            scales.extend(large.iter().map(|v| v.abs().max(0.1 * most)));
        }
        scales
    }

    /// Measured less predicted over the noise; none where the robot cannot be.
    fn gaps(&self, hidden: &[Hidden], values: &[f64]) -> Option<DVector<f64>> {
        let mut values = values.iter().copied();
        let hidden: Vec<Hidden> = hidden
            .iter()
            .map(|hidden| hidden.with(values.by_ref().take(hidden.values.len()).collect()))
            .collect();
        let world = hide_all(self.stage.world(), &hidden).ok()?;
        let readings = world.readings(&self.track);
        let measured = self.log.cop.iter().zip(&self.log.sigma);
        let gaps = measured
            .zip(&readings)
            .flat_map(|((measured, sigma), reading)| {
                [0, 1].map(|axis| (measured[axis] - reading.cop[axis]) / sigma[axis])
            });
        let gaps = DVector::from_iterator(2 * readings.len(), gaps);
        gaps.iter().all(|gap| gap.is_finite()).then_some(gaps)
    }

    fn cost(&self, gaps: &DVector<f64>) -> f64 {
        let postures = gaps
            .as_slice()
            .chunks(2)
            .map(|gap| gap[0] * gap[0] + gap[1] * gap[1]);
        if self.robust {
            postures.map(|cost| cost.min(CAPPED)).sum()
        } else {
            postures.sum()
        }
    }

    /// `∂prediction/∂value`, each value in its scale.
    fn jacobian(
        &self,
        hidden: &[Hidden],
        at: &[f64],
        scales: &[f64],
        gaps: &DVector<f64>,
    ) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(gaps.len(), at.len());
        let mut values = at.to_vec();
        for j in 0..at.len() {
            let step = 1e-4;
            values[j] = at[j] + step * scales[j];
            if let Some(moved) = self.gaps(hidden, &values) {
                jacobian.set_column(j, &((gaps - moved) / step));
            }
            values[j] = at[j];
        }
        jacobian
    }

    fn step(&self, jacobian: &DMatrix<f64>, gaps: &DVector<f64>, damping: f64) -> DVector<f64> {
        let (mut jacobian, mut gaps) = (jacobian.clone(), gaps.clone());
        if self.robust {
            for i in 0..gaps.len() / 2 {
                if gaps[2 * i].hypot(gaps[2 * i + 1]).powi(2) > CAPPED {
                    jacobian.rows_mut(2 * i, 2).fill(0.0);
                    gaps.rows_mut(2 * i, 2).fill(0.0);
                }
            }
        }
        let mut normal = jacobian.tr_mul(&jacobian);
        for i in 0..normal.nrows() {
            normal[(i, i)] += damping * normal[(i, i)] + 1e-12;
        }
        let right = jacobian.tr_mul(&gaps);
        normal
            .cholesky()
            .map_or_else(|| DVector::zeros(right.len()), |c| c.solve(&right))
    }
}
