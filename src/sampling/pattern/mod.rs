//! Points of the unit square, a block at a time.
//!
//! Every point set draws its jitter from the lanes of its stream, u before v; what it needs besides (scrambles,
//! permutations) is keyed by words that the first lane gives before. Nothing is stored a point: memory does not grow
//! with their number.

mod latin;
mod multi_jittered;
mod permutation;
mod sobol;
mod strata;

use latin::LatinHypercube;
use multi_jittered::MultiJittered;
use sobol::Sobol;
use strata::{Strata, Stratum};

use super::{LANES, Lanes, PointSet, Squares, Strategy, StreamKey, groups};
use crate::number::{Machine, Registers, Work};

/// Points that are permuted at a time: enough to share a round's words, few enough that small estimates clear no memory
/// for nothing.
const ABREAST: usize = 32;

/// The points of one estimate, handed out block by block, so that memory does not grow with their number.
#[derive(Clone, Debug)]
pub struct Pattern {
    set: Set,
    lanes: Lanes,
}

/// What independent uniform points are made into.
#[derive(Clone, Debug)]
enum Set {
    Independent,
    Stratified(Strata),
    /// The strata, and the place within each.
    UniformJitter(Strata, [f64; 2]),
    LatinHypercube(LatinHypercube),
    MultiJittered(MultiJittered),
    Sobol(Sobol),
}

impl Pattern {
    /// - `n`: points of the estimate, ≥ 1
    /// - `lanes`: min(n, 8) of them at least
    #[inline(always)]
    pub fn new(strategy: Strategy, n: u64, mut lanes: Lanes) -> Pattern {
        let set = match strategy.point_set() {
            PointSet::Independent => Set::Independent,
            PointSet::Stratified => Set::Stratified(Strata::new(n)),
            PointSet::UniformJitter => {
                let place = [lanes.next_units()[0], lanes.next_units()[0]];
                Set::UniformJitter(Strata::new(n), place)
            }
            PointSet::LatinHypercube => Set::LatinHypercube(LatinHypercube::new(n, &mut lanes)),
            PointSet::MultiJittered => Set::MultiJittered(MultiJittered::new(n, &mut lanes)),
            PointSet::Sobol => Set::Sobol(Sobol::new(n, &mut lanes)),
        };
        Pattern { set, lanes }
    }

    /// The next `len` points (rounded up to whole lanes; what lies beyond `len` is padding of no meaning).
    #[inline(always)]
    pub fn fill(&mut self, squares: &mut Squares, len: usize) {
        for group in 0..groups(len) {
            squares.u[group] = self.lanes.next_units();
            squares.v[group] = self.lanes.next_units();
        }
        match &mut self.set {
            Set::Independent => {}
            Set::Stratified(strata) => strata.jitter(squares, len),
            Set::UniformJitter(strata, [u, v]) => {
                squares.u[..groups(len)].fill([*u; LANES]);
                squares.v[..groups(len)].fill([*v; LANES]);
                strata.jitter(squares, len);
            }
            Set::LatinHypercube(latin) => latin.jitter(squares, len),
            Set::MultiJittered(multi) => multi.jitter(squares, len),
            Set::Sobol(sobol) => sobol.jitter(squares, len),
        }
    }

    /// As [`Pattern::fill`], compiled for a machine.
    pub(crate) fn fill_on(&mut self, machine: Machine, squares: &mut Squares, len: usize) {
        machine.run(Fill { pattern: self, squares, len });
    }
}

struct Fill<'a> {
    pattern: &'a mut Pattern,
    squares: &'a mut Squares,
    len: usize,
}

impl Work for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, _: R) {
        self.pattern.fill(self.squares, self.len);
    }
}

/// See [`fill_side_by_side`].
struct SideBySide<'a> {
    strategy: Strategy,
    n: usize,
    keys: &'a [StreamKey],
    below: [u64; 2],
    squares: &'a mut Squares,
}

impl Work for SideBySide<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, _: R) {
        side_by_side(self.strategy, self.n, self.keys, self.below, self.squares);
    }
}

/// The points of several small estimates side by side: estimate k has places kN to kN + N − 1 of the block, and the very
/// points that a [`Pattern`] of its key would give it.
///
/// - `n`: points of each estimate: 1, 2, 4 or 8
/// - `keys`: one for each estimate, as many as fit; `below`: words that each takes in first
pub(crate) fn fill_side_by_side(
    machine: Machine,
    strategy: Strategy,
    n: usize,
    keys: &[StreamKey],
    below: [u64; 2],
    squares: &mut Squares,
) {
    machine.run(SideBySide { strategy, n, keys, below, squares });
}

