//! The robot of a fit: which links the data moved.

use super::{FitReport, Moved, Shown};
use crate::report::figures::fit::{sole_beside, some};
use crate::report::figures::robot::Marks;
use crate::report::health::Posed;
use crate::report::robot::{Card, Correction, Shown as Posture};
use sesc_identify::fit::residuals::Residual;

/// Standard deviations that one parameter in twenty leaves by chance, and that none does.
const CHANCE: f64 = 2.0;
const SURE: f64 = 4.0;
/// Bodies that a caption names.
const NAMED: usize = 3;

/// The robot with the links shaded that the data moved, where it is at hand.
pub fn card<'a>(report: &FitReport<'_>, shown: &'a Shown) -> Option<Card<'a>> {
    let moved = shown.robot.as_ref()?;
    let posture = |row: &Residual| Posture {
        pose: row.pose,
        q: row.q.clone(),
        measured: Some(row.measured),
        predicted: Some([row.cad, row.fitted]),
        ..Posture::default()
    };
    Some(Card {
        skeleton: &moved.skeleton,
        postures: some(&shown.residuals).map(posture).collect(),
        apart: Posed::of(&report.found.health).shown(),
        beside: Some(sole_beside(&shown.residuals)),
        caption: caption(moved, report),
        marks: marks(moved, report),
        correction: Correction {
            names: ["CAD", "the fit"],
            ..Correction::default()
        },
    })
}

fn marks(moved: &Moved, report: &FitReport<'_>) -> Marks {
    let skeleton = &moved.skeleton;
    let links = skeleton.capsules.iter().map(|capsule| {
        let by = (moved.deviations[capsule.body] - CHANCE) / (SURE - CHANCE);
        (capsule.link.clone(), by)
    });
    let arrows = report.corrected.iter().flat_map(|corrected| {
        corrected.links.iter().filter_map(|change| {
            let (body, from) = skeleton.in_body(&change.link, change.com[0])?;
            let (_, to) = skeleton.in_body(&change.link, change.com[1])?;
            Some((body, [from, to]))
        })
    });
    Marks {
        moved: links.collect(),
        arrows: arrows.collect(),
        ..Marks::default()
    }
}

/// Which bodies moved most, by how many of their standard deviations.
fn caption(moved: &Moved, report: &FitReport<'_>) -> String {
    let mut order: Vec<(f64, &str)> = (moved.deviations.iter().zip(&report.found.bodies))
        .map(|(by, body)| (*by, body.body.as_str()))
        .collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let named = order.iter().filter(|(by, _)| *by > CHANCE).take(NAMED);
    let named: Vec<String> = named
        .map(|(by, body)| format!("`{body}` ({by:.1})"))
        .collect();
    let said = match named.is_empty() {
        true => "No link moved by more than chance.".to_string(),
        false => format!(
            "What moved most, in standard deviations: {}.",
            named.join(", ")
        ),
    };
    let arrows = match report.corrected {
        Some(_) => {
            " Orange arrows: how the CoM of links moves in the corrected URDF, all \
                    enlarged alike."
        }
        None => "",
    };
    format!(
        "{said} Blue links: a parameter of their body is more than {SURE:.0} standard deviations \
         from CAD; grey-blue: more than {CHANCE:.0}, which one parameter in twenty is by chance.\
         {arrows}"
    )
}
