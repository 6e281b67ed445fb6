//! Directions uniform in the solid angle in which a shape is seen, with the place where each meets it.
//!
//! A rectangle and a polygon are triangles, one chosen by solid angle, the direction then by [`SphericalTriangle`]. (For a
//! rectangle this is the distribution of Ureña, Fajardo & King 2013, whose map subtracts 2π from a sum of four angles.) A
//! sphere is its cone.
//!
//! A disk is seen as an elliptic cone, whose solid angle is an elliptic integral. Directions are drawn uniformly in the
//! rectangle around that ellipse instead, and those that miss the disk are told as misses: they bring nothing, and the mean
//! is right. Misses are few where the disk fills the sky, and 1 − π/4 ≈ 21 % where it is small.
//!
//! Everything is computed in a frame in which what is small is a coordinate, so that directions keep their digits from
//! grazing views to hemispheres and no other method is needed at either end.
#![expect(clippy::needless_range_loop, reason = "one index over several rows is what the compiler makes vectors of")]

use glam::DVec3;

use super::ears::triangulated;
use super::spherical::SphericalTriangle;
use super::warp::concentric;
use super::{BLOCK, LANES, Row, Squares, groups};
use crate::geometry::{Frame, Shape};

/// One block of directions, unit vectors.
#[derive(Clone, Debug)]
pub struct DirectionBlock {
    pub x: Row,
    pub y: Row,
    pub z: Row,
}

impl Default for DirectionBlock {
    fn default() -> DirectionBlock {
        let row = [[0.0; LANES]; BLOCK / LANES];
        DirectionBlock { x: row, y: row, z: row }
    }
}

impl DirectionBlock {
    /// One direction.
    #[inline(always)]
    pub fn direction(&self, group: usize, lane: usize) -> DVec3 {
        DVec3::new(self.x[group][lane], self.y[group][lane], self.z[group][lane])
    }

    #[inline(always)]
    pub(super) fn set(&mut self, group: usize, lane: usize, direction: DVec3) {
        (self.x[group][lane], self.y[group][lane], self.z[group][lane]) = direction.into();
    }
}

/// The lit side of a shape, as it is to be looked at from anywhere.
#[derive(Clone, Debug)]
pub struct Silhouette(Outline);

#[derive(Clone, Debug)]
enum Outline {
    /// Corners in the plane's own frame, relative to the anchor; triangles as indices.
    Polygon {
        anchor: DVec3,
        frame: Frame,
        corners: Vec<[f64; 2]>,
        triangles: Vec<[usize; 3]>,
    },
    Disk {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
    Sphere {
        center: DVec3,
        radius: f64,
    },
}

/// The directions in which one eye sees one shape.
#[derive(Clone, Debug, Default)]
pub struct View {
    solid_angle: f64,
    part: Part,
    /// Emptied and filled again for the next eye.
    triangles: Vec<SphericalTriangle>,
}

#[derive(Clone, Debug, Default)]
enum Part {
    #[default]
    Nothing,
    /// Triangles in `axes`, in a plane at `height` from the eye and facing `facing`.
    Flat { axes: Frame, facing: DVec3, height: f64, farthest: f64, ellipse: Option<[f64; 2]> },
    /// Of half-angle ϑ around `axes.normal`: `width` is sin(ϑ/2), `distance` that of the centre.
    Cone { axes: Frame, width: f64, distance: f64, tangent_squared: f64 },
}

impl Silhouette {
    /// `None` for a mesh.
    pub fn new(shape: &Shape) -> Option<Silhouette> {
        Some(Silhouette(match shape {
            Shape::Rectangle(s) => polygon(&s.corners(), s.normal()),
            Shape::Polygon(s) => polygon(s.vertices(), s.normal()),
            Shape::Disk(s) => Outline::Disk { center: s.center(), normal: s.normal(), radius: s.radius() },
            Shape::Sphere(s) => Outline::Sphere { center: s.center(), radius: s.radius() },
            _ => return None,
        }))
    }

