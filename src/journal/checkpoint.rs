//! What a run has done so far, in its folder: whatever ends it, another goes on from there.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufReader, Read};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::error::JournalError;
use super::flush;
use super::identity::Identity;
use super::shelf::{Shelf, State, read};
use super::writer::Writer;
use crate::trial::{Absent, Keeper, Kept, Unit};

/// Lies in a report's folder while the run is not finished.
pub const CHECKPOINT: &str = "checkpoint.units";

/// The units of a run that is not finished.
pub struct Checkpoint {
    path: PathBuf,
    /// Of an earlier run.
    shelf: Shelf,
    /// `None` once it cannot be written any more.
    writer: Mutex<Option<Writer>>,
    fault: Mutex<Option<JournalError>>,
}

impl Checkpoint {
    /// Begins anew: what an earlier run left is gone.
    pub fn begin(folder: &Path, identity: &Identity) -> Result<Checkpoint, JournalError> {
        let path = folder.join(CHECKPOINT);
        let file = OpenOptions::new().write(true).create(true).truncate(true).open(&path);
        let file = file.map_err(|source| JournalError::Write { path: path.clone(), source })?;
        let writer = Writer::begin(&path, file, identity)?;
        Ok(Checkpoint::with(path, Shelf::default(), writer))
    }

    /// Goes on where an earlier run was ended, or begins where none was. What belongs to another run is refused, and stays.
    pub fn resume(folder: &Path, identity: &Identity) -> Result<Checkpoint, JournalError> {
        let path = folder.join(CHECKPOINT);
        let found = match read(&path) {
            Ok(found) => found,
            Err(JournalError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                return Checkpoint::begin(folder, identity);
            }
            // Nothing was done yet.
            Err(JournalError::Torn { .. }) => return Checkpoint::begin(folder, identity),
            Err(JournalError::Damaged { .. }) if is_stub(&path) => return Checkpoint::begin(folder, identity),
            Err(error) => return Err(error),
        };
        if let Some(why) = identity.difference(&found.identity) {
            return Err(JournalError::Foreign { path, why });
        }
        let State::Cut { at, .. } = found.state else {
            let what = "it has the end of a shard".to_owned();
            return Err(JournalError::Damaged { path, what });
        };
        let mut shelf = Shelf::default();
        shelf.take(&path, &found);
        let file = OpenOptions::new().write(true).open(&path);
        let file = file.map_err(|source| JournalError::Write { path: path.clone(), source })?;
        let writer = Writer::go_on(&path, file, at)?;
        Ok(Checkpoint::with(path, shelf, writer))
    }

    fn with(path: PathBuf, shelf: Shelf, writer: Writer) -> Checkpoint {
        Checkpoint { path, shelf, writer: Mutex::new(Some(writer)), fault: Mutex::default() }
    }

    /// Whether an earlier run left one in a folder.
    pub fn is_in(folder: &Path) -> bool {
        folder.join(CHECKPOINT).is_file()
    }

    /// Units of an earlier run.
    pub fn resumed(&self) -> usize {
        self.shelf.len()
    }

    /// The first fault that kept units from being kept, or from being read again; told once.
    pub fn fault(&self) -> Option<JournalError> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// The run is finished, and needs none.
    ///
    /// - `report`: the files that were made of it. They are flushed first, so that a power cut never leaves neither; but for a
    ///   run so short that a power cut would have taken it whole
    pub fn remove(self, report: &[PathBuf]) -> Result<(), JournalError> {
        if self.writer.lock().unwrap_or_else(PoisonError::into_inner).as_ref().is_none_or(|open| open.is_lasting) {
            flush::files(report)?;
        }
        match fs::remove_file(&self.path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => {
                Err(JournalError::Write { path: self.path, source })
            }
            _ => Ok(()),
        }
    }

    fn note(&self, fault: JournalError) {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
    }
}

/// Whether a file is shorter than any head is, or holds nothing yet: a power cut may leave the length without the bytes.
fn is_stub(path: &Path) -> bool {
    const SHORTEST: u64 = 64;
    let Ok(file) = File::open(path) else { return false };
    let is_short = file.metadata().is_ok_and(|file| file.len() < SHORTEST);
    let mut bytes = BufReader::new(file).bytes();
    is_short || bytes.all(|byte| matches!(byte, Ok(0)))
}

impl Keeper for Checkpoint {
    /// What cannot be read is made anew.
    fn found(&self, unit: &Unit) -> Option<Kept> {
        match self.shelf.get(unit)? {
            Ok(kept) => Some(kept),
            Err(fault) => {
                self.note(fault);
                None
            }
        }
    }

    fn absent(&self, _: &Unit) -> Absent {
        Absent::Make
    }

    /// A run that cannot keep a unit goes on: it may yet come to its end, and there may be room again for the next.
    fn keep(&self, unit: &Unit, kept: Kept) -> ControlFlow<()> {
        let mut writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(open) = &mut *writer
            && let Err(fault) = open.unit(unit, &kept)
        {
            if !open.is_sound {
                *writer = None;
            }
            drop(writer);
            self.note(fault);
        }
        ControlFlow::Continue(())
    }
}
