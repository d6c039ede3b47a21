//! What to do next, said once: console, pages and JSON print the same list.

use serde::Serialize;

/// Something to do next.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct NextStep {
    /// What to do.
    pub what: String,
    /// What it is good for.
    pub why: String,
    /// Command line, placeholders in capitals; none where no command does it.
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

/// What the caller would type to do the same again: next steps have it in their command lines.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct CommandLine {
    /// The URDF; `URDF` unless given.
    pub urdf: String,
    /// The log; `LOG` unless given.
    pub log: String,
    /// Words of options that the next command takes, too, such as `--support`, `r_sole`; none
    /// unless given.
    pub options: Vec<String>,
}

impl Default for CommandLine {
    fn default() -> CommandLine {
        CommandLine {
            urdf: "URDF".to_string(),
            log: "LOG".to_string(),
            options: Vec::new(),
        }
    }
}

impl CommandLine {
    /// `sesc diagnose op2.urdf --support r_sole --data log.csv --out model.toml`, where `command`
    /// is `diagnose` and `more` is `--out model.toml`.
    pub(crate) fn of(&self, command: &str, more: &str) -> String {
        let mut line = format!("sesc {command} {}", quoted(&self.urdf));
        line = format!("{line}{} --data {}", self.typed(), quoted(&self.log));
        match more {
            "" => line,
            more => format!("{line} {more}"),
        }
    }

    /// `sesc compare log.csv LATER_LOG --urdf op2.urdf --support r_sole`
    pub(crate) fn compared(&self) -> String {
        let [log, urdf] = [&self.log, &self.urdf].map(|word| quoted(word));
        format!("sesc compare {log} LATER_LOG --urdf {urdf}{}", self.typed())
    }

    /// The options, a blank before each.
    fn typed(&self) -> String {
        let words = self.options.iter().map(|word| format!(" {}", quoted(word)));
        words.collect()
    }

    /// The same without an option that takes a value, which the next command gives otherwise.
    pub(crate) fn without(&self, option: &str) -> CommandLine {
        let mut line = self.clone();
        let joined = format!("{option}=");
        line.options.retain(|word| !word.starts_with(&joined));
        while let Some(at) = line.options.iter().position(|word| word == option) {
            let end = (at + 2).min(line.options.len());
            line.options.drain(at..end);
        }
        line
    }
}

/// A word as a shell takes it.
///
/// ```
/// assert_eq!(sesc_identify::next_steps::quoted("my log.csv"), "'my log.csv'");
/// ```
#[doc(hidden)]
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@".contains(c);
    match word.chars().all(plain) && !word.is_empty() {
        true => word.to_string(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

impl NextStep {
    /// Something that is done by hand.
    pub fn by_hand(what: impl Into<String>, why: impl Into<String>) -> NextStep {
        NextStep {
            what: what.into(),
            why: why.into(),
            command: None,
            makes: None,
        }
    }

    /// Something that a command line does: these words behind `sesc`.
    ///
    /// ```
    /// use sesc_identify::next_steps::NextStep;
    ///
    /// let step = NextStep::of_command("Fit the log", "it gives the parameters", &["fit", "a b.urdf"]);
    /// assert_eq!(step.command.as_deref(), Some("sesc fit 'a b.urdf'"));
    /// ```
    pub fn of_command(what: impl Into<String>, why: impl Into<String>, words: &[&str]) -> NextStep {
        let words: Vec<String> = words.iter().map(|word| quoted(word)).collect();
        NextStep::by_hand(what, why).by(format!("sesc {}", words.join(" ")))
    }

    /// What broken data leave to be done.
    pub(crate) fn repair() -> NextStep {
        NextStep::by_hand(
            "Repair what is wrong with the data, and record the log again",
            "nothing that is fitted to broken data is a result",
        )
    }

    /// The same, done by this command line.
    pub(crate) fn by(self, command: String) -> NextStep {
        NextStep {
            command: Some(command),
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
