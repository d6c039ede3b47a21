//! Bytes to text, and faults of the text as a whole.

use super::report::{Complaint, Lines, shown};

/// The one fault that ends the pass, at a byte of the text.
#[derive(Debug)]
pub(super) struct Fault {
    at: Option<usize>,
    message: String,
}

impl Fault {
    pub(super) fn new(at: usize, message: impl Into<String>) -> Self {
        Fault {
            at: Some(at),
            message: message.into(),
        }
    }

    pub(super) fn of_file(message: &str) -> Self {
        Fault {
            at: None,
            message: message.to_owned(),
        }
    }

    pub(super) fn line(&self, bytes: &[u8]) -> Option<u32> {
        self.at.map(|at| Lines::of(bytes).line(at))
    }

    #[cfg(test)]
    pub(super) fn message(&self) -> &str {
        &self.message
    }

    pub(super) fn into_complaint(self, file: &str, bytes: &[u8]) -> Complaint {
        Complaint {
            file: file.to_owned(),
            line: self.line(bytes),
            message: self.message,
        }
    }
}

/// Text of the bytes, which must be UTF-8.
pub(super) fn decode(bytes: &[u8]) -> Result<&str, Fault> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(Fault::of_file("UTF-16 text; save it as UTF-8"));
    }
    // Some C programs write the end of their string, too.
    let end = bytes.iter().rposition(|&byte| byte != 0);
    let bytes = &bytes[..end.map_or(0, |end| end + 1)];
    if bytes.contains(&0) {
        return Err(Fault::of_file(
            "a binary file; give the URDF, which is XML text",
        ));
    }
    std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        Fault::new(
            at,
            format!(
                "byte 0x{:02x} is not UTF-8; save the file as UTF-8",
                bytes[at]
            ),
        )
    })
}

/// A tag name for a message, without the backticks.
pub(super) fn plain(name: &str) -> String {
    shown(name).replace('`', "")
}
