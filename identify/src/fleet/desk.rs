//! The logs of a group while it is worked on: which are known, which are in memory, and what
//! each contributes.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::content::{Content, Log};
use super::disk::Disk;
use super::evaluate::Parts;
use super::failed::{Failed, with_cause};
use super::groups::Group;
use super::known_logs::{Held, Seen};
use super::options::{Only, Options};
use super::part_of_log::{Contribution, Gathering, support_said};
use super::row::Row;
use super::store::Store;
use crate::Error;
use crate::robot::Robot;
use crate::watch::{Watch, tell};

/// The logs of a group on their way to its row.
pub(super) struct Desk<'a> {
    disk: &'a dyn Disk,
    store: Option<&'a Store>,
    robot: &'a Arc<Robot>,
    options: &'a Options,
    group: &'a Group,
    held: Vec<(PathBuf, Held)>,
    /// What logs contribute that were read here, by the name that the store has for it.
    parts: Vec<(String, Contribution)>,
    /// Hash and path of every log.
    pub read: Vec<(String, PathBuf)>,
    /// Logs that could not be read.
    pub failed: Vec<Failed>,
    /// Why, as rows say it.
    pub errors: Vec<String>,
    /// Logs that were opened; the others are as the store knows them.
    pub opened: usize,
    /// Whether the same logs give the same row the next time.
    pub sound: bool,
}

