//! Files of commands: what is read is not written, outputs are asked about before any
//! work, and they are gone when a command is interrupted.

use std::path::{Path, PathBuf};

use sesc_identify::logs::Sidecar;
use sesc_model::files::{self, Access, NewFile};

use super::kinds::Kind;
use super::streams::is_standard;
use super::{defaults, message, print_as_is};
use crate::Error;

/// The files of a command. Every command that writes names here all that it reads and
/// writes, with the sidecars that belong to logs.
#[derive(Default)]
pub(super) struct Files {
    access: Access,
    written: Vec<(Kind, PathBuf)>,
    /// Files in folders that are made for them.
    made: Vec<(Kind, PathBuf)>,
    /// How often standard input is read, and standard output written.
    inputs: usize,
    outputs: usize,
    /// What was given `-` and cannot be a stream.
    misused: Option<String>,
}

impl Files {
    /// URDFs that are read, and the options beside them.
    pub(super) fn reads_robots<'a>(self, urdfs: impl IntoIterator<Item = &'a PathBuf>) -> Files {
        urdfs.into_iter().fold(self, |mut files, urdf| {
            files.inputs += usize::from(is_standard(urdf));
            let options = defaults::beside(urdf);
            let access = files.access.reads([urdf]);
            files.access = access.reserves(options, "the options of the robot");
            files
        })
    }

    /// Files that are read, where they are given.
    pub(super) fn reads<'a>(mut self, paths: impl IntoIterator<Item = &'a PathBuf>) -> Files {
        for path in paths {
            if is_standard(path) {
                self.misused.get_or_insert_with(|| {
                    "`-`: standard input is read as a URDF or as a log of --data; give a file here \
                     (`./-` is one of that name)"
                        .to_string()
                });
            }
            self.access = self.access.reads([path]);
        }
        self
    }

    /// Files that are not read and not written either; `role` is what they are.
    pub(super) fn keeps<'a>(
        mut self,
        paths: impl IntoIterator<Item = &'a str>,
        role: &'static str,
    ) -> Files {
        self.access = self.access.reserves(paths, role);
        self
    }

    /// A setting that may name a file.
    pub(super) fn may_read<'a>(self, settings: impl IntoIterator<Item = &'a String>) -> Files {
        let paths: Vec<PathBuf> = settings.into_iter().map(PathBuf::from).collect();
        self.reads(&paths)
    }

    /// Logs that are read, and their sidecars: a file that took the place of one would be
    /// read as it from then on.
    pub(super) fn reads_logs<'a>(self, logs: impl IntoIterator<Item = &'a PathBuf>) -> Files {
        logs.into_iter().fold(self, |mut files, log| {
            if is_standard(log) {
                files.inputs += 1;
                files.access = files.access.reads([log]);
                return files;
            }
            let [own, older] = Sidecar::paths(log);
            let is_read = |path: &PathBuf| !own.exists() || *path == own;
            let sidecars: Vec<PathBuf> = [own.clone(), older].into_iter().filter(is_read).collect();
            let access = files.access.reads([log]);
            files.access = access.reserves(sidecars, "the sidecar of a log");
            files
        })
    }

    /// Files of a kind that are written, where they are asked for.
    pub(super) fn writes<'a>(
        mut self,
        kind: Kind,
        paths: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Files {
        for path in paths {
            if !is_standard(path) {
                self.access = self.access.writes([path]);
                self.written.push((kind, path.clone()));
            } else if kind.streams() {
                self.outputs += 1;
            } else {
                let name = kind.name();
                self.misused.get_or_insert_with(|| {
                    format!("`-`: {name} is written to a file; give its name (`./-` is one)")
                });
            }
        }
        self
    }

    /// Whether a result is printed as JSON, which leaves standard output to nothing else.
    pub(super) fn prints(mut self, json: bool) -> Files {
        if json && self.outputs > 0 {
            let sentence = "--json and an output to `-` both take standard output; give that \
                            output a file";
            self.misused.get_or_insert_with(|| sentence.to_string());
        }
        self
    }

    /// Logs that are written, and the sidecars that come with them.
    pub(super) fn writes_logs<'a>(
        self,
        kind: Kind,
        logs: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Files {
        logs.into_iter().fold(self, |files, log| {
            // A log that ends like a sidecar is refused when it is begun.
            let sidecar = Some(Sidecar::path(log)).filter(|path| path != log);
            let sidecar = sidecar.filter(|_| !is_standard(log));
            files.writes(kind, [log]).writes(Kind::Sidecar, &sidecar)
        })
    }

    /// Files of a kind that may be written, in folders that are made for them.
    pub(super) fn makes<'a>(
        mut self,
        kind: Kind,
        paths: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Files {
        for path in paths {
            self.access = self.access.writes([path]);
            self.made.push((kind, path.clone()));
        }
        self
    }

    /// Whether all of them can go together and each takes the place of its like, before
    /// anything is written.
    ///
    /// # Errors
    /// When a file is read and written, or meant for two outputs, ends like another kind, or
    /// would take the place of a file of another kind.
    pub(super) fn check(&self) -> Result<(), Error> {
        let twice = |count: usize, what: &str| {
            let sentence = format!("`-` is given twice, and standard {what} is there once");
            (count > 1).then_some(sentence)
        };
        let wrong = self.misused.clone();
        let wrong = wrong.or_else(|| twice(self.inputs, "input"));
        if let Some(sentence) = wrong.or_else(|| twice(self.outputs, "output")) {
            return Err(Error::Usage(sentence));
        }
        self.access.check().map_err(Error::Usage)?;
        let mut all = self.written.iter().chain(&self.made);
        all.try_for_each(|(kind, path)| kind.check(path).map_err(Error::Usage))
    }

    /// [`Files::check`], and whether every folder takes a file: before long work, not
    /// behind it.
    ///
    /// # Errors
    /// Besides those, a file that cannot be begun.
    pub(super) fn check_writable(&self) -> Result<(), Error> {
        self.check()?;
        for (_, path) in &self.written {
            // A file that is dropped leaves nothing behind.
            drop(NewFile::create(path)?);
        }
        Ok(())
    }
}

