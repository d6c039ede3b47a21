//! From facts to source files: the one way of build scripts, the command line and Python.

use std::path::PathBuf;

use crate::Error;
#[cfg(feature = "c99")]
use crate::emit::c::{
    self, Options, Scalar, Servos,
    layout::{self, Layout},
};
use crate::emit::{names, rust};
use crate::facts::Facts;

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
