//! How results and messages look: bold verdicts, coloured warnings, or silence.
//!
//! Only what people read is emphasised, and only where a terminal shows it; JSON, CSV and
//! written files are the same everywhere.

use std::env;
use std::io::IsTerminal as _;
use std::sync::OnceLock;

use clap::{Args, ValueEnum};

const BOLD: &str = "\x1b[1m";
const RED: &str = "\x1b[1;31m";
const YELLOW: &str = "\x1b[1;33m";
const CYAN: &str = "\x1b[36m";
const PLAIN: &str = "\x1b[0m";

/// What every command takes.
#[derive(Args, Clone, Copy, Default)]
#[command(next_help_heading = "Options of every command")]
pub(super) struct Manners {
    /// Emphasise verdicts and warnings; `auto` does so on a terminal, unless `NO_COLOR` is set
    #[arg(long, value_name = "WHEN", value_enum, default_value_t, global = true)]
    color: When,
    /// Say nothing on stderr but warnings and errors: no notes, no progress, no names of
    /// written files
    #[arg(long, short, global = true)]
    quiet: bool,
}

#[derive(Clone, Copy, Default, PartialEq, ValueEnum)]
enum When {
    #[default]
    Auto,
    Always,
    Never,
}

/// Those of the command that runs in this process; set once.
static MANNERS: OnceLock<Manners> = OnceLock::new();

impl Manners {
    /// They hold for all that this process says from now on.
    pub(super) fn hold(self) {
        // Only a second command in one process finds them set.
        let _ = MANNERS.set(self);
    }
}

fn manners() -> Manners {
    MANNERS.get().copied().unwrap_or_default()
}

fn emphasis(terminal: bool) -> bool {
    let wanted = || {
        let unwanted = env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        terminal && !unwanted && env::var_os("TERM").is_none_or(|term| term != "dumb")
    };
    match manners().color {
        When::Always => true,
        When::Never => false,
        When::Auto => wanted(),
    }
}

/// Whether `--quiet` asks for results, warnings and errors alone.
pub(super) fn quiet() -> bool {
    manners().quiet
}

/// A result for people: its first paragraph and the headings of its tables in bold.
pub(super) fn result(text: &str) -> String {
    match emphasis(std::io::stdout().is_terminal()) {
        true => bold(text),
        false => text.to_string(),
    }
}

fn bold(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let first = lines.iter().take_while(|line| !line.is_empty()).count();
    let underlined = |k: usize| {
        let below = lines.get(k + 1);
        below.is_some_and(|line| line.starts_with('─') && line.chars().all(|c| "─ ".contains(c)))
    };
    let mut out = String::with_capacity(text.len() + 64);
    for (k, line) in lines.iter().enumerate() {
        match !line.is_empty() && (k < first || underlined(k)) {
            true => out.push_str(&format!("{BOLD}{line}{PLAIN}\n")),
            false => out.push_str(&format!("{line}\n")),
        }
    }
    out
}

/// A message on stderr, its kind (`warning:`, `error:`) in colour; none that `--quiet` silences.
pub(super) fn message(text: &str) -> Option<String> {
    let kinds = [
        ("error:", RED, true),
        ("check failed:", RED, true),
        ("warning:", YELLOW, true),
        ("note:", CYAN, false),
        ("next ", CYAN, false),
    ];
    let kind = kinds.iter().find(|(kind, ..)| text.starts_with(kind));
    let heeded = kind.is_some_and(|(.., heeded)| *heeded);
    if quiet() && !heeded {
        return None;
    }
    let painted = emphasis(std::io::stderr().is_terminal());
    Some(match kind.filter(|_| painted) {
        Some((kind, colour, _)) => format!("{colour}{kind}{PLAIN}{}", &text[kind.len()..]),
        None => text.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_paragraph_and_headings_are_bold() {
        let text = "Verdict,\nin two lines.\n\neffect  mm\n──────  ──\noffset   2\n";
        let expected = "\x1b[1mVerdict,\x1b[0m\n\x1b[1min two lines.\x1b[0m\n\n\
                        \x1b[1meffect  mm\x1b[0m\n──────  ──\noffset   2\n";
        assert_eq!(bold(text), expected);
    }
}
