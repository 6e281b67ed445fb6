//! How one source looks from the eye: its plane in strips, and what may stand before it.

use glam::DVec3;

use super::blocker::Blocker;
use super::breaks;
use super::super::body::{Body, Figure};
use crate::geometry::Frame;

/// The strips' frame on the source's plane. Lengths are in a unit of the view's own, a power of two that brings the
/// source's distance near one; points are relative to the eye.
///
/// A strip is the line `height down + s e1 + t e2` at one s; (σ, τ) are (s, t) relative to the source's centre, so that
/// a small source far away keeps its digits.
///
/// A sphere source is looked at on the disk of its silhouette, which fills the same directions.
pub(super) struct View<'a> {
    pub n: DVec3,
    /// Unit, from the eye to its foot on the plane.
    pub down: DVec3,
    pub height: f64,
    pub e1: DVec3,
    pub e2: DVec3,
    /// (s, t) of the source's centre.
    pub center: [f64; 2],
    /// The source's centre in space: that of the plane figure, or of the sphere.
    pub middle: DVec3,
    pub outline: Outline,
    /// A sphere source's radius: light starts from its front.
    pub ball: Option<f64>,
    pub blockers: Vec<Blocker<'a>>,
    /// The view's unit in the bodies' unit.
    pub unit: f64,
}

/// The source's outline in (σ, τ).
pub(super) enum Outline {
    Circle { radius: f64 },
    Edges(Vec<[[f64; 2]; 2]>),
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

/// A stretch of a strip, in τ, with how far off either end may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub from: f64,
    pub to: f64,
    pub doubt_from: f64,
    pub doubt_to: f64,
}

/// Angles at which strips may run, radians: one of them suits, as no edge of the scene should be parallel to them.
const TURNS: [f64; 5] = [0.618_033_988_749_894_9, 1.144_122_805_635_368_6, 0.083_203_350_589_9, 1.713, 2.414_213_562_373];

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
            Figure::Ball { .. } => {
                let distance = middle.length();
                (middle / distance, (distance - reach) * (distance + reach) / distance, Some(reach))
            }
        };
        let least = if ball.is_some() { f64::EPSILON * f64::EPSILON } else { 4.0 * f64::EPSILON };
        if height.is_nan() || height <= least {
            return None;
        }
        let blockers: Vec<Blocker> = occluders.iter().map(|body| Blocker::new(body, eye, unit)).collect();
        let frame = Frame::around(down);
        let axes = |turn: f64| {
            let (sin, cos) = turn.sin_cos();
            [frame.tangent * cos + frame.bitangent * sin, frame.bitangent * cos - frame.tangent * sin]
        };
        let corners = match &source.figure {
            Figure::Flat(shape) => {
                let at = |i: u32| ((shape.origin - source.center) + shape.offsets[i as usize]) / unit;
                shape.edges.iter().map(|edge| edge.map(at)).collect()
            }
            _ => Vec::new(),
        };
        let [e1, e2] = axes(least_parallel(&corners, &blockers, down, &axes));
        let outline = match &source.figure {
            Figure::Disk { radius, .. } => Outline::Circle { radius: radius / unit },
            Figure::Ball { .. } => Outline::Circle { radius: reach * (height / middle.length()).sqrt() },
            Figure::Flat(_) => {
                Outline::Edges(corners.iter().map(|edge| edge.map(|p| [p.dot(e1), p.dot(e2)])).collect())
            }
        };
        let center = if ball.is_some() { [0.0, 0.0] } else { [middle.dot(e1), middle.dot(e2)] };
        let mut view = View { n, down, height, e1, e2, center, middle, outline, ball, blockers, unit };
        let ranges: Vec<[f64; 2]> = view.blockers.iter().map(|b| breaks::range(&view, &b.form)).collect();
        for (blocker, range) in view.blockers.iter_mut().zip(ranges) {
            blocker.range = range;
        }
        Some(view)
    }

    /// The source's ends in σ.
    pub fn extent(&self) -> (f64, f64) {
        match &self.outline {
            Outline::Circle { radius } => (-radius, *radius),
            Outline::Edges(edges) => edges
                .iter()
                .flatten()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[0]), high.max(p[0]))),
        }
    }

    pub fn strip(&self, sigma: f64) -> Strip {
        let s = self.center[0] + sigma;
        let y = self.height.hypot(s);
        let ahead = (self.down * self.height + self.e1 * s) / y;
        Strip { sigma, ahead, y, across: ahead.cross(self.e2) }
    }

    /// (σ, τ) of a direction, if it meets the source's plane.
    pub fn flat(&self, direction: DVec3) -> Option<[f64; 2]> {
        let depth = direction.dot(self.down);
        let share = self.height / depth;
        let at = [direction.dot(self.e1) * share - self.center[0], direction.dot(self.e2) * share - self.center[1]];
        (depth > 0.0 && at[0].is_finite() && at[1].is_finite()).then_some(at)
    }

    /// The point of the source's plane at τ of a strip.
    pub fn point(&self, strip: &Strip, tau: f64) -> DVec3 {
        strip.ahead * strip.y + self.e2 * (self.center[1] + tau)
    }

    /// Where on the source a ray through a point of its plane ends, relative to `middle`.
    pub fn on_source(&self, strip: &Strip, tau: f64) -> DVec3 {
        match self.ball {
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
        let rounding = 4.0 * f64::EPSILON;
        match &self.outline {
            Outline::Circle { radius } => {
                let half = ((radius - sigma) * (radius + sigma)).max(0.0).sqrt();
                if half > 0.0 {
                    let doubt = rounding * radius * (radius / half);
                    stretches.push(Stretch { from: -half, to: half, doubt_from: doubt, doubt_to: doubt });
                }
            }
            Outline::Edges(edges) => {
                let mut crossings: Vec<(f64, f64)> = Vec::with_capacity(4);
                for [[sa, ta], [sb, tb]] in edges {
                    if (*sa > sigma) != (*sb > sigma) {
                        let slope = (tb - ta) / (sb - sa);
                        let (near, far) = (sa.abs().max(sb.abs()), ta.abs().max(tb.abs()));
                        crossings.push((ta + (sigma - sa) * slope, rounding * (far + near * slope.abs())));
                    }
                }
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

    /// n·r along a strip: its value at τ = 0, and its slope.
    pub fn cosine(&self, strip: &Strip) -> (f64, f64) {
        (self.n.dot(self.point(strip, 0.0)), self.n.dot(self.e2))
    }
}

/// Of a few turns, the one whose strips stay clearest of all edges.
fn least_parallel(
    own: &[[DVec3; 2]],
    blockers: &[Blocker],
    down: DVec3,
    axes: &impl Fn(f64) -> [DVec3; 2],
) -> f64 {
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
