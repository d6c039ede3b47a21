//! What the names of a package may begin with.

use crate::emit::names::{self, Naming};
use crate::error::Problem;

/// Headers of the C library: a file of that name would stand in their way.
const HEADERS: [&str; 24] = [
    "assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits",
    "locale", "math", "setjmp", "signal", "stdarg", "stdbool", "stddef", "stdint", "stdio",
    "stdlib", "string", "tgmath", "time", "wchar", "wctype",
];

/// Prefixes of C and C++ names, and of files.
///
/// Symbols are as long as they come out: compilers and linkers tell them apart by all of their
/// characters, as macros of joints already need.
pub(crate) const PREFIX: Naming = Naming {
    word: |name| {
        let mut word = names::module(name);
        while word.contains("__") {
            word = word.replace("__", "_");
        }
        word
    },
    is_spelled: |name| {
        names::is_identifier(name)
            && !name.contains("__")
            && !name.ends_with('_')
            && !HEADERS.contains(&name.to_lowercase().as_str())
    },
    refused: |name, suggestion| Problem::BadPrefix { name, suggestion },
};

/// A prefix like `name` that serves.
pub fn suggest(name: &str) -> String {
    PREFIX.suggest(name)
}
