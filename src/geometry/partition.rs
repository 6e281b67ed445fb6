//! A polygon cut into cells of equal area that belong to the squares of the unit square's regular grid.
//!
//! Halved again and again by straight cuts, across the sweep direction for each halving of u and along it for each halving
//! of v, in turn: level k has 2ᵏ × 2ᵏ cells, each a half of a half of one cell of level k − 1. Convex cells stay compact, so
//! that a function that is smooth on the polygon varies over a cell as little as the cell is wide, whatever corners the
//! polygon has: what one stratum of a sampler needs.
//!
//! Where a cut parts a cell into pieces (the arms of a U), later cuts part the row of pieces, in their order along the axis,
//! and at most one piece: a cut through all of them would leave both arms in every cell up to their ends. With it the cells
//! of any level have, all together, at most one piece too many for each re-entrant corner.

use std::array;

use glam::DVec3;

use super::Polygon;

/// A simple closed curve, counter-clockwise: (sweep, along) of each vertex, metres.
pub type Outline = Vec<[f64; 2]>;

/// A polygon's cells of one level.
#[derive(Clone, Debug)]
pub struct Partition {
    axes: Axes,
    side: usize,
    /// `[u][v]`, row-major.
    cells: Vec<Vec<Outline>>,
}

/// Coordinates in a polygon's plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// A vertex of the polygon, metres.
    pub origin: DVec3,
    /// Unit vector, at right angles to the longest edge: u runs this way.
    pub sweep: DVec3,
    /// Unit vector along the longest edge: v runs this way. sweep × along is the polygon's normal.
    pub along: DVec3,
}

impl Axes {
    /// The sweep runs at right angles to the longest edge, so that one end of it is a full chord and not a needle's point.
    pub fn of(polygon: &Polygon) -> Axes {
        let vertices = polygon.vertices();
        let n = vertices.len();
        let longest = (0..n)
            .map(|i| vertices[(i + 1) % n] - vertices[i])
            .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
            .expect("a polygon has edges");
        let along = longest.normalize();
        Axes { origin: vertices[0], sweep: along.cross(polygon.normal()), along }
    }

    /// A polygon's vertices in these coordinates.
    pub fn flatten(&self, polygon: &Polygon) -> Outline {
        let offsets = polygon.vertices().iter().map(|p| *p - self.origin);
        offsets.map(|p| [p.dot(self.sweep), p.dot(self.along)]).collect()
    }

    /// The point with these coordinates, metres.
    pub fn place(&self, [sweep, along]: [f64; 2]) -> DVec3 {
        self.origin + self.sweep * sweep + self.along * along
    }
}

impl Partition {
    /// The cells of level `levels`: 4 to that power.
    ///
    /// - error: areas of cells differ by less than 1e-12 of the polygon's over the number of cells (tested)
    pub fn new(polygon: &Polygon, levels: u32) -> Partition {
        let axes = Axes::of(polygon);
        let mut side = 1;
        let mut cells = vec![vec![axes.flatten(polygon)]];
        for _ in 0..levels {
            let mut finer = vec![Vec::new(); 4 * cells.len()];
            for (index, cell) in cells.into_iter().enumerate() {
                let (i, j) = (index / side, index % side);
                for (k, quarter) in quarters(cell).into_iter().enumerate() {
                    finer[(2 * i + k / 2) * 2 * side + 2 * j + k % 2] = quarter;
                }
            }
            side *= 2;
            cells = finer;
        }
        Partition { axes, side, cells }
    }

    /// The coordinates that outlines are in.
    pub fn axes(&self) -> &Axes {
        &self.axes
    }
    /// Cells in each direction.
    pub fn side(&self) -> usize {
        self.side
    }
    /// The cell of u in [i, i + 1] / side and v in [j, j + 1] / side: disjoint outlines, most often one.
    ///
    /// - `i`, `j` below [`Partition::side`]
    pub fn cell(&self, i: usize, j: usize) -> &[Outline] {
        &self.cells[i * self.side + j]
    }
}

/// The cells of the next level that make up a cell, `[u][v]`.
pub fn quarters(cell: Vec<Outline>) -> [Vec<Outline>; 4] {
    let [less, more] = halve(cell, 0);
    let ([a, b], [c, d]) = (halve(less, 1), halve(more, 1));
    [a, b, c, d]
}

