//! Identifiers from the names of links and joints.
//!
//! URDF names hold dots, slashes, hyphens, spaces and letters of any script.
//! Generated names use ASCII letters, digits and `_` only; names that collide
//! after conversion are numbered in document order.

use crate::Error;
use crate::error::Problem;
use sesc_model::names::{cut, word};

/// `op2_r_sole` for a module, from words of any kind.
pub fn module(name: &str) -> String {
    let mut word = word(name).to_lowercase();
    if word.starts_with(|c: char| c.is_ascii_digit()) {
        word.insert_str(0, "robot_");
    }
    word
}

/// `Op2RSole` for a type, from a module name.
pub fn type_name(module: &str) -> String {
    module
        .split('_')
        .filter(|part| !part.is_empty())
        .map(|part| {
            let mut letters = part.chars();
            let first = letters.next().map(|c| c.to_ascii_uppercase());
            first.into_iter().chain(letters).collect::<String>()
        })
        .collect()
}

/// Longest name: files of it can be had in every file system, with the ends that layouts add.
pub const LONGEST: usize = 100;

/// Names of generated items that a module's type must not take.
const TAKEN: [&str; 3] = ["Real", "DOF", "PRISMATIC"];

/// Whether `name` serves as a module and its type serves beside what is in it.
pub fn is_module_name(name: &str) -> bool {
    name.len() <= LONGEST && is_spelled(name)
}

/// Whether `name` is a module's but for its length.
fn is_spelled(name: &str) -> bool {
    !is_device(name)
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && syn::parse_str::<syn::Ident>(name).is_ok()
        && !TAKEN.contains(&type_name(name).as_str())
}

/// Whether Windows takes a file of this name for a device, whatever its end.
pub(crate) fn is_device(name: &str) -> bool {
    let name = name.to_lowercase();
    let numbered = |kind: &str| {
        let number = name.strip_prefix(kind);
        number.is_some_and(|n| matches!(n.as_bytes(), [b'0'..=b'9']))
    };
    matches!(&*name, "con" | "prn" | "aux" | "nul") || numbered("com") || numbered("lpt")
}

/// The module of what is called `name`, whole however long it is: a part of it might be that of
/// another robot or support.
pub fn whole(name: &str) -> String {
    let word = module(name);
    match is_spelled(&word) {
        true => word,
        false => format!("{word}_robot"),
    }
}

/// A name like `name` that serves.
pub fn suggest(name: &str) -> String {
    cut(&whole(name), LONGEST)
}

/// Refuses a name that is too long for files.
///
/// # Errors
/// When `name` has more than [`LONGEST`] characters.
pub fn check_length(name: &str, suggestion: String) -> Result<(), Error> {
    match name.chars().count() {
        ..=LONGEST => Ok(()),
        length => Err(Problem::LongName {
            name: name.to_string(),
            length,
            longest: LONGEST,
            suggestion,
        }
        .into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_and_types_have_legal_names() {
        assert_eq!(type_name("op2_r_sole"), "Op2RSole");
        assert_eq!(module("7-bot.A"), "robot_7_bot_a");
        let words = "|_|__|r#fn|fn|self|é|real|DOF|2a|a-b|con|Lpt1";
        for bad in words.split('|').chain([&*"long".repeat(250)]) {
            assert!(!is_module_name(bad), "{bad}");
            assert!(is_module_name(&suggest(bad)), "{bad} -> {}", suggest(bad));
        }
    }
}
