//! Down to the disk: what a power cut is to leave.

#[cfg(unix)]
use std::fs::File;
use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};

use super::error::JournalError;
use crate::threads;

/// Files that were written, and the folders that hold their names; side by side, since each waits for the disk.
pub(super) fn files(paths: &[PathBuf]) -> Result<(), JournalError> {
    let mut folders: Vec<&Path> = paths.iter().filter_map(|path| path.parent()).collect();
    folders.sort();
    folders.dedup();
    let write = |path: &Path, source| JournalError::Write { path: path.to_owned(), source };
    let flushed = |path: &PathBuf| OpenOptions::new().write(true).open(path).and_then(|file| file.sync_all());
    let file = |path: &PathBuf| flushed(path).map_err(|source| write(path, source));
    threads::map(paths, file).into_iter().collect::<Result<(), JournalError>>()?;
    folders.into_iter().try_for_each(|path| folder(path).map_err(|source| write(path, source)))
}

/// The name of a file is in the folder's own blocks.
#[cfg(unix)]
pub(super) fn folder(folder: &Path) -> io::Result<()> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        // Some file systems of networks have nothing to flush there.
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
        done => done,
    }
}

#[cfg(not(unix))]
pub(super) fn folder(_: &Path) -> io::Result<()> {
    Ok(())
}
