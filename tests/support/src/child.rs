//! Crates that tests write. Cargo builds all of them in one target folder, so that what they depend
//! on is compiled once.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{ROOT, scratch, tool};

/// A crate that a test writes.
pub struct Child {
    folder: PathBuf,
}

impl Child {
    /// A crate of this name that depends on the runtime; `more` ends its manifest.
    pub fn new(name: &str, more: &str) -> Child {
        let manifest = format!(
            "[workspace]\n[package]\nname = {name:?}\nversion = \"0.1.0\"\nedition = \"2024\"\n\
             [dependencies]\nsesc-runtime = {{ path = \"{ROOT}/runtime\" }}\n{more}"
        );
        let child = Child {
            folder: scratch(&format!("children/{name}")),
        };
        child.write("Cargo.toml", &manifest);
        child
    }

    /// A crate with the dependencies of `examples/controller`, and a copy of the OP2's URDF.
    pub fn controller(name: &str) -> Child {
        let child = Child {
            folder: scratch(&format!("children/{name}")),
        };
        for file in ["Cargo.toml", "Cargo.lock"] {
            let text = Child::example(file).replace("../../", &format!("{ROOT}/"));
            let named = format!("name = {name:?}");
            child.write(file, &text.replace("name = \"controller\"", &named));
        }
        let urdf = fs::read_to_string(format!("{ROOT}/robots/op2/op2.urdf")).unwrap();
        child.write("op2.urdf", &urdf);
        child
    }

    /// A file of `examples/controller`.
    pub fn example(file: &str) -> String {
        fs::read_to_string(format!("{ROOT}/examples/controller/{file}")).unwrap()
    }

    /// The target folder of all these crates.
    pub fn target() -> PathBuf {
        scratch("children-target")
    }

    /// A file of the crate.
    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// Writes a file; what stands there already keeps its time, by which cargo compiles.
    pub fn write(&self, file: &str, text: &str) {
        let path = self.path(file);
        fs::create_dir_all(path.parent().unwrap_or(Path::new(""))).unwrap();
        if !fs::read_to_string(&path).is_ok_and(|before| before == text) {
            fs::write(path, text).unwrap();
        }
    }

    /// What cargo prints, or says where it fails.
    pub fn cargo(&self, arguments: &[&str]) -> Result<Vec<u8>, String> {
        tool(&mut self.command(arguments))
    }

    /// Cargo with these words.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO"));
        command.arg(arguments[0]).arg("--offline");
        command.arg("--target-dir").arg(Child::target());
        command.args(&arguments[1..]).current_dir(&self.folder);
        command
    }
}
