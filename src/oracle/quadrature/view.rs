//! How one source looks from the eye: its plane in strips, and what may stand before it.

use glam::DVec3;

use super::super::body::{Body, Figure};
use super::blocker::Blocker;
use super::breaks;
use crate::geometry::Frame;
use crate::number::Wide;

/// The strips' frame on the source's plane. Lengths are in a unit of the view's own, a power of two that brings the
/// source's distance near one; points are relative to the eye.
///
/// A strip is the line `height down + s e1 + t e2` at one s; (σ, τ) are (s, t) relative to an anchor, so that digits are
/// kept where they matter: the source's centre, for a small source far away; the foot, where that is on or beside the
/// source and may be close to an edge.
///
/// A sphere source is looked at on the disk of its silhouette, which fills the same directions.
pub(super) struct View<'a> {
    pub n: DVec3,
    /// Unit, from the eye to its foot on the plane.
    pub down: DVec3,
    pub height: f64,
    pub e1: DVec3,
    pub e2: DVec3,
    /// (s, t) of the anchor.
    pub anchor: [f64; 2],
    /// The source's centre in space: that of the plane figure, or of the sphere.
    pub middle: DVec3,
    /// How far off `height` may be, as a share of it.
    pub height_doubt: f64,
    /// n·r at the anchor, and how far off it may be.
    at_anchor: f64,
    anchor_doubt: f64,
    pub outline: Outline,
    /// A sphere source's radius: light starts from its front.
    pub ball: Option<f64>,
    pub blockers: Vec<Blocker<'a>>,
    /// The view's unit in the bodies' unit.
    pub unit: f64,
}

/// The source's outline in (σ, τ).
pub(super) enum Outline {
    Circle(Round),
    Edges(Vec<Edge>),
}

/// A circle that keeps its digits close to the anchor.
pub(super) struct Round {
    pub center: [f64; 2],
    pub radius: f64,
    /// The anchor's distance from the centre, squared, less the radius squared.
    power: f64,
    power_doubt: f64,
}

/// A straight edge that keeps its digits close to the anchor.
pub(super) struct Edge {
    pub ends: [[f64; 2]; 2],
    /// τ at σ = 0 of the line that it lies on, and how far off that may be.
    level: f64,
    level_doubt: f64,
    slope: f64,
}

/// One strip, and the plane through it and the eye: there, a point is (x along e2, y along `ahead`).
pub(super) struct Strip {
    pub sigma: f64,
    /// Unit, from the eye to the strip, perpendicular to it.
    pub ahead: DVec3,
    /// The strip's distance from the eye.
    pub y: f64,
    /// Unit normal of the plane.
    pub across: DVec3,
}

/// n·r along a strip: `level + slope τ`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cosine {
    pub level: f64,
    pub slope: f64,
    /// How far off either may be.
    pub level_doubt: f64,
    pub slope_doubt: f64,
}

/// A stretch of a strip, in τ, with how far off either end may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub from: f64,
    pub to: f64,
    pub doubt_from: f64,
    pub doubt_to: f64,
}

/// Angles at which strips may run, radians: one of them suits, as no edge of the scene should be parallel to them.
const TURNS: [f64; 5] =
    [0.618_033_988_749_894_9, 1.144_122_805_635_368_6, 0.083_203_350_589_9, 1.713, 2.414_213_562_373];