/// Two parts of equal area: what is less along the axis, what is more.
fn halve(mut pieces: Vec<Outline>, axis: usize) -> [Vec<Outline>; 2] {
    let middle = |outline: &Outline| {
        let (low, high) = extent(outline, axis);
        low + high
    };
    pieces.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    let whole: f64 = pieces.iter().map(area).sum();
    let mut wanted = 0.5 * whole;
    let [mut less, mut more] = [Vec::new(), Vec::new()];
    for piece in pieces {
        let own = area(&piece);
        // Rounding is no piece.
        let crumb = 1e-14 * whole;
        if wanted <= crumb {
            more.push(piece);
        } else if own <= wanted + crumb {
            less.push(piece);
        } else {
            let [below, above] = cut(&piece, axis, place_of_cut(&piece, axis, wanted));
            less.extend(below.into_iter().filter(|part| area(part) > crumb));
            more.extend(above.into_iter().filter(|part| area(part) > crumb));
        }
        wanted -= own;
    }
    [less, more]
}

/// Square metres, by the shoelace about the first vertex.
fn area(outline: &Outline) -> f64 {
    let [x, y] = outline[0];
    let twice = |pair: &[[f64; 2]]| (pair[0][0] - x) * (pair[1][1] - y) - (pair[1][0] - x) * (pair[0][1] - y);
    0.5 * outline.windows(2).map(twice).sum::<f64>()
}

fn extent(outline: &Outline, axis: usize) -> (f64, f64) {
    let fold = |(low, high): (f64, f64), p: &[f64; 2]| (low.min(p[axis]), high.max(p[axis]));
    outline.iter().fold((f64::INFINITY, f64::NEG_INFINITY), fold)
}

fn edges(outline: &Outline) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    (0..outline.len()).map(|i| [outline[i], outline[(i + 1) % outline.len()]])
}

/// Where along an edge it has this coordinate on the axis: the other coordinate.
fn crossing([a, b]: [[f64; 2]; 2], axis: usize, at: f64) -> f64 {
    let share = ((at - a[axis]) / (b[axis] - a[axis])).clamp(0.0, 1.0);
    a[1 - axis] + (b[1 - axis] - a[1 - axis]) * share
}

/// The coordinate below which an outline has this much area: between neighbouring vertices the chord is linear, the
/// area a quadratic.
fn place_of_cut(outline: &Outline, axis: usize, wanted: f64) -> f64 {
    let mut stops: Vec<f64> = outline.iter().map(|p| p[axis]).collect();
    stops.sort_by(f64::total_cmp);
    let mut before = 0.0;
    for stop in stops.windows(2) {
        let width = stop[1] - stop[0];
        let middle = stop[0] + 0.5 * width;
        // Counter-clockwise, edges that go down bound a chord from above where the axis is the first, from below where it
        // is the second.
        let chord: [f64; 2] = array::from_fn(|end| {
            let spans = edges(outline).filter(|[a, b]| (a[axis] < middle) != (b[axis] < middle));
            let signed = spans.map(|edge| {
                let goes_down = edge[1][axis] < edge[0][axis];
                let at = crossing(edge, axis, stop[end]);
                if goes_down == (axis == 0) { at } else { -at }
            });
            signed.sum::<f64>().max(0.0)
        });
        let own = 0.5 * (chord[0] + chord[1]) * width;
        let left = wanted - before;
        if own > 0.0 && left <= own {
            let root = (chord[0] * chord[0] + 2.0 * (chord[1] - chord[0]) * left / width).max(0.0).sqrt();
            return (stop[0] + 2.0 * left / (chord[0] + root)).min(stop[1]);
        }
        before += own;
    }
    stops[stops.len() - 1]
}

