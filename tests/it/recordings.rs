//! Recordings: noise that lasts is counted, stays and visits are, and intervals hold.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{Diagnosis, Verdict};
use sesc_reference::World;
use sesc_test_support::command::{Folder, number, says};
use sesc_test_support::examine::recordings::{Kept, Said};
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::{Kind, Motion, Noise, Recording};
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{diagnosed, lists, of_recording};

const NOISE: Noise = Noise {
    kind: Kind::White,
    std: [2e-3; 2],
    visit_std: 0.0,
};

fn case(motion: Motion, kind: Kind, visit_std: f64) -> Kept {
    Kept {
        platform: Platform::Op2,
        motion,
        noise: Noise {
            kind,
            visit_std,
            ..NOISE
        },
        rate: 10.0,
        timed: true,
        stated: false,
    }
}

fn ask(case: &Kept, seeds: std::ops::Range<u64>) -> Vec<Said> {
    let stage = Stage::new(case.platform);
    let of = |seed| case.ask(&stage, &case.record(&stage, seed), false).unwrap();
    seeds.map(of).collect()
}

/// Share of the intervals that hold, and the median of what rows are worth.
fn summed(said: &[Said]) -> (f64, f64) {
    let [hold, all] = [0, 1].map(|k| {
        let of = |s: &Said| [s.intervals.0, s.intervals.1][k] as f64;
        said.iter().map(of).sum::<f64>()
    });
    let mut worth: Vec<f64> = said.iter().map(|s| s.samples.1 as f64).collect();
    worth.sort_by(f64::total_cmp);
    (hold / all, worth[worth.len() / 2])
}

/// 1200 rows of noise that lasts τ are worth 1200 · Δt/2τ, whatever its kind; of 8 logs
/// with 42 parameters each, a share of 0.05 would miss by 0.02 if they were independent.
#[test]
fn intervals_of_a_fit_hold_in_noise_that_lasts() {
    let kinds = [
        (Kind::White, 1200.0),
        (Kind::Ar1(0.5), 120.0),
        (Kind::Smooth(0.1), 300.0),
        (Kind::Sway(0.3), 340.0),
    ];
    for (kind, worth) in kinds {
        let said = ask(&case(Motion::Sines(120.0), kind, 0.0), 100..108);
        let (share, found) = summed(&said);
        println!("{kind:?}: {share:.3} hold, worth {found} of {worth}");
        assert!((0.88..=1.0).contains(&share), "{kind:?}: {share}");
        assert!((0.5..1.6).contains(&(found / worth)), "{kind:?}: {found}");
    }
}

/// 120 stays of ten readings each: as many independent readings of the visits as there
/// are stays, with times and without.
#[test]
fn visits_that_differ_are_what_a_recording_is_worth() {
    let stays = Motion::Stays {
        postures: 60,
        visits: 2,
        hold: 1.0,
    };
    for timed in [true, false] {
        let [same, differ] = [0.0, 4e-3].map(|visit_std| Kept {
            timed,
            ..case(stays, Kind::White, visit_std)
        });
        let (share, worth) = summed(&ask(&same, 0..6));
        assert!(share > 0.88, "{share}");
        assert_eq!(worth, 1200.0);
        let said = ask(&differ, 0..6);
        let (share, worth) = summed(&said);
        println!("timed {timed}: {share:.3} hold, worth {worth}");
        assert!(share > 0.88, "{share}");
        // √(2² + 4²) mm a reading; the mean of a stay √(2²/10 + 4²): 1.23 as many.
        assert!((100.0..190.0).contains(&worth), "{worth}");
        let expected = 20_f64.sqrt() / 2.0;
        assert!(said.iter().all(|s| (s.noise / expected - 1.0).abs() < 0.2));
    }
}

/// White noise of 0.5 mm, nothing stated, nothing repeated: the noise is found, and
/// nothing else.
#[test]
fn the_noise_that_nobody_states_is_found() {
    let mut case = case(Motion::Sines(40.0), Kind::White, 0.0);
    case.noise.std = [5e-4; 2];
    let stage = Stage::new(case.platform);
    for seed in 0..3 {
        let recording = case.record(&stage, seed);
        let said = case.ask(&stage, &recording, true).unwrap();
        let noise = said.diagnosed_noise.unwrap();
        println!("{noise:.3} {:?}", said.verdict);
        assert!((0.9..1.1).contains(&noise), "{noise}");
        assert!((0.9..1.1).contains(&said.noise), "{}", said.noise);
        assert_eq!(said.verdict, Some(Verdict::None));
    }
}

