//! The robot of a fleet's page: joints and links that something is said of.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use minijinja::Value;
use sesc_identify::fleet::summary::{ChangeKind, Summary};
use sesc_identify::fleet::{Fleet, Options};
use sesc_identify::health::Kind;
use sesc_identify::robot::Robot;
use sesc_identify::skeleton::Skeleton;
use sesc_model::effects::about::{TargetKind, about};
use sesc_model::effects::{Catalog, Target};

use super::count;
use crate::report::figures::robot::Marks;
use crate::report::robot::{Card, Correction};

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
    let effects = about(&Catalog::standard());
    let acts_on_links = |name: &str| {
        let effect = effects.iter().find(|effect| effect.name == name);
        effect.is_some_and(|effect| effect.target == TargetKind::Link)
    };
    let mut point = |of_link: bool, target: &str, what: String| {
        if mark(&mut marks, skeleton, of_link, target) {
            said.push(match target {
                Target::ALL_JOINTS => format!("every joint ({what})"),
                target => format!("`{}` ({what})", target.replace(',', "`, `")),
            });
        }
    };
    for group in &summary.shared {
        let robots = count(group.robots.len(), "robot");
        point(
            acts_on_links(&group.effect),
            &group.target,
            format!("{} in {robots}", group.effect),
        );
    }
    let changes = summary
        .changes
        .iter()
        .filter(|c| c.kind == ChangeKind::Effect);
    for change in changes {
        if let Some((effect, target)) = change.target.split_once(':') {
            let what = format!("{effect} of {} from {} on", change.robot, change.day);
            point(acts_on_links(effect), target, what);
        }
    }
    for (joint, robots) in stuck(fleet, summary) {
        let robots = robots.into_iter().collect::<Vec<&str>>().join(", ");
        point(false, joint, format!("encoder stuck in {robots}"));
    }
    let caption = match said.is_empty() {
        true => "No joint and no link is shared, changed or stuck.".to_string(),
        false => format!("Orange: {}.", said.join("; ")),
    };
    let card = Card {
        skeleton,
        postures: Vec::new(),
        beside: None,
        caption: format!(
            "{caption} Quartered disc: centre of mass by CAD, with its plumb line; all joints at \
             zero."
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
