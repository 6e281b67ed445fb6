//! The unit square laid on a source with equal areas, as strata are defined: stated here in their mathematics, apart from
//! the estimator's code, so that variances of strata are predicted and not copied.

use std::f64::consts::FRAC_PI_4;

use glam::DVec3;
use smallvec::SmallVec;

use crate::geometry::partition::{Axes, Partition};
use crate::geometry::{Frame, Polygon, Shape};

/// A place on a source.
#[derive(Clone, Copy, Debug)]
pub(in crate::oracle) struct Place {
    pub position: DVec3,
    /// Unit, to the lit side.
    pub normal: DVec3,
}

/// (u, v) in the unit square to a place; the density per area is one over the area.
#[derive(Clone, Debug)]
pub(in crate::oracle) enum Chart {
    /// centre + (u − ½) edge_u + (v − ½) edge_v.
    Rectangle { center: DVec3, edge_u: DVec3, edge_v: DVec3, normal: DVec3 },
    /// Concentric squares become concentric circles (Shirley & Chiu 1997).
    Disk { center: DVec3, frame: Frame, radius: f64 },
    /// The square folded along its diagonal (Heitz 2019): weights u − m and v − m of the second and third corner,
    /// m = min(u, v)/2.
    Triangle { corners: [DVec3; 3], normal: DVec3 },
    /// u sweeps the area at right angles to the longest edge, v runs along the chord.
    Polygon(Box<Layout>),
    /// Octahedral, each octant a quarter of a concentric disk lifted with equal areas (Clarberg 2008).
    Sphere { center: DVec3, radius: f64 },
}

impl Chart {
    /// `None` for a mesh.
    pub fn of(shape: &Shape) -> Option<Chart> {
        Some(match shape {
            Shape::Rectangle(s) => {
                Chart::Rectangle { center: s.center(), edge_u: s.edge_u(), edge_v: s.edge_v(), normal: s.normal() }
            }
            Shape::Disk(s) => {
                Chart::Disk { center: s.center(), frame: Frame::around(s.normal()), radius: s.radius() }
            }
            Shape::Polygon(s) => match s.vertices() {
                &[a, b, c] => Chart::Triangle { corners: [a, b, c], normal: s.normal() },
                _ => Chart::Polygon(Box::new(Layout::new(s))),
            },
            Shape::Sphere(s) => Chart::Sphere { center: s.center(), radius: s.radius() },
            Shape::Mesh(_) => return None,
        })
    }

    /// Whether the map may have a crease within [u₀, u₁] × [v₀, v₁].
    pub fn is_creased(&self, [u0, u1]: [f64; 2], [v0, v1]: [f64; 2]) -> bool {
        // Whether intervals share more than an end.
        let meet = |a: [f64; 2], b: [f64; 2]| a[0] < b[1] && b[0] < a[1];
        match self {
            Chart::Rectangle { .. } => false,
            Chart::Triangle { .. } => meet([u0, u1], [v0, v1]),
            Chart::Disk { .. } => meet([u0, u1], [v0, v1]) || meet([u0, u1], [1.0 - v1, 1.0 - v0]),
            Chart::Polygon(layout) => layout.is_creased([u0, u1], [v0, v1]),
            Chart::Sphere { .. } => {
                let size = |x: [f64; 2]| {
                    let [a, b] = x.map(|x| (2.0 * x - 1.0).abs());
                    let across = (x[0] < 0.5) != (x[1] < 0.5) && x[1] != 0.5;
                    if across { [0.0, a.max(b)] } else { [a.min(b), a.max(b)] }
                };
                let ([a0, a1], [b0, b1]) = (size([u0, u1]), size([v0, v1]));
                a0 == 0.0 || b0 == 0.0 || (a0 + b0 < 1.0 && a1 + b1 > 1.0)
            }
        }
    }

    pub fn place(&self, u: f64, v: f64) -> Place {
        match self {
            Chart::Rectangle { center, edge_u, edge_v, normal } => {
                Place { position: *center + *edge_u * (u - 0.5) + *edge_v * (v - 0.5), normal: *normal }
            }
            Chart::Disk { center, frame, radius } => {
                let [x, y] = concentric(2.0 * u - 1.0, 2.0 * v - 1.0);
                let offset = frame.tangent * x + frame.bitangent * y;
                Place { position: *center + offset * *radius, normal: frame.normal }
            }
            Chart::Triangle { corners: [a, b, c], normal } => {
                let low = 0.5 * u.min(v);
                Place { position: *a + (*b - *a) * (u - low) + (*c - *a) * (v - low), normal: *normal }
            }
            Chart::Polygon(layout) => Place { position: layout.position(u, v), normal: layout.normal },
            Chart::Sphere { center, radius } => {
                let normal = octahedral(2.0 * u - 1.0, 2.0 * v - 1.0);
                Place { position: *center + normal * *radius, normal }
            }
        }
    }
}

