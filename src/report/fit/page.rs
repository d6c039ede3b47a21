//! The page of `sesc fit --report`.

use minijinja::value::{Serde, Value};
use minijinja::{Error, context};

use super::{FitReport, Shown, robot};
use crate::report::data::Data;
use crate::report::figures::fit as figures;
use crate::report::html::render;
use crate::report::origin::Origin;
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
    let map = map.map_or(Value::from(()), figure);
    let context = context! {
        found => Serde(found),
        corrected => report.corrected.map(Serde),
        shifts => report.corrected.map(|corrected| {
            corrected.links.iter().map(|change| change.shift()).collect::<Vec<f64>>()
        }),
        robot => robot::card(report, shown).map(|card| card.context()),
        data => data(report, shown).context(),
        origin => Origin {
            robot: [&found.robot, &found.hash],
            logs: found.data.iter().map(|log| (&*log.file, log.rows, &*log.hash)).collect(),
            times: found
                .data
                .iter()
                .filter_map(|log| log.times)
                .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]),
            command: &shown.command,
        }
        .context(),
        next => next_steps::context(report.next_steps),
        noise_source => found.noise_source.phrase(),
        soles => found.closure.as_ref().map(soles),
        again => found.again.as_ref().map(|again| &again.sentence),
        residuals => shown.residuals.len(),
        bounds => &found.active_bounds,
        physical => found.active_bounds.is_some(),
        test => found.lack_of_fit.map(Serde),
        gain => found.cad_rmse / found.held_out_rmse,
        told => found.parameters.iter().filter(|p| p.source == "data").count(),
        figures => context! {
            waterfall => figure(figures::waterfall(found)),
            bodies => figure(figures::bodies(&found.bodies)),
            changes => figure(figures::changes(&found.parameters)),
            sole => figures::sole(&shown.residuals).map(figure).to_vec(),
            correlation => map,
        },
    };
    render("fit.html", context)
}

/// What came in.
fn data<'a>(report: &FitReport<'a>, shown: &'a Shown) -> Data<'a> {
    let found = report.found;
    let mut lines = vec![("rows", found.samples.sentence())];
    lines.push((
        "postures",
        format!("{}, {} readings", found.postures, found.readings),
    ));
    lines.push((
        "visits",
        match &found.visits {
            Some(visits) => visits.sentence(),
            None => "no posture was reached twice".to_string(),
        },
    ));
    Data {
        lines,
        dofs: shown
            .robot
            .as_ref()
            .map_or(&[], |robot| &robot.skeleton.dofs),
        used: &shown.used,
        postures: shown.residuals.iter().map(|row| row.q.as_slice()).collect(),
        health: &found.health,
        first_posed: (shown.robot.as_ref()).map(|_| figures::some(&shown.residuals).count()),
    }
}
