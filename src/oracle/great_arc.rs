//! A straight edge as a curve of directions: an arc of a great circle.

use glam::DVec3;

use super::rim::Term;
use crate::number::{Number, Vector};

/// Directions `start cos θ + along sin θ`, 0 ≤ θ ≤ `length` < π; what it bounds lies on the side of `normal`.
#[derive(Clone, Copy, Debug)]
pub(super) struct GreatArc<T = f64> {
    start: Vector<T>,
    along: Vector<T>,
    /// Unit directions of the two ends, the same bits for all arcs that share the corner: signs taken of them agree.
    pub ends: [Vector<T>; 2],
    /// Unit, along `r × dr`.
    pub normal: Vector<T>,
    /// Radians.
    pub length: T,
    /// |p| |e| / |p × e|: how much rounding of the edge's points grows in its plane's normal.
    condition: f64,
}

impl<T: Number> GreatArc<T> {
    /// The edge from `p` to `q`, that share of a line.
    ///
    /// p × line keeps the digits that p × q loses when the edge is short: `line` comes from the shape, not from the
    /// difference of two far points. `None` where the line passes through the origin or the edge has no length.
    ///
    /// - `share`: q − p in units of `line`, > 0
    /// - `ends`: the directions of `p` and `q`
    #[inline]
    pub fn of_edge([p, q]: [Vector<T>; 2], line: Vector<T>, share: T, ends: [Vector<T>; 2]) -> Option<GreatArc<T>> {
        let normal = p.cross(line);
        let size = normal.length();
        let product = (p.length_squared().primal() * line.length_squared().primal()).sqrt();
        if size.primal() <= f64::EPSILON * product || product == 0.0 {
            return None;
        }
        // |p × q| and p · q of the angle between them.
        let length = (size * share).atan2(p.dot(q));
        let scale = T::constant(1.0) / size;
        GreatArc::new(normal * scale, length, ends, product * scale.primal())
    }

    /// The arc from direction `p` to direction `q` on the great circle with unit normal `normal`.
    pub fn on_circle(p: Vector<T>, q: Vector<T>, normal: Vector<T>) -> Option<GreatArc<T>> {
        let length = normal.dot(p.cross(q)).atan2(p.dot(q));
        GreatArc::new(normal, length, [p.normalize(), q.normalize()], 1.0)
    }

    #[inline]
    fn new(normal: Vector<T>, length: T, ends: [Vector<T>; 2], condition: f64) -> Option<GreatArc<T>> {
        let start = (ends[0] - normal * ends[0].dot(normal)).normalize();
        let along = normal.cross(start);
        (length.primal() > 0.0).then_some(GreatArc { start, along, ends, normal, length, condition })
    }

    /// Unit direction.
    pub fn point(&self, angle: T) -> Vector<T> {
        let (sin, cos) = angle.sin_cos();
        self.start * cos + self.along * sin
    }
    /// In (−π, π].
    pub fn parameter(&self, direction: Vector<T>) -> T {
        direction.dot(self.along).atan2(direction.dot(self.start))
    }

    /// ∫ n·(r × dr)/|r|² from one angle to another: `n · normal` times the angle (Lambert, 1760).
    pub fn contour(&self, n: Vector<T>, from: T, to: T) -> Term<T> {
        let angle = to - from;
        let value = n.dot(self.normal) * angle;
        let angle = angle.primal();
        // The plane's normal turns about the edge's own direction: for a short edge it may turn far, and moves little.
        let tilt = angle.min(1.0) * self.condition;
        Term { value, weight: 0.25 * (from.primal().abs() + to.primal().abs()) + angle + tilt, count: 1 }
    }
}

impl GreatArc {
    /// Angle from a unit direction to the nearest point of the arc (a lower bound, tight where it is small).
    pub fn distance(&self, d: DVec3) -> f64 {
        let t = self.parameter(Vector::constant(d));
        if (0.0..=self.length).contains(&t) {
            self.normal.primal().dot(d).abs()
        } else {
            d.distance(self.ends[0].primal()).min(d.distance(self.ends[1].primal()))
        }
    }
}
