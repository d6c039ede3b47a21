//! The `sesc` command: exit 0 ok, 1 a check failed, 2 bad usage or input.

use std::process::ExitCode;

fn main() -> ExitCode {
    sesc::cli::main()
}
