//! What units of work came to, in files: so that nothing is lost that was done, and many can do one run.
//!
//! - a [`Checkpoint`] lies in a report's folder while a run goes on;
//! - a [`ShardFile`] holds one shard of a run;
//! - [`gather`] puts shards together, in whatever order they come, and names what is missing, damaged or of another run.
//!
//! A file says which run it belongs to ([`Identity`]: version, seed, options, cases by their content, and a fingerprint of
//! the machine's numbers); each unit has a checksum, and so has a finished file.

mod checkpoint;
mod error;
mod flush;
mod frame;
mod gather;
mod identity;
mod lock;
mod shard;
mod shelf;
#[cfg(test)]
mod tests;
mod writer;

pub use checkpoint::{CHECKPOINT, Checkpoint};
pub use error::JournalError;
pub use gather::{Gathered, Indices, Merging, gather};
pub use identity::{CaseIdentity, Identity};
pub use lock::FolderLock;
pub use shard::{Beginning, Finished, ShardFile, shard_name};

/// Reads bytes as [`gather`] reads a file of units, to their end; for who feeds it with what is none.
#[doc(hidden)]
pub fn try_bytes(bytes: &[u8]) -> Result<(), JournalError> {
    shelf::read_from(bytes, bytes.len() as u64, std::path::Path::new("these bytes")).map(drop)
}

/// The same of bodies that are framed first, as if they had been written so; each behind a byte that says how long it is, and of
/// what kind.
#[doc(hidden)]
pub fn try_bodies(mut bytes: &[u8]) -> Result<(), JournalError> {
    let mut file = frame::MARK.to_vec();
    let mut digest = crate::configuration::Sha256::new();
    let mut units = 0;
    while let Some((first, rest)) = bytes.split_first() {
        let (body, rest) = rest.split_at((usize::from(*first) * 4).min(rest.len()));
        let kind = match first % 8 {
            0 => frame::Kind::Head,
            1 => frame::Kind::End,
            _ => frame::Kind::Unit,
        };
        units += u64::from(kind == frame::Kind::Unit);
        file.extend(frame::frame(kind, &[body]));
        bytes = rest;
    }
    digest.update(&file);
    file.extend(frame::end_frame(units, digest));
    try_bytes(&file)
}

/// This computer's name, where it can be told.
fn host() -> String {
    let kernel = std::fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let said = kernel.or_else(|| std::env::var("HOSTNAME").ok()).or_else(|| std::env::var("COMPUTERNAME").ok());
    said.map_or("this machine".to_owned(), |name| name.trim().to_owned())
}
