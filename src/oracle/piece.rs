//! A surface as seen from one point: a set of directions, the curves that bound it, and on which side one is.

use std::f64::consts::TAU;

use glam::DVec3;

use super::form::{Few, FlatForm, Form, HalfSpace};
use super::great_arc::GreatArc;
use super::rim::{Rim, RimCut, Term};
use super::silhouette::{self, Coverage};
use crate::number::{Number, Vector};

/// A part of the boundary of a set of directions; the set lies to its left (`r × dr`), unless its complement is meant.
#[derive(Clone, Copy, Debug)]
pub(super) enum Curve<T = f64> {
    Straight(GreatArc<T>),
    /// `from ≤ t ≤ to`, at most one turn.
    Round {
        rim: Rim<T>,
        from: T,
        to: T,
    },
}

impl<T: Number> Curve<T> {
    pub fn range(&self) -> (T, T) {
        match self {
            Curve::Straight(arc) => (T::zero(), arc.length),
            Curve::Round { from, to, .. } => (*from, *to),
        }
    }
    /// Not unit on a rim.
    pub fn point(&self, t: T) -> Vector<T> {
        match self {
            Curve::Straight(arc) => arc.point(t),
            Curve::Round { rim, .. } => rim.point(t),
        }
    }
    /// The parameter (on a rim: up to whole turns) of a direction on the curve.
    pub fn parameter(&self, direction: Vector<T>) -> T {
        match self {
            Curve::Straight(arc) => arc.parameter(direction),
            Curve::Round { rim, .. } => rim.angle(direction),
        }
    }
    pub fn contour(&self, n: Vector<T>, from: T, to: T) -> Term<T> {
        match self {
            Curve::Straight(arc) => arc.contour(n, from, to),
            Curve::Round { rim, .. } => rim.contour(n, from, to),
        }
    }
    pub fn is_closed(&self) -> bool {
        matches!(self, Curve::Round { from, to, .. } if (*to - *from).primal() >= TAU)
    }
}

/// Directions that meet a surface.
#[derive(Clone, Debug)]
pub(super) struct Piece<T = f64> {
    pub curves: Vec<Curve<T>>,
    /// Whether a half-space took something away.
    pub is_cut: bool,
    /// Whether all directions but these are meant: then the set lies to the right of the curves.
    pub is_complement: bool,
    inside: Inside<T>,
}

#[derive(Clone, Debug)]
enum Inside<T> {
    /// In the cone and, where it is cut, on the side of the plane through the origin.
    Round { rim: Rim<T>, cut: Option<Vector<T>> },
    /// In the silhouette's part before a plane, or in the disk in which the ball meets that plane.
    Cap(Box<Cap<T>>),
    /// Left of all edges.
    Convex,
    /// Even-odd among the edges (as [from, to] in the plane one unit away): corners are computed once, so that the edges
    /// which share one agree on which side of it a direction passes.
    EvenOdd { axis: Vector<T>, u: Vector<T>, v: Vector<T>, edges: Vec<[[f64; 2]; 2]> },
    /// Where faces lie.
    Covered(Box<Coverage>),
}

/// See [`Inside::Cap`].
#[derive(Clone, Debug)]
struct Cap<T> {
    silhouette: Rim<T>,
    cut: Vector<T>,
    section: Rim<T>,
}

impl Piece {
    /// Signed angle from the boundary to a unit direction, positive inside; its size is a lower bound, tight near the
    /// boundary.
    pub fn margin(&self, d: DVec3) -> f64 {
        let on = |plane: &Vector<f64>| plane.dot(Vector::constant(d));
        let within = match &self.inside {
            Inside::Round { rim, cut: None } => rim.margin(d),
            Inside::Round { rim, cut: Some(plane) } => rim.margin(d).min(on(plane)),
            Inside::Cap(cap) => cap.silhouette.margin(d).min(on(&cap.cut)).max(cap.section.margin(d)),
            Inside::Convex => self.arcs().map(|arc| on(&arc.normal)).fold(f64::INFINITY, f64::min),
            Inside::Covered(coverage) => coverage.margin(d),
            Inside::EvenOdd { axis, u, v, edges } => {
                let nearest = self.arcs().map(|arc| arc.distance(d)).fold(f64::INFINITY, f64::min);
                let depth = on(axis);
                if depth > 0.0 && is_inside(edges, [on(u) / depth, on(v) / depth]) { nearest } else { -nearest }
            }
        };
        if self.is_complement { -within } else { within }
    }

    /// Of a mesh, whose curves may cross one another, and may lie where it covers both sides.
    pub fn coverage(&self) -> Option<&Coverage> {
        match &self.inside {
            Inside::Covered(coverage) => Some(coverage),
            _ => None,
        }
    }

