//! A robot description read from URDF. Real files load; all errors of a broken
//! file are reported at once, by file and line, link or joint.
//!
//! ```text
//! bytes -> size, UTF-8 -> scan -> XML tree -> draft -> checks -> Description
//! ```
//!
//! The scan bounds what the XML reader sees ([`limits`]) and takes out what it stumbles
//! over, so that no input can panic or overflow the stack. The draft knows where
//! everything stands and finds all faults at once.

mod check;
mod collision;
mod description;
mod doubts;
mod draft;
mod edit_joints;
mod edit_masses;
mod edits;
mod error;
mod extent;
mod joint;
#[doc(hidden)]
pub mod limits;
mod link;
mod mimic;
pub(crate) mod nearest;
mod origin;
mod report;
mod rotation;
mod scan;
mod source;
mod text;
mod values;

#[cfg(test)]
mod tests;

use std::io::Read as _;
use std::path::Path;

use crate::hash;
use crate::stamp::Stamp;
#[doc(hidden)]
pub use collision::{Collision, Shape, collisions};
pub use description::Description;
#[doc(hidden)]
pub use description::{Extent, Inertial, Joint, JointType, Limit, Link, Mimic, Origin};
#[doc(hidden)]
pub use edit_joints::{Load, Shift, add_loads, edit_joints};
#[doc(hidden)]
pub use edit_masses::{Weight, edit_masses};
pub use error::{Error, ErrorKind};
use error::{directory, too_large, unreadable};
#[doc(hidden)]
pub use extent::extents;
pub use nearest::suggestion;
pub use report::Complaint;
use report::{Lines, Report};
use source::Source;

/// Name of the file that means standard input, and what messages call it.
const STANDARD_INPUT: (&str, &str) = ("-", "standard input");

/// Read and check a URDF file; `-` is standard input.
///
/// The file is read once, from its beginning to its end, so that it may be a pipe.
///
/// # Errors
/// When the file cannot be read, or everything that is wrong with its text.
pub fn read(path: &Path) -> Result<Description, Error> {
    if path.as_os_str() == STANDARD_INPUT.0 {
        return read_from(std::io::stdin(), STANDARD_INPUT.1);
    }
    let file = path.display().to_string();
    if path.is_dir() {
        return Err(directory(file));
    }
    let unreadable = |source| unreadable(&file, source);
    let opened = std::fs::File::open(path).map_err(unreadable)?;
    let stamp = Stamp::of(&opened);
    let read = bytes_of(&opened, &file);
    // What is wrong with a file that is being written is not its fault.
    stamp
        .map_or(Ok(()), |stamp| stamp.check(&opened))
        .map_err(unreadable)?;
    decoded(&read?, &file)
}

fn read_from(source: impl std::io::Read, file: &str) -> Result<Description, Error> {
    decoded(&bytes_of(source, file)?, file)
}

fn bytes_of(source: impl std::io::Read, file: &str) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    source
        .take(limits::FILE_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|source| unreadable(file, source))?;
    if bytes.len() as u64 > limits::FILE_BYTES {
        return Err(too_large(file));
    }
    Ok(bytes)
}

fn decoded(bytes: &[u8], file: &str) -> Result<Description, Error> {
    let text = text::decode(bytes).map_err(|fault| fault.into_complaint(file, bytes))?;
    parse(text, file)
}

/// Read and check a URDF given as text; `file` is its name in messages.
///
/// # Errors
/// Everything that is wrong with the text.
pub fn parse(text: &str, file: &str) -> Result<Description, Error> {
    if text.len() as u64 > limits::FILE_BYTES {
        return Err(too_large(file));
    }
    let source = Source::new(text, file)?;
    let document = source.document()?;
    let mut report = Report::new(file);
    let lines = Lines::of(source.text.as_bytes());
    let draft = draft::draft(source.text, &document, &lines, &mut report);
    check::check(&draft, &mut report);
    mimic::check(&draft, &mut report);
    let notes = report.finish()?;
    let mut robot = Description {
        name: draft.name,
        links: draft.links.into_iter().map(|link| link.found).collect(),
        joints: draft.joints.into_iter().map(|joint| joint.found).collect(),
        notes,
        hash: hash(source.text),
        file: file.to_owned(),
        shapes: Vec::new(),
        text: text.to_owned(),
    };
    robot.shapes = extents(&robot)?;
    let doubts = robot.doubts();
    robot.notes.extend(doubts);
    Ok(robot)
}

fn hash(text: &str) -> String {
    let bytes = text.bytes().filter(|&byte| byte != b'\r');
    let hash = bytes.fold(hash::START, |hash, byte| hash::fnv1a(hash, &[byte]));
    format!("{hash:016x}")
}
