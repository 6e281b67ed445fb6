//! Maps from the unit square to a surface. All are of equal area (the density per area is one over the area). They are
//! continuous wherever the surface allows; where a polygon does not, they jump along lines of the square's dyadic grid
//! only. Strata keep both their area and their shape: N of them, with N a power of 4 for such polygons.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec3;
use smallvec::SmallVec;

use super::arc::sin_cos_eighth;
use super::{BLOCK, LANES, Row, Squares, groups};
use crate::geometry::partition::{Axes, Outline, Partition, quarters};
use crate::geometry::{Frame, Polygon, Shape};
use crate::number::{Eight, Lanewise, Machine, Registers, Work};

/// Halvings of u and of v before a torn polygon's cells are swept by chords: 1024 cells.
const LEVELS: u32 = 5;
/// Further halvings of the few cells that are torn themselves.
const DEEPER: u32 = 8;

/// One block of points on a surface, as offsets from the surface's origin, metres.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct SurfaceBlock {
    pub x: Row,
    pub y: Row,
    pub z: Row,
}

impl Default for SurfaceBlock {
    fn default() -> SurfaceBlock {
        SurfaceBlock {
            x: [[0.0; LANES]; BLOCK / LANES],
            y: [[0.0; LANES]; BLOCK / LANES],
            z: [[0.0; LANES]; BLOCK / LANES],
        }
    }
}

/// A surface that points can be put on.
#[derive(Clone, Debug)]
pub struct Surface {
    origin: DVec3,
    area: f64,
    chart: Chart,
}

/// How the unit square is laid on the surface.
#[derive(Clone, Debug)]
enum Chart {
    /// (u − ½) edge_u + (v − ½) edge_v.
    Parallelogram { normal: DVec3, edge_u: DVec3, edge_v: DVec3 },
    /// Concentric squares to concentric circles (Shirley & Chiu 1997); the axes are R long.
    Disk { normal: DVec3, tangent: DVec3, bitangent: DVec3 },
    /// Folded along the diagonal of the square (Heitz, *A Low-Distortion Map Between Triangle and Square*, 2019).
    Triangle { normal: DVec3, to_second: DVec3, to_third: DVec3 },
    /// u sweeps the polygon by area, v runs along the chord.
    Chords { normal: DVec3, sweep: DVec3, along: DVec3, slabs: Vec<Slab> },
    /// Cells of equal area for the squares of a grid of 2⁵ × 2⁵, each swept by chords of its own; the few that re-entrant
    /// corners tear are cut further.
    Cells {
        normal: DVec3,
        sweep: DVec3,
        along: DVec3,
        slabs: Vec<Slab>,
        /// First those of the grid, `[u][v]`.
        cells: Vec<CellChart>,
    },
    /// The octahedral map made equal-area by concentric quarter disks (Clarberg, JGT 13(3), 2008).
    Sphere { radius: f64 },
}

/// How a square of the dyadic grid is laid on its cell.
#[derive(Clone, Copy, Debug)]
enum CellChart {
    /// By these of the slabs.
    Swept { from: usize, to: usize },
    /// By four cells, `[u][v]`, from this one on.
    Quartered { first: usize },
}

/// How smooth the map to a surface is: what a smooth function on the surface looks like over the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Seams {
    /// Smooth, but for creases along lines of one u.
    None,
    /// Continuous, with creases along slanted lines (the diagonals of the square).
    Creased,
    /// It jumps along lines of the dyadic grid, down to 1/32 (finer only where a re-entrant corner is near).
    Torn,
}

/// The part of a polygon between two neighbouring vertices in sweep order.
#[derive(Clone, Debug)]
struct Slab {
    /// Share of the polygon's area before this slab.
    area_before: f64,
    /// Sweep coordinate where it begins, and its width, metres.
    start: f64,
    width: f64,
    /// Chord (all pieces together) where it begins and ends, times the slab's width, as shares of the polygon's area.
    chord: [f64; 2],
    /// Metres of chord per unit of `chord`.
    metres: f64,
    /// For each piece, bottom and top at the beginning and at the end.
    pieces: SmallVec<[[[f64; 2]; 2]; 1]>,
}

