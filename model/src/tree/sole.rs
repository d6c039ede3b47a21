//! The frame of a sole that has no link of its own in the URDF.
//!
//! ```text
//! LINK@40mm        the frame of LINK, moved by 40 mm along its −z: z = 0 in the sole
//! ```
//!
//! It is a link without mass behind a fixed joint, as if the URDF had it; every name of a
//! support (command line, sidecar, model file, build script) may be one.

use std::borrow::Cow;

use super::supports::name_some;
use super::{Motion, Tree};
use crate::Error;
use crate::error::Problem;
use crate::urdf::{Description, Inertial, Joint, JointType, Limit, Link, Origin};

/// No foot is higher, mm.
const HIGHEST_MM: f64 = 2000.0;

/// A shape may reach so far below the sole, as rubber does, mm.
const SHALLOW_MM: f64 = 2.0;

/// The name of the frame `height_m` below that of `link`.
///
/// ```
/// assert_eq!(sesc_model::tree::sole_of("foot", 0.035), "foot@35mm");
/// ```
#[doc(hidden)]
pub fn sole_of(link: &str, height_m: f64) -> String {
    // Below a nanometre is rounding; nothing is below zero by nothing.
    let mm = libm::round(1e9 * height_m) / 1e6 + 0.0;
    format!("{link}@{mm}mm")
}

/// `LINK@40mm` as `LINK` and 40.
fn parts(support: &str) -> Option<(&str, &str)> {
    support.strip_suffix("mm")?.rsplit_once('@')
}

/// What is said of a robot whose support link has a shape that reaches below its frame.
#[doc(hidden)]
pub fn below(robot: &Description, support: &str) -> Option<String> {
    let mut links = robot.link_names().zip(&robot.shapes);
    let (link, shape) = links.find(|(link, _)| *link == support)?;
    let mm = -1000.0 * shape.as_ref()?.low[2];
    let sole = sole_of(link, libm::round(10.0 * mm) / 1e4);
    (mm > SHALLOW_MM).then(|| {
        format!(
            "the ground is at z = 0 of `{link}`, and the collision shape of `{link}` reaches \
             {mm:.1} mm below it; if the robot stands on the lowest point of that shape, \
             its support link is `{sole}`"
        )
    })
}

/// How much further the CoM is along another axis than along z before that axis is asked about.
const SIDEWAYS: f64 = 3.0;

/// What is said of a foot whose z axis does not point to the CoM where all joints are in their
/// middle, with the lines of URDF that make a sole of it.
pub(super) fn turned(robot: &Description, tree: &Tree) -> Option<String> {
    let support = &tree.links[tree.support].name;
    let link = sole_parts(support)
        .and_then(Result::ok)
        .map_or(&**support, |(link, _)| link);
    let body = |name: &String| name == link || rigid_with(tree, name);
    if !tree.feet.iter().any(body) {
        return None;
    }
    let com = tree.com_in_the_middle();
    let reach = |axis: usize| libm::fabs(com[axis]);
    let up = if reach(0) > reach(1) { 0 } else { 1 };
    let is_up = com[2] > 0.0 && reach(up) < SIDEWAYS * com[2];
    if is_up || !(reach(up) > SIDEWAYS * reach(2) || com[2] < 0.0) {
        return None;
    }
    let up = if reach(up) > SIDEWAYS * reach(2) {
        up
    } else {
        2
    };
    let down = com[up] < 0.0;
    let (name, sign) = (["x", "y", "z"][up], if down { "-" } else { "" });
    let quarter = std::f64::consts::FRAC_PI_2;
    let rpy = match (up, down) {
        (0, false) => [0.0, quarter, 0.0],
        (0, true) => [0.0, -quarter, 0.0],
        (1, false) => [-quarter, 0.0, 0.0],
        (1, true) => [quarter, 0.0, 0.0],
        _ => [2.0 * quarter, 0.0, 0.0],
    };
    let mut links = robot.link_names().zip(&robot.shapes);
    let shape = links
        .find(|(own, _)| *own == link)
        .and_then(|(_, shape)| shape.as_ref());
    let lowest = shape.map_or(
        0.0,
        |shape| if down { shape.high[up] } else { shape.low[up] },
    );
    let mut xyz = [0.0; 3];
    xyz[up] = lowest;
    let [x, y, z] = xyz;
    let [roll, pitch, yaw] = rpy;
    let mm = com.map(|x| libm::round(1000.0 * x));
    Some(format!(
        "in the middle of its joints the CoM is {} mm along x, {} mm along y and {} mm along z of \
         `{support}`: does {sign}{name} point up? A sole needs z up; these lines before </robot> are \
         one: <link name=\"{link}_sole\"/> <joint name=\"{link}_sole_fixed\" type=\"fixed\"><parent \
         link=\"{link}\"/><child link=\"{link}_sole\"/><origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} \
         {yaw}\"/></joint>",
        mm[0], mm[1], mm[2]
    ))
}

/// Whether a link is of the rigid body of the support.
fn rigid_with(tree: &Tree, name: &str) -> bool {
    let mut body = vec![false; tree.links.len()];
    body[tree.support] = true;
    for edge in &tree.edges {
        body[edge.far] = body[edge.near] && edge.motion == Motion::Fixed;
    }
    tree.links
        .iter()
        .zip(body)
        .any(|(link, own)| own && link.name == name)
}

