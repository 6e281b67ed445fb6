//! Multi-jittered sampling: one point in each of N strata, and in each of N columns and N rows (Chiu, Shirley & Wang,
//! *Multi-Jittered Sampling*, Graphics Gems IV, 1994).
//!
//! With N = R · C strata in R rows, the strata of one row share its C lines of height 1/N among them by a permutation, and
//! those of one column its R lines of width 1/N; every row and column has a permutation of its own, and the order of the
//! points is a permutation too. (Kensler's *correlated* multi-jittering, Pixar 2013, has one permutation for all rows: the
//! rows of strata then move as a whole, √N errors instead of N, and a smooth integrand's variance falls as N^−3/2 only; here
//! as N⁻². Measured in the tests.)
//!
//! **Any N.** Where N has no factor between √(N/2) and √N, its strata are those of `stratified`: rows of C or C + 1 of
//! them. All of the above stays true of the strata and of the lines of height 1/N; the lines of a column are shared among
//! the rows of equal count: rows of C strata have C·R_C columns with one point each, the others (C+1)·R_{C+1} of theirs.

use super::permutation::{Family, Permutation};
use super::strata::Rows;
use super::{ABREAST, Lanes, Squares};

#[derive(Clone, Debug)]
pub(super) struct MultiJittered {
    layout: Rows,
    order: Permutation,
    across: Family,
    up: Family,
    next: u64,
}

impl MultiJittered {
    pub fn new(n: u64, lanes: &mut Lanes) -> MultiJittered {
        let layout = layout(n);
        let (few, longer_rows) = (n / layout.rows, n % layout.rows);
        let [short_columns, long_columns] = [(few, layout.rows - longer_rows), (few + 1, longer_rows)]
            .map(|(columns, rows)| std::iter::repeat_n(rows, columns as usize));
        let cells = (0..layout.rows).map(|row| layout.start_of(row + 1) - layout.start_of(row));
        MultiJittered {
            layout,
            order: Permutation::draw(n, lanes),
            across: Family::draw(n, short_columns.chain(long_columns), lanes),
            up: Family::draw(n, cells, lanes),
            next: 0,
        }
    }

    /// Moves uniform points into their strata and lines.
    #[inline(always)]
    pub fn jitter(&mut self, squares: &mut Squares, len: usize) {
        let (all_u, all_v) = (squares.u.as_flattened_mut(), squares.v.as_flattened_mut());
        for (u, v) in all_u[..len].chunks_mut(ABREAST).zip(all_v[..len].chunks_mut(ABREAST)) {
            self.jitter_some(u, v);
        }
    }

    /// The next points, [`ABREAST`] at most.
    #[inline(always)]
    fn jitter_some(&mut self, u: &mut [f64], v: &mut [f64]) {
        let len = u.len();
        let Rows { n, rows } = self.layout;
        let (few, longer_rows) = (n / rows, n % rows);
        let mut stratum = [0; ABREAST];
        for (k, stratum) in stratum[..len].iter_mut().enumerate() {
            *stratum = self.next + k as u64;
        }
        self.order.permute(&mut stratum[..len]);
        self.next += len as u64;

        // Place of each point's stratum in its row, and of the row among those of equal count.
        let (mut start, mut place, mut cells) = ([0; ABREAST], [0; ABREAST], [0; ABREAST]);
        let (mut rank, mut alike, mut before) = ([0; ABREAST], [0; ABREAST], [0; ABREAST]);
        for k in 0..len {
            let row = self.layout.row_of(stratum[k]);
            start[k] = self.layout.start_of(row);
            place[k] = stratum[k] - start[k];
            cells[k] = self.layout.start_of(row + 1) - start[k];
            let longer_before = start[k] - row * few;
            let is_longer = cells[k] > few;
            rank[k] = if is_longer { longer_before } else { row - longer_before };
            alike[k] = if is_longer { longer_rows } else { rows - longer_rows };
            before[k] = place[k] * alike[k] + if is_longer { few * (rows - longer_rows) } else { 0 };
        }
        self.across.permute_each(&mut rank[..len], &alike[..len], &before[..len]);
        for (k, u) in u.iter_mut().enumerate() {
            *u = ((place[k] * alike[k] + rank[k]) as f64 + *u) / (cells[k] * alike[k]) as f64;
        }
        self.up.permute_each(&mut place[..len], &cells[..len], &start[..len]);
        for (k, v) in v.iter_mut().enumerate() {
            *v = ((start[k] + place[k]) as f64 + *v) / n as f64;
        }
    }
}

