//! The one place where the diagnoser is called, by its binary: `sesc diagnose
//! URDF --data LOG --prior tight --json --out MODEL` (the virtual robot weighs what CAD
//! says), then `sesc predict` with that model.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

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
        let said = self.run(&[
            "diagnose".as_ref(),
            urdf.as_os_str(),
            "--data".as_ref(),
            log.as_os_str(),
            "--prior".as_ref(),
            "tight".as_ref(),
            "--json".as_ref(),
            "--out".as_ref(),
            model.as_os_str(),
        ])?;
        serde_json::from_slice(&said).map_err(|error| error.to_string())
    }

    /// The CoP that a model predicts for a file of postures, m.
    ///
    /// # Errors
    /// What it wrote where it failed, or that it wrote no table.
    pub fn predict(
        &self,
        urdf: &Path,
        model: &Path,
        postures: &Path,
    ) -> Result<Vec<[f64; 2]>, String> {
        let said = self.run(&[
            "predict".as_ref(),
            urdf.as_os_str(),
            "--model".as_ref(),
            model.as_os_str(),
            "--data".as_ref(),
            postures.as_os_str(),
        ])?;
        let said = String::from_utf8_lossy(&said);
        let rows = said.lines().skip(1).map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let cop = [4, 5].map(|i| cells.get(i).and_then(|cell| cell.parse().ok()));
            match cop {
                [Some(x), Some(y)] => Ok([x, y]),
                _ => Err(format!("`{line}` has no CoP")),
            }
        });
        rows.collect()
    }

    fn run(&self, arguments: &[&OsStr]) -> Result<Vec<u8>, String> {
        let output = Command::new(&self.sesc)
            .args(arguments)
            .output()
            .map_err(|error| format!("{}: {error}", self.sesc.display()))?;
        if output.status.success() {
            Ok(output.stdout)
        } else {
            Err(String::from_utf8_lossy(&output.stderr).into_owned())
        }
    }
}
