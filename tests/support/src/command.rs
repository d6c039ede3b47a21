//! Running `sesc` and reading what it says.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The project's root.
pub const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// The `sesc` that cargo built beside the test: `target/debug/sesc` for
/// `target/debug/deps/test`.
pub fn program() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let program = test.parent().unwrap().with_file_name("sesc");
    program.with_extension(std::env::consts::EXE_EXTENSION)
}

/// What `sesc` prints and returns with these arguments.
pub fn sesc(arguments: &[&str]) -> Output {
    Command::new(program()).args(arguments).output().unwrap()
}

/// A command line in words; each `@` is the next of `values`, which may hold spaces.
pub fn in_words<'a>(line: &'a str, values: &[&'a str]) -> Vec<&'a str> {
    let mut values = values.iter();
    let words = line.split(' ').map(|word| match word {
        "@" => values.next().expect("a value for each @"),
        _ => word,
    });
    words.collect()
}

/// The path of the OP2's URDF.
pub fn op2() -> String {
    format!("{ROOT}/robots/op2/op2.urdf")
}

/// What a command that succeeded printed.
pub fn stdout(output: &Output) -> String {
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Exit code 2, nothing on stdout but the error itself where JSON was asked for, and every one
/// of `words` in the message.
pub fn refused(output: &Output, words: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    let answer = String::from_utf8_lossy(&output.stdout);
    let is_error = answer.starts_with("{\n  \"schema\"") && answer.contains("\n  \"error\": {");
    assert!(answer.is_empty() || is_error, "{answer}");
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
}

/// A folder that goes when the test ends.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// Writes a file into a folder; its path.
pub fn write(folder: &Path, name: &str, text: impl AsRef<[u8]>) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.display().to_string()
}
