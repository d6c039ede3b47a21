//! How often commands that are killed leave what is neither old nor new.

use std::error::Error;
use std::path::Path;

use clap::Args;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_test_support::kills::{Tally, Victim, WRITERS, Writer};

/// What `cargo xtask kills` is asked.
#[derive(Args)]
pub struct Kills {
    /// Kills of all commands together
    #[arg(long, default_value_t = 1000)]
    times: u32,
    /// Seed of the moments
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl Kills {
    /// Kill `sesc` as it stands beside this program, and print a table.
    ///
    /// # Errors
    /// A file that is neither the old one nor the new one, or a temporary file that stays.
    pub fn run(&self) -> Result<(), Box<dyn Error>> {
        let own = std::env::current_exe()?;
        let program = own
            .with_file_name("sesc")
            .with_extension(std::env::consts::EXE_EXTENSION);
        if !program.exists() {
            return Err(format!("{} is not built: cargo build", program.display()).into());
        }
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let each = self.times.div_ceil(u32::try_from(WRITERS.len())?);
        println!(
            "| command | killed before its end | nothing changed | outputs of two runs | temporary \
             file left |"
        );
        println!("|---|---|---|---|---|");
        let mut all = Tally::default();
        for writer in WRITERS {
            let tally = killed(&program, writer, each, &mut rng)?;
            row(writer.name, &tally);
            all += &tally;
        }
        row("all", &all);
        Ok(())
    }
}

/// Kill a command until so many kills came before its end.
fn killed(
    program: &Path,
    writer: Writer,
    times: u32,
    rng: &mut ChaCha8Rng,
) -> Result<Tally, String> {
    let victim = Victim::new(program, writer);
    let mut all = Tally::default();
    while all.hit < times {
        let tally = victim.kill(times - all.hit, rng)?;
        all += &tally;
        if all.late > 50 * times {
            return Err(format!("{} ends before it is killed", writer.name));
        }
    }
    Ok(all)
}

fn row(name: &str, tally: &Tally) {
    println!(
        "| {name} | {} | {} | {} | {} |",
        tally.hit, tally.old, tally.mixed, tally.left
    );
}
