//! Identifiers from the names of links and joints.
//!
//! URDF names hold dots, slashes, hyphens, spaces and letters of any script.
//! Generated names use ASCII letters, digits and `_` only; names that collide
//! after conversion are numbered in document order.

use std::collections::HashSet;

/// Longest word for a link or joint: lines of generated code stay short.
const LONGEST: usize = 26;

/// Legal words for `names`, unique among themselves, in the same order.
pub fn unique<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    numbered(names.map(word), LONGEST)
}

/// Legal names of constants for `names`: whole words in capitals, unique among themselves.
pub fn constants<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    numbered(names.map(|name| word(name).to_uppercase()), usize::MAX)
}

/// The words, no longer than `longest`; all but the first of those alike get a number.
fn numbered(words: impl Iterator<Item = String>, longest: usize) -> Vec<String> {
    let words: Vec<String> = words.map(|word| cut(&word, longest)).collect();
    let mut taken: HashSet<String> = HashSet::new();
    let all: HashSet<&String> = words.iter().collect();
    words
        .iter()
        .map(|word| {
            if taken.insert(word.clone()) {
                return word.clone();
            }
            let numbered = (2..)
                .map(|n| {
                    let number = format!("_{n}");
                    cut(word, longest - number.len()) + &number
                })
                .find(|candidate| !taken.contains(candidate) && !all.contains(candidate))
                .expect("some number is free");
            taken.insert(numbered.clone());
            numbered
        })
        .collect()
}

/// The first `length` characters, without a `_` left hanging.
pub fn cut(word: &str, length: usize) -> String {
    match word.get(..length) {
        Some(start) => start.trim_end_matches('_').to_string(),
        None => word.to_string(),
    }
}

/// `l-knee.1` → `l_knee_1`; a word never starts or ends with `_` by conversion.
pub fn word(name: &str) -> String {
    let mut word = String::new();
    for c in name.chars() {
        if c.is_ascii_alphanumeric() || c == '_' {
            word.push(c);
        } else if !c.is_ascii() && c.is_alphanumeric() {
            // Letters outside ASCII keep their identity by code point.
            word.push_str(&format!("u{:x}", c as u32));
        } else if !word.ends_with('_') {
            word.push('_');
        }
    }
    let trimmed = word.trim_matches('_');
    if trimmed.is_empty() {
        "unnamed".to_string()
    } else {
        trimmed.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_words_and_stay_apart() {
        let names = ["l-knee", "l.knee", "l knee", "l_knee_2", "κ", "!"];
        let words = "l_knee l_knee_3 l_knee_4 l_knee_2 u3ba unnamed";
        assert_eq!(unique(names.into_iter()).join(" "), words);
        let constants = constants(["l-knee", "L knee", "hip"].into_iter());
        assert_eq!(constants, ["L_KNEE", "L_KNEE_2", "HIP"]);
        let long = ["joint", "jaw"].map(|end| format!("right_shoulder_pitch_front_{end}"));
        let short = unique(long.iter().map(String::as_str)).join(" ");
        let expected = "right_shoulder_pitch_front right_shoulder_pitch_fro_2";
        assert_eq!(short, expected);
    }
}
