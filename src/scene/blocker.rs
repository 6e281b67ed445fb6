//! Shadow rays against analytic shapes, a block at a time and without branches on the data.

use glam::DVec3;

use super::visibility::{SilhouetteEdges, Target, VisibilityMap};
use super::{Hierarchy, ShadowCache};
use crate::geometry::{Frame, Polygon, Shape};
use crate::number::{Eight, Lanewise, Machine, Registers, Work};
use crate::sampling::{BLOCK, LANES, Row, groups};

/// A block of shadow rays from one shading point: displacements to the points on the source, metres.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct ShadowRays {
    pub x: Row,
    pub y: Row,
    pub z: Row,
}

impl Default for ShadowRays {
    fn default() -> ShadowRays {
        ShadowRays {
            x: [[0.0; LANES]; BLOCK / LANES],
            y: [[0.0; LANES]; BLOCK / LANES],
            z: [[0.0; LANES]; BLOCK / LANES],
        }
    }
}

impl ShadowRays {
    /// One displacement.
    #[inline(always)]
    pub fn ray(&self, group: usize, lane: usize) -> DVec3 {
        DVec3::new(self.x[group][lane], self.y[group][lane], self.z[group][lane])
    }
}

/// Something that stops light, from both sides.
pub enum Blocker {
    Disk {
        center: DVec3,
        frame: Frame,
        radius: f64,
    },
    /// A parallelogram: inside where both dual coordinates are below ½ in size.
    Parallelogram {
        center: DVec3,
        normal: DVec3,
        dual_u: DVec3,
        dual_v: DVec3,
    },
    /// A simple polygon, in the coordinates of its own plane.
    Polygon {
        anchor: DVec3,
        frame: Frame,
        edges: Vec<Edge>,
    },
    /// A solid ball.
    Ball {
        center: DVec3,
        radius_squared: f64,
    },
    Mesh(Box<MeshBlocker>),
}

/// A mesh.
pub struct MeshBlocker {
    hierarchy: Hierarchy,
    edges: SilhouetteEdges,
}

/// An edge of a flat outline: it spans y in [low, high) and lies at x = at_zero + slope·y.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    low: f64,
    high: f64,
    at_zero: f64,
    slope: f64,
}

impl Edge {
    /// Whether the edge is crossed on the way from (x, y) to x = ∞.
    #[inline(always)]
    pub(super) fn is_right_of(&self, x: f64, y: f64) -> bool {
        (y >= self.low) & (y < self.high) & (x < self.at_zero + self.slope * y)
    }
}

impl Blocker {
    /// - `reach`: a box (low, high) that holds every end of every ray, metres
    pub fn new(shape: &Shape, reach: (DVec3, DVec3)) -> Blocker {
        match shape {
            Shape::Disk(s) => {
                Blocker::Disk { center: s.center(), frame: Frame::around(s.normal()), radius: s.radius() }
            }
            Shape::Rectangle(s) => {
                let across = s.edge_u().cross(s.edge_v());
                let over = 1.0 / across.length_squared();
                Blocker::Parallelogram {
                    center: s.center(),
                    normal: s.normal(),
                    dual_u: s.edge_v().cross(across) * over,
                    dual_v: across.cross(s.edge_u()) * over,
                }
            }
            Shape::Polygon(s) => polygon(s),
            Shape::Sphere(s) => Blocker::Ball { center: s.center(), radius_squared: s.radius() * s.radius() },
            Shape::Mesh(s) => Blocker::Mesh(Box::new(MeshBlocker {
                hierarchy: Hierarchy::new(s, reach),
                edges: SilhouetteEdges::default(),
            })),
        }
    }

    /// Sets to zero the contributions of the rays that this blocks, among the first `len` (rounded up to whole lanes).
    ///
    /// - `from`: the shading point, metres
    pub fn shade(&self, from: DVec3, rays: &ShadowRays, len: usize, contributions: &mut Row) {
        self.shade_on(Machine::Any, from, rays, len, contributions, Help::default());
    }

    /// As [`Blocker::shade`], in the registers of a machine.
    pub(crate) fn shade_on(
        &self,
        machine: Machine,
        from: DVec3,
        rays: &ShadowRays,
        len: usize,
        contributions: &mut Row,
        help: Help,
    ) {
        match self {
            Blocker::Mesh(mesh) => match help.visibility {
                Some(visibility) => visibility.shade(machine, &mesh.hierarchy, from, rays, len, contributions),
                None => mesh.hierarchy.shade(from, rays, len, contributions, help.cache),
            },
            analytic => {
                if let Some(stop) = analytic.stop(from) {
                    machine.run(Shade { stop, rays, len, contributions });
                }
            }
        }
    }

