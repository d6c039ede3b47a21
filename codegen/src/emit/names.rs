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

/// What a language takes as the name of generated files.
pub struct Naming {
    /// The word that text becomes.
    pub(super) word: fn(&str) -> String,
    /// Whether a word serves, but for its length.
    pub(super) is_spelled: fn(&str) -> bool,
    /// What is said of a name that does not, with one that does.
    pub(super) refused: fn(String, String) -> Problem,
}

/// Modules whose type serves beside what is in it.
pub const MODULE: Naming = Naming {
    word: module,
    is_spelled: |name| {
        is_identifier(name)
            && syn::parse_str::<syn::Ident>(name).is_ok()
            && !TAKEN.contains(&type_name(name).as_str())
    },
    refused: |name, suggestion| Problem::BadName { name, suggestion },
};

impl Naming {
    /// The name of what is called `name`, whole however long it is: a part of it might be that of
    /// another robot or support.
    pub fn whole(&self, name: &str) -> String {
        let word = (self.word)(name);
        match (self.is_spelled)(&word) {
            true => word,
            false => format!("{word}_robot"),
        }
    }

    /// A name like `name` that serves.
    pub fn suggest(&self, name: &str) -> String {
        cut(&self.whole(name), LONGEST)
    }

    /// Refuses a name that does not serve.
    ///
    /// # Errors
    /// When `name` has more than [`LONGEST`] characters, or is spelled otherwise.
    pub fn check(&self, name: &str) -> Result<(), Error> {
        let (length, suggestion) = (name.chars().count(), self.suggest(name));
        let problem = match (length > LONGEST, (self.is_spelled)(name)) {
            (false, true) => return Ok(()),
            (false, false) => (self.refused)(name.to_string(), suggestion),
            (true, _) => Problem::LongName {
                name: name.to_string(),
                length,
                longest: LONGEST,
                suggestion,
            },
        };
        Err(problem.into())
    }
}

/// Letters, digits and `_` behind a letter that Windows does not take for a device.
pub(super) fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !is_device(name)
}

/// Whether Windows takes a file of this name for a device, whatever its end.
fn is_device(name: &str) -> bool {
    let name = name.to_lowercase();
    let numbered = |kind: &str| {
        let number = name.strip_prefix(kind);
        number.is_some_and(|n| matches!(n.as_bytes(), [b'0'..=b'9']))
    };
    matches!(&*name, "con" | "prn" | "aux" | "nul") || numbered("com") || numbered("lpt")
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
            assert!(MODULE.check(bad).is_err(), "{bad}");
            let good = MODULE.suggest(bad);
            assert!(MODULE.check(&good).is_ok(), "{bad} -> {good}");
        }
    }
}
