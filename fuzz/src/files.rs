//! Files beside a robot and a log: model, sidecar, prior, servos, factors.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use sesc_codegen::emit::c::{self, Options, Scalar};
use sesc_codegen::facts::Facts;
use sesc_codegen::{Servos, emit};
use sesc_identify::fit::part::Part;
use sesc_identify::fit::prior::Prior;
use sesc_identify::fit::{self, Request};
use sesc_identify::logs::Sidecar;
use sesc_model::{Function, ModelFile};

use crate::{logs, two_link};

/// A folder of this process, in memory where there is such.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let temporary = std::env::temp_dir();
        let parent = if memory.is_dir() { memory } else { &temporary };
        let folder = parent.join(format!("sesc_fuzz_{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for files");
        folder
    })
}

/// A model file, then all that is generated of it.
pub fn model(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let Ok(file) = ModelFile::parse(&text, "fuzz.toml") else {
        return;
    };
    let written = file.to_toml().expect("what was read can be written");
    let again = ModelFile::parse(&written, "again.toml");
    assert!(again.is_ok(), "{:?}\n{written}", again.err());
    let Ok(model) = two_link().1.clone().with_file(file) else {
        return;
    };
    let _ = model.evaluate(Function::Cop, &[0.1, -0.2], &model.params());
    let facts = Facts::of(&model);
    let _ = emit::rust::module(&facts, "fuzz");
    let _ = c::package(&facts, "fuzz", &Options::of(Scalar::F32));
}

/// The sidecar of a good log.
pub fn sidecar(data: &[u8]) {
    let log = folder().join("log.csv");
    std::fs::write(Sidecar::path(&log), data).expect("a sidecar");
    std::fs::write(
        &log,
        "pose,ankle,knee,cop_x,cop_y\n0,0.1,0.2,0.01,0\n1,0.3,-0.2,0,0.01\n",
    )
    .expect("a log");
    logs::read(&*log);
}

/// A file of tolerances.
pub fn prior(data: &[u8]) {
    let path = folder().join("prior.toml");
    std::fs::write(&path, data).expect("a prior");
    let model = &two_link().1;
    if let Ok(prior) = Prior::named(&path.display().to_string(), model) {
        assert!(!prior.sentence().is_empty());
    }
}

/// A file of servos, then the C that takes their ticks.
pub fn servos(data: &[u8]) {
    let path = folder().join("servos.toml");
    std::fs::write(&path, data).expect("servos");
    let Ok(servos) = Servos::read(&path) else {
        return;
    };
    let facts = Facts::of(&two_link().1);
    for scalar in [Scalar::F32, Scalar::Fixed32] {
        let mut options = Options::of(scalar);
        options.servos = Some(servos.clone());
        let _ = c::package(&facts, "fuzz", &options);
    }
}

/// A file of factors, then the fit of it.
pub fn part(data: &[u8]) {
    let Ok(part) = Part::from_bytes(data, "fuzz.part") else {
        return;
    };
    let mut request = Request::default();
    request.parts = vec![("fuzz.part".to_string(), part)];
    let _ = fit::fit(&request, &mut ());
}
