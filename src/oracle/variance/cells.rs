//! Integrals over cells of the unit square, halved until each is wholly seen, wholly hidden, or small.

use std::cell::OnceCell;

use glam::DVec3;
use smallvec::SmallVec;

use super::chart::Place;
use super::field::{Contribution, Field, Landing};
use super::moments::SampleMoments;

/// A rectangle in the unit square.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub u: [f64; 2],
    pub v: [f64; 2],
}

impl Cell {
    pub const WHOLE: Cell = Cell { u: [0.0, 1.0], v: [0.0, 1.0] };

    pub fn area(&self) -> f64 {
        (self.u[1] - self.u[0]) * (self.v[1] - self.v[0])
    }

    fn at(&self, s: f64, t: f64) -> (f64, f64) {
        (self.u[0] + (self.u[1] - self.u[0]) * s, self.v[0] + (self.v[1] - self.v[0]) * t)
    }

    fn quarters(&self) -> [Cell; 4] {
        let (u, v) = self.at(0.5, 0.5);
        let ([u0, u1], [v0, v1]) = (self.u, self.v);
        [[[u0, u], [v0, v]], [[u, u1], [v0, v]], [[u0, u], [v, v1]], [[u, u1], [v, v1]]].map(|[u, v]| Cell { u, v })
    }
}

/// Where the corners of a cell lie in it, all around.
const CORNERS: [(f64, f64); 4] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];

/// A corner or the middle of a cell, which is a corner of others too.
struct Spot {
    u: f64,
    v: f64,
    place: Place,
    direction: DVec3,
    /// Of exitance 1.
    landing: Landing,
    /// Found when it is asked for.
    margin: OnceCell<f64>,
}

/// How far a cell reaches from its middle.
#[derive(Clone, Copy, Debug)]
struct Extent {
    /// As seen from the receiver, radians, with a margin.
    angle: f64,
    /// On the source, metres.
    size: f64,
}

/// How cells are integrated.
pub(super) struct Cells<'a, F> {
    pub field: &'a Field<'a>,
    /// Of one place to several integrands, which share the cells.
    pub contributions: F,
    /// Halvings of the first cell after which strata are asked for: no cell above this level is taken whole.
    pub finest: u32,
    /// Halvings down to which a cell on an edge is cut.
    pub edge_level: u32,
}

/// Beyond the finest strata, too: so often are those on an edge cut.
const EDGE_BELOW: u32 = 4;
/// A cell that is hardly narrower and hardly smaller than the one that it is a quarter of, and beyond this level, is torn: it
/// will not shrink. (One right before the receiver's eye gets smaller, and narrower only when it is as small as it is near.)
const TORN_LEVEL: u32 = 11;
const TORN: f64 = 0.8;
/// Seen wider than this (radians), a cell is cut: the rule below knows nothing of spikes.
const WIDEST: f64 = 0.15;
/// Seen narrower than this, fewer nodes do.
const NARROW: f64 = 0.04;
/// How much farther than its corners a cell may reach, as seen from the receiver.
const BULGE: f64 = 1.3;
/// No cell above this level is taken whole.
const SMOOTH_LEVEL: u32 = 4;
/// How much more often cells on a crease are cut.
const CREASE_BELOW: u32 = 3;

/// Halvings that find where an exitance jumps within a cell.
const JUMP_HALVINGS: u32 = 12;

/// Gauss–Legendre on [0, 1] with three and with four points: (node, weight).
const GAUSS_3: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
const GAUSS_4: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

