//! The robot of a fleet's page: joints and links that something is said of.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use minijinja::Value;
use sesc_identify::fleet::summary::{ChangeKind, Summary};
use sesc_identify::fleet::{Fleet, Options, Row};
use sesc_identify::health::Kind;
use sesc_identify::robot::Robot;
use sesc_identify::skeleton::Skeleton;
use sesc_model::effects::about::{TargetKind, about};
use sesc_model::effects::{Catalog, Target};

use super::{count, subject};
use crate::report::figures::robot::Marks;
use crate::report::robot::{Card, Correction, Shown};
use crate::report::table::in_words;

/// The robot of a fleet as it is drawn, on the support of most of its rows; none where no row has
/// its URDF and a support. Meshes are looked for in `folder`.
pub fn skeleton(
    fleet: &Fleet,
    robot: &Robot,
    options: &Options,
    folder: Option<&Path>,
) -> Option<Skeleton> {
    let mut supports: BTreeMap<&str, usize> = BTreeMap::new();
    let own = |hash: &str| hash == robot.description.hash;
    for row in fleet.rows.iter().filter(|row| own(&row.urdf_hash)) {
        if !row.support.is_empty() {
            *supports.entry(&row.support).or_default() += 1;
        }
    }
    let (support, _) = supports.into_iter().max_by_key(|(_, rows)| *rows)?;
    let model = robot.model(support, options.snapping(), None).ok()?;
    Some(Skeleton::of(&model, &robot.description, folder))
}

/// Joints and links that robots share a fault of, that changed, or whose encoder is stuck, on the
/// robot; what `robot.html` takes.
pub(super) fn card(fleet: &Fleet, summary: &Summary, skeleton: &Skeleton) -> Value {
    let mut marks = Marks::default();
    let mut said = Vec::new();
    let mut point = |of_link: bool, target: &str, what: String| {
        if mark(&mut marks, skeleton, of_link, target) {
            said.push(match target {
                Target::ALL_JOINTS => format!("every joint ({what})"),
                target => format!("`{}` ({what})", target.replace(',', "`, `")),
            });
        }
    };
    for group in &summary.shared {
        let what = format!(
            "{} in {}",
            in_words(&group.effect),
            count(group.robots.len(), "robot")
        );
        point(acts_on_links(&group.effect), &group.target, what);
    }
    let changes = summary.changes.iter();
    for change in changes.filter(|change| change.kind == ChangeKind::Effect) {
        if let Some((effect, target)) = change.target.split_once(':') {
            let said = in_words(effect);
            let what = format!("{said} of {} from {} on", change.robot, change.day);
            point(acts_on_links(effect), target, what);
        }
    }
    for (joint, robots) in stuck(fleet, summary) {
        let robots = robots.into_iter().collect::<Vec<&str>>().join(", ");
        point(false, joint, format!("encoder stuck in {robots}"));
    }
    let nothing = "No joint and no link is shared, changed or stuck.";
    standing(skeleton, marks, &said, nothing, Vec::new())
}

/// One robot of a fleet: joints and links of its last result, and encoders that are stuck on any
/// day; none where its last result is of another URDF than `skeleton`.
pub(super) fn of_robot(rows: &[&Row], skeleton: &Skeleton) -> Option<Value> {
    let last = rows.iter().rev().find(|row| row.has_result())?;
    if last.urdf_hash != skeleton.hash {
        return None;
    }
    let mut marks = Marks::default();
    let mut said = Vec::new();
    for effect in &last.effects.explanation {
        if mark_effect(&mut marks, skeleton, &effect.effect, &effect.target) {
            said.push(subject(effect));
        }
    }
    let findings = rows.iter().flat_map(|row| &row.health);
    let stuck = findings.filter(|finding| finding.kind == Kind::EncoderStuck);
    let stuck: BTreeSet<&str> = stuck.map(|finding| finding.target.as_str()).collect();
    for joint in stuck {
        if mark(&mut marks, skeleton, false, joint) {
            said.push(format!("`{joint}` (encoder stuck)"));
        }
    }
    let nothing = "No joint and no link is suspected.";
    Some(standing(skeleton, marks, &said, nothing, Vec::new()))
}

/// The robot in one of `postures`, or with all joints at zero where there are none, with what is
/// said of the marks on it.
pub(in crate::report) fn standing(
    skeleton: &Skeleton,
    marks: Marks,
    said: &[String],
    nothing: &str,
    postures: Vec<Shown>,
) -> Value {
    let at = match postures.is_empty() {
        true => "all joints at zero",
        false => "the joints as they were read",
    };
    let caption = match said.is_empty() {
        true => nothing.to_string(),
        false => format!("Orange: {}.", said.join("; ")),
    };
    let card = Card {
        skeleton,
        postures,
        apart: Vec::new(),
        beside: None,
        caption: format!(
            "{caption} Quartered disc: centre of mass by CAD, with its plumb line; \
             {at}."
        ),
        marks,
        correction: Correction::default(),
    };
    card.context()
}

/// Joints whose encoder is stuck in robots that are to be looked at.
fn stuck<'f>(fleet: &'f Fleet, summary: &Summary) -> BTreeMap<&'f str, BTreeSet<&'f str>> {
    let first: BTreeSet<&str> = summary.look_first.iter().map(String::as_str).collect();
    let mut found: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for row in &fleet.rows {
        let own = row.health.iter().filter(|f| f.kind == Kind::EncoderStuck);
        for finding in own.filter(|_| first.contains(row.robot.as_str())) {
            found.entry(&finding.target).or_default().insert(&row.robot);
        }
    }
    found
}

/// Mark what an effect acts on; whether that is a joint or a link of the robot.
pub(in crate::report) fn mark_effect(
    marks: &mut Marks,
    skeleton: &Skeleton,
    effect: &str,
    target: &str,
) -> bool {
    mark(marks, skeleton, acts_on_links(effect), target)
}

/// Whether an effect acts on links, and not on joints.
fn acts_on_links(effect: &str) -> bool {
    let effects = about(&Catalog::standard());
    let named = effects.iter().find(|known| known.name == effect);
    named.is_some_and(|effect| effect.target == TargetKind::Link)
}

/// Mark a joint, or a link where the target is `of_link`; whether the robot has it.
fn mark(marks: &mut Marks, skeleton: &Skeleton, of_link: bool, target: &str) -> bool {
    let before = marks.clone();
    for target in target.split(',') {
        match skeleton.carried_by(target) {
            _ if target == Target::ALL_JOINTS => marks.every_joint = true,
            _ if of_link && skeleton.body_of(target).is_some() => {
                marks.links.push(target.to_string());
            }
            Some(body) => {
                let named = (body, target.to_string());
                // Of two things said of a joint its name is written once.
                if marks.joints.contains(&named) {
                    return true;
                }
                marks.joints.push(named);
            }
            None => {}
        }
    }
    *marks != before
}
