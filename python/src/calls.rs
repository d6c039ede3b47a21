//! Calls into the library: without the interpreter's lock, stoppable, and without panics.

use std::any::Any;
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use sesc_identify::{Message, Progress, Watch};

use crate::errors::{Failure, keyword};

/// How often signals are looked for, and progress is shown.
pub(crate) const EVERY: Duration = Duration::from_millis(50);

thread_local! {
    /// What the last panic of this thread said, and where it was.
    static LAST: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// A panic of this module becomes an exception and says nothing on stderr. The hook is that
/// of this shared library alone.
pub(crate) fn keep_panics_to_ourselves() {
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
pub(crate) fn guarded<T>(py: Python<'_>, call: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(result) => result,
        Err(panic) => Err(internal(panic).raise(py)),
    }
}

/// Run something long without the interpreter's lock.
pub(crate) fn detached<T: Send>(
    py: Python<'_>,
    call: impl FnOnce() -> Result<T, Failure> + Send,
) -> PyResult<T> {
    guarded(py, || py.detach(call).map_err(|failure| failure.raise(py)))
}

/// When a call that works in the thread of its caller last looked for signals.
pub(crate) struct Signals(Instant);

impl Signals {
    /// From now on.
    pub(crate) fn new() -> Signals {
        Signals(Instant::now())
    }

    /// The exception of a signal, such as Ctrl-C; looks every [`EVERY`] at most, and takes the
    /// interpreter's lock for that.
    pub(crate) fn look(&mut self) -> PyResult<()> {
        if self.0.elapsed() < EVERY {
            return Ok(());
        }
        self.0 = Instant::now();
        Python::attach(|py| py.check_signals())
    }
}

/// What the thread of a long call and the thread that waits for it share.
#[derive(Default)]
struct Shared {
    stop: AtomicBool,
    progress: Mutex<Option<Progress>>,
}

/// Who watches a long call, in its own thread.
pub(crate) struct Waiting {
    shared: Arc<Shared>,
    /// Sentences about the input.
    pub warnings: Vec<String>,
}

impl Watch for Waiting {
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        if let Ok(mut last) = self.shared.progress.lock() {
            *last = Some(progress);
        }
        match self.shared.stop.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    fn warning(&mut self, warning: &Message) {
        self.warnings.push(warning.worded(keyword));
    }
}

/// What becomes of a call that is stopped.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stopped {
    /// It ends by itself, some time later, and nobody waits: it writes nothing.
    Abandoned,
    /// It has to end first: it takes its unfinished files away.
    Awaited,
}

/// Run a long call in a thread of its own and look for signals meanwhile. `show` is told what is
/// done, how much, and of how much; an exception of it stops the call, as Ctrl-C does.
pub(crate) fn watched<T: Send + 'static>(
    py: Python<'_>,
    show: Option<Py<PyAny>>,
    stopped: Stopped,
    call: impl FnOnce(&mut Waiting) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let look = |progress: Option<Progress>| match (&show, progress) {
        (Some(show), Some(progress)) => {
            let told = (progress.what, progress.done, progress.total);
            show.call1(py, told).map(drop)
        }
        _ => Ok(()),
    };
    run_in_thread(py, look, stopped, call)
}

/// As [`watched`], in a thread that gets no signals: `check` is called every [`EVERY`], and an
/// exception of it stops the call.
pub(crate) fn checked<T: Send + 'static>(
    py: Python<'_>,
    check: Option<Py<PyAny>>,
    call: impl FnOnce(&mut Waiting) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let look = |_| match &check {
        Some(check) => check.call0(py).map(drop),
        None => Ok(()),
    };
    run_in_thread(py, look, Stopped::Abandoned, call)
}

/// Run a call in a thread of its own; a signal stops it, and so does an exception of `look`, which
/// is told how far it is every [`EVERY`].
fn run_in_thread<T: Send + 'static>(
    py: Python<'_>,
    look: impl Fn(Option<Progress>) -> PyResult<()>,
    stopped: Stopped,
    call: impl FnOnce(&mut Waiting) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let shared = Arc::new(Shared::default());
    let (send, mut receive) = mpsc::channel();
    let mut waiting = Waiting {
        shared: Arc::clone(&shared),
        warnings: Vec::new(),
    };
    let work = move || {
        let result = catch_unwind(AssertUnwindSafe(|| call(&mut waiting)));
        let result = result.unwrap_or_else(|panic| Err(internal(panic)));
        // Nobody waits for a call that was abandoned.
        let _ = send.send(result);
    };
    let thread = std::thread::Builder::new().spawn(work)?;
    loop {
        let result;
        (receive, result) = py.detach(move || {
            let result = receive.recv_timeout(EVERY);
            (receive, result)
        });
        let looked = match result {
            Ok(result) => {
                // Gone before the call returns: a process may fork then.
                py.detach(|| drop(thread.join()));
                return result.map_err(|failure| failure.raise(py));
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Failure::internal("a thread ended early").raise(py));
            }
            Err(RecvTimeoutError::Timeout) => py.check_signals().and_then(|()| {
                let progress = shared.progress.lock().ok().and_then(|mut last| last.take());
                look(progress)
            }),
        };
        if let Err(error) = looked {
            shared.stop.store(true, Ordering::Relaxed);
            if stopped == Stopped::Awaited {
                py.detach(|| drop(thread.join()));
            }
            return Err(error);
        }
    }
}

/// Panics inside the package, in each way in which it calls the library (`short`, `long`,
/// `watched`): builds for tests have it, releases do not.
#[cfg(debug_assertions)]
#[pyfunction]
pub(crate) fn _panic(py: Python<'_>, way: String) -> PyResult<()> {
    fn beyond_the_end(way: &str) -> usize {
        [1, 2, 3][way.len()]
    }
    match way.as_str() {
        "short" => guarded(py, || Ok(beyond_the_end(&way))).map(drop),
        "long" => detached(py, || Ok(beyond_the_end(&way))).map(drop),
        _ => watched(py, None, Stopped::Awaited, move |_| {
            Ok(beyond_the_end(&way))
        })
        .map(drop),
    }
}
