//! Why a journal cannot be had.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::trial::Unit;

/// What is wrong with a file of units, with the folder it lies in, or with what it is asked for.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JournalError {
    #[error("cannot read {}: {source}", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("cannot write {}: {source}", path.display())]
    Write { path: PathBuf, source: io::Error },
    /// Another run is at work in the folder.
    #[error("{} is in use by another run{by}; wait for it, or name another folder with --out", path.display())]
    InUse { path: PathBuf, by: String },
    /// It belongs to another run: what is different, what it has, what this run has.
    #[error("{} belongs to another run: {why}", path.display())]
    Foreign { path: PathBuf, why: String },
    /// It was ended before its head was written.
    #[error("{} is damaged: its head is not whole", path.display())]
    Torn { path: PathBuf },
    #[error("{} is damaged: {what}", path.display())]
    Damaged { path: PathBuf, what: String },
    /// Shards that look whole have not all that they should.
    #[error("no shard holds {what}, though all look whole")]
    Lacking { unit: Unit, what: String },
}

impl JournalError {
    /// Whether the same command may do better in a while, with nothing changed but the machine's own state.
    pub fn may_pass(&self) -> bool {
        match self {
            JournalError::InUse { .. } => true,
            JournalError::Read { source, .. } | JournalError::Write { source, .. } => passes(source),
            JournalError::Foreign { .. }
            | JournalError::Torn { .. }
            | JournalError::Damaged { .. }
            | JournalError::Lacking { .. } => false,
        }
    }
}

/// Whether a fault of a file system is one that passes: a server that is away, a handle gone stale.
fn passes(error: &io::Error) -> bool {
    use io::ErrorKind as K;
    matches!(
        error.kind(),
        K::StaleNetworkFileHandle
            | K::TimedOut
            | K::Interrupted
            | K::WouldBlock
            | K::ResourceBusy
            | K::NetworkDown
            | K::NetworkUnreachable
            | K::HostUnreachable
    )
}
