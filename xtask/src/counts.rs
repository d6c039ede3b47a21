//! What a call of each function of the OP2 costs: operations as the program has them,
//! and instructions as callgrind counts them on plain x86-64, held against
//! `benches/instructions/counts.txt`.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;
use sesc::OP2_URDF;
use sesc_identify::robot::Robot;
use sesc_model::{Function, Given, Snapping};

/// Functions that callgrind counts, and what each calls.
const COUNTED: [(&str, Function); 9] = [
    ("com", Function::Com),
    ("com_jacobian", Function::ComJacobian),
    ("com_velocity", Function::ComVelocity),
    ("zmp", Function::Zmp),
    ("gravity_moments", Function::GravityMoments),
    ("regressor_cop", Function::RegressorCop),
    ("com_f32", Function::Com),
    ("com_single", Function::Com),
    ("com_batch", Function::Com),
];

/// How many instructions more than stored are too many, in percent.
const SLACK: u64 = 2;

/// What to do with the counts.
#[derive(Args)]
pub struct Counts {
    /// Store the instructions found
    #[arg(long)]
    bless: bool,
    /// Count operations alone, without callgrind
    #[arg(long, conflicts_with = "bless")]
    operations: bool,
}

impl Counts {
    /// Prints a line for every function.
    ///
    /// # Errors
    /// valgrind or the counted program is missing, or a function takes more
    /// instructions than are stored.
    pub fn run(&self, root: &Path) -> Result<(), Box<dyn Error>> {
        let robot = Robot::parse(OP2_URDF, "op2.urdf")?;
        let model = robot.model("r_sole", Snapping::default(), None)?;
        let folder = root.join("benches/instructions");
        let file = folder.join("counts.txt");
        let stored = fs::read_to_string(&file)?;
        let program = match self.operations || std::env::consts::ARCH != "x86_64" {
            true => None,
            false => Some(build(&folder)?),
        };
        println!(
            "{:<16} {:>5} {:>5} {:>8} {:>13} {:>13}",
            "function", "mul", "add", "sin_cos", "instructions", "stored"
        );
        let (mut found, mut dearer) = (String::new(), Vec::new());
        for (name, function) in COUNTED {
            let program_of = model.program(function, Given::Positions);
            let operations = program_of.ok_or("a function of no posture")?.counts();
            let before = stored.lines().find_map(|line| {
                let (known, count) = line.split_once(' ')?;
                (known == name).then(|| count.parse::<u64>().ok())?
            });
            let now = program.as_deref().map(|path| instructions(path, name));
            let now = now.transpose()?;
            let shown = |count: Option<u64>| count.map_or("-".into(), |count| count.to_string());
            println!(
                "{name:<16} {:>5} {:>5} {:>8} {:>13} {:>13}",
                operations.mul,
                operations.add,
                operations.sin_cos,
                shown(now),
                shown(before)
            );
            if let Some(now) = now {
                found += &format!("{name} {now}\n");
                if before.is_none_or(|before| 100 * now > (100 + SLACK) * before) {
                    dearer.push(name);
                }
            }
        }
        if self.bless {
            fs::write(file, found)?;
        } else if !dearer.is_empty() {
            return Err(format!(
                "more instructions than {SLACK} % above those stored: {}; where that is meant: \
                 cargo xtask counts --bless",
                dearer.join(", ")
            )
            .into());
        }
        Ok(())
    }
}

/// The program that calls each function once, built as a controller builds it.
fn build(folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let target = folder.join("../../target/instructions");
    let status = Command::new(cargo)
        .args(["build", "--quiet", "--release", "--target-dir"])
        .arg(&target)
        .env("RUSTFLAGS", "")
        .current_dir(folder)
        .status()?;
    if !status.success() {
        return Err("benches/instructions does not build".into());
    }
    Ok(target.join("release/instructions"))
}

/// Instructions between the entry of `function` and its return.
fn instructions(program: &Path, function: &str) -> Result<u64, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let report = folder.path().join("callgrind");
    let status = Command::new("valgrind")
        .args(["--quiet", "--tool=callgrind", "--collect-atstart=no"])
        .arg(format!("--callgrind-out-file={}", report.display()))
        .arg(format!("--toggle-collect={function}"))
        .arg(program)
        .arg(function)
        .status()
        .map_err(|error| format!("valgrind: {error}; apt-get install valgrind"))?;
    if !status.success() {
        return Err(format!("callgrind does not count `{function}`").into());
    }
    let text = fs::read_to_string(&report)?;
    let total = text.lines().find_map(|line| {
        line.strip_prefix("summary: ")
            .or_else(|| line.strip_prefix("totals: "))
    });
    Ok(total.ok_or("callgrind wrote no summary")?.trim().parse()?)
}