/// Files of one result: all of them are on the disk before the first takes its place, so that
/// a command that ends in between leaves those of an earlier run together.
#[derive(Default)]
pub(super) struct Together {
    files: Vec<(PathBuf, NewFile)>,
    /// What standard output takes instead of a file.
    printed: Option<String>,
}

impl Together {
    /// A file with this text, not yet in its place; `-` is standard output.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(super) fn add(&mut self, path: &Path, text: &str) -> Result<(), Error> {
        match is_standard(path) {
            true => self.printed = Some(text.to_string()),
            false => self.add_begun(path, files::begun(path, text)?),
        }
        Ok(())
    }

    /// A file that is not yet in its place.
    pub(super) fn add_begun(&mut self, path: &Path, file: NewFile) {
        self.files.push((path.to_path_buf(), file));
    }

    /// Move them to their places, and say so.
    ///
    /// # Errors
    /// When one cannot be written to its end.
    pub(super) fn finish(self) -> Result<(), Error> {
        let (paths, new): (Vec<PathBuf>, Vec<NewFile>) = self.files.into_iter().unzip();
        files::finish_together(new)?;
        for path in paths {
            message(&format!("wrote {}", path.display()));
        }
        self.printed.map_or(Ok(()), |text| print_as_is(&text))
    }
}

/// Have SIGINT (Ctrl-C) and SIGTERM end this process without unfinished files, by the
/// exit codes of a shell: 130 and 143.
#[cfg(unix)]
pub(super) fn tidy_when_interrupted() -> std::io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let wait = move || {
        if let Some(signal) = signals.forever().next() {
            sesc_model::files::abandon(128 + signal);
        }
    };
    std::thread::Builder::new().spawn(wait).map(drop)
}

/// Elsewhere files stay where a command is ended from outside.
#[cfg(not(unix))]
pub(super) fn tidy_when_interrupted() -> std::io::Result<()> {
    Ok(())
}
