//! What one occluder hides of one strip.
//!
//! The plane through the eye and the strip cuts an occluder in chords or in a disk. What of them lies between the eye
//! and the source is projected onto the strip: no shadow outline is ever built.

use glam::DVec3;

use super::super::body::{Body, Figure, Flat};
use super::view::{Stretch, Strip, View};

/// An occluder relative to the eye, in the view's unit.
pub(super) struct Blocker<'a> {
    pub form: Form<'a>,
    /// How far off its points may be by rounding.
    noise: f64,
    /// It shows on strips with σ in between only; set by the view's maker once the strips are chosen.
    pub range: [f64; 2],
}

pub(super) enum Form<'a> {
    Disk { center: DVec3, normal: DVec3, radius: f64 },
    Ball { center: DVec3, radius: f64 },
    Flat { shape: &'a Flat, points: Vec<DVec3> },
}

/// A point in a strip's plane: along the strip, ahead of the eye, and how far off it may be.
#[derive(Clone, Copy)]
struct Spot {
    x: f64,
    y: f64,
    noise: f64,
}

impl<'a> Blocker<'a> {
    /// One for each figure of the body: of a mesh, each of its flat patches.
    pub fn of_body(body: &'a Body, eye: DVec3, unit: f64) -> Vec<Blocker<'a>> {
        let center = (body.center - eye) / unit;
        let form = match &body.figure {
            Figure::Disk { normal, radius, .. } => Form::Disk { center, normal: *normal, radius: radius / unit },
            Figure::Ball { radius } => Form::Ball { center, radius: radius / unit },
            Figure::Flat(shape) => {
                let points = shape.offsets.iter().map(|p| (shape.origin - eye + *p) / unit).collect();
                Form::Flat { shape, points }
            }
            Figure::Mesh(surface) => {
                return surface.patches.iter().flat_map(|patch| Blocker::of_body(patch, eye, unit)).collect();
            }
        };
        let noise = 4.0 * f64::EPSILON * (center.length() + body.reach / unit);
        vec![Blocker { form, noise, range: [f64::NEG_INFINITY, f64::INFINITY] }]
    }

    /// A flat figure's edges; none of the others.
    pub fn edges(&self) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        let (edges, points) = match &self.form {
            Form::Flat { shape, points } => (shape.edges.as_slice(), points.as_slice()),
            _ => (&[][..], &[][..]),
        };
        edges.iter().map(|edge| edge.map(|i| points[i as usize]))
    }

    /// Adds the stretches of the strip that it hides; they may reach beyond the source, even to infinity.
    pub fn cover(&self, view: &View, strip: &Strip, covered: &mut Vec<Stretch>) {
        if strip.sigma < self.range[0] || strip.sigma > self.range[1] {
            return;
        }
        match &self.form {
            Form::Disk { center, normal, radius } => {
                if let Some(chord) = self.chord_of_disk(view, strip, *center, *normal, *radius) {
                    self.cover_by_chord(view, strip, chord, covered);
                }
            }
            Form::Flat { shape, points } => self.cover_by_flat(view, strip, shape, points, covered),
            Form::Ball { center, radius } => self.cover_by_ball(view, strip, *center, *radius, covered),
        }
    }

    fn chord_of_disk(
        &self,
        view: &View,
        strip: &Strip,
        center: DVec3,
        normal: DVec3,
        radius: f64,
    ) -> Option<[Spot; 2]> {
        let along = strip.across.cross(normal);
        let square = along.length_squared();
        let level = strip.across.dot(center);
        let steep = square.sqrt();
        let off = level / steep;
        let half = ((radius - off) * (radius + off)).sqrt();
        // Also where the strip's plane is the disk's own, or beside it: not a number is not above zero.
        if half.is_nan() || half <= 0.0 || steep == 0.0 {
            return None;
        }
        let middle = center - (strip.across - normal * strip.across.dot(normal)) * (level / square);
        let noise = self.noise * (1.0 + (1.0 + radius / half) / steep);
        let end = |side: f64| spot(view, strip, middle + along * (side * half / steep), noise);
        Some([end(-1.0), end(1.0)])
    }

