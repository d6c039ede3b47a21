//! The build-script interface.

use std::path::{Path, PathBuf};

use crate::Error;
#[cfg(feature = "c99")]
use crate::emit::c::{Scalar, Servos, layout::Layout};
use crate::error::Problem;
use crate::facts::Facts;
#[cfg(feature = "c99")]
use crate::sources::C99;
use crate::sources::{self, Sources};
use sesc_model::{Model, ModelFile, Snapping, files, urdf};

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
#[must_use = "nothing is written before .emit()"]
pub struct Builder {
    urdf: PathBuf,
    support: Option<String>,
    name: Option<String>,
    model: Option<PathBuf>,
    functions: Option<Vec<String>>,
    snapping: Snapping,
    out_dir: Option<PathBuf>,
    reruns: bool,
    /// Folder of the C99, where any is wanted.
    #[cfg(feature = "c99")]
    c99_dir: Option<PathBuf>,
    #[cfg(feature = "c99")]
    c99: C99,
}

impl Builder {
    /// Start from a URDF file; relative paths are relative to the crate's root.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_new");
    /// let module = sesc_codegen::Builder::new("../robots/two_link/two_link.urdf")
    ///     .support("foot")
    ///     .out_dir(&folder) // a build script leaves this out
    ///     .emit()?;
    /// assert_eq!(module, folder.join("two_link_foot.rs"));
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn new(urdf: impl AsRef<Path>) -> Builder {
        Builder {
            urdf: urdf.as_ref().to_path_buf(),
            support: None,
            name: None,
            model: None,
            functions: None,
            snapping: Snapping::default(),
            out_dir: None,
            reruns: true,
            #[cfg(feature = "c99")]
            c99_dir: None,
            #[cfg(feature = "c99")]
            c99: C99::default(),
        }
    }

    /// The link that stands on the ground, its sole at z = 0 of its frame; `foot@40mm` is the
    /// frame 40 mm below that of the link `foot`.
    ///
    /// ```
    /// use sesc_codegen::Builder;
    ///
    /// let builder = Builder::new("../robots/two_link/two_link.urdf").out_dir(".");
    /// let error = builder.support("hand").emit().unwrap_err();
    /// assert!(error.to_string().contains("no link `hand` to stand on; the robot has foot"));
    /// ```
    pub fn support(mut self, link: impl Into<String>) -> Builder {
        self.support = Some(link.into());
        self
    }

    /// Name of the module's file; `<robot>_<support>` unless given.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_name");
    /// let builder = sesc_codegen::Builder::new("../robots/two_link/two_link.urdf");
    /// let module = builder.support("foot").name("leg").out_dir(&folder).emit()?;
    /// assert!(std::fs::read_to_string(module).unwrap().contains("pub struct Leg;"));
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn name(mut self, name: impl Into<String>) -> Builder {
        self.name = Some(name.into());
        self
    }

    /// Identified parameters to add as `MODEL_PARAMS`, and effects that `cop` then has.
    ///
    /// ```
    /// use sesc_codegen::{Builder, ErrorKind};
    ///
    /// let builder = Builder::new("../robots/two_link/two_link.urdf").support("foot");
    /// // `sesc fit two_link.urdf --data log.csv --out model.toml` writes one.
    /// let error = builder.model("no_such.toml").out_dir(".").emit().unwrap_err();
    /// assert_eq!(error.kind(), ErrorKind::Model);
    /// ```
    pub fn model(mut self, file: impl AsRef<Path>) -> Builder {
        self.model = Some(file.as_ref().to_path_buf());
        self
    }

    /// Only these functions, and `com`, which is always there; all of them unless given. What a
    /// controller does not call need not be compiled: of robots with a hundred joints and more
    /// that is most of the compiler's time. `correct_cop` comes along where the model has
    /// effects of the sensor.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_functions");
    /// let builder = sesc_codegen::Builder::new("../robots/two_link/two_link.urdf")
    ///     .support("foot")
    ///     .functions(["com", "com_jacobian"])
    ///     .out_dir(&folder);
    /// let module = std::fs::read_to_string(builder.emit()?).unwrap();
    /// assert!(module.contains("fn com_jacobian") && !module.contains("fn zmp"));
    ///
    /// let error = builder.functions(["zpm"]).emit().unwrap_err();
    /// assert!(error.to_string().starts_with("there is no function `zpm`; known are com, "));
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn functions<S: Into<String>>(mut self, names: impl IntoIterator<Item = S>) -> Builder {
        self.functions = Some(names.into_iter().map(Into::into).collect());
        self
    }

