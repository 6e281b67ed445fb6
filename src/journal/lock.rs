//! One run at a time in a folder.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

use super::error::JournalError;

const LOCK: &str = ".lock";
/// Times that the file may be taken away in between; where it seems to each time, the file system numbers files anew.
const PATIENCE: u32 = 100;

/// Held while a folder is written to. The system lets go of it when the program ends, however it does.
pub struct FolderLock {
    path: PathBuf,
    _file: File,
}

impl FolderLock {
    /// Takes a folder, which is made where there is none.
    pub fn take(folder: &Path) -> Result<FolderLock, JournalError> {
        let path = folder.join(LOCK);
        fs::create_dir_all(folder).map_err(|source| JournalError::Write { path: folder.to_owned(), source })?;
        let mut file = FolderLock::open(&path, folder)?;
        // Who held it before may have taken the file away between the two steps.
        for _ in 0..PATIENCE {
            if is_there(&file, &path) {
                break;
            }
            file = FolderLock::open(&path, folder)?;
        }
        let told = format!("process {} on {}\n", std::process::id(), super::host());
        let _ = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(told.as_bytes()));
        Ok(FolderLock { path, _file: file })
    }

    /// The file, made and locked.
    fn open(path: &Path, folder: &Path) -> Result<File, JournalError> {
        let fault = |source| JournalError::Write { path: path.to_owned(), source };
        let file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(fault)?;
        match file.try_lock() {
            Ok(()) => Ok(file),
            Err(TryLockError::WouldBlock) => {
                let mut by = String::new();
                let _ = file.take(200).read_to_string(&mut by);
                let by = if by.is_empty() { by } else { format!(" ({})", by.trim()) };
                Err(JournalError::InUse { path: folder.to_owned(), by })
            }
            // A file system without locks: two runs at once are then nobody's to tell.
            Err(TryLockError::Error(error)) if has_no_locks(&error) => Ok(file),
            Err(TryLockError::Error(error)) => Err(fault(error)),
        }
    }
}

fn has_no_locks(error: &std::io::Error) -> bool {
    /// ENOLCK: a server without a lock manager.
    const NONE_LEFT: i32 = if cfg!(target_os = "linux") { 37 } else { 77 };
    error.kind() == std::io::ErrorKind::Unsupported || (cfg!(unix) && error.raw_os_error() == Some(NONE_LEFT))
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
