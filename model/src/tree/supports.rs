//! Links that a robot may stand on, by their names.

use std::collections::{HashMap, HashSet};

use crate::text;
use crate::urdf::nearest::suggest;
use crate::urdf::{Description, Joint, JointType};

/// Words in the names of links that stand on the ground, the likeliest first.
const SUPPORTS: [&str; 3] = ["sole", "foot", "ankle"];

/// How unlikely a robot stands on the link of this name: 0 for a sole.
#[doc(hidden)]
pub fn support_rank(link: &str) -> usize {
    let name = link.to_lowercase();
    let first = SUPPORTS.iter().position(|word| name.contains(word));
    first.unwrap_or(SUPPORTS.len())
}

/// Whether a link's name says that it lies in a sole.
#[doc(hidden)]
pub fn is_sole(link: &str) -> bool {
    support_rank(link) == 0
}

/// The feet of a robot: rigid bodies at the end of a chain of joints, toes aside, with a link that
/// has `sole` or `foot` in its name; each by the first such link, which carries the others.
/// `base_footprint`, the frame of a robot on the ground, is none, nor are frames of sensors.
#[doc(hidden)]
pub fn feet(robot: &Description) -> Vec<String> {
    let names: Vec<&str> = robot.link_names().collect();
    let is_foot = |name: &str| support_rank(&name.to_lowercase().replace("footprint", "")) < 2;
    let index: HashMap<&str, usize> = names.iter().copied().zip(0..).collect();
    let ends = |joint: &Joint| {
        let of = |link: &String| index.get(link.as_str()).copied();
        Some([of(&joint.parent)?, of(&joint.child)?])
    };
    let mut carrier = vec![None; names.len()];
    for joint in &robot.joints {
        if let Some([parent, child]) = ends(joint) {
            carrier[child] = Some((parent, joint.joint_type == JointType::Fixed));
        }
    }
    // Links that are one rigid body have its first link.
    let body = |link: usize| {
        let fixed = |link: &usize| carrier[*link].and_then(|(parent, is)| is.then_some(parent));
        std::iter::successors(Some(link), fixed)
            .last()
            .unwrap_or(link)
    };
    let mut beside: HashMap<usize, Vec<usize>> = HashMap::new();
    for joint in robot
        .joints
        .iter()
        .filter(|joint| joint.joint_type != JointType::Fixed)
    {
        if let Some([parent, child]) = ends(joint) {
            let (parent, child) = (body(parent), body(child));
            beside.entry(parent).or_default().push(child);
            beside.entry(child).or_default().push(parent);
        }
    }
    let degree = |body: &usize| beside.get(body).map_or(0, Vec::len);
    let is_end = |own: usize| {
        // Toes hang on one that leads on to the robot alone.
        let all = beside.get(&own).into_iter().flatten();
        degree(&own) < 2 || all.filter(|body| degree(body) > 1).count() == 1
    };
    let mut seen = HashSet::new();
    let first = (0..names.len()).filter(|&link| {
        let mut carriers = std::iter::successors(carrier[link], |(link, _)| carrier[*link]);
        is_foot(names[link])
            && !carriers.any(|(link, _)| is_foot(names[link]))
            && is_end(body(link))
            && seen.insert(body(link))
    });
    first.map(|link| names[link].to_string()).collect()
}

/// What can and cannot be said of a robot that stands on more than two feet at once, where it
/// has so many.
#[doc(hidden)]
pub fn on_many_feet(feet: &[String]) -> Option<String> {
    let count = feet.len();
    (count > 2).then(|| {
        format!(
            "the robot has {count} feet ({}): its CoM holds however many stand; the CoP is that of \
             one foot that carries the robot alone, or of two flat soles on one floor, links with \
             `sole` in their names (`both_feet = true` in the sidecar of the log). Point feet that stand together are \
             not described, and a log that was recorded on more than two feet cannot be used",
            text::listed(feet, 12)
        )
    })
}

/// Up to a dozen names for a message, those that contain `asked` first, then soles and feet,
/// and the one that was probably meant.
pub(super) fn name_some<'a>(asked: &str, names: impl Iterator<Item = &'a str>) -> String {
    let mut names: Vec<&str> = names.collect();
    let meant = suggest(asked, "", names.iter().copied()).unwrap_or_default();
    let asked = asked.to_lowercase();
    names.sort_by_key(|name| (!name.to_lowercase().contains(&asked), support_rank(name)));
    text::listed(names, 12) + &meant
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::urdf;

    /// Feet of a robot whose links hang on each other by fixed joints, but for those on the trunk.
    fn feet_of(carried: &[(&str, &str)]) -> Vec<String> {
        let mut text = "<robot name='r'><link name='trunk'><inertial><mass value='1'/></inertial>\
            </link>"
            .to_string();
        for (child, parent) in carried {
            let kind = match *parent == "trunk" && !child.contains("base") {
                true => "continuous",
                false => "fixed",
            };
            text += &format!(
                "<link name='{child}'/><joint name='to_{child}' type='{kind}'>\
                 <parent link='{parent}'/><child link='{child}'/><axis xyz='0 1 0'/></joint>"
            );
        }
        feet(&urdf::parse(&(text + "</robot>"), "r.urdf").unwrap())
    }

    #[test]
    fn a_foot_and_its_sole_are_one_foot() {
        let humanoid = [
            ("base_footprint", "trunk"),
            ("base_foot_camera", "trunk"),
            ("l_foot", "trunk"),
            ("l_sensor", "l_foot"),
            ("l_sole", "l_sensor"),
            ("R_Foot", "trunk"),
            ("r_toe", "R_Foot"),
        ];
        let feet = feet_of(&humanoid);
        assert_eq!(feet, ["l_foot", "R_Foot"]);
        assert_eq!(on_many_feet(&feet), None);
    }

    #[test]
    fn four_feet_are_told_what_they_can_be_used_for() {
        let legs = ["lf", "rf", "lh", "rh"];
        let names = legs.map(|leg| format!("{leg}_foot"));
        let carried: Vec<(&str, &str)> = names.iter().map(|name| (&**name, "trunk")).collect();
        assert_eq!(feet_of(&carried), names);
        let said = on_many_feet(&names).unwrap();
        for words in [
            "4 feet (lf_foot, rf_foot, lh_foot, rh_foot)",
            "both_feet",
            "cannot be used",
        ] {
            assert!(said.contains(words), "{said}");
        }
    }
}
