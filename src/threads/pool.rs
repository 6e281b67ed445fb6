//! On rayon's threads, as many as the command line asks for.

use rayon::prelude::*;

/// What `of` makes of each item.
pub(crate) fn map<T: Sync, R: Send + Sync>(items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    items.par_iter().map(&of).collect()
}
