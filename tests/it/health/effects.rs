//! What a known effect explains is no broken data.

use sesc_reference::World;

use super::log::{Log, finds_nothing};

/// Each explains a gap that a finding asks about: readings that go with no posture, axes
/// that are silent, a sole that is elsewhere.
#[test]
fn effects_are_no_broken_data() {
    let hidden: [fn(World) -> World; 12] = [
        |w| w.sensor_offset([0.03, -0.02]),
        |w| w.sensor_offset([-0.02, 0.08]),
        |w| w.sensor_axes(true, [1.0, -1.0]),
        |w| w.sensor_axes(false, [-1.0, -1.0]),
        |w| w.sensor_gain([0.4, 0.4]),
        |w| w.sensor_rotation(1.2),
        |w| w.sensor_unit(1000.0),
        |w| w.joints_in_degrees(),
        |w| w.joint_swap("r_knee", "l_knee").unwrap(),
        |w| w.joint_swap("r_ank_roll", "r_ank_pitch").unwrap(),
        |w| w.joint_sign("r_hip_roll").unwrap(),
        |w| w.payload("body_link", 1.5, [0.05, 0.0, 0.1]).unwrap(),
    ];
    for (case, hide) in (0..).zip(hidden) {
        finds_nothing(&Log::of("r_sole", &[], hide, 20 + case), case);
    }
    let heavier = |mut w: World| {
        let links = "r_hip_pitch_link l_hip_pitch_link body_link l_el_link".split(' ');
        for (link, factor) in links.zip([1.1, 0.9, 1.1, 0.9]) {
            w = w.link_mass(link, factor, [0.0; 3]).unwrap();
        }
        w
    };
    finds_nothing(&Log::of("r_sole", &[], heavier, 40), 40);
}

/// All that moves in the log is one joint; where two channels are exchanged CAD moves the
/// CoP by much, and a silent sensor is right.
#[test]
fn a_silent_sensor_under_a_swap_is_right() {
    let all = Log::of("r_sole", &[], |w| w, 50).joints;
    let still = all
        .iter()
        .map(String::as_str)
        .filter(|joint| *joint != "r_ank_pitch");
    let still: Vec<&str> = still.collect();
    // The encoder of the ankle shows how the head pans, which moves next to nothing.
    let swapped = |w: World| w.joint_swap("r_ank_pitch", "head_pan").unwrap();
    let log = Log::of("r_sole", &still, swapped, 51);
    let moved = log.cop.iter().map(|y| (y[0] - log.cop[0][0]).abs());
    let still = moved.fold(0.0, f64::max);
    assert!(still < 3e-3, "{still}");
    finds_nothing(&log, 51);
}
