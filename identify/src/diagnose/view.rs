//! What a report shows of a diagnosis: plain numbers, lengths in m, all that is
//! worked out for a figure worked out here.
//!
//! ```text
//! before = reading − CAD        after = reading − explanation, fitted to all postures
//! χ²(s) = Σ (before + s (after − before))² / σ²            part s of the explanation
//! change = h(all effects) − h(all but this one)        gap = rest + change
//! share = 1 − Σ_bins Σ (e − ē_bin)² / Σ (e − ē)² · (n − 1)/(n − bins)
//! ```
//!
//! `rest` is what the whole explanation leaves, so the gap is what all of it but one effect
//! leaves. Where the effect is right, gap = change but for noise: a line of slope 1.

use sesc_model::effects::Target;

use super::findings::{ActsOn, Explained};
use super::held_out;
use super::hypothesis::{Term, with_places};
use super::leftover::Bins;
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
            after: held_out::errors_of(problem, &found.best),
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
            predicted: predicted(problem, found, &residuals),
            by_position: strongest(problem, found, &residuals, Quantity::Position),
            by_moment: strongest(problem, found, &residuals, Quantity::Moment),
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
    let errors = class.map(|fit| held_out::errors_of(problem, fit));
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

/// Residuals are counted from −EDGE to EDGE, in units of noise.
pub const EDGE: f64 = 6.0;
/// Bins between.
const BINS: usize = 24;
/// Squares along the longer side of the map.
const SQUARES: f64 = 8.0;

/// Whitened residuals, counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Readings per bin before.
    pub before: Vec<usize>,
    /// Readings per bin after.
    pub after: Vec<usize>,
    /// Beyond the edges, before and after.
    pub beyond: [usize; 2],
    /// RMS before and after; outliers in neither.
    pub rms: [f64; 2],
    /// Readings that are counted.
    pub count: usize,
}

impl Spread {
    fn of(problem: &Problem, residuals: &Residuals) -> Spread {
        let counted = |errors: &[f64]| {
            let (mut bins, mut beyond) = (vec![0; BINS], 0);
            for (error, weight) in errors.iter().zip(problem.first().inverse_noise()) {
                let place = (error * weight + EDGE) / (2.0 * EDGE) * BINS as f64;
                match (0.0..BINS as f64).contains(&place) {
                    true => bins[place as usize] += 1,
                    false => beyond += 1,
                }
            }
            let entries = errors.iter().zip(problem.first().inverse_noise());
            let entries = entries.enumerate();
            let kept = entries.filter(|(row, _)| !residuals.outlier[row / 2]);
            (bins, beyond, rms(kept.map(|(_, (e, w))| e * w)))
        };
        let before = counted(&residuals.before);
        let after = counted(&residuals.after);
        Spread {
            before: before.0,
            after: after.0,
            beyond: [before.1, after.1],
            rms: [before.2, after.2],
            count: residuals.before.len(),
        }
    }
}

/// Residuals in one square of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Corner nearest to the origin of the map, m.
    pub corner: [f64; 2],
    /// Postures with readings in it.
    pub postures: usize,
    /// RMS in units of noise, before and after.
    pub rms: [f64; 2],
}

/// Squares of the sole in which readings lie; outliers apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Regions {
    /// Side of a square, m.
    pub side: f64,
    /// The squares that hold readings.
    pub squares: Vec<Region>,
}

impl Regions {
    fn of(problem: &Problem, residuals: &Residuals) -> Regions {
        let reading = &problem.data().reading;
        let kept: Vec<usize> = (0..problem.data().len())
            .filter(|&k| !residuals.outlier[k])
            .collect();
        let ends =
            [0, 1].map(|axis| <[f64; 2]>::from(range(kept.iter().map(|k| reading[2 * k + axis]))));
        let lengths = ends.map(|[low, high]| high - low);
        let longest = lengths.into_iter().fold(1e-3, f64::max);
        let side = longest / SQUARES;
        let counts = ends.map(|[low, high]| ((high - low) / side).ceil().max(1.0) as usize);
        let mut members = vec![Vec::new(); counts[0] * counts[1]];
        for &k in &kept {
            // The far end belongs to the last square.
            let [i, j] = [0, 1].map(|axis| {
                let place = (reading[2 * k + axis] - ends[axis][0]) / side;
                (place as usize).min(counts[axis] - 1)
            });
            members[i * counts[1] + j].push(k);
        }
        let squares = members.iter().enumerate();
        let squares = squares.filter(|(_, own)| !own.is_empty());
        let weights: Vec<f64> = problem.first().inverse_noise().collect();
        let region = |(place, own): (usize, &Vec<usize>)| {
            let rows = || own.iter().flat_map(|&k| [2 * k, 2 * k + 1]);
            let of = |errors: &[f64]| rms(rows().map(|row| errors[row] * weights[row]));
            Region {
                corner: [
                    ends[0][0] + side * (place / counts[1]) as f64,
                    ends[1][0] + side * (place % counts[1]) as f64,
                ],
                postures: own.len(),
                rms: [of(&residuals.before), of(&residuals.after)],
            }
        };
        Regions {
            side,
            squares: squares.map(region).collect(),
        }
    }
}

