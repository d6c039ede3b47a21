//! A log of the healthy robot tells its masses, so that a later fault is not hidden in them.
//!
//! Robots weigh what CAD does not say: 10 % and 5 mm a link. The virtual robot takes the healthy log,
//! then the fault is hidden.

use std::sync::Arc;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Diagnosis, Verdict};
use sesc_identify::fit::{self, prior::PriorChoice};
use sesc_identify::logs::{LogSource, Sidecar, Table};
use sesc_identify::robot::Robot;
use sesc_model::ModelFile;
use sesc_reference::{Place, Robot as TrueRobot, World};
use sesc_test_support::command::{Folder, says};
use sesc_test_support::examine::{bought::bought, com_error};
use sesc_test_support::recording::Recording;
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{diagnosed, fit_request, is_listed, labels, robot};
use crate::both_feet::LEG;

/// Noise of a posture's reading, m.
const NOISE: f64 = 5e-4;
/// Postures of the healthy log, and of the one with the fault.
const HEALTHY: usize = 200;
const FAULTY: usize = 120;

/// A robot as it is bought, on the bench.
struct Bench {
    stage: Stage,
    robot: Arc<Robot>,
    world: World,
    random: ChaCha8Rng,
}

impl Bench {
    fn new(seed: u64) -> Bench {
        let stage = Stage::new(Platform::Op2);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let cad = TrueRobot::from_urdf(sesc::OP2_URDF).unwrap();
        let world = World::new(&bought(&cad, &mut random), stage.support).unwrap();
        Bench {
            robot: robot(&stage),
            stage,
            world,
            random,
        }
    }

    /// A log of `world` in so many balanced postures.
    fn log(&mut self, world: &World, postures: usize, name: &str) -> LogSource {
        self.log_on(self.stage.support, world, postures, name)
    }

    /// The same where `world` stands on `support`.
    fn log_on(&mut self, support: &str, world: &World, postures: usize, name: &str) -> LogSource {
        let q = self.stage.balanced(postures, &mut self.random);
        let log = Recording::still(&self.stage, world, q, NOISE, &mut self.random);
        let log = add(Table::new(name), &log);
        LogSource::from(log).with_sidecar(Sidecar {
            support: Some(support.into()),
            ..Sidecar::default()
        })
    }

    fn request(&self, log: LogSource) -> diagnose::Request {
        let mut request = diagnose::Request::new(Arc::clone(&self.robot), log);
        request.noise = Some(NOISE);
        request
    }

    /// RMS error of a model's CoM, x and y, in fresh postures of `world`, m.
    fn com_error(&mut self, world: &World, file: Option<&ModelFile>) -> f64 {
        let q = self.stage.balanced(200, &mut self.random);
        com_error(&self.stage, world, file, &q, 0..2).unwrap()
    }
}

/// The columns of a recording in a table.
fn add(table: Table, log: &Recording) -> Table {
    let columns = log.columns(false).into_iter();
    columns.fold(table, |table, (name, values)| table.numbers(&name, values))
}

/// What is hidden, and the name and target that it goes by.
const FAULTS: [(&str, Place, &[f64]); 8] = [
    ("joint_offset", Place::Joint("r_knee"), &[0.026]),
    ("joint_offset", Place::Joint("r_hip_roll"), &[0.026]),
    ("joint_scale", Place::Joint("r_hip_pitch"), &[1.1]),
    (
        "payload",
        Place::Link("body_link"),
        &[0.25, 0.03, 0.04, 0.05],
    ),
    ("joint_compliance", Place::Joint("r_ank_pitch"), &[20.0]),
    ("backlash", Place::Joint("r_hip_roll"), &[0.035]),
    ("sensor_rotation", Place::Whole, &[0.07]),
    ("sensor_offset", Place::Whole, &[0.006, -0.004]),
];

fn place(place: Place) -> String {
    match place {
        Place::Joint(name) | Place::Link(name) => name.to_string(),
        _ => "-".to_string(),
    }
}

/// Whether the truth is named alone, or is in a class of the answer.
fn is_told(found: &Diagnosis, effect: &str, target: &str) -> (bool, bool) {
    let alone = found.verdict == Verdict::Named && labels(found) == [format!("{effect}:{target}")];
    let label = match target {
        "-" => effect.to_string(),
        _ => format!("{effect}:{target}"),
    };
    (alone, alone || is_listed(found, &[&label]))
}

