//! The program `xacro`, which makes URDFs of its own language.
//!
//! It evaluates Python that stands in the file, so it runs only for a path that the caller of
//! the program typed, never for one that a file or folder gave ([`crate::robot::Robot::read`]).

use std::io::{self, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// Longest URDF that it may make, bytes: as much as a URDF may have.
const LONGEST: u64 = 64 << 20;
/// How much of its messages is kept, bytes.
const MESSAGES: u64 = 64 << 10;
/// How long it may run.
const PATIENCE: Duration = Duration::from_secs(60);

/// Why there is no URDF.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failed {
    #[error("the program `xacro` is not installed; install it, or give the URDF that it makes")]
    NotInstalled,
    #[error("standard input is not expanded by xacro; give the path of a file")]
    StandardInput,
    #[error("xacro does not run: {0}")]
    NotRun(io::Error),
    #[error("xacro does not expand it: {0}")]
    Refused(String),
    #[error("xacro makes more than {} MiB of it", LONGEST >> 20)]
    TooLong,
    #[error("xacro did not end within {} s", .0.as_secs_f64())]
    TooSlow(Duration),
    #[error("xacro expands it to what is no UTF-8")]
    NoText,
}

/// What `xacro` makes of a file.
pub(crate) fn expand(path: &Path) -> Result<String, Failed> {
    if path.as_os_str() == "-" {
        return Err(Failed::StandardInput);
    }
    // `./-x` is no option, and an absolute path stays as it is.
    let mut command = Command::new("xacro");
    command.arg(Path::new(".").join(path));
    run(&mut command, PATIENCE)
}

fn run(command: &mut Command, patience: Duration) -> Result<String, Failed> {
    command.stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => Failed::NotInstalled,
        _ => Failed::NotRun(error),
    })?;
    let output = output(&mut child, patience);
    if output.is_err() {
        // It may have ended by itself.
        let _ = child.kill();
        let _ = child.wait();
    }
    output
}

fn output(child: &mut Child, patience: Duration) -> Result<String, Failed> {
    let end = Instant::now() + patience;
    let text = received(child.stdout.take(), LONGEST + 1);
    let messages = received(child.stderr.take(), MESSAGES);
    let left = || end.saturating_duration_since(Instant::now());
    let late = |_| Failed::TooSlow(patience);
    let text = text.recv_timeout(left()).map_err(late)?;
    if text.len() as u64 > LONGEST {
        return Err(Failed::TooLong);
    }
    let messages = messages.recv_timeout(left()).map_err(late)?;
    let status = loop {
        match child.try_wait().map_err(Failed::NotRun)? {
            Some(status) => break status,
            None if left().is_zero() => return Err(Failed::TooSlow(patience)),
            None => thread::sleep(Duration::from_millis(2)),
        }
    };
    if !status.success() {
        let messages = String::from_utf8_lossy(&messages);
        let last = messages.trim_end().lines().next_back().unwrap_or_default();
        return Err(Failed::Refused(last.escape_debug().to_string()));
    }
    String::from_utf8(text).map_err(|_| Failed::NoText)
}

/// The first `most` bytes of a stream, read by a thread of its own: a program of the program may
/// hold the stream open for ever.
fn received(stream: Option<impl Read + Send + 'static>, most: u64) -> Receiver<Vec<u8>> {
    let (send, receive) = mpsc::channel();
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(stream) = stream {
            let mut begin = stream.take(most);
            // What broke off is judged by the exit code.
            let _ = begin.read_to_end(&mut bytes);
            let _ = send.send(bytes);
            // So that the program is not held up by its messages.
            let _ = io::copy(&mut begin.into_inner(), &mut io::sink());
        }
    });
    receive
}

#[cfg(test)]
mod tests {
    #[cfg(unix)]
    use super::*;

    #[cfg(unix)]
    fn shell(script: &str, patience: Duration) -> Result<String, String> {
        let run = run(Command::new("/bin/sh").args(["-c", script]), patience);
        run.map_err(|failed| failed.to_string())
    }

    #[cfg(unix)]
    #[test]
    fn a_program_is_bounded_in_time_and_output() {
        let minute = Duration::from_secs(60);
        let moment = Duration::from_millis(200);
        assert_eq!(shell("cat; echo text", minute).unwrap(), "text\n");
        let endless = "while :; do echo 0123456789012345678901234567890123456789; done";
        let endless = shell(endless, minute);
        assert_eq!(endless.unwrap_err(), "xacro makes more than 64 MiB of it");
        let chatty =
            "i=0; while [ $i -lt 20000 ]; do echo warning >&2; i=$((i+1)); done; echo text";
        assert_eq!(shell(chatty, minute).unwrap(), "text\n");
        for slow in [
            "sleep 20",
            "echo text; exec >&- 2>&-; sleep 20",
            "sleep 20 & echo text",
        ] {
            let said = shell(slow, moment).unwrap_err();
            assert_eq!(said, "xacro did not end within 0.2 s", "{slow}");
        }
        let failed = shell(
            "echo first >&2; echo 'no\u{1b}[1m such' >&2; exit 2",
            minute,
        );
        let expected = "xacro does not expand it: no\\u{1b}[1m such";
        assert_eq!(failed.unwrap_err(), expected);
        let latin = shell("printf '\\377'", minute);
        assert!(latin.unwrap_err().contains("UTF-8"));
    }
}
