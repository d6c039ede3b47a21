//! What a report shows of a diagnosis: plain numbers, lengths in m, all that is
//! worked out for a figure worked out here.
//!
//! ```text
//! before = reading − CAD        after = reading − explanation, fitted to all postures
//! χ²(s) = Σ (before + s (after − before))² / σ²            part s of the explanation
//! ```

mod spread;
mod trends;

use sesc_model::effects::Target;
pub use spread::{EDGE, Region, Regions, Spread};
pub use trends::{Middle, Point, Predicted, PredictedPoint, Quantity, Trend};

use super::findings::Explained;
use super::held_out;
use super::outliers::Outliers;
use super::problem::{Fit, Problem};
use crate::observations::postures::{range, rms};
use crate::skeleton::Skeleton;

/// Postures that a figure shows one by one; evenly chosen of more.
pub const MOST: usize = 400;
/// Postures of a small panel; evenly chosen of more.
const PER_PANEL: usize = 200;

/// One posture: its reading, and what was simulated there.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// Its number in the log.
    pub pose: i64,
    /// Time, s, or number in the order of the log, from 1.
    pub at: f64,
    /// Positions of the joints, rad or m.
    pub q: Vec<f64>,
    /// CoP that was read, m.
    pub measured: [f64; 2],
    /// CoP predicted by the robot with CAD masses, m.
    pub simulated: [f64; 2],
    /// CoP predicted by the explanation, m.
    pub corrected: [f64; 2],
    /// Rather an outlier than not.
    pub outlier: bool,
}

/// Held-out error at a stage of the way from CAD to noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Its title.
    pub name: String,
    /// RMS error, m.
    pub rmse: f64,
    /// What kind of stage it is.
    pub kind: StageKind,
}

/// Kinds of stages from CAD to noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageKind {
    /// The robot with CAD masses.
    Cad,
    /// Masses alone, or an effect more.
    Better,
    /// What noise alone leaves.
    Noise,
}

/// Rows of the figures.
#[derive(Debug, Clone)]
pub struct DiagnosisView {
    /// The postures, as many as a page can show.
    pub postures: Vec<Posture>,
    /// `at` is a time.
    pub timed: bool,
    /// RMS length of the gap before and after, m; outliers apart.
    pub rms_lengths: [f64; 2],
    /// Corners of the smallest box around the foot's cells.
    pub foot: Option<[[f64; 2]; 2]>,
    /// The gap against what each effect predicts of it, two axes an effect, in the order of
    /// the steps.
    pub predicted: Vec<Predicted>,
    /// Trends over the joints' positions: joints that the explanation names first, then the
    /// strongest.
    pub by_position: Vec<Trend>,
    /// Trends over the joints' gravity moments, in the same order.
    pub by_moment: Vec<Trend>,
    /// What the trends were chosen by is what the explanation leaves, not the gap.
    pub trends_of_rest: bool,
    /// How residuals are distributed, in units of noise.
    pub spread: Spread,
    /// Where on the sole the gaps are.
    pub regions: Regions,
    /// RMS difference of what two explanations of the class predict, in units of
    /// noise.
    pub differences: Vec<Vec<f64>>,
    /// RMS errors from CAD to noise.
    pub stages: Vec<Stage>,
    /// The effects of the explanation in words.
    pub subjects: Vec<String>,
    /// The robot, as it is drawn.
    pub skeleton: Skeleton,
    /// Places of the foot's cells, m; none where none are logged.
    pub cells: Vec<[f64; 2]>,
    /// Least and largest position of every joint over all postures, rad or m.
    pub used: Vec<[f64; 2]>,
    /// χ² of a part s of the explanation, readings interpolated: coefficients of 1, s and s²;
    /// outliers apart.
    pub chi2: [f64; 3],
    /// Readings that are counted in it.
    pub chi2_readings: usize,
    /// χ² that noise leaves of these under the whole explanation.
    pub chi2_expected: f64,
}

/// Residuals of all postures, m, x and y in turn.
struct Residuals {
    before: Vec<f64>,
    after: Vec<f64>,
    outlier: Vec<bool>,
}

impl Residuals {
    fn rms_lengths(&self) -> [f64; 2] {
        [&self.before, &self.after].map(|errors| {
            let own = errors.chunks(2).zip(&self.outlier);
            let kept = own.filter(|(_, outlier)| !**outlier);
            rms(kept.map(|(error, _)| error[0].hypot(error[1])))
        })
    }

    /// Coefficients of χ², and readings that are counted.
    fn chi2(&self, weight: impl Iterator<Item = f64>) -> ([f64; 3], usize) {
        let (mut sum, mut count) = ([0.0; 3], 0);
        let counted = weight.enumerate();
        for (row, weight) in counted.filter(|(row, _)| !self.outlier[row / 2]) {
            let (before, after) = (self.before[row], self.after[row]);
            let (from, by) = (before * weight, (after - before) * weight);
            sum[0] += from * from;
            sum[1] += 2.0 * from * by;
            sum[2] += by * by;
            count += 1;
        }
        (sum, count)
    }
}

