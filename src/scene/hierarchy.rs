//! A bounding-volume hierarchy over a triangle mesh: `obvhs` builds it, the rays of a block go through it side by side
//! (`wide`), and an f64 test decides wherever f32 could err.
//!
//! The only f32 of the crate lives in these two files. Boxes are padded outward by more than all f32 rounding of a ray can add up to,
//! and the triangle test decides shared edges from the same number on both sides, so that no ray slips between
//! neighbours. `Bvh2` is used because the compressed hierarchy loses hits nearer than 1e-4.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use pulp::NullaryFnOnce;

use super::segment::Segment;
use super::wide::{Boxes, Portable, SingleRay, Wide};
use super::{ShadowCache, ShadowRays};
use crate::geometry::Mesh;
use crate::sampling::{LANES, Row, groups};

/// Outward padding of boxes in a scene scaled to [−1, 1]. A ray's origin and direction are rounded to f32 (2⁻²⁴ each,
/// coordinates up to 2), the slab test adds four more roundings: below 1e-6 together.
const PADDING: f32 = 2e-6;

/// A part of a direction below this, in a scene scaled to [−1, 1], is taken for it: less than the padding at the ray's end.
const SMALLEST: f32 = f32::EPSILON;

/// Rays of a block that visit the hierarchy together.
const TOGETHER: usize = 32;

/// Triangles of one mesh, and the boxes around them.
pub struct Hierarchy {
    wide: Wide,
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
        let boxes: Vec<Aabb> = (0..mesh.triangles().len())
            .map(|triangle| {
                let points = mesh.corners(triangle).map(|p| ((p - middle) * scale).as_vec3a());
                Aabb::new(
                    points[0].min(points[1]).min(points[2]) - Vec3A::splat(PADDING),
                    points[0].max(points[1]).max(points[2]) + Vec3A::splat(PADDING),
                )
            })
            .collect();
        let mut spent = std::time::Duration::ZERO;
        let bvh = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut spent);
        drop(boxes);
        Hierarchy { wide: Wide::new(&bvh, mesh, middle, scale), middle, scale }
    }

    /// Metres.
    pub(super) fn vertices(&self) -> &[DVec3] {
        self.wide.vertices()
    }

    /// Corners of the triangles among the vertices, neighbours together; some follow upon themselves.
    pub(super) fn faces(&self) -> &[[u32; 3]] {
        self.wide.faces()
    }

    /// Whether a triangle lies strictly between two points.
    pub fn blocks(&self, from: DVec3, to: DVec3) -> bool {
        on_this_machine(One { hierarchy: self, from, to })
    }

    /// Sets to zero the contributions of the rays that this blocks, among the first `len` of a block. A ray that carries
    /// nothing (padding, too) is not traced.
    ///
    /// - `from`: the shading point, metres
    /// - `cache`: what blocked last, to be asked first; it changes no answer
    pub fn shade(
        &self,
        from: DVec3,
        rays: &ShadowRays,
        len: usize,
        contributions: &mut Row,
        cache: Option<&mut ShadowCache>,
    ) {
        on_this_machine(Block { hierarchy: self, from, rays, len, contributions, cache });
    }

    /// A segment in units of the hierarchy.
    #[inline(always)]
    fn in_f32(&self, from: DVec3, to: DVec3) -> SingleRay {
        let origin = ((from - self.middle) * self.scale).as_vec3();
        let direction = ((to - from) * self.scale).as_vec3();
        SingleRay::new(origin.to_array(), direction.to_array(), SMALLEST, 1.0 + PADDING)
    }

    /// The same answer from testing every triangle: the witness, and the yardstick of the timings.
    pub fn blocks_by_brute_force(&self, from: DVec3, to: DVec3) -> bool {
        Segment::new(from, to).is_some_and(|segment| self.wide.triangles().any(|triangle| segment.meets(&triangle)))
    }
}

/// Rays to be traced with the widest registers that this machine has.
trait Traced {
    type Answer;
    fn trace<R: Boxes>(self, registers: R) -> Self::Answer;
}

#[cfg(target_arch = "x86_64")]
fn on_this_machine<T: Traced>(rays: T) -> T::Answer {
    struct Wider<T>(pulp::x86::V3, T);
    impl<T: Traced> NullaryFnOnce for Wider<T> {
        type Output = T::Answer;
        #[inline(always)]
        fn call(self) -> T::Answer {
            self.1.trace(self.0)
        }
    }
    match pulp::x86::V3::try_new() {
        Some(registers) => registers.vectorize(Wider(registers, rays)),
        None => rays.trace(Portable),
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn on_this_machine<T: Traced>(rays: T) -> T::Answer {
    rays.trace(Portable)
}

/// One ray.
struct One<'a> {
    hierarchy: &'a Hierarchy,
    from: DVec3,
    to: DVec3,
}

impl Traced for One<'_> {
    type Answer = bool;

    #[inline(always)]
    fn trace<R: Boxes>(self, registers: R) -> bool {
        let One { hierarchy, from, to } = self;
        let (mut ends, mut by) = ([Some(to)], [ShadowCache::NOTHING]);
        hierarchy.wide.block(registers, from, &mut ends, &[hierarchy.in_f32(from, to)], &mut by);
        ends[0].is_none()
    }
}

