//! `sesc.toml` beside a URDF: options that every command on this robot would be given.
//!
//! ```toml
//! support = "r_sole"
//! prior = "tight"
//! noise = 0.0005          # m
//! limits = "limits.csv"   # in the folder of this file
//! ```
//!
//! What the command line says wins over it, and so does the support link that the sidecar of a
//! log names. The options that were taken from it are said in a note.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command, CommandFactory as _};
use sesc_identify::logs::Sidecar;
use sesc_model::files;
use sesc_model::spelling::nearest;
use sesc_model::text::shortened;

use super::Cli;
use crate::Error;

/// The file's name.
pub(super) const FILE: &str = "sesc.toml";

/// The newest format of the file that is read.
const FORMAT: u32 = 1;

/// What a key's value is.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Text,
    Number,
    Flag,
    /// A path, unless it is one of these words.
    Path(&'static [&'static str]),
}

/// Keys, which are options with `_` for `-`, in the order in which they are said.
pub(super) const KEYS: [(&str, Kind); 14] = [
    ("support", Kind::Text),
    ("no_snap", Kind::Flag),
    ("both_feet", Kind::Flag),
    ("other_foot", Kind::Text),
    ("degrees", Kind::Flag),
    ("prior", Kind::Path(&["tight", "cad", "free"])),
    ("noise", Kind::Number),
    ("offset", Kind::Number),
    ("floor", Kind::Number),
    ("motion", Kind::Text),
    ("limits", Kind::Path(&[])),
    ("cop_box", Kind::Number),
    ("sole", Kind::Path(&[])),
    ("servos", Kind::Path(&[])),
];

/// Options that the [`FILE`] of a robot gave.
pub(super) struct Given {
    file: PathBuf,
    text: String,
    /// Options as they are typed, `--noise=0.001`, each with its key.
    options: Vec<(&'static str, String)>,
}

impl Given {
    /// What is said of them.
    pub(super) fn note(&self) -> String {
        let options: Vec<&str> = self.options.iter().map(|(_, own)| own.as_str()).collect();
        format!("note: {} gives {}", self.file.display(), options.join(" "))
    }

    /// The message as a fault of the first of them that it names, with the place of its key.
    pub(super) fn blamed(&self, message: &str) -> Option<Error> {
        let names = |option: &str| {
            let name = option.split('=').next().unwrap_or(option);
            let ends = |after: &str| !after.starts_with(|c: char| c.is_alphanumeric() || c == '-');
            let mut places = message.match_indices(name);
            places.any(|(at, _)| ends(&message[at + name.len()..]))
        };
        let (key, _) = self.options.iter().find(|(_, option)| names(option))?;
        Some(wrong(&self.file, &self.text, key, message))
    }
}

/// The options of a command that were typed, apart from those that a file gives.
pub(super) struct Typed(ArgMatches);

impl Typed {
    /// The options of these words; none of words that the parser refuses.
    pub(super) fn new(words: &[OsString]) -> Typed {
        let matches = Cli::command().try_get_matches_from(words);
        Typed(matches.unwrap_or_default())
    }