    fn cover_by_flat(&self, view: &View, strip: &Strip, shape: &Flat, points: &[DVec3], covered: &mut Vec<Stretch>) {
        let mut crossings: Vec<Spot> = Vec::with_capacity(4);
        for edge in &shape.edges {
            let [p, q] = edge.map(|i| points[i as usize]);
            let (above, below) = (strip.across.dot(p), strip.across.dot(q));
            if (above > 0.0) != (below > 0.0) {
                let noise = self.noise * (1.0 + p.distance(q) / (above - below).abs());
                crossings.push(spot(view, strip, p + (q - p) * (above / (above - below)), noise));
            }
        }
        if crossings.len() > 2 {
            let along = strip.across.cross(shape.normal);
            let (x, y) = (along.dot(view.e2), along.dot(strip.ahead));
            crossings.sort_by(|a, b| (a.x * x + a.y * y).total_cmp(&(b.x * x + b.y * y)));
        }
        for pair in crossings.chunks_exact(2) {
            self.cover_by_chord(view, strip, [pair[0], pair[1]], covered);
        }
    }

    fn cover_by_chord(&self, view: &View, strip: &Strip, chord: [Spot; 2], covered: &mut Vec<Stretch>) {
        if view.ball.is_some() {
            return self.cover_before_ball(view, strip, chord, covered);
        }
        // What lies in the source's plane or beyond hides nothing; neither does what lies behind the eye.
        let [p, q] = chord;
        let last = strip.y * (1.0 - 4.0 * f64::EPSILON);
        if (p.y <= 0.0 && q.y <= 0.0) || (p.y >= last - p.noise && q.y >= last - q.noise) {
            return;
        }
        let toward = |end: Spot, other: Spot| {
            if end.y > strip.y {
                let share = (strip.y - other.y) / (end.y - other.y);
                let slope = ((end.x - other.x) / (end.y - other.y)).abs();
                let doubt = (end.noise + other.noise) * (1.0 + slope);
                (other.x + (end.x - other.x) * share - view.anchor[1], doubt)
            } else {
                project(view, strip, end, other)
            }
        };
        let (a, b) = (toward(p, q), toward(q, p));
        push(a, b, covered);
    }

    /// A sphere source's front is curved: what of the chord lies before it is tried out between the places where the
    /// chord may run into it.
    fn cover_before_ball(&self, view: &View, strip: &Strip, chord: [Spot; 2], covered: &mut Vec<Stretch>) {
        let [p, q] = chord;
        if p.y <= 0.0 && q.y <= 0.0 {
            return;
        }
        let (cx, cy, square) = section(view, strip, view.middle, view.ball.unwrap_or_default());
        let mut splits = vec![project(view, strip, p, q), project(view, strip, q, p)];
        // |p + v (q − p) − c|² = ρ²
        let (dx, dy, px, py) = (q.x - p.x, q.y - p.y, p.x - cx, p.y - cy);
        let (aa, ab, bb) = (dx * dx + dy * dy, dx * px + dy * py, px * px + py * py - square);
        let root = (ab * ab - aa * bb).sqrt();
        for v in [(-ab - root) / aa, (-ab + root) / aa] {
            let hit = Spot { x: p.x + v * dx, y: p.y + v * dy, noise: p.noise + q.noise };
            if v > 0.0 && v < 1.0 && hit.y > 0.0 {
                splits.push(project(view, strip, hit, hit));
            }
        }
        self.try_out(view, strip, splits, covered);
    }

    fn cover_by_ball(&self, view: &View, strip: &Strip, center: DVec3, radius: f64, covered: &mut Vec<Stretch>) {
        let (x, y, square) = section(view, strip, center, radius);
        if square <= 0.0 {
            return;
        }
        let r = square.sqrt();
        let everything = Stretch { from: f64::NEG_INFINITY, to: f64::INFINITY, doubt_from: 0.0, doubt_to: 0.0 };
        let distance = x.hypot(y);
        if distance <= r {
            return covered.push(everything);
        }
        let noise = self.noise * (1.0 + radius / r);
        if y + r <= 0.0 || (view.ball.is_none() && y - r >= strip.y * (1.0 - 4.0 * f64::EPSILON) - noise) {
            return;
        }
        // The tangents from the eye touch at c (L/d)² ± c⊥ r L/d²; what the source's plane cuts off does not count.
        let touching = ((distance - r) * (distance + r)).sqrt();
        let share = touching / (distance * distance);
        let bounds = [-1.0, 1.0].map(|side| {
            let touch =
                Spot { x: (x * touching + side * y * r) * share, y: (y * touching - side * x * r) * share, noise };
            if view.ball.is_none() && touch.y >= strip.y {
                let reach = strip.y - y;
                let half = ((r - reach) * (r + reach)).max(0.0).sqrt();
                (x + side * half - view.anchor[1], noise * (1.0 + r / half.max(f64::EPSILON * r)))
            } else if touch.y <= 0.0 {
                (side * f64::INFINITY, 0.0)
            } else {
                // Seen from the eye, a tangent's direction is off by the noise over the distance to the touching point.
                let seen = noise * (1.0 + r / touching.max(f64::EPSILON * r));
                project(view, strip, Spot { noise: seen, ..touch }, touch)
            }
        });
        if view.ball.is_none() {
            return push(bounds[0], bounds[1], covered);
        }
        let mut splits = bounds.to_vec();
        let (cx, cy, own_square) = section(view, strip, view.middle, view.ball.unwrap_or_default());
        // Where the two circles meet.
        let (dx, dy) = (x - cx, y - cy);
        let gap = dx.hypot(dy);
        let along = 0.5 * (gap + (own_square - square) / gap);
        let half = (own_square - along * along).sqrt();
        for side in [-half, half] {
            let hit = Spot { x: cx + (dx * along - dy * side) / gap, y: cy + (dy * along + dx * side) / gap, noise };
            if hit.x.is_finite() && hit.y > 0.0 {
                splits.push(project(view, strip, hit, hit));
            }
        }
        self.try_out(view, strip, splits, covered);
    }

