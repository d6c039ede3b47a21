//! From log files to factors: block by block, once, or a few times over for a
//! robust fit.

use super::criteria::TO_SEE_OUTLIERS;
use nalgebra::{DMatrix, DVector};
use sesc_model::{Model, Snapping};

use super::gather::{Folding, Gathered, LogUsed};
use super::prior::{Prior, Tolerances};
use super::robust::{self, Loss, MEDIAN_OF_PAIRS, Robust};
use super::timing::Timing;
use crate::logs::{LogSource, Options, PostureReader};
use crate::observations::motion::{Plan, Wanted};
use crate::observations::motion_use::MotionModel;
use crate::observations::moving::Moving;
use crate::observations::postures::{Postures, Taking};
use crate::observations::rows::Measurement;
use crate::robot::Robot;
use crate::watch::{Watch, tell};
use crate::{Error, Setting, message};

/// Rows folded in together.
pub(super) const BLOCK: usize = 4096;
/// Residuals kept to take a median of.
const SAMPLE: usize = 100_000;
/// Rounds of reweighting, at most.
const ROUNDS: usize = 20;
/// Part of the readings that reweighting leaves at least. The scale comes from the median, so
/// that half of sound readings keep nearly all their weight.
const LEAST_LEFT: f64 = 0.25;
/// Change of predicted readings at which reweighting ends, in units of their scale.
const SETTLED: f64 = 1e-4;

/// Whether every pass read the same bytes.
///
/// # Errors
/// Names a log that changed between two passes.
fn check_unchanged(before: &[LogUsed], now: &[LogUsed]) -> Result<(), Error> {
    let differs = |(one, other): &(&LogUsed, &LogUsed)| one.hash != other.hash;
    match before.iter().zip(now).find(differs) {
        Some((log, _)) => Err(changed(&log.file)),
        None => Ok(()),
    }
}

fn changed(log: &str) -> Error {
    let message = "it changed while it was read; wait until it is written, and fit again";
    Error::log(log, None, message)
}

/// Logs of one robot.
pub struct Logs<'r> {
    /// The robot that was logged.
    pub robot: &'r Robot,
    /// The logs.
    pub files: &'r [LogSource],
    /// How to read them; a support given here is that of rows without their own.
    pub options: Options,
    /// The support whose parameters are meant; that of the first row unless given.
    pub support: Option<String>,
    /// How decimals of right angles are read.
    pub snapping: Snapping,
    /// Folds of the cross-validation.
    pub folds: usize,
    /// One number is given for the noise of both axes.
    pub one_noise: bool,
    /// Whether the motion of the joints counts.
    pub motion: MotionModel,
}

impl<'r> Logs<'r> {
    /// Read all logs into factors.
    ///
    /// # Errors
    /// Whatever is wrong with a log, its sidecar or its support.
    pub fn gather(
        &self,
        loss: Option<Loss>,
        prior: &dyn Fn(&Model) -> Result<Prior, Error>,
        watch: &mut dyn Watch,
    ) -> Result<(Measurement<'r>, Gathered), Error> {
        let mut measurement = Measurement::new(self.robot, &self.first_support()?, self.snapping)?;
        let masses = self.masses(measurement.model(), prior)?;
        let mut timings = Vec::new();
        for file in self.files {
            let mut reader = self.open(file)?;
            let apart = (self.folds, !self.one_noise);
            let timing = Timing::read(&mut reader, &mut measurement, apart, self.motion, &masses)?;
            timings.push(timing);
        }
        let gathered = self.pass(&mut measurement, &timings, None, "reading", watch)?;
        let Some(loss) = loss else {
            return Ok((measurement, gathered));
        };
        let cad = DVector::from_vec(measurement.model().cad_params());
        let prior = prior(measurement.model())?.covariance_factor(measurement.model());
        let stated = gathered.has_deviations();
        let whole = gathered.together();
        let rows = whole.weighted.rows() as f64;
        let free = whole.solve(1.0, &cad, None);
        let mut params = free.params;
        // What a fit takes up does not show in its residuals.
        let mut taken = free.rank as f64;
        let mut gathered = gathered;
        for _ in 0..ROUNDS {
            if rows - taken < TO_SEE_OUTLIERS {
                let few = format!(
                    ": {rows} rows for {taken:.0} parameters leave nothing to tell an outlier by; \
                     add postures, or take "
                );
                let prior = Setting::Prior;
                return Err(Error::request(message![
                    Setting::Robust,
                    few,
                    prior,
                    " cad"
                ]));
            }
            let shrunk = (1.0 - taken / rows).sqrt();
            let seen = self.scale(&mut measurement, &timings, &params)? / shrunk;
            // Noise that is stated is no outlier.
            let scale = if stated { seen.max(1.0) } else { seen };
            let robust = Robust { loss, scale };
            let weights = Some((&robust, &params));
            let before = gathered.logs;
            gathered = self.pass(&mut measurement, &timings, weights, "reweighting", watch)?;
            check_unchanged(&before, &gathered.logs)?;
            let left = gathered.trusted / gathered.readings.max(1) as f64;
            if left.is_nan() || left < LEAST_LEFT {
                let few = format!(
                    ": it leaves {:.0} % of {} readings, so that they are not readings with \
                     outliers; look at the log, or fit without ",
                    100.0 * left,
                    gathered.readings
                );
                return Err(Error::request(message![
                    Setting::Robust,
                    few,
                    Setting::Robust
                ]));
            }
            let whole = gathered.together();
            let next = whole.solve(scale, &cad, prior.as_ref());
            let r = whole.weighted.r();
            taken = (&r * &next.covariance * r.transpose()).trace() / (scale * scale);
            let rms = (&r * (&next.params - &params)).norm() / rows.sqrt();
            params = next.params;
            if rms <= SETTLED * scale {
                break;
            }
        }
        Ok((measurement, gathered))
    }

