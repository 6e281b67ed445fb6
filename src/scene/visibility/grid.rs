//! A grid of cells, one bit for each, row by row.

/// Cells of the grid along each side.
pub(super) const SIDE: usize = 64;
pub(super) type Grid = [u64; SIDE];
/// How far from an edge a cell is taken to be crossed, in cells.
pub(super) const MARGIN: f64 = 1.0 / 64.0;

/// Marks the cells that a segment comes near.
pub(super) fn draw(crossed: &mut Grid, a: [f64; 2], b: [f64; 2]) {
    let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
    let (first, last) = ((low[1] - MARGIN).floor().max(0.0), (high[1] + MARGIN).floor().min((SIDE - 1) as f64));
    let (left, right) = (low[0].min(high[0]), low[0].max(high[0]));
    let rise = high[1] - low[1];
    let mut row = first;
    while row <= last {
        // What runs level is near all of its length.
        let (from, to) = if rise < MARGIN {
            (left, right)
        } else {
            let at = |y: f64| {
                (low[0] + (y.clamp(low[1], high[1]) - low[1]) * ((high[0] - low[0]) / rise)).clamp(left, right)
            };
            let (enters, leaves) = (at(row - MARGIN), at(row + 1.0 + MARGIN));
            (enters.min(leaves), enters.max(leaves))
        };
        let (from, to) = ((from - MARGIN).floor().max(0.0), (to + MARGIN).floor().min((SIDE - 1) as f64));
        if from <= to {
            crossed[row as usize] |= (u64::MAX >> (SIDE - 1 - (to - from) as usize)) << from as usize;
        }
        row += 1.0;
    }
}

/// The free cells that hang together, side by side, with one of them.
pub(super) fn part(free: &Grid, row: usize, column: u32) -> Grid {
    let mut part = [0; SIDE];
    part[row] = spread(1 << column, free[row]);
    loop {
        let before = part;
        for row in 1..SIDE {
            part[row] |= spread(part[row - 1] & free[row], free[row]);
        }
        for row in (0..SIDE - 1).rev() {
            part[row] |= spread(part[row + 1] & free[row], free[row]);
        }
        if part == before {
            return part;
        }
    }
}

/// All bits of `free` that hang together with one of these, which are among them.
fn spread(seeds: u64, free: u64) -> u64 {
    let (mut up, mut down) = (seeds, seeds);
    let (mut free_up, mut free_down) = (free, free);
    let mut step = 1;
    while step < 64 {
        up |= free_up & (up << step);
        free_up &= free_up << step;
        down |= free_down & (down >> step);
        free_down &= free_down >> step;
        step *= 2;
    }
    up | down
}
