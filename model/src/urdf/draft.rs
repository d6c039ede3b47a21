//! The description as found in the XML tree, before it is checked as a whole.
//!
//! Only direct children of `<robot>` are the robot's: `<link>` and `<joint>`
//! inside of ros2_control, gazebo or transmission blocks are not.

use roxmltree::Document;

use super::joint::{JointDraft, read_joint};
use super::limits;
use super::link::{LinkDraft, read_link};
use super::origin::Version;
use super::report::{EXPAND, Lines, Report, shown};
use super::source::tag;
use super::text::plain;
use super::values::Reader;

pub(super) struct Draft {
    /// Line of the root element, for complaints about the whole.
    pub(super) line: u32,
    pub(super) name: String,
    pub(super) links: Vec<LinkDraft>,
    pub(super) joints: Vec<JointDraft>,
}

/// What `text` holds; `document` is of the scanned text.
pub(super) fn draft(
    text: &str,
    document: &Document<'_>,
    lines: &Lines,
    report: &mut Report,
) -> Draft {
    let root = document.root_element();
    let mut reader = Reader {
        text,
        lines,
        report,
        subject: "robot".to_owned(),
    };
    let line = reader.line(root);
    let mut draft = Draft {
        line,
        name: String::new(),
        links: Vec::new(),
        joints: Vec::new(),
    };
    if tag(root) != "robot" {
        let found = shown(reader.tag(root));
        reader.report.complain(
            line,
            match tag(root) {
                "mujoco" => "this is MJCF, MuJoCo's format; give the URDF that it was made from, \
                             or convert it to one (the Python package \
                             mjcf-urdf-simple-converter does: \
                             `convert(\"model.xml\", \"model.urdf\")`)"
                    .to_string(),
                "sdf" => "this is SDF, Gazebo's format; give the URDF that it was made from, or \
                          convert it to one (sdformat_urdf does)"
                    .to_string(),
                _ => format!(
                    "the root element is {found}, not `robot`; a URDF starts with \
                     <robot name=\"...\">"
                ),
            },
        );
        return draft;
    }
    let name = reader.attribute(root, "name");
    if let Some(text) = &name {
        draft.name = reader.name(text, "name");
    }
    let version = read_version(&mut reader, root);

    let (mut first_macro, mut first_call) = (None, None);
    for child in root.children().filter(roxmltree::Node::is_element) {
        match tag(child) {
            "link" if draft.links.len() < limits::LINKS => {
                draft.links.push(read_link(&mut reader, child, version));
            }
            "joint" if draft.joints.len() < limits::LINKS => {
                draft.joints.push(read_joint(&mut reader, child, version));
            }
            kind @ ("link" | "joint") => {
                let message = format!("more than {} {kind}s; this is no robot", limits::LINKS);
                reader.report.complain(reader.line(child), message);
                break;
            }
            _ => {
                if let Some(word) = reader.tag(child).strip_prefix("xacro:") {
                    let adds = !matches!(word, "property" | "arg" | "macro");
                    first_macro.get_or_insert(child);
                    first_call = first_call.or(adds.then_some(child));
                }
            }
        }
    }
    if let Some(node) = first_call.or(first_macro) {
        let line = reader.line(node);
        if draft.links.is_empty() || first_call.is_some() {
            let tag = plain(reader.tag(node));
            // A call of a macro, or what it includes, may hold links, joints and masses.
            let what = match draft.links.is_empty() {
                true => format!("no link, but <{tag}>"),
                false => format!("<{tag}> stands for parts of the robot"),
            };
            let message = format!("an unexpanded xacro: {what}; {EXPAND}");
            reader.report.complain(line, message);
            return draft;
        }
        let found = shown(reader.tag(node));
        let message = format!("{found}: a leftover of xacro, ignored with all such");
        reader.report.note(line, message);
    }
    if draft.links.is_empty() {
        let message = "the robot has no link; put <link name=\"...\"> directly under <robot>";
        reader.report.complain(line, message);
    }
    if name.is_none() {
        let message = "the robot has no name; add <robot name=\"...\">";
        reader.report.complain(line, message);
    }
    draft
}

fn read_version(reader: &mut Reader<'_>, root: roxmltree::Node<'_, '_>) -> Version {
    let Some(text) = reader.attribute(root, "version") else {
        return Version::OLDEST;
    };
    Version::parse(text.value).unwrap_or_else(|| {
        let found = shown(text.value);
        let message = format!("version {found} is no URDF version; read as 1.0");
        reader.report.note(text.line, message);
        Version::OLDEST
    })
}
