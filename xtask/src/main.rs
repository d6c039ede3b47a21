//! `cargo xtask TASK`.

use std::error::Error;
use std::path::Path;

use clap::Parser;

/// What is done to the project itself
#[derive(Parser)]
enum Task {
    /// Print operations and instructions of one call; fail where they grew by 2 %
    Counts(xtask::counts::Counts),
    /// Write logs with hidden effects, for benches/hidden
    Hidden(xtask::hidden::Hidden),
    /// Rewrite `generated/`, the figure of README and docs/json.md
    Regen,
    /// Ask about virtual robots, and count the answers in docs/dev/study/
    Study(xtask::study::Study),
}

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    let root = root.ok_or("xtask stands in no folder")?;
    match Task::parse() {
        Task::Counts(counts) => counts.run(root)?,
        Task::Hidden(hidden) => hidden.run(root)?,
        Task::Regen => {
            let changed = xtask::regen::write(root)?;
            for path in &changed {
                eprintln!("rewrote {}", path.display());
            }
            if changed.is_empty() {
                eprintln!("generated/ is up to date");
            }
        }
        Task::Study(study) => study.run(root)?,
    }
    Ok(())
}
