//! Orientations that urdf-rs would round: quaternions, as roll, pitch and yaw.

use nalgebra::{Quaternion, UnitQuaternion};
use roxmltree::Node;

use crate::error::{Error, Problem};

/// The `quat_xyzw` of an `<origin>` as `rpy`; it counts from URDF 1.1 on. A missing or odd version
/// means 1.0.
pub(crate) fn angles(origin: Node) -> Result<Option<String>, Error> {
    let root = origin.document().root_element();
    let version = root.attribute("version").unwrap_or_default().trim();
    let version = version
        .split_once('.')
        .and_then(|(major, minor)| Some((major.parse::<u32>().ok()?, minor.parse::<u32>().ok()?)));
    let Some(text) = origin
        .attribute("quat_xyzw")
        .filter(|_| version >= Some((1, 1)))
    else {
        return Ok(None);
    };
    let place = || place(origin);
    if origin.has_attribute("rpy") {
        return Err(Problem::TwoOrientations { place: place() }.into());
    }
    let unit = match numbers(text)[..] {
        [x, y, z, w] => {
            let quaternion = Quaternion::new(w, x, y, z);
            // Its length may overflow.
            UnitQuaternion::try_new(quaternion / quaternion.coords.amax(), 0.0)
        }
        _ => None,
    };
    let unit = unit.ok_or_else(|| Problem::NoQuaternion { place: place() })?;
    // Upright, roll and yaw are about one axis, and the roll makes up for whatever the yaw is.
    let m = unit.to_rotation_matrix();
    let yaw = m[(1, 0)].atan2(m[(0, 0)]);
    let pitch = (-m[(2, 0)]).atan2(m[(0, 0)].hypot(m[(1, 0)]));
    let (s, c) = yaw.sin_cos();
    let roll = (s * m[(0, 2)] - c * m[(1, 2)]).atan2(c * m[(1, 1)] - s * m[(0, 1)]);
    Ok(Some(format!("{roll:?} {pitch:?} {yaw:?}")))
}

/// The words of `text` as numbers, NaN for those that are none.
pub(crate) fn numbers(text: &str) -> Vec<f64> {
    let words = text.split_whitespace();
    words.map(|word| word.parse().unwrap_or(f64::NAN)).collect()
}

/// The link or joint around `node`, for messages.
pub(crate) fn place(node: Node) -> String {
    let owner = node.ancestors().find(|node| node.has_attribute("name"));
    let (kind, name) = owner.map_or(("robot", ""), |owner| {
        (
            owner.tag_name().name(),
            owner.attribute("name").unwrap_or_default(),
        )
    });
    format!("{kind} `{name}`")
}
