//! A mesh as seen from one point: the edges at which what it covers may end, and how many faces lie in a direction.
//!
//! Each face is taken as running counter-clockwise as seen. At an edge with l faces on its left and r on its right the
//! number of faces in a direction changes by l − r: edges between neighbours drop out, and what is left are the silhouette's
//! folds (2 − 0), open borders (1 − 0), and where more than two faces meet. The set that is covered can end only where all
//! faces lie on one side (Appel 1967): these edges are the curves of the piece.
//!
//! The number of faces in a direction is found by counting such edges along a great circle from a direction where it is
//! known. All edges at a corner use the same bits for it, so that no path slips through between two of them.

use glam::DVec3;

use super::form::HalfSpace;
use super::great_arc::GreatArc;
use super::surface::Surface;
use crate::number::{Number, Vector};

/// A mesh relative to the eye.
#[derive(Clone, Debug)]
pub(super) struct SurfaceForm<'a, T = f64> {
    pub surface: &'a Surface,
    pub eye: Vector<T>,
    /// The middle of a ball around it, and that ball's radius.
    pub center: DVec3,
    pub reach: f64,
}

impl<T: Number> SurfaceForm<'_, T> {
    fn corner(&self, i: u32) -> Vector<T> {
        Vector::constant(self.surface.points[i as usize]) - self.eye
    }
}

/// Where a curve of the outline comes from.
#[derive(Clone, Copy, Debug)]
enum Origin {
    /// An edge, faces on its left; where an end is not kept, it stops at the cutting plane.
    Edge { from: u32, to: u32, cut: [bool; 2] },
    /// Where a face is cut: the edges on which the chord starts and ends, each as (kept corner, lost corner).
    Chord { face: u32, start: [u32; 2], end: [u32; 2] },
}

/// An edge at which the number of faces changes.
#[derive(Clone, Debug)]
struct Step {
    arc: GreatArc,
    /// How many faces more there are on the left.
    weight: i32,
}

/// How many faces lie in a direction.
#[derive(Clone, Debug)]
pub(super) struct Coverage {
    /// Those that are curves of the piece come first, in its order.
    steps: Vec<Step>,
    /// How many of them are curves.
    curves: usize,
    /// Directions and how many faces lie there.
    known: Vec<(DVec3, i32)>,
}

/// What can be seen of a mesh: its curves and how much they cover. `None` where nothing is left.
pub(super) fn outline<T: Number>(
    form: &SurfaceForm<T>,
    keep: Option<HalfSpace<T>>,
) -> Option<(Vec<GreatArc<T>>, Coverage, bool)> {
    let eye = Vector::constant(form.eye.primal());
    let plain = SurfaceForm { surface: form.surface, eye, center: form.center, reach: form.reach };
    let plain_keep =
        keep.map(|keep| HalfSpace { normal: Vector::constant(keep.normal.primal()), k: keep.k.primal() });
    let view = View::new(&plain, plain_keep)?;
    let (mut origins, mut steps) = (Vec::new(), Vec::new());
    let mut inner = Vec::new();
    for (origin, weight, is_curve) in view.steps() {
        let Some(arc) = realized(&plain, plain_keep.as_ref(), origin) else { continue };
        if is_curve {
            origins.push(origin);
            steps.push(Step { arc, weight });
        } else {
            inner.push(Step { arc, weight });
        }
    }
    let curves = steps.len();
    steps.extend(inner);
    let mut coverage = Coverage { steps, curves, known: Vec::with_capacity(4) };
    view.look_around(&mut coverage);
    if curves == 0 && coverage.known[0].1 == 0 {
        return None;
    }
    let arcs: Option<Vec<_>> = origins.iter().map(|origin| realized(form, keep.as_ref(), *origin)).collect();
    Some((arcs?, coverage, view.is_cut))
}

fn realized<T: Number>(form: &SurfaceForm<T>, keep: Option<&HalfSpace<T>>, origin: Origin) -> Option<GreatArc<T>> {
    let surface = form.surface;
    let line = |i: u32, j: u32| {
        Vector::<T>::constant(surface.points[j as usize]) - Vector::constant(surface.points[i as usize])
    };
    // In one order whichever face asks, so that all get the same bits.
    let on_plane = |[kept, lost]: [u32; 2]| {
        let (p, q) = (form.corner(kept), form.corner(lost));
        let Some(keep) = keep else { return p };
        let (hp, hq) = (keep.height(p), keep.height(q));
        if hp.primal() <= 0.0 { p } else { p + line(kept, lost) * (hp / (hp - hq)) }
    };
    match origin {
        Origin::Edge { from, to, cut } => {
            let p = if cut[0] { on_plane([to, from]) } else { form.corner(from) };
            let q = if cut[1] { on_plane([from, to]) } else { form.corner(to) };
            let line = line(from, to);
            let share =
                if cut == [false, false] { T::constant(1.0) } else { (q - p).dot(line) / line.length_squared() };
            GreatArc::of_edge([p, q], line, share, [p.normalize(), q.normalize()])
        }
        Origin::Chord { face, start, end } => {
            let keep = keep?;
            let [a, b, c] = surface.faces[face as usize];
            let normal = line(a, b).cross(line(a, c));
            let height = normal.dot(form.corner(a));
            let plane = if keep.k.primal() == 0.0 {
                keep.normal
            } else {
                // Towards what is kept, whichever way the face is wound.
                let towards = keep.normal * height + normal * keep.k;
                let size = towards.length();
                if size.primal() == 0.0 {
                    return None;
                }
                towards * (T::constant(1.0f64.copysign(height.primal())) / size)
            };
            GreatArc::on_circle(on_plane(start), on_plane(end), plane)
        }
    }
}

