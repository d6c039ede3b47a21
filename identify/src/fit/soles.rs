//! Whether the soles of logs of both feet close: what a fit of masses cannot repair.
//!
//! Masses move no sole. A joint offset that bends a leg ends in the masses of a fit, unless
//! somebody looks at the soles.

use super::gather::LogUsed;
use super::logs::Logs;
use crate::Error;
use crate::feet::{Closure, ClosureFound, Feet, of_many, of_one_foot};
use crate::watch::Watch;

/// How the soles lie in the log in which they lie worst; none where no log is of both feet.
///
/// # Errors
/// When the other sole cannot be told, or a log that was `used` cannot be read once more; the kind `Interrupted` where `watch` stops it.
pub(super) fn worst(
    logs: &Logs,
    used: &[LogUsed],
    feet: &Feet,
    watch: &mut dyn Watch,
) -> Result<Option<ClosureFound>, Error> {
    let first = logs.first_support()?;
    let mut worst: Option<ClosureFound> = None;
    for log in logs.files {
        let (mut sidecar, _) = log.sidecar()?;
        if sidecar.both_feet.or(feet.both).is_none() && log.can_be_read_again() {
            // A recording of both contacts says it itself.
            sidecar = logs.open(log)?.sidecar;
        }
        let own = logs.options.support.as_ref().or(sidecar.support.as_ref());
        let support = own.unwrap_or(&first);
        let model = logs.robot.model(support, logs.snapping, None)?;
        let Some(other) = feet.of(&sidecar, &model)? else {
            continue;
        };
        if let Some(note) = of_many(&model, &other) {
            watch.note(&note);
        }
        let Some(data) = logs.postures(log, used, &model, watch)? else {
            watch.note("the soles of a log that can be read once only are not looked at");
            continue;
        };
        if let Some(warning) = of_one_foot(&model, &other, &data) {
            watch.warning(&format!("{}: {warning}", log.name()).into());
        }
        let found = Closure::of(&model, other, &data.q, data.t.as_deref()).found();
        worst = Some(match worst {
            Some(worst) => worst.worse(found),
            None => found,
        });
    }
    Ok(worst)
}
