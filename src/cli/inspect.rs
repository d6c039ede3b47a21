//! `sesc inspect`

use std::collections::BTreeMap;
use std::fmt::Write as _;

use clap::Args;
use sesc_codegen::emit::header::at_most;
use sesc_identify::NextStep;
use sesc_model::text::listed;
use sesc_model::tree::{Snap, snapped};
use sesc_model::{Function, Interface};

use super::steps::About;
use super::{Outcome, RobotArguments, print_found};
use crate::Error;
use crate::inspect::{Inspection, RankCheck, inspect};
use crate::report::next_steps::{self, WithSteps};
use crate::report::table::{self, Table, gathered};

/// Tree, chain, base parameters, what is unobservable, operation counts, snaps
#[derive(Args)]
#[command(
    after_help = "Examples:\n  sesc inspect robots/op2/op2.urdf --support r_sole\n  sesc inspect robots/op2/op2.urdf --support r_sole --long | less -S"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Lists of more than eight lines in full, rotations from the support link to each body, and a
    /// sentence on each function: lines may be long
    #[arg(long, conflicts_with = "json")]
    long: bool,
    /// Machine-readable output
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let stance = arguments.robot.stance(None)?;
    let model = stance.model()?;
    let inspection = inspect(&model);
    super::notes(&inspection.notes);
    let support = model.support().to_string();
    let about = About::new(&arguments.robot.urdf);
    let next_steps = &about.worded([&NextStep::Plan { support }])[..];
    let found = &inspection;
    let found = WithSteps { found, next_steps };
    print_found(arguments.json, &found, false, || {
        let text = text(&inspection, arguments.long);
        format!("{text}\n{}", next_steps::text(next_steps))
    })?;
    match inspection.rank_check {
        RankCheck::Agrees => Ok(Outcome::Ok),
        RankCheck::Undecided => {
            super::message(
                "note: the numeric ranks tell nothing: the pivots of the regressor shrink without \
                 a gap, as where many mimic joints follow one; the counts by structure take as \
                 dependent what differs by less than 1e-12",
            );
            Ok(Outcome::Ok)
        }
        // The structure says one rank, the numbers another: that must not pass quietly.
        RankCheck::Contradicts => {
            super::message("check failed: the numeric rank contradicts the symbolic count");
            Ok(Outcome::Failed)
        }
    }
}