impl<'a> View<'a> {
    /// `None` for a source that turns its dark side, whose plane passes through the eye within rounding, or that is seen
    /// from inside.
    pub fn new(n: DVec3, source: &Body, occluders: &[&'a Body], eye: DVec3) -> Option<View<'a>> {
        let apart = source.center - eye;
        let unit = (apart.length() + source.reach).log2().ceil().clamp(-1000.0, 1000.0).exp2();
        let middle = apart / unit;
        let reach = source.reach / unit;
        let (down, height, ball) = match &source.figure {
            Figure::Disk { normal, .. } => (-*normal, -normal.dot(middle), None),
            Figure::Flat(shape) => (-shape.normal, -shape.normal.dot(middle), None),
            // No source.
            Figure::Mesh(_) => return None,
            Figure::Ball { .. } => {
                let distance = middle.length();
                (middle / distance, (distance - reach) * (distance + reach) / distance, Some(reach))
            }
        };
        let least = if ball.is_some() { f64::EPSILON * f64::EPSILON } else { 4.0 * f64::EPSILON };
        if height.is_nan() || height <= least {
            return None;
        }
        // Products of which one alone counts are not off; for a sphere, distance and silhouette make up for one another.
        let height_doubt = if ball.is_some() { 0.0 } else { rounding(down, middle) / height };
        let off_foot = middle - down * middle.dot(down);
        let at_foot = ball.is_some() || off_foot.length() < 2.0 * reach;
        let blockers: Vec<Blocker> = occluders.iter().flat_map(|body| Blocker::of_body(body, eye, unit)).collect();
        let frame = Frame::around(down);
        let axes = |turn: f64| {
            let (sin, cos) = turn.sin_cos();
            [frame.tangent * cos + frame.bitangent * sin, frame.bitangent * cos - frame.tangent * sin]
        };
        // Relative to the anchor, but for their share along `down`.
        let mut slip = 0.0_f64;
        let corners: Vec<[DVec3; 2]> = match &source.figure {
            Figure::Flat(shape) => {
                let (base, lost) = sum(shape.origin, -if at_foot { eye } else { source.center });
                let mut at = |i: u32| {
                    let (corner, lost_again) = sum(base, shape.offsets[i as usize]);
                    slip = slip.max((lost.length() + lost_again.length()) / unit);
                    corner / unit
                };
                shape.edges.iter().map(|edge| edge.map(&mut at)).collect()
            }
            _ => Vec::new(),
        };
        let [e1, e2] = axes(least_parallel(&corners, &blockers, down, &axes));
        let outline = match &source.figure {
            Figure::Flat(_) => {
                Outline::Edges(corners.iter().map(|edge| Edge::new(*edge, slip, down, e1, e2)).collect())
            }
            Figure::Mesh(_) => return None,
            Figure::Ball { .. } => {
                Outline::Circle(Round::new(DVec3::ZERO, reach * (height / middle.length()).sqrt(), e1, e2))
            }
            Figure::Disk { .. } => {
                Outline::Circle(Round::new(if at_foot { off_foot } else { DVec3::ZERO }, reach, e1, e2))
            }
        };
        let anchored = if at_foot { down * height } else { middle };
        let at_anchor = n.dot(anchored);
        let anchor_doubt = rounding(n, anchored);
        let anchor = if at_foot { [0.0, 0.0] } else { [middle.dot(e1), middle.dot(e2)] };
        let mut view = View {
            n,
            down,
            height,
            e1,
            e2,
            anchor,
            middle,
            height_doubt,
            at_anchor,
            anchor_doubt,
            outline,
            ball,
            blockers,
            unit,
        };
        let ranges: Vec<[f64; 2]> = view.blockers.iter().map(|b| breaks::range(&view, &b.form)).collect();
        for (blocker, range) in view.blockers.iter_mut().zip(ranges) {
            blocker.range = range;
        }
        Some(view)
    }

    /// The source's ends in σ.
    pub fn extent(&self) -> (f64, f64) {
        match &self.outline {
            Outline::Circle(round) => (round.center[0] - round.radius, round.center[0] + round.radius),
            Outline::Edges(edges) => edges
                .iter()
                .flat_map(|edge| edge.ends)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[0]), high.max(p[0]))),
        }
    }

    pub fn strip(&self, sigma: f64) -> Strip {
        let s = self.anchor[0] + sigma;
        let y = self.height.hypot(s);
        let ahead = (self.down * self.height + self.e1 * s) / y;
        Strip { sigma, ahead, y, across: ahead.cross(self.e2) }
    }

    /// (σ, τ) of a direction, if it meets the source's plane.
    pub fn flat(&self, direction: DVec3) -> Option<[f64; 2]> {
        let depth = direction.dot(self.down);
        let share = self.height / depth;
        let at = [direction.dot(self.e1) * share - self.anchor[0], direction.dot(self.e2) * share - self.anchor[1]];
        (depth > 0.0 && at[0].is_finite() && at[1].is_finite()).then_some(at)
    }

    /// The point of the source's plane at τ of a strip.
    pub fn point(&self, strip: &Strip, tau: f64) -> DVec3 {
        strip.ahead * strip.y + self.e2 * (self.anchor[1] + tau)
    }

    /// Where on the source a ray through a point of its plane ends, relative to `middle`.
    pub fn on_source(&self, strip: &Strip, tau: f64) -> DVec3 {
        match self.ball {
            // The foot or the centre itself, whichever the anchor is.
            None if self.anchor == [0.0, 0.0] => self.point(strip, tau) - self.middle,
            None => self.e1 * strip.sigma + self.e2 * tau,
            Some(radius) => {
                let direction = self.point(strip, tau).normalize();
                // From the ball's centre: a square root less precise than its argument loses nothing that matters.
                let off = direction * direction.dot(self.middle) - self.middle;
                off - direction * ((radius - off.length()) * (radius + off.length())).max(0.0).sqrt()
            }
        }
    }

    /// How far from the eye a ray through a point of the plane ends, in units of that point's distance.
    pub fn end_of_ray(&self, point: DVec3) -> f64 {
        match self.ball {
            None => 1.0,
            Some(radius) => {
                let length = point.length();
                let direction = point / length;
                let along = direction.dot(self.middle);
                let off = (direction * along - self.middle).length();
                (along - ((radius - off) * (radius + off)).max(0.0).sqrt()) / length
            }
        }
    }

    /// The source's stretches on a strip, above the horizon or not.
    pub fn inside(&self, sigma: f64, stretches: &mut Vec<Stretch>) {
        stretches.clear();
        match &self.outline {
            Outline::Circle(round) => stretches.extend(round.on_strip(sigma)),
            Outline::Edges(edges) => {
                let mut crossings: Vec<(f64, f64)> = Vec::with_capacity(4);
                crossings.extend(edges.iter().filter_map(|edge| edge.on_strip(sigma)));
                crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
                stretches.extend(crossings.chunks_exact(2).map(|pair| Stretch {
                    from: pair[0].0,
                    to: pair[1].0,
                    doubt_from: pair[0].1,
                    doubt_to: pair[1].1,
                }));
            }
        }
    }

    /// n·r along a strip.
    pub fn cosine(&self, strip: &Strip) -> Cosine {
        Cosine {
            level: self.at_anchor + strip.sigma * self.n.dot(self.e1),
            slope: self.n.dot(self.e2),
            level_doubt: self.anchor_doubt + strip.sigma.abs() * rounding(self.n, self.e1),
            slope_doubt: rounding(self.n, self.e2),
        }
    }
}

