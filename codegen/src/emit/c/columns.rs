//! Lines of at most [`WIDTH`] columns.
//!
//! Code is broken before an operator or after a comma, where few parentheses are
//! open; a comment between two words. Only white space changes.

/// Most columns of a line of generated C.
const WIDTH: usize = 100;

/// Columns that what follows a break is indented further by.
const STEP: usize = 4;

/// `text` with every longer line broken. A line without a place to break stays.
pub(super) fn fitted(text: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    let mut in_comment = false;
    for line in text.lines() {
        let start = line.trim_start();
        let is_comment = in_comment || start.starts_with("/*");
        in_comment = match (line.rfind("/*"), line.rfind("*/")) {
            (Some(open), Some(close)) => open > close,
            (Some(_), None) => true,
            (None, Some(_)) => false,
            (None, None) => in_comment,
        };
        match (line.len() <= WIDTH || start.starts_with('#'), is_comment) {
            (true, _) => lines.push(line.to_string()),
            (false, true) => prose(line, &mut lines),
            (false, false) => code(line, &mut lines),
        }
    }
    lines.join("\n") + "\n"
}

/// Values of an array, as many to a line as fit.
pub(super) fn filled(values: &[String]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for value in values {
        match lines.last_mut() {
            // Behind the last value stands a comma too.
            Some(line) if STEP + line.len() + 2 + value.len() < WIDTH => {
                line.push_str(", ");
                line.push_str(value);
            }
            _ => lines.push(value.clone()),
        }
    }
    lines
}

fn indent(line: &str) -> usize {
    line.len() - line.trim_start().len()
}

/// A line of a comment, broken between words; an `@param` hangs.
fn prose(line: &str, lines: &mut Vec<String>) {
    let start = line.trim_start();
    let margin = indent(line) + usize::from(start.starts_with('/'));
    let text = start.trim_start_matches(['/', '*']);
    let hang = indent(text)
        + if text.trim_start().starts_with('@') {
            STEP
        } else {
            0
        };
    let before = format!("{:margin$}*{:hang$}", "", "", hang = hang.max(1));
    let mut rest = line.to_string();
    while rest.len() > WIDTH {
        let first = indent(&rest) + before.trim_start().len() + 1;
        // The end of the comment stays with its last word.
        let spaces = rest.match_indices(' ').map(|(at, _)| at);
        let spaces = spaces.filter(|at| *at > first && !rest[*at..].starts_with(" */"));
        let Some(at) = spaces
            .clone()
            .rfind(|at| *at <= WIDTH)
            .or(spaces.clone().next())
        else {
            break;
        };
        lines.push(rest[..at].trim_end().to_string());
        rest = before.clone() + rest[at..].trim_start();
    }
    lines.push(rest);
}

/// A line of code, broken where it costs least.
fn code(line: &str, lines: &mut Vec<String>) {
    let margin = indent(line) + STEP;
    let mut rest = line.to_string();
    while rest.len() > WIDTH {
        let breaks = breaks(&rest);
        let fits = breaks.iter().filter(|place| place.at <= WIDTH);
        let Some(best) = fits.min_by_key(|place| place.cost).or(breaks.first()) else {
            break;
        };
        lines.push(rest[..best.at].to_string());
        rest = format!("{:margin$}{}", "", rest[best.at..].trim_start());
    }
    lines.push(rest);
}

/// Where a line may end.
struct Break {
    at: usize,
    cost: usize,
}

const PER_PARENTHESIS: usize = 40;
/// What a break after a comma costs more than one before an operator.
const COMMA: usize = 10;
const ASSIGNMENT: usize = 60;
/// After the parenthesis of a call, and between two words: where there is nothing else.
const CALL: usize = 200;
const WORD: usize = 400;
/// So little left for the next line that it looks lost, and what that costs.
const LITTLE: usize = 12;
const LOST: usize = 30;

