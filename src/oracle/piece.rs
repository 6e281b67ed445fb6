//! A surface as seen from one point: a set of directions, the curves that bound it, and on which side one is.

use std::f64::consts::TAU;

use glam::DVec3;

use super::body::{Body, Figure, Flat};
use super::great_arc::GreatArc;
use super::rim::{Rim, RimCut, Term};
use crate::geometry::Frame;

/// A part of the boundary of a set of directions; the set lies to its left (`r × dr`).
#[derive(Clone, Copy, Debug)]
pub(super) enum Curve {
    Straight(GreatArc),
    /// `from ≤ t ≤ to`, at most one turn.
    Round {
        rim: Rim,
        from: f64,
        to: f64,
    },
}

impl Curve {
    pub fn range(&self) -> (f64, f64) {
        match self {
            Curve::Straight(arc) => (0.0, arc.length),
            Curve::Round { from, to, .. } => (*from, *to),
        }
    }
    /// Not unit on a rim.
    pub fn point(&self, t: f64) -> DVec3 {
        match self {
            Curve::Straight(arc) => arc.point(t),
            Curve::Round { rim, .. } => rim.point(t),
        }
    }
    pub fn contour(&self, n: DVec3, from: f64, to: f64) -> Term {
        match self {
            Curve::Straight(arc) => arc.contour(n, from, to),
            Curve::Round { rim, .. } => rim.contour(n, from, to),
        }
    }
    pub fn is_closed(&self) -> bool {
        matches!(self, Curve::Round { from, to, .. } if to - from >= TAU)
    }
}

/// Directions that meet a surface.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub curves: Vec<Curve>,
    /// Whether a half-space took something away.
    pub is_cut: bool,
    inside: Inside,
}

#[derive(Clone, Debug)]
enum Inside {
    /// In the cone and, where it is cut, on the side of the plane through the origin.
    Round { rim: Rim, cut: Option<DVec3> },
    /// In the silhouette's part before a plane, or in the disk in which the ball meets that plane.
    Cap { silhouette: Rim, cut: DVec3, section: Rim },
    /// Left of all edges.
    Convex,
    /// Even-odd among the edges (as [from, to] in the plane one unit away): corners are computed once, so that the edges
    /// which share one agree on which side of it a direction passes.
    EvenOdd { axis: DVec3, u: DVec3, v: DVec3, edges: Vec<[[f64; 2]; 2]> },
}

/// A half-space `normal · r + k ≥ 0`.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfSpace {
    pub normal: DVec3,
    pub k: f64,
}

impl Piece {
    /// Signed angle from the boundary to a unit direction, positive inside; its size is a lower bound, tight near the
    /// boundary.
    pub fn margin(&self, d: DVec3) -> f64 {
        match &self.inside {
            Inside::Round { rim, cut: None } => rim.margin(d),
            Inside::Round { rim, cut: Some(plane) } => rim.margin(d).min(plane.dot(d)),
            Inside::Cap { silhouette, cut, section } => silhouette.margin(d).min(cut.dot(d)).max(section.margin(d)),
            Inside::Convex => self.arcs().map(|arc| arc.normal.dot(d)).fold(f64::INFINITY, f64::min),
            Inside::EvenOdd { axis, u, v, edges } => {
                let nearest = self.arcs().map(|arc| arc.distance(d)).fold(f64::INFINITY, f64::min);
                let depth = d.dot(*axis);
                let ahead = depth > 0.0;
                if ahead && is_inside(edges, [d.dot(*u) / depth, d.dot(*v) / depth]) { nearest } else { -nearest }
            }
        }
    }

    fn arcs(&self) -> impl Iterator<Item = &GreatArc> {
        self.curves.iter().filter_map(|curve| match curve {
            Curve::Straight(arc) => Some(arc),
            Curve::Round { .. } => None,
        })
    }

