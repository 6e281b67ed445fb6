//! A bounding-volume hierarchy over a triangle mesh: `obvhs` finds candidates in f32, an f64 test decides.
//!
//! The only f32 of the crate lives here. Boxes are padded outward by more than all f32 rounding of a ray can add up to,
//! and the triangle test decides shared edges from the same number on both sides, so that no ray slips between
//! neighbours. `Bvh2` is used because the compressed hierarchy loses hits nearer than 1e-4.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::Ray;

use super::segment::Segment;
use crate::geometry::Mesh;

/// Outward padding of boxes in a scene scaled to [−1, 1]. A ray's origin and direction are rounded to f32 (2⁻²⁴ each,
/// coordinates up to 2), the slab test adds four more roundings: below 1e-6 together.
const PADDING: f32 = 2e-6;

/// Triangles of one mesh, and the boxes around them.
pub struct Hierarchy {
    bvh: Bvh2,
    /// In the order of the hierarchy's leaves.
    triangles: Vec<[DVec3; 3]>,
    middle: DVec3,
    /// Metres to units of the hierarchy.
    scale: f64,
}

impl Hierarchy {
    /// - `mesh`: what blocks; `reach`: a box (low, high) that holds every end of every ray, metres
    pub fn new(mesh: &Mesh, reach: (DVec3, DVec3)) -> Hierarchy {
        let (mut low, mut high) = reach;
        for vertex in mesh.vertices() {
            (low, high) = (low.min(*vertex), high.max(*vertex));
        }
        let middle = low * 0.5 + high * 0.5;
        let scale = 1.0 / (high - middle).max_element().max(f64::MIN_POSITIVE);
        let corners: Vec<[DVec3; 3]> = (0..mesh.triangles().len()).map(|t| mesh.corners(t)).collect();
        let boxes: Vec<Aabb> = corners
            .iter()
            .map(|triangle| {
                let points = triangle.map(|p| ((p - middle) * scale).as_vec3a());
                Aabb::new(
                    points[0].min(points[1]).min(points[2]) - Vec3A::splat(PADDING),
                    points[0].max(points[1]).max(points[2]) + Vec3A::splat(PADDING),
                )
            })
            .collect();
        let mut spent = std::time::Duration::ZERO;
        let bvh = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut spent);
        let triangles = bvh.primitive_indices.iter().map(|index| corners[*index as usize]).collect();
        Hierarchy { bvh, triangles, middle, scale }
    }

    /// Whether a triangle lies strictly between two points.
    pub fn blocks(&self, from: DVec3, to: DVec3) -> bool {
        let Some(segment) = Segment::new(from, to) else { return false };
        let ray = Ray::new(
            ((from - self.middle) * self.scale).as_vec3a(),
            ((to - from) * self.scale).as_vec3a(),
            0.0,
            1.0 + PADDING,
        );
        let meeting = |candidate: usize| if segment.meets(&self.triangles[candidate]) { 0.5 } else { f32::INFINITY };
        !self.bvh.ray_traverse_miss(ray, |_, candidate| meeting(candidate))
    }

    /// The same answer from testing every triangle: the witness, and the yardstick of the timings.
    pub fn blocks_by_brute_force(&self, from: DVec3, to: DVec3) -> bool {
        Segment::new(from, to).is_some_and(|segment| self.triangles.iter().any(|triangle| segment.meets(triangle)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Stream, StreamKey};
    use rand::RngExt;

    /// A bumpy sheet of 2 · n² triangles around z = 1, too gently sloped to show a silhouette to the rays below.
    fn sheet(n: u32) -> Mesh {
        let mut vertices = Vec::new();
        for j in 0..=n {
            for i in 0..=n {
                let (x, y) = (f64::from(i) / f64::from(n) - 0.5, f64::from(j) / f64::from(n) - 0.5);
                vertices.push(DVec3::new(x, y, 1.0 + 0.03 * (9.0 * x).sin() * (7.0 * y).cos()));
            }
        }
        let at = |i: u32, j: u32| j * (n + 1) + i;
        let quads = (0..n * n).map(|k| (k % n, k / n));
        let triangles = quads.flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        });
        Mesh::new(vertices, triangles.collect()).unwrap()
    }

    fn hierarchy(n: u32) -> Hierarchy {
        Hierarchy::new(&sheet(n), (DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 2.0)))
    }

    #[test]
    fn the_hierarchy_agrees_with_brute_force_ray_for_ray() {
        let hierarchy = hierarchy(12);
        let mut draws = Stream::new(StreamKey::root(11));
        let mut point =
            |z: f64, reach: f64| DVec3::new(draws.random_range(-reach..reach), draws.random_range(-reach..reach), z);
        let mut hits = 0;
        for _ in 0..20_000 {
            let (from, to) = (point(0.0, 2.0), point(2.0, 1.0));
            let hit = hierarchy.blocks(from, to);
            assert_eq!(hit, hierarchy.blocks_by_brute_force(from, to), "{from} to {to}");
            hits += u32::from(hit);
        }
        assert!((2_000..18_000).contains(&hits), "both outcomes are common: {hits}");
    }

    #[test]
    fn no_ray_slips_between_neighbours() {
        // Aimed at vertices and at points of shared edges, inside the outline.
        let mesh = sheet(30);
        let hierarchy = hierarchy(30);
        let mut draws = Stream::new(StreamKey::root(12));
        let mut aimed = 0;
        while aimed < 100_000 {
            let t = draws.random_range(0..mesh.triangles().len());
            let [a, b, _] = mesh.corners(t);
            let along: f64 = if draws.random_bool(0.5) { draws.random() } else { 0.0 };
            let target = a + (b - a) * along;
            if target.x.abs() > 0.49 || target.y.abs() > 0.49 {
                continue;
            }
            let from = DVec3::new(draws.random_range(-0.3..0.3), draws.random_range(-0.3..0.3), 0.0);
            let beyond = from + (target - from) * draws.random_range(1.2..2.0);
            assert!(hierarchy.blocks(from, beyond), "leak from {from} through {target}");
            aimed += 1;
        }
    }

    #[test]
    fn what_lies_before_or_behind_the_segment_does_not_block() {
        let hierarchy = hierarchy(8);
        assert!(hierarchy.blocks(DVec3::ZERO, DVec3::Z * 2.0));
        assert!(!hierarchy.blocks(DVec3::ZERO, DVec3::Z * 0.8));
        assert!(!hierarchy.blocks(DVec3::Z * 2.0, DVec3::Z * 1.2));
    }

    #[test]
    fn contact_hits_are_not_lost() {
        let triangle = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]).unwrap();
        let reach = (DVec3::splat(-1e3), DVec3::splat(1e3));
        let hierarchy = Hierarchy::new(&triangle, reach);
        for gap in [1e-3, 1e-6, 1e-9, 1e-12] {
            let from = DVec3::new(0.25, 0.25, -gap);
            assert!(hierarchy.blocks(from, DVec3::new(0.3, 0.2, 900.0)), "gap of {gap} m");
        }
    }

    #[test]
    fn halves_of_the_mesh_answer_as_the_hierarchy_does() {
        let reach = (DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 2.0));
        let (hierarchy, halves) = (hierarchy(12), super::super::halves::Hierarchy::new(&sheet(12), reach));
        let mut draws = Stream::new(StreamKey::root(13));
        let mut point =
            |z: f64, reach: f64| DVec3::new(draws.random_range(-reach..reach), draws.random_range(-reach..reach), z);
        for _ in 0..20_000 {
            let (from, to) = (point(0.0, 2.0), point(2.0, 1.0));
            assert_eq!(halves.blocks(from, to), hierarchy.blocks_by_brute_force(from, to), "{from} to {to}");
        }
        // Rays that lie in the planes of boxes, and a mesh of no height.
        let flat = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y], vec![[0, 1, 2], [1, 3, 2]]);
        let flat = super::super::halves::Hierarchy::new(&flat.unwrap(), reach);
        for x in [0.0, 0.5, 1.0] {
            assert!(flat.blocks(DVec3::new(x, 0.0, -1.0), DVec3::new(x, 0.0, 1.0)), "{x}");
        }
        assert!(!flat.blocks(DVec3::new(1.5, 0.0, -1.0), DVec3::new(1.5, 0.0, 1.0)));
    }
}
