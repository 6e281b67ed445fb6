//! On rayon's threads, as many as the command line asks for.

#[cfg(feature = "studies")]
use std::{sync::OnceLock, sync::atomic::AtomicUsize, sync::atomic::Ordering, thread};

use rayon::prelude::*;

/// What `of` makes of each item.
pub(crate) fn map<T: Sync, R: Send + Sync>(items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    items.par_iter().map(&of).collect()
}

/// What `of` makes of each item, several items at a time: each lane has threads of its own, its share of what there is. So
/// no thread takes up another item while it waits, and what an item measures of its own time is its own.
#[cfg(feature = "studies")]
pub(crate) fn side_by_side<T: Sync, R: Send + Sync>(items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let threads = rayon::current_num_threads();
    let n_lanes = threads.min(items.len());
    let lane = |_| rayon::ThreadPoolBuilder::new().num_threads(threads / n_lanes).build();
    // Where threads cannot be had, in a row on those that there are.
    let Some(lanes) = (n_lanes > 1).then(|| (0..n_lanes).map(lane).collect::<Result<Vec<_>, _>>().ok()).flatten()
    else {
        return items.iter().map(of).collect();
    };
    let places: Vec<OnceLock<R>> = items.iter().map(|_| OnceLock::new()).collect();
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some(index) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|index| *index < items.len()) {
            places[index].get_or_init(|| of(&items[index]));
        }
    };
    let panic = thread::scope(|scope| {
        let hands: Vec<_> = lanes.iter().map(|lane| scope.spawn(|| lane.install(work))).collect();
        hands.into_iter().filter_map(|hand| hand.join().err()).next_back()
    });
    if let Some(panic) = panic {
        std::panic::resume_unwind(panic);
    }
    places.into_iter().filter_map(OnceLock::into_inner).collect()
}
