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
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rand::{Rng, RngExt as _};

use crate::command::ROOT;

/// A command that writes, in two versions whose outputs differ.
#[derive(Debug, Clone, Copy)]
pub struct Writer {
    /// What it is called in tables.
    pub name: &'static str,
    /// Its arguments, between spaces.
    pub versions: [&'static str; 2],
    /// A folder that is removed before each run: its files are written once and never again.
    pub cleared: Option<&'static str>,
}

const fn writer(name: &'static str, versions: [&'static str; 2]) -> Writer {
    Writer {
        name,
        versions,
        cleared: None,
    }
}

/// Every command that writes, and every format.
pub const WRITERS: [Writer; 13] = [
    writer(
        "simulate, CSV",
        [
            "simulate a.urdf --support foot --poses 400 --seed 1 --out out.csv",
            "simulate a.urdf --support foot --poses 400 --seed 2 --out out.csv",
        ],
    ),
    writer(
        "simulate, gzip",
        [
            "simulate a.urdf --support foot --poses 400 --seed 1 --out out.csv.gz",
            "simulate a.urdf --support foot --poses 400 --seed 2 --out out.csv.gz",
        ],
    ),
    writer(
        "simulate, Parquet",
        [
            "simulate a.urdf --support foot --poses 400 --seed 1 --out out.parquet",
            "simulate a.urdf --support foot --poses 400 --seed 2 --out out.parquet",
        ],
    ),
    writer(
        "fit",
        [
            "fit a.urdf --data log.csv --out model.toml --report page.html --urdf b.urdf",
            "fit a.urdf --data log.csv --out model.toml --report page.html --urdf b.urdf --prior \
             tight",
        ],
    ),
    writer(
        "fit, part",
        [
            "fit a.urdf --data log.csv --partial a.part",
            "fit a.urdf --data log.csv --partial a.part --folds 3",
        ],
    ),
    writer(
        "diagnose",
        [
            "diagnose a.urdf --data log.csv --out model.toml --report page.html --next next.csv \
             --mcap found.mcap",
            "diagnose a.urdf --data log.csv --out model.toml --report page.html --next next.csv \
             --mcap found.mcap --prior cad",
        ],
    ),
    writer(
        "predict",
        [
            "predict a.urdf --data log.csv --support foot --out out.csv",
            "predict a.urdf --data log.csv --model model.toml --out out.csv",
        ],
    ),
    writer(
        "compare",
        [
            "compare log.csv other.csv --urdf a.urdf --report page.html",
            "compare log.csv other.csv --urdf a.urdf --report page.html --prior tight",
        ],
    ),
    writer(
        "plan",
        [
            "plan a.urdf --support foot --poses 5 --cop-box 0.2 --candidates 50 --seed 1 --out \
             plan.csv --report page.html",
            "plan a.urdf --support foot --poses 5 --cop-box 0.2 --candidates 50 --seed 2 --out \
             plan.csv --report page.html",
        ],
    ),
    writer(
        "generate, Rust",
        [
            "generate a.urdf --support foot --lang rust --name leg --out out",
            "generate a.urdf --support foot --lang rust --name leg --model model.toml --out out",
        ],
    ),
    writer(
        "generate, C",
        [
            "generate a.urdf --support foot --lang c --scalar f64 --name leg --layout cmake --out \
             out",
            "generate a.urdf --support foot --lang c --scalar f32 --name leg --layout cmake --out \
             out",
        ],
    ),
    Writer {
        name: "fleet",
        versions: [
            "fleet a.urdf --data logs --store parts --out table.csv --report fleet.html \
             --prior-out prior.toml --only parameters",
            "fleet a.urdf --data logs --store parts --out table.csv --report fleet.html \
             --prior-out prior.toml --only parameters --prior cad",
        ],
        cleared: Some("parts"),
    },
    writer(
        "demo",
        [
            "demo --keep kept --out demo.html --seed 1",
            "demo --keep kept --out demo.html --seed 2",
        ],
    ),
];

/// A folder in which one command is killed.
pub struct Victim<'p> {
    program: &'p Path,
    folder: tempfile::TempDir,
    writer: Writer,
    /// What each version writes, beside what it reads.
    whole: [BTreeMap<PathBuf, Vec<u8>>; 2],
    took: Duration,
}

impl<'p> Victim<'p> {
    /// Write what the command reads, and run both versions to their end.
    ///
    /// # Panics
    /// When a command fails.
    pub fn new(program: &'p Path, writer: Writer) -> Victim<'p> {
        let mut victim = Victim {
            program,
            folder: tempfile::tempdir().expect("a folder"),
            writer,
            whole: Default::default(),
            took: Duration::ZERO,
        };
        victim.inputs();
        for version in [0, 1] {
            let begun = Instant::now();
            victim.complete(version);
            victim.took = begun.elapsed();
            victim.whole[version] = files(victim.at());
        }
        assert_ne!(victim.whole[0], victim.whole[1], "{}", writer.name);
        victim
    }

    fn at(&self) -> &Path {
        self.folder.path()
    }

    fn inputs(&self) {
        let urdf = format!("{ROOT}/robots/two_link/two_link.urdf");
        fs::copy(urdf, self.at().join("a.urdf")).expect("the robot");
        let log = "simulate a.urdf --support foot --poses 60 --noise 0.0005 --out";
        self.to_its_end(&format!("{log} log.csv"));
        if self.writer.versions[1].contains("model.toml") {
            self.to_its_end("fit a.urdf --data log.csv --out model.toml");
        }
        if self.writer.name == "compare" {
            self.to_its_end(&format!("{log} other.csv --seed 2"));
        }
        if self.writer.name != "fleet" {
            return;
        }
        // As many as a prior between robots needs.
        for robot in 1..=6 {
            let day = format!("logs/robot={robot}/day=1");
            fs::create_dir_all(self.at().join(&day)).expect("a folder");
            self.to_its_end(&format!("{log} {day}/log.csv --seed {robot}"));
        }
    }

    fn start(&self, line: &str) -> Child {
        let mut command = Command::new(self.program);
        command.current_dir(self.at()).args(line.split(' '));
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().expect("the command starts")
    }

    fn to_its_end(&self, line: &str) {
        let status = self.start(line).wait().expect("the command ends");
        assert!(status.success(), "{line}: {status}");
    }

    fn clear(&self) {
        if let Some(folder) = self.writer.cleared {
            let _ = fs::remove_dir_all(self.at().join(folder));
        }
    }

    /// Run a version to its end.
    fn complete(&self, version: usize) {
        self.clear();
        self.to_its_end(self.writer.versions[version]);
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
            let before = files(self.at());
            let mut child = self.start(self.writer.versions[version]);
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
        let now = files(self.at());
        let is_whole = |(name, bytes): &(&PathBuf, &Vec<u8>)| {
            let mut versions = self.whole.iter();
            versions.any(|whole| whole.get(*name) == Some(*bytes))
        };
        let wrong = now.iter().find(|file| !is_whole(file));
        let gone = before.keys().find(|name| !now.contains_key(*name));
        let said = match (wrong, gone) {
            (Some((name, _)), _) => (name, "neither the old file nor the new one"),
            (None, Some(name)) => (name, "gone"),
            (None, None) => return Ok(()),
        };
        let (name, what) = (said.0.display(), said.1);
        Err(format!("{}: {name} is {what}", self.writer.name))
    }
}

fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with(".sesc-")
}

/// All files of a folder and of those in it, by name, but for temporary ones.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if !is_temporary(&path) {
            let bytes = fs::read(&path).expect("a file");
            found.insert(path, bytes);
        }
    }
    found
}
