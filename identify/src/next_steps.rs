//! What to do next, said once: console, pages and JSON print the same list.

use serde::Serialize;

/// Something to do next.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct NextStep {
    /// What to do, without a full stop.
    pub what: String,
    /// What it is good for, without a capital and a full stop.
    pub why: String,
    /// The command line that does it, in which words in capitals stand for files of the reader;
    /// none where no command does it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// The file that the command writes; who has asked for it needs no such step.
    #[serde(skip)]
    pub makes: Option<Output>,
}

/// Files that a step writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Output {
    /// A model file.
    Model,
    /// A page.
    Page,
    /// Postures to take next.
    Postures,
}

impl NextStep {
    /// Something that is done by hand.
    pub(crate) fn by_hand(what: impl Into<String>, why: impl Into<String>) -> NextStep {
        NextStep {
            what: what.into(),
            why: why.into(),
            command: None,
            makes: None,
        }
    }

    /// What broken data leave to be done.
    pub(crate) fn repair() -> NextStep {
        NextStep::by_hand(
            "Repair what is wrong with the data, and record the log again",
            "nothing that is fitted to broken data is a result",
        )
    }

    /// The same, done by this command line.
    pub(crate) fn by(self, command: &str) -> NextStep {
        NextStep {
            command: Some(command.to_string()),
            ..self
        }
    }

    /// The same, which writes a file.
    pub(crate) fn makes(self, output: Output) -> NextStep {
        NextStep {
            makes: Some(output),
            ..self
        }
    }

    /// Both in a sentence: what to do, and what it is good for.
    pub fn sentence(&self) -> String {
        format!("{}: {}.", self.what, self.why)
    }
}
