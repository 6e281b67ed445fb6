//! Shards put together: what is there, what is missing, what is not to be trusted.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt;
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::error::JournalError;
use super::identity::Identity;
use super::shard::shard_of;
use super::shelf::{Reading, Shelf, State, read};
use crate::trial::{Absent, Keeper, Kept, Portion, Unit};

/// What folders hold of one run.
pub struct Gathered {
    /// Of the run that most files belong to; `None` where there is none.
    pub identity: Option<Identity>,
    /// Into how many shards it is cut.
    pub of: u32,
    /// Shards that no whole file holds, ascending.
    pub missing: Vec<u32>,
    /// What is not to be trusted, by name.
    pub faults: Vec<JournalError>,
    /// Files that hold a shard which another holds, too, and say the same.
    pub duplicates: Vec<PathBuf>,
    /// Whole files of the run.
    pub files: usize,
    pub bytes: u64,
    shelf: Shelf,
}

/// Looks through folders.
pub fn gather(folders: &[PathBuf]) -> Result<Gathered, JournalError> {
    let mut paths = Vec::new();
    for folder in folders {
        paths.extend(shards_in(folder)?);
    }
    paths.sort();
    paths.dedup();
    let readings: Vec<Result<Reading, JournalError>> = paths.par_iter().map(|path| read(path)).collect();
    let mut gathered = Gathered {
        identity: run_of_most(&readings),
        of: 0,
        missing: Vec::new(),
        faults: Vec::new(),
        duplicates: Vec::new(),
        files: 0,
        bytes: 0,
        shelf: Shelf::default(),
    };
    let mut there: BTreeMap<u32, PathBuf> = BTreeMap::new();
    for (path, reading) in paths.into_iter().zip(readings) {
        gathered.add(path, reading, &mut there);
    }
    gathered.of = gathered.identity.as_ref().and_then(|identity| identity.shard).map_or(0, |shard| shard.of);
    gathered.missing = (0..gathered.of).filter(|index| !there.contains_key(index)).collect();
    Ok(gathered)
}

fn shards_in(folder: &Path) -> Result<Vec<PathBuf>, JournalError> {
    let fault = |source| JournalError::Read { path: folder.to_owned(), source };
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(fault)? {
        let entry = entry.map_err(fault)?;
        if entry.file_name().to_str().is_some_and(|name| shard_of(name).is_some()) {
            paths.push(entry.path());
        }
    }
    Ok(paths)
}

/// What most files agree on; among as many, the first by name.
fn run_of_most(readings: &[Result<Reading, JournalError>]) -> Option<Identity> {
    let mut runs: Vec<(&Identity, usize)> = Vec::new();
    for identity in readings.iter().flatten().map(|reading| &reading.identity) {
        match runs.iter_mut().find(|(run, _)| run.difference(identity).is_none()) {
            Some((_, count)) => *count += 1,
            None => runs.push((identity, 1)),
        }
    }
    let most = runs.iter().map(|(_, count)| *count).max()?;
    runs.into_iter().find(|(_, count)| *count == most).map(|(run, _)| run.clone())
}

impl Gathered {
    fn add(&mut self, path: PathBuf, reading: Result<Reading, JournalError>, there: &mut BTreeMap<u32, PathBuf>) {
        let reading = match reading {
            Ok(reading) => reading,
            Err(fault) => return self.faults.push(fault),
        };
        let Some(run) = &self.identity else { return };
        if let Some(why) = run.difference(&reading.identity) {
            return self.faults.push(JournalError::Foreign { path, why });
        }
        let damaged = |path, what: String| JournalError::Damaged { path, what };
        let named = path.file_name().and_then(|name| shard_of(name.to_str()?));
        let Some(shard) = reading.identity.shard.filter(|shard| Some(*shard) == named) else {
            let told = reading.identity.shard.map_or("no shard".to_owned(), |shard| format!("shard {shard}"));
            return self.faults.push(damaged(path, format!("it holds {told}, which its name does not say")));
        };
        if let State::Cut { at, why } = reading.state {
            return self.faults.push(damaged(path, format!("{why} (from byte {at} on)")));
        }
        let contradicted = self.shelf.take(&path, &reading);
        if let Some((unit, other)) = contradicted.first() {
            let what = format!(
                "{} of its results are others than in {}, the first of them {}: one of both machines miscounts",
                contradicted.len(),
                other.display(),
                told(run, unit)
            );
            return self.faults.push(damaged(path, what));
        }
        self.files += 1;
        self.bytes += fs::metadata(&path).map_or(0, |file| file.len());
        match there.entry(shard.index) {
            Entry::Occupied(_) => self.duplicates.push(path),
            Entry::Vacant(place) => drop(place.insert(path)),
        }
    }

    /// Whether a run can be made of it.
    pub fn is_whole(&self) -> bool {
        self.identity.is_some() && self.missing.is_empty() && self.faults.is_empty()
    }

    /// Files stay what they are where another folder becomes the current one.
    pub fn settle(&mut self) {
        self.shelf.settle();
    }

    /// Units of all shards.
    pub fn units(&self) -> usize {
        self.shelf.len()
    }

    /// Its units, for the run that they make up.
    pub fn keeper(&self) -> Merging<'_> {
        Merging { gathered: self, fault: Mutex::default() }
    }
}

/// A unit in words.
fn told(run: &Identity, unit: &Unit) -> String {
    let case = run.cases.get(unit.case as usize).map_or("?", |case| &case.name);
    let Portion { stage, index, of } = unit.portion;
    let part = if of > 1 { format!(" (part {} of {of})", index + 1) } else { String::new() };
    format!("{stage} of {case}{part}")
}

/// Units that others have made; none is made here.
pub struct Merging<'a> {
    gathered: &'a Gathered,
    fault: Mutex<Option<JournalError>>,
}

impl Merging<'_> {
    /// Why the run did not come to its end.
    pub fn fault(&self) -> Option<JournalError> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn note(&self, fault: JournalError) {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
    }
}

impl Keeper for Merging<'_> {
    fn found(&self, unit: &Unit) -> Option<Kept> {
        match self.gathered.shelf.get(unit)? {
            Ok(kept) => Some(kept),
            Err(fault) => {
                self.note(fault);
                None
            }
        }
    }

    fn absent(&self, unit: &Unit) -> Absent {
        if let Some(run) = &self.gathered.identity {
            self.note(JournalError::Lacking { unit: *unit, what: told(run, unit) });
        }
        Absent::GiveUp
    }

    fn keep(&self, _: &Unit, _: Kept) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn makes(&self) -> bool {
        false
    }
}

/// Indices as schedulers take them: `0,3-5,9`.
pub struct Indices<'a>(pub &'a [u32]);

impl fmt::Display for Indices<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut rest = self.0;
        let mut separator = "";
        while let Some(first) = rest.first() {
            let run = rest.iter().zip(*first..).take_while(|(index, next)| *index == next).count();
            let last = rest[run - 1];
            match run {
                1 => write!(f, "{separator}{first}")?,
                _ => write!(f, "{separator}{first}-{last}")?,
            }
            separator = ",";
            rest = &rest[run..];
        }
        Ok(())
    }
}
