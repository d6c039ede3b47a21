use super::*;
use crate::tests::noise as sequence;

/// A joint that swings, with stamps that jitter by a third of an interval.
fn swing(interval: f64, seconds: f64, hertz: f64) -> (Vec<f64>, Vec<f64>) {
    let count = (seconds / interval) as usize;
    let jitter = |k: usize| 0.33 * interval * (12.9 * k as f64).sin();
    let t: Vec<f64> = (0..count)
        .map(|k| k as f64 * interval + jitter(k))
        .collect();
    let at = |t: &f64| 0.3 * (std::f64::consts::TAU * hertz * t).sin();
    let q = t.iter().map(at).collect();
    (t, q)
}

/// Uniform noise of deviation `std` from a fixed sequence.
fn noise(count: usize, std: f64) -> Vec<f64> {
    let mut draw = sequence(std);
    (0..count).map(|_| draw()).collect()
}

/// How a log is differentiated, and its motion.
fn planned(t: &[f64], q: &[f64], dof: usize, wanted: Wanted) -> (Plan, Motion) {
    let plan = Plan::of(t, q, dof).unwrap();
    let motion = plan.motion((t, q, dof), 0..t.len(), wanted).unwrap();
    (plan, motion)
}

/// What an encoder of 4096 ticks a turn reads, and one tick, rad.
const TICK: f64 = std::f64::consts::TAU / 4096.0;

fn ticks(q: &[f64]) -> Vec<f64> {
    q.iter().map(|q| (q / TICK).round() * TICK).collect()
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
}

#[test]
fn a_swing_is_differentiated_on_jittering_stamps() {
    // Worst errors, relative: 1 kHz down to 5 Hz.
    for (step, hertz, within) in [
        (0.001, 1.0, 0.012),
        (0.01, 1.0, 0.01),
        (0.05, 0.5, 0.01),
        (0.1, 0.3, 0.02),
        (0.2, 0.1, 0.02),
        // Slow enough for rows far apart.
        (0.5, 0.08, 0.02),
        (1.0, 0.04, 0.02),
    ] {
        let (t, q) = swing(step, 200.0 * step + 4.0 / hertz, hertz);
        let (_, motion) = planned(&t, &q, 1, Wanted::Changes);
        let known = motion.known.iter().filter(|known| **known).count();
        assert!(known as f64 > 0.85 * t.len() as f64, "{known} of {step}");
        let w = std::f64::consts::TAU * hertz;
        for (k, t) in t.iter().enumerate().filter(|(k, _)| motion.known[*k]) {
            let off = (motion.gains[k] + 0.3 * w * w * (w * t).sin()).abs();
            assert!(off < within * 0.3 * w * w, "{step} s: {off}");
            let off = (motion.rates[k] - 0.3 * w * (w * t).cos()).abs();
            assert!(off < within * 0.3 * w, "{step} s: {off}");
        }
    }
}

#[test]
fn logs_with_long_intervals_know_no_accelerations() {
    for (step, hertz) in [(0.5, 0.3), (1.0, 0.2), (2.0, 0.01)] {
        let (t, q) = swing(step, 300.0, hertz);
        assert_eq!(Plan::of(&t, &q, 1), None, "{step}");
    }
    assert_eq!(Plan::of(&[0.0, 0.01, 0.02], &[0.0, 0.1, 0.2], 1), None);
    // Rows within the interval whose motion is far faster than they show.
    let (t, _) = swing(0.1, 60.0, 0.2);
    let q = noise(t.len(), 0.3);
    let plan = Plan::of(&t, &q, 1).unwrap();
    assert_eq!(plan.motion((&t, &q, 1), 0..t.len(), Wanted::Changes), None);
}

/// Less than some eight rows to a swing do not show it.
#[test]
fn motion_faster_than_its_rows_is_known_as_such() {
    for (step, hertz, is_too_coarse) in [
        (0.1, 0.5, false),
        (0.1, 1.0, false),
        (0.1, 1.8, true),
        (0.02, 3.0, false),
        (0.02, 6.0, true),
    ] {
        let (t, q) = swing(step, 60.0, hertz);
        let plan = Plan::of(&t, &q, 1).unwrap();
        assert_eq!(
            plan.is_too_coarse, is_too_coarse,
            "{hertz} Hz every {step} s"
        );
    }
}