    /// What an eye sees of it: nothing from behind a flat shape, from its plane, or from inside a sphere.
    ///
    /// - `eye`: metres
    pub fn seen_from(&self, eye: DVec3, view: &mut View) {
        view.triangles.clear();
        view.part = Part::Nothing;
        match &self.0 {
            Outline::Polygon { anchor, frame, corners, triangles } => {
                let offset = eye - *anchor;
                let height = offset.dot(frame.normal);
                let foot = [offset.dot(frame.tangent), offset.dot(frame.bitangent)];
                let flat = |k: usize| DVec3::new(corners[k][0], corners[k][1], 0.0);
                let corner = |k: usize| DVec3::new(corners[k][0] - foot[0], corners[k][1] - foot[1], -height);
                if height > 0.0 {
                    let parts = triangles.iter().map(|[a, b, c]| {
                        SphericalTriangle::new(corner(*a), flat(*b) - flat(*a), flat(*c) - flat(*a))
                    });
                    view.triangles.extend(parts);
                    let farthest = (0..corners.len()).map(|k| corner(k).length()).fold(0.0, f64::max);
                    view.part = Part::Flat { axes: *frame, facing: DVec3::Z, height, farthest, ellipse: None };
                }
            }
            Outline::Disk { center, normal, radius } => {
                let across = *center - eye;
                let height = -across.dot(*normal);
                if height > 0.0 {
                    let (part, triangles) = disk(across, *normal, *radius, height);
                    view.triangles.extend(triangles);
                    view.part = part;
                }
            }
            Outline::Sphere { center, radius } => {
                let across = *center - eye;
                let distance = across.length();
                let gap = distance - radius;
                if gap > 0.0 {
                    let tangent_squared = gap * (distance + radius);
                    let sine = radius / distance;
                    let cosine = tangent_squared.sqrt() / distance;
                    let width = sine / (2.0 * (1.0 + cosine)).sqrt();
                    let axes = Frame::around(across / distance);
                    view.part = Part::Cone { axes, width, distance, tangent_squared };
                }
            }
        }
        view.triangles.retain(|triangle| triangle.solid_angle() > 0.0);
        if view.triangles.is_empty() && matches!(view.part, Part::Flat { .. }) {
            view.part = Part::Nothing;
        }
        view.solid_angle = match view.part {
            Part::Nothing => 0.0,
            Part::Flat { .. } => view.triangles.iter().map(SphericalTriangle::solid_angle).sum(),
            Part::Cone { width, .. } => 4.0 * std::f64::consts::PI * width * width,
        };
    }
}

fn polygon(vertices: &[DVec3], normal: DVec3) -> Outline {
    let anchor = vertices[0];
    let frame = Frame::around(normal);
    let corners: Vec<[f64; 2]> =
        vertices.iter().map(|v| [(*v - anchor).dot(frame.tangent), (*v - anchor).dot(frame.bitangent)]).collect();
    let triangles = triangulated(&corners);
    Outline::Polygon { anchor, frame, corners, triangles }
}

/// The rectangle around the elliptic cone in which a disk is seen.
///
/// With h the height over the disk's plane, r₀ the distance from its axis, a its radius, E = h² + r₀² − a² and
/// Λ = 2 a² h²/(√(E² + 4 a² h²) + E), the cone's axis is h r₀ along the disk's plane by h² + Λ towards it, and its semi-axes
/// at unit distance are Λ/(a h) in the plane of both axes and √Λ/h across. (The eigenvectors of the cone's quadratic form;
/// see [`crate::geometry::solid_angle::disk`].)
fn disk(across: DVec3, normal: DVec3, radius: f64, height: f64) -> (Part, [SphericalTriangle; 2]) {
    // In units of the radius.
    let h = height / radius;
    let aside = across + normal * height;
    let r0 = aside.length() / radius;
    let outward = if r0 > 0.0 { aside / (r0 * radius) } else { Frame::around(normal).tangent };
    let product = hypotenuse(h, r0 - 1.0) * hypotenuse(h, r0 + 1.0);
    let excess = h * h + (r0 - 1.0) * (r0 + 1.0);
    // Λ/h², without the difference of near-equal numbers.
    let lambda = if excess > 0.0 { 2.0 / (product + excess) } else { 0.5 * (product - excess) / (h * h) };
    let (semi_along, semi_across) = (lambda * h, lambda.sqrt());
    // Along the disk's plane and towards it, divided by h.
    let (along, down) = (r0, h * (1.0 + lambda));
    let over = 1.0 / hypotenuse(along, down);
    let (along, down) = (along * over, down * over);
    let axis = outward * along - normal * down;
    let tangent = outward * down + normal * along;
    let axes = Frame { tangent, bitangent: axis.cross(tangent), normal: axis };
    let corner = |x: f64, y: f64| DVec3::new(x * semi_along, y * semi_across, 1.0);
    let (wide, high) = (DVec3::X * (2.0 * semi_along), DVec3::Y * (2.0 * semi_across));
    let triangles = [
        SphericalTriangle::new(corner(-1.0, -1.0), wide, high),
        SphericalTriangle::new(corner(1.0, 1.0), -wide, -high),
    ];
    let facing = DVec3::new(along, 0.0, -down);
    let farthest = radius * hypotenuse(h, r0 + 1.0);
    (Part::Flat { axes, facing, height, farthest, ellipse: Some([1.0 / semi_along, 1.0 / semi_across]) }, triangles)
}

/// √(x² + y²) by the square root alone: the same bits on every platform.
fn hypotenuse(x: f64, y: f64) -> f64 {
    let (small, large) = (x.abs().min(y.abs()), x.abs().max(y.abs()));
    let ratio = if large > 0.0 { small / large } else { 0.0 };
    large * (1.0 + ratio * ratio).sqrt()
}

impl View {
    /// Of the directions drawn from, steradians: the shape's own, for a disk that of the rectangle around it.
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// Whether some of these directions pass by the shape: those in the corners of the rectangle around a disk.
    pub fn misses(&self) -> bool {
        matches!(self.part, Part::Flat { ellipse: Some(_), .. })
    }

