//! Our fit from postures in memory: the library's present path, all that is
//! measured of it.

use nalgebra::DVector;
use sesc::identify::factor::Factor;
use sesc::identify::gather::Gathered;
use sesc::identify::measurement::Measurement;
use sesc::identify::prior::Prior;
use sesc::identify::solve::solve;
use sesc::identify::{Settings, identify};
use sesc::posture_log::Block;
use sesc::robot::Robot;
use sesc_codegen::Snapping;

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

/// The parameters alone, as the peers compute them.
pub fn parameters(robot: &Robot, log: &[Block]) -> Vec<f64> {
    let mut measurement = measurement(robot);
    let params = measurement.model().base.params.len();
    let mut factor = Factor::new(params);
    for block in log {
        let rows = measurement.rows(block).expect("flat ground, one foot");
        factor.push(&rows.matrix, &rows.reading, &vec![1.0; rows.reading.len()]);
    }
    let cad = DVector::from_vec(measurement.model().cad_params());
    solve(&factor, 1.0, &cad, None).params.as_slice().to_vec()
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
    let settings = Settings {
        prior: Prior::Free,
        noise: None,
        range: None,
    };
    let found = identify(measurement.model(), &[ours::SUPPORT], &gathered, &settings);
    found.parameters.iter().map(|p| p.value).collect()
}