    /// What can be seen of a blocking body before a plane that does not pass through the eye. `None` where nothing is
    /// left, or it is seen edge-on, or the eye is inside the ball.
    pub fn of_occluder(body: &Body, eye: DVec3, keep: Option<HalfSpace>) -> Option<Piece> {
        let center = body.center - eye;
        match (&body.figure, keep) {
            (Figure::Disk { normal, radius }, _) => round(Rim::of_disk(center, *normal, *radius)?, keep),
            (Figure::Ball { radius }, None) => round(Rim::of_silhouette(center, *radius)?, None),
            (Figure::Ball { radius }, Some(keep)) => ball(center, *radius, keep),
            (Figure::Flat(shape), _) => flat(shape, eye, keep),
        }
    }

    /// What can be seen of an emitting body above the horizon. `None` where nothing is left.
    ///
    /// - `n`: the receiver's unit normal
    pub fn of_source(body: &Body, eye: DVec3, n: DVec3) -> Option<Piece> {
        let above = Some(HalfSpace { normal: n, k: 0.0 });
        let center = body.center - eye;
        match &body.figure {
            Figure::Disk { normal, radius } => round(Rim::of_disk(center, *normal, *radius)?, above),
            Figure::Ball { radius } => round(Rim::of_silhouette(center, *radius)?, above),
            Figure::Flat(shape) => flat(shape, eye, above),
        }
    }
}

fn is_inside(edges: &[[[f64; 2]; 2]], [x, y]: [f64; 2]) -> bool {
    edges.iter().fold(false, |inside, [[xa, ya], [xb, yb]]| {
        inside ^ ((*ya > y) != (*yb > y) && x < xa + (y - ya) * ((xb - xa) / (yb - ya)))
    })
}

fn full(rim: Rim) -> Piece {
    Piece {
        curves: vec![Curve::Round { rim, from: 0.0, to: TAU }],
        is_cut: false,
        inside: Inside::Round { rim, cut: None },
    }
}

/// The great circle in which a half-space's plane cuts the piece's own plane, as a unit normal towards the kept side:
/// a point `λ d` of the plane `axis · r = height` is kept where this is positive.
fn cut_normal(keep: HalfSpace, axis: DVec3, height: f64) -> DVec3 {
    if keep.k == 0.0 { keep.normal } else { (keep.normal * height + axis * keep.k).normalize() }
}

fn round(rim: Rim, keep: Option<HalfSpace>) -> Option<Piece> {
    let Some(keep) = keep else { return Some(full(rim)) };
    match rim.cut(keep.normal, keep.k) {
        RimCut::Whole => Some(full(rim)),
        RimCut::Nothing => None,
        RimCut::Part { from, to } => {
            let plane = cut_normal(keep, rim.axis, rim.height);
            let mut curves = vec![Curve::Round { rim, from, to }];
            curves.extend(GreatArc::on_circle(rim.point(to), rim.point(from), plane, 1.0).map(Curve::Straight));
            Some(Piece { curves, is_cut: true, inside: Inside::Round { rim, cut: Some(plane) } })
        }
    }
}

/// A ball before the plane of a source. Where the plane cuts it, what blocks is convex, so its outline is one loop: the
/// silhouette's part before the plane, then the part of the section circle that lies before the silhouette's own plane.
/// The two meet tangentially.
fn ball(center: DVec3, radius: f64, keep: HalfSpace) -> Option<Piece> {
    let ahead = keep.normal.dot(center) + keep.k;
    let noise = 4.0 * f64::EPSILON * (center.length() + radius + keep.k.abs());
    if ahead <= noise - radius {
        return None;
    }
    let silhouette = Rim::of_silhouette(center, radius)?;
    let cut = silhouette.cut(keep.normal, keep.k);
    if ahead >= radius - noise || cut == RimCut::Whole {
        return Some(full(silhouette));
    }
    let section_radius = ((radius - ahead) * (radius + ahead)).sqrt();
    let section = Rim::of_disk(center - keep.normal * ahead, keep.normal, section_radius)?;
    let RimCut::Part { from, to } = cut else { return Some(full(section)) };
    let plane = cut_normal(keep, silhouette.axis, silhouette.height);
    let begin = section.parameter(silhouette.point(to));
    let mut end = section.parameter(silhouette.point(from));
    if end <= begin {
        end += TAU;
    }
    Some(Piece {
        curves: vec![Curve::Round { rim: silhouette, from, to }, Curve::Round { rim: section, from: begin, to: end }],
        is_cut: true,
        inside: Inside::Cap { silhouette, cut: plane, section },
    })
}

