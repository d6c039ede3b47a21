//! Postures to reach again: what visits of one posture differ by is seen in no other way.
//!
//! ```text
//! reading of a visit = CoP(q) + v + e        v ~ N(0, σ_visit²) per visit, e per reading
//! ```
//!
//! Readings of one visit agree to e, however many they are; a fit that takes them for repeats
//! believes itself too exact by √(1 + σ_visit² n/σ_e²). A log that has visits tells both, and the
//! plan counts a posture as known to √(σ_visit² + σ_e²/n).

use serde::Serialize;
use sesc_model::Snapping;

use super::request::Request;
use crate::Error;
use crate::feet::Places;
use crate::logs::{Options, Readings};
use crate::observations::noise::NoiseSource;
use crate::observations::postures::{Postures, Taking};
use crate::observations::revisits::COUNT;
use crate::watch::Watch;

/// Postures of a plan that should come back.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Revisits {
    /// Their numbers, in order.
    pub poses: Vec<i64>,
    /// Whether the file has rows for them.
    pub written: bool,
    /// Why, as a sentence; where there are none, what is known.
    pub sentence: String,
}

/// What a log says of the noise of postures to come.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Known {
    /// Noise of a single reading within a visit, m; zero where visits are one reading each, whose
    /// noise is part of what they differ by.
    pub noise: Option<f64>,
    /// What visits differ by, m; none where no posture was reached again.
    pub visits: Option<f64>,
}

impl Known {
    /// Look at the log of a request, if it has one.
    pub fn of(request: &Request, watch: &mut dyn Watch) -> Result<Known, Error> {
        let Some(log) = &request.log else {
            return Ok(Known::default());
        };
        let (robot, model) = (&request.robot, &request.model);
        let links = robot.description.link_names();
        let taking = Taking {
            options: Options {
                readings: Readings::Required,
                links: links.map(str::to_string).collect(),
                support: Some(model.support().to_string()),
                soles: Some(Places::of(robot, Snapping::default())),
                both_feet: request.feet.said(),
                ..Options::default()
            },
            noise: None,
            floor: 0.0,
        };
        let data = Postures::read(log, model, &taking, watch)?;
        let rows = data.summary.as_ref().map_or(1.0, |found| found.rows as f64);
        let per_posture = (rows / data.postures.max(1) as f64).max(1.0);
        let known = data.noise_source != NoiseSource::Residuals && data.noise > 0.0;
        let single = known.then_some(data.noise * per_posture.sqrt());
        let noise = match data.visits {
            Some(visits) if visits.std > 0.0 => Some(visits.readings_std.unwrap_or(0.0)),
            _ => single,
        };
        Ok(Known {
            noise,
            visits: data.visits.map(|visits| visits.std),
        })
    }

    /// Standard deviation of a reading as it enters the fit, where `asked` is what it is unless
    /// the log says it, m.
    pub fn reading_std(&self, asked: f64) -> f64 {
        self.noise
            .unwrap_or(asked)
            .hypot(self.visits.unwrap_or(0.0))
    }
}

/// How many postures a plan asks for again.
pub(super) fn count(request: &Request, known: &Known) -> usize {
    let usual = match known.visits {
        Some(_) => 0,
        None => COUNT.min(request.poses / 2),
    };
    request.revisits.unwrap_or(usual).min(request.poses)
}

/// What is said of them.
pub(super) fn said(poses: Vec<i64>, request: &Request, known: &Known) -> Revisits {
    let written = request.revisits.is_some() && !poses.is_empty();
    let names: Vec<String> = poses.iter().map(i64::to_string).collect();
    let sentence = match (poses.is_empty(), known.visits) {
        (true, Some(visits)) => format!(
            "none: the log says that visits of one posture differ by {:.2} mm",
            1e3 * visits
        ),
        (true, None) => "none: what visits of one posture differ by stays unknown".to_string(),
        (false, _) => format!(
            "reach poses {} once again after the others{}: what visits of one posture differ by \
             is not known",
            names.join(", "),
            match written {
                true => ", as the last rows of the file",
                false => ", and log them under the same numbers",
            }
        ),
    };
    Revisits {
        poses,
        written,
        sentence,
    }
}