impl<F: Fn(&Landing) -> [Contribution; N], const N: usize> Cells<'_, F> {
    /// The moments of each integrand over a cell: of what is brought from there, its weight the probability to land there
    /// unblocked.
    ///
    /// - `level`: halvings that led to it
    /// - `visit`: told (level, area, moments) of every cell down to the finest level, a cell after its quarters
    pub fn moments(
        &self,
        cell: Cell,
        level: u32,
        visit: &mut impl FnMut(u32, f64, &[SampleMoments; N]),
    ) -> [SampleMoments; N] {
        let corners = CORNERS.map(|(s, t)| self.spot(cell.at(s, t)));
        self.part(cell, corners.each_ref(), level, Extent { angle: f64::INFINITY, size: f64::INFINITY }, visit)
    }

    fn spot(&self, (u, v): (f64, f64)) -> Spot {
        let place = self.field.place(u, v);
        // Whether it is lit is no matter of how brightly.
        let (direction, landing) = self.field.of(&place, 1.0);
        Spot { u, v, place, direction, landing, margin: OnceCell::new() }
    }

    fn margin(&self, spot: &Spot) -> f64 {
        *spot.margin.get_or_init(|| self.field.margin(spot.direction))
    }

    /// - `above`: of the cell of which this one is a quarter
    fn part(
        &self,
        cell: Cell,
        corners: [&Spot; 4],
        level: u32,
        above: Extent,
        visit: &mut impl FnMut(u32, f64, &[SampleMoments; N]),
    ) -> [SampleMoments; N] {
        let moments = self.found(cell, corners, level, above, visit);
        if level <= self.finest {
            visit(level, cell.area(), &moments);
        }
        moments
    }

    fn found(
        &self,
        cell: Cell,
        corners: [&Spot; 4],
        level: u32,
        above: Extent,
        visit: &mut impl FnMut(u32, f64, &[SampleMoments; N]),
    ) -> [SampleMoments; N] {
        let middle = self.spot(cell.at(0.5, 0.5));
        let margin = self.margin(&middle);
        let distances = corners.map(|corner| corner.direction.distance(middle.direction));
        let reach = BULGE * distances.into_iter().fold(0.0, f64::max);
        let sizes = corners.map(|corner| corner.place.position.distance(middle.place.position));
        let extent = Extent { angle: reach, size: sizes.into_iter().fold(0.0, f64::max) };
        let is_torn = level > TORN_LEVEL && reach > TORN * above.angle && extent.size > TORN * above.size;
        // The corners of a great cell may lie together (at a pole) and tell nothing of how far it reaches.
        let may_end = level >= SMOOTH_LEVEL.max(self.finest);
        if margin.abs() > reach {
            if margin < 0.0 && may_end {
                return [SampleMoments::SHADOW; N];
            }
            let sets = |corner: &&&Spot| corner.landing.cos_receiver * corner.landing.cos_source > 0.0;
            let lit = corners.iter().filter(sets).count();
            // Where light sets, on the receiver's horizon or a sphere's own, the integrand has a corner too.
            let is_creased = (lit != 0 && lit != 4) || self.field.is_creased(cell.u, cell.v);
            let is_uneven = self.field.is_uneven(cell.u, cell.v, level);
            if is_uneven && level >= self.edge_level.max(self.finest + EDGE_BELOW) && (reach <= WIDEST || is_torn) {
                return self.parted(cell);
            }
            let smooth = SMOOTH_LEVEL.max(self.finest) + if is_creased { CREASE_BELOW } else { 0 };
            if level >= smooth && !is_uneven && (reach <= WIDEST || is_torn) {
                return if reach <= NARROW { self.ruled(cell, &GAUSS_3) } else { self.ruled(cell, &GAUSS_4) };
            }
        } else if level >= self.edge_level.max(self.finest + EDGE_BELOW) && (reach <= WIDEST || is_torn) {
            let margins = corners.map(|corner| self.margin(corner));
            let landing = Landing { exitance: self.field.exitance_at(&middle.place), ..middle.landing };
            let share = seen_share(margin, margins);
            return (self.contributions)(&landing).map(|Contribution { value, density }| {
                let weight = density * cell.area() * share;
                SampleMoments { has_shadow: true, ..SampleMoments::point(value, weight) }
            });
        }
        self.quarters(cell, corners, &middle, &mut |quarter, corners| {
            self.part(quarter, corners, level + 1, extent, visit)
        })
    }

    /// Both parts of all quarters, whose corners are the cell's own, its middle, and the middles of its sides.
    fn quarters(
        &self,
        cell: Cell,
        corners: [&Spot; 4],
        middle: &Spot,
        part: &mut dyn FnMut(Cell, [&Spot; 4]) -> [SampleMoments; N],
    ) -> [SampleMoments; N] {
        let ([u0, u1], [v0, v1], (u, v)) = (cell.u, cell.v, (middle.u, middle.v));
        let (bottom, right) = (self.spot((u, v0)), self.spot((u1, v)));
        let (top, left) = (self.spot((u, v1)), self.spot((u0, v)));
        // `[v][u]`.
        let grid = [[corners[0], &bottom, corners[1]], [&left, middle, &right], [corners[3], &top, corners[2]]];
        let mut sums = [SampleMoments::default(); N];
        for (k, quarter) in cell.quarters().into_iter().enumerate() {
            let known = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(j, i)| grid[k / 2 + j][k % 2 + i]);
            let places = CORNERS.map(|(s, t)| quarter.at(s, t));
            let is_known = |c: usize| (known[c].u, known[c].v) == places[c];
            let parts = if (0..4).all(is_known) {
                part(quarter, known)
            } else {
                // Where the sides of a cell are rounded, the same place may have other digits.
                let own: [Option<Spot>; 4] = std::array::from_fn(|c| (!is_known(c)).then(|| self.spot(places[c])));
                part(quarter, std::array::from_fn(|c| own[c].as_ref().unwrap_or(known[c])))
            };
            sums = std::array::from_fn(|i| sums[i].plus(parts[i]));
        }
        sums
    }

    /// A small cell in which the exitance jumps, along one line as far as the cell tells: on each of a few lines across that,
    /// what is on either side of the jump by its length.
    fn parted(&self, cell: Cell) -> [SampleMoments; N] {
        let exitance = |s: f64, t: f64| {
            let (u, v) = cell.at(s, t);
            self.field.exitance_at(&self.field.place(u, v))
        };
        // Borders of texels and of cells often coincide: a hair inside.
        let (low, high) = (1e-9, 1.0 - 1e-9);
        let differs = |a: (f64, f64), b: (f64, f64)| usize::from(exitance(a.0, a.1) != exitance(b.0, b.1));
        let across_u = differs((low, low), (high, low)) + differs((low, high), (high, high));
        let across_v = differs((low, low), (low, high)) + differs((high, low), (high, high));
        let place = |along: f64, line: f64| if across_u >= across_v { (along, line) } else { (line, along) };
        let value = |along: f64, line: f64| {
            let (s, t) = place(along, line);
            exitance(s, t)
        };
        let mut values: [SmallVec<[(f64, f64); 6]>; N] = std::array::from_fn(|_| SmallVec::new());
        for (line, weight) in GAUSS_3 {
            let (mut before, mut after) = (low, high);
            let first = value(before, line);
            let jumps = first != value(after, line);
            for _ in 0..if jumps { JUMP_HALVINGS } else { 0 } {
                let middle = 0.5 * (before + after);
                if value(middle, line) == first {
                    before = middle;
                } else {
                    after = middle;
                }
            }
            let jump = if jumps { 0.5 * (before + after) } else { 1.0 };
            for [from, to] in [[0.0, jump], [jump, 1.0]] {
                if to > from {
                    let (s, t) = place(0.5 * (from + to), line);
                    let (u, v) = cell.at(s, t);
                    let (_, landing) = self.field.at(u, v);
                    for (values, brought) in values.iter_mut().zip((self.contributions)(&landing)) {
                        values.push((brought.value, brought.density * cell.area() * weight * (to - from)));
                    }
                }
            }
        }
        values.each_ref().map(|values| SampleMoments::of(values))
    }

    /// A product rule over a cell without an edge.
    fn ruled(&self, cell: Cell, rule: &[(f64, f64)]) -> [SampleMoments; N] {
        let area = cell.area();
        let mut values: [SmallVec<[(f64, f64); 16]>; N] = std::array::from_fn(|_| SmallVec::new());
        for (s, weight_s) in rule {
            for (t, weight_t) in rule {
                let (u, v) = cell.at(*s, *t);
                let (_, landing) = self.field.at(u, v);
                for (values, brought) in values.iter_mut().zip((self.contributions)(&landing)) {
                    values.push((brought.value, brought.density * area * weight_s * weight_t));
                }
            }
        }
        values.each_ref().map(|values| SampleMoments::of(values))
    }
}