fn flat(shape: &Flat, eye: DVec3, keep: Option<HalfSpace>) -> Option<Piece> {
    let origin = shape.origin - eye;
    let points: Vec<DVec3> = shape.offsets.iter().map(|offset| origin + *offset).collect();
    let farthest = points.iter().map(|p| p.length()).fold(0.0, f64::max);
    let along = points[0].dot(shape.normal);
    if along.abs() <= 4.0 * f64::EPSILON * farthest {
        return None;
    }
    let axis = if along < 0.0 { -shape.normal } else { shape.normal };
    let ordered = |edge: &[u32; 2]| {
        let [from, to] = edge.map(|i| i as usize);
        if along < 0.0 { [to, from] } else { [from, to] }
    };
    let mut curves = Vec::with_capacity(shape.edges.len() + 1);
    let height = |p: DVec3, keep: HalfSpace| {
        let h = keep.normal.dot(p) + keep.k;
        if h.abs() <= 4.0 * f64::EPSILON * (farthest + keep.k.abs()) { 0.0 } else { h }
    };
    let heights: Option<Vec<f64>> = keep.map(|keep| points.iter().map(|p| height(*p, keep)).collect());
    if heights.as_ref().is_some_and(|heights| heights.iter().all(|h| *h <= 0.0)) {
        return None;
    }
    let heights = heights.filter(|heights| heights.iter().any(|h| *h < 0.0));
    let frame = Frame::around(axis);
    let in_plane = |p: DVec3| [p.dot(frame.tangent) / p.dot(axis), p.dot(frame.bitangent) / p.dot(axis)];
    let mut outline = Vec::new();
    let mut crossings = Vec::new();
    for edge in &shape.edges {
        let [i, j] = ordered(edge);
        let (mut p, mut q) = (points[i], points[j]);
        let line = shape.offsets[j] - shape.offsets[i];
        if let Some(heights) = &heights {
            let (hp, hq) = (heights[i], heights[j]);
            if hp < 0.0 && hq < 0.0 {
                continue;
            }
            if (hp < 0.0) != (hq < 0.0) {
                let on_plane = p + line * (hp / (hp - hq));
                crossings.push(on_plane);
                if hp < 0.0 {
                    p = on_plane;
                } else {
                    q = on_plane;
                }
            }
        }
        curves.extend(GreatArc::of_edge(p, q, line).map(Curve::Straight));
        if !shape.convex {
            outline.push([in_plane(p), in_plane(q)]);
        }
    }
    if let (Some(keep), false) = (keep, crossings.is_empty()) {
        let plane = cut_normal(keep, axis, axis.dot(points[0]));
        let direction = plane.cross(axis);
        crossings.sort_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)));
        for pair in crossings.chunks_exact(2) {
            curves.extend(GreatArc::on_circle(pair[0], pair[1], plane, 1.0).map(Curve::Straight));
            if !shape.convex {
                outline.push([in_plane(pair[0]), in_plane(pair[1])]);
            }
        }
    }
    let inside = if shape.convex {
        Inside::Convex
    } else {
        Inside::EvenOdd { axis, u: frame.tangent, v: frame.bitangent, edges: outline }
    };
    (!curves.is_empty()).then_some(Piece { curves, inside, is_cut: heights.is_some() })
}