fn text(i: &Inspection, long: bool) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "{} on {}: {} links, {} bodies, {} independent joints, {:.6} kg (hash {})\n",
        i.robot, i.support, i.links, i.bodies, i.dof, i.mass_kg, i.hash
    );
    let rotation = if long { "B_i" } else { "B_i = B of that ·" };
    let mut chain = Table::new(&["body", "joint", "carried by", "r_i from CAD, mm", rotation]);
    for body in &i.chain {
        let [x, y, z] = body.r.map(|x| 1e3 * x);
        let s = body.s.map(|s| format!("; s = {s:.4}")).unwrap_or_default();
        chain.row(&[
            body.body.clone(),
            body.joint.clone().unwrap_or_default(),
            body.parent.clone().unwrap_or_default(),
            format!("{x:9.4} {y:9.4} {z:9.4}{s}"),
            if long {
                &body.orientation
            } else {
                &body.rotation
            }
            .clone(),
        ]);
    }
    let _ = writeln!(out, "{}", chain.listed(long));
    let mut parameters = Table::new(&["base parameter", "CAD", ""]);
    for parameter in &i.parameters {
        let (value, unit) = match parameter.unit {
            "m" => (format!("{:.4}", 1e3 * parameter.cad), "mm"),
            _ => (format!("{:.6}", parameter.cad), "of the mass"),
        };
        parameters.row(&[parameter.name.clone(), value, unit.to_string()]);
    }
    let _ = writeln!(out, "{}", parameters.listed(long));
    let _ = writeln!(out, "What no data can see:");
    let _ = write!(out, "{}", unseen(i, long));
    // Divisions, clamps and powers: a column of their own where an effect needs any.
    let effects = i.operations.values().any(|operations| operations.other > 0);
    let mut titles = vec!["function", "mul", "add", "sin_cos"];
    titles.extend(effects.then_some("other"));
    titles.extend(["rounding f64", "f32", "unit"]);
    titles.extend(long.then_some("what it is"));
    let mut costs = Table::new(&titles);
    let functions = Function::ALL.iter().map(|function| function.interface());
    let functions: BTreeMap<&str, Interface> = functions.map(|f| (f.name, f)).collect();
    for (name, operations) in &i.operations {
        let mut row = vec![
            name.to_string(),
            operations.mul.to_string(),
            operations.add.to_string(),
            operations.sin_cos.to_string(),
        ];
        row.extend(effects.then(|| operations.other.to_string()));
        row.push(at_most(i.rounding_bound[name].f64));
        row.push(bound_of_use(i.rounding_bound[name].f32));
        row.push(functions[name].unit.to_string());
        row.extend(long.then(|| functions[name].sentence.to_string()));
        costs.row(&row);
    }
    let _ = writeln!(out, "\n{costs}");
    if i.snaps.is_empty() {
        let _ = writeln!(out, "No right angle was snapped.");
    }
    let snap = |snap: &Snap| {
        format!(
            "snapped {}: {:.1e} rad to a right angle, moves the CoM by at most {} m",
            snap.joint,
            snap.angle_error,
            at_most(snap.com_error)
        )
    };
    let snaps: Vec<String> = snapped(&i.snaps, long).iter().map(snap).collect();
    out += &table::listed(&snaps, long);
    let notes = match i.notes.len() {
        0 => String::new(),
        1 => "; 1 note on the URDF, above".to_string(),
        n => format!("; {n} notes on the URDF, above"),
    };
    let _ = writeln!(
        out,
        "\n{} on {}: {} bodies, {} independent joints, {:.6} kg\n{} SESC parameters, {} base \
         parameters; rank {} from CoM rows, {} from flat CoP rows (numerically {} and {})\n{} \
         directions that no data can see{notes}",
        i.robot,
        i.support,
        i.bodies,
        i.dof,
        i.mass_kg,
        i.full_params,
        i.base_params,
        i.rank.xyz,
        i.rank.cop,
        i.numeric_rank.xyz,
        i.numeric_rank.cop,
        i.unobservable.len()
    );
    out
}

/// A wider rounding bound is of no use; the header of generated code then has the largest error
/// that was seen.
const USEFUL_BOUND: f64 = 1e-3;

/// A rounding bound in two digits, if it is of use: intervals of a long chain multiply.
fn bound_of_use(bound: f64) -> String {
    if bound < USEFUL_BOUND {
        at_most(bound)
    } else {
        "none".to_string()
    }
}

/// Joints that a sentence names, at most.
const JOINTS: usize = 8;
/// How names begin of what rotation about a joint's axis hides.
const AXIS_OF: &str = "axis of ";

/// What no data can see: what every revolute joint hides in one sentence, unless all are asked
/// for.
fn unseen(i: &Inspection, long: bool) -> String {
    let mut out = String::new();
    let (alike, others): (Vec<_>, Vec<_>) = i
        .unobservable
        .iter()
        .partition(|own| !long && own.name.starts_with(AXIS_OF));
    let joints = alike.iter().map(|own| own.name.trim_start_matches(AXIS_OF));
    let joints: Vec<&str> = joints.collect();
    if !joints.is_empty() {
        let sentence = format!(
            "along the axis of each of {} joints, r of the body that it moves goes to the body \
             that carries it (table above): rotation about that axis leaves it unchanged. {}",
            joints.len(),
            listed(&joints, JOINTS)
        );
        let _ = writeln!(out, "  {}", table::wrapped(&sentence, "    "));
    }
    let others = others.iter().map(|direction| direction.sentence.clone());
    let others: Vec<String> = others.collect();
    let wrapped = |sentence: String| format!("  {}", table::wrapped(&sentence, "    "));
    let others: Vec<String> = gathered(&others, long).into_iter().map(wrapped).collect();
    out + &table::listed(&others, long)
}