impl Surface {
    /// The surface of a shape; `None` for a mesh.
    pub fn new(shape: &Shape) -> Option<Surface> {
        let (origin, chart) = match shape {
            Shape::Rectangle(s) => {
                (s.center(), Chart::Parallelogram { normal: s.normal(), edge_u: s.edge_u(), edge_v: s.edge_v() })
            }
            Shape::Disk(s) => {
                let frame = Frame::around(s.normal());
                let (tangent, bitangent) = (frame.tangent * s.radius(), frame.bitangent * s.radius());
                (s.center(), Chart::Disk { normal: s.normal(), tangent, bitangent })
            }
            Shape::Polygon(s) => match s.vertices() {
                &[a, b, c] => (a, Chart::Triangle { normal: s.normal(), to_second: b - a, to_third: c - a }),
                _ => {
                    let chart = match chords(s) {
                        Chart::Chords { slabs, .. } if are_torn(&slabs, s.area()) => cells(s),
                        whole => whole,
                    };
                    (s.vertices()[0], chart)
                }
            },
            Shape::Sphere(s) => (s.center(), Chart::Sphere { radius: s.radius() }),
            _ => return None,
        };
        Some(Surface { origin, area: shape.area(), chart })
    }

    /// What offsets are measured from, metres.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }
    /// Square metres.
    pub fn area(&self) -> f64 {
        self.area
    }
    /// The unit normal of a flat surface.
    pub fn flat_normal(&self) -> Option<DVec3> {
        match self.chart {
            Chart::Parallelogram { normal, .. }
            | Chart::Disk { normal, .. }
            | Chart::Triangle { normal, .. }
            | Chart::Chords { normal, .. }
            | Chart::Cells { normal, .. } => Some(normal),
            Chart::Sphere { .. } => None,
        }
    }
    /// The radius of a sphere, metres; a point's normal is its offset over the radius.
    pub fn sphere_radius(&self) -> Option<f64> {
        match self.chart {
            Chart::Sphere { radius } => Some(radius),
            _ => None,
        }
    }

    /// How smooth the map is.
    pub fn seams(&self) -> Seams {
        match self.chart {
            Chart::Parallelogram { .. } | Chart::Chords { .. } => Seams::None,
            Chart::Disk { .. } | Chart::Triangle { .. } | Chart::Sphere { .. } => Seams::Creased,
            Chart::Cells { .. } => Seams::Torn,
        }
    }

    /// Puts the first `len` points of a block (rounded up to whole lanes) on the surface.
    pub fn place(&self, squares: &Squares, len: usize, out: &mut SurfaceBlock) {
        self.place_on(Machine::Any, squares, len, out);
    }

    /// As [`Surface::place`], in the registers of a machine.
    pub(crate) fn place_on(&self, machine: Machine, squares: &Squares, len: usize, out: &mut SurfaceBlock) {
        machine.run(Place { chart: &self.chart, squares, len, out });
    }
}

struct Place<'a> {
    chart: &'a Chart,
    squares: &'a Squares,
    len: usize,
    out: &'a mut SurfaceBlock,
}

impl Work for Place<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, registers: R) {
        let Place { chart, squares, len, out } = self;
        match chart {
            Chart::Parallelogram { edge_u, edge_v, .. } => {
                place_flat(registers, squares, len, out, [*edge_u, *edge_v], Centred);
            }
            Chart::Disk { tangent, bitangent, .. } => {
                place_flat(registers, squares, len, out, [*tangent, *bitangent], Concentric);
            }
            Chart::Triangle { to_second, to_third, .. } => {
                place_flat(registers, squares, len, out, [*to_second, *to_third], Folded);
            }
            Chart::Chords { sweep, along, slabs, .. } => {
                place_one_by_one(squares, len, out, [*sweep, *along], |u, v| on_chord(slabs, u, v));
            }
            Chart::Cells { sweep, along, slabs, cells, .. } => {
                place_one_by_one(squares, len, out, [*sweep, *along], |u, v| in_cell(slabs, cells, u, v));
            }
            Chart::Sphere { radius } => {
                for g in 0..groups(len) {
                    let (u, v) = (Eight::load(registers, &squares.u[g]), Eight::load(registers, &squares.v[g]));
                    let (x, y, z) = octahedral(u, v);
                    (x * *radius).store(&mut out.x[g]);
                    (y * *radius).store(&mut out.y[g]);
                    (z * *radius).store(&mut out.z[g]);
                }
            }
        }
    }
}

