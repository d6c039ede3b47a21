//! A robot description read from URDF. Real files load; a broken file hears
//! everything that is wrong with it at once, by file and line, link or joint.
//!
//! ```text
//! bytes -> size, UTF-8 -> scan -> XML tree -> draft -> checks -> clean URDF -> urdf_rs
//! ```
//!
//! Everything before `urdf_rs` is bounded ([`limits`]) and free of recursion,
//! so that no input can panic or overflow the stack. `urdf_rs` itself only ever
//! sees a minimal description written by `clean`, in document order, with
//! numbers that survive to the last bit.

mod amend;
mod bend;
mod check;
mod clean;
mod draft;
mod edits;
mod extent;
mod joint;
mod joint_limit;
pub mod limits;
mod link;
mod mimic;
mod nearest;
mod report;
mod rotation;
mod scan;
mod source;
mod text;
mod values;

#[cfg(test)]
mod bad_files;
#[cfg(test)]
mod fuzz;
#[cfg(test)]
mod tests;

use std::io::Read as _;
use std::path::Path;

pub use amend::{Weight, amend};
pub use bend::{Load, Shift, bend, load};
pub use extent::{Extent, extents};
pub use report::Complaint;
use report::{Lines, Report};

/// A robot description that passed every check.
///
/// Links and joints stand in document order. Visual and collision elements
/// are dropped; a `quat_xyzw` has become roll, pitch, yaw; axes are as written
/// (not zero, not normalised). A joint without position limits has
/// `limit.lower == -inf` and `limit.upper == inf`.
#[derive(Debug, Clone)]
pub struct Description {
    pub robot: urdf_rs::Robot,
    /// What was ignored or assumed, each `file:line: what`, in line order.
    pub notes: Vec<String>,
    pub name: String,
    /// 16 hex digits: FNV-1a (64 bits) over the bytes of the text, without a
    /// leading byte order mark and without carriage returns, so that a
    /// checkout with other line ends is the same robot.
    pub hash: String,
    /// The file as the caller named it; messages start with it.
    pub file: String,
}

impl Description {
    /// The last part of [`Description::file`], free of directories.
    pub fn file_name(&self) -> &str {
        self.file.rsplit(['/', '\\']).next().unwrap_or(&self.file)
    }
}

#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("{file}: no such file; give the path of a URDF")]
    Missing { file: String },
    #[error("{file}: is a directory; give the path of a URDF file in it")]
    Directory { file: String },
    #[error("{file}: cannot be read; check its permissions")]
    Unreadable {
        file: String,
        source: std::io::Error,
    },
    /// All that is wrong with the text, in line order.
    #[error("{}", report::one_per_line(.0))]
    Faulty(Vec<Complaint>),
    /// The cleaned description did not come back as it was written.
    #[error("{file}: passed every check, but urdf_rs reads it differently; this is a bug")]
    Reader {
        file: String,
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl Error {
    /// The faults of the text; none when the file could not be read at all.
    pub fn complaints(&self) -> &[Complaint] {
        match self {
            Error::Faulty(complaints) => complaints,
            _ => &[],
        }
    }
}

/// Reads and checks a URDF file.
pub fn read(path: &Path) -> Result<Description, Error> {
    let file = path.display().to_string();
    let unreadable = |source: std::io::Error| match source.kind() {
        std::io::ErrorKind::NotFound => Error::Missing { file: file.clone() },
        std::io::ErrorKind::IsADirectory => Error::Directory { file: file.clone() },
        _ => Error::Unreadable {
            file: file.clone(),
            source,
        },
    };
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(Error::Directory { file });
    }
    if metadata.len() > limits::FILE_BYTES {
        return Err(too_large(&file));
    }
    // A pipe has no length to check beforehand, so the reading is bounded too.
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|opened| {
            opened
                .take(limits::FILE_BYTES + 1)
                .read_to_end(&mut bytes)
                .map(drop)
        })
        .map_err(unreadable)?;
    if bytes.len() as u64 > limits::FILE_BYTES {
        return Err(too_large(&file));
    }
    let text = text::decode(&bytes).map_err(|fault| fault.into_error(&file, &bytes))?;
    parse(text, &file)
}

/// Checks a URDF given as text; `file` is its name in messages.
pub fn parse(text: &str, file: &str) -> Result<Description, Error> {
    if text.len() as u64 > limits::FILE_BYTES {
        return Err(too_large(file));
    }
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let scanned = scan::scan(text).map_err(|fault| fault.into_error(file, text.as_bytes()))?;
    let options = roxmltree::ParsingOptions {
        nodes_limit: limits::XML_NODES,
        ..Default::default()
    };
    let document = roxmltree::Document::parse_with_options(&scanned, options)
        .map_err(|error| not_xml(file, &error))?;

    let mut report = Report::new(file);
    let lines = Lines::of(scanned.as_bytes());
    let draft = draft::draft(&document, &lines, &mut report);
    check::check(&draft, &mut report);
    mimic::check(&draft, &mut report);
    let notes = report.finish()?;
    Ok(Description {
        robot: clean::read(&draft).map_err(|source| Error::Reader {
            file: file.to_owned(),
            source,
        })?,
        notes,
        name: draft.name,
        hash: hash(text),
        file: file.to_owned(),
    })
}

fn too_large(file: &str) -> Error {
    let mebibytes = limits::FILE_BYTES >> 20;
    Error::Faulty(vec![Complaint {
        file: file.to_owned(),
        line: None,
        message: format!(
            "larger than {mebibytes} MiB; a URDF names its meshes, it does not hold them"
        ),
    }])
}

fn not_xml(file: &str, error: &roxmltree::Error) -> Error {
    let position = error.pos();
    let text = error.to_string();
    let text = text.replace(&format!(" at {position}"), "");
    Error::Faulty(vec![Complaint {
        file: file.to_owned(),
        line: Some(position.row),
        message: format!(
            "not well-formed XML (column {}): {text}; repair the tag",
            position.col
        ),
    }])
}

fn hash(text: &str) -> String {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let hash = text
        .bytes()
        .filter(|&byte| byte != b'\r')
        .fold(OFFSET, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(PRIME)
        });
    format!("{hash:016x}")
}
