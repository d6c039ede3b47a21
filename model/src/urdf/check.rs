//! Links and joints as a whole: unique names, known ends, one tree, a mass.
//!
//! A consequence of a fault is not complained about again: where a name or an
//! end is missing, the robot is not also said to fall apart.

use std::collections::HashMap;

use super::draft::Draft;
use super::joint::JointDraft;
use super::nearest::Suggestions;
use super::report::{Report, chained, listed, shown};

pub(super) fn check(draft: &Draft, report: &mut Report) {
    // Names with `${...}` in them cannot be looked up in the tree.
    if draft.links.is_empty() || report.is_unexpanded() {
        return;
    }
    let links = draft
        .links
        .iter()
        .map(|link| (link.found.name.as_str(), link.line));
    let links = Names::of(links, "link", report);
    let joints = draft.joints.iter();
    let joints = joints.map(|joint| (joint.found.name.as_str(), joint.line));
    Names::of(joints, "joint", report);
    // A mass that was complained about is no number.
    let total_kg: f64 = draft
        .links
        .iter()
        .map(|link| link.found.inertial.mass_kg)
        .sum();
    if total_kg == 0.0 {
        report.complain(
            draft.line,
            "no link has a mass, so there is no centre of mass; add <inertial><mass value=\"...\"/>",
        );
    }
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
    let mut suggestions = Suggestions::default();
    let mut find = |joint: &JointDraft, end: &str, line: u32, what: &str| {
        let found = links.get(end).copied();
        // An end that is missing was complained about.
        if found.is_none() && !end.is_empty() {
            let names = draft.links.iter().map(|link| link.found.name.as_str());
            let otherwise = "; add the link or correct the name";
            let remedy = suggestions.remedy(end, &joint.found.name, names, otherwise);
            let (joint, end) = (subject(joint), shown(end));
            report.complain(
                line,
                format!("{joint}: {what} link {end} does not exist{remedy}"),
            );
        }
        found
    };
    (draft.joints.iter())
        .map(|joint| {
            let parent = find(joint, &joint.found.parent, joint.ends[0], "parent");
            let child = find(joint, &joint.found.child, joint.ends[1], "child");
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
    fn of(items: impl Iterator<Item = (&'a str, u32)>, kind: &str, report: &mut Report) -> Self {
        let mut index = HashMap::new();
        let mut lines: Vec<u32> = Vec::new();
        let mut whole = true;
        for (place, (name, line)) in items.enumerate() {
            lines.push(line);
            if name.is_empty() {
                whole = false;
            } else if let Some(&first) = index.get(name) {
                whole = false;
                let (name, first) = (shown(name), lines[first]);
                report.complain(
                    line,
                    format!(
                        "{kind} {name} is defined twice, in lines {first} and {line}; rename one"
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
    match joint.found.name.as_str() {
        "" => "joint".to_owned(),
        name => format!("joint {}", shown(name)),
    }
}

/// Every link but one has one parent, and none descends from itself.
fn check_tree(draft: &Draft, edges: &[Option<Edge>], whole: bool, report: &mut Report) {
    let link_name = |link: usize| shown(&draft.links[link].found.name);
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
        let open = joints.iter().copied().filter(|joint| !closes(joint));
        let parents: Vec<usize> = open.collect();
        if let [_, second, ..] = parents[..] {
            let shown_joint = |&joint: &usize| {
                let joint = &draft.joints[joint];
                format!("{} (line {})", shown(&joint.found.name), joint.line)
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
