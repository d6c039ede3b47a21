//! The page of `sesc diagnose --report`.

use minijinja::value::{Serde, Value};
use minijinja::{Error, context};

use super::{DiagnoseReport, ModelUse, effect, parameters, servo, where_to};
use crate::report::data::{Data, visits};
use crate::report::figures::diagnose as figures;
use crate::report::health::Posed;
use crate::report::html::{file_name, render};
use crate::report::origin::Origin;
use crate::report::robot::{Card, Correction, Marked};
use crate::report::table::{count, mm};
use crate::report::{next_steps, soles};
use sesc_identify::diagnose::view::DiagnosisView;
use sesc_identify::diagnose::{ActsOn, Blind, CLASS_SCORE, Diagnosis, OVER_NOTHING, Step, Verdict};
use sesc_identify::skeleton::Skeleton;
use sesc_model::ModelFile;
use sesc_model::effects::Unit;

/// Poses and blind spots in a row, at most.
const POSES: usize = 40;
const BLIND: usize = 40;
const EXPERIMENTS: usize = 8;
const MEMBERS: usize = 10;

/// The page of a diagnosis, alone in one file; `made` says of which robot and data it is,
/// `command` makes it again.
pub fn page(
    report: &DiagnoseReport<'_>,
    view: &DiagnosisView,
    made: &ModelFile,
    command: &str,
) -> Result<String, Error> {
    let found = report.found;
    let figure = Value::from_safe_string;
    let predicted = (!view.predicted.is_empty()).then(|| figures::predicted(&view.predicted));
    let confusion = (view.differences.len() > 1).then(|| figures::confusion(&view.differences));
    let poses = found.outliers.iter().take(POSES);
    let context = context! {
        found => Serde(found),
        origin => Origin::of_diagnosis(found, made, command).context(),
        last => Serde(&found.last),
        lead => &found.lead,
        headline => headline(found, view),
        robot => card(found, view).context(),
        verdict => verdict(found.verdict),
        postures => count(found.postures, "posture"),
        data => data(found, view).context(),
        class_score => CLASS_SCORE,
        class_odds => (0.5 * CLASS_SCORE).exp().round(),
        over_nothing => OVER_NOTHING,
        class_size => found.class.len(),
        noise_source => found.noise_source.phrase(),
        soles => found.closure.as_ref().map(soles),
        again => found.again.as_ref().map(|again| &again.sentence),
        steps => steps(found),
        class => class(found),
        outliers => poses.copied().collect::<Vec<i64>>(),
        more_outliers => found.outliers.len().saturating_sub(POSES),
        blind => spots(&found.blind),
        bearing => spots(&found.detectable),
        separations => found.next_postures.experiments.iter().take(EXPERIMENTS)
            .map(|own| separations(&own.separations)).collect::<Vec<String>>(),
        next_file => found.next_postures.file.as_deref().map(file_name),
        next => next_steps::context(report.next_steps),
        where_to => where_to(found.verdict),
        model_use => report.model_use.as_ref().map(model_use),
        rest => view.trends_of_rest,
        named => view.by_position.iter().any(|trend| trend.named),
        rms => view.spread.rms.to_vec(),
        many => found.postures_used > view.postures.len(),
        shown => view.postures.len(),
        figures => context! {
            waterfall => figure(figures::waterfall(&view.stages)),
            course => figure(figures::course(&view.postures)),
            arrows => figures::arrows(view).map(figure).to_vec(),
            predicted => predicted.map(figure),
            by_position => figure(figures::trends(&view.by_position, "joint position")),
            by_moment => figure(figures::trends(&view.by_moment, "gravity moment")),
            rest => figure(figures::rest(view)),
            regions_before => figure(figures::regions(&view.regions, false)),
            regions_after => figure(figures::regions(&view.regions, true)),
            spread => figure(figures::spread(&view.spread)),
            confusion => confusion.map(figure),
        },
    };
    render("diagnose.html", context)
}

/// What came in.
fn data<'a>(found: &'a Diagnosis, view: &'a DiagnosisView) -> Data<'a> {
    let (postures, used, rows) = (found.postures, found.postures_used, found.samples.rows);
    let said = match used < postures {
        true => format!("{postures}, {used} of them used, evenly chosen"),
        false if rows > postures => {
            let each = rows as f64 / postures.max(1) as f64;
            format!("{postures}, {each:.1} rows each")
        }
        false => format!("{postures}, a row each"),
    };
    Data {
        lines: vec![
            ("rows", found.samples.sentence()),
            ("postures", said),
            ("visits", visits(found.visits.as_ref())),
        ],
        dofs: &view.skeleton.dofs,
        used: &view.used,
        postures: view.postures.iter().map(|row| row.q.as_slice()).collect(),
        health: &found.health,
        first_posed: Some(view.postures.len()),
    }
}

/// Simulation and measurement agree where the gap is at most this many times the noise: what noise
/// of a few dozen readings may show.
const AGREES: f64 = 1.2;

