//! The curves that bound what is seen of a source, as cones of directions, and where two of them cross.
//!
//! A straight edge is a plane through the eye; a rim, a silhouette or a ball's section by the source's plane is a circle
//! in space, its cone of directions `{r : |k r − (r·w) c|² = a² (r·w)²}`, k = c·w. Along another circle this is a
//! trigonometric polynomial of second degree; its zeros are found by bisection with a bound on its curvature, which
//! leaves none out.
//!
//! Crossings found here only tell where strips are to be parted: one that is off by δ costs δ².

use std::f64::consts::{FRAC_PI_8, PI, TAU};

use glam::DVec3;

use crate::geometry::Frame;

/// A curve on the sphere of directions.
#[derive(Clone, Debug)]
pub(super) enum Curve {
    /// The plane through the eye with this unit normal; between two ends, or all of it.
    Line {
        normal: DVec3,
        ends: Option<[DVec3; 2]>,
    },
    Circle(Circle),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Circle {
    pub center: DVec3,
    /// Unit.
    pub normal: DVec3,
    pub radius: f64,
}

/// Ends of a line count as on it this far out, in units of its length.
const BEYOND: f64 = 1e-6;

impl Curve {
    /// An edge between two points; `None` where it points at the eye.
    pub fn edge(p: DVec3, q: DVec3) -> Option<Curve> {
        let (p, q) = (p.try_normalize()?, q.try_normalize()?);
        Some(Curve::Line { normal: p.cross(q).try_normalize()?, ends: Some([p, q]) })
    }

    /// Adds the directions that two curves share, tangential ones included.
    pub fn cross(&self, other: &Curve, found: &mut Vec<DVec3>) {
        match (self, other) {
            (Curve::Line { normal: a, .. }, Curve::Line { normal: b, .. }) => {
                let d = a.cross(*b);
                found.extend([d, -d].into_iter().filter(|d| self.contains(*d) && other.contains(*d)));
            }
            (Curve::Line { normal, .. }, Curve::Circle(circle))
            | (Curve::Circle(circle), Curve::Line { normal, .. }) => {
                let line = if let Curve::Line { .. } = self { self } else { other };
                found.extend(circle.on_plane(*normal).into_iter().filter(|d| line.contains(*d)));
            }
            (Curve::Circle(a), Curve::Circle(b)) => a.cross(b, found),
        }
    }

    /// Whether a direction on the line's plane lies between its ends.
    fn contains(&self, d: DVec3) -> bool {
        match self {
            Curve::Line { normal, ends: Some([p, q]) } => {
                let d = d.normalize_or_zero();
                let length = p.cross(*q).dot(*normal);
                let (from, to) = (p.cross(d).dot(*normal), d.cross(*q).dot(*normal));
                from >= -BEYOND * length && to >= -BEYOND * length && d.dot(*p + *q) > 0.0
            }
            _ => d != DVec3::ZERO,
        }
    }
}

impl Circle {
    /// A ball's silhouette; `None` from inside.
    pub fn silhouette(center: DVec3, radius: f64) -> Option<Circle> {
        let distance = center.length();
        let shrink = (distance - radius) * (distance + radius) / (distance * distance);
        (shrink > 0.0).then(|| Circle {
            center: center * shrink,
            normal: center / distance,
            radius: radius * shrink.sqrt(),
        })
    }

    /// A ball's section by a plane through `point`.
    pub fn section(center: DVec3, radius: f64, normal: DVec3, point: DVec3) -> Option<Circle> {
        let off = normal.dot(center - point);
        let square = (radius - off) * (radius + off);
        (square > 0.0).then(|| Circle { center: center - normal * off, normal, radius: square.sqrt() })
    }

    fn axes(&self) -> [DVec3; 2] {
        let frame = Frame::around(self.normal);
        [frame.tangent, frame.bitangent]
    }

