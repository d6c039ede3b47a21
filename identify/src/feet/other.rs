//! Which link is the other sole.
//!
//! # Contacts
//!
//! Readers ask where one sole is, seen from another: for recordings that have the contact of each by itself,
//! and for readings that are put together from both where a joint is off.
//!
//! ```text
//! y = (1 − s) p₁ + s T(q) p₂                         as the encoders q have the other sole
//!   = CoP(φ) − s Σ_j ∂(T p₂)/∂q_j (φ_j − q_j)        where its joints are at φ
//! ```
//!
//! # Readings of one foot
//!
//! Readings of a two-foot stand are those of both feet together:
//!
//! ```text
//! p = (F₁ p₁ + F₂ p₂) / (F₁ + F₂)        seen from the support; it goes with the CoM: slope 1
//! ```
//!
//! The CoP of one foot alone stays under it, however the CoM moves between the two.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Vector3;
use sesc_model::effects::PostureContext;
use sesc_model::text::listed;
use sesc_model::tree::{is_sole, like_sole, on_many_feet, sole_parts, support_rank};
use sesc_model::urdf::suggestion;
use sesc_model::{Function, Model, Snapping};

use crate::evaluate::Evaluator;
use crate::logs::{Frame, Sidecar, Soles};
use crate::observations::postures::Postures;
use crate::robot::Robot;
use crate::{Error, Setting, message, poses};

/// CAD's CoP moves at least so much, RMS, before anything can be said, m. Chosen: half of
/// it judges by noise.
const MOVES_M: f64 = 5e-3;
/// Readings of both feet go with it by more than this. Chosen: half of it takes readings of
/// one foot for both.
const GOES_WITH: f64 = 0.4;
/// Standard errors by which it has to be less. Chosen: one log of 740 by chance (closed
/// form).
const ERRORS: f64 = 3.0;
/// Postures that say it. Chosen: with half as many a correlation is off by 0.4 (closed
/// form, 1/√n).
const FEWEST: usize = 10;

/// What names of the two sides differ by.
const SIDES: [(&str, &str); 2] = [("left", "right"), ("l", "r")];

/// What a caller says of the feet on the floor; it wins over a log's sidecar.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Feet {
    /// Whether both are on the floor in every row; the sidecar's unless given.
    pub both: Option<bool>,
    /// The link that is the other sole, or the sole of one (`foot@40mm`); it says that both are on the floor, too.
    pub other: Option<String>,
}

/// The other sole of a two-foot stand.
#[derive(Debug, Clone, PartialEq)]
pub struct OtherFoot {
    /// Index among the tree's links.
    pub link: usize,
    /// How far the sole is below the link's origin along its −z, m; 0 of a link in the sole.
    pub below_m: f64,
    /// Its name: `l_sole`, `l_foot@40mm`.
    pub name: String,
}

impl OtherFoot {
    /// The link, and how far the sole is below its origin, m.
    pub fn place(&self) -> (usize, f64) {
        (self.link, self.below_m)
    }
}

impl Feet {
    /// Whether both feet are on the floor, where the caller says it.
    pub(crate) fn said(&self) -> Option<bool> {
        self.both.or(self.other.as_ref().map(|_| true))
    }

    /// The other sole, where a log on the model's support is of both feet: the caller's, else
    /// the sidecar's, else the link that is called as the support is on the other side, else
    /// the only other sole. Where the support is the sole of a link, so is the other, at the same
    /// height unless it is named.
    ///
    /// # Errors
    /// A link that is none, or that no joint moves; no link that must be it; a height that is
    /// none; feet of a robot with more than two that are no soles.
    #[doc(hidden)]
    pub fn of(&self, sidecar: &Sidecar, model: &Model) -> Result<Option<OtherFoot>, Error> {
        let named = self.other.as_deref().or(sidecar.other_foot.as_deref());
        let said = self.said().or(sidecar.both_feet);
        if !said.unwrap_or(named.is_some()) {
            return Ok(None);
        }
        let links = &model.tree.links;
        let name = match named {
            Some(name) => name.to_string(),
            None => mirrored(model).ok_or_else(|| unknown(model))?,
        };
        let support = model.support();
        let wrong = |why: &str| {
            let why = format!(" `{name}` {why}; the robot has {}", soles(model));
            Err(Error::request(message![Setting::OtherFoot, why]))
        };
        let at = |name: &str| links.iter().position(|link| link.name == name);
        let (carrier, below_m) = match sole_parts(&name) {
            Some(Ok(parts)) if at(&name).is_none() => parts,
            Some(Err(meant)) if at(&name).is_none() => {
                return wrong(&format!("is no sole of a link; give `{meant}`"));
            }
            _ => (name.as_str(), 0.0),
        };
        let Some(link) = at(carrier) else {
            let name = carrier;
            let meant = suggestion(name, links.iter().map(|link| link.name.as_str()));
            let has = soles(model);
            let why = format!(" `{name}` is no link of the robot; the robot has {has}{meant}");
            return Err(Error::request(message![Setting::OtherFoot, why]));
        };
        match model.chain.places[link].as_ref().map(|place| place.body) {
            None => wrong("hangs on a joint that no log knows"),
            Some(0) => wrong(&format!("does not move against the support `{support}`")),
            Some(_) => {
                without_soles(model, &name)?;
                Ok(Some(OtherFoot {
                    link,
                    below_m,
                    name,
                }))
            }
        }
    }
}