/// What is said of it, by the command line.
#[test]
fn rows_and_what_they_are_worth_are_said() {
    let folder = Folder::with("op2");
    let stage = Stage::new(Platform::Op2);
    let recording = case(Motion::Sines(60.0), Kind::Ar1(0.4), 0.0).record(&stage, 5);
    folder.write("timed.csv", recording.csv(true));
    folder.write("rows.csv", recording.csv(false));
    let fit = "fit op2.urdf --support r_sole --data";
    let samples = &folder.json(&format!("{fit} timed.csv"))["samples"];
    assert_eq!(samples["rows"], 600);
    assert_eq!(samples["assumed"], false);
    let worth = samples["independent"].as_u64().unwrap();
    assert!((30..160).contains(&worth), "{samples}");
    assert!((0.15..1.2).contains(&number(samples, "/correlation_s")));
    let sentence = format!("600 rows, worth about {worth} independent ones: noise is correlated");
    says(folder.stdout(&format!("{fit} timed.csv")), &[&sentence]);
    let samples = &folder.json(&format!("{fit} rows.csv"))["samples"];
    assert_eq!(samples["independent"], 600);
    assert_eq!(samples["assumed"], true);
    let said = folder.stdout(&format!("{fit} rows.csv"));
    says(said, &["600 rows, taken as independent"]);
}

/// An OP2 that moves by slow sines for `seconds` at `rate` Hz, with noise that is stated truthfully.
fn swaying(
    hide: impl Fn(World) -> World,
    (seconds, rate): (f64, f64),
    kind: Kind,
    seed: u64,
) -> Diagnosis {
    let stage = Stage::new(Platform::Op2);
    let noise = Noise { kind, ..NOISE };
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let (world, sines) = (hide(stage.world()), Motion::Sines(seconds));
    let recording = Recording::take(&stage, &world, sines, noise, rate, random);
    let mut request = of_recording(&stage, &recording);
    request.noise = Some(NOISE.std[0]);
    diagnosed(&request)
}

/// `cargo xtask study false-alarms` counts false alarms of many such recordings.
#[test]
fn nothing_is_named_in_correlated_noise() {
    for (seed, tau) in [(0, 0.1), (10, 0.4), (20, 0.8)] {
        let found = swaying(|w| w, (120.0, 10.0), Kind::Ar1(tau), seed);
        assert_eq!(found.verdict, Verdict::None, "τ {tau}");
        let a = (-1.0_f64 / (10.0 * tau)).exp();
        let true_count = 1200.0 * (1.0 - a) / (1.0 + a);
        // Of the axis that has fewer, which scatters below the truth.
        let ratio = found.samples.independent as f64 / true_count;
        assert!((0.3..2.0).contains(&ratio), "τ {tau}: {ratio}");
    }
    let found = swaying(|w| w, (40.0, 10.0), Kind::White, 8);
    assert_eq!(found.samples.independent, found.samples.rows);
    assert_eq!(found.verdict, Verdict::None);
}

#[test]
fn a_large_effect_is_named_in_correlated_noise() {
    let hide = |w: World| w.joint_offset("r_hip_roll", 0.12).unwrap();
    let found = swaying(hide, (60.0, 20.0), Kind::Ar1(0.3), 5);
    lists(&found, &["joint_offset:r_hip_roll"]);
}

/// 4096 ticks a turn make accelerations of ten rows a second wrong by millimetres of ZMP. Were
/// they as wrong in the regressor, they would pull the parameters to zero: its rows come from
/// smoother motion.
#[test]
fn intervals_hold_where_encoders_read_ticks() {
    let said: Vec<Said> = (0..4)
        .map(|seed| {
            let stage = Stage::new(Platform::Op2);
            let swing = Swing {
                tick: std::f64::consts::TAU / 4096.0,
                ..Swing::new(0.44, 0.2, 60.0)
            };
            let noise = Noise {
                std: [2.5e-4; 2],
                ..NOISE
            };
            let random = &mut ChaCha8Rng::seed_from_u64(seed);
            let recording = swing.record(&stage, stage.world(), noise, 10.0, random);
            let case = Kept {
                noise,
                stated: true,
                ..case(Motion::Sines(60.0), Kind::White, 0.0)
            };
            case.ask(&stage, &recording, false).unwrap()
        })
        .collect();
    let (share, worth) = summed(&said);
    println!("{share:.3} hold, worth {worth}");
    assert!((0.9..=1.0).contains(&share), "{share}");
    assert!(worth > 300.0, "{worth}");
}

/// Twenty seconds at 100 Hz, angles in ticks, noise of 1 mm that lasts 0.2 s and is not stated: an
/// explanation that bends the gap wrongly leaves what looks like noise without an end. An offset
/// of three degrees is found beside noise of fifty independent rows.
#[test]
fn a_gap_that_is_bent_wrongly_is_no_noise_without_end() {
    let stage = Stage::new(Platform::Op2);
    let random = &mut ChaCha8Rng::seed_from_u64(3);
    let swing = Swing {
        tick: std::f64::consts::TAU / 4096.0,
        ..Swing::new(0.4, 0.1, 20.0)
    };
    let world = stage.world().joint_offset("r_knee", 3_f64.to_radians());
    let noise = Noise::new(Kind::Ar1(0.2), 1e-3);
    let recording = swing.record(&stage, world.unwrap(), noise, 100.0, random);
    let found = diagnosed(&of_recording(&stage, &recording));
    assert!((25..100).contains(&found.samples.independent));
    assert!((0.8e-3..1.25e-3).contains(&found.noise), "{}", found.noise);
    assert!(matches!(found.verdict, Verdict::Named | Verdict::Class));
}
