//! Ankles whose encoders are off, in robots whose masses are CAD's: whether `fit` says that its
//! model misses something, where the effect itself would explain enough.

use std::sync::Arc;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_identify::fit::prior::PriorChoice;
use sesc_identify::{diagnose, fit};

use super::{Failure, log, robot};
use crate::recording::Recording;
use crate::stage::Stage;

/// Postures, and readings of each where there are several.
const POSTURES: usize = 60;
const READINGS: usize = 3;
/// Standard deviation of a reading on the OP2, m; of larger robots in proportion to their feet.
const NOISE_M: f64 = 0.5e-3;

/// What `fit` says of one log.
#[derive(Debug, Clone)]
pub struct Found {
    /// The joint and what of it is hidden.
    pub said: String,
    /// Fall of χ² with the offset of this ankle beside masses within CAD's tolerances.
    pub chi2: f64,
    /// Whether `fit` says that the model misses something.
    pub misses: bool,
}

/// Fit a log of `stage` whose ankle of the standing leg, in pitch or roll, is off by 0.5 to 2°; no
/// ankle where `sound`; with one reading a posture, or three.
///
/// # Errors
/// Where the log cannot be taken or fitted.
pub fn examine(stage: &Stage, sound: bool, repeated: bool, seed: u64) -> Result<Found, Failure> {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let ankles = stage
        .joint_names()
        .into_iter()
        .filter(|joint| stage.carries(joint) && (joint.contains("ank")) && !joint.contains("yaw"));
    let ankles: Vec<String> = ankles.collect();
    let joint = &ankles[random.random_range(0..ankles.len())];
    let sign = if random.random_bool(0.5) { 1.0 } else { -1.0 };
    let offset_deg = sign * random.random_range(0.5..2.0);
    let mut world = stage.world();
    if !sound {
        world = world.joint_offset(joint, f64::to_radians(offset_deg))?;
    }
    let readings = if repeated { READINGS } else { 1 };
    let postures = stage.balanced(POSTURES, random).into_iter().enumerate();
    let rows = postures.flat_map(|(k, q)| vec![(k as f64, q); readings]);
    let (pose, q): (Vec<f64>, Vec<Vec<f64>>) = rows.unzip();
    let mut recording = Recording::still(stage, &world, q, NOISE_M * stage.size, random);
    recording.pose = Some(pose);
    let robot = robot(stage)?;
    let mut request = fit::Request::default();
    request.logs = vec![log(&recording, false)];
    request.robot = Some(Arc::clone(&robot));
    request.support = Some(stage.support.into());
    let fitted = fit::fit(&request, &mut ())?.identification;
    let mut request = diagnose::Request::new(robot, log(&recording, false));
    request.support = Some(stage.support.into());
    request.prior = PriorChoice::Cad;
    request.noise = Some(NOISE_M * stage.size);
    request.scores = usize::MAX;
    let scores = diagnose::diagnose(&request, &mut ())?.scores;
    let own = scores
        .iter()
        .find(|own| own.effect == "joint_offset" && own.target == *joint);
    let chi2 = own.map_or(0.0, |own| own.chi2);
    let misses = fitted.misses_something();
    Ok(Found {
        said: format!(
            "{:?} {joint} {offset_deg:.2} deg, {readings} readings, seed {seed}, chi2 {chi2:.0}: noise \
             {:.2e} m from {:?}, held out {:.2e} m, inflation {:.2}, offset {:?}, lack of fit {:?}",
            stage.platform,
            fitted.noise_floor,
            fitted.noise_source,
            fitted.held_out_rmse,
            fitted.inflation,
            fitted.offset,
            fitted.lack_of_fit,
        ),
        chi2,
        misses,
    })
}
