//! A straight edge as a curve of directions: an arc of a great circle.

use glam::DVec3;

use super::rim::Term;

/// Directions `start cos θ + along sin θ`, 0 ≤ θ ≤ `length` < π; what it bounds lies on the side of `normal`.
#[derive(Clone, Copy, Debug)]
pub(super) struct GreatArc {
    start: DVec3,
    along: DVec3,
    /// Unit directions of the two ends, the same bits for all arcs that share the corner: signs taken of them agree.
    pub ends: [DVec3; 2],
    /// Unit, along `r × dr`.
    pub normal: DVec3,
    /// Radians.
    pub length: f64,
    /// |p| |e| / |p × e|: how much rounding of the edge's points grows in its plane's normal.
    condition: f64,
}

impl GreatArc {
    /// The edge from `p` to `q` on a line that runs along `edge` (whose length does not matter).
    ///
    /// p × edge keeps the digits that p × q loses when the edge is short: `edge` comes from the shape, not from the
    /// difference of two far points. `None` where the line passes through the origin or the edge has no length.
    pub fn of_edge(p: DVec3, q: DVec3, edge: DVec3) -> Option<GreatArc> {
        let normal = p.cross(edge);
        let size = normal.length();
        let product = p.length() * edge.length();
        if size <= f64::EPSILON * product || product == 0.0 {
            return None;
        }
        GreatArc::on_circle(p, q, normal / size, product / size)
    }

    /// The arc from direction `p` to direction `q` on the great circle with unit normal `normal`.
    pub fn on_circle(p: DVec3, q: DVec3, normal: DVec3, condition: f64) -> Option<GreatArc> {
        let start = (p - normal * p.dot(normal)).normalize();
        let along = normal.cross(start);
        let length = q.dot(along).atan2(q.dot(start));
        let ends = [p.normalize(), q.normalize()];
        (length > 0.0).then_some(GreatArc { start, along, ends, normal, length, condition })
    }

    /// Unit direction.
    pub fn point(&self, angle: f64) -> DVec3 {
        let (sin, cos) = angle.sin_cos();
        self.start * cos + self.along * sin
    }
    /// In (−π, π].
    pub fn parameter(&self, direction: DVec3) -> f64 {
        direction.dot(self.along).atan2(direction.dot(self.start))
    }

    /// Angle from a unit direction to the nearest point of the arc (a lower bound, tight where it is small).
    pub fn distance(&self, d: DVec3) -> f64 {
        if (0.0..=self.length).contains(&self.parameter(d)) {
            self.normal.dot(d).abs()
        } else {
            d.distance(self.ends[0]).min(d.distance(self.ends[1]))
        }
    }

    /// ∫ n·(r × dr)/|r|² from one angle to another: `n · normal` times the angle (Lambert, 1760).
    pub fn contour(&self, n: DVec3, from: f64, to: f64) -> Term {
        let angle = to - from;
        // The plane's normal turns about the edge's own direction: for a short edge it may turn far, and moves little.
        let tilt = angle.min(1.0) * self.condition;
        Term { value: n.dot(self.normal) * angle, weight: 0.25 * (from.abs() + to.abs()) + angle + tilt }
    }
}
