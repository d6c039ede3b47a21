//! What no effect of the list explains: how much, where, and a short formula.
//!
//! ```text
//! residual ≈ Σ_k (a_k, b_k) f_k(q, τ, u)        a few f from a library, by least
//!                                               squares, each paid for
//! ```
//!
//! Found, not physical: a formula says what the gap follows, not why.

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::PostureContext;

use super::findings::Follows;
use super::problem::{Fit, Problem};
use super::{criteria, held_out};
use crate::lsq::factor_normal;

/// χ² of what is left against what noise leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misfit {
    pub chi2: f64,
    pub expected: f64,
    /// Rows per independent one: χ² scatters as much more.
    pub rows_per_sample: f64,
}

impl Misfit {
    pub fn of(problem: &Problem, fit: &Fit) -> Misfit {
        let apart = held_out::apart(problem, fit);
        let masses = problem.masses(&fit.terms);
        let shift = problem.mass_shift(fit);
        let mut chi2 = 0.0;
        let mut rows = 0.0;
        for (k, apart) in apart.iter().enumerate() {
            if !apart {
                for row in [2 * k, 2 * k + 1] {
                    // Against the noise as it is, however few samples the rows are worth.
                    let left = (fit.residual[row] - shift[row]) * problem.widened[row % 2];
                    chi2 += left.powi(2);
                    rows += 1.0;
                }
            }
        }
        Misfit {
            chi2,
            expected: (rows - fit.unknowns.len() as f64 - masses.directions()).max(1.0),
            rows_per_sample: problem.rows_per_sample(),
        }
    }

    /// Standard deviations beyond what noise leaves.
    pub fn deviations(self) -> f64 {
        (self.chi2 - self.expected) / (2.0 * self.expected * self.rows_per_sample).sqrt()
    }

    pub fn is_clear(self) -> bool {
        self.deviations() > criteria::LEFTOVER_DEVIATIONS
            && self.chi2 > criteria::LEFTOVER_RATIO * self.expected
    }
}

/// One function of a posture with its weight on each axis, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    pub name: String,
    pub weight: [f64; 2],
}

/// A short formula for the residual.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    pub terms: Vec<Term>,
    /// Share of what is above the noise that it explains.
    pub share: f64,
    /// Score of fit and formula together.
    pub score: f64,
}

impl Formula {
    pub fn is_reported(&self) -> bool {
        !self.terms.is_empty() && self.share > criteria::FORMULA_SHARE
    }

    /// `x: 2.98 mm sin(3 r_knee), y: …`
    pub fn text(&self) -> String {
        let axis = |a: usize| {
            let terms = self
                .terms
                .iter()
                .map(|t| format!("{:+.2} mm {}", 1e3 * t.weight[a], t.name));
            terms.collect::<Vec<_>>().join(" ")
        };
        format!("x: {}; y: {}", axis(0), axis(1))
    }
}

