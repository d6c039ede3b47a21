//! Streams of bytes that can be started again.

use std::fmt;
use std::io::{self, Read};
use std::sync::Arc;

type Open = dyn Fn() -> io::Result<Box<dyn Read + Send>> + Send + Sync;

/// Starts a stream from its first byte, as often as asked.
#[derive(Clone)]
pub(in crate::logs) struct Opener(Arc<Open>);

impl Opener {
    pub fn new<R: Read + Send + 'static>(
        open: impl Fn() -> io::Result<R> + Send + Sync + 'static,
    ) -> Opener {
        let boxed = move || -> io::Result<Box<dyn Read + Send>> { Ok(Box::new(open()?)) };
        Opener(Arc::new(boxed))
    }

    pub fn open(&self) -> io::Result<Box<dyn Read + Send>> {
        (self.0)()
    }
}

impl fmt::Debug for Opener {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a stream")
    }
}
