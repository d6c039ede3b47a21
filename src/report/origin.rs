//! Where a page comes from: robot, data, when they were recorded, and the command that makes the
//! page again. Nothing of it is taken from a clock.

use minijinja::context;
use minijinja::value::{Serde, Value};
use sesc_identify::diagnose::Diagnosis;
use sesc_identify::fit::Identification;
use sesc_model::ModelFile;

/// Times (s) from here on are counted from 1970, which logs of a stopwatch never reach; later
/// ones are no times.
const EPOCH_S: [f64; 2] = [1e9, 1e11];

/// What a page is made of.
#[derive(Default)]
pub struct Origin<'a> {
    /// Name of the robot, and the hash of its URDF.
    pub robot: [&'a str; 2],
    /// Logs, with the hash of each.
    pub logs: Vec<Value>,
    /// First and last `t` of the logs, s.
    pub times: Option<[f64; 2]>,
    /// The command that makes the page again; empty from the library.
    pub command: &'a str,
}

impl<'a> Origin<'a> {
    /// Of a fit.
    pub fn of_fit(found: &'a Identification, command: &'a str) -> Origin<'a> {
        let times = found.data.iter().filter_map(|log| log.times);
        Origin {
            robot: [&found.robot, &found.hash],
            logs: found
                .data
                .iter()
                .map(|log| Value::from(Serde(log)))
                .collect(),
            times: times.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]),
            command,
        }
    }

    /// Of a diagnosis; `made` says of which robot and data it is.
    pub fn of_diagnosis(found: &Diagnosis, made: &'a ModelFile, command: &'a str) -> Origin<'a> {
        Origin {
            robot: [&made.robot, &made.hash],
            logs: made
                .data
                .iter()
                .map(|log| Value::from(Serde(log)))
                .collect(),
            times: found.times,
            command,
        }
    }

    /// What `origin.html` and `again.html` take.
    pub fn context(&self) -> Value {
        context! {
            robot => self.robot[0],
            hash => self.robot[1],
            logs => &self.logs,
            recorded => self.times.and_then(recorded),
            command => self.command,
        }
    }
}

/// First and last time as dates, where they are counted from 1970.
pub(super) fn recorded(times: [f64; 2]) -> Option<String> {
    let [first, last] = times;
    let known = |t: f64| (EPOCH_S[0]..EPOCH_S[1]).contains(&t);
    (known(first) && known(last)).then(|| format!("{} to {} UTC", date(first), date(last)))
}

/// `2031-05-01 09:30` of seconds since 1970: the civil calendar, counted in eras of 400 years
/// that begin in March.
fn date(seconds: f64) -> String {
    let minutes = (seconds / 60.0).floor() as i64;
    let (days, minute) = (minutes.div_euclid(1440), minutes.rem_euclid(1440));
    let from_era = days + 719_468;
    let (era, day) = (from_era.div_euclid(146_097), from_era.rem_euclid(146_097));
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * march + 2) / 5 + 1;
    let month = if march < 10 { march + 3 } else { march - 9 };
    let year = year + 400 * era + i64::from(month <= 2);
    format!(
        "{year}-{month:02}-{day:02} {:02}:{:02}",
        minute / 60,
        minute % 60
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dates that `date --utc --date=@SECONDS` gives.
    #[test]
    fn seconds_since_1970_are_dates() {
        for (seconds, expected) in [
            (1_000_000_000.0, "2001-09-09 01:46"),
            (951_782_400.0, "2000-02-29 00:00"),
            (1_709_251_199.9, "2024-02-29 23:59"),
            (1_735_689_600.0, "2025-01-01 00:00"),
            (4_107_542_400.0, "2100-03-01 00:00"),
        ] {
            assert_eq!(date(seconds), expected);
        }
    }

    #[test]
    fn a_stopwatch_gives_no_date() {
        assert_eq!(recorded([0.0, 120.0]), None);
        assert_eq!(recorded([f64::NAN, 1.7e9]), None);
        assert_eq!(recorded([0.0, 1.7e9]), None);
        let said = recorded([1_000_000_000.0, 1_000_000_060.0]);
        assert_eq!(said.unwrap(), "2001-09-09 01:46 to 2001-09-09 01:47 UTC");
    }
}
