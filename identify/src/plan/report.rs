//! A plan: the postures in their order, what they ask of the joints, and what they will tell.
//!
//! # Lessons
//!
//! Each posture teaches something, one after the other:
//!
//! ```text
//! K = C Aᵀ (A C Aᵀ + σ² I)⁻¹        C ← C − K A C        σ_p = √C_pp
//! ```
//!
//! A are the two CoP rows of a posture, C is the covariance of the base parameters before it, at
//! first that of the prior. The lesson of a posture is the parameter whose σ_p falls by the
//! largest part.
//!
//! # Revisits
//!
//! What visits of one posture differ by is seen where postures are reached again, and in no other way:
//!
//! ```text
//! reading of a visit = CoP(q) + v + e        v ~ N(0, σ_visit²) per visit, e per reading
//! ```
//!
//! Readings of one visit agree to e, however many they are; a fit that takes them for repeats
//! believes itself too exact by √(1 + σ_visit² n/σ_e²). A log that has visits tells both, and the
//! plan counts a posture as known to √(σ_visit² + σ_e²/n).

use std::path::PathBuf;

use nalgebra::DMatrix;
use serde::Serialize;
use sesc_model::base::Column;
use sesc_model::{Model, Snapping};

use super::Request;
use super::candidates::Counts;
use super::design::Efficiency;
use super::limits::Limits;
use crate::Error;
use crate::NextStep;
use crate::feet::{Offset, Places};
use crate::logs::{Options, PostureWriter, ROOM, Readings, Row, Samples, Sidecar};
use crate::observations::noise::NoiseSource;
use crate::observations::postures::{Postures, range};
use crate::observations::revisits::{COUNT, spread};
use crate::watch::Watch;

/// Postures to take, in their order, and what a fit of them will know.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Plan {
    /// The robot's name.
    pub robot: String,
    /// Hash of the URDF.
    pub hash: String,
    /// The link on the ground.
    pub support: String,
    /// Number of postures.
    pub poses: usize,
    /// Where the CoP stays, in words.
    pub cop_region: String,
    /// Safety margin of the CoP, deviations.
    pub sigmas: f64,
    /// What was drawn.
    pub draws: Counts,
    /// Postures that were chosen from.
    pub candidates: usize,
    /// What the later fit knows beforehand.
    pub prior: String,
    /// Standard deviation of a reading, m.
    pub noise: f64,
    /// Directions that the candidates tell.
    pub directions: usize,
    /// Directions that the chosen postures tell.
    pub rank: usize,
    /// Condition number.
    pub condition_number: f64,
    /// Expected RMS error of the CoP, m; over all candidates.
    pub expected_error: Option<f64>,
    /// The same for random postures, on average.
    pub expected_error_random: Option<f64>,
    /// Both over the number of postures.
    pub curve: Vec<Efficiency>,
    /// What each posture teaches.
    pub lessons: Vec<Lesson>,
    /// log det of information over prior; greedy, then per round of exchanges.
    pub log_det: Vec<f64>,
    /// Exchanges that improved the greedy choice.
    pub exchanges: usize,
    /// How far the joints move between postures.
    pub motion: Motion,
    /// What was kept clear of the ground.
    pub clearance: String,
    /// What was kept from colliding.
    pub collision: String,
    /// Whether collisions were checked.
    pub collision_checked: bool,
    /// Pairs of bodies that touch at rest.
    pub collision_exempt: Vec<[String; 2]>,
    /// What was noticed.
    pub notes: Vec<String>,
    /// Corners of the CoP's region, counter-clockwise, m.
    pub corners: Vec<[f64; 2]>,
    /// Distance from the edges, m.
    pub margin: f64,
    /// Predicted CoP of the postures, m.
    pub cop: Vec<[f64; 2]>,
    /// Postures that come back after the last.
    pub revisits: Revisits,
    /// What the soles will tell, where both are on the floor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub both_feet: Option<TwoFeet>,
    /// What the chosen postures ask of every joint.
    pub joints: Vec<JointUse>,
    /// The chosen candidates in their order.
    #[serde(skip)]
    pub chosen: Vec<usize>,
    /// All candidates, `q[k * dof + joint]`, rad or m.
    #[serde(skip)]
    pub q: Vec<f64>,
}

