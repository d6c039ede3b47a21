//! Rewrites `generated/` from `robots/` (`cargo regen`).

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    match sesc::regenerate::write(root) {
        Ok(changed) => {
            for path in &changed {
                eprintln!("rewrote {}", path.display());
            }
            if changed.is_empty() {
                eprintln!("generated/ is up to date");
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
