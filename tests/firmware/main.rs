//! The generated C on the processors that it is for: built by `tests/firmware/`
//! for Cortex-M3 and Cortex-M4F, run in qemu, compared with this machine and with
//! f64, and counted.
//!
//! `cargo test --test firmware -- --nocapture costs` prints what a call costs.

mod build;
mod costs;
mod postures;
mod results;

use std::process::Command;
use std::time::Duration;

use sesc_test_support::machine;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const LIMIT: Duration = Duration::from_secs(300);

const FUNCTIONS: [&str; 8] = [
    "com",
    "com_jacobian",
    "com_velocity",
    "gravity_moments",
    "regressor",
    "regressor_cop",
    "regressor_full",
    "cop",
];

/// Floats alone have this one: it divides.
pub const OF_FLOATS: &str = "zmp";

impl build::Config {
    /// Every name that is called: `com_jacobian`, `com_jacobian_sc`, `com_jacobian_ticks`, …
    pub fn names(self) -> impl Iterator<Item = (String, &'static str, &'static str)> {
        let kinds = ["", "_sc", "_ticks"];
        let in_floats = if self.fixed { None } else { Some(OF_FLOATS) };
        let of = move |functions: Vec<&'static str>| {
            kinds.into_iter().flat_map(move |kind| {
                let functions = functions.clone().into_iter();
                functions.map(move |function| (format!("{function}{kind}"), function, kind))
            })
        };
        of(FUNCTIONS.to_vec()).chain(of(in_floats.into_iter().collect()))
    }
}

#[test]
#[should_panic(expected = "did not end within 100ms and was stopped")]
fn a_program_that_hangs_is_stopped() {
    machine::run(
        Command::new("sleep").arg("60"),
        "",
        Duration::from_millis(100),
    );
}
