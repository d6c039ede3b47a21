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

    /// Append a row. Missing cells stay empty; more cells than headers are a mistake.
    pub fn row<S: AsRef<str>>(&mut self, cells: &[S]) -> &mut Table {
        assert!(
            cells.len() <= self.headers.len(),
            "a row of {} cells under {} headers",
            cells.len(),
            self.headers.len()
        );
        let mut row: Vec<String> = cells.iter().map(|cell| one_line(cell.as_ref())).collect();
        row.resize(self.headers.len(), String::new());
        self.rows.push(row);
        self
    }

    fn column(&self, k: usize) -> Column {
        let cells = || self.rows.iter().map(|row| row[k].as_str());
        let widest = cells().map(width).max().unwrap_or(0);
        Column {
            width: widest.max(width(&self.headers[k])),
            numeric: cells().any(is_number)
                && cells().all(|cell| cell.is_empty() || is_number(cell)),
        }
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns: Vec<Column> = (0..self.headers.len()).map(|k| self.column(k)).collect();
        let rules: Vec<String> = columns
            .iter()
            .map(|column| "─".repeat(column.width))
            .collect();
        for row in [&self.headers, &rules].into_iter().chain(&self.rows) {
            let cells: Vec<String> = columns
                .iter()
                .zip(row)
                .map(|(column, cell)| column.pad(cell))
                .collect();
            writeln!(f, "{}", cells.join(GAP).trim_end())?;
        }
        Ok(())
    }
}

/// How a column is set.
struct Column {
    width: usize,
    numeric: bool,
}

impl Column {
    fn pad(&self, cell: &str) -> String {
        let space = " ".repeat(self.width - width(cell));
        if self.numeric {
            space + cell
        } else {
            cell.to_string() + &space
        }
    }
}

fn width(cell: &str) -> usize {
    cell.chars().count()
}

fn is_number(cell: &str) -> bool {
    cell == NO_NUMBER || cell.parse::<f64>().is_ok()
}

/// Names come from files: a line break in one must not break the row.
fn one_line(cell: &str) -> String {
    cell.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}

/// Shown where a value is not a number.
const NO_NUMBER: &str = "–";

/// A length in millimetres without its unit: hundredths below 10 mm, tenths above.
pub fn mm(metres: f64) -> String {
    let mm = 1e3 * metres;
    if !mm.is_finite() {
        return NO_NUMBER.to_string();
    }
    let text = if mm.abs() < 9.995 {
        format!("{mm:.2}")
    } else {
        format!("{mm:.1}")
    };
    // -0.00 is a rounding artefact.
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_string(),
        _ => text,
    }
}

/// Names in a column, and what is said of each: a line each.
pub fn lines<'n>(facts: impl IntoIterator<Item = (&'n str, String)>) -> String {
    let line = |(name, text): (&str, String)| format!("{name:<16} {text}\n");
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
    for word in text.split_whitespace() {
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
    fn numbers_align_right_and_names_left() {
        let mut table = Table::new(&["function", "mul", "error, m", ""]);
        table.row(&["com", "80", "4.4e-16", "ok"]);
        table.row(&["com_jacobian", "312", "-1", "FAIL"]);
        assert_eq!(
            table.to_string(),
            "function      mul  error, m\n\
             ────────────  ───  ────────  ────\n\
             com            80   4.4e-16  ok\n\
             com_jacobian  312        -1  FAIL\n"
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
        assert_eq!(shown, ["3.93", "12.3", "-228.2", "0.00", "0.00", "10.0"]);
        assert_eq!(mm(f64::NAN), NO_NUMBER);
    }
}