    /// What this is to the rays from one point; `None` where it stops none, and of a mesh.
    pub(crate) fn stop(&self, from: DVec3) -> Option<Stop<'_>> {
        match self {
            Blocker::Disk { center, frame, radius } => {
                let plane = Facing::new(from - *center, frame.normal)?;
                let inside = InDisk { x: plane.seen(frame.tangent), y: plane.seen(frame.bitangent), radius: *radius };
                Some(Stop::Disk(Through { plane, inside }))
            }
            Blocker::Parallelogram { center, normal, dual_u, dual_v } => {
                let plane = Facing::new(from - *center, *normal)?;
                let inside = InParallelogram { u: plane.seen(*dual_u), v: plane.seen(*dual_v) };
                Some(Stop::Parallelogram(Through { plane, inside }))
            }
            Blocker::Polygon { anchor, frame, edges } => {
                let plane = Facing::new(from - *anchor, frame.normal)?;
                let inside = InOutline { x: plane.seen(frame.tangent), y: plane.seen(frame.bitangent), edges };
                Some(Stop::Outline(Through { plane, inside }))
            }
            Blocker::Ball { center, radius_squared } => {
                Some(Stop::Ball(Ball { offset: from - *center, radius_squared: *radius_squared }))
            }
            Blocker::Mesh(_) => None,
        }
    }

    /// Where this is known, before any ray is sent, to hide a source from a point; of a mesh, and if enough rays are to follow.
    pub(crate) fn visibility(
        &self,
        machine: Machine,
        from: DVec3,
        target: &Target,
        rays: u64,
    ) -> Option<VisibilityMap> {
        let Blocker::Mesh(mesh) = self else { return None };
        mesh.edges.seen(&mesh.hierarchy, machine, from, target, rays)
    }

    /// What [`Blocker::stop`] has no answer for.
    pub(crate) fn is_mesh(&self) -> bool {
        matches!(self, Blocker::Mesh(_))
    }

    /// Of a mesh.
    pub(crate) fn hierarchy(&self) -> Option<&Hierarchy> {
        let Blocker::Mesh(mesh) = self else { return None };
        Some(&mesh.hierarchy)
    }
}

/// What makes a mesh answer sooner; it changes no answer.
#[derive(Default)]
pub(crate) struct Help<'a> {
    /// What blocked last.
    pub cache: Option<&'a mut ShadowCache>,
    /// Found by this mesh for the point that the rays start from.
    pub visibility: Option<&'a VisibilityMap>,
}

/// An analytic blocker as one shading point sees it.
pub(crate) enum Stop<'a> {
    Disk(Through<InDisk>),
    Parallelogram(Through<InParallelogram>),
    Outline(Through<InOutline<'a>>),
    Ball(Ball),
}

impl Stop<'_> {
    /// What is left of the light along these displacements.
    #[inline(always)]
    pub(crate) fn dim<T: Lanewise>(&self, ray: Displacement<T>, light: T) -> T {
        let stops = match self {
            Stop::Disk(disk) => disk.stops(ray),
            Stop::Parallelogram(parallelogram) => parallelogram.stops(ray),
            Stop::Outline(outline) => outline.stops(ray),
            Stop::Ball(ball) => ball.stops(ray),
        };
        T::choose(stops, light.like(0.0), light)
    }
}

struct Shade<'a> {
    stop: Stop<'a>,
    rays: &'a ShadowRays,
    len: usize,
    contributions: &'a mut Row,
}

impl Work for Shade<'_> {
    type Output = ();

    #[expect(clippy::needless_range_loop, reason = "one index over several rows")]
    #[inline(always)]
    fn run<R: Registers>(self, registers: R) {
        let Shade { stop, rays, len, contributions } = self;
        for g in 0..groups(len) {
            let ray = [
                Eight::load(registers, &rays.x[g]),
                Eight::load(registers, &rays.y[g]),
                Eight::load(registers, &rays.z[g]),
            ];
            let lit = Eight::load(registers, &contributions[g]);
            stop.dim(ray, lit).store(&mut contributions[g]);
        }
    }
}

/// One displacement, or several side by side.
pub(crate) type Displacement<T> = [T; 3];

#[inline(always)]
pub(super) fn dot<T: Lanewise>([x, y, z]: Displacement<T>, by: DVec3) -> T {
    x * by.x + y * by.y + z * by.z
}

#[inline(always)]
fn length_squared<T: Lanewise>([x, y, z]: Displacement<T>) -> T {
    x * x + y * y + z * z
}

/// What stops rays from one point.
trait Stops {
    /// Which rays, of these displacements.
    fn stops<T: Lanewise>(&self, ray: Displacement<T>) -> T::Which;
}