/// A map from the unit square to coordinates along two axes.
trait FlatChart {
    fn at<T: Lanewise>(&self, u: T, v: T) -> (T, T);
}

/// The square itself, around its middle.
struct Centred;
/// See [`concentric`].
struct Concentric;
/// See [`fold`].
struct Folded;

impl FlatChart for Centred {
    #[inline(always)]
    fn at<T: Lanewise>(&self, u: T, v: T) -> (T, T) {
        (u - 0.5, v - 0.5)
    }
}

impl FlatChart for Concentric {
    #[inline(always)]
    fn at<T: Lanewise>(&self, u: T, v: T) -> (T, T) {
        concentric_lanes(u, v)
    }
}

impl FlatChart for Folded {
    #[inline(always)]
    fn at<T: Lanewise>(&self, u: T, v: T) -> (T, T) {
        fold(u, v)
    }
}

#[inline(always)]
fn place_flat<R: Registers>(
    registers: R,
    squares: &Squares,
    len: usize,
    out: &mut SurfaceBlock,
    [first, second]: [DVec3; 2],
    chart: impl FlatChart,
) {
    for g in 0..groups(len) {
        let (a, b) = chart.at(Eight::load(registers, &squares.u[g]), Eight::load(registers, &squares.v[g]));
        (a * first.x + b * second.x).store(&mut out.x[g]);
        (a * first.y + b * second.y).store(&mut out.y[g]);
        (a * first.z + b * second.z).store(&mut out.z[g]);
    }
}

fn place_one_by_one(
    squares: &Squares,
    len: usize,
    out: &mut SurfaceBlock,
    [first, second]: [DVec3; 2],
    chart: impl Fn(f64, f64) -> (f64, f64),
) {
    for g in 0..groups(len) {
        for l in 0..LANES {
            let (a, b) = chart(squares.u[g][l], squares.v[g][l]);
            out.x[g][l] = a * first.x + b * second.x;
            out.y[g][l] = a * first.y + b * second.y;
            out.z[g][l] = a * first.z + b * second.z;
        }
    }
}

/// From the unit square to the unit disk: concentric squares to concentric circles, areas kept (Shirley & Chiu 1997).
///
/// - `u`, `v`: in [0, 1]
/// - error: a few 2⁻⁵³
#[inline(always)]
pub fn concentric(u: f64, v: f64) -> (f64, f64) {
    concentric_lanes(u, v)
}

/// As [`concentric`], for one point or several.
#[inline(always)]
pub(super) fn concentric_lanes<T: Lanewise>(u: T, v: T) -> (T, T) {
    let (a, b) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
    let a_leads = b.abs().is_below(a.abs());
    let (radius, other) = (T::choose(a_leads, a, b), T::choose(a_leads, b, a));
    let (sin, cos) = sin_cos_eighth(T::choose(radius.is_zero(), radius.like(0.0), other / radius));
    let (leading, following) = (radius * cos, radius * sin);
    (T::choose(a_leads, leading, following), T::choose(a_leads, following, leading))
}

/// From the unit square to barycentric weights of the second and third vertex.
#[inline(always)]
fn fold<T: Lanewise>(u: T, v: T) -> (T, T) {
    let low = u.at_most(v) * 0.5;
    (u - low, v - low)
}

/// From the unit square to the unit sphere.
#[inline(always)]
fn octahedral<T: Lanewise>(u: T, v: T) -> (T, T, T) {
    let (a, b) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
    let one = a.like(1.0);
    let height = one - (a.abs() + b.abs());
    let radius = one - height.abs();
    let turn = T::choose(radius.is_zero(), radius.like(0.0), (b.abs() - a.abs()) / radius);
    let (sin, cos) = sin_cos_eighth(turn);
    let ring = radius * (a.like(2.0) - radius * radius).sqrt() * FRAC_1_SQRT_2;
    let z = signed(one - radius * radius, height);
    (signed(ring * (cos - sin), a), signed(ring * (cos + sin), b), z)
}