/// How far off a product of vectors may be: little where one coordinate alone counts, whatever cancels.
fn rounding(a: DVec3, b: DVec3) -> f64 {
    f64::EPSILON * a.abs().dot(b.abs())
}

/// a + b, and what rounding took from it.
fn sum(a: DVec3, b: DVec3) -> (DVec3, DVec3) {
    let lost = |a: f64, b: f64| (Wide::sum(a, b) + -(a + b)).narrow();
    (a + b, DVec3::new(lost(a.x, b.x), lost(a.y, b.y), lost(a.z, b.z)))
}

impl Round {
    fn new(center: DVec3, radius: f64, e1: DVec3, e2: DVec3) -> Round {
        let distance = center.length();
        // The root of a single square is not off.
        let is_exact = center.to_array().iter().filter(|x| **x != 0.0).count() < 2;
        let gap_doubt = if is_exact { (distance - radius).abs() } else { distance };
        Round {
            center: [center.dot(e1), center.dot(e2)],
            radius,
            power: (distance - radius) * (distance + radius),
            power_doubt: f64::EPSILON * gap_doubt * (distance + radius),
        }
    }

    /// Both τ solve τ² − 2 τ τ₀ + σ² − 2 σ σ₀ + power = 0: the nearer one comes from their product.
    fn on_strip(&self, sigma: f64) -> Option<Stretch> {
        let [s, t] = self.center;
        let across = sigma - s;
        let half = ((self.radius - across) * (self.radius + across)).max(0.0).sqrt();
        if half <= 0.0 {
            return None;
        }
        let far = t + half.copysign(t);
        let shift = sigma * (sigma - 2.0 * s);
        let near = (shift + self.power) / far;
        let half_doubt = f64::EPSILON * self.radius * (self.radius / half);
        let far_doubt = half_doubt + f64::EPSILON * far.abs();
        let near_doubt = (self.power_doubt + f64::EPSILON * shift.abs() + near.abs() * far_doubt) / far.abs();
        Some(if near < far {
            Stretch { from: near, to: far, doubt_from: near_doubt, doubt_to: far_doubt }
        } else {
            Stretch { from: far, to: near, doubt_from: far_doubt, doubt_to: near_doubt }
        })
    }
}

