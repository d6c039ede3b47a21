//! A look at the data before any hypothesis: what no effect should be fitted to.
//!
//! ```text
//! constant      an axis of the CoP that does not move where CAD says it must
//! other foot    CAD on another link predicts the readings, on this one it does not
//! turned frame  CAD predicts them in a frame whose axes are permuted, this one's z not up
//! shuffled      readings scatter as CAD says, and go with no posture
//! stuck         an encoder that does not move, and a gap that motion of its joint explains
//! ```
//!
//! Every test asks for a gap far above the noise first: data that fit are healthy.

use nalgebra::Matrix3;
use sesc_model::{Function, Model, Snapping};

use super::findings::HealthFinding;
use crate::evaluate::Evaluator;
use crate::observations::postures::{Postures, rms};
use crate::robot::Robot;

/// A gap from which the frame is asked about, m.
const FAR_M: f64 = 0.02;
/// The right frame leaves no more than this part of the gap.
const FITS: f64 = 0.2;
/// An axis is dead if CAD moves it by so many deviations of its noise …
const MUST_MOVE: f64 = 20.0;
/// … and it goes with CAD by less than this correlation.
const UNRELATED: f64 = 0.3;
/// Postures that shuffling can be seen in, at least.
const ENOUGH: usize = 30;
/// Ratio of scatters that counts as the same.
const ALIKE: (f64, f64) = (0.6, 1.6);
/// Links that are tried as the other foot, at most.
const FEET: usize = 64;
/// Largest change of an encoder that does not move, rad or m.
const STILL: f64 = 1e-9;
/// Share of postures in which the joint is within its limits then, and χ² a reading from
/// which it is looked for.
const STUCK_SHARE: f64 = 0.9;
const STUCK_CHI2: f64 = 9.0;
/// A joint that its encoder does not follow moves by this, RMS, rad; m for a slide.
const LEAST_MOTION: (f64, f64) = (0.1, 0.02);
/// Part of χ² that may be left then, for masses are not known exactly; or this a posture.
const STUCK_LEFT: f64 = 0.02;
const STUCK_NOISE: f64 = 4.0;
/// Part of χ² from which one offset or one scale is the simpler explanation.
const SIMPLE_SHARE: f64 = 0.8;
/// Rounds of the search for where the joint is, and its largest step, rad or m.
const ROUNDS: usize = 8;
const LARGEST_STEP: f64 = 0.3;
/// How far a joint with a stuck encoder may be from where it says, rad; m for a slide.
const ANYWHERE: (f64, f64) = (0.5, 0.1);

/// What is found, and whether anything can be done with the data.
pub(super) struct Health {
    pub findings: Vec<HealthFinding>,
    pub usable: bool,
}

/// Examine a log; postures on a joint whose encoder is stuck count as little as is known
/// of them from then on.
pub(super) fn examine(
    robot: &Robot,
    model: &Model,
    snapping: Snapping,
    data: &mut Postures,
) -> Health {
    let n = data.len();
    let com = Evaluator::new(model, Function::Com).run(&data.q, n);
    let predicted: Vec<f64> = com.chunks_exact(3).flat_map(|c| [c[0], c[1]]).collect();
    let mut findings = dead_axes(data, &predicted);
    if findings.is_empty() {
        findings.extend(wrong_frame(robot, model, snapping, data, &com));
    }
    if findings.is_empty() {
        findings.extend(shuffled(data, &predicted));
    }
    let usable = findings.is_empty();
    if usable {
        findings.extend(stuck(model, data, &predicted));
    }
    Health { findings, usable }
}

fn finding(kind: &'static str, target: &str, sentence: String) -> HealthFinding {
    HealthFinding {
        kind,
        target: target.to_string(),
        sentence,
    }
}

fn axis(values: &[f64], axis: usize) -> Vec<f64> {
    values.iter().skip(axis).step_by(2).copied().collect()
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

/// Deviation from the mean, RMS.
fn scatter(x: &[f64]) -> f64 {
    let middle = mean(x);
    rms(x.iter().map(|x| x - middle))
}

/// Correlation of two columns; zero where one of them does not move.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (ma, mb) = (mean(a), mean(b));
    let both: f64 = a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum();
    let size = scatter(a) * scatter(b) * a.len() as f64;
    if size > 0.0 { both / size } else { 0.0 }
}

/// Axes of the sensor that show nothing.
fn dead_axes(data: &Postures, predicted: &[f64]) -> Vec<HealthFinding> {
    let dead: Vec<usize> = (0..2)
        .filter(|&k| {
            let (read, cad) = (axis(&data.reading, k), axis(predicted, k));
            let noise = rms(axis(&data.std, k).into_iter());
            let moves = scatter(&cad) > MUST_MOVE * noise;
            let constant = scatter(&read) < 1e-9;
            let silent = scatter(&read) < 3.0 * noise && correlation(&read, &cad).abs() < UNRELATED;
            data.len() > 2 && (constant && scatter(&cad) > noise || moves && silent)
        })
        .collect();
    let millimetres = |k: usize| 1e3 * scatter(&axis(predicted, k));
    match dead[..] {
        [] => Vec::new(),
        [k] => vec![finding(
            "cop_axis_dead",
            ["x", "y"][k],
            format!(
                "cop_{} does not move with the robot, where CAD moves it by {:.1} mm RMS: check \
                 the sensor's wiring and the column.",
                ["x", "y"][k],
                millimetres(k)
            ),
        )],
        _ => vec![finding(
            "cop_constant",
            "-",
            format!(
                "The CoP does not move with the robot, where CAD moves it by {:.1} mm RMS: check \
                 that the sensor is on and that its topic is the right one.",
                rms([millimetres(0), millimetres(1)].into_iter())
            ),
        )],
    }
}