impl DiagnosisView {
    pub(in crate::diagnose) fn of(
        problem: &Problem,
        found: &Explained,
        skeleton: Skeleton,
    ) -> DiagnosisView {
        let (data, dof) = (problem.data(), problem.first().model.dof());
        let outliers = found.best.outliers.iter().flat_map(Outliers::named);
        let mut outlier = vec![false; data.len()];
        outliers.for_each(|k| outlier[k] = true);
        let residuals = Residuals {
            before: found.baseline.errors.clone(),
            after: held_out::errors_of(problem, &found.best, None),
            outlier,
        };
        let terms = found.best.terms.iter();
        let all = problem.readings().map(|range| range.len()).sum::<usize>() as f64;
        let (chi2, chi2_readings) = residuals.chi2(problem.first().inverse_noise());
        DiagnosisView {
            used: (0..dof)
                .map(|joint| range(data.q.iter().copied().skip(joint).step_by(dof)).into())
                .collect(),
            cells: data.cells.clone(),
            skeleton,
            chi2,
            chi2_readings,
            chi2_expected: chi2_readings as f64 * found.diagnosis.leftover.expected / all,
            postures: postures(problem, &residuals),
            timed: data.t.is_some(),
            rms_lengths: residuals.rms_lengths(),
            foot: foot(&data.cells),
            predicted: trends::predicted(problem, found, &residuals),
            by_position: trends::strongest(problem, found, &residuals, Quantity::Position),
            by_moment: trends::strongest(problem, found, &residuals, Quantity::Moment),
            trends_of_rest: found.diagnosis.unexplained,
            spread: Spread::of(problem, &residuals),
            regions: Regions::of(problem, &residuals),
            differences: differences(problem, &found.class),
            stages: stages(found),
            subjects: terms.map(|term| term.phrase(problem.context())).collect(),
        }
    }
}

/// Places of `n` postures in a small panel: each among those of the view, and of the log.
fn of_panel(n: usize) -> impl Iterator<Item = (usize, usize)> {
    let shown = chosen(n, MOST);
    let places = chosen(shown.len(), PER_PANEL).into_iter();
    places.map(move |posture| (posture, shown[posture]))
}

/// An even choice of `most` of `n` places, both ends in it.
pub fn chosen(n: usize, most: usize) -> Vec<usize> {
    match n <= most {
        true => (0..n).collect(),
        false => (0..most).map(|k| k * (n - 1) / (most - 1)).collect(),
    }
}

fn postures(problem: &Problem, residuals: &Residuals) -> Vec<Posture> {
    let data = problem.data();
    let dof = problem.first().model.dof();
    let of = |k: usize| {
        let measured = [0, 1].map(|axis| data.reading[2 * k + axis]);
        let less = |errors: &[f64]| [0, 1].map(|axis| measured[axis] - errors[2 * k + axis]);
        Posture {
            pose: data.pose[k],
            q: data.q[k * dof..(k + 1) * dof].to_vec(),
            at: data.t.as_ref().map_or((k + 1) as f64, |t| t[k]),
            measured,
            simulated: less(&residuals.before),
            corrected: less(&residuals.after),
            outlier: residuals.outlier[k],
        }
    };
    chosen(data.len(), MOST).into_iter().map(of).collect()
}

fn foot(cells: &[[f64; 2]]) -> Option<[[f64; 2]; 2]> {
    let [x, y] = [0, 1].map(|axis| range(cells.iter().map(|cell| cell[axis])));
    (!cells.is_empty()).then_some([[x.0, y.0], [x.1, y.1]])
}

/// Each with each; postures that the best of them does not explain are left out.
fn differences(problem: &Problem, class: &[Fit]) -> Vec<Vec<f64>> {
    let mut class = class.iter().filter(|f| !f.terms.is_empty()).peekable();
    let Some(best) = class.peek() else {
        return Vec::new();
    };
    let apart = held_out::apart(problem, best);
    let errors = class.map(|fit| held_out::errors_of(problem, fit, None));
    let errors: Vec<Vec<f64>> = errors.collect();
    let between = |a: &[f64], b: &[f64]| {
        let entries = a.iter().zip(b).zip(problem.first().inverse_noise());
        let kept = entries.enumerate().filter(|(row, _)| !apart[row / 2]);
        rms(kept.map(|(_, ((a, b), w))| (a - b) * w))
    };
    let rows = errors.iter();
    rows.map(|a| errors.iter().map(|b| between(a, b)).collect())
        .collect()
}

fn stages(found: &Explained) -> Vec<Stage> {
    let said = &found.diagnosis;
    let stage = |name: &str, rmse: f64, kind| Stage {
        name: name.to_string(),
        rmse,
        kind,
    };
    let mut stages = vec![stage("CAD", said.baseline.rmse, StageKind::Cad)];
    let masses = said.steps.first().map_or(said.last.rmse, |s| s.rmse_before);
    // A tight prior leaves masses nothing to do.
    if (masses - said.baseline.rmse).abs() > 0.005 * said.baseline.rmse {
        stages.push(stage("masses within the prior", masses, StageKind::Better));
    }
    for step in &said.steps {
        let effect = step.effect.replace('_', " ");
        let name = match step.target.as_str() {
            "-" => format!("+ {effect}"),
            Target::ALL_JOINTS => format!("+ {effect} of every joint"),
            target => format!("+ {effect} {target}"),
        };
        stages.push(stage(&name, step.rmse_after, StageKind::Better));
    }
    stages.push(stage("noise", said.noise_floor, StageKind::Noise));
    stages
}
