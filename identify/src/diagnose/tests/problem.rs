//! Fits of one hypothesis: slopes, minima, stated deviations, penalties.

use sesc_model::effects::PostureContext;

use crate::observations::motion::Motion;
use sesc_reference::{Track, World};

use super::{Bench, NOISE, gauss, term, values};
use crate::diagnose::dictionary::Dictionary;
use crate::diagnose::hypothesis::{Term, effect_terms, sorted};
use crate::diagnose::problem::Problem;
use crate::diagnose::search::Search;

const CELLS: [[f64; 2]; 4] = [[0.5, 0.4], [0.5, -0.4], [-0.5, -0.4], [-0.5, 0.4]];

/// A log of everything: times, cells, tilted ground, moving joints, sides.
fn everything(bench: &Bench) -> Problem<'_> {
    let q = bench.postures(7, 3);
    let mut data = bench.log(&bench.world(), &q, 1);
    let mut gauss = gauss(2);
    let layout = PostureContext::of(&bench.model);
    data.cells = CELLS.to_vec();
    data.t = Some((0..7).map(f64::from).collect());
    data.motion = Some(Motion::default());
    data.posture_context
        .iter_mut()
        .for_each(|u| *u = 0.1 * gauss());
    for k in 0..7 {
        for joint in 0..bench.model.dof() {
            let side = if (k + joint) % 2 == 0 { 1.0 } else { -1.0 };
            data.posture_context[k * layout.len() + layout.side(joint)] = side;
        }
    }
    bench.certain(data)
}

/// Central differences of the readings against the derivatives beside them, both
/// for unknowns of ordinary size.
fn differ(problem: &Problem, terms: &[Term]) -> f64 {
    let scales = problem.scales(terms);
    let at: Vec<f64> = scales.iter().map(|scale| 0.3 * scale).collect();
    let run = |x: &[f64]| {
        let data = &problem.first().data;
        problem
            .first()
            .evaluate(terms, x, &data.q, &data.posture_context)
    };
    let (here, width) = (run(&at), scales.len() + 1);
    let mut worst: f64 = 0.0;
    for (k, scale) in scales.iter().enumerate() {
        let moved = |by: f64| {
            let mut x = at.clone();
            x[k] += by * scale;
            run(&x)
        };
        let (ahead, behind) = (moved(1e-4), moved(-1e-4));
        let mut largest: f64 = 0.0;
        let mut off: f64 = 0.0;
        for row in (0..here.len()).step_by(width) {
            let slope = here[row + 1 + k] * scale;
            let numeric = (ahead[row] - behind[row]) / 2e-4;
            largest = largest.max(slope.abs()).max(numeric.abs());
            off = off.max((slope - numeric).abs());
        }
        // What pulls sideways at the ground does nothing.
        worst = worst.max(if largest > 0.0 { off / largest } else { off });
    }
    worst
}

#[test]
fn slopes_of_every_effect_are_central_differences() {
    let bench = Bench::skew();
    let problem = everything(&bench);
    let mut seen = Vec::new();
    for term in effect_terms(&problem.first().context) {
        if term.unknowns(&problem.first().context) == 0 {
            continue;
        }
        let off = differ(&problem, std::slice::from_ref(&term));
        assert!(off < 1e-5, "{term:?}: {off:e}");
        seen.push(term.name());
    }
    seen.dedup();
    assert_eq!(seen.len(), 16, "{seen:?}");
    let together = [
        ("sensor_rotation", "-"),
        ("sensor_gain", "-"),
        ("ground_slope", "-"),
        ("joint_offset", "hip"),
        ("joint_compliance", "all"),
        ("backlash", "knee"),
        ("payload", "shank"),
        ("external_force", "thigh"),
    ];
    let together = together.map(|(effect, target)| term(&problem, effect, target));
    let off = differ(&problem, &together);
    assert!(off < 1e-5, "together: {off:e}");
}

/// An effect, its values in the order of [`effects::Effect::values`], and a robot
/// that has it.
type Planted = (&'static str, &'static str, Vec<f64>, World);