/// The plane of a flat piece as a shading point sees it. A ray d falls by s = d · `down` towards it and meets it at parameter
/// `height` / s. In coordinates along the plane, s times the meeting point is linear in d: no division is needed where a
/// comparison will do.
#[derive(Clone, Copy)]
struct Facing {
    /// The shading point, from the piece's origin.
    offset: DVec3,
    down: DVec3,
    /// > 0.
    height: f64,
}

impl Facing {
    /// `None` for a point in the plane: it is blocked by nothing there.
    #[inline(always)]
    fn new(offset: DVec3, normal: DVec3) -> Option<Facing> {
        let height = offset.dot(normal);
        let down = if height > 0.0 { -normal } else { normal };
        (height != 0.0).then_some(Facing { offset, down, height: height.abs() })
    }

    /// What d is multiplied with to give s times a coordinate of the meeting point.
    ///
    /// - `axis`: gives that coordinate of a point of the plane, from the piece's origin
    #[inline(always)]
    fn seen(&self, axis: DVec3) -> DVec3 {
        self.down * self.offset.dot(axis) + axis * self.height
    }
}

/// Rays through a part of a plane.
pub(crate) struct Through<I> {
    plane: Facing,
    inside: I,
}

/// Which points of a plane belong to a piece.
trait Inside {
    /// - `s`: as in [`Facing`], > 0 where the answer matters
    fn holds<T: Lanewise>(&self, ray: Displacement<T>, s: T) -> T::Which;
}

impl<I: Inside> Stops for Through<I> {
    #[inline(always)]
    fn stops<T: Lanewise>(&self, ray: Displacement<T>) -> T::Which {
        let s = dot(ray, self.plane.down);
        s.like(self.plane.height).is_below(s) & self.inside.holds(ray, s)
    }
}

pub(crate) struct InDisk {
    x: DVec3,
    y: DVec3,
    radius: f64,
}

impl Inside for InDisk {
    #[inline(always)]
    fn holds<T: Lanewise>(&self, ray: Displacement<T>, s: T) -> T::Which {
        let (x, y, rim) = (dot(ray, self.x), dot(ray, self.y), s * self.radius);
        (x * x + y * y).is_below(rim * rim)
    }
}

/// Both dual coordinates below ½ in size.
pub(crate) struct InParallelogram {
    u: DVec3,
    v: DVec3,
}

impl Inside for InParallelogram {
    #[inline(always)]
    fn holds<T: Lanewise>(&self, ray: Displacement<T>, s: T) -> T::Which {
        let half = s * 0.5;
        dot(ray, self.u).abs().is_below(half) & dot(ray, self.v).abs().is_below(half)
    }
}

pub(crate) struct InOutline<'a> {
    x: DVec3,
    y: DVec3,
    edges: &'a [Edge],
}

impl Inside for InOutline<'_> {
    #[inline(always)]
    fn holds<T: Lanewise>(&self, ray: Displacement<T>, s: T) -> T::Which {
        let (x, y) = (dot(ray, self.x) / s, dot(ray, self.y) / s);
        let mut inside = s.is_below(s);
        for edge in self.edges {
            // low ≤ y < high, and the crossing lies to the right.
            let spans = y.is_below(y.like(edge.low)) ^ y.is_below(y.like(edge.high));
            inside = inside ^ (spans & x.is_below(y * edge.slope + edge.at_zero));
        }
        inside
    }
}

pub(crate) struct Ball {
    /// The shading point, from the middle.
    offset: DVec3,
    radius_squared: f64,
}

impl Stops for Ball {
    #[inline(always)]
    fn stops<T: Lanewise>(&self, ray: Displacement<T>) -> T::Which {
        let Ball { offset, radius_squared } = self;
        let [x, y, z] = ray;
        let nearest = (-dot(ray, *offset) / length_squared(ray)).positive().at_most(x.like(1.0));
        let miss = [x * nearest + offset.x, y * nearest + offset.y, z * nearest + offset.z];
        length_squared(miss).is_below(x.like(*radius_squared))
    }
}

fn polygon(polygon: &Polygon) -> Blocker {
    let anchor = polygon.vertices()[0];
    let frame = Frame::around(polygon.normal());
    let flat: Vec<[f64; 2]> = polygon
        .vertices()
        .iter()
        .map(|v| [(*v - anchor).dot(frame.tangent), (*v - anchor).dot(frame.bitangent)])
        .collect();
    let edges = (0..flat.len())
        .filter_map(|i| {
            let (a, b) = (flat[i], flat[(i + 1) % flat.len()]);
            let (a, b) = if a[1] < b[1] { (a, b) } else { (b, a) };
            let slope = (b[0] - a[0]) / (b[1] - a[1]);
            // A level edge spans no y and bounds nothing here.
            (a[1] < b[1]).then(|| Edge { low: a[1], high: b[1], at_zero: a[0] - slope * a[1], slope })
        })
        .collect();
    Blocker::Polygon { anchor, frame, edges }
}

