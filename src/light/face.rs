//! Surfaces without thickness as rays meet them.
//!
//! A ray that starts on a surface knows it: the meeting at distance nought is left out by name, not by an offset. On a
//! curved one the other root is left, which the quadratic without its constant term gives without cancellation.

use crate::geometry::{Cylinder, DVec3, Disk, Frame, Paraboloid, Polygon, Rectangle, Sphere, SphereCap};

/// An edge of a flat outline: it spans y in [low, high) and lies at x = at_zero + slope · y.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    low: f64,
    high: f64,
    at_zero: f64,
    slope: f64,
}

/// A surface, prepared.
#[derive(Clone, Debug)]
pub(super) enum Face {
    /// Inside where both dual coordinates are below ½ in size.
    Parallelogram {
        center: DVec3,
        normal: DVec3,
        dual_u: DVec3,
        dual_v: DVec3,
    },
    Disk {
        center: DVec3,
        normal: DVec3,
        radius_squared: f64,
    },
    Polygon {
        anchor: DVec3,
        frame: Frame,
        edges: Vec<Edge>,
    },
    Ball {
        center: DVec3,
        radius: f64,
    },
    /// Of a sphere, what lies at least `height` from its centre along the axis.
    Cap {
        center: DVec3,
        radius: f64,
        axis: DVec3,
        height: f64,
    },
    /// Of a cylinder, what lies within `half_height` and at least `least` towards one side.
    Wall {
        center: DVec3,
        axis: DVec3,
        radius: f64,
        half_height: f64,
        toward: DVec3,
        least: f64,
    },
    /// r² = four_f z up to z = depth.
    Dish {
        vertex: DVec3,
        axis: DVec3,
        four_f: f64,
        depth: f64,
    },
}

/// Which rays meet a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sides {
    Both,
    /// Those that arrive against the normal; a ball's is outwards.
    Front,
}

impl Face {
    pub fn rectangle(s: &Rectangle) -> Face {
        let across = s.edge_u().cross(s.edge_v());
        let over = 1.0 / across.length_squared();
        Face::Parallelogram {
            center: s.center(),
            normal: s.normal(),
            dual_u: s.edge_v().cross(across) * over,
            dual_v: across.cross(s.edge_u()) * over,
        }
    }
    pub fn disk(s: &Disk) -> Face {
        Face::Disk { center: s.center(), normal: s.normal(), radius_squared: s.radius() * s.radius() }
    }
    pub fn polygon(vertices: &[DVec3], normal: DVec3) -> Face {
        let (anchor, frame) = (vertices[0], Frame::around(normal));
        let flat: Vec<[f64; 2]> =
            vertices.iter().map(|v| [(*v - anchor).dot(frame.tangent), (*v - anchor).dot(frame.bitangent)]).collect();
        let edge = |i: usize| {
            let (a, b) = (flat[i], flat[(i + 1) % flat.len()]);
            let (a, b) = if a[1] < b[1] { (a, b) } else { (b, a) };
            let slope = (b[0] - a[0]) / (b[1] - a[1]);
            // A level edge spans no y and bounds nothing.
            (a[1] < b[1]).then(|| Edge { low: a[1], high: b[1], at_zero: a[0] - slope * a[1], slope })
        };
        Face::Polygon { anchor, frame, edges: (0..flat.len()).filter_map(edge).collect() }
    }
    pub fn of_polygon(s: &Polygon) -> Face {
        Face::polygon(s.vertices(), s.normal())
    }
    pub fn sphere(s: &Sphere) -> Face {
        Face::Ball { center: s.center(), radius: s.radius() }
    }
    pub fn cap(s: &SphereCap) -> Face {
        let sphere = s.sphere();
        Face::Cap { center: sphere.center(), radius: sphere.radius(), axis: s.axis(), height: s.rim_height() }
    }
    pub fn cylinder(s: &Cylinder) -> Face {
        // A half is exactly a half: cos(π/2) rounds to something else.
        let share = s.arc();
        let cosine = if share == 0.5 { 0.0 } else { libm::cos(std::f64::consts::PI * share) };
        let least = if share == 1.0 { f64::NEG_INFINITY } else { s.radius() * cosine };
        Face::Wall {
            center: s.center(),
            axis: s.axis(),
            radius: s.radius(),
            half_height: 0.5 * s.height(),
            toward: s.toward(),
            least,
        }
    }
    pub fn paraboloid(s: &Paraboloid) -> Face {
        Face::Dish { vertex: s.vertex(), axis: s.axis(), four_f: 4.0 * s.focal_length(), depth: s.depth() }
    }