fn planted(bench: &Bench) -> Vec<Planted> {
    let world = || bench.world();
    let offset = world().joint_offset("r_knee", -0.03);
    let scale = world().joint_scale("r_ank_roll", 1.07);
    let soft = world().joint_compliance("r_ank_pitch", 60.0);
    let payload = world().payload("body_link", 0.3, [0.05, -0.04, 0.06]);
    let force = world().external_force("body_link", [0.5, -0.4, 2.0]);
    let loads = vec![0.3, 0.05, -0.04, 0.06];
    let of_sensor = [
        (
            "sensor_offset",
            vec![0.003, -0.002],
            world().sensor_offset([0.003, -0.002]),
        ),
        ("sensor_rotation", vec![0.08], world().sensor_rotation(0.08)),
        (
            "sensor_gain",
            vec![1.06, 0.95],
            world().sensor_gain([1.06, 0.95]),
        ),
        (
            "sensor_drift",
            vec![0.003, 0.002],
            world().sensor_drift([0.003, 0.002]),
        ),
    ];
    let of_sensor = of_sensor.map(|(effect, values, world)| (effect, "-", values, Ok(world)));
    let of_robot = [
        (
            "ground_slope",
            "-",
            vec![0.012, -0.02],
            world().ground_slope([0.012, -0.02]),
        ),
        ("joint_offset", "r_knee", vec![-0.03], offset),
        ("joint_scale", "r_ank_roll", vec![1.07], scale),
        ("joint_compliance", "r_ank_pitch", vec![60.0], soft),
        ("payload", "body_link", loads, payload),
        ("external_force", "body_link", vec![0.5, -0.4, 2.0], force),
    ];
    let all = of_sensor.into_iter().chain(of_robot);
    let known = all.map(|(effect, target, values, world)| (effect, target, values, world.unwrap()));
    known.collect()
}

/// Values lie about the truth as far as stated: pulls have variance one, none is
/// beyond 3.9 (one in ten thousand).
#[test]
fn values_are_found_and_their_deviations_are_honest() {
    const SEEDS: u64 = 24;
    let bench = Bench::op2();
    let q = bench.balanced(60, 2);
    let dof = bench.model.dof();
    let track = Track::still(q.chunks(dof).map(<[f64]>::to_vec).collect());
    let mut problem = bench.certain(bench.log(&bench.world(), &q, 1));
    let (mut squares, mut count) = (0.0, 0.0);
    for (effect, target, truth, world) in planted(&bench) {
        let own = [term(&problem, effect, target)];
        let clean: Vec<f64> = world.readings(&track).iter().flat_map(|r| r.cop).collect();
        let mut of_effect = 0.0;
        for seed in 0..SEEDS {
            let mut gauss = gauss(100 + seed);
            problem.blocks[0].data.reading = clean.iter().map(|x| x + NOISE * gauss()).collect();
            let fit = problem.fit(&own, None);
            let found = values(&problem, &fit);
            assert_eq!(found.len(), truth.len());
            for (found, value) in found.iter().zip(&truth) {
                let pull = (found.value - value) / found.std;
                assert!(pull.abs() < 3.9, "{effect} {seed}: {found:?}, not {value}");
                of_effect += pull * pull / truth.len() as f64;
            }
            // χ² of 120 readings, at its minimum.
            let expected = 120.0 - truth.len() as f64;
            let off = (fit.objective - expected) / (2.0 * expected).sqrt();
            assert!(off.abs() < 4.5, "{effect} {seed}: {}", fit.objective);
        }
        // Several values of one fit go together: counted as one.
        let spread = (2.0 / SEEDS as f64).sqrt();
        let off = (of_effect / SEEDS as f64 - 1.0).abs();
        assert!(off < 4.0 * spread, "{effect}: {off}");
        squares += of_effect;
        count += SEEDS as f64;
    }
    let off: f64 = squares / count - 1.0;
    assert!(off.abs() < 4.0 * (2.0 / count).sqrt(), "{off}");
}