/// The gap of one axis against one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// The effect and its target in words: `an offset of r_knee`.
    pub subject: String,
    /// 0: x, 1: y.
    pub axis: usize,
    /// Slope of the straight line through the origin that fits the gap best: 1 where the
    /// effect explains all of it; outliers apart. NaN where the effect changes nothing.
    pub slope: f64,
    /// The postures.
    pub points: Vec<PredictedPoint>,
}

/// One posture: what the effect predicts and what was read, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedPoint {
    /// Place of its posture among those of the view.
    pub posture: usize,
    /// Change of the reading that the effect predicts, m.
    pub change: f64,
    /// Gap that all other effects leave, m.
    pub gap: f64,
    /// Whether the posture is an outlier.
    pub outlier: bool,
}

/// Both axes of every effect that changes readings, in the order of the steps.
fn predicted(problem: &Problem, found: &Explained, residuals: &Residuals) -> Vec<Predicted> {
    let best = &found.best;
    let steps = found.told.iter();
    let steps = steps.filter_map(|&at| Some((&best.terms[at], change(problem, best, at)?)));
    let both = steps.flat_map(|(term, change)| {
        let subject = term.phrase(problem.context());
        [0, 1].map(|axis| panel(subject.clone(), axis, &change, residuals))
    });
    both.collect()
}

/// Change of every reading by the effect at this place of the explanation, m; none of what
/// changes no reading.
fn change(problem: &Problem, best: &Fit, at: usize) -> Option<Vec<f64>> {
    let first = problem.first();
    match &best.terms[at] {
        Term::Effect(_) => {}
        Term::Masses => {
            let shift = problem.mass_shift(best);
            let metres = shift.iter().zip(&first.weight).map(|(s, w)| s / w);
            return Some(metres.collect());
        }
        Term::Outliers => return None,
    }
    let (mut terms, mut unknowns) = (Vec::new(), Vec::new());
    for (k, (term, own)) in with_places(&best.terms, &first.context).enumerate() {
        if k != at {
            terms.push(term.clone());
            unknowns.extend_from_slice(&best.unknowns[own]);
        }
    }
    let posture_context = problem.posture_contexts(Some(best)).swap_remove(0);
    // Values come with their derivatives by the unknowns.
    let readings = |terms: &[Term], unknowns: &[f64]| {
        let out = first.evaluate(terms, unknowns, &first.data.q, &posture_context);
        out.into_iter().step_by(1 + unknowns.len())
    };
    let without = readings(&terms, &unknowns);
    let with = readings(&best.terms, &best.unknowns).zip(without);
    Some(with.map(|(with, without)| with - without).collect())
}

fn panel(subject: String, axis: usize, change: &[f64], residuals: &Residuals) -> Predicted {
    let n = residuals.outlier.len();
    let change = |k: usize| change[2 * k + axis];
    let gap = |k: usize| residuals.after[2 * k + axis] + change(k);
    let (mut along, mut square) = (0.0, 0.0);
    for k in (0..n).filter(|&k| !residuals.outlier[k]) {
        along += change(k) * gap(k);
        square += change(k) * change(k);
    }
    let points = of_panel(n).map(|(posture, k)| PredictedPoint {
        posture,
        change: change(k),
        gap: gap(k),
        outlier: residuals.outlier[k],
    });
    Predicted {
        subject,
        axis,
        slope: along / square,
        points: points.collect(),
    }
}

/// Joints that are shown.
const SHOWN: usize = 6;

/// Moments (Nm) and forces (N) below this are written in thousandths.
const SMALL: f64 = 0.2;

/// What a residual is drawn against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// ° of a revolute joint, mm of a prismatic one.
    Position,
    /// Nm of a revolute joint, N of a prismatic one.
    Moment,
}

/// Residuals of one axis, m, at a value of the quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Place of its posture among those of the view.
    pub posture: usize,
    /// Position or moment of the joint, in the trend's unit.
    pub at: f64,
    /// Residual before, m.
    pub before: f64,
    /// Residual after, m.
    pub after: f64,
    /// Whether the posture is an outlier.
    pub outlier: bool,
}

