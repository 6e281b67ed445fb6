//! Closed convex bodies of glass as rays meet them.
//!
//! Whether a ray is inside is known, not asked of its coordinates: from outside it can only enter, and not the body that it
//! has just left; from inside it can only leave, and always does.

use super::face::{ball, ball_ahead};
use crate::configuration::GlassShape;
use crate::geometry::DVec3;

/// A body, prepared.
#[derive(Clone, Debug)]
pub(super) enum Body {
    Ball {
        center: DVec3,
        radius: f64,
    },
    /// Three pairs of parallel faces: unit normals, and the distance of either face from the centre.
    Box {
        center: DVec3,
        normals: [DVec3; 3],
        halves: [f64; 3],
    },
    /// The part of a ball at least `height` from its centre against the axis.
    Lens {
        center: DVec3,
        radius: f64,
        axis: DVec3,
        height: f64,
    },
}

/// A face of a body: of a ball 0; of a lens 0 (curved) or 1 (flat); of a box 2k for the face against the k-th normal, 2k + 1
/// for the one along it.
pub(crate) type Part = u8;

impl Body {
    pub fn new(shape: &GlassShape) -> Body {
        match shape {
            GlassShape::Sphere(s) => Body::Ball { center: s.center(), radius: s.radius() },
            GlassShape::Slab(s) => {
                let middle = s.middle();
                let (u, v, n) = (middle.edge_u(), middle.edge_v(), middle.normal());
                let side = |edge: DVec3, other: DVec3| {
                    let normal = other.cross(n).normalize();
                    let half = 0.5 * edge.dot(normal);
                    if half < 0.0 { (-normal, -half) } else { (normal, half) }
                };
                let ((a, half_a), (b, half_b)) = (side(u, v), side(v, u));
                let halves = [0.5 * s.thickness(), half_a, half_b];
                Body::Box { center: middle.center(), normals: [n, a, b], halves }
            }
            GlassShape::PlanoConvex(s) => {
                let (radius, rim) = (s.curvature_radius(), s.rim_radius());
                let height = ((radius - rim) * (radius + rim)).sqrt();
                Body::Lens { center: s.curvature_center(), radius, axis: s.axis(), height }
            }
        }
    }

    /// Whether a point lies inside.
    pub fn holds(&self, point: DVec3) -> bool {
        match self {
            Body::Ball { center, radius } => (point - *center).length() < *radius,
            Body::Box { center, normals, halves } => {
                normals.iter().zip(halves).all(|(normal, half)| (point - *center).dot(*normal).abs() < *half)
            }
            Body::Lens { center, radius, axis, height } => {
                let offset = point - *center;
                offset.length() < *radius && offset.dot(*axis) < -height
            }
        }
    }

    /// Where a ray from outside enters: metres along it, greater than nought, and the face.
    #[inline(always)]
    pub fn enter(&self, from: DVec3, direction: DVec3) -> Option<(f64, Part)> {
        match self {
            Body::Ball { center, radius } => {
                let near = ball_ahead(from - *center, direction, *radius)?;
                (near > 0.0).then_some((near, 0))
            }
            Body::Box { center, normals, halves } => {
                let offset = from - *center;
                let (mut first, mut last, mut part) = (f64::NEG_INFINITY, f64::INFINITY, 0);
                for k in 0..3 {
                    let (height, way) = (offset.dot(normals[k]), direction.dot(normals[k]));
                    if way == 0.0 {
                        if height.abs() >= halves[k] {
                            return None;
                        }
                        continue;
                    }
                    let (a, b) = ((-halves[k] - height) / way, (halves[k] - height) / way);
                    let (enters, leaves) = if way > 0.0 { (a, b) } else { (b, a) };
                    if enters > first {
                        (first, part) = (enters, 2 * k as Part + Part::from(way < 0.0));
                    }
                    last = last.min(leaves);
                }
                (first > 0.0 && first < last).then_some((first, part))
            }
            Body::Lens { center, radius, axis, height } => {
                let offset = from - *center;
                let [near, far] = ball(offset, direction, *radius, false);
                if far <= 0.0 {
                    return None;
                }
                let (level, way) = (offset.dot(*axis) + height, direction.dot(*axis));
                let (mut first, mut last, mut part) = (near, far, 0);
                if way > 0.0 {
                    last = last.min(-level / way);
                } else if way < 0.0 {
                    let crosses = -level / way;
                    if crosses > first {
                        (first, part) = (crosses, 1);
                    }
                } else if level >= 0.0 {
                    return None;
                }
                (first > 0.0 && first < last).then_some((first, part))
            }
        }
    }

