//! What can go wrong from logs to findings, each with its remedy.

use std::{fmt, io};

use sesc_model::files::TomlFault;

use crate::words::{Message, Setting};

/// Bad input, or a call that makes no sense.
///
/// [`kind`](Error::kind) says what to tell apart, [`file`](Error::file) and
/// [`line`](Error::line) where the fault is. `Display` gives the whole sentence,
/// with settings by the names of their fields; [`worded`](Error::worded) names them
/// otherwise.
#[derive(Debug)]
pub struct Error(Box<Cause>);

/// What kind of thing went wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The URDF, its support link or the model file.
    Model,
    /// A file cannot be read.
    Read,
    /// A file cannot be written.
    Write,
    /// A fault in a posture log, its sidecar, or another file of data.
    Log,
    /// A fault in a file of tolerances.
    Prior,
    /// What is asked for makes no sense, or cannot be had.
    Request,
    /// This build leaves the format out.
    Unsupported,
    /// The caller stopped the call.
    Interrupted,
    /// A result cannot be written down.
    Serialise,
}

impl ErrorKind {
    /// One word, stable: for programs that read it.
    pub fn name(self) -> &'static str {
        match self {
            ErrorKind::Model => "model",
            ErrorKind::Read => "read",
            ErrorKind::Write => "write",
            ErrorKind::Log => "log",
            ErrorKind::Prior => "prior",
            ErrorKind::Request => "request",
            ErrorKind::Unsupported => "unsupported",
            ErrorKind::Interrupted => "interrupted",
            ErrorKind::Serialise => "serialise",
        }
    }
}

type Source = Box<dyn std::error::Error + Send + Sync>;

#[derive(Debug)]
struct Cause {
    kind: ErrorKind,
    file: Option<String>,
    line: Option<u64>,
    message: Message,
    source: Option<Source>,
    /// What is wrong with the robot or its model file, which says the whole sentence.
    model: Option<sesc_model::Error>,
}

impl Error {
    fn new(kind: ErrorKind, message: impl Into<Message>) -> Error {
        Error(Box::new(Cause {
            kind,
            file: None,
            line: None,
            message: message.into(),
            source: None,
            model: None,
        }))
    }

    fn at(mut self, place: impl Into<String>, line: Option<u64>) -> Error {
        (self.0.file, self.0.line) = (Some(place.into()), line);
        self
    }

    fn because(mut self, cause: impl Into<Source>) -> Error {
        self.0.source = Some(cause.into());
        self
    }

    /// The same error with a remedy, after the name of a file that cannot be read.
    pub(crate) fn saying(mut self, remedy: Message) -> Error {
        self.0.message = remedy.after("; ");
        self
    }

    /// What is asked for makes no sense.
    pub fn request(message: impl Into<Message>) -> Error {
        Error::new(ErrorKind::Request, message)
    }

    /// A fault in a log or another file of data.
    pub fn log(file: impl Into<String>, line: Option<u64>, message: impl Into<Message>) -> Error {
        Error::new(ErrorKind::Log, message).at(file, line)
    }

    /// A fault of a log that does not know its name, which [`of_log`](Self::of_log) adds.
    pub(crate) fn row(line: Option<u64>, message: impl Into<Message>) -> Error {
        let mut error = Error::new(ErrorKind::Log, message);
        error.0.line = line;
        error
    }

    /// The same error of the log called `name`, if it is one of a log without its name.
    pub(crate) fn of_log(mut self, name: &str) -> Error {
        if matches!(self.0.kind, ErrorKind::Log | ErrorKind::Read) {
            self.0.file.get_or_insert_with(|| name.to_string());
        }
        self
    }

    /// A fault in a file of tolerances.
    pub(crate) fn prior(file: impl Into<String>, message: impl Into<Message>) -> Error {
        Error::new(ErrorKind::Prior, message).at(file, None)
    }

    /// A file of tolerances that is no TOML, or does not say what they are.
    pub(crate) fn prior_toml(file: impl Into<String>, fault: TomlFault) -> Error {
        Error::new(ErrorKind::Prior, fault.reason).at(file, fault.line)
    }

    /// `file` cannot be read.
    pub(crate) fn read(file: impl Into<String>, source: io::Error) -> Error {
        Error::unread(source).at(file, None)
    }

    /// A log cannot be read that does not know its name.
    pub(crate) fn unread(source: io::Error) -> Error {
        Error::new(ErrorKind::Read, "").because(source)
    }

    /// `file` cannot be written.
    pub(crate) fn write(file: impl Into<String>, source: io::Error) -> Error {
        Error::new(ErrorKind::Write, "")
            .at(file, None)
            .because(source)
    }

    /// A result cannot be written down.
    pub(crate) fn serialise(source: impl Into<Source>) -> Error {
        Error::new(ErrorKind::Serialise, "cannot serialise the result").because(source)
    }

    /// The caller stopped the call.
    pub(crate) fn interrupted() -> Error {
        Error::new(ErrorKind::Interrupted, "stopped before the end")
    }

    /// `file` is of a format that this build leaves out.
    #[cfg(not(all(feature = "parquet", feature = "mcap")))]
    pub(crate) fn without(feature: &'static str, format: &str, file: &str) -> Error {
        let message = crate::message![
            format!("built without {format}; "),
            Setting::Feature(feature),
            " adds it"
        ];
        Error::new(ErrorKind::Unsupported, message).at(file, None)
    }

    /// What kind of thing went wrong.
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// The file with the fault.
    pub fn file(&self) -> Option<&str> {
        self.0.file.as_deref()
    }

    /// The line or row with the fault, from 1.
    pub fn line(&self) -> Option<u64> {
        self.0.line
    }

    /// The column with the fault: messages about one begin with its name.
    pub fn column(&self) -> Option<&str> {
        let rest = self.0.message.first_words().strip_prefix("column `")?;
        rest.split_once('`').map(|(name, _)| name)
    }

    /// What is wrong with the robot or its model file, if it is that.
    pub fn model(&self) -> Option<&sesc_model::Error> {
        let model = self.0.model.as_ref();
        model.filter(|_| self.0.kind == ErrorKind::Model)
    }

    /// The whole sentence, with settings as the caller's users know them.
    pub fn worded(&self, word: impl Fn(Setting) -> String) -> String {
        if let Some(error) = &self.0.model {
            return error.to_string();
        }
        let message = self.0.message.worded(word);
        match (self.0.kind, &self.0.file, self.0.line) {
            (ErrorKind::Read, Some(file), _) => format!("cannot read {file}{message}"),
            (ErrorKind::Write, Some(file), _) => format!("cannot write {file}{message}"),
            (_, Some(file), Some(line)) => format!("{file}:{line}: {message}"),
            (_, Some(file), None) => format!("{file}: {message}"),
            (_, None, _) => message,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.worded(|setting| format!("`{}`", setting.name())))
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        if let Some(error) = &self.0.model {
            return error.source();
        }
        let source = self.0.source.as_deref();
        source.map(|source| source as &(dyn std::error::Error + 'static))
    }
}

impl From<sesc_model::Error> for Error {
    fn from(error: sesc_model::Error) -> Error {
        let kind = match error.kind() {
            sesc_model::ErrorKind::Write => ErrorKind::Write,
            _ => ErrorKind::Model,
        };
        let mut own = Error::new(kind, "");
        (own.0.file, own.0.line) = (error.file().map(str::to_string), error.line());
        own.0.model = Some(error);
        own
    }
}
