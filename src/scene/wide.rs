//! Eight boxes and eight triangles at a time: the hierarchy of `obvhs`, its binary nodes gathered into wide ones.
//!
//! f32 rules out, and settles what lies clear of every edge by more than its own errors; the rest is decided in f64 by
//! [`Segment::meets`]. So an answer is always the one of the f64 test, on every instruction set and in any order of visits.

use glam::DVec3;
use obvhs::bvh2::Bvh2;

use super::segment::Segment;
use crate::geometry::Mesh;

/// Children of a node, triangles of a pack.
pub(super) const WIDTH: usize = 8;
/// Nodes that a ray may leave for later: seven on each of eight levels, and the children of one more.
const ROOM: usize = 64;
/// Marks a child that is packs of triangles: how many stands in the bits below, then the first of them.
const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 25;

/// How far a corner's f32 coordinates across the ray may be off, in a scene scaled to [−1, 1]: ends and corners are
/// rounded (2⁻²⁵ each), so are their differences (2⁻²⁴), the shear (4 · 2⁻²⁴ of at most 1, times at most 2 along the ray),
/// what it is multiplied with, the product and the difference: 9e-7 together.
const DOUBT: f32 = 1e-6;
/// The same for a difference of two products of such coordinates, per size of either corner: with the rounding of the
/// products (2⁻²³ of one size times the other, which is at most 4 of both).
const EDGE_DOUBT: f32 = 1.6e-6;

/// Eight boxes, and what lies in each.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    /// Low and high x, low and high y, low and high z.
    sides: [[f32; WIDTH]; 6],
    /// Nodes first, then packs.
    children: [u32; WIDTH],
    /// One bit for each child that is a node.
    nodes: u32,
}

/// Corners of eight triangles in f32, the last repeated where there are fewer.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(super) struct Pack {
    /// `[corner][axis][triangle]`, in units of the hierarchy.
    corners: [[[f32; WIDTH]; 3]; 3],
}

/// A ray in f32, as boxes and packs are asked about it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SingleRay {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// Which of a node's sides is met first along each axis.
    near: [usize; 3],
    /// How far the ray goes, in its own length.
    end: f32,
    /// Axes, the longest of the direction last, and how far the other two move along it.
    axes: [usize; 3],
    shear: [f32; 2],
}

impl SingleRay {
    /// - `smallest`: a part of the direction below this is taken for it
    /// - `end`: how far the ray goes, in its own length
    #[inline(always)]
    pub(super) fn new(origin: [f32; 3], direction: [f32; 3], smallest: f32, end: f32) -> SingleRay {
        let (mut inverse, mut near) = ([0.0; 3], [0; 3]);
        for axis in 0..3 {
            let along = direction[axis];
            inverse[axis] = 1.0 / if along.abs() < smallest { smallest.copysign(along) } else { along };
            near[axis] = 2 * axis + usize::from(inverse[axis] < 0.0);
        }
        let size = [direction[0].abs(), direction[1].abs(), direction[2].abs()];
        let axes = if size[0] >= size[1] && size[0] >= size[2] {
            [1, 2, 0]
        } else if size[1] >= size[2] {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let shear = [direction[axes[0]] * inverse[axes[2]], direction[axes[1]] * inverse[axes[2]]];
        SingleRay { origin, inverse, near, end, axes, shear }
    }
}

/// What f32 knows of the triangles of a pack: one bit for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Known {
    /// May be met.
    open: u32,
    /// Is met, without doubt.
    sure: u32,
}

/// What is asked of a node and of a pack, on one instruction set.
pub(super) trait Boxes: Copy {
    /// One bit for each box that the ray may meet.
    fn boxes(self, node: &Node, ray: &SingleRay) -> u32;
    /// The children with a bit, moved to the front.
    fn to_the_front(self, children: &[u32; WIDTH], bits: u32) -> [u32; WIDTH];
    /// What can be said without f64.
    fn triangles(self, pack: &Pack, ray: &SingleRay) -> Known;
}

/// Any machine.
#[derive(Clone, Copy)]
pub(super) struct Portable;

