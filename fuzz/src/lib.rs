//! Whatever the bytes, an answer or an error: never a panic, a hang, or a number that is none.
//!
//! A function for each target, called with what libFuzzer made up; each states what must hold
//! besides. `fuzz/run` builds and runs them, `docs/dev/quality.md` says what came of them.

pub mod files;
pub mod generated_c;
pub mod logs;
pub mod robots;
pub mod urdf;

use std::sync::OnceLock;

use sesc_identify::robot::Robot;
use sesc_model::{Model, Snapping};

/// The URDF that logs and files belong to.
const TWO_LINK: &str = include_str!("../../robots/two_link/two_link.urdf");

/// Joints `ankle` and `knee` on `foot`.
pub fn two_link() -> &'static (Robot, Model) {
    static KNOWN: OnceLock<(Robot, Model)> = OnceLock::new();
    KNOWN.get_or_init(|| {
        let robot = Robot::parse(TWO_LINK, "two_link.urdf").expect("a robot of this repository");
        let model = robot.model("foot", Snapping::default(), None);
        let model = model.expect("a robot of this repository");
        (robot, model)
    })
}

/// A panic ends the target, unless the library turns it into an error: those of the Parquet
/// reader, which it keeps to itself.
pub fn init() {
    std::panic::set_hook(Box::new(|about| {
        if !sesc_identify::logs::panic_becomes_error() {
            eprintln!("{about}\n{}", std::backtrace::Backtrace::force_capture());
            std::process::abort();
        }
    }));
}

/// A target named after a function of this crate.
#[macro_export]
macro_rules! target {
    ($function:path) => {
        libfuzzer_sys::fuzz_target!(init: $crate::init(), |data: &[u8]| { $function(data); });
    };
}
