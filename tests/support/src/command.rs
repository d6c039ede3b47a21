//! Running `sesc` and reading what it says.

use std::collections::BTreeMap;
use std::fmt;
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

/// The cells of a table of lines, divided by ` | `: a row begins at the margin of the others, and goes
/// on in lines that stand further to the right, or that begin with `|`.
pub fn rows(table: &str) -> Vec<Vec<String>> {
    let mut rows: Vec<String> = Vec::new();
    let margin = |line: &str| line.len() - line.trim_start().len();
    let margins = table.lines().skip(1).filter(|line| !line.trim().is_empty());
    let least = margins.map(margin).min().unwrap_or(0);
    let goes_on = |line: &str| margin(line) > least || line.trim_start().starts_with('|');
    for line in table.lines().filter(|line| !line.trim().is_empty()) {
        match rows.last_mut() {
            Some(row) if goes_on(line) => *row += &format!(" {}", line.trim()),
            _ => rows.push(line.trim().to_owned()),
        }
    }
    let cells = rows
        .iter()
        .map(|row| row.split(" | ").map(|cell| cell.trim().to_owned()));
    cells.map(Iterator::collect).collect()
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
    says(&message, words);
    assert!(!message.contains("panicked"), "{message}");
}

/// Every one of `words` is in the text.
#[track_caller]
pub fn says(text: impl AsRef<str>, words: &[&str]) {
    let text = text.as_ref();
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

/// The same, with blanks and line breaks alike.
#[track_caller]
pub fn says_somewhere(text: impl AsRef<str>, words: &[&str]) {
    let text: Vec<&str> = text.as_ref().split_whitespace().collect();
    says(text.join(" "), words);
}

/// The JSON that a command printed, whatever its exit code.
pub fn json(output: &Output) -> serde_json::Value {
    let said = String::from_utf8_lossy(&output.stdout);
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {said} {}", stderr(output)))
}

/// A number of a JSON answer.
#[track_caller]
pub fn number(answer: &serde_json::Value, path: &str) -> f64 {
    let value = answer.pointer(path).and_then(serde_json::Value::as_f64);
    value.unwrap_or_else(|| panic!("{path}: {answer}"))
}

/// The list of a JSON answer.
#[track_caller]
pub fn list<'a>(answer: &'a serde_json::Value, path: &str) -> &'a Vec<serde_json::Value> {
    let value = answer.pointer(path).and_then(serde_json::Value::as_array);
    value.unwrap_or_else(|| panic!("{path}: {answer}"))
}

/// The texts of a list of a JSON answer.
#[track_caller]
pub fn texts<'a>(answer: &'a serde_json::Value, path: &str) -> Vec<&'a str> {
    let all = list(answer, path).iter();
    all.map(|text| text.as_str().expect("a text")).collect()
}

/// A CSV table as text: names of columns, and fields row by row.
#[derive(Debug, Clone)]
pub struct Sheet {
    /// Names of the columns.
    pub names: Vec<String>,
    /// Rows of fields.
    pub rows: Vec<Vec<String>>,
}

impl Sheet {
    /// Reads the text of a table.
    pub fn read(text: &str) -> Sheet {
        let mut reader = csv::ReaderBuilder::new();
        let mut reader = reader.comment(Some(b'#')).from_reader(text.as_bytes());
        let fields = |row: &csv::StringRecord| row.iter().map(str::to_owned).collect();
        let names = fields(reader.headers().expect("a header"));
        let rows = reader.records().map(|row| fields(&row.expect("a row")));
        Sheet {
            rows: rows.collect(),
            names,
        }
    }

    /// Place of a column.
    #[track_caller]
    pub fn place(&self, name: &str) -> usize {
        let place = self.names.iter().position(|own| own == name);
        place.unwrap_or_else(|| panic!("no column `{name}` of {:?}", self.names))
    }

