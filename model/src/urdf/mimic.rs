//! Mimic joints: each must end, perhaps over other mimics, at a joint that moves.

use std::collections::HashMap;

use super::check::subject;
use super::description::JointType;
use super::draft::Draft;
use super::joint::JointDraft;
use super::limits;
use super::nearest::Suggestions;
use super::report::{Report, chained, shown};

pub(super) fn check(draft: &Draft, report: &mut Report) {
    if report.is_unexpanded() {
        return;
    }
    let joints = &draft.joints;
    let mut index: HashMap<&str, usize> = HashMap::new();
    for (place, joint) in joints.iter().enumerate() {
        index.entry(&joint.found.name).or_insert(place);
    }
    let master = |joint: &JointDraft| {
        let mimic = joint.found.mimic.as_ref()?;
        index.get(mimic.joint.as_str()).copied()
    };
    let masters: Vec<Option<usize>> = joints.iter().map(master).collect();

    let mut suggestions = Suggestions::default();
    for (joint, master) in joints.iter().zip(&masters) {
        let Some(mimic) = &joint.found.mimic else {
            continue;
        };
        let (own, followed) = (subject(joint), shown(&mimic.joint));
        let found = match master.map(|master| joints[master].found.joint_type) {
            None => {
                let owner = joint.found.name.as_str();
                let others = joints.iter().map(|joint| joint.found.name.as_str());
                let others = others.filter(|name| *name != owner);
                let otherwise = "; name a joint or remove <mimic>";
                let remedy = suggestions.remedy(&mimic.joint, owner, others, otherwise);
                format!("which does not exist{remedy}")
            }
            // Reduced robots fix a master and leave its followers: they stand still.
            Some(JointType::Fixed) => {
                let means = "which is fixed; it stands still at its offset";
                report.note(joint.mimics, format!("{own}: mimics {followed}, {means}"));
                continue;
            }
            Some(kind) if !kind.is_single() => format!(
                "which is {} and has several coordinates; name another joint",
                kind.name()
            ),
            Some(_) => continue,
        };
        report.complain(joint.mimics, format!("{own}: mimics {followed}, {found}"));
    }
    let cycles = cycles(&masters);
    if cycles.is_empty() {
        far(draft, &masters, report);
    }
    for cycle in cycles {
        let joint = &joints[cycle[0]];
        let round = cycle.iter().chain([&cycle[0]]);
        let names = round.map(|&joint| shown(&joints[joint].found.name));
        report.complain(
            joint.mimics,
            format!(
                "{}: mimics itself: {}; let one of them move on its own",
                subject(joint),
                chained(names.collect())
            ),
        );
    }
}

/// Complain of joints that follow by more than any gear does; nothing follows itself.
fn far(draft: &Draft, masters: &[Option<usize>], report: &mut Report) {
    let joints = &draft.joints;
    // Factor and offset to the joint at the end, once they are known.
    let mut ties: Vec<Option<(f64, f64)>> = vec![None; joints.len()];
    for start in 0..joints.len() {
        let mut path = Vec::new();
        let mut at = start;
        while ties[at].is_none() {
            path.push(at);
            match masters[at] {
                Some(master) => at = master,
                None => break,
            }
        }
        for joint in path.into_iter().rev() {
            let of = |master: usize| ties[master].unwrap_or((1.0, 0.0));
            let (factor, offset) = masters[joint].map_or((1.0, 0.0), of);
            let Some(mimic) = &joints[joint].found.mimic else {
                ties[joint] = Some((1.0, 0.0));
                continue;
            };
            let factor = mimic.multiplier * factor;
            let offset = mimic.multiplier * offset + mimic.offset;
            let most = match joints[joint].found.joint_type {
                JointType::Prismatic => limits::MIMIC_M,
                _ => limits::MIMIC,
            };
            let is_far = |x: f64| x.is_nan() || x.abs() > most;
            if is_far(factor) || is_far(offset) {
                let message = format!(
                    "{}: follows {} by a factor of {factor:e} and an offset of {offset:e}; no \
                     gear does, give at most {:e}",
                    subject(&joints[joint]),
                    shown(&mimic.joint),
                    most
                );
                report.complain(joints[joint].mimics, message);
                // What follows in turn is not to blame.
                ties[joint] = Some((1.0, 0.0));
                continue;
            }
            ties[joint] = Some((factor, offset));
        }
    }
}

/// The cycles of "mimics", each from its first joint in document order.
fn cycles(masters: &[Option<usize>]) -> Vec<Vec<usize>> {
    // The walk in which a joint was first met.
    let mut met: Vec<Option<usize>> = vec![None; masters.len()];
    let mut cycles = Vec::new();
    for start in 0..masters.len() {
        let mut path = Vec::new();
        let mut at = start;
        let again = loop {
            if met[at].is_some() {
                break (met[at] == Some(start)).then_some(at);
            }
            met[at] = Some(start);
            path.push(at);
            match masters[at] {
                Some(master) => at = master,
                None => break None,
            }
        };
        if let Some(again) = again {
            let from = path.iter().position(|&joint| joint == again).unwrap_or(0);
            let mut cycle = path.split_off(from);
            let first = (0..cycle.len())
                .min_by_key(|&place| cycle[place])
                .unwrap_or(0);
            cycle.rotate_left(first);
            cycles.push(cycle);
        }
    }
    cycles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_are_found_once() {
        let masters = [Some(1), None, Some(4), Some(2), Some(3), Some(4), Some(6)];
        assert_eq!(cycles(&masters), vec![vec![2, 4, 3], vec![6]]);
    }
}