impl<'a> Desk<'a> {
    pub fn new(
        (store, disk): (Option<&'a Store>, &'a dyn Disk),
        robot: &'a Arc<Robot>,
        options: &'a Options,
        group: &'a Group,
    ) -> Desk<'a> {
        Desk {
            disk,
            store,
            robot,
            options,
            group,
            held: Vec::new(),
            parts: Vec::new(),
            read: Vec::new(),
            failed: Vec::new(),
            errors: Vec::new(),
            opened: 0,
            sound: true,
        }
    }

    /// Know what every log holds, and of parameters alone make its part while it is in memory.
    ///
    /// # Errors
    /// When the store cannot be written; the kind `Interrupted` where `watch` stops it.
    pub fn open(&mut self, watch: &mut dyn Watch) -> Result<(), Error> {
        for path in &self.group.logs {
            let Some(mut held) = self.held(path) else {
                continue;
            };
            if self.options.only == Only::Parameters
                && let Some(log) = &held.log
                && self.digested(&held.content, log, watch)?
            {
                held.log = None;
            }
            self.held.push((path.clone(), held));
        }
        Ok(())
    }

    /// Know what every log holds.
    pub fn look(&mut self) {
        for path in &self.group.logs {
            if let Some(held) = self.held(path) {
                self.held.push((path.clone(), held));
            }
        }
    }

    /// What a log holds; an error is noted.
    fn held(&mut self, path: &Path) -> Option<Held> {
        let known = self.store.map(|store| store.seen(self.disk, path));
        match Held::of(self.disk, path, known) {
            Ok(held) => {
                self.opened += usize::from(held.opened);
                self.read
                    .push((held.content.hash.clone(), path.to_path_buf()));
                Some(held)
            }
            Err(error) => {
                let said = with_cause(&error);
                self.failed.push(Failed {
                    input: path.display().to_string(),
                    error: said.clone(),
                });
                self.errors.push(said);
                None
            }
        }
    }

    /// Make the part of a log that was read, if it says where it stands: else the other logs of
    /// the group have to be known first.
    fn digested(
        &mut self,
        content: &Content,
        log: &Log,
        watch: &mut dyn Watch,
    ) -> Result<bool, Error> {
        let Ok((Some(support), _)) = support_said(self.options, content) else {
            return Ok(false);
        };
        let how = Gathering {
            robot: self.robot,
            options: self.options,
            support: &support,
            alone: true,
        };
        let known = self
            .store
            .and_then(|store| store.part(self.disk, &how, content));
        match known {
            Some(part) => self.parts.push((Store::part_key(&how, content), part)),
            None => {
                self.gathered(&how, log, watch)?;
            }
        }
        Ok(true)
    }

    /// Make the part of a log in memory, and keep it.
    fn gathered(
        &mut self,
        how: &Gathering,
        log: &Log,
        watch: &mut dyn Watch,
    ) -> Result<Contribution, Error> {
        let content = log.content();
        let part = Contribution::of(how, log, watch)?;
        if let Some(store) = self.store.filter(|_| part.is_sound()) {
            // Who stopped the run may be gone: nothing is written any more.
            tell(watch, "diagnosing", 0, 1)?;
            store.put_part(self.disk, (how, &content), &part)?;
        }
        self.parts
            .push((Store::part_key(how, &content), part.clone()));
        Ok(part)
    }

    /// What the logs hold.
    pub fn contents(&self) -> Vec<Content> {
        self.held
            .iter()
            .map(|(_, held)| held.content.clone())
            .collect()
    }

    /// All logs with their bytes: those that the store knows are read.
    ///
    /// # Errors
    /// The kind `Interrupted` where `watch` stops it.
    pub fn in_memory(&mut self, watch: &mut dyn Watch) -> Result<Vec<Log>, Error> {
        let mut logs = Vec::with_capacity(self.held.len());
        for at in 0..self.held.len() {
            tell(watch, "diagnosing", 0, 1)?;
            logs.extend(self.bytes(at));
        }
        Ok(logs)
    }

    /// A log with its bytes, which are read if they have to be. One that is another one by now is
    /// an error, and the row is not kept.
    fn bytes(&mut self, at: usize) -> Option<Log> {
        let (path, held) = &mut self.held[at];
        if held.log.is_some() {
            return held.log.take();
        }
        self.opened += usize::from(!held.opened);
        held.opened = true;
        let read = Held::read(self.disk, path, None).map(|held| held.log);
        let is_it = |log: &Log| log.content() == held.content;
        let error = match read {
            Ok(log) if log.as_ref().is_some_and(is_it) => return log,
            Ok(_) => format!(
                "{} changed while it was read; run again",
                held.content.name()
            ),
            Err(error) => with_cause(&error),
        };
        self.sound = false;
        self.failed.push(Failed {
            input: path.display().to_string(),
            error: error.clone(),
        });
        self.errors.push(error);
        None
    }

    /// Write the row that was made, if it is to be kept, and what logs held that were read.
    ///
    /// # Errors
    /// When the store cannot be written.
    pub fn keep(&self, row: Option<(&str, &Row)>) -> Result<(), Error> {
        let Some(store) = self.store else {
            return Ok(());
        };
        let mut entries = Vec::new();
        if let Some((key, row)) = row {
            entries.push(store.entry_of_row(key, row)?);
        }
        let seen = |(path, held): &'_ (PathBuf, Held)| -> Option<(PathBuf, Seen)> {
            Some((path.clone(), held.seen.clone()?))
        };
        for (path, seen) in self.held.iter().filter_map(seen) {
            entries.push(store.entry_of_seen(&path, &seen)?);
        }
        self.disk.write(&entries)
    }
}

impl Parts for Desk<'_> {
    fn part(
        &mut self,
        how: &Gathering,
        log: &Content,
        watch: &mut dyn Watch,
    ) -> Result<Contribution, Error> {
        let key = Store::part_key(how, log);
        if let Some((_, part)) = self.parts.iter().find(|(own, _)| *own == key) {
            return Ok(part.clone());
        }
        if let Some(part) = self.store.and_then(|store| store.part(self.disk, how, log)) {
            return Ok(part);
        }
        let at = self.held.iter().position(|(_, held)| held.content == *log);
        let bytes = at.and_then(|at| self.bytes(at));
        match bytes {
            Some(log) => self.gathered(how, &log, watch),
            // Why is noted already.
            None => Ok(Contribution::Fault(format!(
                "{} cannot be read",
                log.name()
            ))),
        }
    }

    fn log(&mut self, log: &Content) -> Option<Log> {
        let at = self
            .held
            .iter()
            .position(|(_, held)| held.content == *log)?;
        self.bytes(at)
    }
}
