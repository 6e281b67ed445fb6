//! The unit square laid on a source with equal areas, as strata are defined: stated here in their mathematics, apart from
//! the estimator's code, so that variances of strata are predicted and not copied.

use std::f64::consts::FRAC_PI_4;

use glam::DVec3;

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
    Polygon(Sweep),
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
                _ => Chart::Polygon(Sweep::new(s)),
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
            Chart::Polygon(sweep) => sweep.before.iter().any(|share| meet([u0, u1], [*share, *share])),
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
            Chart::Polygon(sweep) => Place { position: sweep.position(u, v), normal: sweep.normal },
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

/// A polygon run through by area.
#[derive(Clone, Debug)]
pub(in crate::oracle) struct Sweep {
    origin: DVec3,
    across: DVec3,
    along: DVec3,
    normal: DVec3,
    /// Corners in the plane: (across, along).
    corners: Vec<[f64; 2]>,
    /// Where corners lie, ascending; and the share of the area before each.
    stops: Vec<f64>,
    before: Vec<f64>,
    area: f64,
}

impl Sweep {
    fn new(polygon: &Polygon) -> Sweep {
        let vertices = polygon.vertices();
        let n = vertices.len();
        let edge = |i: usize| vertices[(i + 1) % n] - vertices[i];
        // Of several longest edges the last.
        let mut longest = edge(0);
        for i in 1..n {
            if edge(i).length_squared() >= longest.length_squared() {
                longest = edge(i);
            }
        }
        let along = longest.normalize();
        let across = along.cross(polygon.normal());
        let origin = vertices[0];
        let corners: Vec<[f64; 2]> =
            vertices.iter().map(|p| [(*p - origin).dot(across), (*p - origin).dot(along)]).collect();
        let mut stops: Vec<f64> = corners.iter().map(|c| c[0]).collect();
        stops.sort_by(f64::total_cmp);
        let size = stops[n - 1] - stops[0];
        stops.dedup_by(|b, a| *b - *a <= 1e-13 * size);
        let mut sweep =
            Sweep { origin, across, along, normal: polygon.normal(), corners, stops, before: vec![0.0], area: 0.0 };
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

    /// The chord at `s` within the slab from `from` to `to`: [low, high] of each piece, upwards.
    fn chord(&self, s: f64, from: f64, to: f64) -> impl Iterator<Item = [f64; 2]> {
        let middle = 0.5 * (from + to);
        let n = self.corners.len();
        let mut crossings: smallvec::SmallVec<[[f64; 2]; 8]> = (0..n)
            .filter_map(|i| {
                let ([a, p], [b, q]) = (self.corners[i], self.corners[(i + 1) % n]);
                let at = |s: f64| p + (q - p) * ((s - a) / (b - a)).clamp(0.0, 1.0);
                ((a < middle) != (b < middle)).then(|| [at(middle), at(s)])
            })
            .collect();
        crossings.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let pairs: smallvec::SmallVec<[[f64; 2]; 4]> =
            crossings.chunks_exact(2).map(|pair| [pair[0][1], pair[1][1]]).collect();
        pairs.into_iter()
    }

    fn length(&self, s: f64, from: f64, to: f64) -> f64 {
        self.chord(s, from, to).map(|[low, high]| (high - low).max(0.0)).sum()
    }

    fn position(&self, u: f64, v: f64) -> DVec3 {
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
        self.origin + self.across * s + self.along * y
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