    /// The first of these options that was typed; their names are those of the parser's fields.
    pub(super) fn first(&self, options: &[&str]) -> Option<String> {
        let (_, matches) = self.0.subcommand()?;
        let typed = |option: &&&str| {
            let id = option.replace('-', "_");
            matches.try_contains_id(&id).is_ok() && is_typed(matches, &id)
        };
        let first = options.iter().find(typed)?;
        Some(format!("--{first}"))
    }
}

/// `words` with the options that the robot's [`FILE`] gives and they do not, and those.
///
/// # Errors
/// A file that cannot be used, with its name, the key and the remedy.
pub(super) fn completed(
    words: &[OsString],
    typed: &Typed,
) -> Result<(Vec<OsString>, Option<Given>), Error> {
    let mut words = words.to_vec();
    let command = Cli::command();
    // What is wrong with the words is said by the parser that runs after this.
    let Some((name, matches)) = typed.0.subcommand() else {
        return Ok((words, None));
    };
    let (Some(command), Some(file)) = (command.find_subcommand(name), of_robot(matches)) else {
        return Ok((words, None));
    };
    let Some((text, table)) = read(&file)? else {
        return Ok((words, None));
    };
    let known: Vec<&str> = KEYS.iter().map(|(key, _)| *key).collect();
    if let Some(unknown) = table.keys().find(|key| !known.contains(&key.as_str())) {
        let meant = nearest(unknown, "", known.iter().copied());
        let meant = meant.map_or(String::new(), |key| format!("; did you mean `{key}`?"));
        let remedy = format!("no such key; the keys are {}{meant}", known.join(", "));
        return Err(wrong(&file, &text, &shortened(unknown, 64), &remedy));
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut given = Vec::new();
    for (key, kind) in KEYS {
        let Some(value) = table.get(key) else {
            continue;
        };
        let option =
            spelled(value, kind, folder).map_err(|remedy| wrong(&file, &text, key, &remedy))?;
        if let Some(value) = option.filter(|_| wanted(command, matches, key)) {
            given.push((key, format!("--{}{value}", key.replace('_', "-"))));
        }
    }
    if given.is_empty() {
        return Ok((words, None));
    }
    // Behind the name of the command: what comes after `--` are files.
    let at = words.iter().position(|word| word == name);
    let at = at.map_or(words.len(), |k| k + 1);
    words.splice(at..at, given.iter().map(|(_, option)| option.into()));
    let options = given;
    let given = Given {
        file,
        text,
        options,
    };
    Ok((words, Some(given)))
}

/// Where the file of the command's robot would be.
fn of_robot(matches: &ArgMatches) -> Option<PathBuf> {
    let values = |id| matches.try_get_raw(id).ok().flatten();
    let urdf = values("urdf").or_else(|| values("inputs"))?.next()?;
    beside(Path::new(urdf))
}

/// Where the file of the robot of this URDF would be; none beside what is no URDF by its name.
pub(super) fn beside(urdf: &Path) -> Option<PathBuf> {
    let described = urdf.extension().and_then(OsStr::to_str);
    let described =
        described.is_some_and(|extension| ["urdf", "xacro", "xml"].contains(&extension));
    described.then(|| urdf.with_file_name(FILE))
}

fn read(file: &Path) -> Result<Option<(String, toml::Table)>, Error> {
    let text = match files::read_found_text(file, files::SIDECAR) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(fault(file, None, error.to_string())),
    };
    match files::parse_toml(&text, FORMAT) {
        Ok(table) => Ok(Some((text, table))),
        Err(found) => Err(fault(file, found.line, found.reason)),
    }
}

/// What is wrong with a key of `text`, with its line.
fn wrong(file: &Path, text: &str, key: &str, remedy: &str) -> Error {
    let is_key = |line: &str| {
        let rest = line.trim_start().trim_start_matches(['"', '\'']);
        let rest = rest
            .strip_prefix(key)
            .map(|rest| rest.trim_start_matches(['"', '\'']));
        rest.is_some_and(|rest| rest.trim_start().starts_with('='))
    };
    let line = text.lines().position(is_key);
    let line = line.map(|k| k as u64 + 1);
    fault(file, line, format!("`{key}`: {remedy}"))
}

fn fault(file: &Path, line: Option<u64>, reason: String) -> Error {
    let file = file.display().to_string();
    Error::Settings { file, line, reason }
}

/// A value as it stands behind its option; none of a flag that is off.
fn spelled(value: &toml::Value, kind: Kind, folder: &Path) -> Result<Option<String>, String> {
    use toml::Value::{Boolean, Float, Integer, String};
    match (kind, value) {
        (Kind::Text, String(text)) => Ok(Some(format!("={text}"))),
        (Kind::Number, Float(number)) => Ok(Some(format!("={number:?}"))),
        (Kind::Number, Integer(number)) => Ok(Some(format!("={number}"))),
        (Kind::Flag, Boolean(on)) => Ok(on.then(Default::default)),
        (Kind::Path(words), String(text)) if words.contains(&text.as_str()) => {
            Ok(Some(format!("={text}")))
        }
        (Kind::Path(_), String(text)) => match files::named_in(folder, text) {
            Ok(path) => Ok(Some(format!("={}", path.display()))),
            Err(error) => Err(format!("{error}; type the option to read it")),
        },
        (Kind::Number, _) => Err("give a number".to_string()),
        (Kind::Flag, _) => Err("give true or false".to_string()),
        (Kind::Text | Kind::Path(_), _) => Err("give a text in quotes".to_string()),
    }
}

/// Whether the command knows the option, has not been given it, and would use it.
fn wanted(command: &Command, matches: &ArgMatches, key: &str) -> bool {
    let option = key.replace('_', "-");
    let own = command
        .get_arguments()
        .find(|own| own.get_long() == Some(&option));
    let Some(own) = own else { return false };
    let typed = is_typed(matches, own.get_id().as_str()) || contradicts(command, matches, own);
    let used = match key {
        "support" => command.get_name() != "fleet" && !logs_say_support(matches),
        // Postures at rest have no motion.
        "motion" => command.get_name() != "simulate" || is_typed(matches, "rate"),
        // Rust takes angles alone.
        "servos" => command.get_name() != "generate" || takes_ticks(matches),
        _ => true,
    };
    !typed && used
}

/// Whether an option that does not go with this one has been typed: it wins, too.
fn contradicts(command: &Command, matches: &ArgMatches, own: &Arg) -> bool {
    let conflict = |one: &Arg, other: &Arg| {
        let all = command.get_arg_conflicts_with(one);
        all.iter().any(|found| found.get_id() == other.get_id())
    };
    command.get_arguments().any(|other| {
        is_typed(matches, other.get_id().as_str()) && (conflict(own, other) || conflict(other, own))
    })
}

fn is_typed(matches: &ArgMatches, id: &str) -> bool {
    matches.value_source(id) == Some(ValueSource::CommandLine)
}

fn takes_ticks(matches: &ArgMatches) -> bool {
    matches
        .try_get_raw("lang")
        .ok()
        .flatten()
        .is_some_and(|mut lang| lang.any(|lang| lang == "c"))
}

/// Whether logs of the command name their own support links.
fn logs_say_support(matches: &ArgMatches) -> bool {
    let Ok(Some(mut logs)) = matches.try_get_raw("data") else {
        return false;
    };
    logs.any(|log| match Sidecar::of(Path::new(log)) {
        Ok((sidecar, _)) => sidecar.support.is_some(),
        // The command itself complains about it.
        Err(_) => true,
    })
}