    /// Directions of the first `len` points of a block (rounded up to whole lanes), and how far each is from the shape.
    ///
    /// - `distances`: metres; zero for a direction that misses
    #[inline(always)]
    pub fn draw(&self, squares: &Squares, len: usize, directions: &mut DirectionBlock, distances: &mut Row) {
        match &self.part {
            Part::Nothing => distances[..groups(len)].fill([0.0; LANES]),
            Part::Flat { axes, facing, height, farthest, ellipse } => {
                for g in 0..groups(len) {
                    for l in 0..LANES {
                        let d = self.among_triangles(squares.u[g][l], squares.v[g][l]);
                        let inside = ellipse.is_none_or(|[along, across]| {
                            let (x, y) = (d.x * along, d.y * across);
                            x * x + y * y <= d.z * d.z
                        });
                        // In the plane to rounding, the quotient may be anything.
                        let distance = height / -d.dot(*facing);
                        let distance = if distance > 0.0 { distance.max(*height).min(*farthest) } else { *farthest };
                        distances[g][l] = if inside { distance } else { 0.0 };
                        directions.set(g, l, axes.tangent * d.x + axes.bitangent * d.y + axes.normal * d.z);
                    }
                }
            }
            Part::Cone { axes, width, distance, tangent_squared } => {
                for g in 0..groups(len) {
                    for l in 0..LANES {
                        // Equal areas of the unit disk are equal solid angles of the cone (Lambert).
                        let (x, y) = concentric(squares.u[g][l], squares.v[g][l]);
                        let (widest, squared) = (width * width, x * x + y * y);
                        let cosine = 1.0 - 2.0 * widest * squared;
                        let sine = 2.0 * width * (1.0 - widest * squared).sqrt();
                        // sin²ϑ − sin²θ, that the direction is inside the silhouette by.
                        let inside = 4.0 * widest * (1.0 - squared) * (1.0 - widest * (1.0 + squared));
                        let reach = distance * (cosine + inside.max(0.0).sqrt());
                        distances[g][l] = tangent_squared / reach;
                        directions.set(
                            g,
                            l,
                            axes.tangent * (x * sine) + axes.bitangent * (y * sine) + axes.normal * cosine,
                        );
                    }
                }
            }
        }
    }

