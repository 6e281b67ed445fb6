//! Where two boundary curves meet. Each crossing is found once, as one direction, and handed to both curves: roots found
//! separately would leave the contour open.

use std::f64::consts::TAU;

use glam::DVec3;

use super::great_arc::GreatArc;
use super::piece::Curve;
use super::rim::{Rim, RimRoots};
use super::trigonometric::Trigonometric;
use crate::number::{Number, Vector};

/// Curves of one kind that nowhere part by more than this (radians) are one curve: more than the rounding of a
/// direction, less than anything that a shape means.
const COINCIDENT: f64 = 64.0 * f64::EPSILON;
/// Two crossings on either side of a contact, this near to each other (radians of rim), are the contact: what lies
/// between is thinner than rounding, and dropping both is felt in the cube of this.
const CONTACT: f64 = 1.0 / (1u32 << 22) as f64;
/// Beyond the ends of a curve: a split too many harms nothing, a missing one opens the contour.
const OVERHANG: f64 = 1e-12;

/// How two curves lie to one another, beside their crossings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Meeting {
    /// They run along the same circle; whether they also bound it on the same side.
    pub along: Option<bool>,
    /// They touch, or one ends on the other: moved a little, they would cross differently.
    pub touching: bool,
}

/// Reports each crossing as (parameter on `a`, parameter on `b`). Where the two run along the same circle, the ends of
/// each are reported where they lie on the other.
pub(super) fn crossings(a: &Curve, b: &Curve, mut found: impl FnMut(f64, f64)) -> Meeting {
    match (a, b) {
        (Curve::Straight(p), Curve::Straight(q)) => straight_straight(p, q, &mut found),
        (Curve::Straight(p), Curve::Round { rim, from, to }) => straight_round(p, rim, *from, *to, &mut found),
        (Curve::Round { rim, from, to }, Curve::Straight(q)) => {
            straight_round(q, rim, *from, *to, |s, t| found(t, s))
        }
        (Curve::Round { .. }, Curve::Round { .. }) => round_round(a, b, &mut found),
    }
}

/// A crossing whose direction is known to the digits of an `f64`, to all the digits (and slopes) of a number.
pub(super) fn refined<T: Number>(a: &Curve<T>, b: &Curve<T>, near: DVec3) -> Vector<T> {
    match (a, b) {
        (Curve::Straight(p), Curve::Straight(q)) => {
            let direction = p.normal.cross(q.normal);
            if direction.primal().dot(near) < 0.0 { -direction } else { direction }
        }
        (Curve::Straight(edge), Curve::Round { rim, .. }) | (Curve::Round { rim, .. }, Curve::Straight(edge)) => {
            let RimRoots { middle, half, .. } = rim.roots(edge.normal, edge.normal.dot(rim.center));
            let [first, second] = [middle - half, middle + half].map(|t| rim.point(t));
            let nearness = |p: Vector<T>| p.primal().normalize().dot(near);
            if nearness(first) > nearness(second) { first } else { second }
        }
        (Curve::Round { rim: path, .. }, Curve::Round { rim: cone, .. }) => {
            let mantle = Mantle::along(path, cone);
            let mut t = T::constant(path.angle(Vector::constant(near)).primal());
            for _ in 0..T::NEWTON_STEPS {
                let (value, slope) = mantle.outside(t);
                t = t - value / slope;
            }
            path.point(t)
        }
    }
}

/// The parameter of `t` that lies in a rim's range, if any does (with a little overhang, then moved to the end).
fn within(t: f64, from: f64, to: f64, overhang: f64) -> Option<f64> {
    let turns = ((from - overhang - t) / TAU).ceil();
    let t = t + turns * TAU;
    (t <= to + overhang).then(|| t.clamp(from, to))
}

fn straight_straight(a: &GreatArc, b: &GreatArc, found: &mut impl FnMut(f64, f64)) -> Meeting {
    let ([a_start, a_end], [b_start, b_end]) = (a.ends, b.ends);
    let (s0, s1) = (a.normal.dot(b_start), a.normal.dot(b_end));
    let (r0, r1) = (b.normal.dot(a_start), b.normal.dot(a_end));
    if s0.abs().max(s1.abs()).max(r0.abs()).max(r1.abs()) <= COINCIDENT {
        for (on_b, direction) in [(0.0, b_start), (b.length, b_end)] {
            let t = a.parameter(direction);
            if t > 0.0 && t < a.length {
                found(t, on_b);
            }
        }
        for (on_a, direction) in [(0.0, a_start), (a.length, a_end)] {
            let t = b.parameter(direction);
            if t > 0.0 && t < b.length {
                found(on_a, t);
            }
        }
        return Meeting { along: Some(a.normal.dot(b.normal) > 0.0), touching: true };
    }
    // One ends on the other's circle, between the other's ends or at one of them.
    let touching = s0.abs().min(s1.abs()).min(r0.abs().min(r1.abs())) <= COINCIDENT
        && s0.min(s1) <= COINCIDENT
        && s0.max(s1) >= -COINCIDENT
        && r0.min(r1) <= COINCIDENT
        && r0.max(r1) >= -COINCIDENT;
    let meeting = Meeting { along: None, touching };
    // Signs at shared corners agree from edge to edge, so an outline is crossed an even number of times.
    if (s0 >= 0.0) == (s1 >= 0.0) || (r0 >= 0.0) == (r1 >= 0.0) {
        return meeting;
    }
    let on_b = b_start * s1.abs() + b_end * s0.abs();
    let on_a = a_start * r1.abs() + a_end * r0.abs();
    if on_a.dot(on_b) > 0.0 {
        found(a.parameter(on_b).clamp(0.0, a.length), b.parameter(on_b).clamp(0.0, b.length));
    }
    meeting
}

