//! Options that commands share: the robot, how a log is read, what becomes of its rows.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use sesc_identify::diagnose::Request;
use sesc_identify::feet::Feet;
use sesc_identify::fit::MotionModel;
use sesc_identify::fit::prior::{Prior, PriorChoice};
use sesc_identify::logs::{Angles, LogSource, Stays};
use sesc_identify::robot::{Robot, Stance};
use sesc_identify::skeleton::Skeleton;
use sesc_model::tree::sole_of;
use sesc_model::{Model, ModelFile, Snapping};

use super::values::{self, MOTION, one_of};
use super::{message, notes};
use crate::Error;

/// How a log is read, and what is known before it.
#[derive(Args)]
pub(super) struct ReadingArguments {
    /// Revolute joints are logged in degrees
    #[arg(long)]
    pub(super) degrees: bool,
    /// Tolerances of CAD: tight (mass 0.2 %, CoM 0.1 mm), cad (10 %, 5 mm), free, or a TOML file:
    /// [default] mass = 0.1, com = 0.005 (m); [links.NAME] likewise, and mass_kg; or what
    /// `fleet --prior-out` wrote; or the model file of this robot that `fit` wrote when it was
    /// healthy. Unless given, tight for diagnoses, and cad for `fit` and the
    /// parameters of `fleet`
    #[arg(long, value_name = "tight|cad|free|FILE")]
    pub(super) prior: Option<String>,
    /// Standard deviation of a single reading on one axis, m; from the log unless given
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = values::number("noise"))]
    pub(super) noise: Option<f64>,
    /// Compare readings with the ZMP where a log with `t` knows accelerations, or take all as
    /// those of standing postures
    #[arg(long, value_parser = one_of(MOTION), default_value = MOTION[0].0)]
    pub(super) motion: MotionModel,
}

impl ReadingArguments {
    pub(super) fn angles(&self) -> Option<Angles> {
        self.degrees.then_some(Angles::Deg)
    }

    /// The prior that is named, or this one.
    pub(super) fn prior_or(&self, usual: &str) -> PriorChoice {
        PriorChoice::from(self.prior.as_deref().unwrap_or(usual))
    }
}

/// How a log is diagnosed.
#[derive(Args)]
pub(super) struct DiagnosisArguments {
    #[command(flatten)]
    pub(super) reading: ReadingArguments,
    /// Added to the noise in quadrature, m: what encoder ticks do
    #[arg(
        long,
        value_name = "M",
        default_value = "0.0001",
        allow_negative_numbers = true, value_parser = values::number("floor")
    )]
    pub(super) floor: f64,
}

impl DiagnosisArguments {
    /// Ask about a log so.
    pub(super) fn request(
        &self,
        robot: Arc<Robot>,
        log: LogSource,
        standing: &StandingArguments,
        feet: &FeetArguments,
        stays: &StaysArguments,
    ) -> Result<Request, Error> {
        let mut request = Request::new(robot, log);
        request.support = standing.support()?;
        request.snapping = standing.snapping();
        request.angles = self.reading.angles();
        request.prior = self.reading.prior_or(Prior::OF_DIAGNOSES);
        request.noise = self.reading.noise;
        request.floor = self.floor;
        request.motion = self.reading.motion;
        request.stays = stays.into();
        request.feet = feet.into();
        Ok(request)
    }
}

/// How far readings may be shifted.
#[derive(Args)]
pub(super) struct OffsetArguments {
    /// How far all readings may be shifted before a log says so, standard deviation, m: a frame of
    /// the foot, the corner of a force plate, the zero of a sensor. 0 for not at all; 0.003 or 0.03,
    /// whichever is likelier, unless given
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = values::number("offset"))]
    pub(super) offset: Option<f64>,
}

/// What becomes of rows in which the robot holds still.
#[derive(Args)]
pub(super) struct StaysArguments {
    /// Take only rows of stays: stretches of at least so many seconds in which every joint is
    /// slower than 0.02 rad/s; each is one posture. Recordings of ROS have 0.3 s unless given,
    /// where the robot holds still at all. 0 takes every row as one of a robot that moves.
    /// Else rows of a stay of a second are one posture where a log has `t` and no `pose`
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = values::stays)]
    pub(super) settle: Option<Stays>,
}

impl From<&StaysArguments> for Stays {
    fn from(arguments: &StaysArguments) -> Stays {
        arguments.settle.unwrap_or_default()
    }
}