/// What the soles of a plan on both feet will tell.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TwoFeet {
    /// Link of the other sole.
    pub other_foot: String,
    /// Detectable offsets between the soles; those that move no sole are left out.
    pub offsets: Vec<Offset>,
}

impl TwoFeet {
    /// In a few words.
    pub fn sentence(&self) -> String {
        let mut said = format!("both soles on the floor, `{}` the other", self.other_foot);
        let worst = self.offsets.iter().max_by(|a, b| a.std.total_cmp(&b.std));
        if let Some(worst) = worst {
            said += &format!(
                ": how it lies tells an offset of each of {} joints, of `{}` worst (± {:.2}°)",
                self.offsets.len(),
                worst.joint,
                worst.std.to_degrees()
            );
        }
        said
    }
}

/// The largest joint displacement from posture to posture, summed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Motion {
    /// In the order of choice, rad or m.
    pub as_chosen: f64,
    /// In the order of the plan.
    pub ordered: f64,
}

impl Plan {
    /// What became of the draws, in words.
    pub fn drawn(&self) -> String {
        let draws = &self.draws;
        let mut said = format!(
            "{}: {} balanced, {} of them clear of the ground",
            draws.drawn, draws.balanced, draws.clear
        );
        if self.collision_checked {
            said += &format!(", {} of these free of self-collision", draws.collision_free);
        }
        said
    }

    /// Write the postures as a log, those that come back included; gives back where its
    /// sidecar is.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, mut log: PostureWriter) -> Result<Option<PathBuf>, Error> {
        for (pose, q) in self.rows() {
            log.row(&Row {
                pose,
                q,
                ..Row::default()
            })?;
        }
        log.finish(&self.sidecar())
    }

    /// The rows of its file: the number of each posture, from 1, and the posture; those that
    /// come back are last.
    pub fn rows(&self) -> impl Iterator<Item = (i64, &[f64])> {
        let postures: Vec<&[f64]> = self.postures().collect();
        let again = self.revisits.poses.iter().copied();
        let again = again.filter(|_| self.revisits.written);
        let numbers = (1..=postures.len() as i64).chain(again);
        numbers.map(move |pose| (pose, postures[pose as usize - 1]))
    }

    /// The sidecar of its file.
    pub fn sidecar(&self) -> Sidecar {
        Sidecar {
            robot: Some(self.robot.clone()),
            support: Some(self.support.clone()),
            both_feet: self.both_feet.as_ref().map(|_| true),
            other_foot: self.both_feet.as_ref().map(|feet| feet.other_foot.clone()),
            ..Sidecar::default()
        }
    }

    /// What to do with the postures: record them, and fit the log.
    pub fn next_steps(&self) -> Vec<NextStep> {
        let names = self.joints.iter().map(|own| own.joint.clone());
        vec![
            NextStep::Record {
                joints: names.collect(),
                revolute: self.joints.iter().any(|own| !own.prismatic),
                prismatic: self.joints.iter().any(|own| own.prismatic),
                support: self.support.clone(),
            },
            // A log that is still to come has no sidecar that names its support link.
            NextStep::Fit {
                support: Some(self.support.clone()),
            },
        ]
    }

    /// The chosen postures in their order, rad or m.
    pub fn postures(&self) -> impl Iterator<Item = &[f64]> {
        let dof = self.q.len() / self.candidates.max(1);
        let chosen = self.chosen.iter();
        chosen.map(move |&k| &self.q[k * dof..(k + 1) * dof])
    }
}