    /// How decimals of right angles are read.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_snapping");
    /// use sesc_codegen::{Builder, Snapping};
    ///
    /// let builder = Builder::new("../robots/two_link/two_link.urdf").support("foot");
    /// builder.snapping(Snapping::Off).out_dir(&folder).emit()?; // 1.5708 is 1.5708
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn snapping(mut self, snapping: Snapping) -> Builder {
        self.snapping = snapping;
        self
    }

    /// Where to write, instead of `OUT_DIR`.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_out_dir");
    /// let builder = sesc_codegen::Builder::new("../robots/two_link/two_link.urdf");
    /// let module = builder.support("foot").out_dir(&folder).emit()?;
    /// assert!(module.starts_with(&folder));
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn out_dir(mut self, dir: impl AsRef<Path>) -> Builder {
        self.out_dir = Some(dir.as_ref().to_path_buf());
        self
    }

    /// Whether to print `cargo::rerun-if-changed` for the files that are read; it is
    /// unless a build script says otherwise.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_reruns");
    /// let builder = sesc_codegen::Builder::new("../robots/two_link/two_link.urdf");
    /// builder.support("foot").emit_rerun_if_changed(false).out_dir(&folder).emit()?;
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn emit_rerun_if_changed(mut self, emit: bool) -> Builder {
        self.reruns = emit;
        self
    }

    /// Generate the module and return its path.
    ///
    /// Prints `cargo::rerun-if-changed` for every file read, also when it fails,
    /// so that mending the file builds again. A file that would not change is
    /// not touched.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_emit");
    /// let builder = sesc_codegen::Builder::new("../robots/two_link/two_link.urdf")
    ///     .support("foot")
    ///     .out_dir(&folder);
    /// let module = std::fs::read_to_string(builder.emit()?).unwrap();
    /// assert!(module.contains("fn com"));
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    ///
    /// # Errors
    /// Everything wrong with the URDF or the model file, an unknown support
    /// link or function, or a folder that cannot be written.
    pub fn emit(&self) -> Result<PathBuf, Error> {
        for read in [Some(&self.urdf), self.model.as_ref()]
            .into_iter()
            .flatten()
        {
            if self.reruns {
                println!("cargo::rerun-if-changed={}", read.display());
            }
        }
        let support = self.support.as_deref().ok_or(Problem::NoSupport)?;
        let functions = sources::functions(self.functions.as_deref())?;
        let variable = "OUT_DIR";
        let out_dir = (self.out_dir.clone())
            .or_else(|| std::env::var_os(variable).map(PathBuf::from))
            .ok_or(Problem::NotABuildScript { variable })?;
        let description = urdf::read(&self.urdf).map_err(sesc_model::Error::from)?;
        let mut model = Model::new(&description, support, self.snapping)?;
        if let Some(file) = &self.model {
            model = model.with_file(ModelFile::read(file)?)?;
        }
        for note in model.cautions() {
            println!("cargo::warning={note}");
        }
        let facts = Facts::with(&model, &functions);
        let mut written = Vec::new();
        let mut take = |sources: Sources, dir: &Path| {
            for note in sources.notes {
                println!("cargo::warning={note}");
            }
            let files = sources.files.into_iter();
            written.extend(files.map(|(file, text)| (dir.join(file), text)));
        };
        take(sources::rust(&facts, self.name.as_deref())?, &out_dir);
        #[cfg(feature = "c99")]
        if let Some(dir) = &self.c99_dir {
            let name = self.name.as_deref();
            take(sources::c99(&facts, name, &self.c99)?, dir);
        }
        let path = written[0].0.clone();
        let access = files::Access::default()
            .reads([&self.urdf])
            .reads(&self.model)
            .writes(written.iter().map(|(path, _)| path));
        access
            .check()
            .map_err(|clash| files::failed(&path, std::io::Error::other(clash)))?;
        files::write_all_if_changed(&written)?;
        Ok(path)
    }
}

