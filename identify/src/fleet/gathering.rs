//! What groups came to, put together in whatever order they come.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sesc_model::Snapping;

use super::disk::Disk;
use super::failed::Failed;
use super::row::Row;
use super::table::assembled;
use super::work::Done;
use crate::robot::Robot;

/// A log that was given before under another name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Twice {
    /// The file.
    pub input: String,
    /// The file with the same bytes.
    pub same_as: String,
    /// Whether both count once, as logs of one robot and day.
    pub counted_once: bool,
}

/// Everything that was found, group by group.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Fleet {
    /// A row per robot and day, sorted.
    pub rows: Vec<Row>,
    /// Logs with errors, sorted by name.
    pub failed: Vec<Failed>,
    /// Logs that came more than once, sorted by name.
    pub twice: Vec<Twice>,
    /// Rows that were in the store.
    pub from_store: usize,
    /// Logs that were opened; the others the store knew.
    pub opened: usize,
    /// Names of the base parameters, by the hash of the URDF and the support.
    pub names: BTreeMap<(String, String), Vec<String>>,
}

/// A path with its robot and day.
type Place = (String, (String, String));

/// A fleet while its groups come in.
#[derive(Debug, Default)]
pub struct Gathering {
    fleet: Fleet,
    /// Places of every log by the hash of its content.
    places: BTreeMap<String, Vec<Place>>,
    /// URDFs other than the fleet's, by hash and support.
    urdfs: BTreeMap<(String, String), Option<PathBuf>>,
}

impl Gathering {
    /// Take over what a group came to.
    pub fn add(&mut self, done: Done) {
        let Done {
            row,
            failed,
            read,
            opened,
            from_store,
            urdf,
        } = done;
        self.fleet.failed.extend(failed);
        self.fleet.from_store += usize::from(from_store);
        self.fleet.opened += opened;
        for (hash, path) in read {
            let of = (row.robot.clone(), row.day.clone());
            let place = (path.display().to_string(), of);
            self.places.entry(hash).or_default().push(place);
        }
        if !row.params.is_empty() {
            let key = (row.urdf_hash.clone(), row.support.clone());
            self.urdfs.entry(key).or_insert(urdf);
        }
        self.fleet.rows.push(row);
    }

    /// All groups together; `robot` is that of groups without a URDF of their own, and `disk`
    /// has the others.
    pub fn finish(self, robot: &Arc<Robot>, disk: &dyn Disk) -> Fleet {
        let Gathering {
            mut fleet,
            places,
            urdfs,
        } = self;
        for mut same in places.into_values() {
            same.sort();
            let (first, of) = same[0].clone();
            for (input, its) in same.drain(1..) {
                fleet.twice.push(Twice {
                    input,
                    same_as: first.clone(),
                    counted_once: its == of,
                });
            }
        }
        for (key, urdf) in urdfs {
            let names = match urdf {
                None => names(robot, &key.1),
                Some(path) => disk
                    .robot(&path)
                    .map_or_else(|_| Vec::new(), |own| names(&own, &key.1)),
            };
            fleet.names.insert(key, names);
        }
        fleet.failed.sort();
        fleet.twice.sort();
        fleet.rows = assembled(std::mem::take(&mut fleet.rows));
        fleet
    }
}

/// Names of the base parameters.
fn names(robot: &Robot, support: &str) -> Vec<String> {
    let model = robot.model(support, Snapping::default(), None);
    model.map_or_else(
        |_| Vec::new(),
        |model| model.base.params.iter().map(|p| p.name.clone()).collect(),
    )
}
