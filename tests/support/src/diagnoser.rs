//! The one place where the diagnoser is called, by its binary: `sesc diagnose
//! URDF --data LOG --prior tight --json --out MODEL` (the virtual robot weighs what CAD
//! says), then `sesc predict` with that model.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{Sheet, in_words, tool};

/// A diagnoser to ask: a robot's description and a log in, its JSON out.
#[derive(Debug, Clone)]
pub struct Diagnoser {
    /// The command.
    pub sesc: PathBuf,
}

impl Diagnoser {
    /// What it says; the corrected model goes to `model`.
    ///
    /// # Errors
    /// What it wrote where it failed, or that it wrote no JSON.
    pub fn diagnose(
        &self,
        urdf: &Path,
        log: &Path,
        model: &Path,
    ) -> Result<serde_json::Value, String> {
        let line = "diagnose @ --data @ --prior tight --json --out @";
        let said = self.run(line, [urdf, log, model])?;
        serde_json::from_str(&said).map_err(|error| error.to_string())
    }

    /// The CoP that a model predicts for a file of postures, m.
    ///
    /// # Errors
    /// What it wrote where it failed.
    pub fn predict(
        &self,
        urdf: &Path,
        model: &Path,
        postures: &Path,
    ) -> Result<Vec<[f64; 2]>, String> {
        let said = self.run("predict @ --model @ --data @", [urdf, model, postures])?;
        Ok(Sheet::read(&said).cop())
    }

    fn run(&self, line: &str, paths: [&Path; 3]) -> Result<String, String> {
        let paths = paths.map(|path| path.to_str().unwrap_or_default());
        let said = tool(Command::new(&self.sesc).args(in_words(line, &paths)))?;
        String::from_utf8(said).map_err(|error| error.to_string())
    }
}
