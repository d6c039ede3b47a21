//! Panics of foreign readers that become errors.

use std::cell::Cell;

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Whether a panic on this thread becomes an error of the log that is being read.
///
/// The Parquet library meets some damaged files with a panic, which is caught. The panic
/// hook runs before that and by default prints a message; it belongs to the application, so
/// this library leaves it alone. An application may set one that is silent where this
/// is true, as the command line does:
///
/// ```
/// let usual = std::panic::take_hook();
/// std::panic::set_hook(Box::new(move |about| {
///     if !sesc_identify::logs::panic_becomes_error() {
///         usual(about);
///     }
/// }));
/// ```
pub fn panic_becomes_error() -> bool {
    GUARDED.get()
}

/// Panics of this thread become errors until it is dropped.
#[cfg(feature = "parquet")]
pub(super) struct Guard(());

#[cfg(feature = "parquet")]
impl Guard {
    pub fn new() -> Guard {
        GUARDED.set(true);
        Guard(())
    }
}

#[cfg(feature = "parquet")]
impl Drop for Guard {
    fn drop(&mut self) {
        GUARDED.set(false);
    }
}