    /// The postures of a log, one of those that were `used`, that stand on the model's support;
    /// none where none does, or where the log can be read once only.
    ///
    /// # Errors
    /// A log that cannot be read once more, or is another than it was; the kind `Interrupted`
    /// where `watch` stops it.
    pub(super) fn postures(
        &self,
        log: &LogSource,
        used: &[LogUsed],
        model: &Model,
        watch: &mut dyn Watch,
    ) -> Result<Option<Postures>, Error> {
        if !log.can_be_read_again() {
            return Ok(None);
        }
        let mut options = self.options.clone();
        options.support = Some(model.support().to_string());
        let taking = Taking {
            options,
            noise: None,
            floor: 0.0,
        };
        let data = Postures::read_some(log, model, &taking, watch)?;
        let read = data.as_ref().and_then(|data| data.summary.as_ref());
        if read.is_some_and(|read| used.iter().all(|log| log.hash != read.hash)) {
            return Err(changed(log.name()));
        }
        Ok(data)
    }

    /// F of how far masses may be off: as was asked, or as they usually are.
    fn masses(
        &self,
        model: &Model,
        prior: &dyn Fn(&Model) -> Result<Prior, Error>,
    ) -> Result<DMatrix<f64>, Error> {
        let usual = || Prior::Cad(Tolerances::usual()).covariance_factor(model);
        let factor = prior(model)?.covariance_factor(model).or_else(usual);
        Ok(factor.unwrap_or_else(|| DMatrix::zeros(model.base.params.len(), 0)))
    }

    /// The support whose parameters are meant.
    pub(super) fn first_support(&self) -> Result<String, Error> {
        if let Some(support) = &self.support {
            return Ok(support.clone());
        }
        let mut named = None;
        if let Some(file) = self.files.first() {
            named = self.open(file)?.first_support()?;
        }
        match named.filter(|link| !link.is_empty()) {
            Some(link) => Ok(link.to_string()),
            None => {
                let mut end =
                    ", `support = \"LINK\"` to the log's sidecar or a column `support`".to_string();
                if let Some(file) = self.files.first() {
                    let odd = file.sidecar()?.1.into_iter();
                    end.extend(odd.map(|message| format!("; {message}")));
                }
                end += &self.robot.feet_note();
                let start = "no support link: add ";
                Err(Error::request(message![start, Setting::Support, end]))
            }
        }
    }

    /// Open one of the logs.
    pub(super) fn open(&self, file: &LogSource) -> Result<PostureReader, Error> {
        PostureReader::of_robot(file, &self.robot.description, &self.options)
    }

    /// Open one of the logs, whose motion is known by `plan`.
    pub(super) fn moving(&self, file: &LogSource, plan: Option<&Plan>) -> Result<Moving, Error> {
        let reader = self.open(file)?;
        let dof = reader.dof;
        Ok(Moving::new(reader, dof, plan.cloned(), Wanted::Smooth))
    }