/// The formula that explains most of what `fit` leaves.
pub fn formula(problem: &Problem, fit: &Fit) -> Formula {
    let library = library(problem);
    let n = problem.data.len();
    let misfit = Misfit::of(problem, fit);
    let mut target = fit.residual.as_ref().clone();
    target -= problem.mass_shift(fit);
    for (k, apart) in held_out::apart(problem, fit).into_iter().enumerate() {
        if apart {
            target[2 * k] = 0.0;
            target[2 * k + 1] = 0.0;
        }
    }
    let penalty = 2.0 * (2.0 * n as f64).ln() + 2.0 * (library.len() as f64).ln();
    let column = |f: &[f64], axis: usize| {
        DVector::from_fn(2 * n, |row, _| match row % 2 == axis {
            true => f[row / 2] * problem.weight[row],
            false => 0.0,
        })
    };
    let mut chosen: Vec<usize> = Vec::new();
    let mut weights = DVector::zeros(0);
    let mut left = target.clone();
    while chosen.len() < criteria::FORMULA_TERMS {
        // The function most like what is left, on both axes together.
        let worth = |f: &[f64]| {
            (0..2)
                .map(|axis| {
                    let c = column(f, axis);
                    let square = c.norm_squared();
                    if square > 1e-9 {
                        c.dot(&left).powi(2) / square
                    } else {
                        0.0
                    }
                })
                .sum::<f64>()
        };
        let best = (0..library.len())
            .filter(|k| !chosen.contains(k))
            .map(|k| (k, worth(&library[k].1)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((k, _)) = best else { break };
        let mut tried = chosen.clone();
        tried.push(k);
        let columns: Vec<DVector<f64>> = tried
            .iter()
            .flat_map(|&k| [column(&library[k].1, 0), column(&library[k].1, 1)])
            .collect();
        let matrix = DMatrix::from_columns(&columns);
        let Some(factor) = factor_normal(matrix.tr_mul(&matrix)) else {
            break;
        };
        let solution = factor.solve(&matrix.tr_mul(&target));
        let rest = &target - &matrix * &solution;
        if left.norm_squared() - rest.norm_squared() < penalty {
            break;
        }
        (chosen, weights, left) = (tried, solution, rest);
    }
    let gained = target.norm_squared() - left.norm_squared();
    Formula {
        terms: chosen
            .iter()
            .enumerate()
            .map(|(at, &k)| Term {
                name: library[k].0.clone(),
                weight: [weights[2 * at], weights[2 * at + 1]],
            })
            .collect(),
        share: gained / (misfit.chi2 - misfit.expected).max(1.0),
        score: fit.score() - gained + penalty * chosen.len() as f64,
    }
}

/// Functions of a posture that a gap may follow, and the quantity that each is of: the first is
/// the constant.
fn library(problem: &Problem) -> Vec<(String, Vec<f64>, Option<Follows>)> {
    let (n, dof) = (problem.data.len(), problem.context.robot.dof());
    let dofs = &problem.context.robot.tree.dofs;
    let moments = problem.moments_at(&problem.data.q);
    let layout = PostureContext::of(problem.context.robot);
    let mut library = Vec::new();
    let mut add = |of: Option<Follows>, name: String, f: &dyn Fn(usize) -> f64| {
        library.push((name, (0..n).map(f).collect(), of));
    };
    add(None, "1".to_string(), &|_| 1.0);
    let place = |k: usize| problem.data.posture_context[k * layout.len() + layout.place()];
    let along = || Some(Follows::Place);
    add(along(), "place in the log".to_string(), &place);
    add(along(), "place in the log²".to_string(), &|k| {
        place(k).powi(2)
    });
    for (j, joint) in dofs.iter().enumerate() {
        let name = &joint.joint;
        let q = |k: usize| problem.data.q[k * dof + j];
        let moment = |k: usize| moments[k * 3 * dof + j];
        let of_q = || Some(Follows::Position(name.clone()));
        let of_tau = || Some(Follows::Moment(name.clone()));
        add(of_q(), name.clone(), &q);
        add(of_q(), format!("{name}²"), &|k| q(k).powi(2));
        add(of_q(), format!("{name}³"), &|k| q(k).powi(3));
        add(of_q(), format!("|{name}|"), &|k| q(k).abs());
        if !joint.prismatic {
            for times in 1..=4 {
                let factor = f64::from(times);
                let prefix = if times == 1 {
                    String::new()
                } else {
                    format!("{times} ")
                };
                add(of_q(), format!("sin({prefix}{name})"), &|k| {
                    (factor * q(k)).sin()
                });
                add(of_q(), format!("cos({prefix}{name})"), &|k| {
                    (factor * q(k)).cos()
                });
            }
        }
        add(of_tau(), format!("moment of {name}"), &moment);
        add(of_tau(), format!("|moment of {name}|"), &|k| {
            moment(k).abs()
        });
        add(of_tau(), format!("moment of {name}²"), &|k| {
            moment(k).powi(2)
        });
        add(of_tau(), format!("sign of the moment of {name}"), &|k| {
            moment(k).signum()
        });
    }
    library
}

/// Where the residual is strongest: which joint or moment it goes with.
pub fn strongest(problem: &Problem, fit: &Fit) -> Option<(String, Follows, f64)> {
    let n = problem.data.len();
    let whole = fit.residual.norm_squared();
    let share = |f: &[f64]| {
        let mean = f.iter().sum::<f64>() / n as f64;
        (0..2)
            .map(|axis| {
                let c: Vec<f64> = (0..n)
                    .map(|k| (f[k] - mean) * problem.weight[2 * k + axis])
                    .collect();
                let square: f64 = c.iter().map(|x| x * x).sum();
                let dot: f64 = (0..n).map(|k| c[k] * fit.residual[2 * k + axis]).sum();
                if square > 1e-12 {
                    dot * dot / square
                } else {
                    0.0
                }
            })
            .sum::<f64>()
            / whole
    };
    library(problem)
        .into_iter()
        .filter_map(|(name, f, of)| Some((name, of?, share(&f))))
        .max_by(|a, b| a.2.total_cmp(&b.2))
}
