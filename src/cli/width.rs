//! Text that fits the terminal: the last column of a table and long sentences are wrapped.

use std::io::IsTerminal as _;

/// What is wrapped keeps at least so many characters a line.
const LEAST: usize = 20;
/// A last column without so much room goes into lines of its own, behind so many blanks.
const INDENT: usize = 4;
/// Blanks between columns.
const GAP: usize = 2;

/// The width of the terminal that shows results; none where none does.
pub(super) fn of_terminal() -> Option<usize> {
    if !std::io::stdout().is_terminal() {
        return None;
    }
    terminal_size::terminal_size().map(|(width, _)| usize::from(width.0))
}

/// Lines of at most `width` characters, where they can be broken: rows of a table go on below
/// their last column, or below themselves where a column before it is too far right; other lines
/// below their first word.
pub(super) fn fitted(text: &str, width: usize) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let mut columns = Vec::new();
    let mut out = String::with_capacity(text.len() + 64);
    for (k, line) in lines.iter().enumerate() {
        if line.is_empty() {
            columns.clear();
        } else if let Some(rule) = lines.get(k + 1).filter(|below| is_rule(below)) {
            columns = starts(rule);
        }
        match (columns.is_empty(), is_rule(line)) {
            (false, true) => {
                out.extend(line.chars().take(width));
                out.truncate(out.trim_end_matches(' ').len());
            }
            (false, false) => row(line, &columns, width, &mut out),
            (true, _) => wrap(line, line.len() - line.trim_start().len(), width, &mut out),
        }
        out.push('\n');
    }
    out
}

/// The line under the headers of a table.
pub(super) fn is_rule(line: &str) -> bool {
    line.starts_with('─') && line.chars().all(|c| "─ ".contains(c))
}

/// Where the columns of a table begin, in characters.
fn starts(rule: &str) -> Vec<usize> {
    let marks: Vec<char> = rule.chars().collect();
    let begins = |k: &usize| marks[*k] != ' ' && (*k == 0 || marks[*k - 1] == ' ');
    (0..marks.len()).filter(begins).collect()
}

/// A row of a table: what follows the columns that have room is wrapped.
fn row(line: &str, columns: &[usize], width: usize, out: &mut String) {
    let ends = columns.iter().skip(1).map(|next| next - GAP);
    let fitting = ends.take_while(|end| *end <= width).count();
    let last = columns.len() - 1;
    if fitting >= last || line.chars().count() <= width {
        wrap(line, columns[last], width, out);
        return;
    }
    let at = |k: usize| {
        let at = line.char_indices().nth(columns[k]);
        at.map_or(line.len(), |(at, _)| at)
    };
    let cells = (fitting..=last).map(|k| {
        let end = if k == last { line.len() } else { at(k + 1) };
        line[at(k)..end].trim()
    });
    let cells: Vec<&str> = cells.filter(|cell| !cell.is_empty()).collect();
    let cells = cells.join(&" ".repeat(GAP));
    out.push_str(line[..at(fitting)].trim_end());
    out.push('\n');
    wrap(&format!("{:INDENT$}{cells}", ""), INDENT, width, out);
}

/// A line whose words behind `indent` characters are wrapped there, or below it where there is
/// no room.
fn wrap(line: &str, indent: usize, width: usize, out: &mut String) {
    if line.chars().count() <= width {
        out.push_str(line);
        return;
    }
    let at = line.char_indices().nth(indent);
    let (head, rest) = line.split_at(at.map_or(line.len(), |(at, _)| at));
    // A word that is longer than the column has more room below its row.
    let longest = rest.split_whitespace().map(|word| word.chars().count());
    let least = LEAST.max(longest.max().unwrap_or(0));
    let indent = match width < indent + least && !head.trim().is_empty() {
        true => {
            out.push_str(head.trim_end());
            out.push('\n');
            out.extend(std::iter::repeat_n(' ', INDENT));
            INDENT
        }
        false => {
            out.push_str(head);
            indent
        }
    };
    let mut length = indent;
    // Blanks between words stay, but for those at the end of a line.
    for piece in rest.split_inclusive(' ') {
        let word = piece.trim_end().chars().count();
        if length > indent && length + word > width {
            out.truncate(out.trim_end().len());
            out.push('\n');
            out.extend(std::iter::repeat_n(' ', indent));
            length = indent;
        }
        out.push_str(piece);
        length += piece.chars().count();
    }
    out.truncate(out.trim_end().len());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_column_goes_on_below_itself() {
        let text = "effect  what it is\n\
                    ──────  ───────────────────────────────────────\n\
                    offset  the encoder of a joint is off by a constant\n\
                    swap    two joints\n\
                    \n\
                    A sentence of more than thirty characters.\n";
        let expected = "effect  what it is\n\
                        ──────  ──────────────────────\n\
                        offset  the encoder of a joint\n        \
                        is off by a constant\n\
                        swap    two joints\n\
                        \n\
                        A sentence of more than thirty\n\
                        characters.\n";
        assert_eq!(fitted(text, 30), expected);
        assert_eq!(fitted(text, 100), text);
        let long = "at    imitated by\n\
                    ────  ───────────────────────────────\n\
                    knee  a_word_of_twenty_four_ch and more\n";
        let below = "at    imitated by\n\
                     ────  ──────────────────────\n\
                     knee\n    \
                     a_word_of_twenty_four_ch\n    \
                     and more\n";
        assert_eq!(fitted(long, 28), below);
        // No room for a column: it goes below its row.
        let narrow = "effect  what it is\n\
                      ──────  ────────────\n\
                      offset\n    \
                      the encoder of a\n    \
                      joint is off by\n    \
                      a constant\n\
                      swap    two joints\n\
                      \n\
                      A sentence of more\n\
                      than thirty\n\
                      characters.\n";
        assert_eq!(fitted(text, 20), narrow);
    }

    #[test]
    fn a_table_whose_columns_have_no_room_goes_on_below_its_rows() {
        let text = "body   carried by  r_i, mm\n\
                    ─────  ──────────  ───────────\n\
                    torso  pelvis      1.5 2.5 3.5\n\
                    head   torso\n";
        let expected = "body   carried by\n    \
                        r_i, mm\n\
                        ─────  ──────────\n\
                        torso  pelvis\n    \
                        1.5 2.5 3.5\n\
                        head   torso\n";
        assert_eq!(fitted(text, 18), expected);
        let wide = "a  bb  c\n─  ──  ─────\n1  22  three four five\n";
        for (text, width) in [(text, 12), (wide, 14)] {
            let narrow = fitted(text, width);
            let mut lines = narrow.lines();
            assert!(lines.all(|line| line.chars().count() <= width), "{narrow}");
        }
    }

    #[test]
    fn no_word_is_lost_and_indented_lines_stay_so() {
        let text = "  joint  the axis of l_knee moves to its parent  and more of it\n";
        for width in 20..70 {
            let fitted = fitted(text, width);
            let words = fitted.split_whitespace();
            assert!(words.eq(text.split_whitespace()), "{width}");
            for line in fitted.lines() {
                assert!(line.starts_with("  ") && line.chars().count() <= width);
            }
        }
    }
}