/// What two feet of a robot with more can be used for, where a log or a plan is of both.
pub(crate) fn of_many(model: &Model, other: &OtherFoot) -> Option<String> {
    let said = on_many_feet(&model.tree.feet)?;
    Some(format!(
        "`{}` and `{}` are taken as flat soles on one floor that carry the robot alone: {said}",
        model.support(),
        other.name
    ))
}

/// Refuse two feet of a robot with more that cannot be taken as flat on one floor: such feet are
/// points unless a name says that there is a sole, or how far below the link it lies.
fn without_soles(model: &Model, other: &str) -> Result<(), Error> {
    let (support, count) = (model.support(), model.tree.feet.len());
    let is_flat = |name: &str| is_sole(name) || name.contains('@');
    if count <= 2 || is_flat(support) && is_flat(other) {
        return Ok(());
    }
    Err(Error::request(format!(
        "`{support}` and `{other}` are 2 of the robot's {count} feet, and their names do not say \
         that they are soles: both feet are compared by height, roll and pitch of flat soles on one \
         floor, and a floor gives a point foot no roll and no pitch. Record the robot on one foot \
         that carries it alone; or, where these feet are flat, say how far below them their soles \
         lie, `{0}@40mm`, or give each a link in its sole behind a fixed joint, called such as \
         `{0}_sole`",
        carrier(model)
    )))
}

fn unknown(model: &Model) -> Error {
    let why = format!(
        "both feet are on the floor, and no link is plainly the other sole to `{}`; name it by \
         `other_foot = \"…\"` in the sidecar or by ",
        model.support()
    );
    let has = format!(" (the robot has {})", soles(model));
    Error::request(message![why, Setting::OtherFoot, has])
}

/// The link that is the support, or whose sole it is.
fn carrier(model: &Model) -> &str {
    match sole_parts(model.support()) {
        Some(Ok((link, _))) if model.tree.by_height => link,
        _ => model.support(),
    }
}

/// The robot's links but the support and what carries it.
fn others(model: &Model) -> Vec<&str> {
    let links = model.tree.links.iter().map(|link| link.name.as_str());
    let own = [model.support(), carrier(model)];
    links.filter(|name| !own.contains(name)).collect()
}

/// These, soles and feet first.
fn soles(model: &Model) -> String {
    let mut names = others(model);
    names.sort_by_key(|name| support_rank(name));
    listed(names, 12)
}

/// The link that is called as the support is on the other side; else the only other one of
/// the words that name a foot. Where the support is the sole of a link, its sole.
fn mirrored(model: &Model) -> Option<String> {
    let (support, mut found) = (carrier(model), others(model));
    if found.iter().any(|name| mirror(support, name)) {
        found.retain(|name| mirror(support, name));
    } else {
        let rank = support_rank(support);
        found.retain(|name| support_rank(name) == rank && rank < support_rank(""));
    }
    let [link] = found[..] else { return None };
    Some(match model.tree.by_height {
        true => like_sole(model.support(), link),
        false => link.to_string(),
    })
}

/// Whether two names differ in one word alone, which names a side.
fn mirror(one: &str, other: &str) -> bool {
    let (one, other) = (one.to_lowercase(), other.to_lowercase());
    let turned = |from: &str, to: &str| {
        one.match_indices(from).any(|(at, _)| {
            let (before, after) = (&one[..at], &one[at + from.len()..]);
            // A letter alone must be a word of its own, or begin the name: `lfoot`.
            let apart = |c: Option<char>| c.is_none_or(|c| !c.is_ascii_alphabetic());
            let alone = from.len() > 1
                || before.is_empty()
                || apart(before.chars().next_back()) && apart(after.chars().next());
            alone && format!("{before}{to}{after}") == other
        })
    };
    let mut sides = SIDES.into_iter();
    sides.any(|(a, b)| turned(a, b) || turned(b, a))
}

/// The soles of a robot, by its URDF.
pub(crate) struct Places {
    robot: Arc<Robot>,
    snapping: Snapping,
    /// The robot on each link that was asked about; none on what is no support.
    on: Mutex<HashMap<String, Option<Arc<Model>>>>,
}

