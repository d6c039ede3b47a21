//! Text that fits the terminal: the last column of a table and long sentences are wrapped.

use std::io::IsTerminal as _;

/// What is wrapped keeps at least so many characters a line.
const LEAST: usize = 20;
/// A last column without so much room goes into lines of its own, behind so many blanks.
const INDENT: usize = 4;

/// The width of the terminal that shows results; none where none does.
pub(super) fn of_terminal() -> Option<usize> {
    if !std::io::stdout().is_terminal() {
        return None;
    }
    terminal_size::terminal_size().map(|(width, _)| usize::from(width.0))
}

/// Lines of at most `width` characters, where they can be broken: those of a table go on below
/// its last column, others below their first word.
pub(super) fn fitted(text: &str, width: usize) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let mut last_column = None;
    let mut out = String::with_capacity(text.len() + 64);
    for (k, line) in lines.iter().enumerate() {
        if line.is_empty() {
            last_column = None;
        } else if let Some(rule) = lines.get(k + 1).filter(|below| is_rule(below)) {
            last_column = Some(start_of_last(rule));
        }
        match (last_column, is_rule(line)) {
            (Some(_), true) => out.extend(line.chars().take(width)),
            (Some(start), false) => wrap(line, start, width, &mut out),
            (None, _) => wrap(line, line.len() - line.trim_start().len(), width, &mut out),
        }
        out.push('\n');
    }
    out
}

/// The line under the headers of a table.
fn is_rule(line: &str) -> bool {
    line.starts_with('─') && line.chars().all(|c| "─ ".contains(c))
}

/// Where the last column of a table begins, in characters.
fn start_of_last(rule: &str) -> usize {
    let marks: Vec<char> = rule.trim_end().chars().collect();
    marks.iter().rposition(|c| *c == ' ').map_or(0, |k| k + 1)
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
    fn no_word_is_lost_and_indented_lines_stay_so() {
        let text = "  joint  the axis of l_knee moves to its parent  and more of it\n";
        for width in 20..70 {
            let fitted = fitted(text, width);
            let words = |text: &str| {
                text.split_whitespace()
                    .map(str::to_string)
                    .collect::<Vec<_>>()
            };
            assert_eq!(words(&fitted), words(text), "{width}");
            for line in fitted.lines() {
                assert!(line.starts_with("  ") && line.chars().count() <= width);
            }
        }
    }
}