#[inline(always)]
fn side_by_side(strategy: Strategy, n: usize, keys: &[StreamKey], below: [u64; 2], squares: &mut Squares) {
    match strategy.point_set() {
        PointSet::Independent | PointSet::Stratified => {}
        PointSet::UniformJitter | PointSet::LatinHypercube | PointSet::MultiJittered | PointSet::Sobol => {
            return fill_one_by_one(strategy, n, keys, below, squares);
        }
    }
    let a_group = LANES / n;
    for (group, keys) in keys.chunks(a_group).enumerate() {
        let mut lanes = Lanes::side_by_side(keys, below, n);
        squares.u[group] = lanes.next_units();
        squares.v[group] = lanes.next_units();
    }
    if strategy.point_set() == PointSet::Stratified {
        let mut strata = Strata::new(n as u64);
        let cells: [Stratum; LANES] = std::array::from_fn(|lane| {
            if lane % n == 0 {
                strata = Strata::new(n as u64);
            }
            strata.take()
        });
        for group in 0..groups(n * keys.len()) {
            for (lane, cell) in cells.iter().enumerate() {
                squares.u[group][lane] = (cell.column + squares.u[group][lane]) * cell.width;
                squares.v[group][lane] = cell.bottom + squares.v[group][lane] * cell.height;
            }
        }
    }
}