/// From [−1, 1]² to the unit disk: the square of half-side r becomes the circle of radius r, run through evenly.
fn concentric(a: f64, b: f64) -> [f64; 2] {
    let (r, along) = if a.abs() > b.abs() { (a, b) } else { (b, a) };
    if r == 0.0 {
        return [0.0, 0.0];
    }
    let (sin, cos) = (FRAC_PI_4 * along / r).sin_cos();
    if a.abs() > b.abs() { [r * cos, r * sin] } else { [r * sin, r * cos] }
}

/// From [−1, 1]² to the unit sphere. |a| + |b| = 1 is the equator; r is the distance, in that norm, from the nearer pole.
fn octahedral(a: f64, b: f64) -> DVec3 {
    let height = 1.0 - a.abs() - b.abs();
    let r = 1.0 - height.abs();
    let turn = if r == 0.0 { 0.0 } else { FRAC_PI_4 * ((b.abs() - a.abs()) / r + 1.0) };
    let (sin, cos) = turn.sin_cos();
    // 1 − z = r² gives equal areas.
    let ring = r * (2.0 - r * r).sqrt();
    DVec3::new((ring * cos).copysign(a), (ring * sin).copysign(b), (1.0 - r * r).copysign(height))
}

/// A polygon laid out over the unit square: by its chords, or where these jump (at re-entrant corners) cell by cell of a
/// partition, each by its own chords.
#[derive(Clone, Debug)]
pub(in crate::oracle) struct Layout {
    axes: Axes,
    normal: DVec3,
    /// Cells along each side.
    side: usize,
    /// `[u][v]`.
    sweeps: Vec<Sweep>,
}

/// Halvings of either side of the square, where there are cells.
const CELL_LEVELS: u32 = 5;

impl Layout {
    fn new(polygon: &Polygon) -> Layout {
        let axes = Axes::of(polygon);
        let (normal, whole) = (polygon.normal(), Sweep::new(vec![axes.flatten(polygon)]));
        if !whole.is_torn() {
            return Layout { axes, normal, side: 1, sweeps: vec![whole] };
        }
        let partition = Partition::new(polygon, CELL_LEVELS);
        let side = partition.side();
        let sweep = |k: usize| Sweep::new(partition.cell(k / side, k % side).to_vec());
        Layout { axes: *partition.axes(), normal, side, sweeps: (0..side * side).map(sweep).collect() }
    }

    /// The cell of a place in the square, and the place in the cell's own.
    fn cell(&self, u: f64, v: f64) -> (&Sweep, [f64; 2]) {
        let scaled = [u, v].map(|x| x * self.side as f64);
        let [i, j] = scaled.map(|x| (x as usize).min(self.side - 1));
        (&self.sweeps[i * self.side + j], [scaled[0] - i as f64, scaled[1] - j as f64])
    }

    fn position(&self, u: f64, v: f64) -> DVec3 {
        let (sweep, [u, v]) = self.cell(u, v);
        self.axes.place(sweep.position(u, v))
    }

    fn is_creased(&self, u: [f64; 2], v: [f64; 2]) -> bool {
        let side = self.side as f64;
        let one_cell = |x: [f64; 2]| (x[1] * side).ceil() - (x[0] * side).floor() <= 1.0;
        if !(one_cell(u) && one_cell(v)) {
            return true;
        }
        let (sweep, [from, _]) = self.cell(0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]));
        let half = 0.5 * (u[1] - u[0]) * side;
        sweep.before.iter().any(|share| (from - half..from + half).contains(share) && *share > from - half)
    }
}

/// A figure run through by area. Outlines are disjoint and counter-clockwise; coordinates are (across, along).
#[derive(Clone, Debug)]
struct Sweep {
    outlines: Vec<Vec<[f64; 2]>>,
    /// Where corners lie, ascending; and the share of the area before each.
    stops: Vec<f64>,
    before: Vec<f64>,
    area: f64,
}

