//! The robot of a diagnosis: what is suspected is marked on it.

use super::{effect, parameters};
use crate::report::figures::diagnose as figures;
use crate::report::figures::robot::Marks;
use crate::report::health::Posed;
use crate::report::robot::{Card, Correction, Shown};
use sesc_identify::diagnose::view::{DiagnosisView, Posture};
use sesc_identify::diagnose::{ActsOn, Diagnosis, Step};
use sesc_identify::skeleton::Skeleton;
use sesc_model::effects::Unit;

/// Parameters that a slider names, at most.
const NAMED: usize = 4;

/// The robot with its joints, links and cells marked that the explanation names.
pub fn card<'a>(found: &Diagnosis, view: &'a DiagnosisView) -> Card<'a> {
    let suspects = suspects(&found.steps, &view.skeleton);
    let shown = |row: &Posture| Shown {
        pose: row.pose,
        q: row.q.clone(),
        measured: Some(row.measured),
        predicted: Some([row.simulated, row.corrected]),
        outlier: row.outlier,
        ..Shown::default()
    };
    let postures = view.postures.len();
    let caption = format!(
        "{} Quartered disc: centre of mass, with its plumb line; dots on the floor: CoP of \
         {postures} postures. Arrows lead from the simulated to the measured CoP; between CAD and \
         corrected, simulated readings are interpolated.",
        suspects.sentence
    );
    Card {
        skeleton: &view.skeleton,
        postures: view.postures.iter().map(shown).collect(),
        apart: Posed::of(&found.health).shown(),
        beside: Some(figures::arrows_beside(view, &suspects.cells)),
        caption,
        marks: suspects.marks,
        correction: Correction {
            chi2: Some((view.chi2, view.chi2_readings as f64)),
            found: values(&found.steps),
            names: ["CAD", "corrected"],
        },
    }
}

/// Name, value and unit of what was found.
fn values(steps: &[Step]) -> Vec<(String, f64, &'static str)> {
    let all = steps.iter().flat_map(|step| {
        step.parameters
            .iter()
            .enumerate()
            .map(move |(k, (name, quantity))| {
                let (factor, unit) = Unit::of(name).shown();
                let subject = match (step.target.as_str(), step.parameters.len()) {
                    (_, several) if several > 1 && k > 0 => Unit::stem(name),
                    ("-", 1) => effect(step),
                    ("-", _) => format!("{}: {}", effect(step), Unit::stem(name)),
                    (target, 1) => format!("{} {target}", effect(step)),
                    (target, _) => format!("{} {target}: {}", effect(step), Unit::stem(name)),
                };
                (subject, factor * quantity.value, unit)
            })
    });
    all.take(NAMED).collect()
}

/// What the explanation names, on the robot.
#[derive(Default)]
struct Suspects {
    marks: Marks,
    cells: Vec<usize>,
    sentence: String,
}

fn suspects(steps: &[Step], skeleton: &Skeleton) -> Suspects {
    let mut found = Suspects::default();
    let mut said = Vec::new();
    for step in steps {
        let before = (found.marks.clone(), found.cells.len());
        mark(&mut found, &step.acts_on, skeleton);
        let (what, sizes) = (effect(step), parameters(step).join(", "));
        // `offset 1.5°` says what it is.
        let told = sizes
            .split(' ')
            .next()
            .is_some_and(|word| what.ends_with(word));
        let what = match (sizes.is_empty(), told) {
            (true, _) => what,
            (_, true) => sizes,
            _ => format!("{what}: {sizes}"),
        };
        let marked = before != (found.marks.clone(), found.cells.len());
        if marked {
            let target = step.target.replace(',', "`, `");
            said.push(match step.acts_on {
                ActsOn::AllJoints => format!("every joint ({what})"),
                _ => format!("`{target}` ({what})"),
            });
        }
    }
    found.sentence = match (steps.is_empty(), said.is_empty()) {
        (true, _) => "No joint, link or cell is suspected.".to_string(),
        (false, true) => {
            "What is suspected is no joint and no link: sensor, ground or masses.".to_string()
        }
        (false, false) => format!("Orange: {}.", said.join("; ")),
    };
    found
}

fn mark(found: &mut Suspects, acts_on: &ActsOn, skeleton: &Skeleton) {
    match acts_on {
        ActsOn::AllJoints => found.marks.every_joint = true,
        ActsOn::Link(link) if skeleton.body_of(link).is_some() => {
            found.marks.links.push(link.clone());
        }
        ActsOn::Joints(joints) => {
            let carried = joints.iter().filter_map(|joint| {
                let body = skeleton.carried_by(joint)?;
                Some((body, joint.clone()))
            });
            found.marks.joints.extend(carried);
        }
        ActsOn::Cell(k) => found.cells.push(*k),
        _ => {}
    }
}
