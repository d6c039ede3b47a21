//! Calls into the library: without the interpreter's lock, stoppable, and without panics.

use std::any::Any;
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use sesc_identify::{Message, Progress, Watch};

use crate::errors::{Failure, keyword};

/// How often signals are looked for, and progress is shown.
const EVERY: Duration = Duration::from_millis(50);

thread_local! {
    /// What the last panic of this thread said, and where it was.
    static LAST: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// A panic of this module becomes an exception and says nothing on stderr. The hook is that
/// of this shared library alone.
pub fn keep_panics_to_ourselves() {
    std::panic::set_hook(Box::new(|about| {
        let said = about.to_string();
        LAST.with(|last| *last.borrow_mut() = Some(said));
    }));
}

fn internal(_: Box<dyn Any + Send>) -> Failure {
    let said = LAST.with(|last| last.borrow_mut().take());
    let said = said.unwrap_or_else(|| "a panic without words".to_string());
    Failure::internal(format!(
        "{said}; this is a defect of sesc, please report it"
    ))
}

/// Run something short; a panic becomes an exception.
pub fn guarded<T>(py: Python<'_>, call: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(result) => result,
        Err(panic) => Err(internal(panic).raise(py)),
    }
}

/// Run something long without the interpreter's lock.
pub fn detached<T: Send>(
    py: Python<'_>,
    call: impl FnOnce() -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let result = py.detach(|| catch_unwind(AssertUnwindSafe(call)));
    match result {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(failure)) => Err(failure.raise(py)),
        Err(panic) => Err(internal(panic).raise(py)),
    }
}

/// Who waits in Python: Ctrl-C stops the call, and so does an exception of the caller's
/// `progress`.
pub struct Waiting {
    show: Option<Py<PyAny>>,
    looked: Instant,
    stopped: Option<PyErr>,
    /// Sentences about the input.
    pub warnings: Vec<String>,
    /// Sentences about the robot.
    pub notes: Vec<String>,
}

impl Waiting {
    /// With a function of what is done, how much of it, and of how much.
    pub fn new(show: Option<Py<PyAny>>) -> Waiting {
        Waiting {
            show,
            looked: Instant::now(),
            stopped: None,
            warnings: Vec::new(),
            notes: Vec::new(),
        }
    }

    fn look(&self, progress: Progress) -> PyResult<()> {
        Python::attach(|py| {
            py.check_signals()?;
            match &self.show {
                Some(show) => show
                    .call1(py, (progress.what, progress.done, progress.total))
                    .map(drop),
                None => Ok(()),
            }
        })
    }
}

impl Watch for Waiting {
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        if self.looked.elapsed() < EVERY {
            return ControlFlow::Continue(());
        }
        let looked = self.look(progress);
        self.looked = Instant::now();
        match looked {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.stopped = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    fn note(&mut self, note: &str) {
        self.notes.push(note.to_string());
    }

    fn warning(&mut self, warning: &Message) {
        self.warnings.push(warning.worded(keyword));
    }
}

/// Run a call that can be stopped; `waiting` keeps what was said meanwhile.
pub fn watched<T: Send>(
    py: Python<'_>,
    waiting: &mut Waiting,
    call: impl FnOnce(&mut Waiting) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let result = detached(py, || call(waiting));
    match waiting.stopped.take() {
        Some(error) => Err(error),
        None => result,
    }
}
