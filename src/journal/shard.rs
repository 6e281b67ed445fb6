//! A shard of a run, worked on and finished: one file, which is there whole or not at all.
//!
//! While it is worked on, units go to a file of a passing name; then they are put in order, ended by a checksum, flushed to
//! disk and moved into place. Whoever makes the same shard at the same time has a passing file of his own, and moves the same
//! units into the same place.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

use super::error::JournalError;
use super::flush;
use super::frame::{Kind, MARK, end_frame, frame, unit_frame};
use super::identity::Identity;
use super::shelf::{Shelf, State, UNFINISHED, read};
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
    earlier: Mutex<Shelf>,
    /// Units of earlier tries.
    resumed: usize,
    /// Whether earlier tries have left work that is not gone on with.
    pub left: bool,
    passing: PathBuf,
    writer: Mutex<Writer>,
    /// Units that were written.
    kept: AtomicU64,
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
                        // Whoever finished it may have been ended before this.
                        sweep(folder, shard);
                        return Ok(Beginning::Finished(path, found.len()));
                    }
                    // What can be used of a damaged one is used.
                    shelf.take(&path, &found);
                }
                Err(JournalError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => {}
                Err(JournalError::Torn { .. } | JournalError::Damaged { .. }) => {}
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
        let left = !resume && !passing_files(folder, shard).is_empty();
        let passing = passing_name(folder, shard);
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&passing);
        let file = file.map_err(|source| fault(&passing, source))?;
        // Others see that somebody is at work on it. Without locks they may take it away, and then it is made again.
        let _ = file.try_lock();
        let writer = Mutex::new(Writer::begin(&passing, file, &identity)?);
        let folder = folder.to_owned();
        Ok(Beginning::Work(Box::new(ShardFile {
            folder,
            shard,
            identity,
            division,
            resumed: shelf.len(),
            earlier: Mutex::new(shelf),
            left,
            passing,
            writer,
            kept: AtomicU64::new(0),
            fault: Mutex::default(),
        })))
    }

    /// Units of earlier tries.
    pub fn resumed(&self) -> usize {
        self.resumed
    }

    /// What ended the work on it, if a file did.
    pub fn fault(&self) -> Option<JournalError> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Puts all units in order, and the file in its place.
    pub fn finish(self) -> Result<Finished, JournalError> {
        let next = self.passing.with_extension("finished.partial");
        let finished = self.all().and_then(|all| self.put(&all, &next)).or_else(|error| {
            let _ = fs::remove_file(&next);
            // Whoever finished it first has taken this away.
            self.finished_by_another().ok_or(error)
        })?;
        let _ = fs::remove_file(&self.passing);
        sweep(&self.folder, self.shard);
        Ok(finished)
    }

    /// All units of the shard: those that were made now, as they were written, and what earlier tries have left.
    fn all(&self) -> Result<Shelf, JournalError> {
        let made = read(&self.passing)?;
        let (length, units) = {
            let writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner);
            (writer.len(), self.kept.load(Relaxed))
        };
        // Whoever wrote it knows what it should hold.
        if (made.state != State::Cut { at: length, why: UNFINISHED }) || made.len() as u64 != units {
            let what = match made.state {
                State::Cut { at, why } if at < length => format!("{why} (from byte {at} on): not what was written"),
                _ => "it is not what was written".to_owned(),
            };
            return Err(JournalError::Damaged { path: self.passing.clone(), what });
        }
        let mut all = Shelf::default();
        all.take(&self.passing, &made);
        let mut earlier = self.earlier.lock().unwrap_or_else(PoisonError::into_inner);
        all.take_rest(std::mem::take(&mut *earlier));
        Ok(all)
    }

    /// Writes units under a passing name, and moves the file into its place.
    fn put(&self, all: &Shelf, next: &Path) -> Result<Finished, JournalError> {
        let place = self.folder.join(shard_name(self.shard));
        let write = |source| JournalError::Write { path: place.clone(), source };
        // The file stays open, and with it the lock, until it is in its place.
        let (_held, finished) = self.write_in_order(all, next)?;
        fs::rename(next, &place).map_err(write)?;
        flush::folder(&self.folder).map_err(write)?;
        Ok(Finished { path: place.clone(), ..finished })
    }

    fn finished_by_another(&self) -> Option<Finished> {
        let path = self.folder.join(shard_name(self.shard));
        let found = read(&path).ok().filter(|found| found.state == State::Whole)?;
        let same = self.identity.difference(&found.identity).is_none();
        let bytes = fs::metadata(&path).ok()?.len();
        same.then(|| Finished { path, units: found.len() as u64, bytes })
    }

    fn write_in_order(&self, all: &Shelf, path: &Path) -> Result<(File, Finished), JournalError> {
        let fault = |source| JournalError::Write { path: path.to_owned(), source };
        let file = OpenOptions::new().write(true).create_new(true).open(path).map_err(fault)?;
        let _ = file.try_lock();
        let mut out = BufWriter::with_capacity(1 << 18, file);
        let (mut digest, mut bytes) = (Sha256::new(), 0);
        let mut put = |frame: &[u8]| {
            digest.update(frame);
            bytes += frame.len() as u64;
            out.write_all(frame).map_err(fault)
        };
        put(MARK)?;
        // Of two machines the heads differ in where it was made, and the units in how long they took.
        put(&frame(Kind::Head, &[&serde_json::to_vec(&self.identity).expect("texts and numbers serialise")]))?;
        let units = all.units();
        for unit in &units {
            let Some(kept) = all.get(unit) else { continue };
            put(&unit_frame(unit, &kept?))?;
        }
        let end = end_frame(units.len() as u64, digest);
        bytes += end.len() as u64;
        let written = out.write_all(&end).and_then(|()| out.into_inner().map_err(io::IntoInnerError::into_error));
        let file = written.and_then(|file| file.sync_all().map(|()| file)).map_err(fault)?;
        Ok((file, Finished { path: path.to_owned(), units: units.len() as u64, bytes }))
    }
}

impl Keeper for ShardFile {
    fn found(&self, unit: &Unit) -> Option<Kept> {
        self.earlier.lock().unwrap_or_else(PoisonError::into_inner).get(unit)?.ok()
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
            Ok(_) => {
                self.kept.fetch_add(1, Relaxed);
                ControlFlow::Continue(())
            }
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

/// Takes away what tries at a shard that is there have left.
fn sweep(folder: &Path, shard: Shard) {
    for path in passing_files(folder, shard) {
        // Not while somebody is still at work on it: his end will come, and be the same.
        let is_left = |file: File| file.try_lock().is_ok();
        if OpenOptions::new().write(true).open(&path).is_ok_and(is_left) {
            let _ = fs::remove_file(&path);
        }
    }
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
