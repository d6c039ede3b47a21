//! `sesc demo`

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use sesc_identify::files::write_all_if_changed;
use sesc_identify::robot::Robot;
use sesc_identify::simulate;
use sesc_identify::simulate::hide;
use sesc_model::Snapping;

use super::outputs::{Files, Kind};
use super::{Bar, Outcome, command_line, message, print_found, steps};
use crate::demo::{self, Demo};
use crate::report::next_steps::{self, Worded};
use crate::report::table::{Table, hundredths as mm, wrapped};
use crate::report::{self, DemoReport, HiddenAct};
use crate::{Error, OP2_URDF};

/// The seed paper's simulation end to end on the embedded OP2, with a report
#[derive(Args)]
#[command(after_help = "Examples:\n  sesc demo --out demo.html\n  sesc demo --keep play")]
pub(super) struct Arguments {
    /// Report to write
    #[arg(long, value_name = "FILE", default_value = "sesc-demo.html")]
    out: PathBuf,
    /// Folder for the robot and two small logs of it, to play with
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Seed of postures and noise
    #[arg(long, default_value_t = demo::SEED)]
    seed: u64,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// What programs are told.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Answer<'a> {
    /// Whether all generated functions are within their bounds.
    pass: bool,
    /// The page that was written.
    page: String,
    /// What it shows.
    #[serde(flatten)]
    report: &'a DemoReport,
    /// What to do next.
    next_steps: &'a [Worded],
}

/// Noise of a reading in the logs that are kept, m.
const NOISE_M: f64 = 0.0005;
/// The logs that are kept: a robot as its URDF says, and one whose knee is off.
const SAMPLES: [(&str, &[&str]); 2] = [
    ("clean.csv", &[]),
    ("knee.csv", &["joint_offset:r_knee=3deg"]),
];

pub(super) fn run(arguments: &Arguments) -> Outcome {
    let files = Files::default().writes(Kind::Page, [&arguments.out]);
    files.check()?;
    if let Some(folder) = &arguments.keep {
        keep(folder)?;
    }
    let demo = demo::run(arguments.seed, &mut Bar::new("verifying"))?;
    let steps = [after(arguments.keep.as_deref())];
    let page = report::demo::page(&demo.report, &steps, &command_line())?;
    write_all_if_changed(&[(arguments.out.clone(), page)])?;
    let pass = demo.first.verification.pass;
    let answer = Answer {
        pass,
        page: arguments.out.display().to_string(),
        report: &demo.report,
        next_steps: &steps,
    };
    print_found(arguments.json, &answer, false, || {
        let (text, next) = (text(&demo), next_steps::text(&steps));
        format!("{text}\nreport with figures: {}\n\n{next}", answer.page)
    })?;
    if !pass {
        message("check failed: generated functions and reference disagree");
    }
    Ok(pass)
}

/// What to do after the demo: with what it kept, or to keep it.
fn after(kept: Option<&Path>) -> Worded {
    let (what, why, command) = match kept {
        None => (
            "Write a robot and two logs of it",
            "every command can be tried on them",
            steps::line(["demo", "--keep", "play"]),
        ),
        Some(folder) => {
            let file = |name: &str| folder.join(name).display().to_string();
            let (urdf, log) = (file("op2.urdf"), file(SAMPLES[1].0));
            (
                "Diagnose the log of the robot whose knee is off",
                "a diagnosis says what its simulation misses",
                steps::line(["diagnose", &urdf, "--data", &log]),
            )
        }
    };
    Worded {
        what: what.to_string(),
        why: why.to_string(),
        command: Some(command),
    }
}

