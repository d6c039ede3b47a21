//! Progress of a long run whose stderr is no terminal: a line for each tenth, with an estimate of
//! the end.

use std::time::{Duration, Instant};

use sesc_identify::{Message, Progress, Watch};
use std::ops::ControlFlow;

use super::{Bar, message};

/// Lines of the whole run.
const LINES: u64 = 10;
/// Shorter runs say nothing.
const SHORT: Duration = Duration::from_secs(2);

/// A bar on a terminal, and lines elsewhere.
pub(super) struct BarOrLines {
    pub bar: Bar,
    lines: Lines,
    start: Instant,
}

impl BarOrLines {
    pub(super) fn new(what: &'static str) -> BarOrLines {
        BarOrLines {
            bar: Bar::new(what),
            lines: Lines::default(),
            start: Instant::now(),
        }
    }
}

impl Watch for BarOrLines {
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        if self.bar.0.is_hidden()
            && let Some(line) = self.lines.line(progress, self.start.elapsed())
        {
            message(&line);
        }
        self.bar.progress(progress)
    }

    fn note(&mut self, note: &str) {
        self.bar.note(note);
    }

    fn warning(&mut self, warning: &Message) {
        self.bar.warning(warning);
    }
}

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
        let tenths = LINES * progress.done.min(total) / total;
        if tenths <= self.tenths {
            return None;
        }
        let step = (progress.done - self.done).max(1) as f64;
        let each = elapsed.saturating_sub(self.at).as_secs_f64() / step;
        let left = Duration::from_secs_f64(each * (total - progress.done.min(total)) as f64);
        (self.tenths, self.done, self.at) = (tenths, progress.done, elapsed);
        (elapsed >= SHORT).then(|| {
            let end = match progress.done >= total {
                true => format!("in {}", words(elapsed)),
                false => format!("about {} left", words(left)),
            };
            format!(
                "{}: {} %, {} of {total}, {end}",
                progress.what,
                100 * tenths / LINES,
                progress.done
            )
        })
    }
}

/// `40 s`, `3 min`, `2 h 10 min`.
fn words(time: Duration) -> String {
    let seconds = time.as_secs_f64().round() as u64;
    match seconds {
        0..100 => format!("{seconds} s"),
        100..6000 => format!("{} min", (seconds + 30) / 60),
        _ => format!(
            "{} h {} min",
            (seconds + 30) / 3600,
            (seconds + 30) / 60 % 60
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let seconds = 10 * u64::saturating_sub(done, 210);
            said.extend(lines.line(progress(done, 420), Duration::from_secs(seconds)));
            assert_eq!(
                lines.line(progress(done, 420), Duration::from_secs(seconds)),
                None
            );
        }
        assert_eq!(
            said,
            [
                "diagnosing: 60 %, 252 of 420, about 28 min left",
                "diagnosing: 70 %, 294 of 420, about 21 min left",
                "diagnosing: 80 %, 336 of 420, about 14 min left",
                "diagnosing: 90 %, 378 of 420, about 7 min left",
                "diagnosing: 100 %, 420 of 420, in 35 min",
            ]
        );
        assert_eq!(lines.line(progress(1, 0), Duration::from_secs(9)), None);
    }

    #[test]
    fn times_are_said_in_one_or_two_units() {
        let said = [3, 99, 100, 5999, 7800].map(|s| words(Duration::from_secs(s)));
        assert_eq!(said, ["3 s", "99 s", "2 min", "100 min", "2 h 10 min"]);
    }
}