    /// A field of a row.
    pub fn field(&self, row: usize, name: &str) -> &str {
        &self.rows[row][self.place(name)]
    }

    /// Numbers of these columns, row by row.
    pub fn numbers(&self, names: &[impl AsRef<str>]) -> Vec<Vec<f64>> {
        let places: Vec<usize> = names.iter().map(|name| self.place(name.as_ref())).collect();
        let number = |field: &String| field.parse().unwrap_or_else(|_| panic!("{field}"));
        let row = |row: &Vec<String>| places.iter().map(|at| number(&row[*at])).collect();
        self.rows.iter().map(row).collect()
    }

    /// Readings of each row, m.
    pub fn cop(&self) -> Vec<[f64; 2]> {
        let rows = self.numbers(&["cop_x", "cop_y"]).into_iter();
        rows.map(|row| [row[0], row[1]]).collect()
    }

    /// Writes a value into a column: of one row, or of all.
    pub fn set(&mut self, name: &str, row: Option<usize>, value: &str) {
        let place = self.place(name);
        let rows = self.rows.iter_mut().enumerate();
        let rows = rows.filter(|(k, _)| row.is_none_or(|row| row == *k));
        rows.for_each(|(_, row)| row[place] = value.to_owned());
    }

    /// Adds a column of what is said of each row by its number.
    pub fn add(&mut self, name: &str, of: impl Fn(usize) -> String) {
        self.names.push(name.to_owned());
        let rows = self.rows.iter_mut().enumerate();
        rows.for_each(|(k, row)| row.push(of(k)));
    }

    /// Leaves out the columns that are not kept.
    pub fn keep(&mut self, is_kept: impl Fn(&str) -> bool) {
        let kept: Vec<bool> = self.names.iter().map(|name| is_kept(name)).collect();
        for row in self.rows.iter_mut().chain([&mut self.names]) {
            let mut kept = kept.iter();
            row.retain(|_| *kept.next().expect("a field a column"));
        }
    }
}

/// The table as CSV.
impl fmt::Display for Sheet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut rows = [&self.names].into_iter().chain(&self.rows);
        rows.try_for_each(|row| writeln!(f, "{}", row.join(",")))
    }
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

    /// The same of a line with values, as of [`in_words`].
    pub fn run_on(&self, line: &str, values: &[&str]) -> Output {
        let mut command = self.command("");
        command.args(in_words(line, values)).output().unwrap()
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

    /// What a command that succeeds says on stderr.
    pub fn said(&self, line: &str) -> String {
        let output = self.run(line);
        assert!(output.status.success(), "{line}: {}", stderr(&output));
        stderr(&output)
    }

    /// The JSON of a command that succeeds.
    pub fn json(&self, line: &str) -> serde_json::Value {
        serde_json::from_str(&self.stdout(&format!("{line} --json"))).unwrap()
    }

    /// The JSON of a command that ends with this code.
    pub fn json_of(&self, code: i32, line: &str) -> serde_json::Value {
        let output = self.run(&format!("{line} --json"));
        assert_eq!(
            output.status.code(),
            Some(code),
            "{line}: {}",
            stderr(&output)
        );
        json(&output)
    }

    /// A table of the folder.
    pub fn sheet(&self, name: &str) -> Sheet {
        Sheet::read(&self.read(name))
    }

    /// A TOML file of the folder.
    pub fn toml(&self, name: &str) -> toml::Table {
        self.read(name).parse().unwrap()
    }

    /// Refuses the command with these words.
    pub fn refuses(&self, line: &str, words: &[&str]) {
        refused(&self.run(line), words);
    }

    /// Refuses each command of a table: the command, then words of its message.
    pub fn refuses_each(&self, table: &str) {
        for row in rows(table) {
            let cells: Vec<&str> = row.iter().map(String::as_str).collect();
            assert!(cells.len() > 1, "no words for {row:?}");
            self.refuses(cells[0], &cells[1..]);
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