/// Rows at the ends and beside a pause have no window, unless the robot stands there.
#[test]
fn edges_have_no_window_unless_the_robot_stands() {
    let mut t: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
    t.iter_mut().skip(100).for_each(|t| *t += 5.0);
    let at = |k: usize| if k < 100 { (3.0 * t[k]).sin() } else { 0.1 };
    let q: Vec<f64> = (0..t.len()).map(at).collect();
    let (plan, motion) = planned(&t, &q, 1, Wanted::Changes);
    for (row, known) in motion.known.iter().enumerate() {
        let whole = row >= 100 || row.min(99 - row) >= 9;
        assert_eq!(*known, whole, "row {row}");
    }
    assert!(motion.gains[100..].iter().all(|gain| *gain == 0.0));
    let still = vec![0.1; t.len()];
    assert_eq!(
        plan.motion((&t, &still, 1), 0..t.len(), Wanted::Changes),
        None
    );
}

/// The stated deviation of an acceleration is what noise of the encoders makes of it, and a
/// slow swing in such noise is taken over long windows.
#[test]
fn deviations_are_those_of_the_noise() {
    let (t, slow) = swing(0.01, 60.0, 0.25);
    let noise = noise(t.len(), 1e-3);
    let pairs = slow.iter().zip(&noise);
    let q: Vec<f64> = pairs.map(|(a, b)| a + b).collect();
    let plan = Plan::of(&t, &q, 1).unwrap();
    assert!(plan.half > 0.5, "{plan:?}");
    let rows = 100..t.len() - 100;
    let motion = plan.motion((&t, &q, 1), rows, Wanted::Changes).unwrap();
    let w = std::f64::consts::TAU * 0.25;
    let off = motion.gains.iter().zip(&t[100..]);
    let off = off.map(|(gain, t)| gain + 0.3 * w * w * (w * t).sin());
    let off: Vec<f64> = off.collect();
    let ratio = rms(&off) / rms(&motion.gains_std);
    assert!((0.85..1.15).contains(&ratio), "{ratio}");
    // Noise alone moves no joint.
    let still = plan.motion((&t, &noise, 1), 0..t.len(), Wanted::Changes);
    let still = still.unwrap();
    assert!(still.gains.iter().all(|gain| *gain == 0.0));
    // And its positions are known better than they are read, by windows of 0.6 s and more.
    assert!(rms(&still.positions) < 0.4 * rms(&noise));
}

/// Encoders that write ticks bend no acceleration: what is left is noise that averages out.
#[test]
fn ticks_leave_accelerations_as_large_as_they_are() {
    let rates = [
        (0.01, 0.7),
        (0.02, 0.7),
        (0.05, 0.7),
        (0.1, 0.3),
        (0.01, 0.2),
    ];
    for (step, hertz) in rates {
        let (t, q) = swing(step, 120.0, hertz);
        let q = ticks(&q);
        let (_, motion) = planned(&t, &q, 1, Wanted::Changes);
        let w = std::f64::consts::TAU * hertz;
        let (mut product, mut square) = (0.0, 0.0);
        for (k, t) in t.iter().enumerate().filter(|(k, _)| motion.known[*k]) {
            let truth = -0.3 * w * w * (w * t).sin();
            product += motion.gains[k] * truth;
            square += truth * truth;
        }
        let share = product / square;
        assert!((share - 1.0).abs() < 0.005, "{step} s, {hertz} Hz: {share}");
    }
}

/// Where rows are far apart, windows bend fast joints by a percent; how much is seen, and taken
/// back of each joint. Without noise, and with that of ticks.
#[test]
fn what_windows_bend_is_taken_back() {
    let (step, hertz) = (0.2, [0.4, 0.13]);
    for tick in [1e-9, TICK] {
        let swings = hertz.map(|hertz| swing(step, 120.0, hertz));
        let t = &swings[0].0;
        let read = |q: &f64| (q / tick).round() * tick;
        let q: Vec<f64> = (0..t.len())
            .flat_map(|k| [0, 1].map(|joint| read(&swings[joint].1[k])))
            .collect();
        let (plan, motion) = planned(t, &q, 2, Wanted::Alone);
        for (joint, hertz) in hertz.into_iter().enumerate() {
            let w = std::f64::consts::TAU * hertz;
            let (mut product, mut square, mut bent) = (0.0, 0.0, 0.0);
            for (k, t) in t.iter().enumerate().filter(|(k, _)| motion.known[*k]) {
                let truth = -0.3 * w * w * (w * t).sin();
                product += motion.gains[2 * k + joint] * truth;
                bent += motion.gains[2 * k + joint] / plan.unbend[joint] * truth;
                square += truth * truth;
            }
            let (share, bent) = (product / square, bent / square);
            assert!((share - 1.0).abs() < 0.002, "{hertz} Hz: {share}");
            let expected = [0.004..0.01, -0.001..0.001][joint].clone();
            assert!(expected.contains(&(1.0 - bent)), "{hertz} Hz: {bent}");
        }
    }
}