#[cfg(feature = "studies")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Disk, Mesh, Rectangle, Sphere};
    use crate::sampling::{Stream, StreamKey};
    use rand::RngExt;

    const REACH: (DVec3, DVec3) = (DVec3::splat(-3.0), DVec3::splat(3.0));

    fn blocked(shape: &Shape, from: DVec3, to: DVec3) -> bool {
        let d = to - from;
        let rays = ShadowRays {
            x: [[d.x; LANES]; BLOCK / LANES],
            y: [[d.y; LANES]; BLOCK / LANES],
            z: [[d.z; LANES]; BLOCK / LANES],
        };
        let mut contributions = [[1.0; LANES]; BLOCK / LANES];
        Blocker::new(shape, REACH).shade(from, &rays, 1, &mut contributions);
        contributions[0][0] == 0.0
    }

    #[test]
    fn a_rectangle_a_polygon_and_a_mesh_of_it_block_the_same_rays() {
        let rectangle =
            Rectangle::new(DVec3::new(0.1, 0.2, 1.0), DVec3::new(1.0, 0.0, 0.5), DVec3::new(0.0, 0.8, 0.0)).unwrap();
        let corners = rectangle.corners();
        let shapes = [
            Shape::Rectangle(rectangle),
            Shape::Polygon(Polygon::new(corners.to_vec()).unwrap()),
            Shape::Mesh(Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap().subdivided(2)),
        ];
        let mut draws = Stream::new(StreamKey::root(21));
        let mut hits = 0;
        for _ in 0..5_000 {
            let mut point = |z: f64| DVec3::new(draws.random_range(-1.0..1.0), draws.random_range(-1.0..1.0), z);
            let (from, to) = (point(0.0), point(2.0));
            let answers = shapes.each_ref().map(|shape| blocked(shape, from, to));
            assert!(answers[0] == answers[1] && answers[1] == answers[2], "{from} to {to}: {answers:?}");
            hits += u32::from(answers[0]);
        }
        assert!((500..4_500).contains(&hits), "{hits}");
    }

    #[test]
    fn a_many_sided_polygon_blocks_like_the_disk() {
        let disk = Disk::new(DVec3::new(0.2, -0.1, 1.0), DVec3::new(0.2, 0.1, 1.0), 0.6).unwrap();
        let frame = Frame::around(disk.normal());
        let rim = (0..2000).map(|k| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 2000.0).sin_cos();
            disk.center() + (frame.tangent * cos + frame.bitangent * sin) * disk.radius()
        });
        let polygon = Shape::Polygon(Polygon::new(rim.collect()).unwrap());
        let mut draws = Stream::new(StreamKey::root(22));
        let mut differ = 0;
        for _ in 0..2_000 {
            let mut point = |z: f64| DVec3::new(draws.random_range(-1.0..1.0), draws.random_range(-1.0..1.0), z);
            let (from, to) = (point(0.0), point(2.0));
            differ += u32::from(blocked(&Shape::Disk(disk), from, to) != blocked(&polygon, from, to));
        }
        assert!(differ <= 1, "areas differ by 2e-6: {differ} rays of 2000");
    }

    #[test]
    fn a_concave_outline_has_its_notch() {
        let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let l = Shape::Polygon(Polygon::new(l.iter().map(|p| DVec3::new(p[0], p[1], 1.0)).collect()).unwrap());
        let up = |x: f64, y: f64| blocked(&l, DVec3::new(x, y, 0.0), DVec3::new(x, y, 2.0));
        assert!(up(0.5, 1.5) && up(1.5, 0.5) && up(0.5, 0.5));
        assert!(!up(1.5, 1.5) && !up(-0.1, 0.5) && !up(2.1, 0.5));
    }

    #[test]
    fn a_ball_is_solid_and_ends_where_it_ends() {
        let ball = Shape::Sphere(Sphere::new(DVec3::Z, 0.5).unwrap());
        assert!(blocked(&ball, DVec3::ZERO, DVec3::Z * 2.0));
        assert!(!blocked(&ball, DVec3::ZERO, DVec3::Z * 0.4));
        assert!(!blocked(&ball, DVec3::Z * 1.6, DVec3::Z * 2.0));
        assert!(blocked(&ball, DVec3::Z, DVec3::Z * 2.0), "from inside");
        assert!(blocked(&ball, DVec3::Z * 0.9, DVec3::Z * 1.1), "wholly inside");
    }

    #[test]
    fn a_piece_in_the_plane_of_the_shading_point_blocks_nothing() {
        let disk = Shape::Disk(Disk::new(DVec3::X, DVec3::Z, 0.5).unwrap());
        assert!(!blocked(&disk, DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0)));
        assert!(!blocked(&disk, DVec3::ZERO, DVec3::new(2.0, 0.0, 1.0)));
    }
}