    /// Where a ray meets the surface first, metres along it, greater than nought.
    ///
    /// - `direction`: unit vector; `starts_here`: whether `from` is a point of this surface
    #[inline(always)]
    pub fn meet(&self, from: DVec3, direction: DVec3, starts_here: bool, sides: Sides) -> Option<f64> {
        match self {
            Face::Parallelogram { center, normal, dual_u, dual_v } => {
                flat(from - *center, direction, *normal, starts_here, sides, |p| {
                    p.dot(*dual_u).abs() < 0.5 && p.dot(*dual_v).abs() < 0.5
                })
            }
            Face::Disk { center, normal, radius_squared } => {
                flat(from - *center, direction, *normal, starts_here, sides, |p| p.length_squared() < *radius_squared)
            }
            Face::Polygon { anchor, frame, edges } => {
                flat(from - *anchor, direction, frame.normal, starts_here, sides, |p| {
                    let (x, y) = (p.dot(frame.tangent), p.dot(frame.bitangent));
                    let right = |e: &Edge| y >= e.low && y < e.high && x < e.at_zero + e.slope * y;
                    edges.iter().fold(false, |inside, edge| inside ^ right(edge))
                })
            }
            Face::Ball { center, radius } => {
                if sides == Sides::Front {
                    let ahead = if starts_here { None } else { ball_ahead(from - *center, direction, *radius) };
                    return ahead.filter(|t| *t > 0.0);
                }
                let roots = ball(from - *center, direction, *radius, starts_here);
                roots.into_iter().find(|t| *t > 0.0)
            }
            Face::Cap { center, radius, axis, height } => {
                let offset = from - *center;
                let roots = ball(offset, direction, *radius, starts_here);
                roots.into_iter().find(|t| *t > 0.0 && (offset + direction * *t).dot(*axis) >= *height)
            }
            Face::Wall { center, axis, radius, half_height, toward, least } => {
                let offset = from - *center;
                let (across, way) = (offset - *axis * offset.dot(*axis), direction - *axis * direction.dot(*axis));
                let constant = (across.length() - radius) * (across.length() + radius);
                let roots = quadratic(way.length_squared(), across.dot(way), constant, starts_here);
                roots.into_iter().find(|t| {
                    let at = offset + direction * *t;
                    *t > 0.0 && at.dot(*axis).abs() < *half_height && at.dot(*toward) >= *least
                })
            }
            Face::Dish { vertex, axis, four_f, depth } => {
                let offset = from - *vertex;
                let (z, rise) = (offset.dot(*axis), direction.dot(*axis));
                let (across, way) = (offset - *axis * z, direction - *axis * rise);
                let constant = across.length_squared() - four_f * z;
                let roots =
                    quadratic(way.length_squared(), across.dot(way) - 0.5 * four_f * rise, constant, starts_here);
                roots.into_iter().find(|t| *t > 0.0 && z + rise * *t <= *depth)
            }
        }
    }

    /// Whether it lies outside of a ball for sure, its rim not counted: no line meets it within the ball, to rounding.
    pub fn is_clear_of(&self, middle: DVec3, reach: f64) -> bool {
        let reach = reach * (1.0 + 1e-6);
        let beyond = |point: DVec3, normal: DVec3| (middle - point).dot(normal).abs() > reach;
        match self {
            Face::Parallelogram { center, normal, .. } | Face::Disk { center, normal, .. } => {
                beyond(*center, *normal)
            }
            Face::Polygon { anchor, frame, .. } => beyond(*anchor, frame.normal),
            Face::Ball { center, radius } | Face::Cap { center, radius, .. } => {
                ((middle - *center).length() - radius).abs() > reach
            }
            Face::Wall { center, axis, radius, .. } => {
                let offset = middle - *center;
                ((offset - *axis * offset.dot(*axis)).length() - radius).abs() > reach
            }
            Face::Dish { .. } => false,
        }
    }

    /// The unit normal at a point of the surface: of a ball, cap and wall outwards; of a dish on its hollow side.
    #[inline(always)]
    pub fn normal(&self, at: DVec3) -> DVec3 {
        match self {
            Face::Parallelogram { normal, .. } | Face::Disk { normal, .. } => *normal,
            Face::Polygon { frame, .. } => frame.normal,
            Face::Ball { center, .. } | Face::Cap { center, .. } => (at - *center).normalize(),
            Face::Wall { center, axis, .. } => {
                let offset = at - *center;
                (offset - *axis * offset.dot(*axis)).normalize()
            }
            Face::Dish { vertex, axis, four_f, .. } => {
                // The gradient of four_f z − r².
                let offset = at - *vertex;
                let across = offset - *axis * offset.dot(*axis);
                (*axis * (0.5 * four_f) - across).normalize()
            }
        }
    }
}

