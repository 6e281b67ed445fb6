//! N strata of equal area, for any N, and points moved into them.

use super::Squares;

/// N strata dealt to R rows as evenly as they go: row r holds ⌊(r+1)N/R⌋ − ⌊rN/R⌋ of them and is as high as its share of
/// the strata.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows {
    pub n: u64,
    pub rows: u64,
}

impl Rows {
    /// The first stratum of a row; N for row R.
    #[inline(always)]
    pub fn start_of(self, row: u64) -> u64 {
        if self.is_small() {
            row * self.n / self.rows
        } else {
            (row as u128 * self.n as u128 / self.rows as u128) as u64
        }
    }

    /// The row of a stratum: the last r with rN/R < stratum + 1.
    #[inline(always)]
    pub fn row_of(self, stratum: u64) -> u64 {
        if self.is_small() {
            ((stratum + 1) * self.rows).div_ceil(self.n) - 1
        } else {
            (((stratum + 1) as u128 * self.rows as u128).div_ceil(self.n as u128) - 1) as u64
        }
    }

    /// Whether products of N and R fit 64 bits.
    #[inline(always)]
    fn is_small(self) -> bool {
        self.n < 1 << 32 && self.rows < 1 << 32
    }
}

/// One stratum: (column + u) · width, bottom + v · height.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stratum {
    pub column: f64,
    pub width: f64,
    pub bottom: f64,
    pub height: f64,
}

/// The strata in order, R = ⌊√N⌉ rows of them. All have area 1/N, and for a square N they are the regular grid.
#[derive(Clone, Debug)]
pub(super) struct Strata {
    rows: Rows,
    /// Row and first stratum of the row at hand.
    row: u64,
    row_start: u64,
    row_end: u64,
    /// Next stratum.
    next: u64,
}

impl Strata {
    pub fn new(n: u64) -> Strata {
        let rows = Rows { n, rows: ((n as f64).sqrt().round() as u64).max(1) };
        Strata { rows, row: 0, row_start: 0, row_end: rows.start_of(1), next: 0 }
    }

    /// The stratum at hand, after moving to the next row where one is finished.
    #[inline(always)]
    fn current(&mut self) -> Stratum {
        if self.next == self.row_end {
            self.row += 1;
            self.row_start = self.row_end;
            self.row_end = self.rows.start_of(self.row + 1);
        }
        let (cells, n) = ((self.row_end - self.row_start) as f64, self.rows.n as f64);
        Stratum {
            column: (self.next - self.row_start) as f64,
            width: 1.0 / cells,
            bottom: self.row_start as f64 / n,
            height: cells / n,
        }
    }

    /// The next stratum.
    #[inline(always)]
    pub fn take(&mut self) -> Stratum {
        let stratum = self.current();
        self.next += 1;
        stratum
    }

    /// Moves uniform points into their strata, in order.
    #[inline(always)]
    pub fn jitter(&mut self, squares: &mut Squares, len: usize) {
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

    #[test]
    fn rows_deal_out_every_stratum_once() {
        for n in [1, 2, 3, 5, 7, 12, 37, 200, 1000, (1 << 40) + 7, 1 << 52] {
            for rows in [1, 2, 3, (n as f64).sqrt().round() as u64] {
                let rows = Rows { n, rows: rows.clamp(1, n) };
                assert_eq!((rows.start_of(0), rows.start_of(rows.rows)), (0, n));
                for row in (0..rows.rows).step_by((rows.rows as usize / 1000).max(1)) {
                    let (start, end) = (rows.start_of(row), rows.start_of(row + 1));
                    assert!(start < end, "no row is empty");
                    assert_eq!((rows.row_of(start), rows.row_of(end - 1)), (row, row), "{rows:?}");
                    assert!((end - start).abs_diff(n / rows.rows) <= 1, "rows are alike to one stratum");
                }
            }
        }
    }

    #[test]
    fn strata_follow_one_another_and_have_area_one_over_n() {
        for n in [1, 2, 3, 5, 7, 12, 37, 200, 1000] {
            let mut strata = Strata::new(n);
            let mut covered = 0.0;
            for _ in 0..n {
                let s = strata.take();
                approx::assert_abs_diff_eq!(s.width * s.height, 1.0 / n as f64, epsilon = 1e-15);
                approx::assert_abs_diff_eq!(s.bottom + s.column * s.width * s.height, covered, epsilon = 1e-12);
                covered += s.width * s.height;
            }
            approx::assert_abs_diff_eq!(covered, 1.0, epsilon = 1e-12);
        }
    }
}