fn breaks(line: &str) -> Vec<Break> {
    let bytes = line.as_bytes();
    let mut found = Vec::new();
    // What was open before the line: it closes more than it opens.
    let mut depth: isize = 0;
    let mut depths = Vec::new();
    let (mut quoted, mut escaped) = (false, false);
    for (at, &byte) in bytes.iter().enumerate() {
        if quoted {
            quoted = byte != b'"' || escaped;
            escaped = byte == b'\\' && !escaped;
            continue;
        }
        match byte {
            b'"' => quoted = true,
            b'(' | b'[' | b'{' => {
                depth += 1;
                let call = at > 0 && byte == b'(' && bytes[at - 1].is_ascii_alphanumeric();
                // Not where nothing is passed.
                if call && bytes.get(at + 1) != Some(&b')') {
                    depths.push((at + 1, depth));
                }
            }
            b')' | b']' | b'}' => depth -= 1,
            b' ' if at > indent(line) => depths.push((at, depth)),
            _ => {}
        }
        if bytes[at..].starts_with(b"/*") {
            break;
        }
    }
    let lowest = depths.iter().map(|(_, depth)| *depth).min().unwrap_or(0);
    for (at, depth) in depths {
        let next = line[at..]
            .trim_start()
            .split(' ')
            .next()
            .unwrap_or_default();
        let kind = match (bytes[at - 1], next) {
            (b'(', _) => CALL,
            (_, "{" | "=") => continue,
            (_, "+" | "-" | "*" | "/" | "?" | ":" | "&&" | "||" | "|" | "&" | "^" | "/*") => 0,
            // The last argument of a call, in one word.
            (b',', next) if next.contains(')') => COMMA + LOST,
            (b',', _) => COMMA,
            (b'=', _) => ASSIGNMENT,
            // An operator stays with its right operand.
            (b'+' | b'-' | b'*' | b'/' | b'?' | b':' | b'&' | b'|' | b'^', _) => continue,
            _ => WORD,
        };
        let lost = if line.len() - at <= LITTLE { LOST } else { 0 };
        let empty = WIDTH.saturating_sub(at) / 2;
        let open = depth.abs_diff(lowest);
        found.push(Break {
            at,
            cost: open * PER_PARENTHESIS + kind + lost + empty,
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All but white space and the stars of continued comments.
    fn letters(text: &str) -> String {
        let words = text.split_whitespace().filter(|word| *word != "*");
        words.collect()
    }

    #[track_caller]
    fn check(long: &str, expected: &str) {
        let found = fitted(long);
        assert_eq!(found, expected);
        assert_eq!(letters(&found), letters(long));
        assert!(found.lines().all(|line| line.len() <= WIDTH));
    }

    #[test]
    fn sums_are_broken_before_their_addends() {
        check(
            "    const int32_t v_l_knee_x = op2_narrow(op2_shift_up(r[25], 30u) + ((int64_t)c_l_ank_pitch * r[27]) + ((int64_t)s_l_ank_pitch * v_l_ank_pitch_y), 30u);\n",
            "    const int32_t v_l_knee_x = op2_narrow(op2_shift_up(r[25], 30u)\n        \
             + ((int64_t)c_l_ank_pitch * r[27]) + ((int64_t)s_l_ank_pitch * v_l_ank_pitch_y), 30u);\n",
        );
    }

    #[test]
    fn calls_without_another_place_are_broken_after_their_parenthesis() {
        let name = "a_prefix_as_long_as_a_prefix_may_be";
        let call = format!("{name}_narrow((int64_t){name}_narrow((int64_t)s_right_ankle_roll");
        check(
            &format!("        - {call} * x, 30u) * y, 30u);\n"),
            &format!(
                "        - {name}_narrow(\n            \
                 (int64_t){name}_narrow((int64_t)s_right_ankle_roll\n            \
                 * x, 30u) * y, 30u);\n"
            ),
        );
    }

    #[test]
    fn declarations_and_comments_are_broken_between_words() {
        let (long, name) = ("a".repeat(50), "b".repeat(60));
        check(
            &format!("extern const {long} {name}[2];\n"),
            &format!("extern const {long}\n    {name}[2];\n"),
        );
        check(
            &format!("/** {long} {name} */\n"),
            &format!("/** {long}\n * {name} */\n"),
        );
        check(
            &format!("/*\n * @param[in] q {long} {name}\n */\n"),
            &format!("/*\n * @param[in] q {long}\n *     {name}\n */\n"),
        );
    }

    #[test]
    fn what_cannot_be_broken_stays() {
        let name = "c c".repeat(60);
        for line in [format!("    \"{name}\",\n"), format!("#error \"{name}\"\n")] {
            assert_eq!(fitted(&line), line);
        }
    }

    #[test]
    fn arrays_are_filled() {
        let values: Vec<String> = (1000..1040).map(|k| k.to_string()).collect();
        let lines = filled(&values);
        assert_eq!(lines.join(", "), values.join(", "));
        assert!(lines.iter().all(
            |line| (80..WIDTH - STEP).contains(&line.len()) || *line == lines[lines.len() - 1]
        ));
    }
}
