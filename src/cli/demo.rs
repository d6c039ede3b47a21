//! `sesc demo`

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use sesc_model::files::write_all_if_changed;

use super::{Bar, Outcome, message, show};
use crate::Error;
use crate::demo::{self, Demo};
use crate::report::html;
use crate::report::table::{Table, wrapped};

/// The seed paper's simulation end to end on the embedded OP2, with a report
#[derive(Args)]
#[command(after_help = "Example:\n  sesc demo --out demo.html")]
pub(super) struct Arguments {
    /// Report to write
    #[arg(long, value_name = "FILE", default_value = "sesc-demo.html")]
    out: PathBuf,
    /// Seed of postures and noise
    #[arg(long, default_value_t = demo::SEED)]
    seed: u64,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let demo = demo::run(arguments.seed, &mut Bar::new("verifying"))?;
    let page = html::demo(&demo.report).map_err(|error| Error::Report(Box::new(error)))?;
    write_all_if_changed(&[(arguments.out.clone(), page)])?;
    show(&text(&demo))?;
    show(&format!(
        "\nreport with figures: {}\n",
        arguments.out.display()
    ))?;
    if demo.verification.pass {
        Ok(Outcome::Ok)
    } else {
        message("check failed: generated functions and reference disagree");
        Ok(Outcome::Failed)
    }
}

fn text(demo: &Demo) -> String {
    let report = &demo.report;
    let errors = &report.errors;
    let mm = |x: f64| format!("{:.2}", 1e3 * x);
    let mut out = String::new();
    let _ = writeln!(
        out,
        "{} on {}: {} joints, {} SESC parameters of which data can tell {} apart\n\
         1. generated {} lines of Rust and compared them with the reference on {} postures\n",
        report.robot,
        report.support,
        report.dof,
        report.full_params,
        report.base_params,
        demo.lines,
        demo.verification.samples
    );
    let mut functions = Table::new(&[
        "function",
        "mul",
        "add",
        "sin_cos",
        "worst error, m",
        "allowed, m",
    ]);
    for row in &report.functions {
        functions.row(&[
            row.name.clone(),
            row.mul.to_string(),
            row.add.to_string(),
            row.sin_cos.to_string(),
            format!("{:.1e}", row.worst_error_m),
            format!("{:.1e}", row.bound_m),
        ]);
    }
    let _ = writeln!(
        out,
        "{functions}\n2. {} postures in ±{:.0}°, CoP noise {} mm: least squares on {} columns (rank {}) \
         and on {} base columns (rank {}, condition {:.0})\n",
        report.postures,
        report.range_deg,
        mm(report.noise_m),
        report.full_params,
        demo.ranks[0],
        report.base_params,
        demo.ranks[1],
        demo.condition_number
    );
    let mut lengths = Table::new(&[
        "body",
        "|r| CAD, mm",
        "63 columns, mm",
        "base part CAD, mm",
        "identified, mm",
        "not observable",
    ]);
    for row in &report.lengths {
        lengths.row(&[
            row.body.clone(),
            mm(row.cad_m),
            mm(row.full_m),
            mm(row.base_cad_m),
            mm(row.base_m),
            row.unseen.clone(),
        ]);
    }
    let _ = writeln!(out, "{lengths}");
    let _ = writeln!(
        out,
        "3. on {} postures the fit never saw\n   \
         against noisy readings   {} mm mean absolute, of which the noise alone makes {} mm\n   \
         against the true CoP     {} mm RMS (theory: noise × √(rank/2N) = {} mm)\n   \
         CoM height               known up to one constant ({} mm with minimum norm); flat CoP cannot tell it, CAD gives it",
        report.held_out,
        mm(errors.measured_mae_m),
        mm(errors.noise_mae_m),
        mm(errors.clean_rmse_base_m),
        mm(errors.theory_rmse_m),
        mm(report.height_offset_m),
    );
    out.push_str(&second_act(demo));
    out
}

/// Something is wrong with the robot, and is found.
fn second_act(demo: &Demo) -> String {
    let hidden = &demo.hidden;
    let found = &hidden.diagnosis;
    let mm = |x: f64| format!("{:.2}", 1e3 * x);
    let mut out = String::new();
    let _ = writeln!(
        out,
        "\n4. something is hidden in the robot: {} balanced postures, read to {} mm\n   {}",
        found.postures,
        mm(found.noise),
        wrapped(&found.sentence, "   ")
    );
    let _ = writeln!(
        out,
        "   on {} postures never seen the model misses the true CoP by {} mm, before {} mm,\n   \
         and the true CoM by {} mm, before {} mm; its {} lines of Rust carry the effect",
        demo::hidden::JUDGED,
        mm(hidden.after),
        mm(hidden.before),
        mm(hidden.com_after),
        mm(hidden.com_before),
        hidden.lines
    );
    out
}
