//! The sidecar of a log: `<stem>.toml` beside `<stem>.csv`, all keys optional.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::Error;

/// What a log's sidecar may say.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sidecar {
    /// A name, for reports.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// The link that stands on the ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub support: Option<String>,
    /// `rad` (default) or `deg`, of the turning joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angles: Option<Angles>,
    /// Readings averaged into one row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub readings_per_pose: Option<u64>,
    /// Places of the foot cells, m, support frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<Vec<[f64; 2]>>,
    /// Gravity in the support frame, m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<[f64; 3]>,
}

/// Unit of the turning joints' columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Angles {
    Rad,
    Deg,
}

impl Sidecar {
    /// Where the sidecar of `log` is.
    pub fn path(log: &Path) -> PathBuf {
        log.with_extension("toml")
    }

    /// Read the sidecar of `log`; a log without one has an empty one.
    pub fn of(log: &Path) -> Result<Sidecar, Error> {
        let path = Sidecar::path(log);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Ok(Sidecar::default());
            }
            Err(source) => {
                return Err(Error::Read {
                    file: path.display().to_string(),
                    source,
                });
            }
        };
        let bad = |message: String| Error::Log {
            file: path.display().to_string(),
            line: None,
            message,
        };
        let sidecar: Sidecar = toml::from_str(&text).map_err(|error| bad(error.to_string()))?;
        if let Some([x, y, z]) = sidecar.gravity {
            let usable = x.is_finite() && y.is_finite() && z.is_finite() && z < 0.0;
            if !usable {
                return Err(bad(format!(
                    "gravity [{x}, {y}, {z}] does not pull onto the sole; its z must be negative"
                )));
            }
        }
        Ok(sidecar)
    }
}