/// The rays of a block.
struct Block<'a> {
    hierarchy: &'a Hierarchy,
    from: DVec3,
    rays: &'a ShadowRays,
    len: usize,
    contributions: &'a mut Row,
    cache: Option<&'a mut ShadowCache>,
}

impl Traced for Block<'_> {
    type Answer = ();

    #[expect(clippy::needless_range_loop, reason = "one index over several rows")]
    #[inline(always)]
    fn trace<R: Boxes>(self, registers: R) {
        let Block { hierarchy, from, rays, len, contributions, cache } = self;
        let mut none = ShadowCache::default();
        let is_kept = cache.is_some();
        let cache = cache.unwrap_or(&mut none);
        let is_asked = is_kept && cache.is_asked();
        let (mut asked, mut helped) = (0, 0);
        let some = TOGETHER / LANES;
        for start in (0..groups(len)).step_by(some) {
            let (mut to, mut in_f32) = ([None; TOGETHER], [SingleRay::default(); TOGETHER]);
            let mut by = [ShadowCache::NOTHING; TOGETHER];
            for g in start..(start + some).min(groups(len)) {
                for l in 0..LANES {
                    if contributions[g][l] != 0.0 {
                        let (end, ray) = (from + rays.ray(g, l), (g - start) * LANES + l);
                        in_f32[ray] = hierarchy.in_f32(from, end);
                        to[ray] = Some(end);
                        if is_asked {
                            let last = cache.parts[g * LANES + l];
                            asked += 1;
                            if hierarchy.wide.part_blocks(registers, last, &in_f32[ray], from, end) {
                                (contributions[g][l], to[ray]) = (0.0, None);
                                helped += 1;
                            }
                        }
                    }
                }
            }
            hierarchy.wide.block(registers, from, &mut to, &in_f32, &mut by);
            for (ray, to) in to.iter().enumerate() {
                if to.is_none() {
                    contributions[start + ray / LANES][ray % LANES] = 0.0;
                }
                if by[ray] != ShadowCache::NOTHING {
                    cache.parts[start * LANES + ray] = by[ray];
                }
            }
        }
        cache.count(asked, helped);
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
            assert_eq!(
                One { hierarchy: &hierarchy, from, to }.trace(Portable),
                hit,
                "on any machine: {from} to {to}"
            );
            let alone = hierarchy.wide.blocks_below(0, &hierarchy.in_f32(from, to), from, to);
            assert_eq!(alone, hit, "deeper than there is room for: {from} to {to}");
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
    fn a_block_of_rays_is_its_rays_one_by_one_whatever_the_cache_holds() {
        let hierarchy = hierarchy(20);
        let mut draws = Stream::new(StreamKey::root(15));
        let (mut stopped, mut let_through, mut at_once) = (0, 0, 0);
        for len in [1, 7, 8, 33, 100, 128] {
            let ends: Vec<DVec3> = (0..len)
                .map(|_| DVec3::new(draws.random_range(-1.0..1.0), draws.random_range(-1.0..1.0), 2.0))
                .collect();
            // Left over from elsewhere: parts that there are, and parts that there are not.
            let left_over = std::array::from_fn(|_| draws.random_range(0..200));
            let mut cache = ShadowCache::holding(left_over);
            // Points close to each other, with the same ends.
            for step in 0..6 {
                let from = DVec3::new(-0.5 + 1e-3 * f64::from(step), 0.1, 0.0);
                let mut rays = ShadowRays::default();
                for (k, end) in ends.iter().enumerate() {
                    (rays.x[k / LANES][k % LANES], rays.y[k / LANES][k % LANES], rays.z[k / LANES][k % LANES]) =
                        (*end - from).into();
                }
                let carried = |k: usize| if k < len { (k % 3) as f64 } else { 0.0 };
                let mut contributions = Row::default();
                for (k, contribution) in contributions.as_flattened_mut().iter_mut().enumerate() {
                    *contribution = carried(k);
                }
                let mut without = contributions;
                let before = cache.clone();
                hierarchy.shade(from, &rays, len, &mut contributions, Some(&mut cache));
                hierarchy.shade(from, &rays, len, &mut without, None);
                assert_eq!(contributions, without);
                for (k, contribution) in contributions.as_flattened().iter().enumerate() {
                    let blocked = k < len && hierarchy.blocks(from, from + rays.ray(k / LANES, k % LANES));
                    assert_eq!(*contribution, if blocked { 0.0 } else { carried(k) }, "ray {k} of {len}");
                    stopped += u32::from(blocked && carried(k) > 0.0);
                    let_through += u32::from(*contribution > 0.0);
                    let is_kept = step > 0 && before.parts[k] == cache.parts[k];
                    at_once += u32::from(blocked && carried(k) > 0.0 && is_kept);
                }
            }
        }
        assert!(stopped > 100 && let_through > 100, "both outcomes are common: {stopped}, {let_through}");
        assert!(at_once > 50, "what blocked last blocks again: {at_once} of {stopped}");
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