/// Positions are known as well as is said: better than the noise that was added to them, dense or
/// not. Ticks follow each other evenly, and average out better than white noise.
#[test]
fn positions_are_known_as_well_as_encoders_read_them() {
    for (step, hertz) in [(0.001, 0.7), (0.005, 0.3), (0.02, 0.3), (0.1, 0.15)] {
        let (t, truth) = swing(step, 60.0, hertz);
        let white = truth.iter().zip(noise(t.len(), 1e-3));
        let white: Vec<f64> = white.map(|(q, e)| q + e).collect();
        for (q, read, least) in [
            (white, 1e-3, 0.8),
            (ticks(&truth), TICK / 12_f64.sqrt(), 0.0),
        ] {
            let (_, motion) = planned(&t, &q, 1, Wanted::Changes);
            let known = (0..t.len()).filter(|k| motion.known[*k]);
            let off: Vec<f64> = known.map(|k| motion.positions[k] - truth[k]).collect();
            let ratio = rms(&off) / rms(&motion.positions_std);
            assert!((least..1.2).contains(&ratio), "{step} s: {ratio}");
            assert!(rms(&off) < 0.9 * read, "{step} s");
        }
    }
}

/// Jerk and snap of a swing at 100, 50 and 20 Hz, row by row, the middle of a long log like
/// its end; none where rows are too far apart, beside a pause and at the ends.
#[test]
fn accelerations_change_as_those_of_a_swing_do() {
    let hertz = 0.7;
    let w = std::f64::consts::TAU * hertz;
    for (step, within) in [(0.01, 0.03), (0.02, 0.03), (0.05, 0.03), (0.16, 0.0)] {
        let (mut t, q) = swing(step, 600.0 * step, if within > 0.0 { hertz } else { 0.1 });
        t.iter_mut().skip(400).for_each(|t| *t += 100.0 / hertz);
        let (plan, motion) = planned(&t, &q, 1, Wanted::Changes);
        let mut told = 0;
        for (k, t) in t.iter().enumerate() {
            let (jerk, snap) = (motion.jerks[k], motion.snaps[k]);
            let beside = !motion.known[k] || k.min(599 - k) < 2 || k.abs_diff(400) < 2;
            if within == 0.0 || (beside && jerk == 0.0) {
                assert_eq!((jerk, snap), (0.0, 0.0), "{step} s, row {k}");
                continue;
            }
            told += usize::from(jerk != 0.0);
            let off = jerk + 0.3 * w.powi(3) * (w * t).cos();
            let is_near = off.abs() < within * 0.3 * w.powi(3);
            assert!(is_near || jerk == 0.0, "{step} s, row {k}");
            let off = snap - 0.3 * w.powi(4) * (w * t).sin();
            let is_near = off.abs() < 3.0 * within * 0.3 * w.powi(4);
            assert!(is_near || jerk == 0.0, "{step} s, row {k}");
        }
        assert!(within == 0.0 || told > 500, "{told}");
        // In some rows alone, whose neighbours are seen.
        let some = plan.motion((&t, &q, 1), 100..150, Wanted::Changes).unwrap();
        assert_eq!(some.jerks.len(), 50);
        for (k, jerk) in some.jerks.iter().enumerate() {
            let whole = motion.jerks[100 + k];
            assert!((jerk - whole).abs() < 1e-6 * whole.abs().max(1.0));
        }
    }
}

/// Rows near the ends and beside a pause have windows that are shorter on one side; what is
/// smooth there has as little of the ticks as elsewhere.
#[test]
fn rows_at_the_ends_are_smooth_too() {
    for (step, hertz) in [(0.001, 0.125), (0.005, 0.3), (0.02, 0.2)] {
        let seconds = 30.0;
        let (mut t, truth) = swing(step, seconds, hertz);
        let half = t.len() / 2;
        t.iter_mut().skip(half).for_each(|t| *t += 2.0 / hertz);
        let q = ticks(&truth);
        let (plan, motion) = planned(&t, &q, 1, Wanted::Smooth);
        let smooth = motion.smooth.unwrap();
        let beside = (1.1 * plan.half / step) as usize;
        let from_end = |k: usize| k.min(t.len() - 1 - k).min(k.abs_diff(half));
        let ends: Vec<usize> = (0..t.len())
            .filter(|k| motion.known[*k] && from_end(*k) < beside)
            .collect();
        assert!(ends.len() > beside, "{step} s: {}", ends.len());
        let off = |read: &[f64]| {
            let off = ends.iter().map(|k| read[*k] - truth[*k]);
            rms(&off.collect::<Vec<f64>>())
        };
        let (own, ticks) = (off(&smooth[0]), off(&q));
        assert!(own < 0.5 * ticks, "{step} s: {own} of {ticks}");
    }
}
