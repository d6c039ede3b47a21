//! The generated C on the processors that it is for: built by `tests/firmware/`
//! for Cortex-M3 and Cortex-M4F, run in qemu, compared with this machine and with
//! f64, and counted.
//!
//! `cargo test --test boards -- --nocapture costs` prints what a call costs.

mod build;
mod costs;
mod postures;
mod results;

use std::process::Command;
use std::time::Duration;

use sesc_model::Function;
use sesc_test_support::machine;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const LIMIT: Duration = Duration::from_secs(300);

impl build::Config {
    /// Every name that is called: `com_jacobian`, `com_jacobian_sc`, `com_jacobian_ticks`, …;
    /// floats alone have the ZMP, which divides.
    pub fn names(self) -> impl Iterator<Item = (String, &'static str, &'static str)> {
        // Nobody asks for the Jacobian of the reading here.
        let asked = Function::ALL
            .into_iter()
            .filter(|f| *f != Function::CopJacobian);
        let (of_floats, of_all): (Vec<_>, Vec<_>) =
            asked.partition(|function| *function == Function::Zmp);
        let of = |functions: Vec<Function>| {
            ["", "_sc", "_ticks"].into_iter().flat_map(move |kind| {
                let names = functions.clone().into_iter().map(Function::name);
                names.map(move |name| (format!("{name}{kind}"), name, kind))
            })
        };
        of(of_all).chain(of(if self.fixed { Vec::new() } else { of_floats }))
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
