//! Work spread over threads, its results in the order of the work: one thread or many give the same.

#[cfg_attr(not(feature = "fast"), path = "scoped.rs")]
mod pool;

pub(crate) use pool::map;

#[cfg(test)]
#[path = "scoped.rs"]
mod scoped;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_work() {
        let work: Vec<u64> = (0..1000).collect();
        let squares: Vec<u64> = work.iter().map(|k| k * k).collect();
        assert_eq!(map(&work, |k| k * k), squares);
        assert_eq!(scoped::map(&work, |k| k * k), squares);
        for few in [&work[..0], &work[..1], &work[..2]] {
            assert_eq!(scoped::map(few, |k| k + 1), few.iter().map(|k| k + 1).collect::<Vec<_>>());
        }
    }

    #[test]
    fn work_within_work_comes_to_an_end() {
        let sums = scoped::map(&[10_u64, 20, 30], |n| {
            let parts: Vec<u64> = (0..*n).collect();
            scoped::map(&parts, |k| k * n).into_iter().sum::<u64>()
        });
        assert_eq!(sums, [450, 3800, 13_050]);
    }

    #[test]
    #[should_panic(expected = "the third")]
    fn who_panics_is_heard() {
        scoped::map(&[1, 2, 3, 4], |k| assert!(*k != 3, "the third"));
    }
}