/// As many rows as N's greatest divisor up to √N, where there is one no less than √(N/2); else ⌊√N⌉.
fn layout(n: u64) -> Rows {
    let root = n.isqrt();
    let divisor = (1..=root).rev().take_while(|rows| 2 * rows * rows >= n).find(|rows| n.is_multiple_of(*rows));
    Rows { n, rows: divisor.unwrap_or_else(|| ((n as f64).sqrt().round() as u64).max(1)) }
}

#[cfg(test)]
mod tests {
    use super::super::{LANES, Pattern, Strategy, StreamKey};
    use super::*;
    use crate::sampling::BLOCK;

    #[test]
    fn rows_divide_where_they_can() {
        let rows = |n: u64| layout(n).rows;
        assert_eq!([1, 2, 4, 8, 16, 32, 128, 512, 1024, 12, 1000].map(rows), [1, 1, 2, 2, 4, 4, 8, 16, 32, 3, 25]);
        // 3 and 37 have no such divisor, 10 = 2 · 5 none that is near enough to a square.
        assert_eq!([3, 10, 37].map(rows), [2, 3, 6]);
    }

    /// Mean of a smooth function over the points of Kensler's listing, with ideal permutations.
    fn correlated_mean(side: usize, lanes: &mut Lanes, f: impl Fn(f64, f64) -> f64) -> f64 {
        let mut shuffled = || {
            let mut places: Vec<usize> = (0..side).collect();
            for k in (1..side).rev() {
                places.swap(k, (lanes.next_units()[0] * (k + 1) as f64) as usize);
            }
            places
        };
        let (across, up) = (shuffled(), shuffled());
        let (m, n) = (side as f64, (side * side) as f64);
        let mut sum = 0.0;
        for (i, up) in up.iter().enumerate() {
            for (j, across) in across.iter().enumerate() {
                let [a, b] = [lanes.next_units()[0], lanes.next_units()[0]];
                let u = (i as f64 + (*across as f64 + a) / m) / m;
                let v = (j as f64 + (*up as f64 + b) / m) / m;
                sum += f(u, v);
            }
        }
        sum / n
    }

    fn plain_mean(side: usize, lanes: &mut Lanes, f: impl Fn(f64, f64) -> f64) -> f64 {
        let n = (side * side) as u64;
        let key = StreamKey::root(lanes.next_words()[0]);
        let mut pattern = Pattern::new(Strategy::MultiJittered, n, Lanes::new(key, LANES));
        let mut squares = Squares::default();
        let mut sum = 0.0;
        for start in (0..n).step_by(BLOCK) {
            let len = BLOCK.min((n - start) as usize);
            pattern.fill(&mut squares, len);
            let pairs = squares.u.as_flattened().iter().zip(squares.v.as_flattened());
            sum += pairs.take(len).map(|(u, v)| f(*u, *v)).sum::<f64>();
        }
        sum / n as f64
    }

    /// (u − ½)(v − ½) is all that neither rows nor columns take away.
    #[test]
    fn rows_of_their_own_keep_the_rate_that_rows_alike_lose() {
        let mut lanes = Lanes::new(StreamKey::root(17), 1);
        let mut slope = |mean: &dyn Fn(usize, &mut Lanes) -> f64| {
            let [few, many] =
                [8, 32].map(|side| (0..2000).map(|_| mean(side, &mut lanes).powi(2)).sum::<f64>() / 2000.0);
            (many / few).ln() / 16_f64.ln()
        };
        let f = |u: f64, v: f64| (u - 0.5) * (v - 0.5);
        let plain = slope(&|side, lanes| plain_mean(side, lanes, f));
        let alike = slope(&|side, lanes| correlated_mean(side, lanes, f));
        println!("{plain:.3} {alike:.3}");
        // Standard error of each: √2 √(2/2000) / ln 16 = 0.016.
        assert!((plain + 2.0).abs() < 0.1 && (alike + 1.5).abs() < 0.1, "{plain} {alike}");
    }
}