/// What postures ask of a joint, rad or m.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JointUse {
    /// The joint's name.
    pub joint: String,
    /// Whether `limits`, `values` and `used` are m.
    pub prismatic: bool,
    /// What was allowed.
    pub limits: [f64; 2],
    /// Posture by posture, in their order.
    #[serde(skip)]
    pub values: Vec<f64>,
    /// Least and largest of these.
    pub used: [f64; 2],
}

/// What the chosen postures ask of every joint.
pub(super) fn joint_use(
    model: &Model,
    limits: &Limits,
    q: &[f64],
    chosen: &[usize],
) -> Vec<JointUse> {
    let dof = model.dof();
    let of_joint = |j: usize| {
        let values: Vec<f64> = chosen.iter().map(|k| q[k * dof + j]).collect();
        let (least, largest) = range(values.iter().copied());
        JointUse {
            joint: model.tree.dofs[j].joint.clone(),
            prismatic: model.tree.dofs[j].prismatic,
            limits: limits.ranges[j].into(),
            used: [least, largest],
            values,
        }
    };
    (0..dof).map(of_joint).collect()
}

/// The parameter that a posture tells most of.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Lesson {
    /// Name of the base parameter.
    pub parameter: String,
    /// `m`; `1` for a mass fraction.
    pub unit: &'static str,
    /// Standard deviation before it.
    pub before: f64,
    /// Standard deviation after it.
    pub after: f64,
}

/// The lessons of postures in their `order`: `regressor` is φᵀ as columns, two per candidate,
/// `prior` a factor of the covariance that is known beforehand, `noise` that of a reading, m.
pub(super) fn lessons(
    model: &Model,
    regressor: &DMatrix<f64>,
    prior: &DMatrix<f64>,
    noise: f64,
    order: &[usize],
) -> Vec<Lesson> {
    let lesson = |pair: &[Vec<f64>]| {
        let part = |k: &usize| pair[1][*k] / pair[0][*k];
        let known = (0..pair[0].len()).filter(|k| part(k).is_finite());
        let k = known.min_by(|a, b| part(a).total_cmp(&part(b)))?;
        let param = &model.base.params[k];
        Some(Lesson {
            parameter: param.name.clone(),
            unit: match param.column {
                Column::Prismatic { .. } => "1",
                Column::Axis { .. } => "m",
            },
            before: pair[0][k],
            after: pair[1][k],
        })
    };
    let steps = deviations(regressor, prior, noise, order);
    steps.windows(2).filter_map(lesson).collect()
}

/// Deviations of all parameters before the first posture and after each.
fn deviations(
    regressor: &DMatrix<f64>,
    prior: &DMatrix<f64>,
    noise: f64,
    order: &[usize],
) -> Vec<Vec<f64>> {
    let mut covariance = prior * prior.transpose();
    let of = |covariance: &DMatrix<f64>| -> Vec<f64> {
        let variances = covariance.diagonal();
        variances.iter().map(|x| x.max(0.0).sqrt()).collect()
    };
    let mut all = vec![of(&covariance)];
    for &k in order {
        let rows = regressor.columns(2 * k, 2);
        let spread = &covariance * rows;
        let reading = rows.tr_mul(&spread) + DMatrix::identity(2, 2) * noise.powi(2);
        if let Some(inverse) = reading.try_inverse() {
            covariance -= &spread * inverse * spread.transpose();
        }
        all.push(of(&covariance));
    }
    all
}

/// Postures of a plan that should come back.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Revisits {
    /// Their numbers, in order.
    pub poses: Vec<i64>,
    /// Whether the file has rows for them.
    pub written: bool,
    /// Why, as a sentence; where there are none, what is known.
    pub sentence: String,
}

