//! Units appended to a file, each whole: whatever ends the program ends it between two of them, or within the last.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::error::JournalError;
use super::flush;
use super::frame::{Kind, MARK, frame, unit_frame};
use super::identity::Identity;
use crate::trial::{Kept, Unit};

/// What a power cut may cost. A program that is killed loses nothing that was written.
const UNSYNCED: Duration = Duration::from_secs(20);

pub(super) struct Writer {
    path: PathBuf,
    file: File,
    /// Whole frames so far, bytes.
    at: u64,
    synced: Instant,
    /// Whether any of it was flushed, so that a power cut leaves it.
    pub is_lasting: bool,
    /// Whether what could not be written was cut off, so that more can follow.
    pub is_sound: bool,
}

impl Writer {
    /// A new file, with its head.
    pub fn begin(path: &Path, file: File, identity: &Identity) -> Result<Writer, JournalError> {
        let head = serde_json::to_vec(identity).expect("texts and numbers serialise");
        let mut writer =
            Writer { path: path.to_owned(), file, at: 0, synced: Instant::now(), is_lasting: false, is_sound: true };
        writer.append(MARK)?;
        writer.append(&frame(Kind::Head, &[&head]))?;
        Ok(writer)
    }

    /// A file that is there, from `at` on; what follows is cut off.
    pub fn go_on(path: &Path, file: File, at: u64) -> Result<Writer, JournalError> {
        let mut writer =
            Writer { path: path.to_owned(), file, at, synced: Instant::now(), is_lasting: true, is_sound: true };
        let cut = writer.file.set_len(at).and_then(|()| writer.seek());
        cut.map_err(|source| writer.fault(source))?;
        Ok(writer)
    }

    /// Appends a unit; returns where its payload begins.
    pub fn unit(&mut self, unit: &Unit, kept: &Kept) -> Result<u64, JournalError> {
        self.append(&unit_frame(unit, kept))?;
        Ok(self.at - kept.bytes.len() as u64)
    }

    /// Whole frames so far, bytes.
    pub fn len(&self) -> u64 {
        self.at
    }

    /// Appends bytes, all or none of them.
    pub fn append(&mut self, bytes: &[u8]) -> Result<(), JournalError> {
        let mut written = self.file.write_all(bytes);
        if written.is_ok() && self.synced.elapsed() > UNSYNCED {
            written = self.file.sync_data().and_then(|()| self.path.parent().map_or(Ok(()), flush::folder));
            self.synced = Instant::now();
            self.is_lasting = true;
        }
        match written {
            Ok(()) => {
                self.at += bytes.len() as u64;
                Ok(())
            }
            Err(source) => {
                // Half a frame is cut off; where even that fails, the reader does it.
                self.is_sound = self.file.set_len(self.at).and_then(|()| self.seek()).is_ok();
                Err(self.fault(source))
            }
        }
    }

    fn seek(&mut self) -> io::Result<()> {
        use std::io::Seek;
        self.file.seek(io::SeekFrom::Start(self.at)).map(drop)
    }

    fn fault(&self, source: io::Error) -> JournalError {
        JournalError::Write { path: self.path.clone(), source }
    }
}
