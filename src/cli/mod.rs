//! The command line: parse, call, print.

mod arguments;
mod compare;
mod defaults;
mod demo;
mod diagnose;
mod effects;
mod fit;
mod fleet;
mod generate;
mod inspect;
mod outputs;
mod plan;
mod predict;
#[cfg(feature = "schema")]
pub mod schema;
mod shell;
mod simulate;
mod steps;
mod terminal;
pub mod values;
mod verify;
mod width;

use std::ffi::OsString;
use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::sync::OnceLock;

use arguments::{
    DiagnosisArguments, FeetArguments, OffsetArguments, ReadingArguments, RobotArguments,
    StandingArguments, StaysArguments,
};
use clap::error::{ContextKind, ErrorKind};
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use sesc_model::text::{is_hidden, visible, visible_lines};
use terminal::Bar;

use crate::Error;
use crate::report::next_steps::{self, WithSteps, Worded};
use crate::report::table::{gathered, wrapped_at};
use sesc_identify::logs::{COLUMNS, Need};
use sesc_identify::robot::Robot;

/// Centre of mass by the statically equivalent serial chain: from a URDF to
/// verified functions, and from posture logs to parameters.
#[derive(Parser)]
#[command(name = "sesc", version, about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    manners: terminal::Manners,
}

#[derive(Subcommand)]
enum Command {
    // In the order of work, the demo before it.
    Demo(demo::Arguments),
    Inspect(inspect::Arguments),
    Plan(plan::Arguments),
    Simulate(simulate::Arguments),
    Fit(fit::Arguments),
    Diagnose(diagnose::Arguments),
    Effects(effects::Arguments),
    Compare(compare::Arguments),
    Predict(predict::Arguments),
    Generate(generate::Arguments),
    Verify(verify::Arguments),
    Fleet(fleet::Arguments),
    Completions(shell::Completions),
    Man(shell::Manual),
}

/// Whether every check of a command passed (exit code 1 if not), or why it did not run.
type Outcome = Result<bool, Error>;

/// Words of the command line that runs in this process, its name first.
static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

/// Run the command line of this process.
pub fn main() -> ExitCode {
    ExitCode::from(main_from(std::env::args_os().collect()))
}

/// Run the command line of these words, the name of the program first, in a process that does
/// nothing else; gives its exit code.
pub fn main_from(words: Vec<OsString>) -> u8 {
    let words = WORDS.get_or_init(|| words);
    let mut options = words.iter().skip(1).take_while(|word| *word != "--");
    let json = options.any(|word| word == "--json");
    let mut program = Cli::command();
    let typed = &match program.try_get_matches_from_mut(words) {
        Ok(typed) => typed,
        Err(error) => return refused(error, None, json),
    };
    let given = match defaults::given(&program, typed) {
        Ok(given) => given,
        Err(error) => return failed(&error, None, json),
    };
    let given = given.as_ref();
    let parsed = match given {
        None => Cli::from_arg_matches(typed),
        Some(given) => Cli::try_parse_from(given.beside(words)),
    };
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => return refused(error, given, json),
    };
    cli.manners.hold();
    if let Some(given) = given {
        message(&given.note());
    }
    stay_silent_where_panics_become_errors();
    if let Err(error) = outputs::tidy_when_interrupted() {
        // Results do not depend on it.
        message(&format!(
            "note: an interruption would leave files behind: {error}"
        ));
    }
    let outcome = match cli.command {
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Generate(arguments) => generate::run(&arguments),
        Command::Verify(arguments) => verify::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Predict(arguments) => predict::run(&arguments),
        Command::Fit(arguments) => fit::run(&arguments, typed),
        Command::Diagnose(arguments) => diagnose::run(&arguments),
        Command::Effects(arguments) => effects::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments, typed),
        Command::Fleet(arguments) => fleet::run(&arguments, typed),
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Completions(arguments) => shell::completions(&arguments),
        Command::Man(arguments) => shell::manual(&arguments),
    };
    match outcome {
        Ok(passed) => u8::from(!passed),
        // A reader that went away (`| head`) is no fault.
        Err(error) if outputs::is_closed(&error) => 0,
        Err(error) => failed(&error, given, json),
    }
}

