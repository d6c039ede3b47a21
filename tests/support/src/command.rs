//! Running `sesc` and reading what it says.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

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

/// What a command wrote on stderr.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder below `target/tmp` that outlives the test.
pub fn scratch(name: &str) -> PathBuf {
    let folder = program().with_file_name("../tmp").join(name);
    fs::create_dir_all(&folder).unwrap();
    fs::canonicalize(folder).unwrap()
}

/// The same, emptied.
pub fn fresh(name: &str) -> PathBuf {
    fs::remove_dir_all(scratch(name)).unwrap();
    scratch(name)
}

/// Run a tool; what it says if it fails. A tool that is not there fails the test.
pub fn tool(command: &mut Command) -> Result<Vec<u8>, String> {
    let output = command.output().unwrap_or_else(|error| {
        panic!("{command:?}: {error}; tests need a C compiler as cc, `.ci/all` installs others")
    });
    match output.status.success() {
        true => Ok(output.stdout),
        false => Err(format!(
            "{command:?}: {}\n{}{}",
            output.status,
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        )),
    }
}

/// What a tool that must succeed prints.
pub fn printed(command: &mut Command) -> String {
    let printed = tool(command).unwrap_or_else(|message| panic!("{message}"));
    String::from_utf8(printed).unwrap()
}

/// All files of a folder and of those in it, by name.
pub fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => found.extend(files(&path)),
            false => drop(found.insert(path.clone(), fs::read(&path).unwrap())),
        }
    }
    found
}

/// A folder in which commands run; it goes when the test ends.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// A folder without files.
    pub fn empty() -> Folder {
        Folder(folder())
    }

    /// A folder with `ROBOT.urdf` of `robots/ROBOT/`.
    pub fn with(robot: &str) -> Folder {
        let folder = Folder::empty();
        let urdf = format!("{ROOT}/robots/{robot}/{robot}.urdf");
        folder.write(&format!("{robot}.urdf"), fs::read(urdf).unwrap());
        folder
    }

    /// A folder with the OP2 and a log of it on its right sole, simulated with these options.
    pub fn with_log(options: &str) -> Folder {
        let folder = Folder::with("op2");
        folder.simulate(&format!("{options} --out log.csv"));
        folder
    }

    /// Simulates a log of the OP2 on its right sole.
    pub fn simulate(&self, options: &str) {
        self.stdout(&format!("simulate op2.urdf --support r_sole {options}"));
    }

    /// The folder itself.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// A file of the folder.
    pub fn join(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The same as a word of a command.
    pub fn at(&self, name: &str) -> String {
        self.join(name).display().to_string()
    }

    /// Writes a file, below folders that need not be there; its path.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) -> String {
        fs::create_dir_all(self.join(name).parent().unwrap()).unwrap();
        write(self.path(), name, text)
    }

    /// The text of a file.
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// `sesc` with the words of a line, in the folder.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(program());
        command.current_dir(self.path());
        command.args(line.split_whitespace());
        command
    }

    /// What it prints and returns.
    pub fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    /// The same with a file in a pipe as standard input.
    pub fn piped(&self, line: &str, input: &str) -> Output {
        let mut command = self.command(line);
        let pipes = command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = pipes.stderr(Stdio::piped()).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        // The command need not read it.
        let _ = stdin.write_all(&fs::read(self.join(input)).unwrap());
        drop(stdin);
        child.wait_with_output().unwrap()
    }

    /// What a command that succeeds prints.
    pub fn stdout(&self, line: &str) -> String {
        stdout(&self.run(line))
    }

    /// The JSON of a command that succeeds.
    pub fn json(&self, line: &str) -> serde_json::Value {
        serde_json::from_str(&self.stdout(&format!("{line} --json"))).unwrap()
    }

    /// Refuses the command with these words.
    pub fn refuses(&self, line: &str, words: &[&str]) {
        refused(&self.run(line), words);
    }

    /// Refuses each command of a table of lines: the command, then words of its message, with ` | `
    /// before each; a line that begins with `|` goes on with the row before it.
    pub fn refuses_each(&self, table: &str) {
        let mut rows: Vec<String> = Vec::new();
        for line in table.lines().map(str::trim) {
            match rows.last_mut() {
                Some(row) if line.starts_with('|') => *row += &format!(" {line}"),
                _ => rows.push(line.to_string()),
            }
        }
        for row in rows {
            let mut cells = row.split(" | ").map(str::trim);
            let line = cells.next().unwrap();
            self.refuses(line, &cells.collect::<Vec<_>>());
        }
    }

    /// All files, with their bytes.
    pub fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        files(self.path())
    }

    /// Names of what lies in the folder itself, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.path()).unwrap();
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<String> = entries
            .map(|entry| name(entry).into_string().unwrap())
            .collect();
        names.sort();
        names
    }
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
