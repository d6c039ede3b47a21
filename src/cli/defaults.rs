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

use std::any::TypeId;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command};
use sesc_identify::logs::Sidecar;
use sesc_model::files;
use sesc_model::spelling::nearest;
use sesc_model::text::shortened;

use crate::Error;

/// The file's name.
pub(super) const FILE: &str = "sesc.toml";

/// The newest format of the file that is read.
const FORMAT: u32 = 1;

/// Keys, which are options with `_` for `-`, in the order in which they are said. What their values
/// are the options say: flags, numbers, texts or, where the name of the value has `FILE`, paths.
pub(super) const KEYS: [&str; 14] = [
    "support",
    "no_snap",
    "both_feet",
    "other_foot",
    "degrees",
    "prior",
    "noise",
    "offset",
    "floor",
    "motion",
    "limits",
    "cop_box",
    "sole",
    "servos",
];

/// Options that the [`FILE`] of a robot gives.
pub(super) struct Given {
    command: String,
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

    /// The words of a command line with them, behind the name of the command: what comes after
    /// `--` are files.
    pub(super) fn beside(&self, words: &[OsString]) -> Vec<OsString> {
        let mut words = words.to_vec();
        let at = words.iter().position(|word| *word == *self.command);
        let at = at.map_or(words.len(), |k| k + 1);
        words.splice(at..at, self.options.iter().map(|(_, option)| option.into()));
        words
    }
}

/// Refuse the first of these options that was typed, since nothing would come of it; `why` has the
/// remedy.
///
/// # Errors
/// When one was typed.
pub(super) fn refuse(words: &ArgMatches, options: &[&str], why: &str) -> Result<(), Error> {
    let own = words.subcommand().map(|(_, own)| own);
    let typed = |option: &&&str| own.is_some_and(|own| is_typed(own, &option.replace('-', "_")));
    match options.iter().find(typed) {
        Some(option) => Err(Error::Usage(format!("--{option} {why}"))),
        None => Ok(()),
    }
}

/// The options that the robot's [`FILE`] gives to the command and nobody typed, if any.
///
/// # Errors
/// A file that cannot be used, with its name, the key and the remedy.
pub(super) fn given(program: &Command, words: &ArgMatches) -> Result<Option<Given>, Error> {
    let command = words.subcommand().and_then(|(name, matches)| {
        Some((program.find_subcommand(name)?, matches, of_robot(matches)?))
    });
    let Some((command, matches, file)) = command else {
        return Ok(None);
    };
    let Some((text, table)) = read(&file)? else {
        return Ok(None);
    };
    if let Some(unknown) = table.keys().find(|key| !KEYS.contains(&key.as_str())) {
        let meant = nearest(unknown, "", KEYS);
        let meant = meant.map_or(String::new(), |key| format!("; did you mean `{key}`?"));
        let remedy = format!("no such key; the keys are {}{meant}", KEYS.join(", "));
        return Err(wrong(&file, &text, &shortened(unknown, 64), &remedy));
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut options = Vec::new();
    for key in KEYS {
        let own = option(command, key);
        // A fault of the file is one for every command.
        let mut others = program.get_subcommands();
        let known = own.or_else(|| others.find_map(|other| option(other, key)));
        let (Some(value), Some(known)) = (table.get(key), known) else {
            continue;
        };
        let spelled = spelled(value, known, folder);
        let spelled = spelled.map_err(|remedy| wrong(&file, &text, key, &remedy))?;
        let wanted = own.is_some_and(|own| wanted(command, matches, own));
        options.extend(spelled.filter(|_| wanted).map(|option| (key, option)));
    }
    let command = command.get_name().to_string();
    Ok((!options.is_empty()).then_some(Given {
        command,
        file,
        text,
        options,
    }))
}

/// The option of a key, where a command has it.
fn option<'c>(command: &'c Command, key: &str) -> Option<&'c Arg> {
    let name = key.replace('_', "-");
    let mut all = command.get_arguments();
    all.find(|own| own.get_long() == Some(&name))
}