/// Say what the parser finds wrong, and in which file where that gave the option; the exit code.
fn refused(mut error: clap::Error, given: Option<&defaults::Given>, json: bool) -> u8 {
    // Help and version are answers.
    if !error.use_stderr() {
        error.exit();
    }
    // A word behind `--` is a file: no remedy for an option that is not there.
    if error.kind() == ErrorKind::UnknownArgument {
        error.remove(ContextKind::Suggested);
    }
    let rendered = error.render().to_string();
    let said = rendered.trim_start_matches("error: ").split("\n\n");
    let is_beside =
        |own: &str| own.starts_with("Usage:") || own.starts_with("For more information");
    let said = said.filter(|own| !is_beside(own.trim_start()));
    let said: Vec<&str> = said.map(str::trim_end).collect();
    let first = said.first().copied().unwrap_or_default();
    if let Some(error) = given.and_then(|given| given.blamed(first)) {
        return failed(&error, None, json);
    }
    if json {
        print_error(&Error::Usage(said.join("\n\n")));
    }
    error.exit()
}

/// Say what is wrong, and where an option stands that it is about; the exit code.
fn failed(error: &Error, given: Option<&defaults::Given>, json: bool) -> u8 {
    let placed = given.and_then(|given| given.blamed(&error.to_string()));
    let error = match (&placed, error.kind()) {
        // Other kinds name files of their own.
        (Some(placed), "usage" | "request") => placed,
        _ => error,
    };
    if json {
        print_error(error);
    }
    complain(error);
    2
}

/// Damaged Parquet files make its library panic; the error that comes of it says enough.
fn stay_silent_where_panics_become_errors() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |about| {
        if !sesc_identify::logs::panic_becomes_error() {
            usual(about);
        }
    }));
}

/// What programs are told where a command fails.
#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Failure<'a> {
    /// What went wrong.
    error: ErrorAbout<'a>,
}

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ErrorAbout<'a> {
    /// Kind of error; `usage`, `model`, `log`, `read`, `write` and others.
    kind: &'a str,
    /// The sentence, with its causes.
    message: String,
    /// The file that it is about.
    file: Option<&'a str>,
    /// The line of that file, from 1.
    line: Option<u64>,
}

/// An error on stdout, for programs; stderr has the sentence, too.
fn print_error(error: &Error) {
    let message = [vec![error.to_string()], causes(error)].concat().join(": ");
    let error = ErrorAbout {
        kind: error.kind(),
        message: message.trim_end().to_string(),
        file: error.file(),
        line: error.line(),
    };
    // If stdout is closed, nobody reads it.
    let _ = print_json(&Failure { error });
}

/// An error and what caused it, on stderr.
fn complain(error: &Error) {
    let mut text = format!("error: {error}\n");
    for cause in causes(error) {
        text.push_str(&format!("  caused by: {cause}\n"));
    }
    // A line break of a path begins no line.
    if let Some(file) = error.file().filter(|file| file.contains('\n')) {
        text = text.replace(file, &visible(file));
    }
    messages(text.trim_end());
}

/// What caused an error, the nearest cause first.
fn causes(error: &Error) -> Vec<String> {
    let first = match error {
        // Said already, in the words of this command line.
        Error::Identify(inner) => std::error::Error::source(inner),
        other => std::error::Error::source(other),
    };
    let all = std::iter::successors(first, |inner| inner.source());
    all.map(ToString::to_string).collect()
}

/// What the links of a robot weigh together in its URDF.
fn check_mass(kg: Option<f64>, robot: &Robot) -> Result<(), Error> {
    let wrong = |wrong| Error::Usage(format!("--total-mass {}: {wrong}", kg.unwrap_or_default()));
    values::check_mass(kg, robot).map_err(wrong)
}

/// Notes, on stderr; those of one kind together.
fn notes(notes: &[String]) {
    for note in gathered(notes, false) {
        message(&format!("note: {note}"));
    }
}

/// Say on stderr that an output is missing.
fn not_written(path: &Path) {
    message(&format!(
        "{} is not written: the data cannot be used",
        path.display()
    ));
}

/// A line on stderr: a line break of a path begins no other.
fn message(text: &str) {
    messages(&visible(text));
}

/// Lines on stderr. Names of files may hold what a terminal obeys; it is spelled out.
fn messages(text: &str) {
    if let Some(text) = terminal::worded(&visible_lines(text)) {
        // If stderr is closed, the message cannot be shown.
        let _ = writeln!(std::io::stderr(), "{text}");
    }
}

/// A result on stdout that people read: emphasised where a terminal shows it.
fn show(text: &str) -> Result<(), Error> {
    let text = visible_lines(text);
    let text = width::of_terminal().map_or(text.clone(), |width| width::fitted(&text, width));
    print_as_is(&terminal::result(&text))
}

