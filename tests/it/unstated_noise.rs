//! Nothing states the noise of a log, no posture was repeated: what the best explanation and
//! free masses leave is the noise, and evidence is about that of a log that states it.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::Diagnosis;
use sesc_identify::diagnose::{Verdict, diagnose};
use sesc_identify::logs::Table;
use sesc_reference::World;
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::request;

const NOISE_M: f64 = 5e-4;

/// 200 balanced postures of the OP2, white noise of 0.50 mm on each axis.
struct Bench {
    stage: Stage,
    q: Vec<Vec<f64>>,
    cop: Vec<[f64; 2]>,
}

impl Bench {
    fn of(hide: impl Fn(World) -> World, seed: u64) -> Bench {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let stage = Stage::new(Platform::Op2);
        let world = hide(stage.world());
        let q = stage.balanced(200, random);
        // Twelve uniform numbers less six: a normal one, nearly.
        let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        let cop = q
            .iter()
            .map(|q| world.cop(q).map(|y| y + NOISE_M * normal()));
        Bench {
            cop: cop.collect(),
            stage,
            q,
        }
    }

    fn diagnosis(&self, stated: Option<f64>) -> Diagnosis {
        let mut log = Table::new("log");
        for (axis, name) in ["cop_x", "cop_y"].into_iter().enumerate() {
            let values: Vec<f64> = self.cop.iter().map(|y| y[axis]).collect();
            log = log.numbers(name, values);
            if let Some(std) = stated {
                log = log.numbers(&format!("{name}_std"), vec![std; self.q.len()]);
            }
        }
        for (j, joint) in self.stage.joint_names().iter().enumerate() {
            log = log.numbers(joint, self.q.iter().map(|q| q[j]).collect::<Vec<_>>());
        }
        diagnose(&request(&self.stage, log), &mut ())
            .unwrap()
            .diagnosis
    }
}

/// Tests the mean over several logs, for an estimate from 360 degrees of freedom scatters by 4 %.
#[test]
fn noise_and_evidence_are_those_of_a_log_that_states_it() {
    let hide = |w: World| w.joint_offset("r_hip_roll", 0.05).unwrap();
    let (mut noise, mut evidence) = (Vec::new(), Vec::new());
    for seed in 1..=3 {
        let bench = Bench::of(hide, seed);
        let [with, without] = [Some(NOISE_M), None].map(|std| bench.diagnosis(std));
        let sum = |d: &Diagnosis| d.steps.iter().map(|s| s.evidence).sum::<f64>();
        println!(
            "{:.3} mm, evidence {:.0} and {:.0}, {:?} {:?}",
            1e3 * without.noise,
            sum(&with),
            sum(&without),
            with.verdict,
            without.verdict
        );
        assert_eq!(with.verdict, without.verdict);
        noise.push(without.noise / NOISE_M);
        evidence.push(sum(&without) / sum(&with));
    }
    assert!(noise.iter().all(|r| (r - 1.0).abs() < 0.1), "{noise:?}");
    assert!(
        evidence.iter().all(|r| (r - 1.0).abs() < 0.15),
        "{evidence:?}"
    );
}

/// A knee whose gear errs by a sine: no effect of the list is that, and no stated noise is
/// needed to see it.
#[test]
fn what_nothing_explains_is_unexplained_without_a_stated_noise() {
    let hide = |w: World| w.cop_sine("r_knee", 7.0, [0.008, 0.004]).unwrap();
    let bench = Bench::of(hide, 5);
    for stated in [Some(NOISE_M), None] {
        let found = bench.diagnosis(stated);
        println!("{:?} {}", found.verdict, found.sentence);
        assert_eq!(found.verdict, Verdict::Unexplained);
        assert!(found.unexplained);
    }
}
