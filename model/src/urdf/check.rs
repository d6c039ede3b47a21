//! Links and joints as a whole: unique names, known ends, one tree, a mass.
//!
//! A consequence of a fault is not complained about again: where a name or an
//! end is missing, the robot is not also said to fall apart.

use std::collections::HashMap;

use super::draft::Draft;
use super::joint::JointDraft;
use super::nearest::{SUGGESTIONS, suggest};
use super::report::{Report, chained, listed, shown};
use super::values::At;

pub(super) fn check(draft: &Draft, report: &mut Report) {
    // Names with `${...}` in them cannot be looked up in the tree.
    if draft.links.is_empty() || report.is_unexpanded() {
        return;
    }
    let links = Names::of(
        draft
            .links
            .iter()
            .map(|link| (link.name.as_deref(), link.line)),
        "link",
        report,
    );
    let joints = draft
        .joints
        .iter()
        .map(|joint| (joint.name.as_deref(), joint.line));
    Names::of(joints, "joint", report);
    check_mass(draft, report);

    let edges = find_edges(draft, &links.index, report);
    let whole = links.whole && edges.iter().all(Option::is_some);
    check_tree(draft, &edges, whole, report);
}

/// The links each joint joins; none where an end does not exist.
fn find_edges(
    draft: &Draft,
    links: &HashMap<&str, usize>,
    report: &mut Report,
) -> Vec<Option<Edge>> {
    let mut wrong = 0;
    let mut find = |joint: &JointDraft, end: &Option<At<String>>, what: &str| {
        let end = end.as_ref()?;
        let found = links.get(end.value.as_str()).copied();
        if found.is_none() {
            wrong += 1;
            let owner = joint.name.as_deref().unwrap_or_default();
            let names = draft.links.iter().filter_map(|link| link.name.as_deref());
            let remedy = (wrong <= SUGGESTIONS)
                .then(|| suggest(&end.value, owner, names))
                .flatten();
            report.complain(
                end.line,
                format!(
                    "{}: {what} link {} does not exist{}",
                    subject(joint),
                    shown(&end.value),
                    remedy
                        .as_deref()
                        .unwrap_or("; add the link or correct the name")
                ),
            );
        }
        found
    };
    (draft.joints.iter())
        .map(|joint| {
            let parent = find(joint, &joint.parent, "parent");
            let child = find(joint, &joint.child, "child");
            Some(Edge {
                parent: parent?,
                child: child?,
            })
        })
        .collect()
}

struct Edge {
    parent: usize,
    child: usize,
}

/// Names and the first place each stands at.
struct Names<'a> {
    index: HashMap<&'a str, usize>,
    /// Nothing is nameless or named twice.
    whole: bool,
}