impl Edge {
    /// - `ends`: relative to the anchor, but for what lies along `down`
    /// - `slip`: how far off either end may be
    fn new(ends: [DVec3; 2], slip: f64, down: DVec3, e1: DVec3, e2: DVec3) -> Edge {
        let [p, q] = ends;
        let along = q - p;
        let [run, rise] = [along.dot(e1), along.dot(e2)];
        // Twice the triangle's area over the edge, exact where its coordinates are few: no rotated corner is.
        let area = down.dot(p.cross(q));
        let (a, b) = (p.abs(), q.abs());
        let terms = down.abs().dot(DVec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x));
        // (e1, e2, down) is right-handed.
        Edge {
            ends: ends.map(|p| [p.dot(e1), p.dot(e2)]),
            level: -area / run,
            level_doubt: (f64::EPSILON * terms + slip * along.length()) / run.abs(),
            slope: rise / run,
        }
    }

    fn on_strip(&self, sigma: f64) -> Option<(f64, f64)> {
        let [[from, _], [to, _]] = self.ends;
        let lift = sigma * self.slope;
        let doubt = self.level_doubt + f64::EPSILON * (self.level.abs() + 2.0 * lift.abs());
        ((from > sigma) != (to > sigma)).then_some((self.level + lift, doubt))
    }
}

/// Of a few turns, the one whose strips stay clearest of all edges.
fn least_parallel(own: &[[DVec3; 2]], blockers: &[Blocker], down: DVec3, axes: &impl Fn(f64) -> [DVec3; 2]) -> f64 {
    // Edges beyond these seldom matter, and a bad turn costs time, not truth.
    const ENOUGH: usize = 64;
    let own = own.iter().map(|[p, q]| (*q - *p).normalize_or_zero());
    // A line of sight's plane meets the source's plane along this direction.
    let others = blockers.iter().flat_map(Blocker::edges).map(|[p, q]| p.cross(q).cross(down).normalize_or_zero());
    let along: Vec<DVec3> = own.chain(others).take(ENOUGH).collect();
    let clear = |turn: f64| {
        let [e1, _] = axes(turn);
        along.iter().filter(|d| **d != DVec3::ZERO).map(|d| d.dot(e1).abs()).fold(1.0, f64::min)
    };
    let mut best = (TURNS[0], clear(TURNS[0]));
    for turn in TURNS {
        // Where the first will do, it stays: a scene that moves a little keeps its strips.
        if best.1 < 1e-2 && clear(turn) > best.1 {
            best = (turn, clear(turn));
        }
    }
    best.0
}
