//! From logs to factors: rows are read once, looked at, and folded in block by block, a few times
//! over for a robust fit.

use std::sync::{Arc, Mutex};

use nalgebra::{DMatrix, DVector};
use sesc_model::Model;

use super::criteria::TO_SEE_OUTLIERS;
use super::gather::{Gathered, LogUsed, fold_in};
use super::prior::Tolerances;
use super::request::{FOLDS, Request};
use super::robust::{self, Loss, MEDIAN_OF_PAIRS, Robust};
use super::timing::Timing;
use crate::feet::{Closure, ClosureFound, Places, of_many, of_one_foot};
use crate::health::{self, Finding};
use crate::logs::{BLOCK, Options, ROOM, Readings, Samples, Weight};
use crate::observations::motion::Wanted;
use crate::observations::moving::Moving;
use crate::observations::postures::Postures;
use crate::observations::revisits::{Again, Untold};
use crate::observations::rows::Measurement;
use crate::robot::Robot;
use crate::threads::both;
use crate::watch::{Watch, tell};
use crate::{Error, Setting, message};

/// Residuals kept to take a median of.
const SAMPLE: usize = 100_000;
/// Rounds of reweighting, at most.
const ROUNDS: usize = 20;
/// Part of the readings that reweighting leaves at least. The scale comes from the median, so
/// that half of sound readings keep nearly all their weight.
const LEAST_LEFT: f64 = 0.25;
/// Change of predicted readings at which reweighting ends, in units of their scale.
const SETTLED: f64 = 1e-4;
/// Longer logs are recordings: no postures are proposed to be reached once more.
const ROWS_OF_POSTURES: u64 = 20_000;

/// The logs of a request, without rows that cannot be used.
pub(super) struct Logs<'r> {
    request: &'r Request,
    robot: Arc<Robot>,
    samples: Vec<Samples>,
    /// The support whose parameters are meant.
    support: String,
    /// Folds of the cross-validation.
    folds: usize,
    /// What is wrong with them.
    findings: Vec<Finding>,
    /// What is known of the noise and the motion of each log, once they were gathered.
    pub timings: Vec<Timing>,
}

