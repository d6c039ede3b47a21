//! Aligned columns for the command line.
//!
//! A column of numbers is aligned right, any other left; headers follow their
//! column and are underlined.
//!
//! ```text
//! function   mul  worst error, m
//! ─────────  ───  ──────────────
//! com         80         4.4e-16
//! regressor  312         8.9e-16
//! ```

use std::fmt;

use sesc_model::text::{self, minus};

/// Lines of a list, at most, unless all are asked for.
pub const LISTED: usize = 8;

/// Sentences that differ in the `names` of things alone as one that counts and names them; each by
/// itself with `long`.
pub fn gathered(sentences: &[String], long: bool) -> Vec<String> {
    let name = |sentence: &str| sentence.split('`').nth(1).map(str::to_string);
    // Lines of the file and sizes differ from one to the next.
    let kind = |sentence: &str| -> String {
        let bare = sentence.replacen(&name(sentence).unwrap_or_default(), "", 1);
        bare.chars().filter(|c| !c.is_ascii_digit()).collect()
    };
    let mut kinds: Vec<(String, Vec<&String>)> = Vec::new();
    for sentence in sentences {
        let own = (!long && name(sentence).is_some()).then(|| kind(sentence));
        let mut known = kinds.iter_mut();
        match known.find(|(kind, _)| own.as_ref() == Some(kind)) {
            Some((_, alike)) => alike.push(sentence),
            None => kinds.push((own.unwrap_or_default(), vec![sentence])),
        }
    }
    let said = |(_, alike): (String, Vec<&String>)| {
        let others = alike[1..].iter().filter_map(|sentence| name(sentence));
        let others: Vec<String> = others.map(|name| format!("`{name}`")).collect();
        match others.len() {
            0 => alike[0].clone(),
            n => format!(
                "{} of this kind: {}; also {}",
                n + 1,
                alike[0],
                text::listed(others, NAMED)
            ),
        }
    };
    kinds.into_iter().map(said).collect()
}

/// Names of things that a sentence is of, too, at most.
const NAMED: usize = 4;

/// What follows a list of which `count` lines do not stand there.
pub fn and_more(count: usize) -> String {
    match count {
        0 => String::new(),
        _ => format!("and {count} more: --long lists all\n"),
    }
}

/// Lines of a list: as many as there are with `long`.
pub fn listed(lines: &[String], long: bool) -> String {
    let shown = if long { lines.len() } else { LISTED };
    let first = lines.iter().take(shown).map(|line| format!("{line}\n"));
    first.collect::<String>() + &and_more(lines.len().saturating_sub(shown))
}

/// Space between columns.
const GAP: &str = "  ";

/// Rows of text under headers; `Display` aligns them, one line each.
#[derive(Debug, Clone)]
pub struct Table {
    headers: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(headers: &[&str]) -> Table {
        Table {
            headers: headers.iter().map(ToString::to_string).collect(),
            rows: Vec::new(),
        }
    }

    /// A table of these rows.
    pub fn of<const N: usize>(
        headers: &[&str; N],
        rows: impl IntoIterator<Item = [String; N]>,
    ) -> Table {
        let mut table = Table::new(headers);
        for row in rows {
            table.row(&row);
        }
        table
    }

    /// Append a row. Missing cells stay empty; more cells than headers are a mistake.
    pub fn row<S: AsRef<str>>(&mut self, cells: &[S]) -> &mut Table {
        assert!(
            cells.len() <= self.headers.len(),
            "a row of {} cells under {} headers",
            cells.len(),
            self.headers.len()
        );
        let cell = |cell: &S| minus(&one_line(cell.as_ref()));
        let mut row: Vec<String> = cells.iter().map(cell).collect();
        row.resize(self.headers.len(), String::new());
        self.rows.push(row);
        self
    }

    /// The first rows, and how many follow; all of them with `long`.
    pub fn listed(mut self, long: bool) -> String {
        let shown = if long { self.rows.len() } else { LISTED };
        let more = self.rows.len().saturating_sub(shown);
        self.rows.truncate(shown);
        format!("{self}{}", and_more(more))
    }