impl Boxes for Portable {
    #[inline(always)]
    fn boxes(self, node: &Node, ray: &SingleRay) -> u32 {
        let (mut enters, mut leaves) = ([0.0_f32; WIDTH], [ray.end; WIDTH]);
        for axis in 0..3 {
            let (near, far) = (&node.sides[ray.near[axis]], &node.sides[ray.near[axis] ^ 1]);
            for k in 0..WIDTH {
                let enter = (near[k] - ray.origin[axis]) * ray.inverse[axis];
                let leave = (far[k] - ray.origin[axis]) * ray.inverse[axis];
                enters[k] = if enter > enters[k] { enter } else { enters[k] };
                leaves[k] = if leave < leaves[k] { leave } else { leaves[k] };
            }
        }
        (0..WIDTH).fold(0, |bits, k| bits | u32::from(enters[k] <= leaves[k]) << k)
    }

    #[inline(always)]
    fn to_the_front(self, children: &[u32; WIDTH], bits: u32) -> [u32; WIDTH] {
        ORDERS[bits as usize & 0xff].map(|k| children[k as usize])
    }

    #[inline(always)]
    fn triangles(self, _: &Pack, _: &SingleRay) -> Known {
        Known { open: 0xff, sure: 0 }
    }
}

/// For each set of bits: their places, in order, then zeros.
static ORDERS: [[u8; WIDTH]; 256] = orders();

const fn orders() -> [[u8; WIDTH]; 256] {
    let mut orders = [[0; WIDTH]; 256];
    let mut bits = 0;
    while bits < 256 {
        let (mut place, mut k) = (0, 0);
        while k < WIDTH {
            if bits >> k & 1 == 1 {
                orders[bits][place] = k as u8;
                place += 1;
            }
            k += 1;
        }
        bits += 1;
    }
    orders
}

/// Written without closures and `map`: what is not marked to be inlined is compiled for the oldest machine.
#[cfg(target_arch = "x86_64")]
impl Boxes for pulp::x86::V3 {
    #[inline(always)]
    fn boxes(self, node: &Node, ray: &SingleRay) -> u32 {
        use pulp::{Simd, cast, f32x8};
        let (mut enters, mut leaves) = (self.splat_f32s(0.0), self.splat_f32s(ray.end));
        for axis in 0..3 {
            let (origin, inverse) = (self.splat_f32s(ray.origin[axis]), self.splat_f32s(ray.inverse[axis]));
            let near: f32x8 = cast(node.sides[ray.near[axis]]);
            let far: f32x8 = cast(node.sides[ray.near[axis] ^ 1]);
            enters = self.max_f32s(self.mul_f32s(self.sub_f32s(near, origin), inverse), enters);
            leaves = self.min_f32s(self.mul_f32s(self.sub_f32s(far, origin), inverse), leaves);
        }
        self.avx._mm256_movemask_ps(cast(self.cmp_le_f32x8(enters, leaves))) as u32
    }

    #[inline(always)]
    fn to_the_front(self, children: &[u32; WIDTH], bits: u32) -> [u32; WIDTH] {
        use pulp::cast;
        let order = u64::from_le_bytes(ORDERS[bits as usize & 0xff]);
        let order = self.avx2._mm256_cvtepu8_epi32(cast([order, 0]));
        cast(self.avx2._mm256_permutevar8x32_epi32(cast(*children), order))
    }