#[inline(always)]
fn flat(
    offset: DVec3,
    direction: DVec3,
    normal: DVec3,
    starts_here: bool,
    sides: Sides,
    inside: impl Fn(DVec3) -> bool,
) -> Option<f64> {
    let drop = -direction.dot(normal);
    if starts_here || (sides == Sides::Front && drop <= 0.0) {
        return None;
    }
    // Infinite or NaN for a ray along the plane: then no comparison holds.
    let t = offset.dot(normal) / drop;
    (t > 0.0 && t < f64::INFINITY && inside(offset + direction * t)).then_some(t)
}

/// Both distances at which a ray's line meets a sphere, the nearer first; not numbers above nought where there is none.
///
/// Half of the chord is the root of R² less the squared distance of the line from the centre, which keeps its digits for
/// a small or far sphere (Haines et al., *Ray Tracing Gems*, 2019, chapter 7).
#[inline(always)]
pub(super) fn ball(offset: DVec3, direction: DVec3, radius: f64, starts_here: bool) -> [f64; 2] {
    let middle = -offset.dot(direction);
    if starts_here {
        return [f64::NEG_INFINITY, 2.0 * middle];
    }
    let apart = (offset + direction * middle).length_squared();
    let half_squared = radius * radius - apart;
    if half_squared <= 0.0 {
        return [f64::NEG_INFINITY; 2];
    }
    let half = half_squared.sqrt();
    let distance = offset.length();
    let outside = (distance - radius) * (distance + radius);
    // The root of the larger size by a sum, the other by the product of both.
    if middle > 0.0 { [outside / (middle + half), middle + half] } else { [middle - half, outside / (middle - half)] }
}

/// The nearer of [`ball`] for a ray that starts elsewhere; `None` where it is not ahead.
#[inline(always)]
pub(super) fn ball_ahead(offset: DVec3, direction: DVec3, radius: f64) -> Option<f64> {
    let middle = -offset.dot(direction);
    let half_squared = radius * radius - (offset + direction * middle).length_squared();
    if !(middle > 0.0 && half_squared > 0.0) {
        return None;
    }
    let (distance, half) = (offset.length(), half_squared.sqrt());
    Some((distance - radius) * (distance + radius) / (middle + half))
}

