//! On threads of the standard library, one for each core, which end with the work.

use std::num::NonZero;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// What `of` makes of each item.
pub(crate) fn map<T: Sync, R: Send + Sync>(items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let places: Vec<OnceLock<R>> = items.iter().map(|_| OnceLock::new()).collect();
    each(items.len(), &|index| {
        places[index].get_or_init(|| of(&items[index]));
    });
    places.into_iter().filter_map(OnceLock::into_inner).collect()
}

/// Calls for each index below n once: each thread takes the next that nobody has. What panics is heard here.
fn each(n: usize, work: &(dyn Fn(usize) + Sync)) {
    let crew = thread::available_parallelism().map_or(1, NonZero::get).min(n);
    if crew < 2 {
        return (0..n).for_each(work);
    }
    let next = AtomicUsize::new(0);
    let hand = || {
        loop {
            match next.fetch_add(1, Ordering::Relaxed) {
                index if index < n => work(index),
                _ => break,
            }
        }
    };
    let panic = thread::scope(|scope| {
        let hands: Vec<_> = (0..crew).map(|_| scope.spawn(hand)).collect();
        hands.into_iter().filter_map(|hand| hand.join().err()).next_back()
    });
    if let Some(panic) = panic {
        std::panic::resume_unwind(panic);
    }
}

/// What `of` makes of each item, one after the other: threads go to what is within.
#[cfg(feature = "studies")]
pub(crate) fn side_by_side<T: Sync, R: Send + Sync>(items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    items.iter().map(of).collect()
}
