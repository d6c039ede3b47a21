//! What the names of a package may begin with.

use crate::emit::names::{self, LONGEST};
use sesc_model::names::cut;

/// Headers of the C library: a file of that name would stand in their way.
const HEADERS: [&str; 24] = [
    "assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits",
    "locale", "math", "setjmp", "signal", "stdarg", "stdbool", "stddef", "stdint", "stdio",
    "stdlib", "string", "tgmath", "time", "wchar", "wctype",
];

/// Whether `name` serves as a prefix of C and C++ names, and of files.
///
/// Symbols are as long as they come out: compilers and linkers tell them apart by all of their
/// characters, as macros of joints already need.
pub fn is_prefix(name: &str) -> bool {
    name.len() <= LONGEST && is_spelled(name)
}

/// Whether `name` is a prefix but for its length.
fn is_spelled(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
        && !names::is_device(name)
        && !HEADERS.contains(&name.to_lowercase().as_str())
}

/// The prefix of what is called `name`, whole however long it is: a part of it might be that of
/// another robot or support.
pub fn whole(name: &str) -> String {
    let mut word = names::module(name);
    while word.contains("__") {
        word = word.replace("__", "_");
    }
    match is_spelled(&word) {
        true => word,
        false => format!("{word}_robot"),
    }
}

/// A name like `name` that serves.
pub fn suggest(name: &str) -> String {
    cut(&whole(name), LONGEST)
}