    /// u first chooses among the triangles, then what is left of it lies in the chosen one.
    #[inline(always)]
    fn among_triangles(&self, u: f64, v: f64) -> DVec3 {
        let mut left = u * self.solid_angle;
        let last = self.triangles.len() - 1;
        let mut chosen = &self.triangles[last];
        for triangle in &self.triangles[..last] {
            if left < triangle.solid_angle() {
                chosen = triangle;
                break;
            }
            left -= triangle.solid_angle();
        }
        chosen.direction((left / chosen.solid_angle()).clamp(0.0, 1.0), v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Disk, Polygon, Rectangle, Sphere, solid_angle};

    /// Midpoints of n × n cells of the square: direction and distance.
    fn grid(view: &View, n: usize) -> Vec<(DVec3, f64)> {
        let (mut squares, mut directions) = (Squares::default(), DirectionBlock::default());
        let mut distances = [[0.0; LANES]; BLOCK / LANES];
        let mut all = Vec::with_capacity(n * n);
        for start in (0..n * n).step_by(BLOCK) {
            let len = BLOCK.min(n * n - start);
            for k in 0..len {
                let (i, j) = ((start + k) % n, (start + k) / n);
                squares.u[k / LANES][k % LANES] = (i as f64 + 0.5) / n as f64;
                squares.v[k / LANES][k % LANES] = (j as f64 + 0.5) / n as f64;
            }
            view.draw(&squares, len, &mut directions, &mut distances);
            all.extend((0..len).map(|k| {
                let (g, l) = (k / LANES, k % LANES);
                (directions.direction(g, l), distances[g][l])
            }));
        }
        all
    }

    fn view(shape: &Shape, eye: DVec3) -> View {
        let mut view = View::default();
        Silhouette::new(shape).unwrap().seen_from(eye, &mut view);
        view
    }

    fn exact(shape: &Shape, eye: DVec3) -> f64 {
        match shape {
            Shape::Disk(s) => solid_angle::disk(eye, s),
            Shape::Rectangle(s) => solid_angle::rectangle(eye, s),
            Shape::Polygon(s) => solid_angle::polygon(eye, s),
            Shape::Sphere(s) => solid_angle::sphere(eye, s),
            Shape::Mesh(_) => unreachable!("no mesh here"),
        }
        .unwrap()
    }

    fn shapes() -> Vec<Shape> {
        let frame = Frame::around(DVec3::new(0.1, -0.2, -1.0).normalize());
        let flat = |outline: &[[f64; 2]]| {
            let vertices = outline.iter().map(|p| DVec3::Z + frame.tangent * p[0] + frame.bitangent * p[1]);
            Shape::Polygon(Polygon::new(vertices.collect()).unwrap())
        };
        vec![
            Shape::Rectangle(Rectangle::new(DVec3::Z, DVec3::Y * 1.5, DVec3::X).unwrap()),
            Shape::Disk(Disk::new(DVec3::Z, DVec3::new(0.2, 0.1, -1.0), 0.7).unwrap()),
            Shape::Sphere(Sphere::new(DVec3::Z, 0.6).unwrap()),
            flat(&[[0.0, 0.0], [1.0, 0.2], [0.3, 1.5]]),
            flat(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]),
            flat(&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.5, 0.5], [0.0, 2.0]]),
        ]
    }

    fn eyes() -> Vec<DVec3> {
        let v = DVec3::new;
        vec![
            v(0.0, 0.0, 0.0),
            v(0.3, 0.4, 0.2),
            v(3.0, 1.0, 0.3),
            v(-40.0, 3.0, -70.0),
            v(1e3, 2e3, -5e3),
            v(1e6, 2e6, -3e6),
        ]
    }

    #[test]
    fn the_share_that_hits_is_the_exact_solid_angle() {
        for shape in shapes() {
            for eye in eyes() {
                let view = view(&shape, eye);
                let n = 400;
                let hits = grid(&view, n).iter().filter(|(_, distance)| *distance > 0.0).count();
                let found = view.solid_angle() * hits as f64 / (n * n) as f64;
                let exact = exact(&shape, eye);
                // A disk's ellipse is counted in cells; all else is hit always.
                let allowed = if matches!(shape, Shape::Disk(_)) { 2e-3 } else { 1e-9 };
                assert!((found / exact - 1.0).abs() < allowed, "{} from {eye}: {found}, not {exact}", shape.kind());
                assert!(hits as f64 >= 0.78 * (n * n) as f64, "{} from {eye}: {hits} hits", shape.kind());
            }
        }
    }

    #[test]
    fn directions_end_on_the_shape() {
        for shape in shapes() {
            for eye in eyes() {
                let view = view(&shape, eye);
                for (direction, distance) in grid(&view, 40).into_iter().filter(|(_, distance)| *distance > 0.0) {
                    let end = eye + direction * distance;
                    let rounding = 1e-14 * (1.0 + distance);
                    let off = match &shape {
                        Shape::Disk(s) => {
                            assert!((end - s.center()).length() <= s.radius() + rounding);
                            (end - s.center()).dot(s.normal())
                        }
                        Shape::Rectangle(s) => {
                            let corner = end - s.center();
                            assert!(corner.x.abs() <= 0.5 + rounding && corner.y.abs() <= 0.75 + rounding);
                            corner.dot(s.normal())
                        }
                        Shape::Polygon(s) => (end - s.vertices()[0]).dot(s.normal()),
                        Shape::Sphere(s) => (end - s.center()).length() - s.radius(),
                        Shape::Mesh(_) => unreachable!("no mesh here"),
                    };
                    assert!(off.abs() <= rounding, "{} from {eye}: {end} is off by {off}", shape.kind());
                }
            }
        }
    }

    #[test]
    fn the_far_side_of_a_shape_is_not_seen() {
        let disk = Disk::new(DVec3::Z, DVec3::NEG_Z, 1.0).unwrap();
        let square = Rectangle::new(DVec3::Z, DVec3::Y, DVec3::X).unwrap();
        for shape in [Shape::Disk(disk), Shape::Rectangle(square)] {
            for eye in [DVec3::Z * 1.5, DVec3::new(3.0, 0.0, 1.0)] {
                assert_eq!(view(&shape, eye).solid_angle(), 0.0, "{shape:?} from {eye}");
            }
        }
        let ball = Shape::Sphere(Sphere::new(DVec3::Z, 1.0).unwrap());
        assert_eq!(view(&ball, DVec3::Z * 1.5).solid_angle(), 0.0);
    }

    /// The mean of Ω cosθ/π over a fine grid is the form factor, from 10⁻¹⁴ sr to nearly 2π sr, with no step where other
    /// renderers change their method (10⁻⁴, 3·10⁻⁴, 6.22 sr).
    #[test]
    fn no_seam_shows_from_specks_to_hemispheres() {
        // Straight above the middle: closed forms of the simplest kind.
        let (half, radius) = (0.5_f64, 0.5_f64);
        let square = Shape::Rectangle(Rectangle::new(DVec3::ZERO, DVec3::X, DVec3::Y).unwrap());
        let triangles = [[0, 1, 2], [0, 2, 3]].map(|t| {
            let Shape::Rectangle(s) = &square else { unreachable!() };
            Shape::Polygon(Polygon::new(t.map(|k| s.corners()[k]).to_vec()).unwrap())
        });
        let disk = Shape::Disk(Disk::new(DVec3::ZERO, DVec3::Z, radius).unwrap());
        let of_corner = |h: f64| {
            let side = half / h;
            let root = side.hypot(1.0);
            2.0 / (2.0 * std::f64::consts::PI) * (side / root) * (side / root).atan()
        };
        let mut span = (f64::INFINITY, 0.0_f64);
        // From 10⁻³ to 10⁷ metres, and on either side of where the square fills 10⁻⁴, 3·10⁻⁴ and 6.22 sr.
        let all = (0..=80).map(|step| 10_f64.powf(-3.0 + f64::from(step) / 8.0));
        let thresholds =
            [100.0, 57.735, 0.01117].into_iter().flat_map(|h| [0.999, 0.9999, 1.0001, 1.001].map(|k| h * k));
        for height in all.chain(thresholds) {
            // The square is bent most where it covers nearly a hemisphere.
            let n = if height < 0.4 { 256 } else { 64 };
            let eye = DVec3::Z * height;
            let mean = |shape: &Shape, n: usize| {
                let view = view(shape, eye);
                let cosines = grid(&view, n).into_iter().map(|(d, far)| if far > 0.0 { -d.z } else { 0.0 });
                (
                    view.solid_angle(),
                    view.solid_angle() / std::f64::consts::PI * cosines.sum::<f64>() / (n * n) as f64,
                )
            };
            let square_factor = 4.0 * of_corner(height);
            let (omega, found) = mean(&square, n);
            span = (span.0.min(omega), span.1.max(omega));
            assert!((found / square_factor - 1.0).abs() < 3e-4, "square, {omega} sr: {found}, not {square_factor}");
            for triangle in &triangles {
                let (omega, found) = mean(triangle, n);
                assert!((found / square_factor - 0.5).abs() < 3e-4, "triangle, {omega} sr: {found}");
            }
            let disk_factor = radius * radius / (radius * radius + height * height);
            let (omega, found) = mean(&disk, 2 * n);
            assert!((found / disk_factor - 1.0).abs() < 2e-3, "disk, {omega} sr: {found}, not {disk_factor}");
            let ball = Shape::Sphere(Sphere::new(DVec3::NEG_Z * radius, radius).unwrap());
            let ball_factor = (radius / (radius + height)).powi(2);
            let (omega, found) = mean(&ball, n);
            assert!((found / ball_factor - 1.0).abs() < 3e-4, "ball, {omega} sr: {found}, not {ball_factor}");
        }
        assert!(span.0 < 1.01e-14 && span.1 > 6.27, "{span:?}");
    }
}