impl<'a> Names<'a> {
    fn of(
        items: impl Iterator<Item = (Option<&'a str>, u32)>,
        kind: &str,
        report: &mut Report,
    ) -> Self {
        let mut index = HashMap::new();
        let mut lines = Vec::new();
        let mut whole = true;
        for (place, (name, line)) in items.enumerate() {
            lines.push(line);
            let Some(name) = name else {
                whole = false;
                continue;
            };
            if let Some(&first) = index.get(name) {
                whole = false;
                let first: u32 = lines[first];
                report.complain(
                    line,
                    format!(
                        "{kind} {} is defined twice, in lines {first} and {line}; rename one",
                        shown(name)
                    ),
                );
            } else {
                index.insert(name, place);
            }
        }
        Names { index, whole }
    }
}

pub(super) fn subject(joint: &JointDraft) -> String {
    match joint.name.as_deref() {
        Some(name) => format!("joint {}", shown(name)),
        None => "joint".to_owned(),
    }
}

fn check_mass(draft: &Draft, report: &mut Report) {
    let mut total_kg = 0.0;
    for link in &draft.links {
        match link.inertial {
            Some(inertial) => total_kg += inertial.mass_kg,
            // Complained about.
            None => return,
        }
    }
    if total_kg == 0.0 {
        report.complain(
            draft.line,
            "no link has a mass, so there is no centre of mass; add <inertial><mass value=\"...\"/>",
        );
    }
}

/// Every link but one has one parent, and none descends from itself.
fn check_tree(draft: &Draft, edges: &[Option<Edge>], whole: bool, report: &mut Report) {
    let link_name = |link: usize| shown(draft.links[link].name.as_deref().unwrap_or_default());
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); draft.links.len()];
    let mut above: Vec<Vec<usize>> = vec![Vec::new(); draft.links.len()];
    for (joint, edge) in edges.iter().enumerate() {
        if let Some(edge) = edge {
            below[edge.parent].push(joint);
            above[edge.child].push(joint);
        }
    }
    let roots: Vec<usize> = (0..draft.links.len())
        .filter(|&link| above[link].is_empty())
        .collect();

    let closing = closing_joints(&roots, edges, &below);
    for (joint, cycle) in &closing {
        let names = cycle.iter().map(|&link| link_name(link)).collect();
        report.complain(
            draft.joints[*joint].line,
            format!(
                "{} closes a loop: {}; a URDF is a tree, remove one joint of it",
                subject(&draft.joints[*joint]),
                chained(names)
            ),
        );
    }
    for (link, joints) in above.iter().enumerate() {
        let closes = |joint: &usize| closing.iter().any(|(other, _)| other == joint);
        let parents: Vec<usize> = match closing.is_empty() || joints.len() < 2 {
            true => joints.clone(),
            false => joints
                .iter()
                .copied()
                .filter(|joint| !closes(joint))
                .collect(),
        };
        if let [_, second, ..] = parents[..] {
            let shown_joint = |&joint: &usize| {
                let joint = &draft.joints[joint];
                let name = shown(joint.name.as_deref().unwrap_or_default());
                format!("{name} (line {})", joint.line)
            };
            report.complain(
                draft.joints[second].line,
                format!(
                    "link {} is the child of several joints: {}; a URDF is a tree, keep one",
                    link_name(link),
                    listed(&parents, shown_joint)
                ),
            );
        }
    }
    if whole && let [_, second, ..] = roots[..] {
        let shown_link =
            |&link: &usize| format!("{} (line {})", link_name(link), draft.links[link].line);
        report.complain(
            draft.links[second].line,
            format!(
                "the robot falls into {} parts, with roots {}; join them by joints",
                roots.len(),
                listed(&roots, shown_link)
            ),
        );
    }
}

/// The joints that lead back to a link above them, each with the loop it
/// closes. Depth first without recursion, so that a chain may have any length.
fn closing_joints(
    roots: &[usize],
    edges: &[Option<Edge>],
    below: &[Vec<usize>],
) -> Vec<(usize, Vec<usize>)> {
    /// Loops beyond this many are not told apart.
    const MOST: usize = 100;
    #[derive(Clone, Copy, PartialEq)]
    enum State {
        New,
        OnPath,
        Done,
    }
    let mut state = vec![State::New; below.len()];
    let mut closing = Vec::new();
    for start in roots.iter().copied().chain(0..below.len()) {
        if state[start] != State::New {
            continue;
        }
        state[start] = State::OnPath;
        let mut path = vec![(start, 0)];
        while let Some((link, next)) = path.last_mut() {
            let Some(&joint) = below[*link].get(*next) else {
                state[*link] = State::Done;
                path.pop();
                continue;
            };
            *next += 1;
            let Some(child) = edges[joint].as_ref().map(|edge| edge.child) else {
                continue;
            };
            match state[child] {
                State::New => {
                    state[child] = State::OnPath;
                    path.push((child, 0));
                }
                State::OnPath if closing.len() < MOST => {
                    let from = path.iter().position(|(link, _)| *link == child);
                    let on_path = path[from.unwrap_or(0)..].iter().map(|(link, _)| *link);
                    closing.push((joint, on_path.chain([child]).collect()));
                }
                _ => {}
            }
        }
    }
    closing
}