    #[inline(always)]
    fn triangles(self, pack: &Pack, ray: &SingleRay) -> Known {
        use pulp::{Simd, cast};
        let a = sheared(self, &pack.corners[0], ray);
        let b = sheared(self, &pack.corners[1], ray);
        let c = sheared(self, &pack.corners[2], ray);
        let u = self.sub_f32s(self.mul_f32s(c[0], b[1]), self.mul_f32s(c[1], b[0]));
        let v = self.sub_f32s(self.mul_f32s(a[0], c[1]), self.mul_f32s(a[1], c[0]));
        let w = self.sub_f32s(self.mul_f32s(b[0], a[1]), self.mul_f32s(b[1], a[0]));
        let size_a = self.add_f32s(self.abs_f32s(a[0]), self.abs_f32s(a[1]));
        let size_b = self.add_f32s(self.abs_f32s(b[0]), self.abs_f32s(b[1]));
        let size_c = self.add_f32s(self.abs_f32s(c[0]), self.abs_f32s(c[1]));
        let (doubt, least) = (self.splat_f32s(EDGE_DOUBT), self.splat_f32s(2.0 * DOUBT * DOUBT));
        let u_doubt = self.add_f32s(self.mul_f32s(doubt, self.add_f32s(size_b, size_c)), least);
        let v_doubt = self.add_f32s(self.mul_f32s(doubt, self.add_f32s(size_c, size_a)), least);
        let w_doubt = self.add_f32s(self.mul_f32s(doubt, self.add_f32s(size_a, size_b)), least);
        let (u_left, u_right) = (self.cmp_gt_f32x8(u, u_doubt), self.cmp_lt_f32x8(u, self.neg_f32s(u_doubt)));
        let (v_left, v_right) = (self.cmp_gt_f32x8(v, v_doubt), self.cmp_lt_f32x8(v, self.neg_f32s(v_doubt)));
        let (w_left, w_right) = (self.cmp_gt_f32x8(w, w_doubt), self.cmp_lt_f32x8(w, self.neg_f32s(w_doubt)));
        let any_left = self.or_m32s(self.or_m32s(u_left, v_left), w_left);
        let any_right = self.or_m32s(self.or_m32s(u_right, v_right), w_right);
        let outside = self.avx._mm256_movemask_ps(cast(self.and_m32s(any_left, any_right))) as u32;
        let open = !outside & 0xff;
        if open == 0 {
            return Known { open, sure: 0 };
        }
        let all_left = self.and_m32s(self.and_m32s(u_left, v_left), w_left);
        let all_right = self.and_m32s(self.and_m32s(u_right, v_right), w_right);
        let inside = self.or_m32s(all_left, all_right);
        // All three corners between the ends, by more than they may be off.
        let inverse = ray.inverse[ray.axes[2]];
        let margin = 2.0 * DOUBT * inverse.abs();
        let (low, high) = (self.splat_f32s(margin), self.splat_f32s(1.0 - margin));
        let scale = self.splat_f32s(inverse);
        let (ta, tb, tc) = (self.mul_f32s(a[2], scale), self.mul_f32s(b[2], scale), self.mul_f32s(c[2], scale));
        let first = self.min_f32s(self.min_f32s(ta, tb), tc);
        let last = self.max_f32s(self.max_f32s(ta, tb), tc);
        let between = self.and_m32s(self.cmp_gt_f32x8(first, low), self.cmp_lt_f32x8(last, high));
        let sure = self.avx._mm256_movemask_ps(cast(self.and_m32s(inside, between))) as u32;
        Known { open, sure }
    }
}

/// Eight corners as the ray sees them: across it, and along it.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn sheared(registers: pulp::x86::V3, corners: &[[f32; WIDTH]; 3], ray: &SingleRay) -> [pulp::f32x8; 3] {
    use pulp::{Simd, cast, f32x8};
    let [x, y, z] = ray.axes;
    let along: f32x8 = registers.sub_f32s(cast(corners[z]), registers.splat_f32s(ray.origin[z]));
    let first: f32x8 = registers.sub_f32s(cast(corners[x]), registers.splat_f32s(ray.origin[x]));
    let second: f32x8 = registers.sub_f32s(cast(corners[y]), registers.splat_f32s(ray.origin[y]));
    let shear = [registers.splat_f32s(ray.shear[0]), registers.splat_f32s(ray.shear[1])];
    [
        registers.sub_f32s(first, registers.mul_f32s(shear[0], along)),
        registers.sub_f32s(second, registers.mul_f32s(shear[1], along)),
        along,
    ]
}

/// Triangles in a hierarchy of eights.
pub(super) struct Wide {
    nodes: Vec<Node>,
    packs: Vec<Pack>,
    /// Corners of the triangles of the packs, eight for each.
    faces: Vec<[u32; 3]>,
    /// Metres.
    vertices: Vec<DVec3>,
}

impl Wide {
    /// - `bvh`: over the triangles of `faces`, its boxes padded
    /// - `middle`, `scale`: from metres to units of the hierarchy
    pub(super) fn new(bvh: &Bvh2, mesh: &Mesh, middle: DVec3, scale: f64) -> Wide {
        let mut wide =
            Wide { nodes: vec![Node::empty()], packs: vec![], faces: vec![], vertices: mesh.vertices().to_vec() };
        if bvh.nodes.is_empty() {
            return wide;
        }
        // Binary nodes, and the wide nodes that are to hold what is below them.
        let mut open = vec![(0_usize, 0_usize)];
        let mut own = Vec::new();
        while let Some((binary, place)) = open.pop() {
            for (k, below) in children_of(bvh, binary).into_iter().enumerate() {
                let aabb = bvh.nodes[below].aabb();
                for axis in 0..3 {
                    wide.nodes[place].sides[2 * axis][k] = aabb.min[axis];
                    wide.nodes[place].sides[2 * axis + 1][k] = aabb.max[axis];
                }
                own.clear();
                wide.nodes[place].children[k] = if goes_into_packs(bvh, below, &mut own) {
                    let own =
                        own.iter().map(|place| mesh.triangles()[bvh.primitive_indices[*place as usize] as usize]);
                    wide.pack(own.collect(), middle, scale)
                } else {
                    wide.nodes[place].nodes |= 1 << k;
                    wide.nodes.push(Node::empty());
                    open.push((below, wide.nodes.len() - 1));
                    wide.nodes.len() as u32 - 1
                };
            }
        }
        // What grew by doubling holds up to twice what it needs.
        wide.nodes.shrink_to_fit();
        wide.packs.shrink_to_fit();
        wide.faces.shrink_to_fit();
        wide
    }

