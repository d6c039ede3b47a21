//! The log of a diagnosis with what was predicted of it, for viewers of recordings.
//!
//! ```text
//! gap = measured − predicted        predicted: by CAD, or by the explanation
//! ```

use super::findings::Explained;
use super::held_out;
use super::problem::Problem;
use crate::logs::{Recording, Track, TrackKind};

/// Topics of the CoP: as it was read, by CAD, by the explanation; and what each leaves.
const MEASURED: &str = "/cop/measured";
const CAD: [&str; 2] = ["/cop/cad", "/cop_gap/cad"];
const EXPLAINED: [&str; 2] = ["/cop/explained", "/cop_gap/explained"];

/// Every posture that was used, in the order of the log.
pub(super) fn of(problem: &Problem, found: &Explained) -> Recording {
    let data = &problem.first().data;
    let pairs = |values: &[f64]| -> Vec<[f64; 2]> {
        let pairs = values.chunks_exact(2);
        pairs.map(|pair| [pair[0], pair[1]]).collect()
    };
    let measured = pairs(&data.reading);
    let explained = held_out::errors_of(problem, &found.best, None);
    let predictions = [(CAD, &found.baseline.errors), (EXPLAINED, &explained)];
    let (mut points, mut differences) = (Vec::new(), Vec::new());
    for ([point, difference], errors) in predictions {
        let gaps = pairs(errors);
        let predicted = measured.iter().zip(&gaps);
        points.push(Track {
            topic: point,
            kind: TrackKind::Point,
            xy: predicted.map(|(y, e)| [y[0] - e[0], y[1] - e[1]]).collect(),
        });
        differences.push(Track {
            topic: difference,
            kind: TrackKind::Difference,
            xy: gaps,
        });
    }
    let readings = Track {
        topic: MEASURED,
        kind: TrackKind::Reading,
        xy: measured,
    };
    let dofs = &problem.first().model.tree.dofs;
    Recording {
        frame: problem.first().model.support().to_string(),
        joints: dofs
            .iter()
            .map(|dof| dof.joint.trim().to_string())
            .collect(),
        t: data.t.clone(),
        q: data.q.clone(),
        tracks: [readings]
            .into_iter()
            .chain(points)
            .chain(differences)
            .collect(),
    }
}
