//! `sesc generate`

use std::convert::Infallible;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::Serialize;
use sesc_codegen::facts::Facts;
use sesc_codegen::sources::{self, C99};
use sesc_codegen::{Layout, Scalar, Servos};
use sesc_identify::NextStep;
use sesc_identify::files::write_all_if_changed;
use sesc_model::effects::EncoderMap;
use sesc_model::text::visible_lines;

use super::outputs::{Files, Kind};
use super::steps::{About, named};
use super::values::{LAYOUTS, SCALARS, one_of};
use super::{Outcome, RobotArguments, message, notes, outputs, print_as_is, print_found};
use crate::Error;
use crate::report::next_steps::{self, Worded};

/// Write the functions of a robot as source code
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    sesc generate robots/op2/op2.urdf --support r_sole --lang rust --name op2_r_sole --out src/\n  \
    sesc generate robots/op2/op2.urdf --support r_sole --functions com,com_jacobian --out src/\n  \
    sesc generate robots/op2/op2.urdf --support r_sole --lang c --scalar f32 --name op2_r_sole --out fw/\n  \
    sesc generate robots/op2/op2.urdf --support r_sole --lang c --layout cmake --name op2_r_sole --out op2_r_sole/\n  \
    sesc generate robots/op2/op2.urdf --support r_sole --lang c --lanes 8 --name op2_r_sole --out sim/")]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Language of the output
    #[arg(long, value_enum, default_value = "rust")]
    lang: Language,
    /// Scalar type of C [default: f64, of --layout arduino and platformio f32]; Rust output is
    /// generic and serves f64, f32 and SIMD lanes alike
    #[arg(long, value_parser = one_of(SCALARS))]
    scalar: Option<Scalar>,
    /// Module name, or prefix of the C names; `ROBOT_SUPPORT` unless given
    #[arg(long)]
    name: Option<String>,
    /// Folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Identified parameters, and their support unless --support is given: MODEL_PARAMS in Rust,
    /// functions with constants folded in C. Its effects of the body are part of every function,
    /// those of ground and sensor of cop, the predicted reading; correct_cop inverts those of the
    /// sensor, where there are any
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Only these functions, divided by commas, and com, which is always there; all unless given.
    /// The compiler is quicker by what is left out: three quarters of a robot's code for CoM,
    /// Jacobian and CoP rows alone. correct_cop comes along where the model has effects of the
    /// sensor
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = trimmed)]
    functions: Option<Vec<String>>,
    /// C: what to put around the two files; bare unless given
    #[arg(long, value_parser = one_of(LAYOUTS))]
    layout: Option<Layout>,
    /// C: functions of servo ticks [default: true for f32 and fixed32]
    #[arg(long, value_name = "BOOL")]
    ticks: Option<bool>,
    /// C: each joint's servo, implies --ticks true; TOML: [default] zero = 2048, sign = 1,
    /// resolution = 4096; [joints.NAME] likewise, metres_per_tick for prismatic joints
    #[arg(long, value_name = "FILE")]
    servos: Option<PathBuf>,
    /// C in f64 or f32: NAME_estimator, the base parameters by recursive least squares, one
    /// posture a call, no allocation; goes on from the fit of --model
    #[arg(long)]
    estimator: bool,
    /// C in f64 or f32, for gcc and clang on computers: functions of many postures besides,
    /// NAME_com_batch(n, q, r, com) and so on, structures of arrays, q[j * n + i] joint j of
    /// posture i; side by side as many as a register of the target holds, at most N
    #[arg(long, value_name = "N", value_parser = lanes)]
    lanes: Option<u32>,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

/// What is told of a package that was written.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Answer<'a> {
    /// Name of the robot.
    robot: &'a str,
    /// The link on the ground.
    support: &'a str,
    /// Files of the package.
    files: Vec<WrittenFile>,
    /// Effects of the model file, and the functions that hold them.
    effects: Vec<Held>,
    /// What to add to the readings of encoders, of those that do not read the truth.
    encoder_zeros: Vec<EncoderZero<'a>>,
    /// What was noticed.
    notes: &'a [String],
    /// What to do next.
    next_steps: &'a [Worded],
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Held {
    /// Its name in model files.
    effect: &'static str,
    /// What it acts on; `-` for the whole robot.
    target: String,
    /// `all`: every function, `com` and `model_com` too; `cop`: `cop` and `cop_jacobian` alone;
    /// `none`: a log alone shows it.
    functions: &'static str,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct EncoderZero<'a> {
    /// Name of the joint.
    joint: &'a str,
    /// What its encoder's reading is multiplied with first.
    scale: f64,
    /// What is added then, rad or m.
    add: f64,
}

/// Effects of a model file with the functions that hold them.
fn held(facts: &Facts) -> Vec<Held> {
    let effects = facts.effects.iter();
    effects
        .map(|effect| Held {
            effect: effect.name,
            target: effect.target.unwrap_or("-").to_string(),
            functions: match (effect.is_static, effect.changes_body) {
                (true, true) => "all",
                (true, false) => "cop",
                (false, _) => "none",
            },
        })
        .collect()
}

/// Encoders that do not read the truth.
fn encoder_zeros<'m>(facts: &Facts<'m>) -> Vec<EncoderZero<'m>> {
    let pairs = facts.dofs.iter().zip(&facts.encoders);
    let off = pairs.filter(|(_, map)| **map != EncoderMap::TRUE);
    off.map(|(dof, map)| EncoderZero {
        joint: &dof.joint,
        scale: map.scale,
        add: map.offset,
    })
    .collect()
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct WrittenFile {
    /// Its path.
    file: String,
    /// Whether it was written; it was up to date otherwise.
    changed: bool,
}