/// Gap of the readings to a CoP, m RMS.
fn gap(data: &Postures, cop: impl Iterator<Item = f64>) -> f64 {
    rms(data.reading.iter().zip(cop).map(|(y, p)| y - p))
}

/// Another link, or other axes of this one, that the readings fit.
fn wrong_frame(
    robot: &Robot,
    model: &Model,
    snapping: Snapping,
    data: &Postures,
    com: &[f64],
) -> Option<HealthFinding> {
    let n = data.len();
    let here = gap(data, com.chunks_exact(3).flat_map(|c| [c[0], c[1]]));
    if here < FAR_M {
        return None;
    }
    let tree = &model.tree;
    let support = &tree.links[tree.support].name;
    let turned = axes_with_another_up().into_iter().map(|axes| {
        let row = |c: &[f64], k: usize| -> f64 { (0..3).map(|m| axes[(k, m)] * c[m]).sum() };
        gap(
            data,
            com.chunks_exact(3).flat_map(|c| [row(c, 0), row(c, 1)]),
        )
    });
    let turned = turned.fold(f64::INFINITY, f64::min);
    let leaves = leaf_links(robot).into_iter().filter(|link| link != support);
    let on = |link: String| {
        let model = robot.model(&link, snapping, None).ok()?;
        let cop = Evaluator::new(&model, Function::Cop).run(&data.q, n);
        Some((gap(data, cop.into_iter()), link))
    };
    let feet = leaves.take(FEET).filter_map(on);
    let foot = feet.min_by(|a, b| a.0.total_cmp(&b.0));
    match foot {
        Some((there, link)) if there < FITS * here && there <= turned => Some(finding(
            "other_foot",
            &link,
            format!(
                "The readings are {:.0} mm off on `{support}` and {:.1} mm on `{link}`: the robot \
                 stood on `{link}`; give that support.",
                1e3 * here,
                1e3 * there
            ),
        )),
        _ if turned < FITS * here => Some(finding(
            "frame_turned",
            support,
            format!(
                "The readings are {:.0} mm off in the frame of `{support}` and {:.1} mm where \
                 another of its axes points up: its z axis is not the normal of the sole; give a \
                 sole link as support.",
                1e3 * here,
                1e3 * turned
            ),
        )),
        _ => None,
    }
}

/// Rotations by right angles after which another axis than z is vertical.
fn axes_with_another_up() -> Vec<Matrix3<f64>> {
    let mut found = Vec::new();
    for (x, y, z) in [
        (0, 1, 2),
        (0, 2, 1),
        (1, 0, 2),
        (1, 2, 0),
        (2, 0, 1),
        (2, 1, 0),
    ] {
        for signs in 0..8 {
            let sign = |bit: usize| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let mut axes = Matrix3::zeros();
            axes[(0, x)] = sign(0);
            axes[(1, y)] = sign(1);
            axes[(2, z)] = sign(2);
            if axes.determinant() > 0.0 && z != 2 {
                found.push(axes);
            }
        }
    }
    found
}

/// Links that carry no joint: feet, hands, the head.
fn leaf_links(robot: &Robot) -> Vec<String> {
    let description = &robot.description;
    let carries = |link: &str| description.joints.iter().any(|joint| joint.parent == link);
    let links = description.links.iter().map(|link| link.name.clone());
    links.filter(|link| !carries(link)).collect()
}

/// Readings of other postures than those they stand beside.
fn shuffled(data: &Postures, predicted: &[f64]) -> Option<HealthFinding> {
    // Swapped axes go with the other one.
    let related = |a: usize, b: usize| {
        correlation(&axis(&data.reading, a), &axis(predicted, b)).abs() >= UNRELATED
    };
    let unrelated = (0..2).all(|k| {
        let (read, cad) = (axis(&data.reading, k), axis(predicted, k));
        let ratio = scatter(&read) / scatter(&cad);
        let alike =
            (ALIKE.0..ALIKE.1).contains(&ratio) && (mean(&read) - mean(&cad)).abs() < scatter(&cad);
        let moves = scatter(&cad) > MUST_MOVE * rms(axis(&data.std, k).into_iter());
        alike && moves && !related(k, 0) && !related(k, 1)
    });
    (unrelated && data.len() >= ENOUGH).then(|| {
        finding(
            "rows_shuffled",
            "-",
            "Readings scatter as CAD says and go with no posture: rows of the CoP and of the \
             joints do not belong together; check how they were joined."
                .to_string(),
        )
    })
}

