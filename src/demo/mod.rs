//! The SESC paper's simulation on the embedded OP2, with what flat CoP data cannot observe.
//!
//! 1000 postures uniform in ±30°, CoP noise 4.93 mm, least squares on all 63
//! columns (the paper's Eq. (5), by pseudo-inverse) and on the 43 base columns.
//! Errors are stated on postures the fit never saw: against noisy readings,
//! where the noise itself is most of the error, and against the truth, where
//! theory says σ √(rank / 2N).

pub mod hidden;

use nalgebra::{DMatrix, DVector};
use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_model::{Function, Given, Model, Snapping};
use sesc_reference::Reference;

use crate::Error;
use crate::OP2_URDF;
use crate::report::{CopRow, DemoReport, Errors, FunctionRow, HeightRow, LengthRow};
use crate::verify::{self, Verification};
use sesc_identify::Watch;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::lsq::{Estimate, Factor, solve};
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_identify::threads::both;

/// CoP noise of the seed paper, m.
pub const NOISE: f64 = 0.00493;
/// Posture range of the seed paper, degrees.
pub const RANGE_DEG: f64 = 30.0;
/// Postures to fit, as in the paper.
pub const POSTURES: usize = 1000;
/// Further postures the fit never sees.
pub const HELD_OUT: usize = 10_000;
/// Postures shown in the figures, as in the paper's Fig. 3b.
const SHOWN: usize = 26;

/// Everything the demo found.
pub struct Demo {
    /// What its page shows.
    pub report: DemoReport,
    /// The first act: a robot that is as its model says.
    pub first: FirstAct,
}

/// What the first act found, beside what its page shows.
pub struct FirstAct {
    /// Generated functions against the reference.
    pub verification: Verification,
    /// Lines of Rust that were generated.
    pub lines: usize,
    /// Both fits' ranks: full columns, base columns.
    pub ranks: [usize; 2],
    /// Condition number of the base regressor over the fitted postures.
    pub condition_number: f64,
}

/// Seed of the demo unless given.
pub const SEED: u64 = 6;

/// Run with the given seed.
///
/// # Errors
/// When `watch` stops it.
pub fn run(seed: u64, watch: &mut dyn Watch) -> Result<Demo, Error> {
    let robot = Robot::parse(OP2_URDF, "op2.urdf")?;
    let model = robot.model("r_sole", Snapping::default(), None)?;
    let (hidden, first) = both(
        || hidden::run(&robot, &model, seed),
        || first_act(&robot, &model, seed, watch),
    );
    let ((mut report, first), hidden) = (first?, hidden?);
    report.hidden = Some(hidden);
    Ok(Demo { report, first })
}

/// The first act, and the page without the second.
fn first_act(
    robot: &Robot,
    model: &Model,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<(DemoReport, FirstAct), Error> {
    let reference = verify::reference(robot, model)?;
    let code = rust::module(&Facts::of(model), "op2_r_sole")?;
    let verification = verify::verify(robot, model, 5000, seed, watch)?;

    let study = Study::new(model, &reference, seed);
    let full = study.fit(Function::RegressorFull);
    let base = study.fit(Function::RegressorCop);
    let report = DemoReport {
        hidden: None,
        robot: model.tree.robot.clone(),
        hash: model.tree.hash.clone(),
        support: model.tree.links[model.tree.support].name.clone(),
        dof: model.dof(),
        bodies: model.chain.bodies.len(),
        full_params: model.chain.full_params,
        base_params: model.base.params.len(),
        rank_cop: model.base.rank_cop,
        postures: POSTURES,
        range_deg: RANGE_DEG,
        noise_m: NOISE,
        held_out: HELD_OUT,
        functions: functions(model, &verification),
        lengths: lengths(model, &full, &base),
        errors: study.errors(&full, &base),
        cop: study.cop_rows(&base),
        height: study.height_rows(&base),
        height_offset_m: study.height_offset(&base),
        unobservable: model
            .base
            .unobservable
            .iter()
            .map(|u| u.sentence.clone())
            .collect(),
    };
    let first = FirstAct {
        verification,
        lines: code.lines().count(),
        ranks: [full.rank, base.rank],
        condition_number: base.condition_number,
    };
    Ok((report, first))
}

/// Simulated data: what a lab would have, and the truth it would not.
struct Study<'m> {
    model: &'m Model,
    /// Postures to fit, then postures held out, one after the other.
    fitted: Vec<f64>,
    held_out: Vec<f64>,
    /// Noisy readings x, y, x, y, … of the postures fitted and held out, m.
    readings: DVector<f64>,
    held_out_readings: DVector<f64>,
    /// True CoM of the held-out postures from the reference, row by row, m.
    truth: Vec<[f64; 3]>,
}