    /// Where a ray from inside leaves: metres along it, at least nought, and the face.
    ///
    /// - `left`: the face that it starts on, if it starts on one
    #[inline(always)]
    pub fn leave(&self, from: DVec3, direction: DVec3, left: Option<Part>) -> (f64, Part) {
        // Rounding may put a starting point a hair outside: then the ray leaves at once.
        let far = |offset: DVec3, radius: f64| {
            if left == Some(0) {
                return (-2.0 * offset.dot(direction)).max(0.0);
            }
            let middle = -offset.dot(direction);
            let apart = (offset + direction * middle).length_squared();
            (middle + (radius * radius - apart).max(0.0).sqrt()).max(0.0)
        };
        match self {
            Body::Ball { center, radius } => (far(from - *center, *radius), 0),
            Body::Box { center, normals, halves } => {
                let offset = from - *center;
                let mut found = (f64::INFINITY, 0);
                for k in 0..3 {
                    let way = direction.dot(normals[k]);
                    let part = 2 * k as Part + Part::from(way > 0.0);
                    if way == 0.0 || left == Some(part) {
                        continue;
                    }
                    let t = ((halves[k].copysign(way) - offset.dot(normals[k])) / way).max(0.0);
                    if t < found.0 {
                        found = (t, part);
                    }
                }
                found
            }
            Body::Lens { center, radius, axis, height } => {
                let offset = from - *center;
                let way = direction.dot(*axis);
                let curved = far(offset, *radius);
                if way > 0.0 && left != Some(1) {
                    let flat = (-(offset.dot(*axis) + height) / way).max(0.0);
                    if flat < curved {
                        return (flat, 1);
                    }
                }
                (curved, 0)
            }
        }
    }

    /// The outward unit normal of a face at a point of it.
    #[inline(always)]
    pub fn normal(&self, part: Part, at: DVec3) -> DVec3 {
        match self {
            Body::Ball { center, .. } => (at - *center).normalize(),
            Body::Box { normals, .. } => {
                let normal = normals[usize::from(part / 2)];
                if part % 2 == 1 { normal } else { -normal }
            }
            Body::Lens { center, axis, .. } => {
                if part == 1 {
                    *axis
                } else {
                    (at - *center).normalize()
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{PlanoConvex, Rectangle, Slab, Sphere};

    fn bodies() -> [Body; 3] {
        let plate = Rectangle::new(DVec3::ZERO, DVec3::new(2.0, 1.0, 0.0), DVec3::new(-0.5, 1.0, 0.0)).unwrap();
        [
            GlassShape::Sphere(Sphere::new(DVec3::new(0.1, 0.0, 0.0), 0.7).unwrap()),
            GlassShape::Slab(Slab::new(plate, 0.4).unwrap()),
            GlassShape::PlanoConvex(PlanoConvex::new(DVec3::Z * -0.3, DVec3::Z, 1.0, 0.8).unwrap()),
        ]
        .map(|shape| Body::new(&shape))
    }

    /// What enters leaves, in between is inside, and before and after is not.
    #[test]
    fn a_line_crosses_a_convex_body_once() {
        for body in bodies() {
            let mut crossings = 0;
            for k in 0..2000 {
                let turn = f64::from(k) * 2.399_963;
                let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / 2000.0;
                let ring = (1.0 - z * z).sqrt();
                let from = DVec3::new(ring * turn.cos(), ring * turn.sin(), z) * 3.0;
                let target = DVec3::new((0.7 * turn).sin(), (1.3 * turn).cos(), (0.3 * turn).sin()) * 0.6;
                let d = (target - from).normalize();
                let Some((enters, part)) = body.enter(from, d) else {
                    assert!((0..200).all(|i| !body.holds(from + d * (f64::from(i) * 0.03))), "{body:?} is missed");
                    continue;
                };
                crossings += 1;
                let at = from + d * enters;
                assert!(body.normal(part, at).dot(d) < 0.0);
                let (length, out) = body.leave(at, d, Some(part));
                assert!(length > 0.0 && length.is_finite());
                assert!(body.normal(out, at + d * length).dot(d) > 0.0);
                for share in [1e-9, 0.3, 0.7, 1.0 - 1e-9] {
                    assert!(body.holds(at + d * (length * share)), "{body:?}");
                }
                let (before, after) = (from + d * (enters - 1e-9), at + d * (length + 1e-9));
                assert!(!body.holds(before) && !body.holds(after));
                // From within, without a face: the same way out.
                let (rest, same) = body.leave(at + d * (0.5 * length), d, None);
                assert!((rest - 0.5 * length).abs() < 1e-13 && same == out);
                // Turned inwards at the way out, it leaves by another place.
                let n = body.normal(out, at + d * length);
                let back = d - n * (2.0 * d.dot(n));
                let (again, _) = body.leave(at + d * length, back, Some(out));
                assert!(body.holds(at + d * length + back * (0.5 * again)));
            }
            assert!(crossings > 300, "{body:?}: {crossings}");
        }
    }
}
