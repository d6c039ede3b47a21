//! The page of `sesc fit --report`.

use minijinja::value::{Serde, Value};
use minijinja::{Error, context};

use super::text::misfit;
use super::{FitReport, Moved, Shown};
use crate::report::data::{Data, visits};
use crate::report::figures::fit as figures;
use crate::report::figures::robot::Marks;
use crate::report::health::Posed;
use crate::report::html::render;
use crate::report::origin::Origin;
use crate::report::robot::{Card, Correction};
use crate::report::{next_steps, soles};

/// Parameters whose correlations fit on a map.
const MAPPED: usize = 150;

/// The page of a fit, alone in one file.
pub fn page(report: &FitReport<'_>) -> Result<String, Error> {
    let nothing = Shown::default();
    let shown = report.shown.unwrap_or(&nothing);
    let found = report.found;
    let figure = Value::from_safe_string;
    let map = &shown.correlation_matrix;
    let map = (map.len() <= MAPPED && !map.is_empty()).then(|| figures::correlation(map));
    let context = context! {
        found => Serde(found),
        corrected => report.corrected.map(Serde),
        shifts => report.corrected.map(|corrected| {
            corrected.links.iter().map(|change| change.shift()).collect::<Vec<f64>>()
        }),
        robot => card(report, shown).map(|card| card.context()),
        data => data(report, shown).context(),
        origin => Origin::of_fit(found, &shown.command).context(),
        next => next_steps::context(report.next_steps),
        noise_source => found.noise_source.phrase(),
        soles => found.closure.as_ref().map(soles),
        again => found.again.as_ref().map(|again| &again.sentence),
        residuals => shown.residuals.len(),
        bounds => &found.active_bounds,
        physical => found.active_bounds.is_some(),
        misses => found.misses_something(),
        test => found.lack_of_fit.map(Serde),
        misfit => found.lack_of_fit.map(|test| misfit(found, test.p_value)),
        told => found.parameters.iter().filter(|p| p.source == "data").count(),
        figures => context! {
            waterfall => figure(figures::waterfall(found)),
            bodies => figure(figures::bodies(&found.bodies)),
            changes => figure(figures::changes(&found.parameters)),
            sole => figures::sole(&shown.residuals).map(figure).to_vec(),
            correlation => map.map(figure),
        },
    };
    render("fit.html", context)
}

/// What came in.
fn data<'a>(report: &FitReport<'a>, shown: &'a Shown) -> Data<'a> {
    let found = report.found;
    let postures = format!("{}, {} readings", found.postures, found.readings);
    let robot = shown.robot.as_ref();
    Data {
        lines: vec![
            ("rows", found.samples.sentence()),
            ("postures", postures),
            ("visits", visits(found.visits.as_ref())),
        ],
        dofs: robot.map_or(&[], |robot| &robot.skeleton.dofs),
        used: &shown.used,
        postures: shown.residuals.iter().map(|row| row.q.as_slice()).collect(),
        health: &found.health,
        first_posed: robot.map(|_| figures::postures(&shown.residuals).len()),
    }
}

// The robot of a fit: which links the data moved.

/// Standard deviations that one parameter in twenty leaves by chance, and that none does.
const CHANCE: f64 = 2.0;
const SURE: f64 = 4.0;
/// Bodies that a caption names.
const NAMED: usize = 3;

/// The robot with the links shaded that the data moved, where it is at hand.
fn card<'a>(report: &FitReport<'_>, shown: &'a Shown) -> Option<Card<'a>> {
    let moved = shown.robot.as_ref()?;
    Some(Card {
        skeleton: &moved.skeleton,
        postures: figures::postures(&shown.residuals),
        apart: Posed::of(&report.found.health).shown(),
        beside: Some(figures::sole_beside(&shown.residuals)),
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
    let named = named.join(", ");
    let said = match named.is_empty() {
        true => "No link moved by more than chance.".to_string(),
        false => format!("What moved most, in standard deviations: {named}."),
    };
    let arrows = " Orange arrows: how the CoM of links moves in the corrected URDF, all enlarged \
                  alike.";
    let arrows = report.corrected.map_or("", |_| arrows);
    format!(
        "{said} Blue links: a parameter of their body is more than {SURE:.0} standard deviations \
         from CAD; grey-blue: more than {CHANCE:.0}, which one parameter in twenty is by chance.\
         {arrows}"
    )
}
