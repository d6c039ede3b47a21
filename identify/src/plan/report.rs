//! What a plan says: the postures in their order, and what they will tell.

use std::path::PathBuf;

use serde::Serialize;

use super::candidates::Counts;
use super::efficiency::Efficiency;
use super::joint_use::JointUse;
use super::lessons::Lesson;
use super::revisits::Revisits;
use crate::Error;
use crate::feet::Offset;
use crate::logs::{LogSource, PostureWriter, Row, Sidecar, Table};
use crate::next_steps::NextStep;

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
        let worst = self.offsets.iter().max_by(|a, b| a.std.total_cmp(&b.std));
        match worst {
            Some(worst) => format!(
                "both soles on the floor, `{}` the other: how it lies tells an offset of each of {} \
                 joints, of `{}` worst (± {:.2}°)",
                self.other_foot,
                self.offsets.len(),
                worst.joint,
                worst.std.to_degrees()
            ),
            None => format!("both soles on the floor, `{}` the other", self.other_foot),
        }
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
        let clear = format!(
            "{}: {} balanced, {} of them clear of the ground",
            draws.drawn, draws.balanced, draws.clear
        );
        match self.collision_checked {
            true => format!(
                "{clear}, {} of these free of self-collision",
                draws.collision_free
            ),
            false => clear,
        }
    }

    /// The postures as a log in memory, those that come back included.
    pub fn log(&self) -> LogSource {
        let (poses, rows): (Vec<i64>, Vec<&[f64]>) = self.rows().unzip();
        let table = Table::new("plan").integers("pose", poses);
        let joints = self.joints.iter().enumerate();
        let table = joints.fold(table, |table, (k, joint)| {
            let values: Vec<f64> = rows.iter().map(|q| q[k]).collect();
            table.numbers(&joint.joint, values)
        });
        LogSource::from(table).with_sidecar(self.sidecar())
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

    fn sidecar(&self) -> Sidecar {
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
        self.chosen
            .iter()
            .map(move |&k| &self.q[k * dof..(k + 1) * dof])
    }
}
