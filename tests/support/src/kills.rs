//! Commands that write, killed at random moments: what is on the disk afterwards.
//!
//! ```text
//! version A ──▶ whole      version B ──▶ whole      then, again and again:
//! start A or B ── random moment ──▶ SIGKILL ──▶ every file is A's or B's, to the byte
//! ```
//!
//! A kill may leave temporary files, `.sesc-….part`, beside the outputs.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use rand::{Rng, RngExt as _};

use crate::command::{Folder, rows};

/// A command that writes, in two versions whose outputs differ.
#[derive(Debug, Clone)]
pub struct Writer {
    /// What it is called in tables.
    pub name: String,
    /// Its words.
    command: String,
    /// What the second version has behind these.
    end: String,
}

impl Writer {
    /// The words of a version.
    pub fn line(&self, version: usize) -> String {
        let end = if version == 0 { "" } else { &self.end };
        format!("{} {end}", self.command)
    }
}

/// A name of every command that writes and of every format, its words, the end of the second version.
const WRITERS: &str =
    "simulate, CSV | simulate a.urdf --support foot --poses 400 --out out.csv | --seed 2
    simulate, gzip | simulate a.urdf --support foot --poses 400 --out out.csv.gz | --seed 2
    simulate, Parquet | simulate a.urdf --support foot --poses 400 --out out.parquet | --seed 2
    fit | fit a.urdf --data log.csv --out model.toml --report page.html --urdf b.urdf
        | --prior tight
    fit, part | fit a.urdf --data log.csv --partial a.part | --folds 3
    diagnose | diagnose a.urdf --data log.csv --out model.toml --report page.html --next next.csv
        | --prior cad
    predict | predict a.urdf --data log.csv --out out.csv | --model model.toml
    compare | compare log.csv other.csv --urdf a.urdf --report page.html | --prior tight
    plan | plan a.urdf --support foot --poses 5 --cop-box 0.2 --candidates 50 --out plan.csv
        --report page.html | --seed 2
    generate, Rust | generate a.urdf --support foot --lang rust --name leg --out out
        | --model model.toml
    generate, C | generate a.urdf --support foot --lang c --name leg --layout cmake --out out
        | --scalar f32
    fleet | fleet a.urdf --data logs --store parts --out table.csv --report fleet.html
        --prior-out prior.toml --only parameters | --prior cad
    demo | demo --keep kept --out demo.html | --seed 2";

/// Every command that writes.
pub fn writers() -> impl Iterator<Item = Writer> {
    rows(WRITERS).into_iter().map(|row| {
        let [name, command, end] = row.try_into().expect("three cells");
        Writer { name, command, end }
    })
}

/// A folder of the fleet's rows: they are written once and never again.
const STORE: &str = "parts";

/// A folder with `a.urdf`, two logs of it, `model.toml` fitted to the first, and that one as the log
/// of a fleet.
pub fn inputs() -> Folder {
    let folder = Folder::with("two_link");
    fs::rename(folder.join("two_link.urdf"), folder.join("a.urdf")).expect("the robot");
    folder.stdout("simulate a.urdf --support foot --poses 60 --noise 0.0005 --out log.csv");
    folder.stdout("fit a.urdf --data log.csv --out model.toml");
    let other = "simulate a.urdf --support foot --poses 60 --noise 0.0005 --seed 2 --out other.csv";
    folder.stdout(other);
    for name in ["log.csv", "log.csv.toml"] {
        folder.write(&format!("logs/robot=1/day=1/{name}"), folder.read(name));
    }
    folder
}

/// A folder in which one command is killed.
pub struct Victim {
    folder: Folder,
    writer: Writer,
    /// What each version writes, beside what it reads.
    whole: [BTreeMap<PathBuf, Vec<u8>>; 2],
    took: Duration,
}

impl Victim {
    /// Write what the command reads, and run both versions to their end.
    ///
    /// # Panics
    /// When a command fails.
    pub fn new(writer: Writer) -> Victim {
        let mut victim = Victim {
            folder: inputs(),
            writer,
            whole: Default::default(),
            took: Duration::ZERO,
        };
        let log = "simulate a.urdf --support foot --poses 60 --noise 0.0005 --out";
        // As many as a prior between robots needs.
        for robot in 2..=6 {
            let day = format!("logs/robot={robot}/day=1");
            fs::create_dir_all(victim.folder.join(&day)).expect("a folder");
            let line = format!("{log} {day}/log.csv --seed {robot}");
            victim.folder.stdout(&line);
        }
        for version in [0, 1] {
            victim.clear();
            let begun = Instant::now();
            victim.folder.stdout(&victim.writer.line(version));
            victim.took = begun.elapsed();
            victim.whole[version] = victim.files();
        }
        assert_ne!(victim.whole[0], victim.whole[1], "{}", victim.writer.name);
        victim
    }

    fn start(&self, version: usize) -> Child {
        let mut command = self.folder.command(&self.writer.line(version));
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().expect("the command starts")
    }

    fn clear(&self) {
        let _ = fs::remove_dir_all(self.folder.join(STORE));
    }

    /// All files but for temporary ones.
    fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut files = self.folder.files();
        files.retain(|path, _| !is_temporary(path));
        files
    }

    /// Kill the command `times` times, half of the kills towards its end, where it writes; how
    /// many came before its end.
    ///
    /// # Errors
    /// A file that is neither the old one nor the new one, whole, or that is gone.
    pub fn kill(&self, times: u32, rng: &mut impl Rng) -> Result<u32, String> {
        let mut hit = 0;
        for _ in 0..times {
            let version = usize::from(rng.random_bool(0.5));
            let from = if rng.random_bool(0.5) { 0.8 } else { 0.0 };
            self.clear();
            let before = self.files();
            let mut child = self.start(version);
            std::thread::sleep(self.took.mul_f64(rng.random_range(from..1.02)));
            let killed = child.kill();
            let status = child.wait().map_err(|error| error.to_string())?;
            killed.map_err(|error| error.to_string())?;
            self.look(&before)?;
            hit += u32::from(!status.success());
        }
        Ok(hit)
    }

    /// Whether every file that is there after a kill is whole, and none is gone.
    fn look(&self, before: &BTreeMap<PathBuf, Vec<u8>>) -> Result<(), String> {
        let now = self.files();
        let is_whole = |(name, bytes): &(&PathBuf, &Vec<u8>)| {
            let mut versions = self.whole.iter();
            versions.any(|whole| whole.get(*name) == Some(*bytes))
        };
        let wrong = now.iter().find(|file| !is_whole(file));
        let gone = before.keys().find(|name| !now.contains_key(*name));
        let (name, what) = match (wrong, gone) {
            (Some((name, _)), _) => (name, "neither the old file nor the new one"),
            (None, Some(name)) => (name, "gone"),
            (None, None) => return Ok(()),
        };
        Err(format!(
            "{}: {} is {what}",
            self.writer.name,
            name.display()
        ))
    }
}

fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with(".sesc-")
}