/// Which feet are on the floor.
#[derive(Args)]
pub(super) struct FeetArguments {
    /// Both soles are flat on one floor in every row (`both_feet` in the sidecar): joint offsets
    /// show in how they lie. The CoP is that of both feet together
    #[arg(long)]
    pub(super) both_feet: bool,
    /// The link that is the other sole (`other_foot` in the sidecar), or the sole of one:
    /// `l_foot@40mm`; by its name unless given, at the height of the support's
    #[arg(long, value_name = "LINK")]
    pub(super) other_foot: Option<String>,
}

impl From<&FeetArguments> for Feet {
    fn from(arguments: &FeetArguments) -> Feet {
        Feet {
            both: arguments.both_feet.then_some(true),
            other: arguments.other_foot.clone(),
        }
    }
}

/// The robot of a command.
#[derive(Args)]
pub(super) struct RobotArguments {
    /// Robot description; `-` is standard input
    #[arg(value_name = "URDF")]
    pub(super) urdf: PathBuf,
    #[command(flatten)]
    pub(super) standing: StandingArguments,
}

/// What the robot stands on, and how its right angles are read.
#[derive(Args)]
pub(super) struct StandingArguments {
    /// Link that stands on the ground; its sole is z = 0 of its frame. Parameters are those of
    /// this link, and rows of a log stand on it unless a column `support` says otherwise
    #[arg(long, value_name = "LINK")]
    support: Option<String>,
    /// Height of the support link's origin over its sole, along z, m, where it is not in the sole.
    /// `--support foot --sole-height 0.04` is short for `--support foot@40mm`, which sidecars,
    /// build scripts and sesc.toml take, too
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = values::number("sole_height"))]
    sole_height: Option<f64>,
    /// Take decimals of right angles (1.5708) literally
    #[arg(long)]
    pub(super) no_snap: bool,
    /// Expand the robot description by the program `xacro`, which runs code that stands in it, as
    /// where its name ends in `.xacro`
    #[arg(long)]
    xacro: bool,
}

impl StandingArguments {
    /// What the robot stands on: a link, or the sole of one.
    pub(super) fn support(&self) -> Result<Option<String>, Error> {
        match (&self.support, self.sole_height) {
            (link, None) => Ok(link.clone()),
            (Some(link), Some(height)) if height.is_finite() => Ok(Some(sole_of(link, height))),
            (Some(_), Some(_)) => Err(Error::Usage(
                "--sole-height: give a number of metres".to_string(),
            )),
            (None, Some(_)) => Err(Error::Usage(
                "--sole-height: name the link that has this sole by --support".to_string(),
            )),
        }
    }

    /// Read the URDF that was typed.
    pub(super) fn robot(&self, urdf: &Path) -> Result<Robot, Error> {
        let typed = Robot::read_typed(urdf, self.xacro)?;
        if typed.expanded {
            message(&format!(
                "note: {} was expanded by xacro, which ran code of that file",
                urdf.display()
            ));
        }
        Ok(typed.robot)
    }

    /// The robot on a support link as pages draw it, with the meshes beside its URDF.
    pub(super) fn skeleton(
        &self,
        robot: &Robot,
        support: &str,
        urdf: Option<&Path>,
    ) -> Result<Skeleton, Error> {
        let model = robot.model(support, self.snapping(), None)?;
        let folder = urdf.and_then(Path::parent);
        Ok(Skeleton::of(&model, &robot.description, folder))
    }

    pub(super) fn snapping(&self) -> Snapping {
        if self.no_snap {
            Snapping::Off
        } else {
            Snapping::default()
        }
    }
}

impl RobotArguments {
    /// The robot, with the parameters of a model file if one is given.
    pub(super) fn stance(&self, model_file: Option<&Path>) -> Result<Stance, Error> {
        let mut stance = Stance::new(self.standing.robot(&self.urdf)?);
        stance.support = self.standing.support()?;
        stance.snapping = self.standing.snapping();
        Ok(match model_file {
            Some(path) => stance.with_parameters(ModelFile::read(path)?)?,
            None => stance,
        })
    }

    /// Read the robot and build its model, saying on stderr what was noticed.
    pub(super) fn load(&self, model_file: Option<&Path>) -> Result<(Arc<Robot>, Model), Error> {
        let stance = self.stance(model_file)?;
        let model = stance.model()?;
        notes(&model.tree.notes);
        // Effects of a model file that no posture alone shows.
        notes(&model.cautions());
        Ok((stance.robot, model))
    }
}