/// The link and the height of its frame over the sole, m, of a name `LINK@40mm`; none of another
/// name.
///
/// ```
/// use sesc_model::tree::sole_parts;
///
/// assert_eq!(sole_parts("foot@40mm"), Some(Ok(("foot", 0.04))));
/// assert_eq!(sole_parts("foot"), None);
/// // Each sole has one name.
/// assert_eq!(sole_parts("foot@40.0mm"), Some(Err("foot@40mm".to_string())));
/// ```
///
/// # Errors
/// What was meant, where the height is none, or is written in another way.
#[doc(hidden)]
pub fn sole_parts(support: &str) -> Option<Result<(&str, f64), String>> {
    let (link, height) = parts(support)?;
    let mm: Option<f64> = height.parse().ok();
    let mm = mm.filter(|mm| mm.is_finite() && libm::fabs(*mm) <= HIGHEST_MM);
    let meant = mm.map(|mm| sole_of(link, mm / 1000.0));
    Some(match (mm, meant) {
        (Some(mm), Some(meant)) if meant == support => Ok((link, mm / 1000.0)),
        (_, meant) => Err(meant.unwrap_or_else(|| format!("{link}@40mm"))),
    })
}

/// The sole of `link` at the height at which `support` is one of its link; `link` where it is none.
///
/// ```
/// assert_eq!(sesc_model::tree::like_sole("r_foot@40mm", "l_foot"), "l_foot@40mm");
/// ```
#[doc(hidden)]
pub fn like_sole(support: &str, link: &str) -> String {
    match parts(support) {
        Some((_, height)) => format!("{link}@{height}mm"),
        None => link.to_string(),
    }
}

/// Whether a robot with these links can stand on `support`: one of them, or the sole of one.
#[doc(hidden)]
pub fn is_support<'a>(support: &str, mut links: impl Iterator<Item = &'a str>) -> bool {
    let carrier = parts(support).map(|(link, _)| link);
    links.any(|link| link == support || Some(link) == carrier)
}

/// The robot with a link `support`, which may be the sole of another one.
pub(super) fn standing<'a>(
    robot: &'a Description,
    support: &str,
) -> Result<Cow<'a, Description>, Error> {
    let has = |name: &str| robot.link_names().any(|link| link == name);
    if has(support) {
        return Ok(Cow::Borrowed(robot));
    }
    let link = match parts(support) {
        Some((link, _)) if has(link) => link,
        parts => {
            let name = parts.map_or(support, |(link, _)| link);
            return Err(Problem::UnknownSupport {
                file: robot.file.clone(),
                name: name.to_string(),
                links: name_some(name, robot.link_names()),
            }
            .into());
        }
    };
    let height_m = match sole_parts(support) {
        Some(Ok((_, height_m))) => height_m,
        meant => {
            let meant = meant.and_then(Result::err);
            return Err(Problem::NoHeight {
                support: support.to_string(),
                meant: meant.unwrap_or_else(|| format!("{link}@40mm")),
            }
            .into());
        }
    };
    let mut with = robot.clone();
    with.links.push(Link {
        name: support.to_string(),
        inertial: Inertial::default(),
    });
    with.joints.push(Joint {
        name: support.to_string(),
        joint_type: JointType::Fixed,
        origin: Origin {
            xyz: [0.0, 0.0, -height_m],
            rpy: [0.0; 3],
        },
        parent: link.to_string(),
        child: support.to_string(),
        axis: [1.0, 0.0, 0.0],
        limit: Limit::NONE,
        mimic: None,
    });
    Ok(Cow::Owned(with))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::urdf;

    fn robot() -> Description {
        let text = "<robot name='r'><link name='foot'><inertial><mass value='1'/></inertial></link>\
            <link name='a@1mm'><inertial><mass value='1'/></inertial></link>\
            <joint name='j' type='fixed'><parent link='foot'/><child link='a@1mm'/></joint></robot>";
        urdf::parse(text, "r.urdf").unwrap()
    }

    fn refused(support: &str) -> String {
        standing(&robot(), support).unwrap_err().to_string()
    }

    #[test]
    fn a_sole_is_a_link_below_its_foot() {
        let robot = robot();
        let with = standing(&robot, "foot@35mm").unwrap();
        assert_eq!(with.links.len(), 3);
        assert_eq!(with.joints[1].origin.xyz, [0.0, 0.0, -0.035]);
        assert_eq!((&with.hash, &with.text), (&robot.hash, &robot.text));
        // A link of that name is itself.
        assert!(matches!(standing(&robot, "a@1mm"), Ok(Cow::Borrowed(_))));
        assert!(standing(&robot, "a@1mm@-2.5mm").is_ok());
        let links = || robot.link_names();
        assert!(is_support("foot@35mm", links()) && is_support("a@1mm", links()));
        assert!(!is_support("hand@35mm", links()) && !is_support("foot@35", links()));
    }

    #[test]
    fn one_frame_has_one_name_and_a_wrong_one_says_which() {
        assert!(refused("foot@35.0mm").contains("`foot@35mm`"));
        assert!(refused("foot@0.0350mm").contains("`foot@0.035mm`"));
        assert!(refused("foot@xmm").contains("such as `foot@40mm`"));
        assert!(refused("foot@35000mm").contains("such as `foot@40mm`"));
        assert!(refused("foot@nanmm").contains("such as `foot@40mm`"));
        assert!(refused("fot@35mm").contains("no link `fot`"));
        assert!(refused("foot@35").contains("no link `foot@35`"));
    }

    #[test]
    fn heights_have_no_digits_of_rounding() {
        for (height_m, name) in [(0.035, "f@35mm"), (-0.0126, "f@-12.6mm"), (0.0, "f@0mm")] {
            assert_eq!(sole_of("f", height_m), name);
        }
    }
}