    /// Puts triangles into packs; gives the child that stands for them.
    fn pack(&mut self, own: Vec<[u32; 3]>, middle: DVec3, scale: f64) -> u32 {
        let first = self.packs.len();
        for eight in own.chunks(WIDTH) {
            let full: [[u32; 3]; WIDTH] = std::array::from_fn(|k| eight[k.min(eight.len() - 1)]);
            self.faces.extend(full);
            let corners = [0, 1, 2].map(|corner| {
                let points = full.map(|face| ((self.vertices[face[corner] as usize] - middle) * scale).as_vec3());
                [0, 1, 2].map(|axis| points.map(|point| point[axis]))
            });
            self.packs.push(Pack { corners });
        }
        let count = self.packs.len() - first;
        assert!(count < 1 << (31 - COUNT_SHIFT) && first < 1 << COUNT_SHIFT, "2²⁵ packs of eight are room enough");
        LEAF | ((count as u32) << COUNT_SHIFT) | first as u32
    }

    pub(super) fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }
    pub(super) fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// All triangles, some of them more than once.
    pub(super) fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> {
        self.faces.iter().map(|face| self.corners(face))
    }

    /// Metres.
    #[inline(always)]
    fn corners(&self, face: &[u32; 3]) -> [DVec3; 3] {
        [self.vertices[face[0] as usize], self.vertices[face[1] as usize], self.vertices[face[2] as usize]]
    }

    /// Which of the rays are blocked, all of them from one point: sets their `to` to `None`.
    ///
    /// In each round every ray visits one node; the packs that were found are looked at when the round is over. What a visit
    /// finds is queued without a branch on it, so that the machine neither waits for one ray nor guesses its way.
    ///
    /// - `rays`: each ray that has an end
    /// - `by`: of each ray that a part of the mesh blocks, that part: for [`Wide::part_blocks`]
    #[inline(always)]
    pub(super) fn block<R: Boxes, const N: usize>(
        &self,
        registers: R,
        from: DVec3,
        to: &mut [Option<DVec3>; N],
        rays: &[SingleRay; N],
        by: &mut [u32; N],
    ) {
        // Each ray's nodes still to be visited, the root first.
        let (mut nodes, mut left) = ([[0_u32; ROOM]; N], [1_usize; N]);
        let (mut packs, mut packs_of, mut found) = ([[0_u32; WIDTH]; N], [0_u32; N], [0_u32; N]);
        let (mut active, mut n_active) = ([0_u32; N], 0);
        for (ray, end) in to.iter().enumerate() {
            active[n_active] = ray as u32;
            n_active += usize::from(end.is_some());
        }
        while n_active > 0 {
            let mut n_found = 0;
            for ray in active.into_iter().take(n_active) {
                let at = ray as usize % N;
                left[at] -= 1;
                let place = nodes[at][left[at] % ROOM];
                let node = &self.nodes[place as usize];
                let met = registers.boxes(node, &rays[at]);
                let (inner, outer) = (met & node.nodes, met & !node.nodes);
                match nodes[at][left[at] % ROOM..].first_chunk_mut() {
                    Some(free) => {
                        *free = registers.to_the_front(&node.children, inner);
                        left[at] += inner.count_ones() as usize;
                    }
                    // More levels than there is room for: by itself, to the end.
                    None => {
                        if to[at].is_some_and(|end| self.blocks_below(place, &rays[at], from, end)) {
                            to[at] = None;
                        }
                    }
                }
                packs[n_found] = registers.to_the_front(&node.children, outer);
                packs_of[n_found] = ray;
                found[n_found] = outer.count_ones();
                n_found += usize::from(outer != 0);
            }
            for k in 0..n_found {
                let at = packs_of[k] as usize % N;
                let Some(end) = to[at] else { continue };
                for child in packs[k].into_iter().take(found[k] as usize) {
                    let (first, count) = (child & ((1 << COUNT_SHIFT) - 1), (child & !LEAF) >> COUNT_SHIFT);
                    for pack in first..first + count {
                        if self.pack_blocks(registers, pack, &rays[at], from, end) {
                            to[at] = None;
                            by[at] = pack;
                            break;
                        }
                    }
                }
            }
            let mut n_next = 0;
            for k in 0..n_active {
                let ray = active[k];
                let at = ray as usize % N;
                active[n_next] = ray;
                n_next += usize::from((left[at] > 0) & to[at].is_some());
            }
            n_active = n_next;
        }
    }

    /// Whether anything below a node blocks a segment, however deep that is.
    #[cold]
    pub(super) fn blocks_below(&self, node: u32, ray: &SingleRay, from: DVec3, to: DVec3) -> bool {
        let mut open = vec![node];
        while let Some(place) = open.pop() {
            let node = &self.nodes[place as usize];
            let met = Portable.boxes(node, ray);
            for (k, child) in node.children.into_iter().enumerate().filter(|(k, _)| met >> k & 1 == 1) {
                if node.nodes >> k & 1 == 1 {
                    open.push(child);
                    continue;
                }
                let (first, count) = (child & ((1 << COUNT_SHIFT) - 1), (child & !LEAF) >> COUNT_SHIFT);
                if (first..first + count).any(|pack| self.pack_blocks(Portable, pack, ray, from, to)) {
                    return true;
                }
            }
        }
        false
    }

    /// Whether one part of the mesh, if there is such a part, blocks a segment.
    #[inline(always)]
    pub(super) fn part_blocks<R: Boxes>(
        &self,
        registers: R,
        part: u32,
        ray: &SingleRay,
        from: DVec3,
        to: DVec3,
    ) -> bool {
        (part as usize) < self.packs.len() && self.pack_blocks(registers, part, ray, from, to)
    }

    /// Whether a triangle of a pack blocks a segment.
    #[inline(always)]
    fn pack_blocks<R: Boxes>(&self, registers: R, pack: u32, ray: &SingleRay, from: DVec3, to: DVec3) -> bool {
        let known = registers.triangles(&self.packs[pack as usize], ray);
        known.open != 0 && (known.sure != 0 || self.blocks_in_f64(pack, known.open, from, to))
    }

    /// Whether one of the triangles with a bit blocks a segment, in f64.
    #[cold]
    #[inline(never)]
    fn blocks_in_f64(&self, pack: u32, open: u32, from: DVec3, to: DVec3) -> bool {
        let Some(segment) = Segment::new(from, to) else { return false };
        let faces = &self.faces[pack as usize * WIDTH..][..WIDTH];
        let mut open = (0..WIDTH).filter(|k| open >> k & 1 == 1);
        open.any(|k| segment.meets(&self.corners(&faces[k])))
    }
}

