//! A sensor whose axes are exchanged, mirrored or turned, as a fit of masses sees it.

use sesc_reference::World;
use sesc_test_support::command::says;

use super::log::{Log, NOISE_M};
use crate::asked::kinds;

/// The eight ways in which axes lie along each other but one, and a yaw of any size.
#[test]
fn axes_that_are_turned_are_named_by_a_fit() {
    let turned = |yaw: f64, [x, y]: [f64; 2]| {
        let (sine, cosine) = yaw.to_radians().sin_cos();
        [cosine * x - sine * y, sine * x + cosine * y]
    };
    type Axes = Box<dyn Fn([f64; 2]) -> [f64; 2]>;
    let ways: [(&str, Axes); 10] = [
        ("x and y are exchanged", Box::new(|[x, y]| [y, x])),
        ("x is −y and y is −x", Box::new(|[x, y]| [-y, -x])),
        ("x axis points the other way", Box::new(|[x, y]| [-x, y])),
        ("y axis points the other way", Box::new(|[x, y]| [x, -y])),
        ("by 90°", Box::new(|[x, y]| [-y, x])),
        ("by −90°", Box::new(|[x, y]| [y, -x])),
        ("by 180°", Box::new(|[x, y]| [-x, -y])),
        ("by 30° about", Box::new(move |y| turned(30.0, y))),
        ("by -50° about", Box::new(move |y| turned(-50.0, y))),
        ("by 140° about", Box::new(move |y| turned(140.0, y))),
    ];
    for (case, (words, way)) in (200..).zip(ways) {
        let mut log = Log::of("r_sole", &[], |w| w, case);
        log.cop.iter_mut().for_each(|y| *y = way(*y));
        let found = log.fit().health;
        assert_eq!(kinds(&found), [("frame_turned", "r_sole")], "{words}");
        says(&found[0].sentence, &[words]);
        assert!(found[0].picture.is_some());
    }
}

/// What is no turn of the axes is none: other effects, small turns, and noise.
#[test]
fn other_effects_are_no_turn() {
    let hidden: [fn(World) -> World; 12] = [
        |w| w,
        |w| w.sensor_rotation(0.2),
        |w| w.sensor_offset([0.03, -0.02]),
        |w| w.sensor_gain([0.4, 1.4]),
        |w| w.joint_swap("r_knee", "l_knee").unwrap(),
        |w| w.joint_swap("r_ank_roll", "r_ank_pitch").unwrap(),
        |w| w.joint_swap("r_hip_roll", "r_hip_pitch").unwrap(),
        |w| w.joint_sign("r_hip_roll").unwrap(),
        |w| w.joint_sign("r_ank_pitch").unwrap(),
        |w| w.joint_sign("r_ank_roll").unwrap(),
        |w| w.payload("body_link", 1.5, [0.05, 0.0, 0.1]).unwrap(),
        |w| w.joint_offset("r_ank_roll", 0.3).unwrap(),
    ];
    for (case, hide) in (230..).zip(hidden) {
        let found = Log::of("r_sole", &[], hide, case).fit().health;
        assert!(found.is_empty(), "{case}: {found:?}");
    }
    // Noise as large as the motion of the CoP.
    let mut log = Log::of("r_sole", &[], |w| w, 250);
    for (k, y) in log.cop.iter_mut().enumerate() {
        *y = [[1.7, 2.9], [3.1, 0.7]].map(|[a, b]| {
            let phase = 1000.0 * k as f64;
            100.0 * NOISE_M * ((a * phase).sin() + (b * phase).cos())
        });
    }
    log.noise_is_given = false;
    let found = log.fit().health;
    let mut kinds = kinds(&found).into_iter();
    assert!(kinds.all(|(kind, _)| kind != "frame_turned"), "{found:?}");
}
