//! What can go wrong while a report is written.

use std::io;
use std::path::PathBuf;

/// Why a report, or a part of it, could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The output folder cannot be made or written to.
    #[error("cannot write to the report folder {path}: {source}")]
    Folder { path: PathBuf, source: io::Error },
    /// Something that is no folder stands where the folder should be.
    #[error("the report folder {path} is a file; name a folder, or move the file away")]
    NotAFolder { path: PathBuf },
    /// One file cannot be written, moved into place, or removed.
    #[error("cannot write {path}: {source}")]
    File { path: PathBuf, source: io::Error },
    /// A number that is due is NaN or infinite: a fault of whoever measured it, kept out of the report.
    #[error("{table}, column {column}: {value} is no finite number (row of case {case})")]
    NotFinite { table: &'static str, column: String, case: String, value: f64 },
    /// A table cannot be written to its destination (standard output, say).
    #[error("cannot write {table}: {source}")]
    Table { table: &'static str, source: io::Error },
    /// A folder holds no report, or not all of one.
    #[error("{path} holds no report of etendue: {}", missing.as_ref().map_or("there is no such folder".to_owned(),
        |file| format!("{file} is missing")))]
    NoReport { path: PathBuf, missing: Option<String> },
    /// A file of a report cannot be read.
    #[error("cannot read {path}: {source}")]
    Unreadable { path: PathBuf, source: io::Error },
    /// A file of a report says what cannot be.
    #[error("{path}, line {line}: {reason}")]
    NotOurs { path: PathBuf, line: u64, reason: String },
    /// A plot cannot be drawn.
    #[error("cannot draw {path}: {reason}")]
    Plot { path: PathBuf, reason: String },
}