    fn arcs(&self) -> impl Iterator<Item = &GreatArc> {
        self.curves.iter().filter_map(|curve| match curve {
            Curve::Straight(arc) => Some(arc),
            Curve::Round { .. } => None,
        })
    }
}

impl<T: Number> Piece<T> {
    /// All directions but these.
    pub fn complement(self) -> Piece<T> {
        Piece { is_complement: !self.is_complement, ..self }
    }

    /// What can be seen of a blocking body before a plane that does not pass through the eye. `None` where nothing is
    /// left, or it is seen edge-on, or the eye is inside the ball.
    pub fn of_occluder(form: &Form<T>, keep: Option<HalfSpace<T>>) -> Option<Piece<T>> {
        match (form, keep) {
            (Form::Disk { center, normal, radius }, _) => round(Rim::of_disk(*center, *normal, *radius)?, keep),
            (Form::Ball { center, radius }, None) => round(Rim::of_silhouette(*center, *radius)?, None),
            (Form::Ball { center, radius }, Some(keep)) => ball(*center, *radius, keep),
            (Form::Flat(form), _) => flat(form, keep),
            (Form::Mesh(form), _) => {
                let (arcs, coverage, is_cut) = silhouette::outline(form, keep)?;
                let curves = arcs.into_iter().map(Curve::Straight).collect();
                Some(Piece { curves, is_cut, is_complement: false, inside: Inside::Covered(Box::new(coverage)) })
            }
        }
    }

    /// What can be seen of an emitting body above the horizon. `None` where nothing is left.
    ///
    /// - `n`: the receiver's unit normal
    pub fn of_source(form: &Form<T>, n: Vector<T>) -> Option<Piece<T>> {
        let above = Some(HalfSpace { normal: n, k: T::zero() });
        match form {
            Form::Disk { center, normal, radius } => round(Rim::of_disk(*center, *normal, *radius)?, above),
            Form::Ball { center, radius } => round(Rim::of_silhouette(*center, *radius)?, above),
            Form::Flat(form) => flat(form, above),
            Form::Mesh(_) => None,
        }
    }
}

fn is_inside(edges: &[[[f64; 2]; 2]], [x, y]: [f64; 2]) -> bool {
    edges.iter().fold(false, |inside, [[xa, ya], [xb, yb]]| {
        inside ^ ((*ya > y) != (*yb > y) && x < xa + (y - ya) * ((xb - xa) / (yb - ya)))
    })
}

fn full<T: Number>(rim: Rim<T>) -> Piece<T> {
    Piece {
        curves: vec![Curve::Round { rim, from: T::zero(), to: T::turn() }],
        is_cut: false,
        is_complement: false,
        inside: Inside::Round { rim, cut: None },
    }
}

/// The great circle in which a half-space's plane cuts the piece's own plane, as a unit normal towards the kept side:
/// a point `λ d` of the plane `axis · r = height` is kept where this is positive.
fn cut_normal<T: Number>(keep: HalfSpace<T>, axis: Vector<T>, height: T) -> Vector<T> {
    if keep.k.primal() == 0.0 { keep.normal } else { (keep.normal * height + axis * keep.k).normalize() }
}

fn round<T: Number>(rim: Rim<T>, keep: Option<HalfSpace<T>>) -> Option<Piece<T>> {
    let Some(keep) = keep else { return Some(full(rim)) };
    match rim.cut(keep.normal, keep.k) {
        RimCut::Whole => Some(full(rim)),
        RimCut::Nothing => None,
        RimCut::Part { from, to } => {
            let plane = cut_normal(keep, rim.axis, rim.height);
            let mut curves = vec![Curve::Round { rim, from, to }];
            curves.extend(GreatArc::on_circle(rim.point(to), rim.point(from), plane).map(Curve::Straight));
            Some(Piece {
                curves,
                is_cut: true,
                is_complement: false,
                inside: Inside::Round { rim, cut: Some(plane) },
            })
        }
    }
}

