//! `cargo xtask hidden FOLDER`: logs of the reference's virtual robot with effects hidden, for
//! `benches/hidden/run`.
//!
//! ```text
//! FOLDER/KIND-SEED/{log.csv, fresh.csv, truth.json}
//! ```

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use sesc_test_support::examine::unlisted::{Kind, Trial};
use sesc_test_support::stage::{Platform, Stage};

/// How many logs, and where they go.
#[derive(Args)]
pub struct Hidden {
    /// Where a folder for each log is made
    folder: PathBuf,
    /// Logs of each kind of effect
    #[arg(long, default_value_t = 1)]
    logs: u64,
    /// The first log's seed; each further one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl Hidden {
    /// Write the logs.
    ///
    /// # Errors
    /// Of the files.
    pub fn run(&self, root: &Path) -> Result<(), Box<dyn Error>> {
        let stage = Stage::new(Platform::Op2);
        for (k, kind) in Kind::ALL.into_iter().enumerate() {
            for seed in self.seed..self.seed + self.logs {
                let trial = Trial::new(&stage, Some(kind), false, seed + 1000 * k as u64)?;
                let folder = self.folder.join(format!("{kind:?}-{seed}"));
                fs::create_dir_all(&folder)?;
                let [apart_s, fresh_apart_s] = trial.apart_s();
                let rows = trial.log.iter().map(|(q, cop)| [q, &cop[..]].concat());
                let log = table(&trial.joints, &["cop_x", "cop_y"], rows, apart_s)?;
                fs::write(folder.join("log.csv"), log)?;
                let columns = ["cop_x", "cop_y", "com_x", "com_y", "com_z"];
                let rows = trial.fresh.iter();
                let rows = rows.map(|(q, cop, com)| [q, &cop[..], &com[..]].concat());
                let fresh = table(&trial.joints, &columns, rows, fresh_apart_s)?;
                fs::write(folder.join("fresh.csv"), fresh)?;
                let truth = serde_json::json!({
                    "kind": kind.name().replace('-', &format!("{kind:?}").to_lowercase()),
                    "is_in_table": kind.is_in_table(),
                    "place": trial.place,
                    "chi2": trial.chi2.round(),
                    "noise_m": trial.noise_m,
                    "support": stage.support,
                    "simulator": "virtual",
                    "urdf": fs::canonicalize(&stage.urdf)?.strip_prefix(root)?,
                });
                fs::write(folder.join("truth.json"), format!("{truth:#}\n"))?;
            }
        }
        Ok(())
    }
}

/// Rows of joint positions and of `columns` as CSV, `apart_s` seconds apart.
fn table(
    joints: &[String],
    columns: &[&str],
    rows: impl Iterator<Item = Vec<f64>>,
    apart_s: f64,
) -> Result<String, std::fmt::Error> {
    let joints = joints.iter().map(String::as_str);
    let names: Vec<&str> = joints.chain(columns.iter().copied()).collect();
    let mut text = format!("t,pose,{}\n", names.join(","));
    for (k, row) in rows.enumerate() {
        write!(text, "{},{k}", apart_s * k as f64)?;
        for x in row {
            write!(text, ",{x}")?;
        }
        text.push('\n');
    }
    Ok(text)
}