/// Mean residuals of a bin, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Middle {
    /// Mean position or moment, in the trend's unit.
    pub at: f64,
    /// Mean residual before, m.
    pub before: f64,
    /// Mean residual after, m.
    pub after: f64,
}

/// Residuals against one quantity of one joint, on the axis that follows it more.
#[derive(Debug, Clone, PartialEq)]
pub struct Trend {
    /// Name of the joint.
    pub joint: String,
    /// Whether the explanation names it.
    pub named: bool,
    /// Unit of positions or moments.
    pub unit: &'static str,
    /// 0: x, 1: y.
    pub axis: usize,
    /// Part of the scatter that follows the quantity, before and after.
    pub share: [f64; 2],
    /// The postures.
    pub points: Vec<Point>,
    /// Means over bins of the quantity.
    pub means: Vec<Middle>,
}

/// The joints that the explanation names, and then those that the gap, or what is left of it,
/// goes with most.
fn strongest(
    problem: &Problem,
    found: &Explained,
    residuals: &Residuals,
    quantity: Quantity,
) -> Vec<Trend> {
    let of_rest = found.diagnosis.unexplained;
    let named = |joint: &str| {
        let mut steps = found.diagnosis.steps.iter();
        steps.position(|step| match &step.acts_on {
            ActsOn::Joints(joints) => joints.iter().any(|own| own == joint),
            _ => false,
        })
    };
    let (data, context) = (problem.data(), problem.context());
    let (n, dofs) = (data.len(), &context.robot.tree.dofs);
    // By joint, posture by posture, `width` apart.
    let (all, width) = match quantity {
        Quantity::Position => (data.q.clone(), dofs.len()),
        Quantity::Moment => (problem.first().moments_at(&data.q), 3 * dofs.len()),
    };
    let mut ranked = Vec::new();
    for (j, joint) in dofs.iter().enumerate() {
        let (factor, unit) = match (quantity, joint.prismatic) {
            (Quantity::Position, false) => (180.0 / std::f64::consts::PI, "°"),
            (Quantity::Position, true) => (1e3, "mm"),
            (Quantity::Moment, false) => (context.weight(), "Nm"),
            (Quantity::Moment, true) => (context.weight(), "N"),
        };
        let mut values: Vec<f64> = (0..n).map(|k| factor * all[k * width + j]).collect();
        let unit = match values.iter().fold(0.0, |most: f64, x| most.max(x.abs())) {
            most if quantity == Quantity::Moment && most < SMALL => {
                values.iter_mut().for_each(|x| *x *= 1e3);
                if joint.prismatic { "mN" } else { "mNm" }
            }
            _ => unit,
        };
        let kept = (0..n).filter(|&k| !residuals.outlier[k]).collect();
        let bins = Bins::new(kept, |k| values[k]);
        let both = [&residuals.before, &residuals.after];
        let followed = [0, 1].map(|axis| both.map(|e| bins.share(|row| e[row], axis..axis + 1)));
        let worth = followed.map(|own| own[usize::from(of_rest)].1);
        let axis = usize::from(worth[1] > worth[0]);
        let point = |(posture, k): (usize, usize)| Point {
            posture,
            at: values[k],
            before: residuals.before[2 * k + axis],
            after: residuals.after[2 * k + axis],
            outlier: residuals.outlier[k],
        };
        let step = named(&joint.joint);
        let trend = Trend {
            joint: joint.joint.clone(),
            named: step.is_some(),
            unit,
            axis,
            share: followed[axis].map(|(share, _)| share),
            points: of_panel(n).map(point).collect(),
            means: means(&bins, &values, residuals, axis),
        };
        ranked.push((step.unwrap_or(usize::MAX), worth[axis], trend));
    }
    ranked.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    ranked.truncate(SHOWN);
    ranked.into_iter().map(|(.., trend)| trend).collect()
}

fn means(bins: &Bins, values: &[f64], residuals: &Residuals, axis: usize) -> Vec<Middle> {
    let bins = bins.0.iter().filter(|bin| !bin.is_empty());
    let middle = |bin: &Vec<usize>| {
        let mean =
            |of: &dyn Fn(usize) -> f64| bin.iter().map(|&k| of(k)).sum::<f64>() / bin.len() as f64;
        Middle {
            at: mean(&|k| values[k]),
            before: mean(&|k| residuals.before[2 * k + axis]),
            after: mean(&|k| residuals.after[2 * k + axis]),
        }
    };
    bins.map(middle).collect()
}
