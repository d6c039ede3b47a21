//! What the names of a package may begin with.

use crate::emit::names;

/// Longest prefix: macros with it stay distinct in C99's 63 characters.
const LONGEST: usize = 32;

/// Headers of the C library: a file of that name would stand in their way.
const HEADERS: [&str; 24] = [
    "assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits",
    "locale", "math", "setjmp", "signal", "stdarg", "stdbool", "stddef", "stdint", "stdio",
    "stdlib", "string", "tgmath", "time", "wchar", "wctype",
];

/// Whether `name` serves as a prefix of C and C++ names, and of files.
pub fn is_prefix(name: &str) -> bool {
    name.len() <= LONGEST
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
        && !names::is_device(name)
        && !HEADERS.contains(&name.to_lowercase().as_str())
}

/// A name like `name` that serves.
pub fn suggest(name: &str) -> String {
    let mut word = names::module(name);
    while word.contains("__") {
        word = word.replace("__", "_");
    }
    word.truncate(LONGEST);
    let word = word.trim_end_matches('_');
    match is_prefix(word) {
        true => word.to_string(),
        false => format!("{word}_robot"),
    }
}