impl<'m> Study<'m> {
    fn new(model: &'m Model, reference: &Reference, seed: u64) -> Study<'m> {
        let range = RANGE_DEG.to_radians();
        let mut simulator = Simulator::new(&model.tree.dofs, Some(range), seed);
        let fitted = simulator.batch(POSTURES);
        let held_out = simulator.batch(HELD_OUT);
        // Readings come from the reference: the model must not grade itself.
        let truths = |q: &[f64]| -> Vec<[f64; 3]> {
            q.chunks(model.dof())
                .map(|q| reference.com(q).into())
                .collect()
        };
        let mut read = |com: &[[f64; 3]]| {
            let flat = com.iter().flat_map(|com| [com[0], com[1]]);
            DVector::from_vec(flat.map(|x| x + simulator.gauss(NOISE)).collect())
        };
        let truth = truths(&held_out);
        let readings = read(&truths(&fitted));
        let held_out_readings = read(&truth);
        Study {
            model,
            readings,
            held_out_readings,
            truth,
            fitted,
            held_out,
        }
    }

    /// Least squares on the x and y rows of `function`: minimum norm where they see nothing.
    fn fit(&self, function: Function) -> Estimate {
        let rows = cop_rows(self.model, function, &self.fitted, POSTURES);
        let mut factor = Factor::new(rows.ncols());
        factor.push(&rows, &self.readings, &[1.0; 2 * POSTURES]);
        solve(&factor, NOISE, &DVector::zeros(rows.ncols()), None)
    }

    /// Mean |error| against the readings fitted, m.
    fn in_sample(&self, function: Function, fit: &Estimate) -> f64 {
        let rows = cop_rows(self.model, function, &self.fitted, POSTURES);
        (rows * &fit.params - &self.readings).abs().mean()
    }

    /// Predicted x, y, x, y, … of the held-out postures.
    fn predicted(&self, function: Function, fit: &Estimate) -> DVector<f64> {
        cop_rows(self.model, function, &self.held_out, HELD_OUT) * &fit.params
    }

    fn errors(&self, full: &Estimate, base: &Estimate) -> Errors {
        let truth = DVector::from_iterator(
            2 * HELD_OUT,
            self.truth.iter().flat_map(|com| [com[0], com[1]]),
        );
        let rms = |x: DVector<f64>| (x.norm_squared() / x.len() as f64).sqrt();
        let by_base = self.predicted(Function::RegressorCop, base);
        let by_full = self.predicted(Function::RegressorFull, full);
        let cad = DVector::from_vec(
            Evaluator::new(self.model, Function::Cop).run(&self.held_out, HELD_OUT),
        );
        let measured = (&by_base - &self.held_out_readings).abs().mean();
        Errors {
            measured_mae_m: measured,
            in_sample_mae_m: self.in_sample(Function::RegressorCop, base),
            noise_mae_m: NOISE * (2.0 / std::f64::consts::PI).sqrt(),
            clean_rmse_base_m: rms(by_base - &truth),
            clean_rmse_full_m: rms(by_full - &truth),
            theory_rmse_m: NOISE * (base.rank as f64 / (2 * POSTURES) as f64).sqrt(),
            cad_clean_rmse_m: rms(cad - &truth),
        }
    }

    fn cop_rows(&self, base: &Estimate) -> Vec<CopRow> {
        let cad = Evaluator::new(self.model, Function::Cop).run(&self.held_out, SHOWN);
        let identified = self.predicted(Function::RegressorCop, base);
        let measured = &self.held_out_readings;
        let dof = self.model.dof();
        (0..SHOWN)
            .map(|k| CopRow {
                pose: k + 1,
                q: self.held_out[dof * k..dof * (k + 1)].to_vec(),
                measured: [measured[2 * k], measured[2 * k + 1]],
                truth: [self.truth[k][0], self.truth[k][1]],
                cad: [cad[2 * k], cad[2 * k + 1]],
                identified: [identified[2 * k], identified[2 * k + 1]],
            })
            .collect()
    }

    /// CoM heights of the held-out postures with the minimum-norm constant, m.
    fn heights(&self, base: &Estimate) -> Vec<f64> {
        let params = base.params.as_slice().to_vec();
        let com = Evaluator::with_params(self.model, Function::Com, params);
        com.run(&self.held_out, HELD_OUT)
            .chunks(3)
            .map(|com| com[2])
            .collect()
    }

    /// The constant that no flat CoP tells: minimum norm minus CAD, m.
    fn height_offset(&self, base: &Estimate) -> f64 {
        let heights = self.heights(base);
        let sum: f64 = heights
            .iter()
            .zip(&self.truth)
            .map(|(z, com)| z - com[2])
            .sum();
        sum / HELD_OUT as f64
    }

    fn height_rows(&self, base: &Estimate) -> Vec<HeightRow> {
        let constant = self.model.base.params[2].cad - base.params[2];
        let heights = self.heights(base);
        (0..SHOWN)
            .map(|k| HeightRow {
                pose: k + 1,
                truth: self.truth[k][2],
                identified: heights[k],
                anchored: heights[k] + constant,
            })
            .collect()
    }
}

/// The x and y rows of a regressor, posture by posture: 2n × columns.
fn cop_rows(model: &Model, function: Function, q: &[f64], n: usize) -> DMatrix<f64> {
    let evaluator = Evaluator::new(model, function);
    let values = evaluator.run(q, n);
    let columns = match function {
        Function::RegressorFull => model.chain.full_params,
        _ => model.base.params.len(),
    };
    let rows = values
        .chunks(evaluator.width())
        .flat_map(|posture| posture[..2 * columns].iter().copied());
    DMatrix::from_row_iterator(2 * n, columns, rows)
}

fn functions(model: &Model, verification: &Verification) -> Vec<FunctionRow> {
    let row = |function: Function| {
        let counts = model.program(function, Given::Positions)?.counts();
        Some(FunctionRow {
            name: function.name().to_string(),
            mul: counts.mul,
            add: counts.add,
            sin_cos: counts.sin_cos,
            worst_error_m: verification.worst_error[function.name()],
            bound_m: verification.bound[function.name()],
        })
    };
    Function::ALL.into_iter().filter_map(row).collect()
}

/// ‖r_i‖ from CAD and as identified, body by body (the paper's Fig. 3a).
fn lengths(model: &Model, full: &Estimate, base: &Estimate) -> Vec<LengthRow> {
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
    let row = |body: &sesc_model::chain::Body| {
        // Base parameters are named `link.axis`.
        let own = |k: &usize| {
            model.base.params[*k]
                .name
                .rsplit_once('.')
                .is_some_and(|n| n.0 == body.name)
        };
        let params: Vec<usize> = (0..model.base.params.len()).filter(own).collect();
        LengthRow {
            body: body.name.clone(),
            joint: body.joint.clone().unwrap_or_default(),
            cad_m: norm(&mut body.r().into_iter()),
            full_m: full.params.rows(body.column, 3).norm(),
            base_cad_m: norm(&mut params.iter().map(|&k| model.base.params[k].cad)),
            base_m: norm(&mut params.iter().map(|&k| base.params[k])),
            unseen: match &body.joint {
                Some(joint) => format!("along the axis of {joint}"),
                None => "its height".to_string(),
            },
        }
    };
    model.chain.bodies.iter().map(row).collect()
}