/// Standard deviation of a reading as it enters the fit, and what visits differ by, m: as the log
/// of a request says it, if it has one; none of visits where no posture was reached again.
pub(super) fn known(request: &Request, watch: &mut dyn Watch) -> Result<(f64, Option<f64>), Error> {
    let Some(log) = &request.log else {
        return Ok((request.noise, None));
    };
    let (robot, model) = (&request.robot, &request.model);
    let links = robot.description.link_names();
    let options = Options {
        readings: Readings::Required,
        links: links.map(str::to_string).collect(),
        support: Some(model.support().to_string()),
        soles: Some(Places::of(robot, Snapping::default())),
        both_feet: request.feet.said(),
        ..Options::default()
    };
    let samples = Samples::read(log, &robot.description, &options, ROOM, watch)?;
    let data = Postures::read(&samples, model, (None, 0.0), watch)?;
    let rows = data.summary.as_ref().map_or(1.0, |found| found.rows as f64);
    let per_posture = (rows / data.postures.max(1) as f64).max(1.0);
    let is_known = data.noise_source != NoiseSource::Residuals && data.noise > 0.0;
    let single = match data.visits {
        // Where visits are one reading each, its noise is part of what they differ by.
        Some(visits) if visits.std > 0.0 => visits.readings_std.unwrap_or(0.0),
        _ if is_known => data.noise * per_posture.sqrt(),
        _ => request.noise,
    };
    let visits = data.visits.map(|visits| visits.std);
    Ok((single.hypot(visits.unwrap_or(0.0)), visits))
}

/// Which of the chosen postures come back, spread over what their `rows` tell.
pub(super) fn revisits(request: &Request, visits: Option<f64>, rows: &DMatrix<f64>) -> Revisits {
    let usual = visits.map_or(COUNT.min(request.poses / 2), |_| 0);
    let count = request.revisits.unwrap_or(usual).min(request.poses);
    let poses = spread(rows, count).into_iter().map(|k| k as i64 + 1);
    let poses: Vec<i64> = poses.collect();
    let written = request.revisits.is_some() && !poses.is_empty();
    let names: Vec<String> = poses.iter().map(i64::to_string).collect();
    let how = match written {
        true => ", as the last rows of the file",
        false => ", and log them under the same numbers",
    };
    let sentence = match (poses.is_empty(), visits) {
        (true, Some(visits)) => format!(
            "none: the log says that visits of one posture differ by {:.2} mm",
            1e3 * visits
        ),
        (true, None) => "none: what visits of one posture differ by stays unknown".to_string(),
        (false, _) => format!(
            "reach poses {} once again after the others{how}: what visits of one posture differ by \
             is not known",
            names.join(", ")
        ),
    };
    Revisits {
        poses,
        written,
        sentence,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the inverse of the whole information.
    #[test]
    fn deviations_after_all_postures_are_those_of_one_fit() {
        let regressor = DMatrix::from_fn(4, 12, |i, j| ((i * 31 + j * j * 7) as f64 * 0.61).sin());
        let entry = |i: usize, j: usize| if i == j { 0.5 } else { 0.05 * (i + j) as f64 };
        let prior = DMatrix::from_fn(4, 4, entry);
        let (noise, order) = (0.2, [4, 0, 3]);
        let steps = deviations(&regressor, &prior, noise, &order);
        assert_eq!(steps.len(), 4);
        let own = |count: usize| {
            let columns = order[..count].iter().flat_map(|k| [2 * k, 2 * k + 1]);
            let columns: Vec<usize> = columns.collect();
            let rows = regressor.select_columns(&columns) / noise;
            let information =
                (&prior * prior.transpose()).try_inverse().unwrap() + &rows * rows.transpose();
            information.try_inverse().unwrap()
        };
        for (count, step) in steps.iter().enumerate() {
            let expected = own(count);
            for (k, std) in step.iter().enumerate() {
                let off = std / expected[(k, k)].sqrt() - 1.0;
                assert!(off.abs() < 1e-9, "{count} {k}: {off}");
            }
        }
    }
}
