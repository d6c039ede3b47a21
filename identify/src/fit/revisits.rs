//! Which postures of a log to reach once more, where nothing tells its noise, or how visits of one
//! posture differ.

use super::gather::Gathered;
use super::logs::Logs;
use crate::Error;
use crate::observations::revisits::{Again, Untold};
use crate::watch::Watch;

/// Longer logs are recordings: they are not read once more.
const ROWS: u64 = 20_000;

/// Those of the first log, if no posture of any was visited again, and rows do not state
/// deviations of single readings.
///
/// # Errors
/// No support; a log that cannot be read once more; the kind `Interrupted` where `watch` stops it.
pub(super) fn of(
    logs: &Logs,
    gathered: &Gathered,
    watch: &mut dyn Watch,
) -> Result<Option<Again>, Error> {
    let repeats = &gathered.repeats;
    let untold = match (repeats.rows > repeats.postures, gathered.has_deviations()) {
        (true, _) if repeats.visits == repeats.postures => Untold::Visits,
        (false, false) => Untold::Noise,
        _ => return Ok(None),
    };
    let Some(log) = logs.files.first() else {
        return Ok(None);
    };
    if gathered.readings > ROWS {
        return Ok(None);
    }
    let support = logs.first_support()?;
    let model = logs.robot.model(&support, logs.snapping, None)?;
    let data = logs.postures(log, &gathered.logs, &model, watch)?;
    Ok(data.and_then(|data| Again::of(untold, &model, &data)))
}