#[test]
fn a_healthy_log_tells_a_fault_from_masses() {
    let (mut alone, mut told, mut all) = (0, 0, 0);
    let mut ratios = Vec::new();
    let mut lines = Vec::new();
    for seed in 1..=2 {
        let mut bench = Bench::new(seed);
        let healthy = bench.world.clone();
        let before = bench.log(&healthy, HEALTHY, "before.csv");
        for (effect, target, values) in FAULTS {
            let faulty = healthy.clone().named(effect, target, values).unwrap();
            let log = bench.log(&faulty, FAULTY, "log.csv");
            let mut request = bench.request(log);
            request.healthy = vec![before.clone()];
            let found = diagnose::diagnose(&request, &mut ()).unwrap();
            let (is_alone, is_told) = is_told(&found.diagnosis, effect, &place(target));
            alone += usize::from(is_alone);
            told += usize::from(is_told);
            all += 1;
            lines.push(format!("{effect}: {}", found.diagnosis.sentence));
            let error = bench.com_error(&faulty, Some(&found.model_file));
            ratios.push(error / bench.com_error(&faulty, None));
        }
        // The same robot, still sound.
        let log = bench.log(&healthy, FAULTY, "log.csv");
        let mut request = bench.request(log);
        request.healthy = vec![before];
        assert_eq!(diagnosed(&request).verdict, Verdict::None);
    }
    ratios.sort_by(f64::total_cmp);
    let lines = lines.join("\n");
    let enough = told + 1 >= all && 10 * alone >= 6 * all;
    assert!(enough, "{alone}, {told} of {all}\n{lines}");
    assert!(ratios[ratios.len() / 2] < 0.1, "{ratios:?}");
}

/// The healthy log on the other foot, by its sidecar, with and without a support that is given for
/// the log at hand; and a further log beside it.
#[test]
fn healthy_logs_go_with_further_logs_and_with_another_foot() {
    let mut bench = Bench::new(5);
    let healthy = bench.world.clone();
    let before = bench.log(&healthy, HEALTHY, "before.csv");
    let other = World::new(healthy.robot(), "l_sole").unwrap();
    let on_other = bench.log_on("l_sole", &other, HEALTHY, "before.csv");
    let faulty = healthy.joint_offset("r_hip_roll", 0.026).unwrap();
    let log = bench.log(&faulty, FAULTY / 2, "log.csv");
    let after = bench.log(&faulty, FAULTY / 2, "after.csv");
    let mut alone = None;
    for (before, support) in [
        (before, None),
        (on_other.clone(), None),
        (on_other, Some("r_sole")),
    ] {
        for then in [vec![], vec![after.clone()]] {
            let mut request = bench.request(log.clone());
            request.support = support.map(String::from);
            request.healthy = vec![before.clone()];
            request.then = then.clone();
            let found = diagnosed(&request);
            let (_, is_told) = is_told(&found, "joint_offset", "r_hip_roll");
            assert!(is_told, "{support:?} {}: {}", then.len(), found.sentence);
            assert_eq!(found.warnings, [""; 0]);
            // A further log makes the offset known better.
            let std = found.steps[0].parameters["offset_rad"].std;
            match then.is_empty() {
                true => alone = Some(std),
                false => assert!(std < alone.unwrap(), "{std} {alone:?}"),
            }
        }
    }
}

#[test]
fn a_fault_that_the_healthy_log_shares_is_said() {
    let mut bench = Bench::new(4);
    let faulty = bench.world.clone().joint_scale("r_hip_pitch", 1.1).unwrap();
    let before = bench.log(&faulty, HEALTHY, "before.csv");
    let log = bench.log(&faulty, FAULTY, "log.csv");
    let mut request = bench.request(log);
    request.healthy = vec![before];
    let found = diagnosed(&request);
    let said = found.warnings.join("\n");
    says(said, &["before.csv", "joint_scale:r_hip_pitch"]);
}

