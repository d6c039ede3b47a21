//! Days put together in windows of several.
//!
//! ```text
//! window(d) = ⌊(d − d_0) / N⌋      d_0: Monday 1970-01-05 for dates, 1 for numbered days
//! ```
//!
//! A window begins where the calendar says and not where logs begin: which days a fleet has
//! moves none, and windows of 7 days begin on Mondays.

use std::num::NonZeroU32;

use sesc_model::text::visible;

use super::input::Input;
use crate::{Error, Setting, message};

/// Days from 1970-01-01 to the Monday after it.
const MONDAY: i64 = 4;
/// Number of the first day, where days are numbered.
const FIRST: i64 = 1;

/// What a day is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Day {
    /// `2031-05-01`, `20310501`, `2031-05-01 00:00`: days since 1970-01-01.
    Date(i64),
    /// `12`: its number.
    Number(i64),
}

/// The inputs with the first day of its window for each day; windows are of so many days.
///
/// ```
/// use std::collections::BTreeMap;
/// use std::num::NonZeroU32;
/// use sesc_identify::fleet::{Input, windows};
///
/// let by = ["robot".to_string(), "day".to_string()];
/// let input = |path: &str| Input::new(path.into(), &BTreeMap::new(), &by);
/// // A Thursday and the Sunday after it.
/// let days = vec![input("r17_2031-05-01.csv"), input("r17_2031-05-04.csv")];
/// let weeks = windows(days, NonZeroU32::new(7).unwrap())?;
/// assert!(weeks.iter().all(|input| input.day == "2031-04-28"));
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// When a day is neither a date (`2031-05-01`, `20310501`) nor a number.
pub fn windows(inputs: Vec<Input>, days: NonZeroU32) -> Result<Vec<Input>, Error> {
    let mut inputs = inputs;
    for input in &mut inputs {
        input.day = match first_day(&input.day, days.get().into()) {
            Some(first) => first,
            None => {
                let day = match input.day.as_str() {
                    "" => "it has no day".to_string(),
                    day => format!("its day is `{}`", visible(day)),
                };
                return Err(Error::request(message![
                    Setting::Window,
                    format!(
                        " puts days together, and {day} ({}); give dates such as 2031-05-01, or \
                         numbers",
                        visible(&input.path.display().to_string())
                    )
                ]));
            }
        };
    }
    Ok(inputs)
}

/// The first day of the window that a day is in: a number, or a date as `2031-04-28` however the
/// day is written, so that a window has one name.
fn first_day(day: &str, days: i64) -> Option<String> {
    let window = |day: i64, origin: i64| (day - origin).div_euclid(days) * days + origin;
    Some(match day_of(day)? {
        Day::Number(number) => window(number, FIRST).to_string(),
        Day::Date(day) => {
            let (year, month, day) = date(window(day, MONDAY));
            format!("{year:04}-{month:02}-{day:02}")
        }
    })
}

fn day_of(text: &str) -> Option<Day> {
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let date = |year: &str, month: &str, day: &str| -> Option<i64> {
        let parts = [(year, 4), (month, 2), (day, 2)];
        let fits = parts
            .iter()
            .all(|(part, count)| part.len() == *count && is_digits(part));
        let [year, month, day] = parts.map(|(part, _)| part.parse::<i64>().ok());
        fits.then(|| days_since_1970(year?, month?, day?))?
    };
    // A time of the day behind a date is that of the day.
    let text = match text.split_once([' ', 'T']) {
        Some((date, time)) if time.starts_with(|c: char| c.is_ascii_digit()) => date,
        _ => text,
    };
    let mut parts = text.split('-');
    if let (Some(year), Some(month), Some(day), None) =
        (parts.next(), parts.next(), parts.next(), parts.next())
    {
        return date(year, month, day).map(Day::Date);
    }
    if !is_digits(text) {
        return None;
    }
    let packed = match (text.get(..4), text.get(4..6), text.get(6..)) {
        (Some(year), Some(month), Some(day)) => date(year, month, day),
        _ => None,
    };
    // Nobody numbers days up to twenty million.
    match packed {
        Some(day) => Some(Day::Date(day)),
        None => text
            .parse::<u32>()
            .ok()
            .map(|number| Day::Number(number.into())),
    }
}

/// Days of a date of the Gregorian calendar since 1970-01-01; none of dates that are none.
fn days_since_1970(year: i64, month: i64, day: i64) -> Option<i64> {
    let valid = (1..=12).contains(&month) && (1..=31).contains(&day);
    // Years begin in March here, so that the odd day is their last.
    let (of_year, month) = match month > 2 {
        true => (year, month - 3),
        false => (year - 1, month + 9),
    };
    let (era, year) = (of_year.div_euclid(400), of_year.rem_euclid(400));
    let of_year = (153 * month + 2) / 5 + day - 1;
    let of_era = 365 * year + year / 4 - year / 100 + of_year;
    let days = 146_097 * era + of_era - 719_468;
    let own = (year + 400 * era, month, day);
    let (y, m, d) = date(days);
    let again = match m > 2 {
        true => (y, m - 3, d),
        false => (y - 1, m + 9, d),
    };
    // The 31st of a month of 30 days is another date.
    (valid && own == again).then_some(days)
}

/// Year, month and day of so many days since 1970-01-01.
fn date(days: i64) -> (i64, i64, i64) {
    let days = days + 719_468;
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let year = year + 400 * era;
    match month < 10 {
        true => (year, month + 3, day),
        false => (year + 1, month - 9, day),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_begin_where_the_calendar_says() {
        let first = |day: &str, days: i64| first_day(day, days).unwrap_or_default();
        // 2031-05-05 is a Monday.
        for (day, monday) in [
            ("2031-05-04", "2031-04-28"),
            ("2031-05-05", "2031-05-05"),
            ("2031-05-11", "2031-05-05"),
            ("20310511", "2031-05-05"),
            ("2031-05-11 00:00", "2031-05-05"),
            ("2031-05-11T23:59:59Z", "2031-05-05"),
            ("1970-01-01", "1969-12-29"),
            ("2032-03-01", "2032-03-01"),
            ("2032-02-29", "2032-02-23"),
        ] {
            assert_eq!(first(day, 7), monday, "{day}");
        }
        assert_eq!(first("2031-05-04", 1), "2031-05-04");
        for (day, window) in [
            ("1", "1"),
            ("7", "1"),
            ("8", "8"),
            ("014", "8"),
            ("0", "-6"),
        ] {
            assert_eq!(first(day, 7), window, "{day}");
        }
        for day in [
            "",
            "monday",
            "2031-02-29",
            "2031-13-01",
            "2031-5-1",
            "1-2-3-4",
            "ä1",
            "2031-05-01 noon",
        ] {
            assert_eq!(first_day(day, 7), None, "{day}");
        }
    }

    #[test]
    fn every_day_of_four_centuries_has_its_date() {
        for days in -146_097..146_097 {
            let (year, month, day) = date(days);
            assert_eq!(days_since_1970(year, month, day), Some(days));
        }
        assert_eq!(days_since_1970(2000, 3, 1), Some(11_017));
    }
}
