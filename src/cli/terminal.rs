//! What people see of a command beside its result: bold verdicts, coloured warnings or silence, and
//! progress.
//!
//! Only what people read is emphasised, and only where a terminal shows it; JSON, CSV and written
//! files are the same everywhere. Progress is a bar on a terminal; a run that takes long says a
//! line for each tenth elsewhere.

use std::env;
use std::io::{self, IsTerminal as _};
use std::ops::ControlFlow;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use clap::{Args, ColorChoice};
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use sesc_identify::{Message, Progress, Watch};

use super::message;
use super::width::is_rule;
use crate::words::option;

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
    color: ColorChoice,
    /// Say nothing on stderr but warnings and errors: no notes, no progress, no names of
    /// written files
    #[arg(long, short, global = true)]
    quiet: bool,
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
    let set = |name: &str| env::var_os(name).unwrap_or_default();
    match manners().color {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => terminal && set("NO_COLOR").is_empty() && set("TERM") != "dumb",
    }
}

/// A result for people: its first paragraph and the headings of its tables in bold.
pub(super) fn result(text: &str) -> String {
    match emphasis(io::stdout().is_terminal()) {
        true => bold(text),
        false => text.to_string(),
    }
}

fn bold(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let first = lines.iter().take_while(|line| !line.is_empty()).count();
    let underlined = |k: usize| lines.get(k + 1).is_some_and(|below| is_rule(below));
    let painted = lines.iter().enumerate().map(|(k, line)| {
        match !line.is_empty() && (k < first || underlined(k)) {
            true => format!("{BOLD}{line}{PLAIN}\n"),
            false => format!("{line}\n"),
        }
    });
    painted.collect()
}

/// A message on stderr, its kind (`warning:`, `error:`) in colour; none that `--quiet` silences.
pub(super) fn worded(text: &str) -> Option<String> {
    let kinds = [
        ("error:", RED, true),
        ("check failed:", RED, true),
        ("warning:", YELLOW, true),
        ("note:", CYAN, false),
        ("next ", CYAN, false),
    ];
    let kind = kinds.iter().find(|(kind, ..)| text.starts_with(kind));
    let heeded = kind.is_some_and(|(.., heeded)| *heeded);
    if manners().quiet && !heeded {
        return None;
    }
    let painted = emphasis(io::stderr().is_terminal());
    Some(match kind.filter(|_| painted) {
        Some((kind, colour, _)) => format!("{colour}{kind}{PLAIN}{}", &text[kind.len()..]),
        None => text.to_string(),
    })
}

/// Progress on the terminal, or in lines, and warnings on stderr.
pub(super) struct Bar {
    bar: ProgressBar,
    /// Where a run says lines, what it said last.
    lines: Option<Lines>,
    start: Instant,
}

impl Bar {
    pub(super) fn new(what: &'static str) -> Bar {
        let bar = ProgressBar::no_length();
        if !io::stderr().is_terminal() || manners().quiet {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        bar.set_style(style(0, None));
        bar.set_message(what);
        let (lines, start) = (None, Instant::now());
        Bar { bar, lines, start }
    }

    /// One of a long run, which says lines where there is no terminal.
    pub(super) fn or_lines(what: &'static str) -> Bar {
        let mut bar = Bar::new(what);
        bar.lines = bar.bar.is_hidden().then(Lines::default);
        bar
    }

    /// Take it off the terminal, before a result is shown.
    pub(super) fn clear(&self) {
        self.bar.finish_and_clear();
    }

    /// Show that so much is done. A bar of length 0 is full, and one without a length says
    /// `0/0`: there is none until it is known how much there is to do.
    pub(super) fn move_to(&self, done: u64, total: Option<u64>) {
        self.bar.set_style(style(done, total));
        match total.filter(|total| *total > 0) {
            Some(total) => self.bar.set_length(total),
            None => self.bar.unset_length(),
        }
        self.bar.set_position(done);
    }
}

fn template(done: u64, total: Option<u64>) -> &'static str {
    match (done, total.filter(|total| *total > 0)) {
        (_, Some(_)) => "{msg} {bar:30} {pos}/{len} ({eta})",
        (0, None) => "{msg} …",
        (_, None) => "{msg} {pos}",
    }
}

