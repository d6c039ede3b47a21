//! Robots and postures that several tests share.

use sesc_reference::{Error, ErrorKind, Reference, Robot, World};

/// Reads a robot from lines: URDF, `link NAME MASS_KG COM_M`, or `KIND NAME PARENT CHILD` of a
/// joint, behind which `|` stand the attributes of its origin, and its axis, limit and mimic.
pub(crate) fn robot(text: &str) -> Robot {
    Robot::from_urdf(&urdf("name='test'", text)).expect("the test robot reads")
}

/// The URDF of such lines with these attributes of the robot.
pub(crate) fn urdf(attributes: &str, text: &str) -> String {
    let element = |line: &str| {
        let mut parts = line.split('|').map(str::trim);
        let words: Vec<&str> = parts.next().unwrap().split_whitespace().collect();
        match words[..] {
            ["link", name, kg, x, y, z] => format!(
                "<link name='{name}'><inertial><origin xyz='{x} {y} {z}'/><mass value='{kg}'/>\
                 </inertial></link>"
            ),
            [kind, name, parent, child] if !kind.starts_with('<') => format!(
                "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>\
                 <origin {}/>{}</joint>",
                parts.next().unwrap_or_default(),
                parts.next().unwrap_or_default()
            ),
            _ => line.to_owned(),
        }
    };
    let elements: String = text
        .trim()
        .lines()
        .map(|line| element(line.trim()))
        .collect();
    format!("<robot {attributes}>{elements}</robot>")
}

/// Asserts that numbers are as near as that, each to its own.
#[track_caller]
pub(crate) fn near<const N: usize>(found: [f64; N], expected: [f64; N], tolerance: f64) {
    let squares = found.iter().zip(expected).map(|(a, b)| (a - b) * (a - b));
    let error = squares.sum::<f64>().sqrt();
    assert!(error < tolerance, "{found:?} is not {expected:?}");
}

/// What an error is about, of a call that must have one.
pub(crate) fn kind<T>(found: Result<T, Error>) -> ErrorKind {
    found.err().expect("this call is refused").kind()
}

/// A tree with every way of moving: branches, skewed axes, a prismatic joint, a mimic, a
/// fixed joint, a massless link. Root `torso`; four revolute joints, one prismatic,
/// one mimic.
pub(crate) fn bushy() -> Robot {
    robot(
        "link torso 3.0 0.02 -0.01 0.1
         link thigh 1.1 0.01 0.02 -0.2
         link shin 0.7 -0.01 0.005 -0.15
         link foot 0.3 0.03 0.0 -0.02
         <link name='sole'/>
         link arm 0.5 0.1 0.03 0.02
         link piston 0.2 0.0 0.04 0.01
         link finger 0.05 0.02 0.01 0.0
         revolute hip torso thigh | xyz='0 -0.1 -0.1' rpy='0.1 0.2 -0.3' | <axis xyz='1 2 -1'/>
         revolute knee thigh shin | xyz='0.01 0 -0.4' | <axis xyz='0 1 0.1'/>
         continuous ankle shin foot | xyz='0 0.01 -0.3' rpy='0 0.5 0' | <axis xyz='0.3 1 0'/>
         fixed flange foot sole | xyz='0.05 0 -0.05' rpy='0.02 -0.5 0.4'
         revolute shoulder torso arm | xyz='0 0.2 0.3' rpy='1.5 0 0' | <axis xyz='1 1 1'/>
         prismatic slide arm piston | xyz='0.2 0 0' rpy='0 0 0.7' | <axis xyz='1 0.5 0'/>
         revolute curl piston finger | xyz='0.1 0 0' | <axis xyz='0 0 1'/>\
         <mimic joint='shoulder' multiplier='-0.7' offset='0.2'/>",
    )
}

/// Postures spread evenly over the joints' ranges; the same every time.
pub(crate) fn postures(reference: &Reference, count: usize) -> Vec<Vec<f64>> {
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
pub(crate) fn leaning() -> Robot {
    robot(
        "<link name='foot'/>
         link stick 2 0 0 0.5
         continuous ankle foot stick | xyz='0 0 0.1' | <axis xyz='0 1 0'/>",
    )
}

pub(crate) const LEANING_KG: f64 = 2.0;
pub(crate) const LEANING_M: f64 = 0.5;

/// The same thing, described from the stick down: the foot is the ankle's child.
pub(crate) fn leaning_from_above() -> Robot {
    robot(
        "link stick 2 0 0 0.5
         <link name='foot'/>
         continuous ankle stick foot | | <axis xyz='0 -1 0'/>",
    )
}

/// The leaning stick as it stands on its foot.
pub(crate) fn stick() -> World {
    World::new(&leaning(), "foot").unwrap()
}

/// The tree and its reference on its sole, and its virtual robot.
pub(crate) fn bushy_on_sole() -> (Robot, Reference, World) {
    let robot = bushy();
    let reference = Reference::new(&robot, "sole").unwrap();
    let world = World::new(&robot, "sole").unwrap();
    (robot, reference, world)
}