/// The size of one number with the sign of another.
#[inline(always)]
fn signed<T: Lanewise>(size: T, sign: T) -> T {
    let size = size.abs();
    T::choose(sign.is_below(sign.like(0.0)), -size, size)
}

/// From the unit square to a cell, and there to a chord.
#[inline(always)]
fn in_cell(slabs: &[Slab], cells: &[CellChart], u: f64, v: f64) -> (f64, f64) {
    let (i, j, mut u, mut v) = grid_place(f64::from(1_u32 << LEVELS), u, v);
    let mut cell = i * (1 << LEVELS) + j;
    loop {
        match cells[cell] {
            CellChart::Swept { from, to } => return on_chord(&slabs[from..to], u, v),
            CellChart::Quartered { first } => {
                let (i, j, finer_u, finer_v) = grid_place(2.0, u, v);
                (cell, u, v) = (first + 2 * i + j, finer_u, finer_v);
            }
        }
    }
}

/// Column and row of a point in a grid, and its place in that square. Exact: sides are powers of two.
#[inline(always)]
fn grid_place(side: f64, u: f64, v: f64) -> (usize, usize, f64, f64) {
    let (i, j) = ((u * side).min(side - 1.0).floor(), (v * side).min(side - 1.0).floor());
    (i as usize, j as usize, u * side - i, v * side - j)
}

fn on_chord(slabs: &[Slab], u: f64, v: f64) -> (f64, f64) {
    let slab = &slabs[slabs.partition_point(|slab| slab.area_before <= u).max(1) - 1];
    // Area from the slab's beginning, over its width: chord₀ x + (chord₁ − chord₀) x²/2 for x in [0, 1].
    let [begin, end] = slab.chord;
    let target = u - slab.area_before;
    let root = (begin * begin + 2.0 * (end - begin) * target).max(0.0).sqrt();
    let x = if target > 0.0 { (2.0 * target / (begin + root)).min(1.0) } else { 0.0 };
    let mut left = v * (begin + (end - begin) * x) * slab.metres;
    let mut y = 0.0;
    for [bottom, top] in &slab.pieces {
        let low = bottom[0] + (bottom[1] - bottom[0]) * x;
        let length = top[0] + (top[1] - top[0]) * x - low;
        y = low + left.min(length);
        left -= length;
        if left <= 0.0 {
            break;
        }
    }
    (slab.start + slab.width * x, y)
}

/// Lays a polygon out by its chords.
fn chords(polygon: &Polygon) -> Chart {
    let axes = Axes::of(polygon);
    let outline = axes.flatten(polygon);
    let slabs = slabs(std::slice::from_ref(&outline), 1e-13 * extent(&outline));
    Chart::Chords { normal: polygon.normal(), sweep: axes.sweep, along: axes.along, slabs }
}

/// Lays a polygon out cell by cell.
fn cells(polygon: &Polygon) -> Chart {
    let partition = Partition::new(polygon, LEVELS);
    let axes = partition.axes();
    let nothing = 1e-13 * extent(&axes.flatten(polygon));
    let side = partition.side();
    let (mut all, mut cells) = (Vec::new(), Vec::new());
    // Cells, in order, of the level at hand; then those that the torn ones among them are quartered into.
    let mut level: Vec<Vec<Outline>> =
        (0..side * side).map(|k| partition.cell(k / side, k % side).to_vec()).collect();
    for deeper in 0..=DEEPER {
        let mut finer = Vec::new();
        let first_finer = cells.len() + level.len();
        for cell in level {
            let mut own = slabs(&cell, nothing);
            if deeper < DEEPER && are_torn(&own, polygon.area()) {
                cells.push(CellChart::Quartered { first: first_finer + finer.len() });
                finer.extend(quarters(cell));
            } else {
                cells.push(CellChart::Swept { from: all.len(), to: all.len() + own.len() });
                all.append(&mut own);
            }
        }
        level = finer;
    }
    Chart::Cells { normal: polygon.normal(), sweep: axes.sweep, along: axes.along, slabs: all, cells }
}

