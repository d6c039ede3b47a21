//! What a fit found: parameters with uncertainty, observability and held-out error.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use sesc_model::{Information, Model, ModelFile};

use super::criteria::{FAR, GROSSLY};
use super::gather::{DownWeighted, LogUsed};
use super::masses::{Limits, Masses};
use super::offset::{self, Offset};
use super::prior::Prior;
use crate::NextStep;
use crate::feet::ClosureFound;
use crate::health::Finding;
use crate::logs::Weight;
use crate::lsq::solve::Estimate;
use crate::observations::motion_use::MotionUse;
use crate::observations::noise::NoiseSource;
use crate::observations::repeats::{LackOfFit, Visits};
use crate::observations::revisits::Again;
use crate::observations::sample_count::SampleCount;

/// How to fit.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Settings {
    /// The tolerances of CAD masses.
    pub prior: Prior,
    /// Standard deviation of a single reading on one axis, m; from the data where not given.
    pub noise: Option<f64>,
    /// Range over which errors are expected: ±rad about zero within the limits.
    pub range: Option<f64>,
    /// Deviations of an offset of readings that are tried, m; none where there is none.
    pub offset: Vec<f64>,
    /// Where masses can be; anywhere where not given.
    pub(super) limits: Option<Limits>,
    /// What [`over_range`](super::estimate::over_range()) makes of the model, where it is known.
    pub(super) over_range: Option<Arc<DMatrix<f64>>>,
}

impl Settings {
    /// Noise from the data, errors over the whole range of the joints.
    pub fn new(prior: Prior) -> Settings {
        Settings {
            prior,
            noise: None,
            range: None,
            offset: offset::STD_M.to_vec(),
            limits: None,
            over_range: None,
        }
    }
}

/// One base parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ParameterFound {
    /// Name of the base parameter.
    pub name: String,
    /// What was identified, m.
    pub value: f64,
    /// Standard deviation, m; ± 1.96 of them hold 95 %, none where neither data nor prior determine
    /// it.
    pub std: Option<f64>,
    /// Its value by CAD, m.
    pub cad: f64,
    /// `data` or `prior`, whichever tells more.
    pub source: &'static str,
}

/// Two parameters that are known less well apart than together.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Correlation {
    /// Name of one parameter.
    pub a: String,
    /// Name of the other.
    pub b: String,
    /// Their correlation, −1 to 1.
    pub correlation: f64,
}

/// ‖base part of r_i‖ of one body.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BodyLength {
    /// Name of the body.
    pub body: String,
    /// The joint that moves it; none of the support.
    pub joint: Option<String>,
    /// By CAD, m.
    pub cad: f64,
    /// As identified, m.
    pub identified: f64,
    /// Its standard deviation, m.
    pub std: Option<f64>,
}

/// The constant that flat single-foot CoP never tells.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HeightConstant {
    /// Name of the base parameter.
    pub name: String,
    /// Its value, m.
    pub value: f64,
    /// Standard deviation of the estimate, m; none where data and prior do not determine it.
    pub std: Option<f64>,
    /// `data`, `prior` or `cad`.
    pub source: &'static str,
}

/// A direction that cannot be seen.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Unseen {
    /// The parameter that it moves most.
    pub name: String,
    /// The direction as a sentence.
    pub sentence: String,
}