#[cfg(feature = "c99")]
impl Builder {
    /// Write C99 too: `<name>.h` and `<name>.c` into `dir`, in f64 (f32 for Arduino and PlatformIO)
    /// and bare unless [`Builder::scalar`] and [`Builder::layout`] say otherwise.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_c99");
    /// let builder = sesc_codegen::Builder::new("../robots/two_link/two_link.urdf");
    /// builder.support("foot").out_dir(&folder).c99(folder.join("c")).emit()?;
    /// assert!(folder.join("c/two_link_foot.h").exists());
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn c99(mut self, dir: impl AsRef<Path>) -> Builder {
        self.c99_dir = Some(dir.as_ref().to_path_buf());
        self
    }

    /// Arithmetic of the C99 functions.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_scalar");
    /// use sesc_codegen::{Builder, Scalar};
    ///
    /// let builder = Builder::new("../robots/two_link/two_link.urdf").support("foot");
    /// builder.c99(&folder).scalar(Scalar::Fixed32).out_dir(&folder).emit()?;
    /// let header = std::fs::read_to_string(folder.join("two_link_foot.h")).unwrap();
    /// assert!(header.contains("typedef int32_t two_link_foot_real;"));
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn scalar(mut self, scalar: Scalar) -> Builder {
        self.c99.scalar = Some(scalar);
        self
    }

    /// Servos whose ticks the C99 functions `_ticks` take; `None` leaves these functions
    /// out. Unless given, f32 and fixed32 have them, of 4096 ticks a turn.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_servos");
    /// use sesc_codegen::{Builder, Servos};
    ///
    /// let builder = Builder::new("../robots/two_link/two_link.urdf").support("foot");
    /// builder.c99(&folder).servos(Servos::default()).out_dir(&folder).emit()?;
    /// let header = std::fs::read_to_string(folder.join("two_link_foot.h")).unwrap();
    /// assert!(header.contains("two_link_foot_com_ticks"));
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn servos(mut self, servos: impl Into<Option<Servos>>) -> Builder {
        self.c99.servos = Some(servos.into());
        self
    }

    /// Whether the C99 has `NAME_estimator`: base parameters by recursive least squares, one
    /// posture a call, in f64 or f32, without allocation. It has not unless asked. With a
    /// model file of `sesc fit`, `NAME_estimator_resume` goes on from that fit.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_estimator");
    /// use sesc_codegen::{Builder, Scalar};
    ///
    /// let builder = Builder::new("../robots/two_link/two_link.urdf").support("foot");
    /// builder.c99(&folder).scalar(Scalar::F32).estimator(true).out_dir(&folder).emit()?;
    /// let header = std::fs::read_to_string(folder.join("two_link_foot.h")).unwrap();
    /// assert!(header.contains("int two_link_foot_estimator_add("));
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn estimator(mut self, wanted: bool) -> Builder {
        self.c99.estimator = wanted;
        self
    }

    /// Functions of many postures in the C99, `NAME_com_batch` and so on, for gcc and clang:
    /// structures of arrays, in f64 or f32, computed as many side by side as a register of the
    /// target holds, at most `lanes`, which is 4, 8 or 16. There are none unless asked.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_lanes");
    /// use sesc_codegen::Builder;
    ///
    /// let builder = Builder::new("../robots/two_link/two_link.urdf").support("foot");
    /// builder.c99(&folder).lanes(8).out_dir(&folder).emit()?;
    /// let header = std::fs::read_to_string(folder.join("two_link_foot.h")).unwrap();
    /// assert!(header.contains("void two_link_foot_com_batch("));
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn lanes(mut self, lanes: u32) -> Builder {
        self.c99.lanes = Some(lanes);
        self
    }

    /// What to put around the C99 files.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join("sesc_builder_layout");
    /// use sesc_codegen::{Builder, Layout};
    ///
    /// let builder = Builder::new("../robots/two_link/two_link.urdf").support("foot");
    /// builder.c99(&folder).layout(Layout::Cmake).out_dir(&folder).emit()?;
    /// assert!(folder.join("CMakeLists.txt").exists());
    /// # Ok::<(), sesc_codegen::Error>(())
    /// ```
    pub fn layout(mut self, layout: Layout) -> Builder {
        self.c99.layout = layout;
        self
    }
}
