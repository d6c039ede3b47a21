//! The hash of a file's bytes, on a thread of its own while its rows are read: columns lie one
//! behind the other, so that no reader of rows meets all bytes in their order.

use std::hash::Hasher as _;
use std::io::{self, Read as _};
use std::panic;
use std::sync::{Arc, Weak};
use std::thread::{Builder, JoinHandle};

use twox_hash::XxHash64;

use crate::logs::input::{Bytes, Place};

/// Bytes read at once.
const PIECE: usize = 1 << 18;

/// A hash under way; it is given up with this.
pub(super) struct Hashing {
    thread: JoinHandle<io::Result<u64>>,
    /// The thread goes on as long as this is there.
    wanted: Arc<()>,
}

impl Hashing {
    /// Begin; none where no thread starts.
    pub fn begin(place: &Place) -> Option<Hashing> {
        let wanted = Arc::new(());
        let (place, still) = (place.clone(), Arc::downgrade(&wanted));
        let work = move || while_wanted(&place, &still);
        let thread = Builder::new().name("hash".into()).spawn(work).ok()?;
        Some(Hashing { thread, wanted })
    }

    /// The hash.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn end(self) -> io::Result<u64> {
        let Hashing { thread, wanted } = self;
        let hash = thread.join();
        drop(wanted);
        hash.unwrap_or_else(|reason| panic::resume_unwind(reason))
    }
}

/// The hash, here and now.
///
/// # Errors
/// A file that cannot be read.
pub(super) fn of(place: &Place) -> io::Result<u64> {
    let wanted = Arc::new(());
    while_wanted(place, &Arc::downgrade(&wanted))
}

fn while_wanted(place: &Place, wanted: &Weak<()>) -> io::Result<u64> {
    let mut file = Bytes::open(place)?;
    let mut buffer = vec![0; PIECE];
    let mut hash = XxHash64::with_seed(0);
    while wanted.strong_count() > 0 {
        match file.read(&mut buffer)? {
            0 => break,
            n => hash.write(&buffer[..n]),
        }
    }
    Ok(hash.finish())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logs::table::Shared;

    #[test]
    fn a_hash_aside_is_that_of_the_bytes() {
        // That of nothing, by the description of XXH64.
        let nothing = Place::Bytes(Shared::new(Vec::new()));
        assert_eq!(of(&nothing).unwrap(), 0xef46_db37_51d8_e999);
        let bytes: Vec<u8> = (0..3 * PIECE + 1).map(|k| ((k * k) >> 7) as u8).collect();
        let place = Place::Bytes(Shared::new(bytes));
        let aside = Hashing::begin(&place).unwrap().end().unwrap();
        assert_eq!(aside, of(&place).unwrap());
    }
}
