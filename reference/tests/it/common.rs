//! Robots and postures that several tests share.

use sesc_reference::{Error, ErrorKind, Reference, Robot};

/// Reads a robot from its links and joints alone.
pub fn robot(body: &str) -> Robot {
    Robot::from_urdf(&format!("<robot name='test'>{body}</robot>")).expect("the test robot reads")
}

/// What an error is about, of a call that must have one.
pub fn kind<T>(found: Result<T, Error>) -> ErrorKind {
    found.err().expect("this call is refused").kind()
}

/// A link with mass.
pub fn link(name: &str, mass_kg: f64, com_m: [f64; 3]) -> String {
    let [x, y, z] = com_m;
    format!(
        "<link name='{name}'><inertial><origin xyz='{x} {y} {z}'/><mass value='{mass_kg}'/>\
         </inertial></link>"
    )
}

/// A joint; `more` holds axis, limit and mimic.
pub fn joint(
    name: &str,
    kind: &str,
    parent: &str,
    child: &str,
    origin: &str,
    more: &str,
) -> String {
    format!(
        "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>\
         <origin {origin}/>{more}</joint>"
    )
}

/// A tree with every way of moving: branches, skewed axes, a prismatic joint, a mimic, a
/// fixed joint, a massless link. Root `torso`; four revolute joints, one prismatic,
/// one mimic.
pub fn bushy() -> Robot {
    robot(
        &[
            link("torso", 3.0, [0.02, -0.01, 0.1]),
            link("thigh", 1.1, [0.01, 0.02, -0.2]),
            link("shin", 0.7, [-0.01, 0.005, -0.15]),
            link("foot", 0.3, [0.03, 0.0, -0.02]),
            "<link name='sole'/>".to_owned(),
            link("arm", 0.5, [0.1, 0.03, 0.02]),
            link("piston", 0.2, [0.0, 0.04, 0.01]),
            link("finger", 0.05, [0.02, 0.01, 0.0]),
            joint(
                "hip",
                "revolute",
                "torso",
                "thigh",
                "xyz='0 -0.1 -0.1' rpy='0.1 0.2 -0.3'",
                "<axis xyz='1 2 -1'/>",
            ),
            joint(
                "knee",
                "revolute",
                "thigh",
                "shin",
                "xyz='0.01 0 -0.4'",
                "<axis xyz='0 1 0.1'/>",
            ),
            joint(
                "ankle",
                "continuous",
                "shin",
                "foot",
                "xyz='0 0.01 -0.3' rpy='0 0.5 0'",
                "<axis xyz='0.3 1 0'/>",
            ),
            joint(
                "flange",
                "fixed",
                "foot",
                "sole",
                "xyz='0.05 0 -0.05' rpy='0.02 -0.5 0.4'",
                "",
            ),
            joint(
                "shoulder",
                "revolute",
                "torso",
                "arm",
                "xyz='0 0.2 0.3' rpy='1.5 0 0'",
                "<axis xyz='1 1 1'/>",
            ),
            joint(
                "slide",
                "prismatic",
                "arm",
                "piston",
                "xyz='0.2 0 0' rpy='0 0 0.7'",
                "<axis xyz='1 0.5 0'/>",
            ),
            joint(
                "curl",
                "revolute",
                "piston",
                "finger",
                "xyz='0.1 0 0'",
                "<axis xyz='0 0 1'/><mimic joint='shoulder' multiplier='-0.7' offset='0.2'/>",
            ),
        ]
        .concat(),
    )
}

/// Postures spread evenly over the joints' ranges; the same every time.
pub fn postures(reference: &Reference, count: usize) -> Vec<Vec<f64>> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut uniform = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let limits = reference.limits();
    (0..count)
        .map(|_| {
            let range = limits.iter();
            range
                .map(|(low, high)| low + (high - low) * uniform())
                .collect()
        })
        .collect()
}

/// A mass of 2 kg on a stick of 0.5 m that leans over an ankle 0.1 m above the
/// foot: at `q` it stands at x = 0.5 sin q, z = 0.1 + 0.5 cos q.
pub fn leaning() -> Robot {
    robot(
        &[
            "<link name='foot'/>".to_owned(),
            link("stick", LEANING_KG, [0.0, 0.0, LEANING_M]),
            joint(
                "ankle",
                "continuous",
                "foot",
                "stick",
                "xyz='0 0 0.1'",
                "<axis xyz='0 1 0'/>",
            ),
        ]
        .concat(),
    )
}

pub const LEANING_KG: f64 = 2.0;
pub const LEANING_M: f64 = 0.5;

/// The same thing, described from the stick down: the foot is the ankle's child.
pub fn leaning_from_above() -> Robot {
    robot(
        &[
            link("stick", LEANING_KG, [0.0, 0.0, LEANING_M]),
            "<link name='foot'/>".to_owned(),
            joint(
                "ankle",
                "continuous",
                "stick",
                "foot",
                "",
                "<axis xyz='0 -1 0'/>",
            ),
        ]
        .concat(),
    )
}
