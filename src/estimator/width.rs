//! How wide registers are is found at run time: inner loops are compiled for each width.

pub(super) use pulp::{Arch, NullaryFnOnce};