    /// The points in a plane through the eye: two, which may be one.
    fn on_plane(&self, normal: DVec3) -> Vec<DVec3> {
        let [u, v] = self.axes();
        let (level, swing_u, swing_v) = (normal.dot(self.center), normal.dot(u), normal.dot(v));
        let ratio = -level / (self.radius * swing_u.hypot(swing_v));
        if ratio.is_nan() || ratio.abs() > 1.0 + BEYOND {
            return Vec::new();
        }
        let (middle, half) = (swing_v.atan2(swing_u), ratio.clamp(-1.0, 1.0).acos());
        let at = |angle: f64| self.center + (u * angle.cos() + v * angle.sin()) * self.radius;
        vec![at(middle - half), at(middle + half)]
    }

    /// The two strips' s on which it ends, and the points there, for strips whose planes have the normals A + s B:
    /// (N·c)² = a² (|N|² − (N·w)²).
    pub fn extremes(&self, a: DVec3, b: DVec3) -> [(f64, DVec3); 2] {
        let form = |x: DVec3, y: DVec3| {
            let flat = x.dot(y) - x.dot(self.normal) * y.dot(self.normal);
            x.dot(self.center) * y.dot(self.center) - self.radius * self.radius * flat
        };
        let (square, middle, level) = (form(b, b), form(a, b), form(a, a));
        // Not a number where there is none.
        let root = (middle * middle - square * level).sqrt();
        let far = -(middle + root.copysign(middle));
        [far / square, level / far].map(|s| {
            let across = a + b * s;
            let along = across - self.normal * across.dot(self.normal);
            (s, self.center - along * (across.dot(self.center) / along.length_squared()))
        })
    }