/// Where the file of the command's robot would be.
fn of_robot(matches: &ArgMatches) -> Option<PathBuf> {
    let values = |id| matches.try_get_raw(id).ok().flatten();
    let urdf = values("urdf").or_else(|| values("inputs"))?.next()?;
    beside(Path::new(urdf))
}

/// Where the file of the robot of this URDF would be; none beside what is no URDF by its name.
pub(super) fn beside(urdf: &Path) -> Option<PathBuf> {
    let extension = urdf.extension()?.to_str()?;
    let is_described = ["urdf", "xacro", "xml"].contains(&extension);
    is_described.then(|| urdf.with_file_name(FILE))
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
    let quotes = ['"', '\''];
    let is_key = |line: &str| {
        let rest = line.trim_start().trim_start_matches(quotes);
        let rest = rest.strip_prefix(key).unwrap_or_default();
        let rest = rest.trim_start_matches(quotes);
        rest.trim_start().starts_with('=')
    };
    let line = text.lines().position(is_key);
    let line = line.map(|k| k as u64 + 1);
    fault(file, line, format!("`{key}`: {remedy}"))
}

fn fault(file: &Path, line: Option<u64>, reason: String) -> Error {
    let file = file.display().to_string();
    Error::Settings { file, line, reason }
}

/// A value as it is typed, `--noise=0.001`; none of a flag that is off.
fn spelled(value: &toml::Value, option: &Arg, folder: &Path) -> Result<Option<String>, String> {
    use toml::Value::{Boolean, Float, Integer, String};
    let name = option.get_long().unwrap_or_default();
    let words = option.get_value_names().unwrap_or_default().first();
    let mut words = words.map_or("", |words| words.as_str()).split('|');
    let is_number = option.get_value_parser().type_id() == TypeId::of::<f64>();
    let value = match (option.get_action().takes_values(), value) {
        (false, Boolean(on)) => return Ok(on.then(|| format!("--{name}"))),
        (false, _) => return Err("give true or false".to_string()),
        (true, Float(number)) if is_number => format!("{number:?}"),
        (true, Integer(number)) if is_number => number.to_string(),
        (true, _) if is_number => return Err("give a number".to_string()),
        (true, String(text)) if words.clone().any(|own| own == text) => text.clone(),
        (true, String(text)) if words.any(|own| own == "FILE") => {
            let path = files::named_in(folder, text);
            let path = path.map_err(|error| format!("{error}; type the option to read it"))?;
            path.display().to_string()
        }
        (true, String(text)) => text.clone(),
        (true, _) => return Err("give a text in quotes".to_string()),
    };
    Ok(Some(format!("--{name}={value}")))
}

/// Whether an option of the command has not been typed, and is of use.
fn wanted(command: &Command, matches: &ArgMatches, own: &Arg) -> bool {
    let id = own.get_id().as_str();
    let used = match id {
        "support" => command.get_name() != "fleet" && !logs_say_support(matches),
        // Postures at rest have no motion.
        "motion" => command.get_name() != "simulate" || is_typed(matches, "rate"),
        // Rust takes angles alone.
        "servos" => {
            let mut lang = matches
                .try_get_raw("lang")
                .ok()
                .flatten()
                .into_iter()
                .flatten();
            command.get_name() != "generate" || lang.any(|lang| lang == "c")
        }
        _ => true,
    };
    used && !is_typed(matches, id) && !contradicts(command, matches, own)
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

/// Whether logs of the command name their own support links.
fn logs_say_support(matches: &ArgMatches) -> bool {
    let logs = matches.try_get_raw("data").ok().flatten();
    // The command itself complains about a sidecar with errors.
    let says = |log| Sidecar::of(Path::new(log)).map_or(true, |(own, _)| own.support.is_some());
    logs.into_iter().flatten().any(says)
}
