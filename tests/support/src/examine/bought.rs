//! Robots as they are bought: every link is off CAD by 10 % of its mass and 5 mm, an effect is
//! hidden, and a log of the healthy robot may be there.

use std::path::Path;
use std::sync::Arc;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Diagnosis, Request, Verdict};
use sesc_model::ModelFile;
use sesc_reference::{Robot as TrueRobot, World};

use super::{Failure, com_error, left_by_file, reread, robot};
use crate::hidden::hide_all;
use crate::judge::{Answer, truth};
use crate::log::{Log, Style};
use crate::poses::Poses;
use crate::recording::normal;
use crate::stage::Postures;
use crate::trial::Trial;

/// Postures of the healthy log, of the one with the fault, and of those that judge.
const HEALTHY: usize = 200;
const FAULTY: usize = 100;
const JUDGED: usize = 200;

/// The robot as it might really be: every link's mass off by 10 %, its CoM by 5 mm an axis.
pub fn bought(cad: &TrueRobot, random: &mut ChaCha8Rng) -> TrueRobot {
    let mut gauss = |std: f64| std * normal(random);
    let mut robot = cad.clone();
    for link in cad.links().iter().filter(|link| link.mass_kg > 0.0) {
        let mass = link.mass_kg * (1.0 + gauss(0.1)).max(0.2);
        let com = link.com_m.coords.map(|c| c + gauss(0.005));
        // A point mass that makes it so.
        let extra = mass - link.mass_kg;
        let at = (com * mass - link.com_m.coords * link.mass_kg) / extra;
        robot = robot
            .with_point_mass(&link.name, extra, at.into())
            .expect("a link of the robot");
    }
    robot
}

/// What became of one log.
#[derive(Debug, Clone)]
pub struct Found {
    /// The log: its seed, its robot and what is hidden.
    pub log: String,
    /// What the diagnosis comes to.
    pub said: String,
    /// What is hidden is the answer, masses aside.
    pub alone: bool,
    /// It is the answer or of the class.
    pub listed: bool,
    /// It is of the answer, and something that is not hidden as well.
    pub beside: bool,
    /// Something is named, and nothing of it is hidden or of its class.
    pub wrong: bool,
    /// The written model predicts its own log as the diagnosis states.
    pub agrees: bool,
    /// CoM error of the written model over CAD's, fresh postures.
    pub ratio: f64,
}

/// Diagnoses a log of a bought robot with what `trial` hides, beside a log of the healthy robot
/// where that is wanted.
///
/// # Errors
/// Where the log cannot be taken or diagnosed, or its model not be read.
pub fn examine(trial: &Trial, healthy: bool, folder: &Path) -> Result<Found, Failure> {
    let stage = &trial.stage;
    let mut random = ChaCha8Rng::seed_from_u64(!trial.seed);
    let cad = TrueRobot::from_urdf(&std::fs::read_to_string(&stage.urdf)?)?;
    let sound = World::new(&bought(&cad, &mut random), stage.support)?;
    let world = hide_all(sound.clone(), &trial.hidden)?;
    let mut take = |world: &World, postures: usize, name: &str| {
        let poses = Poses::draw(stage, Postures::Bench(postures), false, &mut random);
        let log = Log::take(stage, world, &poses, Style::default(), &mut random);
        log.write(folder, &format!("{name}_{}_{healthy}", trial.seed))
    };
    let before = take(&sound, HEALTHY, "before");
    let log = take(&world, FAULTY, "bought");
    let robot = robot(stage)?;
    let mut request = Request::new(Arc::clone(&robot), log.as_path());
    if healthy {
        request.healthy = vec![before.as_path().into()];
    }
    let report = diagnose::diagnose(&request, &mut ())?;
    let file = reread(&report.model_file)?;
    let q = stage.balanced(JUDGED, &mut random);
    let error = |file: Option<&ModelFile>| com_error(stage, &world, file, &q, 0..2);
    let ratio = error(Some(&file))? / error(None)?;
    let left = left_by_file(&report, &robot, stage.support, &log.as_path().into())?;
    let on_log = &report.diagnosis.model_on_log;
    let least = on_log.stated_rmse.max(report.diagnosis.noise_floor);
    let agrees = (left - on_log.stated_rmse).abs() <= 0.01 * least;
    judged(trial, &report.diagnosis, (ratio, agrees))
}

fn judged(
    trial: &Trial,
    found: &Diagnosis,
    (ratio, agrees): (f64, bool),
) -> Result<Found, Failure> {
    let mut answer = Answer::read(&serde_json::to_value(found)?)?;
    let said = format!("{}: {:?}", answer.verdict, found.indistinguishable);
    let hidden = truth(&trial.hidden);
    // That masses are off is true of every robot.
    let groups = answer.groups.iter_mut();
    for labels in groups.chain([&mut answer.steps]) {
        labels.retain(|label| !label.starts_with("mass_distribution"));
    }
    let explained = matches!(found.verdict, Verdict::Named | Verdict::Class);
    let alone = explained && answer.is(&hidden);
    let listed = explained && answer.lists(&hidden);
    let beside = explained && !listed && answer.steps.is_superset(&hidden);
    let masses_alone = answer.groups.iter().any(|group| group.is_empty());
    let names = explained && !answer.steps.is_empty() && !masses_alone;
    Ok(Found {
        log: format!("seed {} {:?} {hidden:?}", trial.seed, trial.stage.platform),
        said,
        alone,
        listed,
        beside,
        wrong: names && !listed && !beside,
        agrees,
        ratio,
    })
}