    /// One pass over all logs.
    fn pass(
        &self,
        measurement: &mut Measurement<'r>,
        timings: &[Timing],
        robust: Option<(&Robust, &DVector<f64>)>,
        what: &'static str,
        watch: &mut dyn Watch,
    ) -> Result<Gathered, Error> {
        let params = measurement.model().base.params.len();
        let mut gathered = Gathered::new(params, self.folds);
        for (file, timing) in self.files.iter().zip(timings) {
            let name = file.name();
            let mut reader = self.moving(file, timing.plan.as_ref())?;
            gathered.begin_log(timing);
            let mut folding = Folding::default();
            loop {
                let (block, motion) = reader.known_rows(BLOCK)?;
                for warning in reader.warnings.drain(..) {
                    if robust.is_none() {
                        watch.warning(&warning);
                    }
                }
                if block.is_empty() {
                    break;
                }
                if block.len() == BLOCK {
                    folding.begin(&mut gathered.folds);
                }
                let rows = (&block, motion.as_ref());
                gathered.push_moving(measurement, rows, name, robust, &mut folding)?;
                let (done, total) = reader.progress();
                tell(watch, what, done, total)?;
            }
            if let Some(summary) = reader.summary() {
                if gathered.logs.iter().any(|log| log.hash == summary.hash) {
                    return Err(Error::request(format!(
                        "{name}: given twice, its postures would count twice"
                    )));
                }
                gathered.logs.push(LogUsed {
                    file: file.file_name().to_string(),
                    hash: summary.hash,
                    rows: summary.rows,
                    times: summary.times,
                });
                gathered.averaged += reader.averaged() * summary.rows as f64;
            }
            gathered.join_reached_again(measurement)?;
            gathered.end_log_without(reader.left_out, folding);
        }
        Ok(gathered)
    }

    /// Scale of the residuals by their median: outliers do not move it.
    fn scale(
        &self,
        measurement: &mut Measurement<'r>,
        timings: &[Timing],
        params: &DVector<f64>,
    ) -> Result<f64, Error> {
        let mut lengths: Vec<f64> = Vec::new();
        for (file, timing) in self.files.iter().zip(timings) {
            let mut reader = self.moving(file, timing.plan.as_ref())?;
            while lengths.len() < SAMPLE {
                let (block, motion) = reader.known_rows(BLOCK)?;
                if block.is_empty() {
                    break;
                }
                let rows = measurement.moving_rows(&block, motion.as_ref())?;
                let ones = vec![[1.0; 2]; block.len()];
                let std = block.std.as_ref().unwrap_or(&ones);
                lengths.extend(robust::lengths(&rows, std, params));
            }
        }
        lengths.sort_by(f64::total_cmp);
        let median = lengths.get(lengths.len() / 2).copied().unwrap_or(0.0);
        Ok((median / MEDIAN_OF_PAIRS).max(f64::MIN_POSITIVE))
    }
}

#[cfg(test)]
mod tests {
    use std::io::{self, Read};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::super::{Request, gather};
    use crate::logs::LogSource;
    use crate::robot::{ROD, Robot};

    /// A log of which opening number `odd` gives something else.
    fn gathered(odd: usize, breaks: bool) -> (usize, Option<String>) {
        let row = |k: u32, shift: f64| {
            let q = (0.7 * f64::from(k)).sin();
            format!("{k},{q},{},0\n", 0.11 * q.sin() + shift)
        };
        let rows = move |shift| (0..20).map(|k| row(k, shift)).collect::<String>();
        let opened = Arc::new(AtomicUsize::new(0));
        let counter = Arc::clone(&opened);
        let stream = LogSource::stream("run.csv", move || {
            let is_odd = counter.fetch_add(1, Ordering::Relaxed) == odd;
            if is_odd && breaks {
                return Err(io::Error::other("the line broke"));
            }
            let text = "pose,hip,cop_x,cop_y\n".to_string() + &rows(f64::from(is_odd) * 1e-3);
            Ok(io::Cursor::new(text).chain(io::empty()))
        });
        let request = Request {
            robot: Some(Arc::new(Robot::parse(ROD, "rod.urdf").unwrap())),
            logs: vec![stream],
            support: Some("foot".into()),
            ..Request::default()
        };
        let error = gather(&request, &mut ()).err();
        let error = error.map(|error| format!("{error:?}"));
        (opened.load(Ordering::Relaxed), error)
    }

    /// Also in the last pass, which looks for postures to reach once more.
    #[test]
    fn a_log_that_breaks_or_changes_between_passes_is_an_error() {
        let (passes, error) = gathered(usize::MAX, false);
        assert!(passes > 2 && error.is_none(), "{passes}: {error:?}");
        for odd in 0..passes {
            let (_, error) = gathered(odd, true);
            let error = error.unwrap_or_else(|| panic!("pass {odd} of {passes}"));
            assert!(error.contains("the line broke"), "{error}");
        }
        // A pass that opens a log for its sidecar alone sees no rows.
        let changed = (0..passes).filter_map(|odd| gathered(odd, false).1);
        let changed: Vec<String> = changed.collect();
        assert!(!changed.is_empty());
        for error in changed {
            assert!(error.contains("changed while it was read"), "{error}");
        }
    }
}