/// The finding in a line.
fn headline(found: &Diagnosis, view: &DiagnosisView) -> String {
    let subjects = view.subjects.join(", and ");
    match found.verdict {
        Verdict::None if found.baseline.rmse <= AGREES * found.noise_floor => {
            "Simulation and measurement agree".to_string()
        }
        Verdict::None => "Nothing is missing that this noise would let one see".to_string(),
        Verdict::Absorbed => "Masses take the gap: nothing else is visible".to_string(),
        Verdict::Named => format!("The simulation misses {subjects}"),
        Verdict::Class => format!(
            "The simulation misses {subjects}, or {}",
            match found.class.len() {
                2 => "the other explanation that looks alike".to_string(),
                n => format!("one of {} others that look alike", n.saturating_sub(1)),
            }
        ),
        Verdict::TooShort => "The log is too short to tell noise from a fault".to_string(),
        Verdict::Unusable => "These data cannot be used".to_string(),
        Verdict::Unexplained if subjects.is_empty() => {
            "No known effect explains the gap".to_string()
        }
        Verdict::Unexplained => {
            let are = if view.subjects.len() > 1 { "are" } else { "is" };
            format!("No known effect explains the gap; {subjects} {are} part of it")
        }
    }
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::None => "nothing missing that these data could show",
        Verdict::Named => "one explanation",
        Verdict::Class => "one of several that these data cannot tell apart",
        Verdict::Absorbed => "absorbed by masses, not visible in these data",
        Verdict::Unexplained => "nothing known explains all of it",
        Verdict::TooShort => "too short to tell noise from a fault",
        Verdict::Unusable => "data that cannot be used",
    }
}

/// What the template says of each effect in words.
fn steps(found: &Diagnosis) -> Vec<Value> {
    let row = |step: &Step| {
        context! {
            effect => effect(step),
            parameters => parameters(step),
            servo => servo(&step.remedy),
        }
    };
    found.steps.iter().map(row).collect()
}

/// Offsets with the size from which they show.
fn spots(all: &[Blind]) -> Vec<Value> {
    let spot = |own: &Blind| {
        context! { joint => &own.target, unseen => own.unseen(), size => &own.size }
    };
    all.iter().take(BLIND).map(spot).collect()
}

/// How the model file is used, without the folders of this machine.
fn model_use(model_use: &ModelUse) -> Value {
    let file = file_name(&model_use.model);
    let plain = |text: &str| text.replace(&model_use.model, file);
    context! {
        build_rs => plain(&model_use.build_rs),
        generate => plain(&model_use.generate),
        c => model_use.c,
    }
}

/// Each explanation with the odds against it, the best one's being even.
fn class(found: &Diagnosis) -> Vec<Value> {
    let row = |member: &sesc_identify::diagnose::Member| {
        context! {
            effects => &member.subjects,
            odds => format!("1 : {:.0}", (0.5 * member.score_difference).exp().max(1.0)),
            com_apart => member.com_apart.map_or("–".to_string(), mm),
        }
    };
    found.class.iter().map(row).collect()
}

/// χ² against each explanation but the first.
fn separations(chi2: &[f64]) -> String {
    let shown = chi2.iter().take(MEMBERS).map(|x| match x.is_finite() {
        true => format!("{x:.0}"),
        false => "–".to_string(),
    });
    let more = (chi2.len() > MEMBERS).then(|| "…".to_string());
    shown.chain(more).collect::<Vec<_>>().join(", ")
}

// The robot of a diagnosis: what is suspected is marked on it.

/// Parameters that a slider names, at most.
const NAMED: usize = 4;

/// The robot with its joints, links and cells marked that the explanation names.
pub(crate) fn card<'a>(found: &Diagnosis, view: &'a DiagnosisView) -> Card<'a> {
    let (marked, cells) = suspects(&found.steps, &view.skeleton);
    let suspects = marked.sentence(match found.steps.is_empty() {
        true => "No joint, link or cell is suspected.",
        false => "What is suspected is no joint and no link: sensor, ground or masses.",
    });
    let postures = view.postures.len();
    let caption = format!(
        "{suspects} Quartered disc: centre of mass, with its plumb line; dots on the floor: CoP of \
         {postures} postures. Arrows lead from the simulated to the measured CoP; between CAD and \
         corrected, simulated readings are interpolated.",
    );
    Card {
        skeleton: &view.skeleton,
        postures: figures::postures(view),
        apart: Posed::of(&found.health).shown(),
        beside: Some(figures::arrows_beside(view, &cells)),
        caption,
        marks: marked.marks,
        correction: Correction {
            chi2: Some((view.chi2, view.chi2_expected)),
            found: values(&found.steps),
            names: ["CAD", "corrected"],
        },
    }
}

/// Name, value and unit of what was found.
fn values(steps: &[Step]) -> Vec<(String, f64, &'static str)> {
    let mut all = Vec::new();
    for step in steps {
        for (k, (name, quantity)) in step.parameters.iter().enumerate() {
            let (factor, unit) = Unit::of(name).shown();
            let effect = match step.target.as_str() {
                "-" => effect(step),
                target => format!("{} {target}", effect(step)),
            };
            let subject = match (k, step.parameters.len()) {
                (_, 1) => effect,
                (0, _) => format!("{effect}: {}", Unit::stem(name)),
                _ => Unit::stem(name),
            };
            all.push((subject, factor * quantity.value, unit));
        }
    }
    all.truncate(NAMED);
    all
}

/// What the explanation names, on the robot, and its cells.
fn suspects(steps: &[Step], skeleton: &Skeleton) -> (Marked, Vec<usize>) {
    let (mut found, mut cells) = (Marked::default(), Vec::new());
    for step in steps {
        let what = effect(step);
        match step.acts_on {
            ActsOn::Cell(k) => {
                cells.push(k);
                found.say(&step.target, &what);
            }
            ActsOn::Whole => {}
            _ => found.point(skeleton, step.effect, &step.target, &what),
        }
    }
    (found, cells)
}