/// `p ln 2N + 2 ln(kinds · targets)`: twenty joints cost 2 ln 20 more than one sensor.
#[test]
fn penalties_grow_with_unknowns_and_targets() {
    for (bench, joint, link) in [
        (Bench::op2(), "r_knee", "body_link"),
        (Bench::skew(), "knee", "shank"),
    ] {
        let q = bench.postures(30, 1);
        let problem = bench.certain(bench.log(&bench.world(), &q, 1));
        let (joints, links) = (
            bench.model.dof() as f64,
            problem.first().context.links().len() as f64,
        );
        let penalty = |problem: &Problem, effect: &str, target: &str| {
            problem.penalty(&[term(problem, effect, target)])
        };
        let rotation = penalty(&problem, "sensor_rotation", "-");
        let off = |penalty: f64, unknowns: f64, targets: f64| {
            (penalty - rotation - (unknowns - 1.0) * 60.0_f64.ln() - 2.0 * targets.ln()).abs()
        };
        assert!(off(penalty(&problem, "joint_offset", joint), 1.0, joints) < 1e-9);
        assert!(off(penalty(&problem, "backlash", "all"), 1.0, joints + 1.0) < 1e-9);
        assert!(off(penalty(&problem, "sensor_gain", "-"), 2.0, 1.0) < 1e-9);
        assert!(off(penalty(&problem, "payload", link), 4.0, links) < 1e-9);
        let both = ["sensor_rotation", "sensor_gain"].map(|e| term(&problem, e, "-"));
        let sum = rotation + penalty(&problem, "sensor_gain", "-");
        assert!((problem.penalty(&both) - sum).abs() < 1e-12);
        // By how well targets are seen: the chance of an effect stays what it was.
        let terms = effect_terms(&problem.first().context);
        let chance = |problem: &Problem, name: &str| {
            let own = terms.iter().filter(|i| i.name() == name);
            let penalties = own.map(|i| problem.penalty(std::slice::from_ref(i)));
            penalties.map(|penalty| (-0.5 * penalty).exp()).sum::<f64>()
        };
        let names = ["joint_offset", "payload", "joint_scale", "sensor_gain"];
        let even = names.map(|name| chance(&problem, name));
        let problem = Search::new(problem).problem;
        for (name, even) in names.iter().zip(even) {
            let weighted = chance(&problem, name);
            assert!((weighted / even - 1.0).abs() < 1e-9, "{name}");
        }
        if joints > 2.0 {
            let [ankle, elbow] = ["r_ank_roll", "l_el"];
            let ankle = penalty(&problem, "joint_offset", ankle);
            assert!(ankle + 4.0 < penalty(&problem, "joint_offset", elbow));
        }
    }
}

#[test]
fn what_an_effect_gains_is_what_its_fit_comes_to_with_masses_known_and_free() {
    let bench = Bench::op2();
    let (q, knee, dof) = (
        bench.postures(60, 3),
        bench.joint("r_knee"),
        bench.model.dof(),
    );
    let mut bent = q.clone();
    bent.iter_mut()
        .skip(knee)
        .step_by(dof)
        .for_each(|q| *q += 0.02);
    let mut data = bench.log(&bench.world(), &bent, 4);
    data.q = q;
    let problem = bench.problem(data, "tight");
    let dictionary = Dictionary::new(&problem, None);
    for parent in [vec![], vec![Term::Masses]] {
        let before = problem.fit(&parent, None);
        let gains = dictionary.gains(&before, &problem);
        let mut asked = 0;
        for (candidate, gain) in dictionary.candidates.iter().zip(gains) {
            if candidate.term.name() != "joint_offset" {
                continue;
            }
            let terms = [&parent[..], std::slice::from_ref(&candidate.term)].concat();
            let terms = sorted(&problem.first().context, &terms);
            let fit = problem.fit(&terms, None);
            let offset = fit.unknowns_of(&problem.first().context, &candidate.term);
            if offset.is_none_or(|offset| offset[0].abs() > 0.04) {
                // Readings are linear in small offsets alone.
                continue;
            }
            let fell = before.objective - fit.objective;
            let label = candidate.term.label(&problem.first().context);
            assert!(
                (gain - fell).abs() < 0.15 * fell + 1.0,
                "{label}: {gain} {fell}"
            );
            asked += usize::from(fell > 5.0);
        }
        assert!(asked > 0, "some offset helps beside {parent:?}");
    }
}
