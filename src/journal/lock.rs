//! One run at a time in a folder.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

use super::error::JournalError;

const LOCK: &str = ".lock";

/// Held while a folder is written to. The system lets go of it when the program ends, however it does.
pub struct FolderLock {
    path: PathBuf,
    _file: File,
}

impl FolderLock {
    /// Takes a folder, which is made where there is none.
    pub fn take(folder: &Path) -> Result<FolderLock, JournalError> {
        let path = folder.join(LOCK);
        let fault = |source| JournalError::Write { path: path.clone(), source };
        fs::create_dir_all(folder).map_err(|source| JournalError::Write { path: folder.to_owned(), source })?;
        loop {
            let mut file =
                OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path).map_err(fault)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let mut by = String::new();
                    let _ = file.take(200).read_to_string(&mut by);
                    let by = if by.is_empty() { by } else { format!(" ({})", by.trim()) };
                    return Err(JournalError::InUse { path: folder.to_owned(), by });
                }
                // A file system without locks: two runs at once are then nobody's to tell.
                Err(TryLockError::Error(error)) if error.kind() == std::io::ErrorKind::Unsupported => {}
                Err(TryLockError::Error(error)) => return Err(fault(error)),
            }
            // Who held it before may have taken the file away between the two steps.
            if !is_there(&file, &path) {
                continue;
            }
            let told = format!("process {} on {}\n", std::process::id(), super::host());
            let _ = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(told.as_bytes()));
            return Ok(FolderLock { path, _file: file });
        }
    }
}

#[cfg(unix)]
fn is_there(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (Ok(open), Ok(there)) = (file.metadata(), fs::metadata(path)) else { return false };
    (open.dev(), open.ino()) == (there.dev(), there.ino())
}

/// Where an open file cannot be taken away.
#[cfg(not(unix))]
fn is_there(_: &File, _: &Path) -> bool {
    true
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // While it is held: nobody else has it.
        let _ = fs::remove_file(&self.path);
    }
}
