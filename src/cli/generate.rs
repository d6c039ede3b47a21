//! `sesc generate`

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sesc_codegen::emit::{names, rust};
use sesc_codegen::write_if_changed;

use super::{Outcome, RobotArguments, message, print};
use crate::Error;

/// Write the functions of a robot as source code
#[derive(Args)]
#[command(
    after_help = "Example:\n  sesc generate robots/op2/op2.urdf --support r_sole --lang rust --name op2_r_sole --out src/"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Language of the output
    #[arg(long, value_enum, default_value = "rust")]
    lang: Language,
    /// Scalar type; Rust output is generic and serves f64, f32 and SIMD lanes alike
    #[arg(long, value_enum, default_value = "f64")]
    scalar: Scalar,
    /// Module name; <robot>_<support> unless given
    #[arg(long)]
    name: Option<String>,
    /// Folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Identified parameters to add as MODEL_PARAMS
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Language {
    Rust,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Scalar {
    F64,
    F32,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let (_, model) = arguments.robot.load(arguments.model.as_deref())?;
    let Language::Rust = arguments.lang;
    let (Scalar::F64 | Scalar::F32) = arguments.scalar;
    let name = arguments.name.clone().unwrap_or_else(|| {
        let support = &model.tree.links[model.tree.support].name;
        names::suggest(&format!("{}_{support}", model.tree.robot))
    });
    let text = rust::module(&model, &name)?;
    let path = arguments.out.join(format!("{name}.rs"));
    if !write_if_changed(&path, &text)? {
        message("already up to date");
    }
    print(&format!("{}\n", path.display()))?;
    Ok(Outcome::Ok)
}