/// A joint that does not move in the log though the CoP says that it does.
fn stuck(model: &Model, data: &mut Postures, predicted: &[f64]) -> Option<HealthFinding> {
    let (n, dof) = (data.len(), model.dof());
    let whitened = |row: usize| (data.reading[row] - predicted[row]) / data.std[row];
    let total: f64 = (0..2 * n).map(|row| whitened(row).powi(2)).sum();
    if total < STUCK_CHI2 * (2 * n) as f64 || n < 3 {
        return None;
    }
    let still = |joint: &usize| {
        let column = (0..n).map(|k| data.q[k * dof + joint]);
        let (low, high) = column.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
            (a.min(x), b.max(x))
        });
        high - low < STILL
    };
    // Where another effect is the cause, the joint would hardly have to move, or too far.
    let believable = |moved: &Moved| {
        let dof_of = &model.tree.dofs[moved.joint];
        let range = (dof_of.upper - dof_of.lower).max(1e-6);
        let within = |k: &usize| {
            let at = data.q[k * dof + moved.joint] + moved.far[*k];
            (dof_of.lower - 0.1 * range..=dof_of.upper + 0.1 * range).contains(&at)
        };
        let inside = (0..n).filter(within).count();
        let least = if dof_of.prismatic {
            LEAST_MOTION.1
        } else {
            LEAST_MOTION.0
        };
        scatter(&moved.far) > least && inside as f64 >= STUCK_SHARE * n as f64
    };
    let joints = (0..dof).filter(still);
    let moved = joints.map(|joint| Moved::of(model, data, joint));
    let best = moved
        .filter(believable)
        .min_by(|a, b| a.left.total_cmp(&b.left))?;
    let least_left = (STUCK_LEFT * total).max(STUCK_NOISE * n as f64);
    if best.left > least_left {
        return None;
    }
    let (joint, most) = (best.joint, total - best.left);
    let slopes = Evaluator::new(model, Function::ComJacobian).run(&data.q, n);
    let slope = |k: usize, axis: usize, joint: usize| slopes[(3 * k + axis) * dof + joint];
    // One offset or scale for all postures is simpler than one unknown for each.
    let by_one = |joint: usize, scale: bool| {
        let column = |row: usize| {
            let by = if scale {
                data.q[row / 2 * dof + joint]
            } else {
                1.0
            };
            by * slope(row / 2, row % 2, joint) / data.std[row]
        };
        let along: f64 = (0..2 * n).map(|row| column(row) * whitened(row)).sum();
        let size: f64 = (0..2 * n).map(|row| column(row).powi(2)).sum();
        along * along / size.max(1e-30)
    };
    let simple = (0..dof).flat_map(|joint| [by_one(joint, false), by_one(joint, true)]);
    if simple.fold(0.0, f64::max) > SIMPLE_SHARE * total {
        return None;
    }
    let dof_of = &model.tree.dofs[joint];
    let anywhere = if dof_of.prismatic {
        ANYWHERE.1
    } else {
        ANYWHERE.0
    };
    let wider: Vec<f64> = (0..2 * n)
        .map(|row| data.std[row].hypot(anywhere * slope(row / 2, row % 2, joint)))
        .collect();
    data.std = wider;
    Some(finding(
        "encoder_stuck",
        &dof_of.joint,
        format!(
            "The encoder of {} does not move and the CoP does as if the joint did ({:.0} % of \
             the gap): check its cable; readings count only for what its joint cannot move.",
            dof_of.joint,
            100.0 * most / total
        ),
    ))
}

/// The postures with one joint moved to where the readings are explained best.
struct Moved {
    joint: usize,
    /// Posture by posture, rad or m.
    far: Vec<f64>,
    /// χ² that is left.
    left: f64,
}

impl Moved {
    /// One unknown a posture, by Gauss and Newton.
    fn of(model: &Model, data: &Postures, joint: usize) -> Moved {
        let (n, dof) = (data.len(), model.dof());
        let (cop, slopes) = (
            Evaluator::new(model, Function::Cop),
            Evaluator::new(model, Function::ComJacobian),
        );
        let mut q = data.q.clone();
        let mut far = vec![0.0; n];
        let mut left = f64::INFINITY;
        for round in 0..=ROUNDS {
            let (at, by) = (cop.run(&q, n), slopes.run(&q, n));
            let gap = |row: usize| (data.reading[row] - at[row]) / data.std[row];
            left = (0..2 * n).map(|row| gap(row).powi(2)).sum();
            if round == ROUNDS {
                break;
            }
            for k in 0..n {
                let s =
                    [0, 1].map(|axis| by[(3 * k + axis) * dof + joint] / data.std[2 * k + axis]);
                let along = s[0] * gap(2 * k) + s[1] * gap(2 * k + 1);
                let step = along / (s[0] * s[0] + s[1] * s[1]).max(1e-30);
                far[k] += step.clamp(-LARGEST_STEP, LARGEST_STEP);
                q[k * dof + joint] = data.q[k * dof + joint] + far[k];
            }
        }
        Moved { joint, far, left }
    }
}