/// As [`fill_side_by_side`], for point sets that start with words of their own: one after another.
fn fill_one_by_one(strategy: Strategy, n: usize, keys: &[StreamKey], below: [u64; 2], squares: &mut Squares) {
    let mut own = Squares::default();
    let (all_u, all_v) = (squares.u.as_flattened_mut(), squares.v.as_flattened_mut());
    for (k, key) in keys.iter().enumerate() {
        let lanes = Lanes::new(key.with(below[0]).with(below[1]), n);
        Pattern::new(strategy, n as u64, lanes).fill(&mut own, n);
        all_u[k * n..][..n].copy_from_slice(&own.u.as_flattened()[..n]);
        all_v[k * n..][..n].copy_from_slice(&own.v.as_flattened()[..n]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BLOCK, Row};
    use super::*;

    fn points(strategy: Strategy, n: u64, seed: u64) -> Vec<[f64; 2]> {
        let mut pattern = Pattern::new(strategy, n, Lanes::new(StreamKey::root(seed), LANES));
        let mut squares = Squares::default();
        let mut all = Vec::new();
        while (all.len() as u64) < n {
            let len = BLOCK.min(n as usize - all.len());
            pattern.fill(&mut squares, len);
            all.extend((0..len).map(|i| [squares.u[i / LANES][i % LANES], squares.v[i / LANES][i % LANES]]));
        }
        all
    }

    #[test]
    fn square_numbers_give_the_regular_grid() {
        for (i, [u, v]) in points(Strategy::Stratified, 1024, 5).into_iter().enumerate() {
            assert_eq!(((u * 32.0) as usize, (v * 32.0) as usize), (i % 32, i / 32));
        }
    }

    #[test]
    fn side_by_side_each_estimate_keeps_its_own_points() {
        for strategy in Strategy::ALL {
            for n in [1_usize, 2, 4, 8] {
                let keys: Vec<StreamKey> = (0..(BLOCK / n - 1) as u64).map(|k| StreamKey::root(6).with(k)).collect();
                let mut together = Squares::default();
                side_by_side(strategy, n, &keys, [7, 1], &mut together);
                for (k, key) in keys.iter().enumerate() {
                    let mut alone = Squares::default();
                    let lanes = Lanes::new(key.with(7).with(1), n);
                    Pattern::new(strategy, n as u64, lanes).fill(&mut alone, n);
                    for i in 0..n {
                        let at = |row: &Row, i: usize| row[i / LANES][i % LANES];
                        assert_eq!(at(&together.u, k * n + i), at(&alone.u, i), "{strategy} N = {n}");
                        assert_eq!(at(&together.v, k * n + i), at(&alone.v, i), "{strategy} N = {n}");
                    }
                }
            }
        }
    }

    /// Each of the points in a box of its own, all boxes taken.
    fn one_in_each(boxes: impl Iterator<Item = u64>, n: u64, what: &str) {
        let mut boxes: Vec<u64> = boxes.collect();
        boxes.sort_unstable();
        assert!(boxes.into_iter().eq(0..n), "{what}, N = {n}");
    }

    /// ⌊x · count⌋.
    fn part(x: f64, count: u64) -> u64 {
        (x * count as f64) as u64
    }

    /// Whole lanes, parts of lanes, blocks and more, primes and squares among them.
    const COUNTS: [u64; 12] = [1, 2, 3, 4, 7, 12, 16, 37, 128, 200, 1000, 1024];

    #[test]
    fn the_shifted_grid_has_one_place_in_all_strata() {
        for n in COUNTS {
            let (shifted, strata) = (points(Strategy::UniformJitter, n, 3), &mut Strata::new(n));
            let places: Vec<[f64; 2]> = shifted
                .into_iter()
                .map(|[u, v]| {
                    let Stratum { column, width, bottom, height } = strata.take();
                    [u / width - column, (v - bottom) / height]
                })
                .collect();
            for place in &places {
                for axis in 0..2 {
                    assert!((0.0..1.0).contains(&place[axis]));
                    approx::assert_abs_diff_eq!(place[axis], places[0][axis], epsilon = 1e-11);
                }
            }
        }
    }

    #[test]
    fn rooks_have_a_row_and_a_column_each() {
        for strategy in [Strategy::LatinHypercube, Strategy::MultiJittered] {
            for n in COUNTS {
                let all = points(strategy, n, 4);
                one_in_each(all.iter().map(|p| part(p[1], n)), n, "rows");
                // Where strata come in rows of unequal count, so do columns.
                if strategy == Strategy::LatinHypercube || ![3, 7, 37, 200].contains(&n) {
                    one_in_each(all.iter().map(|p| part(p[0], n)), n, "columns");
                }
            }
        }
    }

    #[test]
    fn multi_jittered_points_have_a_stratum_each() {
        for (n, rows) in [(4, 2), (12, 3), (16, 4), (128, 8), (1000, 25), (1024, 32), (200, 10)] {
            let all = points(Strategy::MultiJittered, n, 5);
            one_in_each(all.iter().map(|p| part(p[1], rows) * (n / rows) + part(p[0], n / rows)), n, "strata");
        }
        // 37 = 6 + 6 + 6 + 6 + 6 + 7: five rows of six strata are 30 rooks, one of seven is 7.
        let all = points(Strategy::MultiJittered, 37, 5);
        let (long, short): (Vec<[f64; 2]>, Vec<[f64; 2]>) = all.iter().partition(|p| p[1] * 37.0 >= 30.0);
        one_in_each(short.iter().map(|p| part(p[0], 30)), 30, "columns of the short rows");
        one_in_each(long.iter().map(|p| part(p[0], 7)), 7, "columns of the long row");
        one_in_each(short.iter().map(|p| part(p[1], 37) / 6 * 6 + part(p[0], 6)), 30, "strata of the short rows");
    }

    #[test]
    fn sobol_points_have_every_elementary_box_to_themselves() {
        let n = 1 << 12;
        let all = points(Strategy::Sobol, n, 6);
        for m in 0..=12 {
            for (run, points) in all.chunks(1 << m).enumerate() {
                for a in 0..=m {
                    let boxes = points.iter().map(|p| part(p[0], 1 << a) << (m - a) | part(p[1], 1 << (m - a)));
                    one_in_each(boxes, 1 << m, &format!("run {run}, {a} digits of u"));
                }
            }
        }
    }

    #[test]
    fn stratifying_keeps_the_density() {
        // Mean of u, v, u², uv over many odd-sized sets: 1/2, 1/2, 1/3, 1/4.
        let (sets, n) = (4000, 7);
        let mut sums = [0.0; 4];
        for seed in 0..sets {
            for [u, v] in points(Strategy::Stratified, n, seed) {
                for (sum, x) in sums.iter_mut().zip([u, v, u * u, u * v]) {
                    *sum += x;
                }
            }
        }
        for (sum, expected) in sums.into_iter().zip([0.5, 0.5, 1.0 / 3.0, 0.25]) {
            // Unstratified standard error is 0.3/√28000 = 0.0018; the strata only lower it.
            approx::assert_abs_diff_eq!(sum / (sets * n) as f64, expected, epsilon = 0.01);
        }
    }
}