/// Whether neighbours in the unit square are parted: where a chord jumps or splits, or where the sweep leaps. What is smooth
/// on the surface would jump over the square along a line, and √N strata lose what strata gain.
///
/// - `area`: of the polygon, square metres; says what is only rounding
fn are_torn(slabs: &[Slab], area: f64) -> bool {
    let split = slabs.iter().any(|slab| slab.pieces.len() > 1);
    let apart = |a: f64, b: f64| (a - b).abs() > 1e-9 * area.sqrt();
    let parted = |before: &Slab, after: &Slab| {
        let mut ends = before.pieces.iter().zip(&after.pieces).flat_map(|(a, b)| [0, 1].map(|k| (a[k][1], b[k][0])));
        apart(before.start + before.width, after.start) || ends.any(|(end, start)| apart(end, start))
    };
    split || slabs.windows(2).any(|pair| parted(&pair[0], &pair[1]))
}

/// Metres of sweep.
fn extent(outline: &Outline) -> f64 {
    let sweep = outline.iter().map(|p| p[0]);
    sweep.clone().fold(f64::NEG_INFINITY, f64::max) - sweep.fold(f64::INFINITY, f64::min)
}

/// Cuts disjoint outlines into slabs.
///
/// - `nothing`: metres of sweep that are only rounding
fn slabs(outlines: &[Outline], nothing: f64) -> Vec<Slab> {
    let mut stops: Vec<f64> = outlines.iter().flatten().map(|p| p[0]).collect();
    stops.sort_by(f64::total_cmp);
    stops.dedup_by(|b, a| *b - *a <= nothing);
    let edges = || outlines.iter().flat_map(|o| (0..o.len()).map(move |i| (o[i], o[(i + 1) % o.len()])));
    let mut slabs = Vec::new();
    let mut area_before = 0.0;
    for stop in stops.windows(2) {
        let (start, width) = (stop[0], stop[1] - stop[0]);
        let middle = start + 0.5 * width;
        let mut crossing: Vec<[f64; 2]> = edges()
            .filter_map(|(a, b)| {
                let spans = (a[0] < middle) != (b[0] < middle);
                let at = |s: f64| a[1] + (b[1] - a[1]) * ((s - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
                spans.then(|| [at(stop[0]), at(stop[1])])
            })
            .collect();
        crossing.sort_by(|a, b| (a[0] + a[1]).total_cmp(&(b[0] + b[1])));
        let pieces: SmallVec<[[[f64; 2]; 2]; 1]> = crossing.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
        let chord =
            [0, 1].map(|end| pieces.iter().map(|[bottom, top]| (top[end] - bottom[end]).max(0.0)).sum::<f64>());
        // Between pieces that stand apart there is nothing to sweep.
        if chord[0] + chord[1] > 0.0 {
            slabs.push(Slab { area_before, start, width, chord, metres: 1.0, pieces });
            area_before += 0.5 * (chord[0] + chord[1]) * width;
        }
    }
    let total = area_before;
    for slab in &mut slabs {
        slab.area_before /= total;
        slab.chord = slab.chord.map(|c| c * slab.width / total);
        slab.metres = total / slab.width;
    }
    slabs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Disk, Rectangle, Sphere};
    use proptest::prelude::*;

    fn polygon(flat: &[[f64; 2]]) -> Shape {
        let frame = Frame::around(DVec3::new(0.3, -0.5, 0.7).normalize());
        let vertices = flat.iter().map(|p| DVec3::new(0.1, 0.2, 0.3) + frame.tangent * p[0] + frame.bitangent * p[1]);
        Shape::Polygon(Polygon::new(vertices.collect()).unwrap())
    }

    fn shapes() -> Vec<Shape> {
        vec![
            Shape::Rectangle(Rectangle::new(DVec3::X, DVec3::X * 2.0, DVec3::Z).unwrap()),
            Shape::Disk(Disk::new(DVec3::Y, DVec3::new(1.0, 2.0, -1.0), 0.7).unwrap()),
            Shape::Sphere(Sphere::new(DVec3::Z, 0.4).unwrap()),
            polygon(&[[0.0, 0.0], [1.0, 0.2], [0.3, 1.5]]),
            polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]),
            polygon(&[[0.0, 0.0], [1.0, 0.0], [1.3, 0.9], [0.5, 1.6], [-0.3, 0.9]]),
            // A lopsided M: two pieces on some chords.
            polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.2, 0.3], [0.0, 2.0]]),
        ]
    }

    fn grid(surface: &Surface, n: usize) -> Vec<DVec3> {
        let mut out = SurfaceBlock::default();
        let mut squares = Squares::default();
        let mut points = Vec::with_capacity(n * n);
        for j in 0..n {
            for start in (0..n).step_by(BLOCK) {
                let len = BLOCK.min(n - start);
                for i in 0..len {
                    squares.u[i / LANES][i % LANES] = ((start + i) as f64 + 0.5) / n as f64;
                    squares.v[i / LANES][i % LANES] = (j as f64 + 0.5) / n as f64;
                }
                surface.place(&squares, len, &mut out);
                let row = |row: &Row, i: usize| row[i / LANES][i % LANES];
                let at = |i: usize| DVec3::new(row(&out.x, i), row(&out.y, i), row(&out.z, i));
                points.extend((0..len).map(|i| surface.origin() + at(i)));
            }
        }
        points
    }

    /// Area and first moments against exact values: for a flat shape by its own boundary (Green), independent of the map.
    fn centroid(shape: &Shape) -> DVec3 {
        match shape {
            Shape::Polygon(p) => {
                let v = p.vertices();
                let (mut sum, mut area) = (DVec3::ZERO, 0.0);
                for i in 1..v.len() - 1 {
                    let part = 0.5 * (v[i] - v[0]).cross(v[i + 1] - v[0]).dot(p.normal());
                    sum += (v[0] + v[i] + v[i + 1]) / 3.0 * part;
                    area += part;
                }
                sum / area
            }
            Shape::Rectangle(s) => s.center(),
            Shape::Disk(s) => s.center(),
            Shape::Sphere(s) => s.center(),
            Shape::Mesh(_) => unreachable!("meshes have no surface map"),
        }
    }

    #[test]
    fn the_mean_over_the_square_is_the_centroid() {
        for shape in shapes() {
            let surface = Surface::new(&shape).unwrap();
            let points = grid(&surface, 512);
            let mean = points.iter().sum::<DVec3>() / points.len() as f64;
            // A crease of the map (a re-entrant corner) that falls inside a row of cells costs up to size / n.
            let allowed = if matches!(&shape, Shape::Polygon(p) if !p.is_convex()) { 1.0 / 512.0 } else { 2e-5 };
            assert!((mean - centroid(&shape)).length() < allowed, "{shape:?}: {mean}");
        }
    }

    #[test]
    fn equal_parts_of_the_square_get_equal_areas() {
        // Local area of small quadrilaterals of the map, against area / cells.
        for shape in shapes() {
            let surface = Surface::new(&shape).unwrap();
            let n = 320;
            let points = grid(&surface, n);
            let expected = surface.area() / (n * n) as f64;
            let mut off = 0;
            for j in 0..n - 1 {
                for i in 0..n - 1 {
                    // Ten places to a cell of a torn surface; between cells it jumps.
                    if surface.seams() == Seams::Torn && (i % 10 == 9 || j % 10 == 9) {
                        continue;
                    }
                    let at = |di: usize, dj: usize| points[(j + dj) * n + i + di];
                    let cell = 0.5 * (at(1, 1) - at(0, 0)).cross(at(0, 1) - at(1, 0)).length();
                    off += usize::from((cell / expected - 1.0).abs() > 0.05);
                }
            }
            // Cells on the creases of a map (diagonals, slab borders, gaps between pieces) are cut; all others agree.
            assert!(off < 8 * n, "{shape:?}: {off} of {} cells have another area", n * n);
        }
    }

    proptest! {
        #[test]
        fn points_lie_on_their_surface(u in 0.0..=1.0, v in 0.0..=1.0) {
            for shape in shapes() {
                let surface = Surface::new(&shape).unwrap();
                let squares = Squares { u: [[u; LANES]; BLOCK / LANES], v: [[v; LANES]; BLOCK / LANES] };
                let mut out = SurfaceBlock::default();
                surface.place(&squares, 1, &mut out);
                let offset = DVec3::new(out.x[0][0], out.y[0][0], out.z[0][0]);
                let (low, high) = shape.bounds();
                let p = surface.origin() + offset;
                prop_assert!(p.cmpge(low - 1e-14).all() && p.cmple(high + 1e-14).all(), "{:?} {}", shape, p);
                match (surface.flat_normal(), surface.sphere_radius()) {
                    (Some(normal), _) => prop_assert!(offset.dot(normal).abs() < 1e-14),
                    (None, Some(radius)) => prop_assert!((offset.length() - radius).abs() < 1e-15),
                    (None, None) => unreachable!(),
                }
                if let Shape::Disk(s) = &shape {
                    prop_assert!(offset.length() <= s.radius() * (1.0 + 1e-15));
                }
            }
        }
    }

    #[test]
    fn only_jumping_chords_tear_a_surface() {
        let torn: Vec<bool> =
            shapes().iter().map(|shape| Surface::new(shape).unwrap().seams() == Seams::Torn).collect();
        let l_and_m_alone: Vec<bool> =
            shapes().iter().map(|shape| matches!(shape, Shape::Polygon(polygon) if !polygon.is_convex())).collect();
        assert_eq!(torn, l_and_m_alone);
        // A dart: its chords along the longest edge end at a concave corner without a jump.
        let dart = polygon(&[[0.0, 0.0], [3.0, 0.0], [1.4, 0.4], [0.9, 1.2]]);
        assert_eq!(Surface::new(&dart).unwrap().seams(), Seams::None);
    }

    /// Variance of the mean of one point in each of `side`² strata, by `fine`² places in all: irradiance, but for a
    /// factor, at a patch that faces the surface three metres from its origin, no occluder.
    fn stratified_variance(surface: &Surface, side: usize, fine: usize) -> f64 {
        let eye = surface.origin() + surface.flat_normal().unwrap() * 3.0;
        let f: Vec<f64> = grid(surface, fine).iter().map(|p| 1.0 / (*p - eye).length_squared().powi(2)).collect();
        let (q, n) = (fine / side, (side * side) as f64);
        let mut sum = 0.0;
        for stratum in 0..side * side {
            let at = |k: usize| f[(stratum / side * q + k / q) * fine + stratum % side * q + k % q];
            let mean = (0..q * q).map(at).sum::<f64>() / (q * q) as f64;
            sum += (0..q * q).map(|k| (at(k) - mean).powi(2)).sum::<f64>() / (q * q) as f64;
        }
        sum / (n * n)
    }

    /// Slope of the variance between N = 4096 and N = 65536, and the variance at 4096.
    fn slope(surface: &Surface) -> (f64, f64) {
        let [few, many] = [64, 256].map(|side| stratified_variance(surface, side, 1024));
        ((many / few).ln() / 16_f64.ln(), few)
    }

    #[test]
    fn strata_of_polygons_keep_their_shape() {
        for shape in shapes() {
            let Shape::Polygon(polygon) = &shape else { continue };
            let surface = Surface::new(&shape).unwrap();
            let (found, variance) = slope(&surface);
            assert!((found + 2.0).abs() < 0.03, "{shape:?}: {found}");
            // Cells and parts of cells, at every N.
            let all = [4, 8, 16, 32, 64].map(|side| stratified_variance(&surface, side, 512));
            assert!(all.windows(2).all(|pair| pair[1] < pair[0] / 13.0), "{shape:?}: {all:?}");
            if surface.seams() == Seams::Torn {
                // By chords alone √N strata hold places on both sides of a re-entrant corner.
                let swept = Surface { chart: chords(polygon), ..surface.clone() };
                let (with_chords, larger) = slope(&swept);
                assert!((with_chords + 1.5).abs() < 0.1, "{shape:?}: {with_chords}");
                assert!(variance < 0.25 * larger, "{shape:?}: {variance} {larger}");
                println!(
                    "{} vertices: {found:.3}, {with_chords:.3}; {:.3}",
                    polygon.vertices().len(),
                    variance / larger
                );
            }
        }
    }
}
