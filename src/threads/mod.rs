//! Work spread over threads, its results in the order of the work: one thread or many give the same.

#[cfg_attr(not(feature = "fast"), path = "scoped.rs")]
mod pool;

pub(crate) use pool::map;
#[cfg(feature = "studies")]
pub(crate) use pool::side_by_side;

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

    #[cfg(feature = "studies")]
    #[test]
    fn lanes_share_the_threads_and_keep_the_order() {
        let work: Vec<u64> = (1..40).collect();
        let of = |n: &u64| {
            let parts: Vec<u64> = (0..*n).collect();
            map(&parts, |k| k * n).into_iter().sum::<u64>()
        };
        let due: Vec<u64> = work.iter().map(of).collect();
        assert_eq!(side_by_side(&work, of), due);
        assert_eq!(scoped::side_by_side(&work, of), due);
        assert_eq!(side_by_side(&work[..1], of), due[..1]);
        assert!(side_by_side(&work[..0], of).is_empty());
    }

    #[cfg(all(feature = "studies", feature = "fast"))]
    #[test]
    fn lanes_are_at_most_the_threads_there_are() {
        for threads in 1..6 {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let shares = pool.install(|| side_by_side(&[(); 4], |()| rayon::current_num_threads()));
            assert_eq!(shares, [(threads / 4).max(1); 4], "{threads}");
        }
    }

    #[cfg(feature = "studies")]
    #[test]
    #[should_panic(expected = "the third")]
    fn who_panics_in_a_lane_is_heard() {
        side_by_side(&[1, 2, 3, 4], |k| assert!(*k != 3, "the third"));
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
