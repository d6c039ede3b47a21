//! Our fit from postures in memory: the library's present path, all that is
//! measured of it.

use sesc_identify::fit::Gathered;
use sesc_identify::observations::Measurement;
use sesc_identify::fit::prior::Prior;
use sesc_identify::fit::{Settings, identify};
use sesc_identify::logs::Block;
use sesc_identify::robot::Robot;
use sesc_model::Snapping;
use sesc_generated::op2_r_sole::{CAD_PARAMS, Op2RSole};
use sesc_runtime::fit::Estimator;

use crate::ours;

/// Postures of a block, as logs deliver them.
const BLOCK: usize = 4096;

/// A log in memory.
pub fn log(q: &[f64], reading: &[[f64; 2]]) -> Vec<Block> {
    let blocks = q.chunks(ours::DOF * BLOCK).zip(reading.chunks(BLOCK));
    blocks
        .enumerate()
        .map(|(k, (q, reading))| {
            let first = k * BLOCK;
            Block {
                line: (first as u64..).take(reading.len()).collect(),
                pose: (first as i64..).take(reading.len()).collect(),
                q: q.to_vec(),
                reading: Some(reading.to_vec()),
                ..Block::default()
            }
        })
        .collect()
}

fn measurement(robot: &Robot) -> Measurement<'_> {
    Measurement::new(robot, ours::SUPPORT, Snapping::default())
        .expect("the OP2 stands on its right sole")
}

/// The parameters, as the peers compute them: generated code, products, one refinement.
pub fn parameters(q: &[f64], reading: &[[f64; 2]]) -> Vec<f64> {
    let (q, _) = q.as_chunks::<{ ours::DOF }>();
    let start = Estimator::with_nominal(&CAD_PARAMS).expect("CAD parameters are finite");
    let found = start.batch::<Op2RSole>(ours::simd(), q, reading, &[1.0; 2]);
    found
        .expect("postures and readings are finite")
        .params()
        .to_vec()
}

/// All that `sesc fit` says after reading: ten-fold cross-validation, noise,
/// uncertainties, what the data cannot see.
pub fn everything(robot: &Robot, log: &[Block]) -> Vec<f64> {
    let mut measurement = measurement(robot);
    let mut gathered = Gathered::new(measurement.model().base.params.len(), 10);
    for block in log {
        let pushed = gathered.push(&mut measurement, block, "log", None);
        pushed.expect("flat ground, one foot");
    }
    let settings = Settings::new(Prior::Free);
    let found = identify(measurement.model(), &[ours::SUPPORT], &gathered, &settings);
    found.parameters.iter().map(|p| p.value).collect()
}
