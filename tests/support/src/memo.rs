//! What a tool said of the same input before.
//!
//! A compiler or a linter gives for the same text, arguments and version the same answer;
//! a test that asks again looks it up. Answers are kept beside what was asked, or, for all
//! checkouts of a machine, in the folder that `SESC_ANSWERS` names. `SESC_ASK_AGAIN=1` asks
//! the tool whatever it said.

use std::collections::HashMap;
use std::fs;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, OnceLock};

/// First line of `tool --version`.
fn version(tool: &str) -> String {
    static KNOWN: OnceLock<Mutex<HashMap<String, String>>> = OnceLock::new();
    let mut known = KNOWN.get_or_init(Mutex::default).lock().unwrap();
    let ask = || {
        let output = Command::new(tool).arg("--version").output();
        output.map_or(String::new(), |output| {
            String::from_utf8_lossy(&output.stdout).into_owned()
        })
    };
    known.entry(tool.to_string()).or_insert_with(ask).clone()
}

/// What `tools` said of `texts` (arguments, or the test's own source, among them): what
/// `ask` gives, or what it gave for the same in `folder` before, where `made` stands still.
pub fn said(
    folder: &Path,
    tools: &[&str],
    texts: &[&str],
    made: &[&Path],
    ask: impl FnOnce() -> String,
) -> String {
    let answers = std::env::var_os("SESC_ANSWERS").map(PathBuf::from);
    let again = std::env::var_os("SESC_ASK_AGAIN").is_some();
    Memory { answers, again }.said(folder, tools, texts, made, ask)
}

/// Where answers are kept, and whether tools are asked in spite of them.
struct Memory {
    /// The folder of all checkouts; beside what was asked if none.
    answers: Option<PathBuf>,
    again: bool,
}

impl Memory {
    fn said(
        &self,
        folder: &Path,
        tools: &[&str],
        texts: &[&str],
        made: &[&Path],
        ask: impl FnOnce() -> String,
    ) -> String {
        let asked = key(folder, tools, texts);
        let stamp = match &self.answers {
            Some(answers) => answers.join(&asked),
            None => folder.join("said"),
        };
        let before = fs::read_to_string(&stamp).unwrap_or_default();
        let known = before.split_once('\n').filter(|(key, _)| *key == asked);
        let there = !self.again && made.iter().all(|path| path.exists());
        if let Some((_, said)) = known.filter(|_| there) {
            return said.to_string();
        }
        let _ = fs::remove_file(&stamp);
        let said = ask();
        fs::write(&stamp, format!("{asked}\n{said}")).unwrap();
        said
    }
}

/// What stands for `tools`, in the versions that are installed, and `texts`.
fn key(folder: &Path, tools: &[&str], texts: &[&str]) -> String {
    let mut hasher = DefaultHasher::new();
    for tool in tools {
        version(tool).hash(&mut hasher);
    }
    // Wherever the checkout is, its files are called the same.
    let place = folder.display().to_string();
    for text in texts {
        text.replace(&place, "").hash(&mut hasher);
    }
    format!("{:016x}", hasher.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How often the tool is asked when five questions are put, two of them the same.
    fn asked(memory: &Memory, folder: &Path) -> usize {
        let asked = std::cell::Cell::new(0);
        let ask = |arguments: &str, text: &str, made: &[&Path]| {
            memory.said(folder, &["rustc"], &[arguments, text], made, || {
                asked.set(asked.get() + 1);
                format!("{text}\nsaid")
            })
        };
        assert_eq!(ask("-O", "a", &[]), "a\nsaid");
        assert_eq!(ask("-O", "a", &[]), "a\nsaid");
        ask("-O", "b", &[]);
        ask("-g", "b", &[]);
        ask("-g", "b", &[&folder.join("program")]);
        asked.get()
    }

    #[test]
    fn other_texts_arguments_and_missing_files_are_asked_again() {
        let folder = std::env::temp_dir().join(format!("sesc_memo_{}", std::process::id()));
        let answers = folder.join("answers");
        fs::create_dir_all(&answers).unwrap();
        let memory = |answers: Option<&Path>, again| Memory {
            answers: answers.map(Path::to_path_buf),
            again,
        };
        assert_eq!(asked(&memory(None, false), &folder), 4);
        assert_eq!(asked(&memory(None, true), &folder), 5);
        assert_eq!(asked(&memory(Some(&answers), false), &folder), 4);
        // All that a checkout knows, another one knows.
        let other = folder.join("other");
        fs::create_dir_all(&other).unwrap();
        assert_eq!(asked(&memory(Some(&answers), false), &other), 1);
        assert_eq!(asked(&memory(Some(&answers), true), &other), 5);
        fs::remove_dir_all(&folder).unwrap();
    }
}
