//! Several logs of one robot on one day as one log.

use std::sync::Arc;

use sesc_model::tree::Dof;

use crate::Error;
use crate::logs::{Block, LogSource, Options, PostureReader, Sidecar, Table};

/// Rows read at once.
const BLOCK: usize = 4096;
/// Time between two logs, s: longer than any correlation between their readings.
const PAUSE_S: f64 = 3600.0;

/// Columns put together log by log, in SI units.
#[derive(Default)]
struct Columns {
    pose: Vec<i64>,
    t: Vec<f64>,
    support: Vec<Arc<str>>,
    q: Vec<f64>,
    reading: Vec<[f64; 2]>,
    std: Vec<[f64; 2]>,
    gravity: Vec<[f64; 3]>,
    /// Logs that have each of these.
    timed: usize,
    supported: usize,
    deviating: usize,
    tilted: usize,
}

/// One log of several, in their order: postures are numbered on, times run on after a
/// pause, and the CoP is in place of foot cells.
///
/// # Errors
/// A log that cannot be read, or logs of which some have what others lack.
pub(super) fn together(
    logs: &[LogSource],
    dofs: &[Dof],
    options: &Options,
) -> Result<LogSource, Error> {
    let name = "the logs of this group";
    let mut all = Columns::default();
    let mut first: Option<Sidecar> = None;
    for log in logs {
        let mut reader = PostureReader::open(log, dofs, options)?;
        let sidecar = plain(&reader.sidecar);
        match &first {
            None => first = Some(sidecar),
            Some(known) if *known == sidecar => {}
            Some(_) => {
                return Err(Error::log(
                    log.name(),
                    None,
                    "its sidecar differs from that of another log of the same group; give them \
                     groups of their own",
                ));
            }
        }
        all.append(&mut reader)?;
    }
    let mut sidecar = first.unwrap_or_default();
    let count = logs.len();
    for (has, what) in [
        (all.deviating, "standard deviations"),
        (all.tilted, "gravity"),
        (all.supported, "a support"),
    ] {
        if has != 0 && has != count {
            return Err(Error::request(format!(
                "{has} of {count} logs of this group have {what}; give all of them or none"
            )));
        }
    }
    if all.deviating > 0 {
        // Deviations are those of rows already.
        sidecar.readings_per_pose = None;
    }
    let mut table = Table::new(name).integers("pose", all.pose);
    if all.timed == count {
        table = table.numbers("t", all.t);
    }
    if all.supported > 0 {
        table = table.texts("support", all.support);
    }
    let dof = dofs.len();
    for (k, joint) in dofs.iter().enumerate() {
        let column: Vec<f64> = all.q.iter().skip(k).step_by(dof).copied().collect();
        table = table.numbers(&joint.joint, column);
    }
    let column = |values: &[[f64; 2]], axis: usize| -> Vec<f64> {
        values.iter().map(|value| value[axis]).collect()
    };
    for (axis, name) in ["cop_x", "cop_y"].into_iter().enumerate() {
        table = table.numbers(name, column(&all.reading, axis));
        if all.deviating > 0 {
            table = table.numbers(&format!("{name}_std"), column(&all.std, axis));
        }
    }
    if all.tilted > 0 {
        for (axis, name) in ["gravity_x", "gravity_y", "gravity_z"]
            .into_iter()
            .enumerate()
        {
            let column: Vec<f64> = all.gravity.iter().map(|g| g[axis]).collect();
            table = table.numbers(name, column);
        }
    }
    Ok(LogSource::from(table).with_sidecar(sidecar))
}

/// What of a sidecar is about the rows as they are put together.
fn plain(sidecar: &Sidecar) -> Sidecar {
    Sidecar {
        robot: None,
        support: None,
        angles: None,
        cells: None,
        gravity: None,
        topic: None,
        columns: None,
        ..sidecar.clone()
    }
}

impl Columns {
    fn append(&mut self, reader: &mut PostureReader) -> Result<(), Error> {
        let numbered = self.pose.iter().max().map_or(0, |last| last + 1);
        let later = self.t.iter().copied().fold(f64::NEG_INFINITY, f64::max) + PAUSE_S;
        let (mut start, mut least) = (None, None);
        let mut has = [false; 4];
        loop {
            let block = reader.block(BLOCK)?;
            if block.is_empty() {
                break;
            }
            let Block {
                pose,
                t,
                support,
                q,
                reading,
                std,
                gravity,
                ..
            } = block;
            // Numbers need not begin at zero.
            let least = *least.get_or_insert(pose.iter().copied().min().unwrap_or(0));
            let number = |pose: &i64| pose.saturating_sub(least).saturating_add(numbered);
            self.pose.extend(pose.iter().map(number));
            if let Some(t) = t {
                let start = *start.get_or_insert(t.first().copied().unwrap_or(0.0));
                let from = if later.is_finite() { later } else { start };
                self.t.extend(t.iter().map(|t| t - start + from));
                has[0] = true;
            }
            if let Some(support) = support {
                self.support.extend(support);
                has[1] = true;
            }
            self.q.extend(q);
            self.reading.extend(reading.unwrap_or_default());
            if let Some(std) = std {
                self.std.extend(std);
                has[2] = true;
            }
            if let Some(gravity) = gravity {
                self.gravity.extend(gravity);
                has[3] = true;
            }
        }
        self.timed += usize::from(has[0]);
        self.supported += usize::from(has[1]);
        self.deviating += usize::from(has[2]);
        self.tilted += usize::from(has[3]);
        Ok(())
    }
}
