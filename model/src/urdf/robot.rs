//! The links and joints of a description that passed every check.
//!
use super::description::{Joint, JointType, Link, Mimic};
use super::draft::Draft;
use super::joint::JointDraft;
use super::link::LinkDraft;
#[cfg(not(feature = "urdf-rs"))]
use super::origin::Version;
#[cfg(feature = "urdf-rs")]
use super::reader::read;

#[cfg(not(feature = "urdf-rs"))]
fn read(_: &str, _: Version, _: &mut [Link], _: &mut [Joint]) {}

/// Links and joints of `draft`, with the numbers that `urdf_rs` reads in `text`.
pub(super) fn robot(draft: Draft, text: &str) -> (Vec<Link>, Vec<Joint>) {
    let mut links: Vec<Link> = draft.links.into_iter().map(Link::from).collect();
    let mut joints: Vec<Joint> = draft.joints.into_iter().map(Joint::from).collect();
    read(text, draft.version, &mut links, &mut joints);
    (links, joints)
}

// The checks found everything that is `None` in a draft and refused the file.

impl From<LinkDraft> for Link {
    fn from(draft: LinkDraft) -> Link {
        Link {
            name: draft.name.unwrap_or_default(),
            inertial: draft.inertial.unwrap_or_default(),
        }
    }
}

impl From<JointDraft> for Joint {
    fn from(draft: JointDraft) -> Joint {
        Joint {
            name: draft.name.unwrap_or_default(),
            joint_type: draft.kind.unwrap_or(JointType::Fixed),
            origin: draft.origin,
            parent: draft.parent.map_or_else(String::new, |end| end.value),
            child: draft.child.map_or_else(String::new, |end| end.value),
            axis: draft.axis,
            limit: draft.limit,
            mimic: draft.mimic.map(|mimic| Mimic {
                joint: mimic.joint.value,
                multiplier: mimic.multiplier,
                offset: mimic.offset,
            }),
        }
    }
}