    fn cross(&self, other: &Circle, found: &mut Vec<DVec3>) {
        // Directions do not feel lengths.
        let size = self.center.length() + self.radius;
        let other_size = other.center.length() + other.radius;
        let (c, r) = (other.center / other_size, other.radius / other_size);
        let k = c.dot(other.normal);
        let [u, v] = self.axes();
        let terms = [self.center, u * self.radius, v * self.radius].map(|x| x / size);
        // |A|² − b² with A = k r − (r·w) c and b = a r·w, where r = r₀ + r₁ cos φ + r₂ sin φ.
        let vector = terms.map(|x| x * k - c * x.dot(other.normal));
        let scalar = terms.map(|x| r * x.dot(other.normal));
        let product = |i: usize, j: usize| vector[i].dot(vector[j]) - scalar[i] * scalar[j];
        let polynomial = [
            product(0, 0) + 0.5 * (product(1, 1) + product(2, 2)),
            2.0 * product(0, 1),
            2.0 * product(0, 2),
            0.5 * (product(1, 1) - product(2, 2)),
            product(1, 2),
        ];
        let rounding =
            16.0 * f64::EPSILON * (0..3).map(|i| vector[i].length_squared() + scalar[i].powi(2)).sum::<f64>();
        if polynomial.iter().all(|x| x.abs() <= rounding) {
            // The same cone.
            return;
        }
        for angle in zeros(polynomial, rounding) {
            let d = terms[0] + terms[1] * angle.cos() + terms[2] * angle.sin();
            // The other nappe of the cone lies behind the eye.
            if k * d.dot(other.normal) > 0.0 {
                found.push(d);
            }
        }
    }
}

/// The zeros in [−π, π] of k₀ + k₁ cos φ + k₂ sin φ + k₃ cos 2φ + k₄ sin 2φ, double ones within `NARROWEST` included.
///
/// - `noise`: how far off a value may be
fn zeros(k: [f64; 5], noise: f64) -> Vec<f64> {
    /// Half-width below which an interval that may hold a zero is taken for one.
    const NARROWEST: f64 = 3e-9;
    /// Zeros closer than this are one: what opens between them holds less than its third power.
    const APART: f64 = 1e-7;
    /// Intervals looked at, at most: rounding may make a flat stretch look full of zeros.
    const ENOUGH: usize = 4000;
    let bend = k[1].hypot(k[2]) + 4.0 * k[3].hypot(k[4]);
    let value = |t: f64| {
        let (sin, cos) = t.sin_cos();
        let (sin_2, cos_2) = (2.0 * sin * cos, (cos - sin) * (cos + sin));
        let f = k[0] + k[1] * cos + k[2] * sin + k[3] * cos_2 + k[4] * sin_2;
        (f, k[2] * cos - k[1] * sin + 2.0 * (k[4] * cos_2 - k[3] * sin_2))
    };
    let mut stack: Vec<(f64, f64)> =
        (0..8).rev().map(|i| (-PI + FRAC_PI_8 * (2.0 * f64::from(i) + 1.0), FRAC_PI_8)).collect();
    let mut found: Vec<f64> = Vec::new();
    let mut looked = 0;
    while let Some((middle, half)) = stack.pop() {
        looked += 1;
        let (f, slope) = value(middle);
        if f.abs() > noise + half * (slope.abs() + 0.5 * half * bend) {
            continue;
        }
        if slope.abs() > bend * half {
            let (low, high) = (middle - half, middle + half);
            let (at_low, at_high) = (value(low).0, value(high).0);
            if at_low == 0.0 || (at_low > 0.0) != (at_high > 0.0) {
                found.push(only_zero(low, high, at_low > 0.0, &value));
            }
        } else if half < NARROWEST || looked > ENOUGH {
            found.push(middle);
        } else {
            stack.extend([(middle + 0.5 * half, 0.5 * half), (middle - 0.5 * half, 0.5 * half)]);
        }
    }
    // One double zero is found many times over, wherever rounding takes the value for zero.
    found.dedup_by(|b, a| *b - *a < APART);
    if found.len() > 1 && found[found.len() - 1] - found[0] > TAU - APART {
        found.pop();
    }
    found
}

/// Newton's steps, kept between two ends of different sign.
fn only_zero(mut low: f64, mut high: f64, falls: bool, value: &impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut at = 0.5 * (low + high);
    for _ in 0..60 {
        let (f, slope) = value(at);
        if (f > 0.0) == falls {
            low = at;
        } else {
            high = at;
        }
        let next = at - f / slope;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - at).abs() < 1e-15 {
            return next;
        }
        at = next;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (φ − a)(φ − b) in trigonometric form: sin((φ−a)/2) sin((φ−b)/2) times the same of c and d.
    fn with_zeros(a: f64, b: f64, c: f64, d: f64) -> [f64; 5] {
        // sin((φ−a)/2) sin((φ−b)/2) = (cos((a−b)/2) − cos(φ − (a+b)/2)) / 2
        let (p, q) = ((0.5 * (a - b)).cos(), (0.5 * (c - d)).cos());
        let (m, n) = (0.5 * (a + b), 0.5 * (c + d));
        [
            p * q + 0.5 * (m - n).cos(),
            -p * n.cos() - q * m.cos(),
            -p * n.sin() - q * m.sin(),
            0.5 * (m + n).cos(),
            0.5 * (m + n).sin(),
        ]
    }

    #[test]
    fn all_zeros_are_found_however_close() {
        for gap in [1.0, 1e-2, 1e-4, 1e-6] {
            let found = zeros(with_zeros(-2.0, -2.0 + gap, 1.0, 2.5), 1e-15);
            let expected = [-2.0, -2.0 + gap, 1.0, 2.5];
            assert_eq!(found.len(), 4, "{gap}: {found:?}");
            for (f, e) in found.iter().zip(expected) {
                assert!((f - e).abs() < 1e-14 / gap, "{gap}: {f} against {e}");
            }
        }
        assert_eq!(zeros(with_zeros(0.3, 0.3, -1.0, -1.0), 1e-15).len(), 2);
        assert_eq!(zeros([1.0, 0.5, 0.0, 0.0, 0.2], 1e-15).len(), 0);
    }

    #[test]
    fn a_small_circle_in_a_large_one_meets_it_nowhere_or_where_it_touches() {
        let circle = |x: f64, radius: f64| Circle { center: DVec3::new(x, 0.0, 1.0), normal: -DVec3::Z, radius };
        let count = |x: f64, radius: f64| {
            let mut found = Vec::new();
            circle(0.0, 1.0).cross(&circle(x, radius), &mut found);
            found.len()
        };
        assert_eq!(
            [count(0.3, 0.5), count(0.5, 0.5), count(0.7, 0.5), count(1.5, 0.5), count(2.0, 0.5)],
            [0, 1, 2, 1, 0]
        );
    }
}