impl Places {
    /// The soles of a robot, as readers of logs take them.
    pub(crate) fn of(robot: &Arc<Robot>, snapping: Snapping) -> Arc<dyn Soles> {
        Arc::new(Places {
            robot: Arc::clone(robot),
            snapping,
            on: Mutex::default(),
        })
    }

    fn model(&self, from: &str) -> Option<Arc<Model>> {
        let mut on = self.on.lock().unwrap_or_else(PoisonError::into_inner);
        let known = on.entry(from.to_string());
        let model = || self.robot.model(from, self.snapping, None).ok();
        known.or_insert_with(|| model().map(Arc::new)).clone()
    }

    /// The robot on the link `from`, the body that holds the link `of` there, and its place on it.
    fn place(&self, from: &str, of: &str) -> Option<(Arc<Model>, usize, poses::Pose)> {
        let model = self.model(from)?;
        let (carrier, below_m) = match sole_parts(of) {
            Some(Ok(parts)) => parts,
            _ => (of, 0.0),
        };
        let mut links = model.tree.links.iter();
        let link = links.position(|link| link.name == carrier)?;
        let (body, place) = poses::of_link(&model, link)?;
        let origin = place.point(&Vector3::new(0.0, 0.0, -below_m));
        Some((model, body, poses::Pose { origin, ..place }))
    }
}

impl fmt::Debug for Places {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Places({})", self.robot.description.name)
    }
}

impl Soles for Places {
    fn seen(&self, q: &[f64], from: &str, of: &str, at: [f64; 2]) -> Option<[f64; 2]> {
        let (model, body, place) = self.place(from, of)?;
        let bodies = poses::bodies(&model.chain.bodies, q);
        let sole = bodies.get(body)?.then(&place);
        let point = sole.point(&Vector3::new(at[0], at[1], 0.0));
        Some([point.x, point.y])
    }

    fn fixed(&self, from: &str, of: &str) -> Option<Frame> {
        let (.., place) = self.place(from, of).filter(|(_, body, _)| *body == 0)?;
        let origin = place.point(&Vector3::zeros());
        let axis = |k: usize| (place.point(&Vector3::ith(k, 1.0)) - origin).into();
        Some(Frame {
            axes: [axis(0), axis(1), axis(2)],
            origin: origin.into(),
        })
    }
}

/// Tell each posture how its reading changes where joints are not where encoders have them, since
/// these place the contact of the other sole.
pub(crate) fn tell_contacts(data: &mut Postures, model: &Model, other: &OtherFoot) {
    let Some((body, place)) = poses::of_link(model, other.link) else {
        return;
    };
    let (layout, dof) = (PostureContext::of(model), model.dof());
    // s T p₂
    let placed = |q: &[f64], [share, x, y]: [f64; 3]| {
        let sole = poses::bodies(&model.chain.bodies, q)[body].then(&place);
        sole.origin * share + sole.rotation * Vector3::new(x, y, 0.0)
    };
    let contexts = data.posture_context.chunks_exact_mut(layout.len());
    let postures = data.q.chunks_exact(dof.max(1)).zip(&data.other_contact);
    for ((q, contact), context) in postures.zip(contexts) {
        let mut moved = q.to_vec();
        for j in 0..dof {
            let mut at = |by: f64| {
                moved[j] = q[j] + by;
                let placed = placed(&moved, *contact);
                moved[j] = q[j];
                placed
            };
            let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
            for axis in 0..2 {
                context[layout.shift_slope(j, axis)] -= slope[axis];
            }
        }
    }
}

