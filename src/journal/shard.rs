//! A shard of a run, worked on and finished: one file, which is there whole or not at all.
//!
//! While it is worked on, units go to a file of a passing name; then they are put in order, ended by a checksum, flushed to
//! disk and moved into place. Whoever makes the same shard at the same time has a passing file of his own, and moves the same
//! units into the same place.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::error::JournalError;
use super::frame::{Kind, MARK, end_frame, frame, unit_frame};
use super::identity::Identity;
use super::shelf::{Shelf, State, read};
use super::writer::Writer;
use crate::configuration::Sha256;
use crate::trial::{Absent, Division, Keeper, Kept, Shard, Stage, Unit};

const ENDING: &str = ".units";
const PASSING: &str = ".partial";

/// The name of a shard's file.
pub fn shard_name(shard: Shard) -> String {
    format!("shard-{:05}-of-{:05}{ENDING}", shard.index, shard.of)
}

/// The shard that a file of such a name holds.
pub(super) fn shard_of(name: &str) -> Option<Shard> {
    let (index, of) = name.strip_prefix("shard-")?.strip_suffix(ENDING)?.split_once("-of-")?;
    let shard = Shard { index: index.parse().ok()?, of: of.parse().ok()? };
    (shard.is_valid() && shard_name(shard) == name).then_some(shard)
}

/// A shard that is worked on.
pub struct ShardFile {
    folder: PathBuf,
    shard: Shard,
    identity: Identity,
    division: Division,
    /// Of earlier tries.
    shelf: Shelf,
    passing: PathBuf,
    writer: Mutex<Writer>,
    fault: Mutex<Option<JournalError>>,
}

/// What there is of a shard before it is worked on.
pub enum Beginning {
    /// It is there, whole: its file, and how many units it has.
    Finished(PathBuf, usize),
    Work(Box<ShardFile>),
}

/// What was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Finished {
    pub path: PathBuf,
    pub units: u64,
    pub bytes: u64,
}

impl ShardFile {
    /// - `identity`: has a shard
    /// - `resume`: whether to go on with what earlier tries have left
    pub fn begin(
        folder: &Path,
        identity: Identity,
        division: Division,
        resume: bool,
    ) -> Result<Beginning, JournalError> {
        let shard = identity.shard.unwrap_or(Shard { index: 0, of: 1 });
        let fault = |path: &Path, source| JournalError::Write { path: path.to_owned(), source };
        fs::create_dir_all(folder).map_err(|source| fault(folder, source))?;
        let mut shelf = Shelf::default();
        if resume {
            let path = folder.join(shard_name(shard));
            match read(&path) {
                Ok(found) => {
                    if let Some(why) = identity.difference(&found.identity) {
                        return Err(JournalError::Foreign { path, why });
                    }
                    if found.state == State::Whole {
                        return Ok(Beginning::Finished(path, found.len()));
                    }
                    // What can be used of a damaged one is used.
                    shelf.take(&path, &found);
                }
                Err(JournalError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => {}
                Err(JournalError::Damaged { .. }) => {}
                Err(error) => return Err(error),
            }
            for path in passing_files(folder, shard) {
                // One without a head is of no use, and one that vanishes was finished.
                let Ok(found) = read(&path) else { continue };
                if let Some(why) = identity.difference(&found.identity) {
                    return Err(JournalError::Foreign { path, why });
                }
                shelf.take(&path, &found);
            }
        }
        let passing = passing_name(folder, shard);
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&passing);
        let file = file.map_err(|source| fault(&passing, source))?;
        // Others see that somebody is at work on it. Without locks they may take it away, and then it is made again.
        let _ = file.try_lock();
        let writer = Mutex::new(Writer::begin(&passing, file, &identity)?);
        let folder = folder.to_owned();
        let fault = Mutex::default();
        Ok(Beginning::Work(Box::new(ShardFile { folder, shard, identity, division, shelf, passing, writer, fault })))
    }

    /// Units of earlier tries.
    pub fn resumed(&self) -> usize {
        self.shelf.len()
    }