/// `found(parameter on the edge, parameter on the rim)`.
fn straight_round(edge: &GreatArc, rim: &Rim, from: f64, to: f64, mut found: impl FnMut(f64, f64)) -> Meeting {
    let mut meeting = Meeting::default();
    // The margin bounds the distance to the rim from below: most edges of a long outline end here.
    if rim.margin(edge.ends[0].primal()).abs() > edge.length + OVERHANG {
        return meeting;
    }
    // Along the rim, the height over the edge's plane is level + swing cos(t − middle).
    let level = edge.normal.dot(rim.center);
    let (pu, pv) = (edge.normal.dot(rim.u), edge.normal.dot(rim.v));
    let size = Number::hypot(pu, pv);
    let swing = rim.radius * size;
    let root = ((swing - level) * (swing + level)).max(0.0).sqrt();
    let is_crossed = level.abs() < swing && root >= CONTACT * swing;
    if !is_crossed {
        meeting.touching = (level.abs() - swing).abs() <= COINCIDENT * rim.center.length() && {
            let lowest = if level < 0.0 { 1.0 } else { -1.0 };
            let t = (lowest * pv).atan2(lowest * pu);
            let angle = edge.parameter(rim.point(t));
            within(t, from, to, CONTACT).is_some() && angle >= -CONTACT && angle <= edge.length + CONTACT
        };
        return meeting;
    }
    let overhang = OVERHANG + 64.0 * f64::EPSILON * swing / root;
    let (cos_middle, sin_middle) = (pu / size, pv / size);
    for sin_half in [-root / swing, root / swing] {
        let cos_half = -level / swing;
        let cos = cos_middle * cos_half - sin_middle * sin_half;
        let sin = sin_middle * cos_half + cos_middle * sin_half;
        let angle = edge.parameter(rim.at((sin, cos)));
        if angle < -overhang || angle > edge.length + overhang {
            continue;
        }
        let Some(on_rim) = within(sin.atan2(cos), from, to, overhang) else { continue };
        meeting.touching |= angle <= overhang || angle >= edge.length - overhang || at_end(on_rim, from, to);
        found(angle.clamp(0.0, edge.length), on_rim);
    }
    meeting
}

/// Whether a parameter is an end of an open arc.
fn at_end(t: f64, from: f64, to: f64) -> bool {
    to - from < TAU && (t - from).min(to - t) <= OVERHANG
}

/// A direction's coordinates against the cone over a rim: on its mantle where `hypot(x[0], x[1]) = x[2]`.
struct Mantle<T>([[T; 3]; 3]);

impl<T: Number> Mantle<T> {
    /// Along another rim each coordinate is `k0 + k1 cos t + k2 sin t`.
    fn along(path: &Rim<T>, cone: &Rim<T>) -> Mantle<T> {
        let row = |p: Vector<T>| [p.dot(path.center), path.radius * p.dot(path.u), path.radius * p.dot(path.v)];
        Mantle([
            row(cone.u * cone.height - cone.axis * cone.offset),
            row(cone.v * cone.height - cone.axis * cone.aside),
            row(cone.axis * cone.radius),
        ])
    }

    /// Distance from the mantle and its slope; negative inside, and on the forward side only.
    fn outside(&self, t: T) -> (T, T) {
        self.outside_at(t.sin_cos())
    }

    fn outside_at(&self, (sin, cos): (T, T)) -> (T, T) {
        let value = |k: &[T; 3]| k[0] + k[1] * cos + k[2] * sin;
        let slope = |k: &[T; 3]| k[2] * cos - k[1] * sin;
        let [x, y, z] = &self.0;
        let out = value(x).hypot(value(y));
        (out - value(z), (value(x) * slope(x) + value(y) * slope(y)) / out - slope(z))
    }
}

impl Mantle<f64> {
    fn polynomial(&self) -> Trigonometric {
        let mut f = Trigonometric::ZERO;
        f.add_square(self.0[0], 1.0);
        f.add_square(self.0[1], 1.0);
        f.add_square(self.0[2], -1.0);
        f
    }