/// A result, as JSON or as a text for people, which goes to stderr where stdout has an output or
/// names of files (`is_beside`).
fn print_found(
    json: bool,
    found: &impl serde::Serialize,
    is_beside: bool,
    text: impl FnOnce() -> String,
) -> Result<(), Error> {
    match json {
        true => print_json(found),
        false if is_beside => {
            messages(text().trim_end());
            Ok(())
        }
        false => show(&text()),
    }
}

/// A result with what to do next, which stands below its text.
fn print_with_steps(
    json: bool,
    found: &impl serde::Serialize,
    next_steps: &[Worded],
    text: impl FnOnce() -> String,
) -> Result<(), Error> {
    let answer = WithSteps { found, next_steps };
    let text = || format!("{}\n{}", text(), next_steps::text(next_steps));
    print_found(json, &answer, false, text)
}

fn print_as_is(text: &str) -> Result<(), Error> {
    let mut stdout = std::io::stdout().lock();
    stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
        .map_err(Error::Stdout)
}

/// What JSON of every command begins with: a number that grows when keys change their
/// meaning, and the keys of the command.
#[derive(serde::Serialize)]
struct Answer<'a, T: serde::Serialize> {
    schema: u32,
    #[serde(flatten)]
    value: &'a T,
}

/// The keys of `sesc.toml`.
pub fn robot_keys() -> impl Iterator<Item = &'static str> {
    defaults::KEYS.into_iter()
}

/// [`COLUMNS`] as a text for help, a line for each that any terminal shows.
///
/// ```
/// let text = sesc::cli::columns_text();
/// assert!(text.contains("cop_x, cop_y"));
/// ```
pub fn columns_text() -> String {
    let mut text = "Columns of a posture log:".to_string();
    for column in COLUMNS {
        let need = match column.need {
            Need::Always => " (required)",
            Need::Reading => " (one kind of reading, where the command needs readings)",
            _ => "",
        };
        let start = format!("\n  {:<32} {:<6} ", column.names.join(", "), column.unit);
        let indent = " ".repeat(start.chars().count() - 1);
        let meaning = format!("{}{need}", column.meaning);
        text += &(start + &wrapped_at(&meaning, &indent, 98 - indent.len()));
    }
    text
}

/// See [`Answer`].
const SCHEMA: u32 = 1;

/// A value as commands print it with `--json`.
///
/// # Errors
/// When it cannot be written as JSON.
pub fn json(value: &impl serde::Serialize) -> Result<String, Error> {
    let answer = Answer {
        schema: SCHEMA,
        value,
    };
    let text = serde_json::to_string_pretty(&answer);
    text.map(|text| ascii_controls(&text))
        .map_err(|error| Error::Report(Box::new(error)))
}

/// A value as JSON on stdout.
fn print_json(value: &impl serde::Serialize) -> Result<(), Error> {
    print_as_is(&(json(value)? + "\n"))
}

/// JSON whose strings hold nothing that a terminal obeys; its own lines are as they were.
fn ascii_controls(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        match is_hidden(c) && c != '\n' {
            true => out.push_str(&format!("\\u{:04x}", u32::from(c))),
            false => out.push(c),
        }
    }
    out
}

/// A number above zero.
fn positive(text: &str) -> Result<f64, &'static str> {
    let value = text.parse().ok();
    let value = value.filter(|value: &f64| *value > 0.0 && value.is_finite());
    value.ok_or("give a number above 0")
}

/// Whether an error, m, is one that the caller accepts, in noise floors; `what` names it.
fn judged(what: &str, error: f64, floor: f64, most: Option<f64>) -> bool {
    // What is not a number is no success either.
    let within = |most: &f64| error.is_finite() && error <= most * floor;
    let beyond = most.filter(|most| !within(most));
    if let Some(most) = beyond {
        let [error, floor] = [error, floor].map(|metres| 1e3 * metres);
        message(&format!(
            "check failed: {what} is {error:.2} mm, which is more than {most} noise floors of \
             {floor:.2} mm"
        ));
    }
    beyond.is_none()
}

/// This command line, as a shell takes it.
fn command_line() -> String {
    let words = WORDS.get().into_iter().flatten().skip(1);
    let words: Vec<_> = words.map(|word| word.to_string_lossy()).collect();
    steps::line(words.iter().map(AsRef::as_ref))
}
