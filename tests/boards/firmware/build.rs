//! How the firmware is built and run: the configurations of the Makefile.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use super::{LIMIT, ROOT};
use sesc_test_support::machine;

/// Processor, arithmetic and rounding: a CONFIG of the Makefile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    pub name: &'static str,
    /// The board of qemu; none is this machine.
    pub board: Option<&'static str>,
    pub fixed: bool,
}

pub const M3_FIXED: Config = Config {
    name: "m3-fixed",
    board: Some("mps2-an385"),
    fixed: true,
};
pub const M3_F32: Config = Config {
    name: "m3-f32",
    board: Some("mps2-an385"),
    fixed: false,
};
/// Multiplications and additions fused where the compiler likes.
pub const M4F_F32: Config = Config {
    name: "m4f-f32",
    board: Some("mps2-an386"),
    fixed: false,
};
/// Every operation rounded by itself.
pub const M4F_F32_EXACT: Config = Config {
    name: "m4f-f32-exact",
    ..M4F_F32
};
pub const HOST_FIXED: Config = Config {
    name: "host-fixed",
    board: None,
    fixed: true,
};
pub const HOST_F32: Config = Config {
    name: "host-f32",
    board: None,
    fixed: false,
};
pub const TARGETS: [Config; 4] = [M3_FIXED, M3_F32, M4F_F32, M4F_F32_EXACT];

impl Config {
    pub fn prefix(self) -> &'static str {
        match self.fixed {
            true => "op2_r_sole_fixed_",
            false => "op2_r_sole_",
        }
    }

    pub fn header(self) -> String {
        let name = self.prefix().trim_end_matches('_');
        fs::read_to_string(format!("{ROOT}/generated/c/{name}.h")).unwrap()
    }

    /// Runs the Makefile.
    pub fn make(self, out: &Path, arguments: &[&str]) {
        let mut make = Command::new("make");
        make.args(["--silent", "--directory", "tests/firmware"])
            .arg(format!("CONFIG={}", self.name))
            .arg(format!("OUT={}", out.display()))
            .args(arguments)
            .current_dir(ROOT);
        // The jobserver of an outer make is not for us.
        make.env_remove("MAKEFLAGS").env_remove("MAKELEVEL");
        machine::printed(&mut make, "", LIMIT);
    }

    /// The folder with everything built, once in a run.
    pub fn built(self) -> PathBuf {
        static BUILT: Mutex<BTreeSet<&str>> = Mutex::new(BTreeSet::new());
        // Another test's failure to build is that test's.
        let mut built = BUILT
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        let out = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join("firmware")
            .join(self.name);
        if !built.contains(self.name) {
            let _ = fs::remove_dir_all(&out);
            fs::create_dir_all(&out).unwrap();
            fs::write(out.join("postures.h"), self.postures_h()).unwrap();
            self.make(&out, &["all"]);
            built.insert(self.name);
        }
        out
    }

    /// How `program` is run.
    pub fn command(self, program: &str) -> Command {
        let program = self.built().join(format!("{program}.elf"));
        let Some(board) = self.board else {
            return Command::new(program);
        };
        let mut qemu = Command::new("qemu-system-arm");
        qemu.args(["-machine", board, "-nographic"])
            .args(["-monitor", "none", "-serial", "null"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .arg("-kernel")
            .arg(program);
        qemu
    }
}

#[test]
fn clang_compiles_without_warnings() {
    for config in [HOST_FIXED, HOST_F32] {
        let postures = config.built();
        let out = postures.join("clang");
        config.make(
            &out,
            &[
                "CC=clang",
                &format!("POSTURES={}", postures.display()),
                "all",
            ],
        );
    }
    // The target's own part, with the headers of the target's library.
    let mut where_is = Command::new("arm-none-eabi-gcc");
    where_is.args(["-E", "-x", "c", "-"]);
    let text = machine::printed(&mut where_is, "#include <stdlib.h>\n", LIMIT);
    let include = text
        .lines()
        .filter_map(|line| line.split('"').nth(1)?.strip_suffix("/stdlib.h"))
        .next()
        .expect("newlib has a stdlib.h");
    for cpu in ["cortex-m3", "cortex-m4"] {
        let mut clang = Command::new("clang");
        clang
            .args(["--target=arm-none-eabi", "-mthumb", &format!("-mcpu={cpu}")])
            .args(
                "-std=c99 -O2 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion".split(' '),
            )
            .args(["-Wfloat-equal", "-Wshadow", "-Werror", "-isystem", include])
            .args(["-c", "-o", "/dev/null"])
            .arg(format!("{ROOT}/tests/firmware/startup.c"));
        machine::printed(&mut clang, "", LIMIT);
    }
}