    /// A root of the polynomial, which also knows the backward half of the cone, brought to the last bits on the mantle.
    fn polished(&self, t: f64) -> Option<f64> {
        let (sin, cos) = t.sin_cos();
        let [k0, k1, k2] = self.0[2];
        if k0 + k1 * cos + k2 * sin <= 0.0 {
            return None;
        }
        let (mut t, (mut value, mut slope)) = (t, self.outside_at((sin, cos)));
        for _ in 0..3 {
            let next = t - value / slope;
            let (closer, steeper) = self.outside(next);
            let is_better = (next - t).abs() < 1e-4 && closer.abs() < value.abs();
            if !is_better {
                break;
            }
            (t, value, slope) = (next, closer, steeper);
        }
        Some(t)
    }
}

fn round_round(a: &Curve, b: &Curve, found: &mut impl FnMut(f64, f64)) -> Meeting {
    let (Curve::Round { rim: first, from: a0, to: a1 }, Curve::Round { rim: second, from: b0, to: b1 }) = (a, b)
    else {
        return Meeting::default();
    };
    // Five points fix a polynomial of degree two: all on the mantle, all of the circle is.
    let apart = |t: f64| second.margin(first.point(t).primal().normalize()).abs();
    if (0..5).all(|i| apart(TAU * f64::from(i) / 5.0) <= COINCIDENT) {
        for end in [*b0, *b1] {
            if let Some(t) = within(first.angle(second.point(end)), *a0, *a1, 0.0) {
                found(t, end);
            }
        }
        for end in [*a0, *a1] {
            if let Some(t) = within(second.angle(first.point(end)), *b0, *b1, 0.0) {
                found(end, t);
            }
        }
        return Meeting { along: Some(true), touching: true };
    }
    let mantle = Mantle::along(first, second);
    let roots = mantle.polynomial().roots();
    let mut pairs = [(0.0, 0.0); 4];
    let mut count = 0;
    for root in roots.as_slice() {
        if let Some(t) = mantle.polished(*root) {
            pairs[count] = (t, second.angle(first.point(t)));
            count += 1;
        }
    }
    let pairs = &pairs[..count];
    let near = |s: f64, t: f64| {
        let gap = (s - t).rem_euclid(TAU);
        gap.min(TAU - gap) < CONTACT
    };
    let is_contact =
        |i: usize| pairs.iter().enumerate().any(|(j, p)| j != i && near(p.0, pairs[i].0) && near(p.1, pairs[i].1));
    let mut meeting = Meeting::default();
    for (i, (s, t)) in pairs.iter().enumerate() {
        if let (Some(s), Some(t)) = (within(*s, *a0, *a1, OVERHANG), within(*t, *b0, *b1, OVERHANG)) {
            let is_contact = is_contact(i);
            meeting.touching |= is_contact || at_end(s, *a0, *a1) || at_end(t, *b0, *b1);
            // An odd cluster is a crossing after all.
            if !(is_contact && count % 2 == 0) {
                found(s, t);
            }
        }
    }
    meeting
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disk(center: [f64; 3], normal: [f64; 3], radius: f64) -> Curve {
        let vector = |v: [f64; 3]| Vector::new(v[0], v[1], v[2]);
        let rim = Rim::of_disk(vector(center), vector(normal).normalize(), radius).unwrap();
        Curve::Round { rim, from: 0.0, to: TAU }
    }

    fn all(a: &Curve, b: &Curve) -> Vec<(f64, f64)> {
        let mut list = Vec::new();
        assert_eq!(crossings(a, b, |s, t| list.push((s, t))), Meeting::default());
        list
    }

    #[test]
    fn two_rims_cross_at_one_direction_each() {
        let a = disk([0.2, 0.1, 2.0], [0.0, 0.0, 1.0], 1.0);
        let b = disk([0.3, 0.3, 1.0], [0.5, -0.3, 1.0], 0.4);
        let list = all(&a, &b);
        assert_eq!(list.len(), 2);
        for (s, t) in list {
            assert!((a.point(s).normalize() - b.point(t).normalize()).length() < 4e-16);
        }
    }

    #[test]
    fn a_thin_ellipse_crosses_a_circle_four_times() {
        let a = disk([0.0, 0.0, 20.0], [0.0, 0.0, 1.0], 10.0);
        let b = disk([0.0, 0.0, 20.0], [1.0, 0.0, 0.3], 12.0);
        assert_eq!(all(&a, &b).len(), 4);
    }

    #[test]
    fn the_backward_half_of_a_cone_is_not_met() {
        let a = disk([0.0, 0.0, 2.0], [0.0, 0.0, 1.0], 1.0);
        let b = disk([0.5, 0.0, -1.0], [0.0, 0.0, 1.0], 0.5);
        assert!(all(&a, &b).is_empty());
    }

    #[test]
    fn a_shadow_that_fits_its_source_coincides_with_it() {
        let a = disk([0.25, 0.0, 2.0], [0.0, 0.0, 1.0], 1.0);
        let b = disk([0.125, 0.0, 1.0], [0.0, 0.0, -1.0], 0.5);
        assert_eq!(crossings(&a, &b, |_, _| {}), Meeting { along: Some(true), touching: true });
    }
}
