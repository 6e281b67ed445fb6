//! Units that lie in files: where each is, and what it says when it is asked for. Only places are held in memory.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::error::JournalError;
use super::frame::{BEFORE, Broken, Frames, Kind, end_of, unit_of};
use super::identity::Identity;
use crate::trial::{Kept, Unit};

/// What is said of a file that ends after a whole unit.
pub(super) const UNFINISHED: &str = "it is not finished";

/// Longest head, bytes: names of a hundred thousand cases.
const LONGEST_HEAD: usize = 64 << 20;

/// Where a unit's payload lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    file: u32,
    at: u64,
    length: u32,
    seconds: f64,
    /// CRC-32 of the payload: two files that hold the same unit hold the same payload.
    checksum: u32,
}

/// A file that was read from end to end.
pub(super) struct Reading {
    pub identity: Identity,
    /// Each with where it lies; the file is nobody's yet.
    units: Vec<(Unit, Place)>,
    pub state: State,
}

impl Reading {
    /// Units.
    pub fn len(&self) -> usize {
        self.units.len()
    }
}

/// How a file ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// As it should.
    Whole,
    /// After this byte there is nothing that can be used.
    Cut { at: u64, why: &'static str },
}

/// Reads a file from end to end and checks every byte of it. What is before a damaged place can be used.
pub(super) fn read(path: &Path) -> Result<Reading, JournalError> {
    let fault = |source| JournalError::Read { path: path.to_owned(), source };
    // A pipe would be waited for.
    if !fs::metadata(path).map_err(fault)?.is_file() {
        return Err(JournalError::Damaged { path: path.to_owned(), what: "it is no file".to_owned() });
    }
    let file = File::open(path).map_err(fault)?;
    let length = file.metadata().map_err(fault)?.len();
    read_from(BufReader::with_capacity(1 << 16, file), length, path)
}

/// The same from anywhere.
///
/// - `path`: what it is called in errors
pub(super) fn read_from(from: impl Read, length: u64, path: &Path) -> Result<Reading, JournalError> {
    let fault = |source| JournalError::Read { path: path.to_owned(), source };
    let damaged = |what: &str| JournalError::Damaged { path: path.to_owned(), what: what.to_owned() };
    let frames = Frames::begin(from, length).map_err(fault)?;
    let mut frames = frames.ok_or_else(|| damaged("it does not begin as a file of units does"))?;
    let mut body = Vec::new();
    let head = frames.next(&mut body).map_err(fault)?;
    if head == Err(Broken::Short) {
        return Err(JournalError::Torn { path: path.to_owned() });
    }
    if head != Ok(Some(Kind::Head)) || body.len() > LONGEST_HEAD {
        return Err(damaged("its head cannot be read"));
    }
    let identity: Identity = serde_json::from_slice(&body).map_err(|_| damaged("its head cannot be read"))?;
    if identity.shard.is_some_and(|shard| !shard.is_valid()) {
        return Err(damaged("its head names a shard that cannot be"));
    }
    let mut units = Vec::new();
    let state = loop {
        let at = frames.at;
        let cut = |why| State::Cut { at, why };
        let sofar = frames.digest.clone();
        match frames.next(&mut body).map_err(fault)? {
            Ok(Some(Kind::Unit)) => {
                let Some((unit, seconds, payload)) = unit_of(&body) else { break cut("a unit has no key") };
                let start = at + BEFORE as u64 + (body.len() - payload.len()) as u64;
                let (length, checksum) = (payload.len() as u32, crc32fast::hash(payload));
                units.push((unit, Place { file: 0, at: start, length, seconds, checksum }));
            }
            Ok(Some(Kind::End)) => {
                let Some((count, digest)) = end_of(&body) else { break cut("its end cannot be read") };
                if count != units.len() as u64 || digest != sofar.finalize() {
                    break cut("its checksum does not match");
                }
                if frames.at != length {
                    break cut("something follows its end");
                }
                break State::Whole;
            }
            Ok(Some(Kind::Head)) => break cut("it has a second head"),
            Ok(None) => break cut(UNFINISHED),
            Err(Broken::Short) => break cut("it ends in the middle of a unit"),
            Err(Broken::Altered) => break cut("the checksum of a unit does not match"),
        }
    };
    Ok(Reading { identity, units, state })
}

/// Units of many files.
#[derive(Default)]
pub(super) struct Shelf {
    files: Vec<PathBuf>,
    /// The one that was asked last: neighbours are asked for one after the other.
    open: Mutex<Option<(u32, File)>>,
    places: HashMap<Unit, Place>,
}

impl Shelf {
    /// Takes up the units of a file; those that are there already stay, and are told with the file that has them if they say
    /// something else.
    pub fn take(&mut self, path: &Path, read: &Reading) -> Vec<(Unit, PathBuf)> {
        let file = self.files.len() as u32;
        self.files.push(path.to_owned());
        let mut contradicted = Vec::new();
        for (unit, place) in &read.units {
            let known = *self.places.entry(*unit).or_insert(Place { file, ..*place });
            if (known.checksum, known.length) != (place.checksum, place.length) {
                contradicted.push((*unit, self.files[known.file as usize].clone()));
            }
        }
        contradicted
    }

    /// Paths are those of the folder that is the current one now.
    pub fn settle(&mut self) {
        for path in &mut self.files {
            if let Ok(absolute) = std::path::absolute(&*path) {
                *path = absolute;
            }
        }
    }

    /// Takes up what another has that is not here.
    pub fn take_rest(&mut self, other: Shelf) {
        let before = self.files.len() as u32;
        self.files.extend(other.files);
        for (unit, place) in other.places {
            self.places.entry(unit).or_insert(Place { file: before + place.file, ..place });
        }
    }

    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Ascending.
    pub fn units(&self) -> Vec<Unit> {
        let mut units: Vec<Unit> = self.places.keys().copied().collect();
        units.sort_unstable();
        units
    }

    /// What a unit says; `None` if it is not here, an error if its file is not what it was.
    pub fn get(&self, unit: &Unit) -> Option<Result<Kept, JournalError>> {
        let place = *self.places.get(unit)?;
        let path = &self.files[place.file as usize];
        let kept = self.payload(&place).map_err(|source| JournalError::Read { path: path.clone(), source });
        Some(kept.and_then(|bytes| {
            if crc32fast::hash(&bytes) == place.checksum {
                return Ok(Kept { bytes, seconds: place.seconds });
            }
            let what = "it was changed while it was read".to_owned();
            Err(JournalError::Damaged { path: path.clone(), what })
        }))
    }

    fn payload(&self, place: &Place) -> io::Result<Vec<u8>> {
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let known = open.take().filter(|(file, _)| *file == place.file);
        let (_, file) = match known {
            Some(known) => open.insert(known),
            None => open.insert((place.file, File::open(&self.files[place.file as usize])?)),
        };
        file.seek(SeekFrom::Start(place.at))?;
        let mut bytes = vec![0; place.length as usize];
        file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}
