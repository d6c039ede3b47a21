//! `sesc effects`

use clap::Args;
use serde::Serialize;
use sesc_identify::diagnose::{MODEL_PAGES, subject};
use sesc_model::effects::about::{EffectAbout, TargetKind, about};
use sesc_model::effects::{Catalog, Site};
use sesc_model::formula::functions;
use sesc_model::urdf::suggestion;

use super::{Outcome, print_json, show};
use crate::Error;
use crate::report::table::Table;

/// What a diagnosis may also name, besides effects.
const BESIDE: &str = "\nA diagnosis may also say `mass_distribution` (masses are not CAD's, beyond \
    their\ntolerances) and `cop_outliers` (a few readings that come from elsewhere).\n\n\
    sesc effects NAME explains one: its equation, what imitates it, and which postures\n\
    tell it apart.\n";

/// List the effects that a diagnosis knows, or explain one
#[derive(Args)]
#[command(
    after_help = "Examples:\n  sesc effects\n  sesc effects joint_offset\n  sesc effects --json"
)]
pub(super) struct Arguments {
    /// Effect to explain
    name: Option<String>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Listed {
    /// The effects, or the one asked for.
    effects: Vec<EffectAbout>,
    /// What else a diagnosis may name.
    others: Vec<NoEffect>,
    /// Where effects of a user's own add something.
    sites: [SiteAbout; 5],
    /// Functions that their formulas may call.
    functions: [&'static str; 9],
}

/// A site of effects of a user's own.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct SiteAbout {
    /// Its name in files: `joint`.
    name: &'static str,
    /// What is added there, and its unit.
    adds: &'static str,
    /// What formulas may depend on there.
    variables: &'static str,
}

/// What a diagnosis may name that is no effect.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct NoEffect {
    /// Name in reports: `cop_outliers`.
    name: &'static str,
    /// What it is about.
    about: &'static str,
    /// What it is, in a sentence.
    sentence: &'static str,
    /// Sentence, equation, what separates it; Markdown.
    page: &'static str,
}

pub(super) fn run(arguments: &Arguments) -> Outcome {
    let mut effects = about(&Catalog::standard());
    let mut others = Vec::from(MODEL_PAGES.map(other));
    if let Some(name) = &arguments.name {
        let names: Vec<&str> = effects.iter().map(|effect| effect.name).collect();
        let known: Vec<&str> = others.iter().map(|own| own.name).collect();
        effects.retain(|effect| effect.name == name);
        others.retain(|other| other.name == name);
        if effects.is_empty() && others.is_empty() {
            let meant = suggestion(name, known.into_iter().chain(names.iter().copied()));
            let names = names.join(", ");
            let sentence = format!("no effect `{name}`; the effects are {names}{meant}");
            return Err(Error::Usage(sentence));
        }
    }
    if arguments.json {
        let sites = Site::ALL.map(|site| SiteAbout {
            name: site.name(),
            adds: site.adds(),
            variables: site.variables(),
        });
        print_json(&Listed {
            effects,
            others,
            sites,
            functions: functions(),
        })?;
        return Ok(true);
    }
    let page = match (&arguments.name, effects.first(), others.first()) {
        (Some(name), Some(effect), _) => {
            format!("{name}: {}\n{}", on_console(effect.page), acts_on(effect))
        }
        (Some(name), None, Some(other)) => format!("{name}: {}", on_console(other.page)),
        _ => table(&effects) + &own() + BESIDE,
    };
    show(&page)?;
    Ok(true)
}

/// Sites and functions of effects of a user's own.
fn own() -> String {
    let mut table = Table::new(&["site", "a formula adds", "variables of the formula"]);
    for site in Site::ALL {
        table.row(&[site.name(), site.adds(), site.variables()]);
    }
    format!(
        "\nEffects of your own (sesc diagnose --effects own.toml) are a site and a formula of {}:\n\n\
         {table}",
        functions().join(" ")
    )
}

/// `Acts on: joint. Parameters: offset_rad (rad), offset_m (m).`
fn acts_on(effect: &EffectAbout) -> String {
    let target = match &effect.target {
        TargetKind::Whole => "the robot".to_string(),
        target => target.to_string(),
    };
    let parameters = effect.parameters.iter().map(|p| match p.unit {
        "1" => p.name.to_string(),
        unit => format!("{} ({unit})", p.name),
    });
    let parameters: Vec<String> = parameters.collect();
    let parameters = match parameters.is_empty() {
        true => "none".to_string(),
        false => parameters.join(", "),
    };
    format!("Acts on: {target}. Parameters: {parameters}.\n")
}

fn other((name, about, page): (&'static str, &'static str, &'static str)) -> NoEffect {
    NoEffect {
        name,
        about,
        sentence: page.lines().next().unwrap_or_default(),
        page,
    }
}

/// A page as a terminal shows it: without fences, its tables as those of other commands, which a
/// narrow terminal wraps in their last column.
fn on_console(page: &str) -> String {
    let mut out = String::new();
    let mut table: Option<Table> = None;
    for line in page.lines().filter(|line| !line.starts_with("```")) {
        let cells = line.strip_prefix('|').and_then(|row| row.strip_suffix('|'));
        let Some(cells) = cells else {
            out.extend(table.take().map(|table| table.to_string()));
            out.extend([line, "\n"]);
            continue;
        };
        let cells: Vec<&str> = cells.split('|').map(str::trim).collect();
        match &mut table {
            None => table = Some(Table::new(&cells)),
            Some(_) if cells.iter().all(|cell| cell.trim_matches('-').is_empty()) => {}
            Some(table) => drop(table.row(&cells)),
        }
    }
    out.extend(table.map(|table| table.to_string()));
    out
}

fn table(effects: &[EffectAbout]) -> String {
    let mut table = Table::new(&[
        "what may be missing (effect)",
        "what it is (its parameters)",
    ]);
    for effect in effects {
        let names: Vec<&str> = effect.parameters.iter().map(|p| p.name).collect();
        let parameters = match names.is_empty() {
            true => String::new(),
            false => format!(" ({})", names.join(", ")),
        };
        let (target, others) = match &effect.target {
            TargetKind::TwoJoints => ("JOINT,JOINT".to_string(), String::new()),
            TargetKind::JointOrAll => ("JOINT".to_string(), " Or of all.".to_string()),
            TargetKind::Ways(names) => {
                let others = format!(" Or of: {}.", names[1..].join(", "));
                (names[0].to_string(), others)
            }
            target => (target.to_string().to_uppercase(), String::new()),
        };
        let what = subject(effect.name, &target);
        table.row(&[what, effect.sentence.to_string() + &others + &parameters]);
    }
    table.to_string()
}

#[cfg(test)]
mod tests {
    use super::on_console;

    #[test]
    fn tables_of_pages_are_those_of_commands() {
        let page = "An equation:\n\n```text\ny = x\n```\n\n| at   | is |\n| ---- | -- |\n| knee | a b |\n\nEnd.\n";
        let shown = "An equation:\n\ny = x\n\nat    is\n────  ───\nknee  a b\n\nEnd.\n";
        assert_eq!(on_console(page), shown);
    }
}