/// Both roots of a t² + 2 b t + c, the smaller first; not numbers above nought where there is none.
#[inline(always)]
fn quadratic(a: f64, b: f64, c: f64, starts_here: bool) -> [f64; 2] {
    if starts_here {
        // Infinite or NaN along an axis that meets the surface once: no meeting, for both.
        let other = -2.0 * b / a;
        return [f64::NEG_INFINITY, if other.is_finite() { other } else { f64::NEG_INFINITY }];
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return [f64::NEG_INFINITY; 2];
    }
    let sum = -(b + discriminant.sqrt().copysign(b));
    let (first, second) = (sum / a, c / sum);
    let finite = |t: f64| if t.is_finite() { t } else { f64::NEG_INFINITY };
    let (first, second) = (finite(first), finite(second));
    if first < second { [first, second] } else { [second, first] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_ahead_to_a_ball_is_the_nearer_meeting_or_none() {
        let mut met = 0;
        for k in 0..4096_u32 {
            // Around the ball on all sides, from beside its surface to far away, aimed at it and past it.
            let turn = |i: u32| 2.399 * f64::from(k * i % 4099);
            let (z, azimuth) = (turn(1).sin(), turn(3));
            let offset = DVec3::new(azimuth.cos(), azimuth.sin(), z) * (1.6 + 3.0 * f64::from(k % 7));
            let aim = DVec3::new(turn(5).cos(), turn(7).sin(), turn(11).cos()) * 1.2;
            let direction = if k % 9 == 0 { offset } else { aim - offset }.normalize();
            let [near, far] = ball(offset, direction, 1.3, false);
            let ahead = (near > 0.0 && far.is_finite()).then_some(near);
            assert_eq!(ball_ahead(offset, direction, 1.3), ahead, "from {offset} along {direction}");
            met += u32::from(ahead.is_some());
        }
        assert!((1000..3500).contains(&met), "both outcomes are common: {met}");
    }

    /// Each curved shape, with points of it and how far they are off.
    #[test]
    fn meetings_lie_on_the_surface_and_chords_come_back() {
        let ball = Sphere::new(DVec3::new(0.1, -0.2, 0.3), 1.3).unwrap();
        let wall = Cylinder::new(DVec3::new(0.1, -0.2, 0.3), DVec3::new(0.1, 0.2, 1.0), 1.3, 50.0).unwrap();
        let dish = Paraboloid::new(DVec3::new(0.1, -0.2, -0.9), DVec3::new(0.1, 0.2, 1.0), 0.4, 20.0).unwrap();
        let off = |face: &Face, p: DVec3| match face {
            Face::Ball { center, radius } => (p - *center).length() - radius,
            Face::Wall { center, axis, radius, .. } => {
                let o = p - *center;
                (o - *axis * o.dot(*axis)).length() - radius
            }
            Face::Dish { vertex, axis, four_f, .. } => {
                let o = p - *vertex;
                let z = o.dot(*axis);
                (o - *axis * z).length_squared() - four_f * z
            }
            _ => panic!("a curved one"),
        };
        for face in [Face::sphere(&ball), Face::cylinder(&wall), Face::paraboloid(&dish)] {
            let mut met = 0;
            for k in 0..500 {
                // Irregular directions from inside.
                let turn = f64::from(k) * 2.399_963;
                let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / 500.0;
                let ring = (1.0 - z * z).sqrt();
                let d = DVec3::new(ring * turn.cos(), ring * turn.sin(), z);
                let from = DVec3::new(0.2, 0.1, 0.4);
                let Some(t) = face.meet(from, d, false, Sides::Both) else { continue };
                let at = from + d * t;
                assert!(off(&face, at).abs() < 1e-12 * (1.0 + t), "{face:?} {d}: {:e}", off(&face, at));
                // Mirrored there, the ray meets the hollow side again, on the surface.
                let n = face.normal(at);
                let back = d - n * (2.0 * d.dot(n));
                if let Some(again) = face.meet(at, back, true, Sides::Both) {
                    assert!(off(&face, at + back * again).abs() < 1e-11 * (1.0 + t + again), "{face:?}");
                    assert!(again > 0.0);
                    met += 1;
                }
                // On the other side it never does.
                let away = d;
                assert!(face.meet(at, away, true, Sides::Both).is_none(), "{face:?} is convex");
            }
            assert!(met > 100, "{face:?}: {met}");
        }
    }

    #[test]
    fn borders_of_parts_are_kept() {
        let half =
            Face::cylinder(&Cylinder::new(DVec3::ZERO, DVec3::Z, 1.0, 2.0).unwrap().part(DVec3::X, 0.5).unwrap());
        let along = |from: DVec3, d: DVec3| half.meet(from, d.normalize(), false, Sides::Both);
        assert_eq!(along(DVec3::ZERO, DVec3::X), Some(1.0));
        assert_eq!(along(DVec3::ZERO, -DVec3::X), None);
        assert_eq!(along(DVec3::X * -3.0, DVec3::X), Some(4.0), "through the open side");
        assert_eq!(along(DVec3::Z * 1.5, DVec3::X), None, "over the rim");
        let sphere = Sphere::new(DVec3::Z, 1.0).unwrap();
        let bowl = Face::cap(&SphereCap::new(sphere, -DVec3::Z, 0.5).unwrap());
        assert_eq!(bowl.meet(DVec3::Z * 5.0, -DVec3::Z, false, Sides::Both), Some(5.0));
        assert_eq!(bowl.meet(DVec3::new(0.6, 0.0, 5.0), -DVec3::Z, false, Sides::Both), None);
        let plate = Face::disk(&Disk::new(DVec3::ZERO, DVec3::Z, 1.0).unwrap());
        assert_eq!(plate.meet(DVec3::Z, -DVec3::Z, false, Sides::Front), Some(1.0));
        assert_eq!(plate.meet(-DVec3::Z, DVec3::Z, false, Sides::Front), None, "from behind");
        assert_eq!(plate.meet(-DVec3::Z, DVec3::Z, false, Sides::Both), Some(1.0));
        let globe = Face::sphere(&Sphere::new(DVec3::ZERO, 1.0).unwrap());
        assert_eq!(globe.meet(DVec3::ZERO, DVec3::Z, false, Sides::Front), None);
        assert_eq!(globe.meet(DVec3::ZERO, DVec3::Z, false, Sides::Both), Some(1.0));
    }
}
