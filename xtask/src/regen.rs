//! What `generated/` holds, the figure of README and docs/json.md, and how they are written.

use std::path::{Path, PathBuf};

use sesc_codegen::emit::c::{self, Options, Scalar};
use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_model::{Function, Model, Snapping, files::write_all_if_changed};

use sesc::demo::{self, hidden};
use sesc::report::figures::diagnose::course;
use sesc::{Error, OP2_URDF};
use sesc_identify::robot::Robot;

/// Robots with checked-in code: folder under `robots/`, support link, module.
pub const TARGETS: [(&str, &str, &str); 2] = [
    ("op2", "r_sole", "op2_r_sole"),
    ("two_link", "foot", "two_link_foot"),
];

/// Robots with checked-in C: folder under `robots/`, support link, scalar, prefix.
pub const C_TARGETS: [(&str, &str, Scalar, &str); 2] = [
    ("op2", "r_sole", Scalar::F32, "op2_r_sole"),
    ("op2", "r_sole", Scalar::Fixed32, "op2_r_sole_fixed"),
];

/// What is checked in of a robot: all, but of the OP2 [`Function::CopJacobian`], whose rows are the
/// first two of the CoM's Jacobian and would double the lines for it.
fn facts<'m>(model: &'m Model, robot: &str) -> Facts<'m> {
    let is_kept = |f: &Function| robot != "op2" || *f != Function::CopJacobian;
    let functions: Vec<Function> = Function::ALL.into_iter().filter(is_kept).collect();
    Facts::with(model, &functions)
}

/// README's figure: what the demo's second act finds.
pub const FIGURE: &str = "docs/hidden_effect.svg";

fn figure() -> Result<String, Error> {
    let robot = Robot::parse(OP2_URDF, "op2.urdf")?;
    let model = robot.model("r_sole", Snapping::default(), None)?;
    let hidden = hidden::run(&robot, &model, demo::SEED)?;
    Ok(course(&hidden.view.postures))
}

/// Every file that is written by `cargo regen`, relative to the project's root, with its text.
pub fn files(root: &Path) -> Result<Vec<(PathBuf, String)>, Error> {
    let mut files = Vec::new();
    let mut modules = String::from(
        "//! Machine-written modules for robots of `robots/`; `cargo regen` rewrites them.\n\n\
         #![no_std]\n#![forbid(unsafe_code)]\n\n",
    );
    for (robot, support, module) in TARGETS {
        let urdf = root.join(format!("robots/{robot}/{robot}.urdf"));
        let model = Robot::read(&urdf)?.model(support, Snapping::default(), None)?;
        let text = rust::module(&facts(&model, robot), module)?;
        files.push((PathBuf::from(format!("generated/src/{module}.rs")), text));
        modules.push_str(&format!(
            "/// `{robot}` on its link `{support}`.\n#[rustfmt::skip]\npub mod {module};\n"
        ));
    }
    files.push((PathBuf::from("generated/src/lib.rs"), modules));
    for (robot, support, scalar, name) in C_TARGETS {
        let urdf = root.join(format!("robots/{robot}/{robot}.urdf"));
        let model = Robot::read(&urdf)?.model(support, Snapping::default(), None)?;
        let mut options = Options::of(scalar);
        options.estimator = scalar != Scalar::Fixed32;
        let package = c::package(&facts(&model, robot), name, &options)?;
        let path = |extension| PathBuf::from(format!("generated/c/{name}.{extension}"));
        files.push((path("h"), package.header));
        files.push((path("c"), package.source));
    }
    files.push((PathBuf::from(FIGURE), figure()?));
    files.push((PathBuf::from("docs/json.md"), crate::json::page()));
    Ok(files)
}

/// Rewrite what changed; returns the files written.
pub fn write(root: &Path) -> Result<Vec<PathBuf>, Error> {
    let (names, texts): (Vec<_>, Vec<_>) = files(root)?.into_iter().unzip();
    let places = names.iter().map(|name| root.join(name));
    let changed = write_all_if_changed(&places.zip(texts).collect::<Vec<_>>())?;
    let names = names.into_iter().zip(changed);
    Ok(names
        .filter_map(|(name, changed)| changed.then_some(name))
        .collect())
}