impl Node {
    /// Boxes that no ray meets.
    fn empty() -> Node {
        let (low, high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Node { sides: [low, high, low, high, low, high], children: [LEAF; WIDTH], nodes: 0 }
    }
}

/// A binary node's descendants that become the children of a wide one: the widest boxes are opened first. Children are
/// visited last to first, so the widest comes last.
fn children_of(bvh: &Bvh2, binary: usize) -> Vec<usize> {
    let node = &bvh.nodes[binary];
    if node.is_leaf() {
        return vec![binary];
    }
    let area = |node: usize| bvh.nodes[node].aabb().half_area();
    let first = node.first_index as usize;
    let mut children = vec![first, first + 1];
    while children.len() < WIDTH {
        let open = children.iter().enumerate().filter(|(_, child)| !goes_into_packs(bvh, **child, &mut Vec::new()));
        let Some((k, widest)) = open.max_by(|(_, a), (_, b)| area(**a).total_cmp(&area(**b))) else { break };
        let first = bvh.nodes[*widest].first_index as usize;
        children[k] = first;
        children.push(first + 1);
    }
    children.sort_by(|a, b| area(*a).total_cmp(&area(*b)));
    children
}

/// Whether what lies below a binary node goes into packs: a leaf does, and what fills one pack at most. Gives their places
/// in the order of the leaves.
fn goes_into_packs(bvh: &Bvh2, node: usize, own: &mut Vec<u32>) -> bool {
    let node = &bvh.nodes[node];
    let first = node.first_index;
    if node.is_leaf() {
        own.extend(first..first + node.prim_count);
        return true;
    }
    own.len() < WIDTH
        && [first, first + 1].into_iter().all(|child| goes_into_packs(bvh, child as usize, own))
        && own.len() <= WIDTH
}
