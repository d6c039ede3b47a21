//! The build-script interface.

use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::Error;
use crate::emit::c::layout::{self, Layout};
use crate::emit::c::{self, Options, Scalar};
use crate::emit::names;
use crate::emit::rust;
use sesc_model::{Model, ModelFile, Snapping, urdf};

/// Generates a module for a robot from a controller's `build.rs`.
///
/// ```no_run
/// # fn main() -> Result<(), sesc_codegen::Error> {
/// sesc_codegen::Builder::new("op2.urdf").support("r_sole").emit()?;
/// # Ok(()) }
/// ```
///
/// and in the crate:
///
/// ```ignore
/// mod op2 { include!(concat!(env!("OUT_DIR"), "/op2_r_sole.rs")); }
/// ```
#[derive(Debug, Clone)]
pub struct Builder {
    urdf: PathBuf,
    support: Option<String>,
    name: Option<String>,
    model: Option<PathBuf>,
    snapping: Snapping,
    out_dir: Option<PathBuf>,
    c99: Option<PathBuf>,
    c99_options: Options,
}

impl Builder {
    /// Start from a URDF file; relative paths are relative to the crate's root.
    pub fn new(urdf: impl AsRef<Path>) -> Builder {
        Builder {
            urdf: urdf.as_ref().to_path_buf(),
            support: None,
            name: None,
            model: None,
            snapping: Snapping::default(),
            out_dir: None,
            c99: None,
            c99_options: Options::of(Scalar::F64),
        }
    }

    /// The link that stands on the ground.
    pub fn support(mut self, link: impl Into<String>) -> Builder {
        self.support = Some(link.into());
        self
    }

    /// Name of the module's file; `<robot>_<support>` unless given.
    pub fn name(mut self, name: impl Into<String>) -> Builder {
        self.name = Some(name.into());
        self
    }

    /// Identified parameters to add as `MODEL_PARAMS`, and effects that `cop` then has.
    pub fn model(mut self, file: impl AsRef<Path>) -> Builder {
        self.model = Some(file.as_ref().to_path_buf());
        self
    }

    /// How decimals of right angles are read.
    pub fn snapping(mut self, snapping: Snapping) -> Builder {
        self.snapping = snapping;
        self
    }

    /// Where to write, instead of `OUT_DIR`.
    pub fn out_dir(mut self, dir: impl AsRef<Path>) -> Builder {
        self.out_dir = Some(dir.as_ref().to_path_buf());
        self
    }

    /// Write C99 too: `<name>.h` and `<name>.c` into `dir`, in f64 unless
    /// [`Builder::c99_options`] says otherwise.
    pub fn c99(mut self, dir: impl AsRef<Path>) -> Builder {
        self.c99 = Some(dir.as_ref().to_path_buf());
        self
    }

    /// Scalar and servos of the C99 functions.
    pub fn c99_options(mut self, options: Options) -> Builder {
        self.c99_options = options;
        self
    }

    /// Generate the module and return its path.
    ///
    /// Prints `cargo::rerun-if-changed` for every file read, also when it fails,
    /// so that mending the file builds again. A file that would not change is
    /// not touched.
    ///
    /// # Errors
    /// Everything wrong with the URDF or the model file, an unknown support
    /// link, or a folder that cannot be written.
    pub fn emit(&self) -> Result<PathBuf, Error> {
        println!("cargo::rerun-if-changed={}", self.urdf.display());
        if let Some(model) = &self.model {
            println!("cargo::rerun-if-changed={}", model.display());
        }
        let support = self.support.as_deref().ok_or(Error::NoSupport)?;
        let out_dir =
            match &self.out_dir {
                Some(dir) => dir.clone(),
                None => std::env::var_os("OUT_DIR").map(PathBuf::from).ok_or(
                    Error::NotABuildScript {
                        variable: "OUT_DIR",
                    },
                )?,
            };
        let description = urdf::read(&self.urdf).map_err(sesc_model::Error::from)?;
        let mut model = Model::new(&description, support, self.snapping)?;
        if let Some(file) = &self.model {
            model = model.with_file(ModelFile::read(file)?)?;
        }
        for note in model.left_out() {
            println!("cargo::warning={note}");
        }
        let name = match &self.name {
            Some(name) => name.clone(),
            None => names::suggest(&format!("{}_{support}", description.name)),
        };
        let path = out_dir.join(format!("{name}.rs"));
        let mut files = vec![(path.clone(), rust::module(&model, &name)?)];
        if let Some(dir) = &self.c99 {
            let package = c::package(&model, &name, &self.c99_options)?;
            for note in &package.notes {
                println!("cargo::warning={note}");
            }
            let package = layout::files(&model, package, &name, &self.c99_options, Layout::Bare)?;
            files.extend(
                package
                    .into_iter()
                    .map(|(file, text)| (dir.join(file), text)),
            );
        }
        write_all_if_changed(&files)?;
        Ok(path)
    }
}

/// Write `text` to `path` through a temporary file, unless it is there already.
/// Returns whether the file changed.
///
/// # Errors
/// When the folder or file cannot be written; nothing half-written stays.
pub fn write_if_changed(path: &Path, text: &str) -> Result<bool, Error> {
    let changed = write_all_if_changed(&[(path.to_path_buf(), text.to_string())])?;
    Ok(changed == [true])
}

/// [`write_if_changed`] for files that belong together: none takes its place
/// before all are on the disk. Returns which of them changed.
///
/// # Errors
/// When a folder or file cannot be written; the files are as they were.
pub fn write_all_if_changed(files: &[(PathBuf, String)]) -> Result<Vec<bool>, Error> {
    let staged: Vec<Option<Staged>> = files
        .iter()
        .map(|(path, text)| Staged::new(path, text))
        .collect::<Result<_, Error>>()?;
    for file in staged.iter().flatten() {
        file.place()?;
    }
    Ok(staged.iter().map(Option::is_some).collect())
}

/// A file beside the place that it is meant for; removed unless it is put there.
struct Staged<'a> {
    path: &'a Path,
    temporary: PathBuf,
}

impl<'a> Staged<'a> {
    /// Nothing if the text is in its place already.
    fn new(path: &'a Path, text: &str) -> Result<Option<Staged<'a>>, Error> {
        if fs::read(path).is_ok_and(|old| old == text.as_bytes()) {
            return Ok(None);
        }
        let failed = |source| write_error(path, source);
        if path.is_dir() {
            return Err(failed(io::ErrorKind::IsADirectory.into()));
        }
        if let Some(dir) = path.parent() {
            fs::create_dir_all(dir).map_err(failed)?;
        }
        let mut temporary = path.as_os_str().to_owned();
        temporary.push(format!(".{}.part", std::process::id()));
        let staged = Staged {
            path,
            temporary: temporary.into(),
        };
        fs::write(&staged.temporary, text).map_err(failed)?;
        Ok(Some(staged))
    }

    fn place(&self) -> Result<(), Error> {
        fs::rename(&self.temporary, self.path).map_err(|source| write_error(self.path, source))
    }
}

impl Drop for Staged<'_> {
    fn drop(&mut self) {
        // Gone if it is in its place; otherwise best effort.
        let _ = fs::remove_file(&self.temporary);
    }
}

fn write_error(path: &Path, source: io::Error) -> Error {
    Error::Write {
        file: path.display().to_string(),
        source,
    }
}
