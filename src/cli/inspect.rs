//! `sesc inspect`

use std::collections::BTreeMap;
use std::fmt::Write as _;

use clap::Args;
use sesc_codegen::emit::header::at_most;
use sesc_identify::NextStep;
use sesc_model::program::Counts;
use sesc_model::text::listed;
use sesc_model::tree::{Snap, snapped};
use sesc_model::{Function, Interface};

use super::steps::About;
use super::{Outcome, RobotArguments, message, notes, print_with_steps};
use crate::inspect::{Inspection, RankCheck, inspect};
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

pub(super) fn run(arguments: &Arguments) -> Outcome {
    let stance = arguments.robot.stance(None)?;
    let model = stance.model()?;
    let found = inspect(&model);
    notes(&found.notes);
    let support = model.support().to_string();
    let steps = About::new(&arguments.robot.urdf).worded([&NextStep::Plan { support }]);
    print_with_steps(arguments.json, &found, &steps, || {
        text(&found, arguments.long)
    })?;
    match found.rank_check {
        RankCheck::Agrees => {}
        RankCheck::Undecided => message(
            "note: the numeric ranks tell nothing: the pivots of the regressor shrink without a \
             gap, as where many mimic joints follow one; the counts by structure take as dependent \
             what differs by less than 1e-12",
        ),
        // The structure says one rank, the numbers another: that must not pass quietly.
        RankCheck::Contradicts => {
            message("check failed: the numeric rank contradicts the symbolic count");
        }
    }
    Ok(found.rank_check != RankCheck::Contradicts)
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
        let r = format!("{x:9.4} {y:9.4} {z:9.4}{s}");
        let [joint, parent] = [&body.joint, &body.parent].map(|x| x.as_deref().unwrap_or_default());
        let rotations = [&body.rotation, &body.orientation];
        chain.row(&[&body.body, joint, parent, &r, rotations[usize::from(long)]]);
    }
    let _ = writeln!(out, "{}", chain.listed(long));
    let mut parameters = Table::new(&["base parameter", "CAD", ""]);
    for parameter in &i.parameters {
        let (value, unit) = match parameter.unit {
            "m" => (format!("{:.4}", 1e3 * parameter.cad), "mm"),
            _ => (format!("{:.6}", parameter.cad), "of the mass"),
        };
        parameters.row(&[&parameter.name, &value, unit]);
    }
    let _ = writeln!(out, "{}\nWhat no data can see:", parameters.listed(long));
    out += &unseen(i, long);
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
        let Counts {
            mul, add, sin_cos, ..
        } = operations;
        let mut row = vec![name.to_string()];
        row.extend([mul, add, sin_cos].map(usize::to_string));
        row.extend(effects.then(|| operations.other.to_string()));
        row.push(at_most(i.rounding_bound[name].f64));
        row.push(bound_of_use(i.rounding_bound[name].f32));
        row.push(functions[name].unit.to_string());
        row.extend(long.then(|| functions[name].sentence.to_string()));
        costs.row(&row);
    }
    let _ = writeln!(out, "\n{costs}");
    if i.snaps.is_empty() {
        out += "No right angle was snapped.\n";
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
    let useful = (bound < USEFUL_BOUND).then(|| at_most(bound));
    useful.unwrap_or("none".to_string())
}

/// Joints that a sentence names, at most.
const JOINTS: usize = 8;
/// How names begin of what rotation about a joint's axis hides.
const AXIS_OF: &str = "axis of ";

/// What no data can see: what every revolute joint hides in one sentence, unless all are asked
/// for.
fn unseen(i: &Inspection, long: bool) -> String {
    let mut joints = Vec::new();
    let mut others = Vec::new();
    for own in &i.unobservable {
        match own.name.strip_prefix(AXIS_OF) {
            Some(joint) if !long => joints.push(joint),
            _ => others.push(own.sentence.clone()),
        }
    }
    let wrapped = |sentence: &String| format!("  {}", table::wrapped(sentence, "    "));
    let others: Vec<String> = gathered(&others, long).iter().map(wrapped).collect();
    let alike = (!joints.is_empty()).then(|| {
        wrapped(&format!(
            "along the axis of each of {} joints, r of the body that it moves goes to the body \
             that carries it (table above): rotation about that axis leaves it unchanged. {}",
            joints.len(),
            listed(&joints, JOINTS)
        ))
    });
    alike.map_or(String::new(), |line| line + "\n") + &table::listed(&others, long)
}