    /// Hides, before a sphere source, whichever stretches between splits a ray through their middle says.
    fn try_out(&self, view: &View, strip: &Strip, splits: Vec<(f64, f64)>, covered: &mut Vec<Stretch>) {
        let mut outline = Vec::with_capacity(1);
        view.inside(strip.sigma, &mut outline);
        let Some(own) = outline.first() else { return };
        // Beside the source's outline there is no front to be before.
        let mut splits: Vec<(f64, f64)> = splits.into_iter().filter(|(tau, _)| !tau.is_nan()).collect();
        for (tau, _) in &mut splits {
            *tau = tau.clamp(own.from, own.to);
        }
        splits.sort_by(|a, b| a.0.total_cmp(&b.0));
        for pair in splits.windows(2) {
            if pair[1].0 > pair[0].0 && self.stops(view, view.point(strip, 0.5 * (pair[0].0 + pair[1].0))) {
                push(pair[0], pair[1], covered);
            }
        }
    }

    /// Whether the open segment from the eye to the source through a point of its plane meets it.
    fn stops(&self, view: &View, point: DVec3) -> bool {
        let end = view.end_of_ray(point) * (1.0 - 1e-13);
        let hit = |anchor: DVec3, normal: DVec3| {
            let share = normal.dot(anchor) / normal.dot(point);
            (share > 0.0 && share < end).then(|| point * share)
        };
        match &self.form {
            Form::Disk { center, normal, radius } => {
                hit(*center, *normal).is_some_and(|p| (p - *center).length() < *radius)
            }
            Form::Ball { center, radius } => {
                let length = point.length();
                let direction = point / length;
                let middle = direction.dot(*center);
                let off = (direction * middle - *center).length();
                let half = (radius - off) * (radius + off);
                half > 0.0 && middle + half.sqrt() > 0.0 && middle - half.sqrt() < end * length
            }
            // Between crossings of the outline with the strip's plane, which are the splits, it is all inside.
            Form::Flat { shape, points } => hit(points[0], shape.normal).is_some(),
        }
    }
}

/// A ball's section by a strip's plane: centre, and the radius' square (below zero where they do not meet).
fn section(view: &View, strip: &Strip, center: DVec3, radius: f64) -> (f64, f64, f64) {
    let off = strip.across.dot(center);
    (center.dot(view.e2), center.dot(strip.ahead), (radius - off) * (radius + off))
}

fn spot(view: &View, strip: &Strip, point: DVec3, noise: f64) -> Spot {
    Spot { x: point.dot(view.e2), y: point.dot(strip.ahead), noise }
}

/// Onto the strip, as τ and its doubt; a chord's end behind the eye goes to infinity, where the rest of the chord leads.
fn project(view: &View, strip: &Strip, end: Spot, other: Spot) -> (f64, f64) {
    if end.y <= 0.0 {
        let at_eye = end.x + (other.x - end.x) * (-end.y / (other.y - end.y));
        return (at_eye.signum() * f64::INFINITY, 0.0);
    }
    let x = end.x * (strip.y / end.y);
    let doubt = (end.noise + f64::EPSILON * end.y) * (strip.y / end.y) * (1.0 + x.abs() / strip.y);
    (x - view.anchor[1], doubt)
}

fn push(a: (f64, f64), b: (f64, f64), covered: &mut Vec<Stretch>) {
    let (a, b) = if a.0 <= b.0 { (a, b) } else { (b, a) };
    if a.0 < b.0 {
        covered.push(Stretch { from: a.0, to: b.0, doubt_from: a.1, doubt_to: b.1 });
    }
}