/// A ball before the plane of a source. Where the plane cuts it, what blocks is convex, so its outline is one loop: the
/// silhouette's part before the plane, then the part of the section circle that lies before the silhouette's own plane.
/// The two meet tangentially.
fn ball<T: Number>(center: Vector<T>, radius: T, keep: HalfSpace<T>) -> Option<Piece<T>> {
    let depth = keep.height(center);
    let (ahead, reach) = (depth.primal(), radius.primal());
    let noise = 4.0 * f64::EPSILON * (center.primal().length() + reach + keep.k.primal().abs());
    if ahead <= noise - reach {
        return None;
    }
    let silhouette = Rim::of_silhouette(center, radius)?;
    let cut = silhouette.cut(keep.normal, keep.k);
    if ahead >= reach - noise || matches!(cut, RimCut::Whole) {
        return Some(full(silhouette));
    }
    let section_radius = ((radius - depth) * (radius + depth)).sqrt();
    let section = Rim::of_disk(center - keep.normal * depth, keep.normal, section_radius)?;
    let RimCut::Part { from, to } = cut else { return Some(full(section)) };
    let plane = cut_normal(keep, silhouette.axis, silhouette.height);
    let begin = section.angle(silhouette.point(to));
    let mut end = section.angle(silhouette.point(from));
    if end.primal() <= begin.primal() {
        end = end + T::turn();
    }
    Some(Piece {
        curves: vec![Curve::Round { rim: silhouette, from, to }, Curve::Round { rim: section, from: begin, to: end }],
        is_cut: true,
        is_complement: false,
        inside: Inside::Cap(Box::new(Cap { silhouette, cut: plane, section })),
    })
}

fn flat<T: Number>(form: &FlatForm<T>, keep: Option<HalfSpace<T>>) -> Option<Piece<T>> {
    let (shape, points) = (form.shape, &form.corners);
    let farthest = points.iter().map(|p| p.primal().length()).fold(0.0, f64::max);
    let along = points[0].dot(form.normal).primal();
    if along.abs() <= 4.0 * f64::EPSILON * farthest {
        return None;
    }
    let axis = if along < 0.0 { -form.normal } else { form.normal };
    let ordered = |edge: &[u32; 2]| {
        let [from, to] = edge.map(|i| i as usize);
        if along < 0.0 { [to, from] } else { [from, to] }
    };
    let mut curves = Vec::with_capacity(shape.edges.len() + 1);
    let side = |p: Vector<T>, keep: &HalfSpace<T>| {
        let h = keep.height(p);
        let noise = 4.0 * f64::EPSILON * (farthest + keep.k.primal().abs());
        if h.primal().abs() <= noise { T::zero() } else { h }
    };
    let heights: Option<Few<T>> = keep.as_ref().map(|keep| points.iter().map(|p| side(*p, keep)).collect());
    if heights.as_ref().is_some_and(|heights| heights.iter().all(|h| h.primal() <= 0.0)) {
        return None;
    }
    let heights = heights.filter(|heights| heights.iter().any(|h| h.primal() < 0.0));
    let frame = (!shape.convex).then(|| axis.frame());
    let mut outline = Vec::new();
    let mut keep_edge = |p: Vector<T>, q: Vector<T>| {
        if let Some((u, v)) = frame {
            outline.push([p, q].map(|p| [(p.dot(u) / p.dot(axis)).primal(), (p.dot(v) / p.dot(axis)).primal()]));
        }
    };
    let directions: Few<Vector<T>> = points.iter().map(|p| p.normalize()).collect();
    let mut crossings: Few<Vector<T>> = Few::new();
    for edge in &shape.edges {
        let [i, j] = ordered(edge);
        let (mut p, mut q) = (points[i], points[j]);
        let (mut ends, mut share) = ([directions[i], directions[j]], T::constant(1.0));
        let line = form.line(i, j);
        if let Some(heights) = &heights {
            let (hp, hq) = (heights[i], heights[j]);
            let (p_below, q_below) = (hp.primal() < 0.0, hq.primal() < 0.0);
            if p_below && q_below {
                continue;
            }
            if p_below != q_below {
                let gap = hp - hq;
                let on_plane = p + line * (hp / gap);
                crossings.push(on_plane);
                if p_below {
                    (p, ends[0], share) = (on_plane, on_plane.normalize(), -hq / gap);
                } else {
                    (q, ends[1], share) = (on_plane, on_plane.normalize(), hp / gap);
                }
            }
        }
        if let Some(arc) = GreatArc::of_edge([p, q], line, share, ends) {
            curves.push(Curve::Straight(arc));
        }
        keep_edge(p, q);
    }
    if let (Some(keep), false) = (keep, crossings.is_empty()) {
        let plane = cut_normal(keep, axis, axis.dot(points[0]));
        let direction = plane.cross(axis).primal();
        crossings.sort_by(|a, b| a.primal().dot(direction).total_cmp(&b.primal().dot(direction)));
        for pair in crossings.chunks_exact(2) {
            curves.extend(GreatArc::on_circle(pair[0], pair[1], plane).map(Curve::Straight));
            keep_edge(pair[0], pair[1]);
        }
    }
    let inside = match frame {
        None => Inside::Convex,
        Some((u, v)) => Inside::EvenOdd { axis, u, v, edges: outline },
    };
    (!curves.is_empty()).then_some(Piece { curves, inside, is_complement: false, is_cut: heights.is_some() })
}
