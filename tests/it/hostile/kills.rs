//! Commands that are killed at any moment leave every file as it was or as it will be, whole.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_test_support::kills::{Victim, writers};

/// Kills of each command.
const KILLS: u32 = 12;

#[test]
#[cfg(unix)]
fn killed_commands_leave_old_files_or_new_ones() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut hit = 0;
    // A demo takes seconds.
    for writer in writers().filter(|writer| writer.name != "demo") {
        hit += Victim::new(writer).kill(KILLS, &mut rng).unwrap();
    }
    assert!(hit >= 3 * KILLS, "only {hit} were killed before their end");
}
