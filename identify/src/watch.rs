//! Long calls: how far they are, and how they are stopped.

use std::ops::ControlFlow;

use crate::{Error, Message};

/// How far a long call is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// What is being done.
    pub what: &'static str,
    /// How much of it is done: bytes, rows, postures.
    pub done: u64,
    /// The whole amount; not known of a pipe.
    pub total: Option<u64>,
}

/// Who waits for a long call.
///
/// A closure over progress is one too; it does not receive warnings.
pub trait Watch {
    /// Receive how far the call is; [`ControlFlow::Break`] stops it with an error of kind
    /// [`Interrupted`](crate::ErrorKind::Interrupted), and nothing is written.
    fn progress(&mut self, progress: Progress) -> ControlFlow<()>;

    /// Receive what was assumed about the robot.
    fn note(&mut self, _: &str) {}

    /// Receive a warning about the input.
    fn warning(&mut self, _: &Message) {}
}

impl<F: FnMut(Progress) -> ControlFlow<()>> Watch for F {
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        self(progress)
    }
}

/// Ignores everything: for calls that are short.
impl Watch for () {
    fn progress(&mut self, _: Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Forwards everything to the caller's watch, each warning once, and keeps the warnings, which are
/// part of the result.
pub(crate) struct Recorder<'w> {
    watch: &'w mut dyn Watch,
    pub warnings: Vec<Message>,
}

impl<'w> Recorder<'w> {
    pub(crate) fn new(watch: &'w mut dyn Watch) -> Recorder<'w> {
        let warnings = Vec::new();
        Recorder { watch, warnings }
    }
}

impl Watch for Recorder<'_> {
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        self.watch.progress(progress)
    }

    fn note(&mut self, note: &str) {
        self.watch.note(note);
    }

    fn warning(&mut self, warning: &Message) {
        if !self.warnings.contains(warning) {
            self.watch.warning(warning);
            self.warnings.push(warning.clone());
        }
    }
}

/// Tell `watch` how far a call is, in front ends' own long calls too.
///
/// # Errors
/// When it wants the call stopped.
pub fn tell(
    watch: &mut (impl Watch + ?Sized),
    what: &'static str,
    done: u64,
    total: impl Into<Option<u64>>,
) -> Result<(), Error> {
    let total = total.into();
    match watch.progress(Progress { what, done, total }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::interrupted()),
    }
}