/// What of the mesh counts: decided once, over `f64`.
struct View<'a> {
    form: &'a SurfaceForm<'a>,
    keep: Option<HalfSpace>,
    /// Before the cutting plane, rounding taken for zero; empty where nothing is cut.
    heights: Vec<f64>,
    /// Of each face: whether it runs counter-clockwise (1) or clockwise (−1) as seen; 0 if it is seen edge-on, or nothing is
    /// left of it.
    turns: Vec<i8>,
    is_cut: bool,
}

impl<'a> View<'a> {
    fn new(form: &'a SurfaceForm<'a>, keep: Option<HalfSpace>) -> Option<View<'a>> {
        let surface = form.surface;
        let eye = form.eye.primal();
        let farthest = (form.center - eye).length() + form.reach;
        let mut heights = Vec::new();
        if let Some(keep) = keep {
            let normal = keep.normal.primal();
            let noise = 4.0 * f64::EPSILON * (farthest + keep.k.abs());
            if normal.dot(form.center - eye) + keep.k < form.reach + noise {
                heights.extend(surface.points.iter().map(|p| {
                    let h = normal.dot(*p - eye) + keep.k;
                    if h.abs() <= noise { 0.0 } else { h }
                }));
                // Where a corner lies in the plane they stay: a face that lies in it goes.
                if heights.iter().all(|h| *h > 0.0) {
                    heights.clear();
                }
            }
        }
        let is_cut = heights.iter().any(|h| *h < 0.0);
        let slack = (4.0 * f64::EPSILON * farthest).powi(2);
        let turns = surface
            .faces
            .iter()
            .map(|face| {
                if !heights.is_empty() && face.iter().all(|i| heights[*i as usize] <= 0.0) {
                    return 0;
                }
                let [a, b, c] = face.map(|i| surface.points[i as usize]);
                let normal = (b - a).cross(c - a);
                let along = normal.dot(a - eye);
                if along * along <= slack * normal.length_squared() {
                    0
                } else if along > 0.0 {
                    1
                } else {
                    -1
                }
            })
            .collect();
        let view = View { form, keep, heights, turns, is_cut };
        view.turns.iter().any(|turn| *turn != 0).then_some(view)
    }

    fn is_lost(&self, i: u32) -> bool {
        self.is_cut && self.heights[i as usize] < 0.0
    }

    /// Edges at which the number of faces changes, by how much, and whether all faces lie on one side.
    fn steps(&self) -> impl Iterator<Item = (Origin, i32, bool)> + '_ {
        let surface = self.form.surface;
        let of_edge = move |(i, [low, high]): (usize, &[u32; 2])| {
            let (mut left, mut right) = (0, 0);
            for beside in surface.beside(i) {
                match (self.turns[beside.face()], beside.is_upward()) {
                    (0, _) => {}
                    (1, true) | (-1, false) => left += 1,
                    _ => right += 1,
                }
            }
            if left == right || (self.is_lost(*low) && self.is_lost(*high)) {
                return None;
            }
            let (from, to) = if left > right { (*low, *high) } else { (*high, *low) };
            let cut = [self.is_lost(from), self.is_lost(to)];
            let weight: i32 = left - right;
            Some((Origin::Edge { from, to, cut }, weight.abs(), left == 0 || right == 0))
        };
        let of_face = move |(i, face): (usize, &[u32; 3])| {
            if self.turns[i] == 0 || !self.is_cut {
                return None;
            }
            let mut face = *face;
            if self.turns[i] < 0 {
                face.swap(1, 2);
            }
            let sides = (0..3).map(|k| [face[k], face[(k + 1) % 3]]);
            let start = sides.clone().find(|[p, q]| !self.is_lost(*p) && self.is_lost(*q))?;
            let end = sides.clone().find(|[p, q]| self.is_lost(*p) && !self.is_lost(*q))?;
            Some((Origin::Chord { face: i as u32, start, end: [end[1], end[0]] }, 1, true))
        };
        let chords = self.is_cut.then(|| surface.faces.iter().enumerate().filter_map(of_face));
        surface.edges.iter().enumerate().filter_map(of_edge).chain(chords.into_iter().flatten())
    }

    /// Directions from which to count: beside the mesh where the eye is outside the ball around it.
    fn look_around(&self, coverage: &mut Coverage) {
        let center = self.form.center - self.form.eye.primal();
        let is_outside = center.length() > self.form.reach * (1.0 + 1e-9);
        let axis = if is_outside { center.normalize() } else { DVec3::new(0.4327, 0.6113, 0.6628).normalize() };
        let (tangent, bitangent) = Vector::constant(axis).frame();
        let (tangent, bitangent): (DVec3, DVec3) = (Vector::<f64>::primal(tangent), Vector::<f64>::primal(bitangent));
        let aside = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            (axis * -0.3127 + (tangent * cos + bitangent * sin) * 0.9498).normalize()
        };
        for direction in [aside(0.5731), aside(2.6411), aside(4.7807), -axis] {
            let count = match coverage.known.first() {
                _ if is_outside => 0,
                None => self.faces_at(direction),
                Some(_) => coverage.count(direction),
            };
            coverage.known.push((direction, count));
        }
    }

    /// Face by face.
    fn faces_at(&self, d: DVec3) -> i32 {
        let (surface, eye) = (self.form.surface, self.form.eye.primal());
        let place = |i: u32| surface.points[i as usize] - eye;
        // Neighbours agree on which side of their edge a direction is.
        let side = |i: u32, j: u32| {
            if i < j { d.dot(place(i).cross(place(j))) } else { -d.dot(place(j).cross(place(i))) }
        };
        let hits = |(i, [a, b, c]): (usize, &[u32; 3])| {
            let turn = f64::from(self.turns[i]);
            if turn == 0.0 || [(*a, *b), (*b, *c), (*c, *a)].iter().any(|(i, j)| turn * side(*i, *j) < 0.0) {
                return false;
            }
            let Some(keep) = self.keep.filter(|_| self.is_cut) else { return true };
            let normal = surface.line(*a, *b).cross(surface.line(*a, *c));
            let share = normal.dot(place(*a)) / normal.dot(d);
            keep.height(Vector::constant(d * share)) >= 0.0
        };
        surface.faces.iter().enumerate().filter(|face| hits(*face)).count() as i32
    }
}

