//! Case files: what stands in the room and how it is to be studied.

mod study;

use crate::configuration::Configuration;

pub use study::{Replicates, SmallestBias, Study};

/// One case, valid by construction.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The file's path below the folder that was given, without `.toml`: `penumbra/eclipse`.
    pub name: String,
    /// What people read.
    pub title: String,
    pub configuration: Configuration,
    pub study: Study,
}