/// Everything a fit found.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Identification {
    /// File of the robot's description.
    pub robot: String,
    /// Hash of the description, in hexadecimal.
    pub hash: String,
    /// The support whose parameters these are.
    pub support: String,
    /// All links that postures stood on.
    pub supports: Vec<String>,
    /// The logs that were used.
    pub data: Vec<LogUsed>,
    /// Postures of all logs.
    pub postures: u64,
    /// Readings of all postures.
    pub readings: u64,
    /// Number of base parameters.
    pub base_params: usize,
    /// Directions that data determine.
    pub rank: usize,
    /// Condition number of what data determine.
    pub condition_number: f64,
    /// Directions that these data do not show.
    pub unobservable: Vec<Unseen>,
    /// Tolerances of CAD masses.
    pub prior: String,
    /// Noise of a reading, m.
    pub noise_floor: f64,
    /// The same of x, y.
    pub noise_axes: [f64; 2],
    /// Independent samples in the logs.
    pub samples: SampleCount,
    /// How motion of the joints counted.
    pub motion: MotionUse,
    /// What the robot weighs by the total force, of the log in which it is farthest from the URDF;
    /// none of logs without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<Weight>,
    /// Scatter between visits of a posture; none if no posture was visited again.
    pub visits: Option<Visits>,
    /// Where the noise was taken from.
    pub noise_source: NoiseSource,
    /// Degrees of freedom of the noise; none where it is stated or guessed.
    pub noise_df: Option<f64>,
    /// Test of the residual against noise; none without a noise estimate.
    pub lack_of_fit: Option<LackOfFit>,
    /// Factor on standard deviations for misfit.
    pub inflation: f64,
    /// By how much all readings are shifted; none where that is not by far likelier than masses
    /// that are off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<Offset>,
    /// RMS on held-out postures, m.
    pub held_out_rmse: f64,
    /// Standard error of that, m.
    pub held_out_error: f64,
    /// Folds of the cross-validation.
    pub folds: usize,
    /// RMS on the fitted postures, m; never the accuracy.
    pub in_sample_rmse: f64,
    /// RMS of CAD's prediction, m.
    pub cad_rmse: f64,
    /// Expected RMS error where data were taken, m.
    pub expected_error_data: f64,
    /// Expected RMS error over the joint range, m.
    pub expected_error_range: f64,
    /// What that range is.
    pub range: String,
    /// The constant height of the CoM.
    pub com_height_constant: HeightConstant,
    /// The base parameters.
    pub parameters: Vec<ParameterFound>,
    /// Lengths of the bodies.
    pub bodies: Vec<BodyLength>,
    /// The strongest, |correlation| > 0.9.
    pub correlations: Vec<Correlation>,
    /// Postures that a robust loss distrusts.
    pub down_weighted: Vec<DownWeighted>,
    /// Postures to reach once more, where nothing tells the noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub again: Option<Again>,
    /// How both soles lie on one floor; of the log in which they lie worst, none of robots that
    /// stand on one foot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closure: Option<ClosureFound>,
    /// What is wrong with the data.
    pub health: Vec<Finding>,
    /// Warnings as sentences: those about the logs first.
    pub warnings: Vec<String>,
    /// How many of these were told while the logs were read.
    #[serde(skip)]
    pub warnings_of_logs: usize,
    /// Bounds on physical masses that are reached; none where the fit was not bounded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub active_bounds: Option<Vec<String>>,
    /// The estimate with its covariance.
    #[doc(hidden)]
    #[serde(skip)]
    pub estimate: Estimate,
    /// Base parameters that readings have, m: with the offset in r_0.
    #[serde(skip)]
    pub(super) params_of_readings: DVector<f64>,
    /// Inverse covariance of the parameters, prior included.
    #[serde(skip)]
    pub information: Information,
    /// Masses of a bounded fit.
    #[doc(hidden)]
    #[serde(skip)]
    pub masses: Option<Masses>,
}

impl Identification {
    /// Whether the fit leaves more than the noise, on postures that it saw or did not see, or takes
    /// an offset: then a diagnosis can say what it misses.
    pub fn misses_something(&self) -> bool {
        let known = self.noise_source != NoiseSource::Unknown;
        let far = known && self.held_out_rmse > FAR * self.noise_floor;
        let [x, y] = self.noise_axes;
        let by_residuals = self.noise_source == NoiseSource::Residuals;
        let grossly = by_residuals && x.max(y) > GROSSLY * x.min(y);
        let open = self.closure.as_ref().is_some_and(|closure| !closure.closes);
        self.inflation > 1.0 || self.offset.is_some() || far || grossly || open
    }

    /// Whether the data can be used: what was fitted to others is no result.
    pub fn is_usable(&self) -> bool {
        !self.health.iter().any(|f| f.kind.makes_unusable())
    }

    /// What to do next; empty where nothing is left to do.
    pub fn next_steps(&self) -> Vec<NextStep> {
        if !self.is_usable() {
            return vec![NextStep::Repair];
        }
        let diagnose = self.misses_something().then_some(NextStep::Diagnose);
        let repeat = self.again.as_ref().map(Again::step);
        diagnose.into_iter().chain(repeat).collect()
    }

    /// Correlations of the parameters with each other; NaN where one has no deviation.
    pub fn correlation_matrix(&self) -> Vec<Vec<f64>> {
        let covariance = &self.estimate.covariance;
        let of = |a: usize, b: usize| {
            covariance[(a, b)] / (covariance[(a, a)] * covariance[(b, b)]).sqrt()
        };
        let all = 0..covariance.nrows();
        all.clone()
            .map(|a| all.clone().map(|b| of(a, b)).collect())
            .collect()
    }

    /// The model file of what was found.
    pub fn model_file(&self, model: &Model) -> ModelFile {
        let values = self.estimate.params.as_slice();
        let mut file = ModelFile::from_values(model, values, None, "data");
        for (parameter, found) in file.parameters.iter_mut().zip(&self.parameters) {
            parameter.std = found.std;
            parameter.source = Some(found.source.to_string());
        }
        file.inform(self.information.clone());
        file.noise_floor = Some(self.noise_floor);
        file.motion = self.motion.counted();
        file.effects.extend(self.offset.iter().map(Offset::record));
        file.data.clone_from(&self.data);
        file
    }
}
