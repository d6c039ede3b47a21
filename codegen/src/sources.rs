//! From facts to source files: the one way of build scripts, the command line and Python.

use std::path::PathBuf;

use crate::Error;
#[cfg(feature = "c99")]
use crate::emit::c::{
    self, Options, Scalar, Servos,
    layout::{self, Layout},
};
use crate::emit::{names, rust};
use crate::error::Problem;
use crate::facts::Facts;
use sesc_model::Function;

/// Source files of a robot.
#[derive(Debug, Clone)]
pub struct Sources {
    /// Paths within the folder that they are written to, and texts.
    pub files: Vec<(PathBuf, String)>,
    /// What the user should know: why functions are left out.
    pub notes: Vec<String>,
}

/// Which C99 is wanted.
#[cfg(feature = "c99")]
#[derive(Debug, Clone)]
pub struct C99 {
    /// Arithmetic.
    pub scalar: Scalar,
    /// Servos whose ticks functions take, or none; the usual ones of the scalar unless given.
    pub servos: Option<Option<Servos>>,
    /// Whether the recursive estimator is wanted.
    pub estimator: bool,
    /// Most postures that functions of many postures compute side by side.
    pub lanes: Option<u32>,
    /// What is put around header and source.
    pub layout: Layout,
}

#[cfg(feature = "c99")]
impl Default for C99 {
    fn default() -> C99 {
        C99 {
            scalar: Scalar::F64,
            servos: None,
            estimator: false,
            lanes: None,
            layout: Layout::Bare,
        }
    }
}

/// The functions of these names; all of them where no choice is made.
///
/// # Errors
/// When there is no function of a name.
pub fn functions<S: AsRef<str>>(choice: Option<&[S]>) -> Result<Vec<Function>, Error> {
    let Some(names) = choice else {
        return Ok(Function::ALL.to_vec());
    };
    let function = |name: &S| {
        let name = name.as_ref();
        Function::named(name).ok_or_else(|| {
            let known = Function::ALL.map(Function::name).join(", ");
            let name = name.to_string();
            Problem::NoFunction { name, known }.into()
        })
    };
    names.iter().map(function).collect()
}

fn usual(facts: &Facts) -> String {
    format!("{}_{}", facts.robot, facts.support)
}

/// The Rust module `name`; `<robot>_<support>` unless given.
///
/// # Errors
/// When `name`, or that of robot and support, is no name of a module or too long for a file.
pub fn rust(facts: &Facts, name: Option<&str>) -> Result<Sources, Error> {
    let name = name.map_or_else(|| names::whole(&usual(facts)), str::to_string);
    let text = rust::module(facts, &name)?;
    Ok(Sources {
        files: vec![(PathBuf::from(format!("{name}.rs")), text)],
        notes: Vec::new(),
    })
}

/// C99 whose names begin with `name`; `<robot>_<support>` unless given.
///
/// # Errors
/// Those of [`c::package`] and [`layout::files`].
#[cfg(feature = "c99")]
pub fn c99(facts: &Facts, name: Option<&str>, wanted: &C99) -> Result<Sources, Error> {
    let name = name.map_or_else(|| c::whole(&usual(facts)), str::to_string);
    let mut options = Options::of(wanted.scalar);
    options.estimator = wanted.estimator;
    options.lanes = wanted.lanes;
    if let Some(servos) = &wanted.servos {
        options.servos.clone_from(servos);
    }
    let mut package = c::package(facts, &name, &options)?;
    let notes = std::mem::take(&mut package.notes);
    let files = layout::files(facts, package, &name, &options, wanted.layout)?;
    Ok(Sources { files, notes })
}
