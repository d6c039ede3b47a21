use std::f64::consts::TAU;

use sesc_model::Snapping;

use super::*;
use crate::observations::motion::{Plan, Wanted};
use crate::robot::Robot;

/// A point of 5 kg, 0.8 m above an ankle in the sole.
const PENDULUM: &str = "<robot name='pendulum'><link name='foot'/>\
    <joint name='ankle' type='continuous'><parent link='foot'/><child link='pole'/>\
    <axis xyz='0 1 0'/></joint>\
    <link name='pole'><inertial><origin xyz='0 0 0.8'/><mass value='5'/></inertial></link>\
    </robot>";

/// 4096 ticks a turn, rad.
const TICK: f64 = TAU / 4096.0;

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
}

/// What an encoder of 4096 ticks a turn makes of the ZMP of a pendulum, against the closed form
/// `p = x − z ẍ/(g + z̈)` of the angles that it did not read: rows apart and dense, near the
/// upright and far from it.
#[test]
fn ticks_move_the_zmp_as_far_as_is_said() {
    let robot = Robot::parse(PENDULUM, "pendulum.urdf").unwrap();
    let model = robot.model("foot", Snapping::default(), None).unwrap();
    for (step, hertz, middle) in [
        (0.2, 0.25, 0.0),
        (0.2, 0.15, 0.5),
        (0.1, 0.2, 0.0),
        (0.05, 0.3, 0.4),
        (0.01, 0.3, 0.0),
        (1.0, 0.05, 0.2),
    ] {
        // Angle, velocity and acceleration of two sines.
        let sines = [(0.35, TAU * hertz), (0.25, 0.618_033_9 * TAU * hertz)];
        let at = |t: f64| {
            let all = sines.iter();
            all.fold([middle, 0.0, 0.0], |[q, v, a], (size, w)| {
                let (s, c) = (w * t).sin_cos();
                [q + size * s, v + size * w * c, a - size * w * w * s]
            })
        };
        let t: Vec<f64> = (0..4000).map(|k| f64::from(k) * step).collect();
        let read = |t: &f64| (at(*t)[0] / TICK).round() * TICK;
        let q: Vec<f64> = t.iter().map(read).collect();
        let plan = Plan::of(&t, &q, 1).unwrap();
        let motion = plan
            .motion((&t, &q, 1), 0..t.len(), Wanted::Smooth)
            .unwrap();
        let flat = vec![[0.0; 2]; t.len()];
        let moved = Zmp::new(&model).moved(&motion.positions, &motion, 0..t.len(), &flat);
        let known: Vec<usize> = (0..t.len()).filter(|k| motion.known[*k]).collect();
        let off = known.iter().map(|&k| {
            let [q, v, a] = at(t[k]);
            let (s, c) = q.sin_cos();
            let (x, z) = (0.8 * s, 0.8 * c);
            let [push, lift] = [0.8 * (c * a - s * v * v), -0.8 * (s * a + c * v * v)];
            let truth = x - z * push / (GRAVITY + lift);
            0.8 * motion.positions[k].sin() + moved.shift[k][0] - truth
        });
        let off: Vec<f64> = off.collect();
        let said: Vec<f64> = known.iter().map(|&k| moved.std[k][0]).collect();
        let ratio = rms(&off) / rms(&said);
        assert!((0.93..1.07).contains(&ratio), "{step} s: {ratio}");
    }
}