/// Write the OP2, and logs of 200 postures of it read to 0.5 mm.
fn keep(folder: &Path) -> Result<(), Error> {
    let urdf = folder.join("op2.urdf");
    let logs = SAMPLES.map(|(name, _)| folder.join(name));
    let name = urdf.display().to_string();
    if std::fs::read(&urdf).is_ok_and(|text| text != OP2_URDF.as_bytes()) {
        return Err(Error::Usage(format!(
            "{name} is another file than would be written; give --keep another folder"
        )));
    }
    write_all_if_changed(&[(urdf.clone(), OP2_URDF.to_string())])?;
    let files = Files::default().reads_robots([&urdf]);
    let files = files.writes_logs(Kind::Readings, &logs);
    files.check_writable()?;
    let robot = Robot::parse(OP2_URDF, "op2.urdf")?;
    for ((_, effects), path) in SAMPLES.iter().zip(&logs) {
        let model = robot.model("r_sole", Snapping::default(), None)?;
        let mut request = simulate::Request::new(hide(model, effects)?, 200);
        request.range = Some(demo::RANGE_DEG.to_radians());
        request.noise = NOISE_M;
        request.seed = 3;
        simulate::write(&request, path, &mut Bar::new("simulating"))?;
    }
    let [clean, knee] = logs.each_ref().map(|path| path.display());
    message(&format!("wrote {name}, {clean}, {knee}"));
    Ok(())
}

fn text(demo: &Demo) -> String {
    let (report, first) = (&demo.report, &demo.first);
    let (full_params, base_params) = (report.full_params, report.base_params);
    let (lines, samples) = (first.lines, first.verification.samples);
    let mut out = format!(
        "{} on {}: {} joints, {full_params} SESC parameters of which data can tell {base_params} \
         apart\n1. generated {lines} lines of Rust and compared them with the reference on \
         {samples} postures\n\n",
        report.robot, report.support, report.dof
    );
    let titles = [
        "function",
        "mul",
        "add",
        "sin_cos",
        "worst error, m",
        "allowed, m",
    ];
    let mut functions = Table::new(&titles);
    for row in &report.functions {
        let [mul, add, sin_cos] = [row.mul, row.add, row.sin_cos].map(|count| count.to_string());
        let [worst, bound] = [row.worst_error_m, row.bound_m].map(|x| format!("{x:.1e}"));
        functions.row(&[&row.name, &mul, &add, &sin_cos, &worst, &bound]);
    }
    let ([full_rank, rank], condition) = (first.ranks, first.condition_number);
    let _ = writeln!(
        out,
        "{functions}\n2. {} postures in ±{:.0}°, CoP noise {} mm: least squares on {full_params} \
         columns (rank {full_rank}) and on {base_params} base columns (rank {rank}, condition \
         {condition:.0})\n",
        report.postures,
        report.range_deg,
        mm(report.noise_m),
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
        let [cad, full] = [row.cad_m, row.full_m].map(mm);
        let [base_cad, base] = [row.base_cad_m, row.base_m].map(mm);
        lengths.row(&[&row.body, &cad, &full, &base_cad, &base, &row.unseen]);
    }
    let errors = &report.errors;
    let _ = writeln!(
        out,
        "{lengths}\n3. on {} postures the fit never saw\n   \
         against noisy readings   {} mm mean absolute, of which the noise alone makes {} mm\n   \
         against the true CoP     {} mm RMS per axis (theory: noise × √(rank/2N) = {} mm)\n   \
         CoM height               known up to one constant ({} mm with minimum norm); flat CoP cannot tell it, CAD gives it",
        report.held_out,
        mm(errors.measured_mae_m),
        mm(errors.noise_mae_m),
        mm(errors.clean_rmse_base_m),
        mm(errors.theory_rmse_m),
        mm(report.height_offset_m),
    );
    out.extend(report.hidden.as_ref().map(second_act));
    out
}

/// Something is wrong with the robot, and is found.
fn second_act(hidden: &HiddenAct) -> String {
    let (found, lines) = (&hidden.diagnosis, hidden.lines);
    let [noise, after, before] = [found.noise, hidden.after, hidden.before].map(mm);
    let [com_after, com_before] = [hidden.com_after, hidden.com_before].map(mm);
    format!(
        "\n4. something is hidden in the robot: {} balanced postures, read to {noise} mm\n   {}\n   \
         on {} postures never seen the model misses the true CoP by {after} mm, before {before} mm,\n   \
         and the true CoM by {com_after} mm, before {com_before} mm; its {lines} lines of Rust carry \
         the effect\n",
        found.postures,
        wrapped(&found.sentence, "   "),
        hidden.judged
    )
}