/// The share of a cell where the margin is positive, taken as linear on the four triangles around the middle.
fn seen_share(middle: f64, corners: [f64; 4]) -> f64 {
    (0..4).map(|i| 0.25 * positive_share([middle, corners[i], corners[(i + 1) % 4]])).sum()
}

/// The share of a triangle where a linear function of these values at its corners is positive.
fn positive_share([a, b, c]: [f64; 3]) -> f64 {
    // The corner whose sign is its own.
    let (own, p, q) = match (a > 0.0, b > 0.0, c > 0.0) {
        (true, true, true) => return 1.0,
        (false, false, false) => return 0.0,
        (x, y, z) if y == z && x != y => (a, b, c),
        (x, y, z) if x == z && y != x => (b, a, c),
        _ => (c, a, b),
    };
    let share = (own / (own - p)) * (own / (own - q));
    if own > 0.0 { share } else { 1.0 - share }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_a_triangle_leaves_its_share() {
        assert_eq!(positive_share([1.0, -1.0, -1.0]), 0.25);
        assert_eq!(positive_share([-1.0, 1.0, 1.0]), 0.75);
        assert_eq!(positive_share([-1.0, 3.0, -3.0]), 0.375);
        // A straight edge through a cell, x < 0.3.
        let margin = |x: f64| 0.3 - x;
        let share = seen_share(margin(0.5), [margin(0.0), margin(1.0), margin(1.0), margin(0.0)]);
        assert!((share - 0.3).abs() < 1e-15, "{share}");
    }
}
