//! Identifiers from the names of links and joints.
//!
//! URDF names hold dots, slashes, hyphens, spaces and letters of any script.
//! Generated names use ASCII letters, digits and `_` only; names that collide
//! after conversion are numbered in document order.

use std::collections::HashSet;

use sesc_model::names::{cut, word};

/// Characters in which C99 promises to tell external names apart; MISRA asks it of all.
pub const SIGNIFICANT: usize = 31;

/// `op2_r_sole` for a module, from words of any kind.
pub fn module(name: &str) -> String {
    let mut word = word(name).to_lowercase();
    if word.starts_with(|c: char| c.is_ascii_digit()) {
        word.insert_str(0, "robot_");
    }
    word
}

/// External names `prefix_suffix` that are not the first to begin with their 31
/// characters, each with a symbol of its own that is.
pub fn distinct(prefix: &str, suffixes: &[String]) -> Vec<(String, String)> {
    let significant = |name: &str| cut(name, SIGNIFICANT);
    let mut taken: HashSet<String> = HashSet::new();
    let mut renamed = Vec::new();
    for suffix in suffixes {
        let name = format!("{prefix}_{suffix}");
        if taken.insert(significant(&name)) {
            continue;
        }
        // The prefix gives way: what the function does stays readable.
        let room = SIGNIFICANT.saturating_sub(suffix.len() + 1).max(4);
        let symbol = (1..)
            .map(|n| match n {
                1 => format!("{}_{suffix}", cut(prefix, room)),
                n => format!("{}{n}_{suffix}", cut(prefix, room.saturating_sub(3))),
            })
            .find(|symbol| !taken.contains(&significant(symbol)))
            .expect("some number is free");
        taken.insert(significant(&symbol));
        renamed.push((name, symbol));
    }
    renamed
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

/// Names of generated items that a module's type must not take.
const TAKEN: [&str; 3] = ["Real", "DOF", "PRISMATIC"];

/// Whether `name` serves as a module and its type serves beside what is in it.
pub fn is_module_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && syn::parse_str::<syn::Ident>(name).is_ok()
        && !TAKEN.contains(&type_name(name).as_str())
}

/// A name like `name` that serves.
pub fn suggest(name: &str) -> String {
    let word = module(name);
    if is_module_name(&word) {
        word
    } else {
        format!("{word}_robot")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_and_types_have_legal_names() {
        let functions = ["regressor", "regressor_cop", "regressor_full"].map(str::to_string);
        assert_eq!(distinct("op2_r_sole", &functions), []);
        assert_eq!(
            distinct("skew_humanoid_right_sole", &functions)[0],
            (
                "skew_humanoid_right_sole_regressor_cop".into(),
                "skew_humanoid_rig_regressor_cop".into()
            )
        );
        assert_eq!(type_name("op2_r_sole"), "Op2RSole");
        assert_eq!(module("7-bot.A"), "robot_7_bot_a");
        for bad in [
            "", "_", "__", "r#fn", "fn", "self", "é", "real", "DOF", "2a", "a-b",
        ] {
            assert!(!is_module_name(bad), "{bad}");
            assert!(is_module_name(&suggest(bad)), "{bad} -> {}", suggest(bad));
        }
    }
}