/// A warning where the readings are those of one foot.
pub(crate) fn of_one_foot(model: &Model, other: &OtherFoot, data: &Postures) -> Option<String> {
    let remedy = format!(
        "on two feet log the CoP of both together, (F₁ p₁ + F₂ p₂) / (F₁ + F₂), in the frame of \
         `{}`",
        model.support()
    );
    if data.raw_cells {
        return Some(format!(
            "the soles of `{}` and `{}` are both on the floor, and foot cells are those of one: {remedy}",
            model.support(),
            other.name
        ));
    }
    let n = data.len();
    let cad = Evaluator::new(model, Function::Cop).run(&data.q, n);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let axes = [0, 1].map(|axis| {
        let [cad, read] = [&cad, &data.reading].map(|values| {
            let own = values.iter().skip(axis).step_by(2);
            let mean = own.clone().sum::<f64>() / n.max(1) as f64;
            own.map(|x| x - mean).collect::<Vec<f64>>()
        });
        (dot(&cad, &cad), cad, read)
    });
    let [x, y] = axes;
    let (of_cad, x, y) = if x.0 > y.0 { x } else { y };
    if n < FEWEST || of_cad < n as f64 * MOVES_M * MOVES_M {
        return None;
    }
    let slope = dot(&x, &y) / of_cad;
    let left = dot(&y, &y) - slope * slope * of_cad;
    let error = (left.max(0.0) / (n - 2) as f64 / of_cad).sqrt();
    (slope + ERRORS * error < GOES_WITH).then(|| {
        format!(
            "readings move {slope:.2} times as far as the CoM does between the soles of `{}` and \
             `{}`, like those of one foot: {remedy}",
            model.support(),
            other.name
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;
    use crate::tests::says;
    use sesc_model::Snapping;

    /// Feet of these names on a pelvis, each by a hinge.
    fn robot(feet: &[&str]) -> Robot {
        let mut urdf = "<robot name='r'><link name='pelvis'><inertial><mass value='1'/>\
            </inertial></link>"
            .to_string();
        for foot in feet {
            urdf += &format!(
                "<link name='{foot}'/><joint name='to_{foot}' type='continuous'>\
                 <parent link='pelvis'/><child link='{foot}'/><axis xyz='1 0 0'/></joint>"
            );
        }
        Robot::parse(&(urdf + "</robot>"), "r.urdf").unwrap()
    }

    /// What the caller says of feet.
    fn feet(both: Option<bool>, other: Option<&str>) -> Feet {
        let other = other.map(str::to_string);
        Feet { both, other }
    }

    fn other(names: &[&str]) -> Result<Option<String>, String> {
        let model = robot(names).model(names[0], Snapping::default(), None);
        let found = feet(Some(true), None).of(&Sidecar::default(), &model.unwrap());
        let found = found.map_err(|error| error.to_string())?;
        Ok(found.map(|found| found.name))
    }

    #[test]
    fn the_other_sole_is_the_one_that_is_called_alike() {
        for feet in [
            ["r_sole", "l_sole", "l_soles"],
            ["left_foot", "right_foot", "third_toe"],
            ["foot-R", "foot-L", "hand-F"],
            ["LeftSole", "RightSole", "Sole"],
            ["lfoot", "rfoot", "toe"],
            ["leg_left_6_link", "leg_right_6_link", "leg_right_7_link"],
            ["sole_one", "sole_two", "head"],
        ] {
            assert_eq!(other(&feet).unwrap().as_deref(), Some(feet[1]));
        }
        let plainly = "no link is plainly the other sole to `foot_a`";
        let words = [plainly, "(the robot has foot_b, foot_c, pelvis)"];
        says(other(&["foot_a", "foot_b", "foot_c"]).unwrap_err(), &words);
        // Feet of three or more are points unless something says that they are flat.
        let words = ["2 of the robot's 3 feet", "`lfoot@40mm`"];
        says(other(&["lfoot", "rfoot", "foot"]).unwrap_err(), &words);
    }

    /// The sole of the other side is at the height of the support's.
    #[test]
    fn a_support_by_its_height_has_a_mirror() {
        let both = feet(Some(true), None);
        for names in [["r_foot", "l_foot", "toe"], ["lfoot", "rfoot", "foot"]] {
            let support = format!("{}@40mm", names[0]);
            let model = robot(&names).model(&support, Snapping::default(), None);
            let model = model.unwrap();
            let found = both.of(&Sidecar::default(), &model).unwrap().unwrap();
            assert_eq!(found.name, format!("{}@40mm", names[1]));
            assert_eq!(model.tree.links[found.link].name, names[1]);
            assert_eq!(found.below_m, 0.04);
        }
    }

    #[test]
    fn what_the_caller_says_wins_over_the_sidecar() {
        let robot = robot(&["r_sole", "l_sole", "toe"]);
        let model = robot.model("r_sole", Snapping::default(), None).unwrap();
        type Said<'a> = (Option<bool>, Option<&'a str>);
        let of = |(both, other): Said, (both_feet, other_foot): Said| {
            let sidecar = Sidecar {
                both_feet,
                other_foot: other_foot.map(str::to_string),
                ..Sidecar::default()
            };
            let found = feet(both, other).of(&sidecar, &model);
            found.map(|found| found.map(|found| found.name))
        };
        let none = (None, None);
        for (caller, sidecar, sole) in [
            (none, none, None),
            (none, (Some(false), None), None),
            (none, (Some(true), None), Some("l_sole")),
            (none, (None, Some("toe")), Some("toe")),
            ((Some(false), None), (Some(true), Some("toe")), None),
            ((None, Some("toe")), (Some(false), None), Some("toe")),
        ] {
            assert_eq!(of(caller, sidecar).unwrap().as_deref(), sole);
        }
        for (name, why) in [("hand", "is no link"), ("r_sole", "does not move")] {
            says(of((None, Some(name)), none).unwrap_err(), &[why]);
        }
    }
}
