//! Points of the unit square, a block at a time.

use super::{BLOCK, LANES, Lanes, PointSet, Row, Strategy, StreamKey, groups};

/// One block of points of the unit square.
#[derive(Clone, Debug)]
pub struct Squares {
    pub u: Row,
    pub v: Row,
}

impl Default for Squares {
    fn default() -> Squares {
        Squares { u: [[0.0; LANES]; BLOCK / LANES], v: [[0.0; LANES]; BLOCK / LANES] }
    }
}

/// The points of one estimate, handed out block by block, so that memory does not grow with their number.
#[derive(Clone, Debug)]
pub struct Pattern {
    strata: Option<Strata>,
    lanes: Lanes,
}

impl Pattern {
    /// - `n`: points of the estimate, ≥ 1
    pub fn new(strategy: Strategy, n: u64, lanes: Lanes) -> Pattern {
        let strata = match strategy.point_set() {
            PointSet::Independent => None,
            PointSet::Stratified => Some(Strata::new(n)),
        };
        Pattern { strata, lanes }
    }

    /// The next `len` points (rounded up to whole lanes; what lies beyond `len` is padding of no meaning).
    #[inline(always)]
    pub fn fill(&mut self, squares: &mut Squares, len: usize) {
        for group in 0..groups(len) {
            squares.u[group] = self.lanes.next_units();
            squares.v[group] = self.lanes.next_units();
        }
        if let Some(strata) = &mut self.strata {
            strata.jitter(squares, len);
        }
    }
}

/// The points of several small estimates side by side: estimate k has places kN to kN + N − 1 of the block, and the very
/// points that a [`Pattern`] of its key would give it.
///
/// - `n`: points of each estimate: 1, 2, 4 or 8
/// - `keys`: one for each estimate, as many as fit
#[inline(always)]
pub fn fill_side_by_side(strategy: Strategy, n: usize, keys: &[StreamKey], squares: &mut Squares) {
    let a_group = LANES / n;
    for (group, keys) in keys.chunks(a_group).enumerate() {
        let mut lanes = Lanes::side_by_side(keys, n);
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

/// One stratum: (column + u) · width, bottom + v · height.
#[derive(Clone, Copy, Debug)]
struct Stratum {
    column: f64,
    width: f64,
    bottom: f64,
    height: f64,
}

/// N strata of equal area, for any N: R = ⌊√N⌉ rows, the N strata dealt to the rows as evenly as they go (row r holds
/// ⌊(r+1)N/R⌋ − ⌊rN/R⌋ of them), each row as high as its share of the strata. All have area 1/N, and for a square N
/// they are the regular grid.
#[derive(Clone, Debug)]
struct Strata {
    n: u64,
    rows: u64,
    /// Row and first stratum of the row at hand.
    row: u64,
    row_start: u64,
    row_end: u64,
    /// Next stratum.
    next: u64,
}

impl Strata {
    fn new(n: u64) -> Strata {
        let rows = ((n as f64).sqrt().round() as u64).max(1);
        let mut strata = Strata { n, rows, row: 0, row_start: 0, row_end: 0, next: 0 };
        strata.row_end = strata.start_of(1);
        strata
    }

    fn start_of(&self, row: u64) -> u64 {
        (row as u128 * self.n as u128 / self.rows as u128) as u64
    }

    /// The stratum at hand, after moving to the next row where one is finished.
    #[inline(always)]
    fn current(&mut self) -> Stratum {
        if self.next == self.row_end {
            self.row += 1;
            self.row_start = self.row_end;
            self.row_end = self.start_of(self.row + 1);
        }
        let cells = (self.row_end - self.row_start) as f64;
        Stratum {
            column: (self.next - self.row_start) as f64,
            width: 1.0 / cells,
            bottom: self.row_start as f64 / self.n as f64,
            height: cells / self.n as f64,
        }
    }

    /// The next stratum.
    #[inline(always)]
    fn take(&mut self) -> Stratum {
        let stratum = self.current();
        self.next += 1;
        stratum
    }

    /// Moves uniform points into their strata, in order.
    #[inline(always)]
    fn jitter(&mut self, squares: &mut Squares, len: usize) {
        let (all_u, all_v) = (squares.u.as_flattened_mut(), squares.v.as_flattened_mut());
        let mut at = 0;
        while at < len {
            let Stratum { column, width, bottom, height } = self.current();
            let run = ((self.row_end - self.next) as usize).min(len - at);
            for (k, u) in all_u[at..at + run].iter_mut().enumerate() {
                *u = (column + k as f64 + *u) * width;
            }
            for v in &mut all_v[at..at + run] {
                *v = bottom + *v * height;
            }
            at += run;
            self.next += run as u64;
        }
    }
}

#[cfg(test)]
mod tests {
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
                fill_side_by_side(strategy, n, &keys, &mut together);
                for (k, key) in keys.iter().enumerate() {
                    let mut alone = Squares::default();
                    Pattern::new(strategy, n as u64, Lanes::new(*key, n)).fill(&mut alone, n);
                    for i in 0..n {
                        let at = |row: &Row, i: usize| row[i / LANES][i % LANES];
                        assert_eq!(at(&together.u, k * n + i), at(&alone.u, i), "{strategy} N = {n}");
                        assert_eq!(at(&together.v, k * n + i), at(&alone.v, i), "{strategy} N = {n}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_stratum_has_one_point_and_area_one_over_n() {
        for n in [1, 2, 3, 5, 7, 12, 37, 200, 1000] {
            let mut strata = Strata::new(n);
            let (mut seen, mut covered) = (0, 0.0);
            for _ in 0..strata.rows {
                let cells = strata.row_end - strata.row_start;
                assert!(cells > 0, "no row is empty");
                seen += cells;
                covered += cells as f64 / n as f64;
                strata.row += 1;
                strata.row_start = strata.row_end;
                strata.row_end = strata.start_of(strata.row + 1);
            }
            assert_eq!(seen, n);
            approx::assert_abs_diff_eq!(covered, 1.0, epsilon = 1e-12);
            assert!(points(Strategy::Stratified, n, 9).iter().flatten().all(|c| (0.0..=1.0).contains(c)));
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