impl Sweep {
    fn new(outlines: Vec<Vec<[f64; 2]>>) -> Sweep {
        let mut stops: Vec<f64> = outlines.iter().flatten().map(|corner| corner[0]).collect();
        stops.sort_by(f64::total_cmp);
        let size = stops[stops.len() - 1] - stops[0];
        stops.dedup_by(|b, a| *b - *a <= 1e-13 * size);
        let mut sweep = Sweep { outlines, stops, before: vec![0.0], area: 0.0 };
        for k in 1..sweep.stops.len() {
            let (from, to) = (sweep.stops[k - 1], sweep.stops[k]);
            // A trapezium for each piece: the chord in the middle is the mean one.
            sweep.area += (to - from) * sweep.length(0.5 * (from + to), from, to);
            sweep.before.push(sweep.area);
        }
        let area = sweep.area;
        sweep.before.iter_mut().for_each(|share| *share /= area);
        sweep
    }

    /// Whether the chord splits or jumps.
    fn is_torn(&self) -> bool {
        let slabs: Vec<[f64; 2]> = self.stops.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        let chord = |[from, to]: [f64; 2], s: f64| -> Vec<[f64; 2]> { self.chord(s, from, to).collect() };
        let split = slabs.iter().any(|slab| chord(*slab, slab[0]).len() > 1);
        let parted = |pair: &[[f64; 2]]| {
            let (end, start) = (chord(pair[0], pair[0][1]), chord(pair[1], pair[1][0]));
            end.iter().flatten().zip(start.iter().flatten()).any(|(a, b)| (a - b).abs() > 1e-9 * self.area.sqrt())
        };
        split || slabs.windows(2).any(parted)
    }

    /// The chord at `s` within the slab from `from` to `to`: [low, high] of each piece, upwards.
    fn chord(&self, s: f64, from: f64, to: f64) -> impl Iterator<Item = [f64; 2]> {
        let middle = 0.5 * (from + to);
        let edges = self.outlines.iter().flat_map(|o| (0..o.len()).map(move |i| (o[i], o[(i + 1) % o.len()])));
        let mut crossings: SmallVec<[[f64; 2]; 8]> = edges
            .filter_map(|([a, p], [b, q])| {
                let at = |s: f64| p + (q - p) * ((s - a) / (b - a)).clamp(0.0, 1.0);
                ((a < middle) != (b < middle)).then(|| [at(middle), at(s)])
            })
            .collect();
        crossings.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let pairs: SmallVec<[[f64; 2]; 4]> = crossings.chunks_exact(2).map(|pair| [pair[0][1], pair[1][1]]).collect();
        pairs.into_iter()
    }

    fn length(&self, s: f64, from: f64, to: f64) -> f64 {
        self.chord(s, from, to).map(|[low, high]| (high - low).max(0.0)).sum()
    }

    fn position(&self, u: f64, v: f64) -> [f64; 2] {
        let k = self.before.partition_point(|share| *share <= u).clamp(1, self.stops.len() - 1);
        let (from, to) = (self.stops[k - 1], self.stops[k]);
        let (first, last) = (self.length(from, from, to), self.length(to, from, to));
        // first·x + (last − first)·x²/2 of the slab's width, 0 ≤ x ≤ 1, is the area wanted.
        let wanted = ((u - self.before[k - 1]) * self.area / (to - from)).max(0.0);
        let root = (first * first + 2.0 * (last - first) * wanted).max(0.0).sqrt();
        let x = if wanted > 0.0 { (2.0 * wanted / (first + root)).min(1.0) } else { 0.0 };
        let s = from + (to - from) * x;
        let mut left = v * self.length(s, from, to);
        let mut y = 0.0;
        for [low, high] in self.chord(s, from, to) {
            let length = (high - low).max(0.0);
            y = low + left.min(length);
            left -= length;
            if left <= 0.0 {
                break;
            }
        }
        [s, y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octants_meet_and_have_equal_areas() {
        // Archimedes: the share of the square above |a| + |b| = r is r²/2, and the cap above z = 1 − r² has r²/2 of the sphere.
        for (a, b) in [(0.3, 0.2), (-0.5, 0.5), (0.7, -0.9), (0.0, -1.0), (1.0, 1.0)] {
            let p = octahedral(a, b);
            assert!((p.length() - 1.0).abs() < 1e-15);
            let r = (a.abs() + b.abs()).min(2.0 - a.abs() - b.abs());
            assert!((p.z.abs() - (1.0 - r * r)).abs() < 1e-15);
        }
        assert!((octahedral(0.5, 0.5) - DVec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-15);
    }
}