impl<'r> Logs<'r> {
    /// Read the logs of a request and look at them.
    /// `support` and `folds` are those of the parts that they go with; `alone` says whether they are
    /// one log that is fitted without others.
    ///
    /// # Errors
    /// Whatever is wrong with a log, its sidecar or its support; the kind `Interrupted` where
    /// `watch` stops it.
    pub(super) fn read(
        request: &'r Request,
        robot: Arc<Robot>,
        (support, folds): (Option<String>, Option<usize>),
        alone: bool,
        watch: &mut dyn Watch,
    ) -> Result<Logs<'r>, Error> {
        let links = robot.description.link_names();
        let options = Options {
            angles: request.angles,
            readings: Readings::Required,
            links: links.map(str::to_string).collect(),
            support: request.support.clone(),
            stays: request.stays,
            soles: Some(Places::of(&robot, request.snapping)),
            both_feet: request.feet.said(),
            ..Options::default()
        };
        if let Some(support) = &support {
            robot.model(support, request.snapping, None)?;
        }
        let (mut read, mut room) = (Vec::new(), ROOM);
        for log in &request.logs {
            let samples = Samples::read(log, &robot.description, &options, room, watch)?;
            room = room.saturating_sub(samples.size());
            read.push(samples);
        }
        let support = match support {
            Some(support) => support,
            None => first_support(read.first(), &robot)?,
        };
        let model = robot.model(&support, request.snapping, None)?;
        let (mut samples, mut findings) = (Vec::new(), Vec::new());
        for read in read {
            let look = (request.snapping, request.noise, alone);
            let (usable, found) = health::look(read, (&robot, &model), look, watch)?;
            samples.push(usable);
            findings.extend(found);
        }
        Ok(Logs {
            request,
            robot,
            samples,
            support,
            folds: folds.or(request.folds).unwrap_or(FOLDS),
            findings,
            timings: Vec::new(),
        })
    }

    /// Rows for the parameters of the support that is meant.
    ///
    /// # Errors
    /// A support that the robot does not have.
    pub(super) fn measurement(&self) -> Result<Measurement<'_>, Error> {
        Measurement::new(&self.robot, &self.support, self.request.snapping)
    }

    /// All logs in factors, with the links that they stood on, the one of the parameters first.
    ///
    /// # Errors
    /// Whatever is wrong with a log, its sidecar or its support.
    pub(super) fn gather(
        &mut self,
        watch: &mut dyn Watch,
    ) -> Result<(Vec<String>, Gathered), Error> {
        let (request, robot) = (self.request, Arc::clone(&self.robot));
        let mut measurement = Measurement::new(&robot, &self.support, request.snapping)?;
        let masses = self.masses(measurement.model())?;
        let usual = Tolerances::usual().factor(measurement.model());
        let tolerances = (&masses, &usual);
        for samples in &self.samples {
            let apart = (self.folds, request.noise.is_none());
            let mut rows = samples.rows()?;
            let timing = Timing::read(
                &mut rows,
                &mut measurement,
                apart,
                request.motion,
                tolerances,
            )?;
            self.timings.push(timing);
        }
        let mut gathered = self.pass(&mut measurement, None, "reading", watch)?;
        if let Some(loss) = request.robust {
            gathered = self.reweighted(gathered, loss, &mut measurement, watch)?;
        }
        if request.noise.is_none() {
            gathered.again = self.again(&gathered, watch)?;
        }
        gathered.closure = self.closure(watch)?;
        let weights = self.samples.iter().filter_map(|samples| samples.weight);
        gathered.weight = weights.reduce(Weight::farther);
        gathered.health.append(&mut self.findings);
        let supports = measurement.supports();
        Ok((supports.into_iter().map(str::to_string).collect(), gathered))
    }

    /// The same logs with postures that `loss` trusts less.
    fn reweighted(
        &self,
        mut gathered: Gathered,
        loss: Loss,
        measurement: &mut Measurement<'_>,
        watch: &mut dyn Watch,
    ) -> Result<Gathered, Error> {
        let cad = DVector::from_vec(measurement.model().cad_params());
        let prior = self.request.prior.of(measurement.model())?;
        let prior = prior.covariance_factor(measurement.model());
        let stated = gathered.has_deviations();
        let whole = gathered.together();
        let rows = whole.weighted.rows() as f64;
        let free = whole.seen().solve(&whole.weighted, 1.0, &cad, None);
        let mut params = free.params;
        // What a fit takes up does not show in its residuals.
        let mut taken = free.rank as f64;
        for _ in 0..ROUNDS {
            if rows - taken < TO_SEE_OUTLIERS {
                let few = format!(
                    ": {rows} rows for {taken:.0} parameters leave nothing to tell an outlier by; \
                     add postures, or take "
                );
                let (robust, prior) = (Setting::Robust, Setting::Prior);
                return Err(Error::request(message![robust, few, prior, " cad"]));
            }
            let shrunk = (1.0 - taken / rows).sqrt();
            let seen = self.scale(measurement, &params)? / shrunk;
            // Noise that is stated is no outlier.
            let scale = if stated { seen.max(1.0) } else { seen };
            let robust = Robust { loss, scale };
            let weights = Some((&robust, &params));
            gathered = self.pass(measurement, weights, "reweighting", watch)?;
            let left = gathered.trusted / gathered.readings.max(1) as f64;
            if left.is_nan() || left < LEAST_LEFT {
                let few = format!(
                    ": it leaves {:.0} % of {} readings, so that they are not readings with \
                     outliers; look at the log, or fit without ",
                    100.0 * left,
                    gathered.readings
                );
                let robust = Setting::Robust;
                return Err(Error::request(message![robust, few, robust]));
            }
            let whole = gathered.together();
            let next = whole
                .seen()
                .solve(&whole.weighted, scale, &cad, prior.as_ref());
            let r = whole.weighted.r();
            taken = (&r * &next.covariance * r.transpose()).trace() / (scale * scale);
            let rms = (&r * (&next.params - &params)).norm() / rows.sqrt();
            params = next.params;
            if rms <= SETTLED * scale {
                break;
            }
        }
        Ok(gathered)
    }

    /// Postures of the first log to reach once more, if no posture of any was visited again, and
    /// rows do not state deviations of single readings.
    fn again(&self, gathered: &Gathered, watch: &mut dyn Watch) -> Result<Option<Again>, Error> {
        let repeats = &gathered.repeats;
        let untold = match (repeats.rows > repeats.postures, gathered.has_deviations()) {
            (true, _) if repeats.visits == repeats.postures => Untold::Visits,
            (false, false) => Untold::Noise,
            _ => return Ok(None),
        };
        let first = self.samples.first();
        let Some(log) = first.filter(|_| gathered.readings <= ROWS_OF_POSTURES) else {
            return Ok(None);
        };
        let model = self
            .robot
            .model(&self.support, self.request.snapping, None)?;
        let data = Postures::read_some(log, &model, (None, 0.0), watch)?;
        Ok(data.and_then(|data| Again::of(untold, &model, &data)))
    }

    /// How the soles lie in the log of both feet in which they lie worst: masses move no sole, and
    /// a joint offset that bends a leg would end in the masses of a fit.
    fn closure(&self, watch: &mut dyn Watch) -> Result<Option<ClosureFound>, Error> {
        let mut worst: Option<ClosureFound> = None;
        for samples in &self.samples {
            let sidecar = &samples.sidecar;
            let own = self.request.support.as_ref().or(sidecar.support.as_ref());
            let support = own.unwrap_or(&self.support);
            let model = self.robot.model(support, self.request.snapping, None)?;
            let Some(other) = self.request.feet.of(sidecar, &model)? else {
                continue;
            };
            if let Some(note) = of_many(&model, &other) {
                watch.note(&note);
            }
            let Some(data) = Postures::read_some(samples, &model, (None, 0.0), watch)? else {
                continue;
            };
            if let Some(warning) = of_one_foot(&model, &other, &data) {
                watch.warning(&format!("{}: {warning}", samples.log.name()).into());
            }
            let found = Closure::of(&model, other, &data.q, data.t.as_deref()).found_by("CAD");
            worst = worst.into_iter().chain([found]).reduce(ClosureFound::worse);
        }
        Ok(worst)
    }

    /// F of how far masses may be off: as was asked, or as they usually are.
    fn masses(&self, model: &Model) -> Result<DMatrix<f64>, Error> {
        let factor = self.request.prior.of(model)?.covariance_factor(model);
        Ok(factor.unwrap_or_else(|| Tolerances::usual().factor(model)))
    }

    /// Each log with its rows, whose motion is known by its plan.
    ///
    /// # Errors
    /// A log that cannot be read once more.
    pub(super) fn moving(&self) -> impl Iterator<Item = Result<(&Samples, Moving), Error>> {
        self.samples.iter().enumerate().map(|(k, samples)| {
            let plan = self.timings.get(k).and_then(|timing| timing.plan.clone());
            let moving = Moving::new(samples.rows()?, samples.dof(), plan, Wanted::Smooth);
            Ok((samples, moving))
        })
    }

    /// One pass over all logs.
    fn pass(
        &self,
        measurement: &mut Measurement<'_>,
        robust: Option<(&Robust, &DVector<f64>)>,
        what: &'static str,
        watch: &mut dyn Watch,
    ) -> Result<Gathered, Error> {
        let params = measurement.model().base.params.len();
        let mut gathered = Gathered::new(params, self.folds);
        for (logged, timing) in self.moving().zip(&self.timings) {
            let (samples, mut reader) = logged?;
            let name = samples.log.name();
            gathered.begin_log(timing);
            let (before, mut work) = (gathered.readings, Vec::new());
            loop {
                // The last rows are folded in while the next ones are read.
                let folds = Mutex::new(&mut gathered.folds[..]);
                let fold = || fold_in(&work, &mut folds.lock().expect("no fold has panicked"));
                let ((), read) = both(fold, || {
                    let (block, motion) = reader.known_rows(BLOCK)?;
                    let rows = measurement.moving_rows(&block, motion.as_ref());
                    Ok::<_, Error>((block, rows))
                });
                let (block, rows) = read?;
                for warning in reader.log.warnings.drain(..) {
                    if robust.is_none() {
                        watch.warning(&warning);
                    }
                }
                if block.is_empty() {
                    break;
                }
                work = gathered.take(&block, rows?, name, robust)?;
                let (done, total) = reader.log.progress();
                tell(watch, what, done, total)?;
            }
            if let Some(summary) = reader.log.summary() {
                if gathered.logs.iter().any(|log| log.hash == summary.hash) {
                    return Err(Error::request(format!(
                        "{name}: given twice, its postures would count twice"
                    )));
                }
                gathered.logs.push(LogUsed {
                    file: samples.log.file_name().to_string(),
                    hash: summary.hash,
                    rows: summary.rows,
                    times: summary.times,
                });
            }
            gathered.end_log(measurement, reader.left_out)?;
            gathered.averaged += reader.log.averaged() * (gathered.readings - before) as f64;
        }
        Ok(gathered)
    }

    /// Scale of the residuals by their median: outliers do not move it.
    fn scale(
        &self,
        measurement: &mut Measurement<'_>,
        params: &DVector<f64>,
    ) -> Result<f64, Error> {
        let mut lengths: Vec<f64> = Vec::new();
        for logged in self.moving() {
            let (_, mut reader) = logged?;
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

/// The support of the first log, where nobody names another.
fn first_support(first: Option<&Samples>, robot: &Robot) -> Result<String, Error> {
    let named = first.map(Samples::first_support).transpose()?.flatten();
    if let Some(link) = named.filter(|link| !link.is_empty()) {
        return Ok(link.to_string());
    }
    let odd = first.map(|first| first.log.sidecar()).transpose()?;
    Err(robot.no_support(&odd.unwrap_or_default().1))
}

#[cfg(test)]
mod tests {
    use std::fs::{self, OpenOptions};
    use std::io::Write as _;
    use std::ops::ControlFlow;
    use std::path::{Path, PathBuf};
    use std::sync::Arc;

    use super::super::{Request, gather};
    use crate::logs::{LogSource, ROOM};
    use crate::robot::{ROD, Robot};
    use crate::{Progress, Watch};

    /// Counts how often a log is read, and adds to its file in pass number `broken`.
    struct Passes {
        path: PathBuf,
        done: u64,
        count: usize,
        broken: usize,
    }

    impl Watch for Passes {
        fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
            self.count += usize::from(progress.done < self.done);
            self.done = progress.done;
            if self.count == self.broken {
                let mut file = OpenOptions::new().append(true).open(&self.path).unwrap();
                file.write_all(b"more").unwrap();
                self.broken = usize::MAX;
            }
            ControlFlow::Continue(())
        }
    }

    /// How often the log at `path`, of `text`, is read, and what is said where it changes in pass
    /// number `broken`.
    fn gathered(path: &Path, text: &str, broken: usize) -> (usize, Option<String>) {
        fs::write(path, text).unwrap();
        let request = Request {
            robot: Some(Arc::new(Robot::parse(ROD, "rod.urdf").unwrap())),
            logs: vec![LogSource::from(path)],
            support: Some("foot".into()),
            ..Request::default()
        };
        let mut passes = Passes {
            path: path.to_path_buf(),
            done: 0,
            count: 0,
            broken,
        };
        let error = gather(&request, &mut passes).err();
        let error = error.map(|error| format!("{error:?}"));
        (passes.count + 1, error)
    }

    /// A log that is too long to be kept.
    #[test]
    fn a_log_that_changes_in_any_pass_is_an_error() {
        let row = |k: u32| {
            let q = (0.7 * f64::from(k)).sin();
            format!("{k},{q},{},0\n", 0.11 * q.sin())
        };
        // Rows of one joint and what is beside it.
        let rows = (0..(ROOM / 9 + 1000) as u32).map(row).collect::<String>();
        let text = "pose,hip,cop_x,cop_y\n".to_string() + &rows;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        let (passes, error) = gathered(&path, &text, usize::MAX);
        assert!(passes > 2 && error.is_none(), "{passes}: {error:?}");
        for broken in 0..passes {
            let (_, error) = gathered(&path, &text, broken);
            let error = error.unwrap_or_else(|| panic!("pass {broken} of {passes}"));
            assert!(error.contains("it changed while it was read"), "{error}");
        }
    }
}