/// The numbers of faces on both sides of a curve, and how far the nearest other edge is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside {
    pub left: i32,
    pub right: i32,
    pub nearest: f64,
}

impl Coverage {
    /// How many faces lie in a direction.
    fn count(&self, d: DVec3) -> i32 {
        let openness = |r: &DVec3| r.dot(d);
        let best = self.known.iter().max_by(|a, b| openness(&a.0).total_cmp(&openness(&b.0)));
        best.map_or(0, |(from, faces)| faces + self.gained(*from, d, &[]))
    }

    /// Signed angle to the nearest curve (its size a lower bound), positive where a face lies in the direction.
    pub fn margin(&self, d: DVec3) -> f64 {
        let nearest = self.nearest(d, &[]);
        if self.count(d) > 0 { nearest } else { -nearest }
    }

    /// At a direction on a great circle along which some of the curves run.
    ///
    /// - `normal`: of the circle, to its left
    /// - `along`: curves that run there, and whether they have the same left
    pub fn beside(&self, d: DVec3, normal: DVec3, along: &[(usize, bool)]) -> Beside {
        let openness = |r: &DVec3| normal.dot(*r).abs() * (1.0 + r.dot(d));
        let best = self.known.iter().max_by(|a, b| openness(&a.0).total_cmp(&openness(&b.0)));
        let Some((from, faces)) = best else { return Beside { left: 0, right: 0, nearest: 0.0 } };
        let here = faces + self.gained(*from, d, along);
        let step: i32 = along.iter().map(|(i, alike)| self.steps[*i].weight * if *alike { 1 } else { -1 }).sum();
        let (left, right) = if normal.dot(*from) > 0.0 { (here, here - step) } else { (here + step, here) };
        Beside { left, right, nearest: self.nearest(d, along) }
    }

    fn nearest(&self, d: DVec3, but: &[(usize, bool)]) -> f64 {
        let mut nearest = std::f64::consts::PI;
        for (i, step) in self.steps[..self.curves].iter().enumerate() {
            // The circle is never farther than the arc.
            if step.arc.normal.primal().dot(d).abs() < nearest && but.iter().all(|(j, _)| *j != i) {
                nearest = nearest.min(step.arc.distance(d));
            }
        }
        nearest
    }

    /// How many faces come in on the shorter way from one direction to another, not counting some curves.
    fn gained(&self, from: DVec3, to: DVec3, but: &[(usize, bool)]) -> i32 {
        let way = from.cross(to);
        let mut gained = 0;
        for (i, Step { arc, weight }) in self.steps.iter().enumerate() {
            let normal = arc.normal.primal();
            let (begin, end) = (normal.dot(from), normal.dot(to));
            if (begin >= 0.0) == (end >= 0.0) {
                continue;
            }
            let [p, q] = arc.ends.map(|end| end.primal());
            let (before, after) = (way.dot(p), way.dot(q));
            if (before >= 0.0) == (after >= 0.0) || but.iter().any(|(j, _)| *j == i) {
                continue;
            }
            let on_edge = p * after.abs() + q * before.abs();
            let on_way = from * end.abs() + to * begin.abs();
            if on_edge.dot(on_way) > 0.0 {
                gained += if end >= 0.0 { *weight } else { -weight };
            }
        }
        gained
    }
}
