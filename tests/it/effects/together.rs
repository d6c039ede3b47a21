//! Effects that meet: loads change what springs, forces and cells feel.

use super::hidden::Hidden;
use super::robots::Stand;
use super::virtual_robot::compare_all;

/// Each a list of effect, target and values; the robot's own sizes as 1.
type Meeting = &'static [(&'static str, &'static str, &'static [f64])];

const MEETINGS: [(Meeting, f64); 9] = [
    // Two loads: shares of the whole, whichever comes first.
    (
        &[
            ("payload", "body_link", &[0.5, 0.02, 0.01, 0.1]),
            ("payload", "l_el_link", &[0.3, 0.0, 0.03, 0.0]),
        ],
        1e-12,
    ),
    (
        &[
            ("payload", "l_el_link", &[0.3, 0.0, 0.03, 0.0]),
            ("external_force", "body_link", &[1.0, -2.0, 3.0]),
        ],
        1e-12,
    ),
    (
        &[
            ("external_force", "body_link", &[1.0, -2.0, 3.0]),
            ("external_force", "l_el_link", &[0.5, 0.5, -2.0]),
        ],
        1e-12,
    ),
    // A spring feels the load: in N, not in parts of the weight.
    (
        &[
            ("payload", "body_link", &[0.5, 0.02, 0.01, 0.1]),
            ("joint_compliance", "r_knee", &[300.0]),
        ],
        1e-9,
    ),
    // So does a cell; and an offset in N is a smaller part of more.
    (
        &[
            ("payload", "body_link", &[0.5, 0.0, 0.0, 0.1]),
            ("cell_offset", "fsr_2", &[1.5]),
            ("cell_exponent", "fsr_1", &[1.2]),
        ],
        1e-9,
    ),
    // Cells that err together share one true CoP.
    (
        &[
            ("cell_gain", "fsr_1", &[0.7]),
            ("cell_gain", "fsr_3", &[1.4]),
            ("cell_offset", "fsr_4", &[0.8]),
        ],
        1e-12,
    ),
    // Zero after gain, direction after scale, wiring last; drift before it.
    (
        &[
            ("sensor_axes", "swapped", &[]),
            ("sensor_drift", "-", &[0.004, -0.002]),
            ("sensor_offset", "-", &[0.003, 0.001]),
            ("units", "millimetres", &[]),
            ("sensor_rotation", "-", &[0.2]),
            ("sensor_gain", "-", &[1.2, 0.9]),
        ],
        1e-9,
    ),
    (
        &[
            ("joint_offset", "r_knee", &[0.1]),
            ("joint_swap", "r_knee,l_knee", &[]),
            ("joint_scale", "r_knee", &[1.2]),
        ],
        1e-12,
    ),
    // A pull keeps its direction on a slope. Forces over cos of it: a part slope²/2.
    (
        &[
            ("ground_slope", "-", &[0.01, -0.02]),
            ("external_force", "body_link", &[1.0, -2.0, 3.0]),
        ],
        2e-5,
    ),
];

#[test]
fn effects_act_on_what_the_others_left() {
    let stand = Stand::new("op2", "r_sole");
    let context = stand.context();
    for (meeting, allowed) in MEETINGS {
        let all = meeting.iter();
        let hidden = all.map(|(effect, target, values)| stand.hidden(effect, target, values));
        let hidden: Vec<Hidden> = hidden.collect();
        let labels: Vec<String> = hidden.iter().map(|h| h.instance.label(&context)).collect();
        let found = compare_all(&stand, &hidden);
        assert!(found.off <= allowed, "{labels:?}: {:.1e}", found.off);
        assert!(found.moved > 1e-3, "{labels:?}: {:.1e}", found.moved);
    }
}