    /// Width of a column, and whether it is one of numbers.
    fn column(&self, k: usize) -> (usize, bool) {
        let cells = || self.rows.iter().map(|row| row[k].as_str());
        let all = cells().chain([self.headers[k].as_str()]);
        let widest = all.map(|cell| cell.chars().count()).max();
        let is_numeric =
            cells().any(is_number) && cells().all(|cell| cell.is_empty() || is_number(cell));
        (widest.unwrap_or(0), is_numeric)
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns: Vec<_> = (0..self.headers.len()).map(|k| self.column(k)).collect();
        let rules = columns.iter().map(|(width, _)| "─".repeat(*width));
        let rules: Vec<String> = rules.collect();
        for row in [&self.headers, &rules].into_iter().chain(&self.rows) {
            let cells = columns.iter().zip(row);
            let cells = cells.map(|((width, is_numeric), cell)| match is_numeric {
                true => format!("{cell:>width$}"),
                false => format!("{cell:<width$}"),
            });
            let line = cells.collect::<Vec<String>>().join(GAP);
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

fn is_number(cell: &str) -> bool {
    cell == NO_NUMBER || cell.replace('−', "-").parse::<f64>().is_ok()
}

/// Names come from files: a line break in one must not break the row.
fn one_line(cell: &str) -> String {
    cell.replace(char::is_control, " ")
}

/// Shown where a value is not a number.
const NO_NUMBER: &str = "–";

/// A length in millimetres without its unit: hundredths below 10 mm, tenths above.
pub fn mm(metres: f64) -> String {
    let mm = 1e3 * metres;
    if !mm.is_finite() {
        return NO_NUMBER.to_string();
    }
    let digits = if mm.abs() < 9.995 { 2 } else { 1 };
    match format!("{mm:.digits$}").as_str() {
        // A rounding artefact.
        "-0.00" => "0.00".to_string(),
        text => minus(text),
    }
}

/// Names in a column, and what is said of each: a line each.
pub fn lines<'n>(facts: impl IntoIterator<Item = (&'n str, String)>) -> String {
    let line = |(name, text): (&str, String)| format!("{name:<16} {}\n", minus(&text));
    facts.into_iter().map(line).collect()
}

/// Lines of at most a hundred characters, `indent` before all but the first.
pub fn wrapped(text: &str, indent: &str) -> String {
    wrapped_at(text, indent, 97)
}

/// The same with lines of at most `most` letters.
pub fn wrapped_at(text: &str, indent: &str, most: usize) -> String {
    let mut out = String::new();
    let mut length = 0;
    for word in minus(text).split_whitespace() {
        let count = word.chars().count();
        if length > 0 && length + 1 + count > most {
            out.push_str(&format!("\n{indent}"));
            length = 0;
        } else if length > 0 {
            out.push(' ');
            length += 1;
        }
        out.push_str(word);
        length += count;
    }
    out
}

/// A length in hundredths of a millimetre, as columns of numbers have it.
pub fn hundredths(metres: f64) -> String {
    minus(&format!("{:.2}", 1e3 * metres))
}

/// A position of a joint with its unit: degrees, or mm of a prismatic one.
pub fn position(value: f64, is_prismatic: bool) -> String {
    let (value, unit) = match is_prismatic {
        true => (1e3 * value, " mm"),
        false => (value.to_degrees(), "°"),
    };
    minus(&format!("{:.0}{unit}", value.round() + 0.0))
}

/// `1 posture`, `2 postures`.
pub fn count(n: usize, what: &str) -> String {
    match n {
        1 => format!("1 {what}"),
        n => format!("{n} {what}s"),
    }
}

/// `joint offset`: a name of programs as people read it.
pub fn in_words(name: &str) -> String {
    name.replace('_', " ")
}

/// A probability as people read it: `p = 0.37`, and `p < 0.005` where two digits would be zero.
pub fn chance(p: f64) -> String {
    match p < 0.005 {
        true => "p < 0.005".to_string(),
        false => format!("p = {p:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chance_is_never_zero() {
        assert_eq!(
            [0.0, 0.0049, 0.005, 0.372].map(chance),
            ["p < 0.005", "p < 0.005", "p = 0.01", "p = 0.37"]
        );
    }

    #[test]
    fn sentences_of_one_kind_are_one_and_long_lists_are_cut() {
        let of = |name: &str| format!("`{name}` follows `hip`: tied");
        let all: Vec<String> = ["a", "b", "c", "d", "e", "f"].map(of).to_vec();
        let one = "6 of this kind: `a` follows `hip`: tied; also `b`, `c`, `d`, `e` and 1 more";
        assert_eq!(gathered(&all, false), [one]);
        assert_eq!(gathered(&all, true), all);
        let others = ["no name".to_string(), of("a"), "no name".to_string()];
        assert_eq!(gathered(&others, false), others);
        let lines: Vec<String> = (1..=10).map(|k| k.to_string()).collect();
        let cut = "1\n2\n3\n4\n5\n6\n7\n8\nand 2 more: --long lists all\n";
        assert_eq!(listed(&lines, false), cut);
        assert_eq!(listed(&lines, true), lines.join("\n") + "\n");
    }

    #[test]
    fn numbers_align_right_and_names_left() {
        let mut table = Table::new(&["function", "mul", "error, m", ""]);
        table.row(&["com", "80", "4.4e-16", "ok"]);
        table.row(&["com_jacobian", "312", "-1", "FAIL"]);
        assert_eq!(
            table.to_string(),
            "function      mul  error, m\n\
             ────────────  ───  ────────  ────\n\
             com            80   4.4e-16  ok\n\
             com_jacobian  312        −1  FAIL\n"
        );
    }

    #[test]
    fn widths_count_characters_and_missing_cells_stay_empty() {
        let mut table = Table::new(&["joint", "δ, mm"]);
        table.row(&["Hüfte", "1.5"]).row(&["a\nb"]);
        assert_eq!(
            table.to_string(),
            "joint  δ, mm\n─────  ─────\nHüfte    1.5\na b\n"
        );
    }

    #[test]
    #[should_panic(expected = "a row of 2 cells under 1 headers")]
    fn too_many_cells_are_a_mistake() {
        Table::new(&["one"]).row(&["1", "2"]);
    }

    #[test]
    fn millimetres_have_sensible_digits() {
        let shown = [0.00393, 0.0123456, -0.2282, 1e-9, -1e-9, 0.009_999].map(mm);
        assert_eq!(shown, ["3.93", "12.3", "−228.2", "0.00", "0.00", "10.0"]);
        assert_eq!(mm(f64::NAN), NO_NUMBER);
    }
}
