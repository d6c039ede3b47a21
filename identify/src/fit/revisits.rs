//! Which postures of a log to reach once more, where nothing tells its noise.

use super::gather::Gathered;
use super::logs::Logs;
use crate::Error;
use crate::observations::revisits::Again;
use crate::observations::rows::CopRows;
use crate::watch::Watch;

/// Longer logs are recordings: they are not read once more.
const ROWS: u64 = 20_000;

/// Estimates the noise of the first log again, if its rows state no deviations and no posture
/// of any repeats.
///
/// # Errors
/// No support; the kind `Interrupted` where `watch` stops it.
pub(super) fn of(
    logs: &Logs,
    gathered: &Gathered,
    watch: &mut dyn Watch,
) -> Result<Option<Again>, Error> {
    let (_, repeats) = gathered.repeats.pure().both();
    let Some(log) = logs.files.first() else {
        return Ok(None);
    };
    let told = gathered.has_deviations() || repeats > 0;
    if told || gathered.readings > ROWS {
        return Ok(None);
    }
    let support = logs.first_support()?;
    let model = logs.robot.model(&support, logs.snapping, None)?;
    let Some(data) = logs.postures(log, &model, watch)? else {
        return Ok(None);
    };
    let rows = CopRows::new(&model).of(&data.q, data.len(), None);
    Ok(Again::of(&rows, &data.pose, data.t.as_deref()))
}