#[test]
fn a_fitted_model_is_the_prior_that_its_log_is() {
    let mut bench = Bench::new(3);
    let healthy = bench.world.clone();
    let before = bench.log(&healthy, HEALTHY, "before.csv");
    let faulty = healthy.joint_offset("r_hip_roll", 0.026).unwrap();
    let log = bench.log(&faulty, FAULTY, "log.csv");
    let mut request = bench.request(log);
    request.healthy = vec![before.clone()];
    let by_log = diagnose::diagnose(&request, &mut ()).unwrap();
    let mut of_fit = fit_request(&bench.stage, before.clone());
    of_fit.noise = Some(NOISE);
    let mut fitted = fit::fit(&of_fit, &mut ()).unwrap().model_file;
    let folder = Folder::empty();
    folder.write("fitted.toml", fitted.to_toml().unwrap());
    request.healthy.clear();
    request.prior = PriorChoice::File(folder.join("fitted.toml"));
    let by_file = diagnose::diagnose(&request, &mut ()).unwrap();
    assert_eq!(by_log.diagnosis.warnings, [""; 0]);
    assert_eq!(by_log.diagnosis.steps[0].effect, "joint_offset");
    assert_eq!(by_log.diagnosis.steps, by_file.diagnosis.steps);
    // A log does not count twice.
    let refused = |request: &diagnose::Request, words: &str| {
        let error = diagnose::diagnose(request, &mut ()).unwrap_err();
        says(error.to_string(), &[words]);
    };
    let mut again = bench.request(before.clone());
    again.prior = request.prior.clone();
    refused(&again, "were fitted to this very log");
    // Nor does a file count that does not say how well it knows, or that has effects.
    fitted.information = None;
    folder.write("fitted.toml", fitted.to_toml().unwrap());
    refused(&request, "information.factor");
    folder.write("fitted.toml", by_log.model_file.to_toml().unwrap());
    refused(&request, "it has effects");
}

/// Rows of both feet, in one log or in two, are explained together: each leg shows in the rows that
/// stand on it.
#[test]
fn faults_of_both_legs_are_found_in_rows_of_both_feet() {
    let mut bench = Bench::new(5);
    let cad = TrueRobot::from_urdf(sesc::OP2_URDF).unwrap();
    let (names, soles) = (bench.stage.joint_names(), ["r_sole", "l_sole"]);
    let rows = soles.map(|sole| {
        let world = World::new(&cad, sole).unwrap();
        let faulty = world.clone().joint_offset("r_ank_pitch", 0.02).unwrap();
        let faulty = faulty.joint_scale("l_hip_pitch", 1.15).unwrap();
        let q = match sole {
            "r_sole" => bench.stage.balanced(80, &mut bench.random),
            // The other foot bears a mirrored robot: encoders of the two legs turn against
            // each other.
            _ => {
                let mut q = bench.stage.balanced(400, &mut bench.random);
                q.iter_mut().for_each(|q| {
                    let of = |name: &str| names.iter().position(|own| own == name).unwrap();
                    for own in LEG {
                        let (right, left) = (of(&format!("r_{own}")), of(&format!("l_{own}")));
                        (q[right], q[left]) = (-q[left], -q[right]);
                    }
                });
                q.retain(|q| world.cop(q).iter().all(|x| x.abs() < 0.03));
                q.truncate(80);
                q
            }
        };
        Recording::still(&bench.stage, &faulty, q, NOISE, &mut bench.random)
    });
    let log = |name: &str, feet: &[usize]| {
        let own = feet.iter().map(|foot| &rows[*foot]);
        let stood = feet
            .iter()
            .map(|foot| vec![Arc::from(soles[*foot]); rows[*foot].q.len()]);
        let stood: Vec<Arc<str>> = stood.flatten().collect();
        let both = Recording {
            joints: names.clone(),
            q: own.clone().flat_map(|own| own.q.clone()).collect(),
            cop: own.flat_map(|own| own.cop.clone()).collect(),
            ..Recording::default()
        };
        LogSource::from(add(Table::new(name).texts("support", stood), &both))
    };
    let told = |request: &diagnose::Request| {
        let found = diagnosed(request);
        assert_eq!(found.warnings, [""; 0]);
        labels(&found)
    };
    let both = ["joint_offset:r_ank_pitch", "joint_scale:l_hip_pitch"];
    assert_eq!(told(&bench.request(log("both.csv", &[0, 1]))), both);
    let mut request = bench.request(log("right.csv", &[0]));
    request.then = vec![log("left.csv", &[1])];
    assert_eq!(told(&request), both);
}