/// The parts of an outline with coordinates below `at`, and from there on.
fn cut(outline: &Outline, axis: usize, at: f64) -> [Vec<Outline>; 2] {
    let n = outline.len();
    let above = |i: usize| outline[i % n][axis] >= at;
    // Edges that cross, in order, by their first vertex. Each begins a chain of vertices on the other side.
    let crossings: Vec<usize> = (0..n).filter(|i| above(*i) != above(i + 1)).collect();
    if crossings.is_empty() {
        let mut parts = [Vec::new(), Vec::new()];
        parts[usize::from(above(0))].push(outline.clone());
        return parts;
    }
    let places: Vec<f64> =
        crossings.iter().map(|i| crossing([outline[*i], outline[(i + 1) % n]], axis, at)).collect();
    // Along the cut, ways up and ways down alternate: the j-th of one is joined to the j-th of the other. Said like this it
    // stays a matching where rounding has two crossings change places.
    let mut ways: [Vec<usize>; 2] = array::from_fn(|up| {
        let of_this_kind = (0..crossings.len()).filter(|k| above(crossings[*k] + 1) == (up == 1));
        of_this_kind.collect()
    });
    ways.iter_mut().for_each(|ways| ways.sort_by(|a, b| places[*a].total_cmp(&places[*b])));
    let mut partner = vec![0; crossings.len()];
    for (down, up) in ways[0].iter().zip(&ways[1]) {
        (partner[*down], partner[*up]) = (*up, *down);
    }
    let point = |k: usize| if axis == 0 { [at, places[k]] } else { [places[k], at] };
    array::from_fn(|side| {
        let mut parts = Vec::new();
        let mut used = vec![false; crossings.len()];
        for first in ways[side].iter().copied() {
            let mut part = Outline::new();
            let mut entry = first;
            while !used[entry] {
                used[entry] = true;
                let exit = (entry + 1) % crossings.len();
                part.push(point(entry));
                let last = if crossings[exit] > crossings[entry] { crossings[exit] } else { crossings[exit] + n };
                part.extend((crossings[entry] + 1..=last).map(|i| outline[i % n]));
                part.push(point(exit));
                entry = partner[exit];
            }
            part.dedup();
            if part.len() > 2 {
                parts.push(part);
            }
        }
        parts
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const L: &[[f64; 2]] = &[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    const M: &[[f64; 2]] = &[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.5, 0.5], [0.0, 2.0]];
    const DART: &[[f64; 2]] = &[[0.0, 0.0], [3.0, 0.0], [1.4, 0.4], [0.9, 1.2]];
    /// A comb with teeth of unequal widths, on its back.
    const COMB: &[[f64; 2]] = &[
        [0.0, 0.0],
        [5.0, 0.0],
        [5.0, 2.0],
        [4.5, 2.0],
        [4.5, 0.3],
        [3.1, 0.3],
        [3.1, 1.7],
        [2.0, 1.9],
        [2.2, 0.3],
        [0.7, 0.3],
        [0.7, 2.3],
        [0.0, 2.1],
    ];
    /// One and a half turns.
    const SPIRAL: &[[f64; 2]] = &[
        [0.0, 0.0],
        [6.0, 0.0],
        [6.0, 6.0],
        [1.0, 6.0],
        [1.0, 2.0],
        [4.0, 2.0],
        [4.0, 4.0],
        [2.5, 4.0],
        [2.5, 3.0],
        [3.0, 3.0],
        [3.0, 3.5],
        [3.5, 3.5],
        [3.5, 2.5],
        [2.0, 2.5],
        [2.0, 5.0],
        [5.0, 5.0],
        [5.0, 1.0],
        [0.0, 1.0],
    ];
    const RECTANGLE: &[[f64; 2]] = &[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]];

    fn polygon(flat: &[[f64; 2]]) -> Polygon {
        let frame = super::super::Frame::around(DVec3::new(0.3, -0.5, 0.7).normalize());
        let place = |p: &[f64; 2]| DVec3::new(0.1, 0.2, 0.3) + frame.tangent * p[0] + frame.bitangent * p[1];
        Polygon::new(flat.iter().map(place).collect()).unwrap()
    }

    fn re_entrant(outline: &Outline) -> usize {
        let n = outline.len();
        let turn = |i: usize| {
            let [a, b, c] = [outline[i], outline[(i + 1) % n], outline[(i + 2) % n]];
            (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
        };
        (0..n).filter(|i| turn(*i) < 0.0).count()
    }

    fn contains(outline: &Outline, p: [f64; 2]) -> bool {
        edges(outline)
            .filter(|[a, b]| (a[0] < p[0]) != (b[0] < p[0]))
            .filter(|e| crossing(*e, 0, p[0]) < p[1])
            .count()
            % 2
            == 1
    }

    #[test]
    fn a_rectangle_is_cut_into_a_regular_grid() {
        let partition = Partition::new(&polygon(RECTANGLE), 3);
        for i in 0..8 {
            for j in 0..8 {
                let [cell] = partition.cell(i, j) else { panic!("one piece") };
                for (axis, k, side) in [(0, i, 1.0), (1, j, 3.0)] {
                    let start = extent(&partition.axes.flatten(&polygon(RECTANGLE)), axis).0;
                    let (low, high) = extent(cell, axis);
                    approx::assert_abs_diff_eq!(low, start + side * k as f64 / 8.0, epsilon = 1e-14);
                    approx::assert_abs_diff_eq!(high, start + side * (k + 1) as f64 / 8.0, epsilon = 1e-14);
                }
            }
        }
    }

    #[test]
    fn cells_have_equal_areas_at_every_level() {
        for flat in [L, M, DART, COMB, SPIRAL, RECTANGLE] {
            let polygon = polygon(flat);
            for levels in 0..=5 {
                let partition = Partition::new(&polygon, levels);
                assert_eq!(partition.cells.len(), 1 << (2 * levels));
                for cell in &partition.cells {
                    let share = cell.iter().map(area).sum::<f64>() / polygon.area() * partition.cells.len() as f64;
                    approx::assert_abs_diff_eq!(share, 1.0, epsilon = 1e-12);
                }
            }
        }
    }

    #[test]
    fn cells_are_whole_but_for_one_piece_a_corner() {
        for flat in [L, M, DART, COMB, SPIRAL] {
            let polygon = polygon(flat);
            let corners = re_entrant(&Axes::of(&polygon).flatten(&polygon));
            for levels in 0..=5 {
                let cells = Partition::new(&polygon, levels).cells;
                let pieces: usize = cells.iter().map(Vec::len).sum();
                assert!(pieces <= cells.len() + corners, "{flat:?} level {levels}: {pieces} pieces");
            }
        }
    }

    /// The lattice of the golden ratio: every point of the polygon is in one cell and every other in none, and a cell
    /// of a level lies in its parent.
    #[test]
    fn cells_cover_the_polygon_once_and_nest() {
        for flat in [L, M, DART, COMB, SPIRAL] {
            let polygon = polygon(flat);
            let outline = Axes::of(&polygon).flatten(&polygon);
            let [coarse, fine] = [2, 4].map(|levels| Partition::new(&polygon, levels));
            let ((x0, x1), (y0, y1)) = (extent(&outline, 0), extent(&outline, 1));
            for k in 0..2000_u32 {
                let (a, b) = ((f64::from(k) + 0.5) / 2000.0, (f64::from(k) * 0.618_033_988_749_894_9).fract());
                let p = [x0 + (x1 - x0) * a, y0 + (y1 - y0) * b];
                let found = |partition: &Partition| -> Vec<usize> {
                    let holds = |i: &usize| partition.cells[*i].iter().any(|piece| contains(piece, p));
                    (0..partition.cells.len()).filter(holds).collect()
                };
                let (outer, inner) = (found(&coarse), found(&fine));
                let inside = usize::from(contains(&outline, p));
                assert_eq!((outer.len(), inner.len()), (inside, inside), "{flat:?} {p:?}");
                for (outer, inner) in outer.iter().zip(&inner) {
                    assert_eq!(*outer, (inner / 16 / 4) * 4 + inner % 16 / 4);
                }
            }
        }
    }

    /// What a stratum's variance goes by: the mean of (diameter² / area) over the cells does not grow with the level.
    #[test]
    fn cells_are_compact() {
        for (flat, allowed) in [(L, 4.0), (M, 8.0), (DART, 12.0), (COMB, 16.0), (SPIRAL, 16.0)] {
            let polygon = polygon(flat);
            for levels in 2..=5 {
                let cells = Partition::new(&polygon, levels).cells;
                let spread = |cell: &Vec<Outline>| {
                    let all: Vec<[f64; 2]> = cell.iter().flatten().copied().collect();
                    let far =
                        all.iter().flat_map(|a| all.iter().map(|b| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)));
                    far.fold(0.0, f64::max)
                };
                let mean = cells.iter().map(spread).sum::<f64>() / polygon.area();
                assert!(mean < allowed, "{flat:?} level {levels}: {mean}");
                println!("{} corners, level {levels}: {mean:.2}", flat.len());
            }
        }
    }
}