    /// What ended the work on it, if a file did.
    pub fn fault(&self) -> Option<JournalError> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Puts all units in order, and the file in its place.
    pub fn finish(mut self) -> Result<Finished, JournalError> {
        let made = match read(&self.passing) {
            Ok(made) => made,
            // Another has finished it, and taken this away.
            Err(error) => return self.finished_by_another().ok_or(error),
        };
        self.shelf.take(&self.passing, &made);
        let next = self.passing.with_extension("finished.partial");
        let place = self.folder.join(shard_name(self.shard));
        let write = |source| JournalError::Write { path: place.clone(), source };
        let finished = self.write_in_order(&next).and_then(|finished| {
            fs::rename(&next, &place).map_err(write)?;
            sync_folder(&self.folder).map_err(write)?;
            Ok(Finished { path: place.clone(), ..finished })
        });
        if finished.is_err() {
            let _ = fs::remove_file(&next);
            return finished;
        }
        let _ = fs::remove_file(&self.passing);
        for path in passing_files(&self.folder, self.shard) {
            // Not while somebody is still at work on it: his end will come, and be the same.
            if File::open(&path).is_ok_and(|file| file.try_lock().is_ok()) {
                let _ = fs::remove_file(&path);
            }
        }
        finished
    }

    fn finished_by_another(&self) -> Option<Finished> {
        let path = self.folder.join(shard_name(self.shard));
        let found = read(&path).ok().filter(|found| found.state == State::Whole)?;
        let same = self.identity.difference(&found.identity).is_none();
        let bytes = fs::metadata(&path).ok()?.len();
        same.then(|| Finished { path, units: found.len() as u64, bytes })
    }

    fn write_in_order(&self, path: &Path) -> Result<Finished, JournalError> {
        let fault = |source| JournalError::Write { path: path.to_owned(), source };
        let file = OpenOptions::new().write(true).create_new(true).open(path).map_err(fault)?;
        let mut out = BufWriter::with_capacity(1 << 18, file);
        let (mut digest, mut bytes) = (Sha256::new(), 0);
        let mut put = |frame: &[u8]| {
            digest.update(frame);
            bytes += frame.len() as u64;
            out.write_all(frame).map_err(fault)
        };
        put(MARK)?;
        // Two machines write the same bytes: where it was made is of no account.
        put(&frame(Kind::Head, &[&serde_json::to_vec(&self.identity).expect("texts and numbers serialise")]))?;
        let units = self.shelf.units();
        for unit in &units {
            let Some(kept) = self.shelf.get(unit) else { continue };
            put(&unit_frame(unit, &kept?))?;
        }
        let end = end_frame(units.len() as u64, digest);
        bytes += end.len() as u64;
        let written = out.write_all(&end).and_then(|()| out.into_inner().map_err(io::IntoInnerError::into_error));
        written.and_then(|file| file.sync_all()).map_err(fault)?;
        Ok(Finished { path: path.to_owned(), units: units.len() as u64, bytes })
    }
}

impl Keeper for ShardFile {
    fn found(&self, unit: &Unit) -> Option<Kept> {
        self.shelf.get(unit)?.ok()
    }

    fn absent(&self, unit: &Unit) -> Absent {
        match self.division.owner(unit, self.shard.of) {
            Some(owner) if owner != self.shard.index => Absent::Leave,
            _ => Absent::Make,
        }
    }

    /// A shard is nothing but its file.
    fn keep(&self, unit: &Unit, kept: Kept) -> ControlFlow<()> {
        let written = self.writer.lock().unwrap_or_else(PoisonError::into_inner).unit(unit, &kept);
        match written {
            Ok(_) => ControlFlow::Continue(()),
            Err(fault) => {
                self.fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
                ControlFlow::Break(())
            }
        }
    }

    fn wants(&self, case: u32, stage: Stage) -> bool {
        self.division.has(self.shard, case, stage)
    }

    fn shares(&self) -> bool {
        true
    }
}

/// A passing name that nobody else has.
fn passing_name(folder: &Path, shard: Shard) -> PathBuf {
    use std::hash::{BuildHasher, Hasher};
    let nonce = std::hash::RandomState::new().build_hasher().finish();
    folder.join(format!(".{}.{nonce:016x}{PASSING}", shard_name(shard)))
}

/// What tries at a shard have left, or are at work on.
fn passing_files(folder: &Path, shard: Shard) -> Vec<PathBuf> {
    let beginning = format!(".{}.", shard_name(shard));
    let is_one = |name: &str| name.starts_with(&beginning) && name.ends_with(PASSING);
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> =
        entries.filter(|entry| entry.file_name().to_str().is_some_and(is_one)).map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

/// The name of a moved file is in the folder's own blocks.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        // Some file systems of networks have nothing to flush there.
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
        done => done,
    }
}

#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}
