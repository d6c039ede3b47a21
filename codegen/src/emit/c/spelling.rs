//! Numbers, strings, comments and names as C writes them.

use super::{Scalar, fixed, float};
use crate::emit::listing::Listing;
use sesc_model::expr::{Argument, Id};

/// Name of an input array in C; `sin` and `cos` belong to the library.
pub(super) fn spelled(argument: Argument) -> &'static str {
    match argument {
        Argument::Sines => "sin_q",
        Argument::Cosines => "cos_q",
        other => other.name(),
    }
}

/// Statements for the arrays that no other reads.
pub(super) fn unread(listing: &Listing) -> Vec<String> {
    let arrays = listing.program.inputs.iter().map(|array| array.argument);
    let unread = arrays.filter(|array| !listing.reads(*array));
    unread
        .map(|array| format!("(void){};", spelled(array)))
        .collect()
}

/// Names of a sine and a cosine; a name for the unused one as well, since the helper writes both.
pub(super) fn pair(listing: &Listing, sin: Option<Id>, cos: Option<Id>) -> [String; 2] {
    let name = |id: Option<Id>| id.and_then(|id| listing.name(id)).map(str::to_string);
    match (name(sin), name(cos)) {
        (Some(s), Some(c)) => [s, c],
        (Some(s), None) => [s.clone(), format!("no_c{}", s.trim_start_matches('s'))],
        (None, Some(c)) => [format!("no_s{}", c.trim_start_matches('c')), c],
        (None, None) => ["no_s".to_string(), "no_c".to_string()],
    }
}

/// A C string literal: printable ASCII as it is, everything else by octal escapes.
pub(super) fn quoted(text: &str) -> String {
    let mut literal = String::from("\"");
    for byte in text.bytes() {
        match byte {
            b'"' | b'\\' => {
                literal.push('\\');
                literal.push(char::from(byte));
            }
            // `??` would begin a trigraph.
            b' '..=b'~' if byte != b'?' => literal.push(char::from(byte)),
            _ => literal.push_str(&format!("\\{byte:03o}")),
        }
    }
    literal.push('"');
    literal
}

/// A value of the scalar, with `bits` fraction bits where it is fixed point.
pub(super) fn number(x: f64, scalar: Scalar, bits: i32) -> String {
    match scalar {
        Scalar::Fixed32 => fixed::literal(x, bits),
        _ => float::literal(x, scalar),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_name_stays_in_its_literal() {
        assert_eq!(quoted("a\"\\?\u{e9}"), "\"a\\\"\\\\\\077\\303\\251\"");
    }
}
