//! `cargo xtask TASK`.

use std::error::Error;
use std::path::Path;

use clap::Parser;

/// What is done to the project itself
#[derive(Parser)]
enum Task {
    /// Write licences and bill of materials of the command line, for a binary archive
    Bill(xtask::crates::archive::Bill),
    /// Print operations and instructions of one call; fail where they grew by 2 %
    Counts(xtask::counts::Counts),
    /// Print what a log of a fleet costs, step by step
    FleetCosts(xtask::fleet_costs::FleetCosts),
    /// Rewrite docs/dependencies.md
    Dependencies(xtask::crates::page::Dependencies),
    /// Draw the rows of a large fleet, and print what putting them together costs
    FleetParts(xtask::fleet_parts::FleetParts),
    /// Rewrite `generated/`, the figure of README, pages of effects and tables of formats
    Regen,
    /// Hide effects in virtual robots, ask `sesc diagnose`, and count in docs/study.md
    Study(xtask::study::Study),
    /// Hide effects of the body, and judge the diagnosed CoM in docs/study-com.md
    StudyCom(xtask::study_com::StudyCom),
    /// Record robots that miss nothing, and count in docs/study-false-alarms.md
    StudyFalseAlarms(xtask::study_false_alarms::StudyFalseAlarms),
    /// Diagnose fleets of virtual robots, and count in docs/study-fleet.md
    StudyFleet(xtask::study_fleet::StudyFleet),
    /// Break logs of virtual robots, and count what is recognised and what is found wrongly
    StudyHealth(xtask::study_health::StudyHealth),
    /// Record moving robots at several rates, and count verdicts in docs/study-motion.md
    StudyMotion(xtask::study_motion::StudyMotion),
    /// Record robots with noise that lasts, and count in docs/study-recordings.md
    StudyRecordings(xtask::study_recordings::StudyRecordings),
}

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    let root = root.ok_or("xtask stands in no folder")?;
    match Task::parse() {
        Task::Bill(bill) => bill.run(root)?,
        Task::Counts(counts) => counts.run(root)?,
        Task::FleetCosts(costs) => costs.run(root)?,
        Task::Dependencies(page) => page.run(root)?,
        Task::FleetParts(parts) => parts.run()?,
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
        Task::StudyCom(study) => study.run(root)?,
        Task::StudyFalseAlarms(study) => study.run(root)?,
        Task::StudyFleet(study) => study.run(root)?,
        Task::StudyHealth(study) => study.run(root)?,
        Task::StudyMotion(study) => study.run(root)?,
        Task::StudyRecordings(study) => study.run(root)?,
    }
    Ok(())
}