/// A name as written, less the blanks around it.
fn trimmed(text: &str) -> Result<String, Infallible> {
    Ok(text.trim().to_string())
}

/// 4, 8 or 16.
fn lanes(text: &str) -> Result<u32, String> {
    match text {
        "4" => Ok(4),
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("give 4, 8 or 16".into()),
    }
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Language {
    Rust,
    C,
}

pub(super) fn run(arguments: &Arguments) -> Outcome {
    if outputs::is_standard(&arguments.out) {
        let sentence = "--out - is no folder, and source files do not go to standard output; name \
                        a folder (`./-` has that name)";
        return Err(Error::Usage(sentence.into()));
    }
    let reads = Files::default()
        .reads_robots([&arguments.robot.urdf])
        .reads(&arguments.model)
        .reads(&arguments.servos);
    reads.check()?;
    let (_, model) = arguments.robot.load(arguments.model.as_deref())?;
    let functions = sources::functions(arguments.functions.as_deref())?;
    let (facts, name) = (Facts::with(&model, &functions), arguments.name.as_deref());
    let written = match arguments.lang {
        Language::Rust => {
            check_rust(arguments)?;
            sources::rust(&facts, name)?
        }
        Language::C => sources::c99(&facts, name, &wanted_c(arguments)?)?,
    };
    notes(&written.notes);
    let files = written.files.into_iter();
    let files: Vec<(PathBuf, String)> = files
        .map(|(file, text)| (arguments.out.join(file), text))
        .collect();
    let paths = || files.iter().map(|(path, _)| path);
    reads.writes(Kind::Source, paths()).check()?;
    if let Some(file) = sources::of_another(&facts, paths()) {
        let file = file.display();
        let what = format!("{file} was generated for another robot or support");
        if arguments.name.is_none() {
            let sentence = format!("{what}; give this one a --name or --out");
            return Err(Error::Usage(sentence));
        }
        message(&format!("{what}, and is replaced"));
    }
    let mut written_files = Vec::new();
    for (path, changed) in paths().zip(write_all_if_changed(&files)?) {
        let file = path.display().to_string();
        if !changed {
            message(&format!("{file} is up to date"));
        }
        if !arguments.json {
            print_as_is(&visible_lines(&format!("{file}\n")))?;
        }
        written_files.push(WrittenFile { file, changed });
    }
    let verify = NextStep::Verify {
        support: model.support().to_string(),
        model: named(&arguments.model),
        unsnapped: false,
    };
    let next_steps = &About::new(&arguments.robot.urdf).worded([&verify]);
    let answer = Answer {
        robot: &model.tree.robot,
        support: model.support(),
        files: written_files,
        effects: held(&facts),
        encoder_zeros: encoder_zeros(&facts),
        notes: &written.notes,
        next_steps,
    };
    print_found(arguments.json, &answer, true, || {
        next_steps::text(next_steps)
    })?;
    Ok(true)
}

/// Options of C are refused beside Rust.
fn check_rust(arguments: &Arguments) -> Result<(), Error> {
    let of_c = [
        (
            arguments.servos.is_some() || arguments.ticks.is_some(),
            "--servos and --ticks are for C; add --lang c (Rust takes joint angles)",
        ),
        (
            arguments.estimator,
            "--estimator is for C; add --lang c (in Rust it is sesc_runtime::fit)",
        ),
        (
            arguments.lanes.is_some(),
            "--lanes is for C; add --lang c (one Rust module serves SIMD lanes, \
             sesc_runtime::Batch)",
        ),
        (
            arguments.scalar.is_some_and(|scalar| scalar != Scalar::F64),
            "--scalar f32 and fixed32 are for C; add --lang c, or leave --scalar out (one Rust \
             module serves f64, f32 and SIMD lanes)",
        ),
        (
            arguments.layout.is_some(),
            "--layout arranges C files; add --lang c, or leave it out (a Rust module is one file)",
        ),
    ];
    match of_c.into_iter().find(|(given, _)| *given) {
        Some((_, sentence)) => Err(Error::Usage(sentence.into())),
        None => Ok(()),
    }
}

fn wanted_c(arguments: &Arguments) -> Result<C99, Error> {
    if arguments.lanes.is_some() && arguments.scalar == Some(Scalar::Fixed32) {
        let sentence = "--lanes is for f64 and f32, fixed32 has one posture a call; leave one out";
        return Err(Error::Usage(sentence.into()));
    }
    let servos = match (&arguments.servos, arguments.ticks) {
        (Some(_), Some(false)) => {
            let sentence = "--servos sets what a tick is, --ticks false leaves ticks out; give one";
            return Err(Error::Usage(sentence.into()));
        }
        (Some(file), _) => Some(Some(Servos::read(file)?)),
        (None, ticks) => ticks.map(|wanted| wanted.then(Servos::default)),
    };
    Ok(C99 {
        scalar: arguments.scalar,
        servos,
        estimator: arguments.estimator,
        lanes: arguments.lanes,
        layout: arguments.layout.unwrap_or(Layout::Bare),
    })
}