fn style(done: u64, total: Option<u64>) -> ProgressStyle {
    ProgressStyle::with_template(template(done, total)).expect("templates are valid")
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.clear();
    }
}

impl Watch for Bar {
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        let lines = self.lines.as_mut();
        if let Some(line) = lines.and_then(|lines| lines.line(progress, self.start.elapsed())) {
            message(&line);
        }
        self.move_to(progress.done, progress.total);
        self.bar.set_message(progress.what);
        ControlFlow::Continue(())
    }

    fn note(&mut self, note: &str) {
        self.bar.suspend(|| message(&format!("note: {note}")));
    }

    fn warning(&mut self, warning: &Message) {
        let warning = format!("warning: {}", warning.worded(option));
        self.bar.suspend(|| message(&warning));
    }
}

/// Lines of a whole run.
const LINES: u64 = 10;
/// Shorter runs say nothing.
const SHORT: Duration = Duration::from_secs(2);

/// What was said last: tenths, what was done, and when.
#[derive(Default)]
struct Lines {
    tenths: u64,
    done: u64,
    at: Duration,
}

impl Lines {
    /// The line that is due after such a time. What is left is taken to go as the last tenth
    /// went: groups that a store knows take no time, and come among others.
    fn line(&mut self, progress: Progress, elapsed: Duration) -> Option<String> {
        let total = progress.total.filter(|total| *total > 0)?;
        let left = total - progress.done.min(total);
        let tenths = LINES * (total - left) / total;
        if tenths <= self.tenths {
            return None;
        }
        let step = (progress.done - self.done).max(1) as f64;
        let each = elapsed.saturating_sub(self.at).div_f64(step);
        (self.tenths, self.done, self.at) = (tenths, progress.done, elapsed);
        let end = match left {
            0 => format!("in {}", HumanDuration(elapsed)),
            _ => format!("about {} left", HumanDuration(each.mul_f64(left as f64))),
        };
        let (what, percent) = (progress.what, 100 * tenths / LINES);
        let line = format!("{what}: {percent} %, {} of {total}, {end}", progress.done);
        (elapsed >= SHORT).then_some(line)
    }
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

    #[test]
    fn there_is_no_bar_until_it_is_known_how_much_there_is_to_do() {
        for (done, total) in [(0, Some(0)), (0, None), (7, None), (7, Some(0))] {
            assert!(!template(done, total).contains("{len}"), "{done} {total:?}");
        }
        assert!(template(0, Some(9)).contains("{pos}/{len}"));
        let bar = Bar::new("reading");
        assert_eq!(bar.bar.length(), None);
        for (done, total, length) in [(0, Some(0), None), (7, None, None), (7, Some(9), Some(9))] {
            bar.move_to(done, total);
            assert_eq!((bar.bar.length(), bar.bar.position()), (length, done));
        }
    }

    /// `Progress` is made by the library alone.
    fn progress(done: u64, total: u64) -> Progress {
        let mut told = None;
        let mut keep = |progress: Progress| {
            told = Some(progress);
            ControlFlow::Continue(())
        };
        sesc_identify::tell(&mut keep, "diagnosing", done, total).unwrap();
        told.unwrap()
    }

    #[test]
    fn a_line_for_each_tenth_says_when_the_run_will_end() {
        let mut lines = Lines::default();
        let mut said = Vec::new();
        for done in 0..=420 {
            // The first half from a store, the rest at ten seconds each.
            let after = Duration::from_secs(10 * u64::saturating_sub(done, 210));
            said.extend(lines.line(progress(done, 420), after));
            assert_eq!(lines.line(progress(done, 420), after), None);
        }
        assert_eq!(
            said,
            [
                "diagnosing: 60 %, 252 of 420, about 28 minutes left",
                "diagnosing: 70 %, 294 of 420, about 21 minutes left",
                "diagnosing: 80 %, 336 of 420, about 14 minutes left",
                "diagnosing: 90 %, 378 of 420, about 7 minutes left",
                "diagnosing: 100 %, 420 of 420, in 35 minutes",
            ]
        );
        assert_eq!(lines.line(progress(1, 0), Duration::from_secs(9)), None);
    }
}
