//! Limits in closed form: one source, one occluder, a straight line, in a pose where shadows are circles, boxes or cones.
//!
//! Each family lists the places where its phase may change, with their bounds, and tells the phase anywhere between them.

use glam::DVec3;

use super::path::{Path, PathShape};
use super::{Limit, LimitMethod, Phase};
use crate::configuration::Configuration;
use crate::geometry::{Disk, Rectangle, Shape, Sphere};

/// Directions nearer to parallel or square than this are so but for rounding.
const ALIGNED: f64 = 4.0 * f64::EPSILON;
/// Rounding steps behind a length below, in units of `f64::EPSILON` times the lengths at hand: each formula has fewer.
const STEPS: f64 = 8.0;

/// A line of points: `origin + direction × distance`.
#[derive(Clone, Copy)]
struct Line {
    origin: DVec3,
    direction: DVec3,
    length: f64,
    normal: DVec3,
}

impl Line {
    fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }
    /// Whether something that is lowest at a height over the horizon of each of the line's points is above it all along:
    /// heights change linearly, so that the ends decide.
    fn sees_whole(&self, lowest: impl Fn(DVec3) -> f64) -> bool {
        lowest(self.origin) >= 0.0 && lowest(self.at(self.length)) >= 0.0
    }
    fn size(&self) -> f64 {
        self.origin.abs().max(self.at(self.length).abs()).max_element()
    }
}

/// A place where the phase may change, and how far off it may be.
type Candidate = (f64, f64);

/// What a length of a parallel pair is off by: the heights' rounding, through the lever 1/(H − z), and its own.
///
/// - `line`: size of the line's coordinates; `between` H − z; `reach`: of both shapes together; `shadow`: the largest length
///   asked for
fn rounding(line: f64, source: DVec3, occluder: DVec3, between: f64, reach: f64, shadow: f64) -> f64 {
    let apart = source.distance(occluder);
    let coordinates = line + source.abs().max(occluder.abs()).max_element();
    STEPS * f64::EPSILON * (coordinates * (1.0 + (reach + apart) / between) + shadow * (1.0 + apart / between))
}

/// All limits, in order; `None` where no closed form applies.
pub(super) fn limits(configuration: &Configuration, path: &Path) -> Option<Vec<Limit>> {
    let PathShape::Segment { direction } = path.shape else { return None };
    let ([source], [occluder]) = (configuration.sources(), configuration.blockers()) else { return None };
    let line = Line { origin: path.from.position(), direction, length: path.length, normal: path.from.normal() };
    match (source.shape(), occluder) {
        (Shape::Disk(source), Shape::Disk(occluder)) => {
            let pair = Circles::of(source, occluder, line)?;
            Some(ordered(path, pair.candidates(), |distance| pair.phase(distance)))
        }
        (Shape::Rectangle(source), Shape::Rectangle(occluder)) => {
            let pair = Boxes::of(source, occluder, line)?;
            Some(ordered(path, pair.candidates(), |distance| pair.phase(distance)))
        }
        (Shape::Sphere(source), Shape::Sphere(occluder)) => {
            let pair = Cones::of(source, occluder, line)?;
            Some(ordered(path, pair.candidates(), |distance| pair.phase(distance)))
        }
        _ => None,
    }
}

/// The candidates at which the phase does change.
fn ordered(path: &Path, mut candidates: Vec<Candidate>, phase: impl Fn(f64) -> Phase) -> Vec<Limit> {
    candidates.retain(|(distance, _)| *distance > 0.0 && *distance < path.length());
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    // What lies within its own bound of the next is one place.
    let mut places: Vec<Candidate> = Vec::new();
    for (distance, bound) in candidates {
        match places.last_mut() {
            Some(last) if distance - last.0 <= bound.max(last.1) => last.1 = last.1.max(bound) + (distance - last.0),
            _ => places.push((distance, bound)),
        }
    }
    let between = |i: usize| {
        let from = if i == 0 { 0.0 } else { places[i - 1].0 };
        let to = places.get(i).map_or(path.length(), |place| place.0);
        phase(from + 0.5 * (to - from))
    };
    let limit = |(i, (distance, bound)): (usize, &Candidate)| {
        let (before, after) = (between(i), between(i + 1));
        let position = path.at(*distance).position();
        let method = LimitMethod::ClosedForm;
        (before != after).then_some(Limit { distance: *distance, position, before, after, bound: *bound, method })
    };
    places.iter().enumerate().filter_map(limit).collect()
}

/// Parallel disks and a line parallel to them.
///
/// Seen from a point, source height H, occluder height z, the occluder's shadow on the source's plane is a circle of radius
/// bH/z whose centre is as far from the source's as the point is from the place c, times z/(H − z) upside down:
///
/// ```text
/// c = c_o − (c_s − c_o) z/(H − z),   umbra where |x − c| ≤ (bH − az)/(H − z), antumbra where ≤ (az − bH)/(H − z),
/// lit where |x − c| ≥ (bH + az)/(H − z)
/// ```
struct Circles {
    /// Where the line is nearest to c, and how near.
    nearest: f64,
    offset: f64,
    /// Negative for an antumbra.
    core: f64,
    penumbra: f64,
    /// Of the lengths above, metres.
    rounding: f64,
}

impl Circles {
    fn of(source: &Disk, occluder: &Disk, line: Line) -> Option<Circles> {
        let m = source.normal();
        let is_parallel = m.cross(occluder.normal()).length() <= ALIGNED && m.dot(line.direction).abs() <= ALIGNED;
        let (high, low) = (m.dot(line.origin - source.center()), m.dot(line.origin - occluder.center()));
        let tilt = line.normal.cross(m).length();
        let lowest = |x: DVec3| line.normal.dot(source.center() - x) - source.radius() * tilt;
        if !(is_parallel && low > 0.0 && high > low && line.sees_whole(lowest)) {
            return None;
        }
        let between = high - low;
        let centre = occluder.center() - (source.center() - occluder.center()) * (low / between);
        let across = line.origin - centre;
        let nearest = -across.dot(line.direction);
        let off = across + line.direction * nearest;
        let (a, b) = (source.radius(), occluder.radius());
        let penumbra = (b * high + a * low) / between;
        Some(Circles {
            nearest,
            offset: (off - m * off.dot(m)).length(),
            core: (b * high - a * low) / between,
            penumbra,
            rounding: rounding(line.size(), source.center(), occluder.center(), between, a + b, penumbra),
        })
    }

    fn candidates(&self) -> Vec<Candidate> {
        let crossing = |radius: f64| {
            let half = ((radius - self.offset) * (radius + self.offset)).sqrt();
            // Off by dr along the radius is off by dr × radius/half along the line, and never by more than at a touch.
            let bound = (self.rounding * (1.0 + radius / half)).min((2.0 * self.rounding * radius).sqrt());
            [(self.nearest - half, bound), (self.nearest + half, bound)]
        };
        let met = [self.core.abs(), self.penumbra].into_iter().filter(|radius| *radius > self.offset);
        met.flat_map(crossing).collect()
    }

    fn phase(&self, distance: f64) -> Phase {
        let away = self.offset.hypot(distance - self.nearest);
        if away >= self.penumbra {
            Phase::Lit
        } else if away <= self.core {
            Phase::Umbra
        } else if away <= -self.core {
            Phase::Antumbra
        } else {
            Phase::Penumbra
        }
    }
}

/// Parallel rectangles with parallel edges, and a line parallel to their planes.
///
/// Along either edge's direction an occluder's edge at O and a source's edge at S, at heights z and H, line up from
/// `x = O + (O − S) z/(H − z)`; a source of width w behind a straight edge so has a penumbra of width w z/(H − z).
struct Boxes {
    sides: [Side; 2],
    /// H/z: how much farther out the shadow on the source's plane is.
    farther: f64,
    /// z/(H − z)
    lever: f64,
    rounding: f64,
}

/// What the pair is along one edge: middles and half widths, and how the line runs.
struct Side {
    source: [f64; 2],
    occluder: [f64; 2],
    /// Of the line's origin, and its slope.
    origin: f64,
    slope: f64,
}

impl Boxes {
    fn of(source: &Rectangle, occluder: &Rectangle, line: Line) -> Option<Boxes> {
        let m = source.normal();
        let (u, v) = (source.edge_u().normalize(), source.edge_v().normalize());
        let is_along = |a: DVec3, b: DVec3| a.normalize().cross(b).length() <= ALIGNED;
        let (edge_u, edge_v) = if is_along(occluder.edge_u(), u) {
            (occluder.edge_u(), occluder.edge_v())
        } else {
            (occluder.edge_v(), occluder.edge_u())
        };
        let is_square = u.dot(v).abs() <= ALIGNED && is_along(edge_u, u) && is_along(edge_v, v);
        let (high, low) = (m.dot(line.origin - source.center()), m.dot(line.origin - occluder.center()));
        let lowest = |x: DVec3| {
            source.corners().iter().map(|corner| line.normal.dot(*corner - x)).fold(f64::INFINITY, f64::min)
        };
        let is_level = m.dot(line.direction).abs() <= ALIGNED;
        if !(is_square && is_level && low > 0.0 && high > low && line.sees_whole(lowest)) {
            return None;
        }
        // About the source's centre, so that a room far from the origin keeps its digits.
        let about = source.center();
        let side = |axis: DVec3, own: DVec3, other: DVec3| Side {
            source: [0.0, 0.5 * own.length()],
            occluder: [axis.dot(occluder.center() - about), 0.5 * other.length()],
            origin: axis.dot(line.origin - about),
            slope: axis.dot(line.direction),
        };
        let reach = 0.5 * (source.edge_u() + source.edge_v()).length() + 0.5 * (edge_u + edge_v).length();
        let widest = reach * (high + low) / (high - low);
        Some(Boxes {
            sides: [side(u, source.edge_u(), edge_u), side(v, source.edge_v(), edge_v)],
            farther: high / low,
            lever: low / (high - low),
            rounding: rounding(line.size(), source.center(), occluder.center(), high - low, reach, widest),
        })
    }

    fn candidates(&self) -> Vec<Candidate> {
        let mut found = Vec::new();
        for side in self.sides.iter().filter(|side| side.slope.abs() > ALIGNED) {
            for (own, other) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                let (s, o) = (side.source[0] + own * side.source[1], side.occluder[0] + other * side.occluder[1]);
                let place = o + (o - s) * self.lever;
                found.push(((place - side.origin) / side.slope, self.rounding / side.slope.abs()));
            }
        }
        found
    }

    fn phase(&self, distance: f64) -> Phase {
        let (mut covers, mut inside) = (true, true);
        for side in &self.sides {
            let x = side.origin + side.slope * distance;
            let middle = x + (side.occluder[0] - x) * self.farther;
            let half = side.occluder[1] * self.farther;
            let apart = (middle - side.source[0]).abs();
            if apart >= half + side.source[1] {
                return Phase::Lit;
            }
            covers &= apart + side.source[1] <= half;
            inside &= apart + half < side.source[1];
        }
        match (covers, inside) {
            (true, _) => Phase::Umbra,
            (_, true) => Phase::Antumbra,
            _ => Phase::Penumbra,
        }
    }
}

/// Two spheres apart, and a line that meets neither.
///
/// With t along the axis from the occluder's centre away from the source's, at the distance L, and ρ from the axis, lines
/// that touch both spheres bound the shadow. Those between them, sin α = (R_s + R_o)/L, bound the penumbra; those along
/// them, sin α = (R_o − R_s)/L, bound the umbra, and beyond its tip the antumbra:
///
/// ```text
/// ρ cos α = R_o + t sin α,   t > −R_o sin α        (antumbra: ρ cos α = −(R_o + t sin α))
/// ```
struct Cones {
    line: Line,
    /// From the occluder's centre to the line's origin, and the unit axis.
    origin: DVec3,
    axis: DVec3,
    occluder_radius: f64,
    /// Sines of the penumbra's and the umbra's angle.
    penumbra: f64,
    umbra: f64,
    rounding: f64,
}

impl Cones {
    fn of(source: &Sphere, occluder: &Sphere, line: Line) -> Option<Cones> {
        let across = occluder.center() - source.center();
        let between = across.length();
        let (own, other) = (source.radius(), occluder.radius());
        let lowest = |x: DVec3| line.normal.dot(source.center() - x) - own;
        let clear = |sphere: &Sphere| {
            let along = (sphere.center() - line.origin).dot(line.direction).clamp(0.0, line.length);
            line.at(along).distance(sphere.center()) > sphere.radius()
        };
        if !(between > own + other && line.sees_whole(lowest) && clear(source) && clear(occluder)) {
            return None;
        }
        let size = line.size()
            + source.center().abs().max(occluder.center().abs()).max_element()
            + line.origin.distance(occluder.center());
        Some(Cones {
            line,
            origin: line.origin - occluder.center(),
            axis: across / between,
            occluder_radius: other,
            penumbra: (own + other) / between,
            umbra: (other - own) / between,
            // The axis turns by the rounding of both centres over their distance.
            rounding: STEPS * f64::EPSILON * size * (1.0 + size / between),
        })
    }

    /// Along and across the axis.
    fn coordinates(&self, distance: f64) -> (f64, DVec3) {
        let at = self.origin + self.line.direction * distance;
        let along = at.dot(self.axis);
        (along, at - self.axis * along)
    }

    fn candidates(&self) -> Vec<Candidate> {
        [self.penumbra, self.umbra].into_iter().flat_map(|sine| self.crossings(sine)).collect()
    }

    /// (ρ cos α)² = (R_o + t sin α)², a quadratic in the distance.
    fn crossings(&self, sine: f64) -> Vec<Candidate> {
        let cosine = ((1.0 - sine) * (1.0 + sine)).sqrt();
        // About the place where the line is nearest to the axis, so that the coefficients do not cancel.
        let slope_along = self.line.direction.dot(self.axis);
        let slope_across = self.line.direction - self.axis * slope_along;
        let (_, start) = self.coordinates(0.0);
        let square = slope_across.length_squared();
        let about = if square > 0.0 { -start.dot(slope_across) / square } else { 0.0 };
        let (along, across) = self.coordinates(about);
        let reach = self.occluder_radius + along * sine;
        let off = cosine * across.length();
        let (a, b, c) = (
            (cosine * square.sqrt() - sine * slope_along) * (cosine * square.sqrt() + sine * slope_along),
            cosine * cosine * across.dot(slope_across) - reach * sine * slope_along,
            (off - reach) * (off + reach),
        );
        let discriminant = b * b - a * c;
        if discriminant.is_nan() || discriminant < 0.0 {
            return Vec::new();
        }
        let q = -(b + discriminant.sqrt().copysign(b));
        let bound = |distance: f64| {
            let (along, across) = self.coordinates(distance);
            let outwards = cosine * across.normalize_or_zero().dot(slope_across);
            let side = (self.occluder_radius + along * sine).signum();
            let rate = (outwards - side * sine * slope_along).abs();
            (self.rounding / rate).min((self.rounding * self.line.length).sqrt()) + self.rounding
        };
        [q / a, c / q].into_iter().map(|s| about + s).filter(|s| s.is_finite()).map(|s| (s, bound(s))).collect()
    }

    fn phase(&self, distance: f64) -> Phase {
        let (along, across) = self.coordinates(distance);
        let off = across.length();
        let reach = |sine: f64| {
            let cosine = ((1.0 - sine) * (1.0 + sine)).sqrt();
            (self.occluder_radius + along * sine) / cosine
        };
        let is_behind = |sine: f64| along > -self.occluder_radius * sine;
        if !(is_behind(self.penumbra) && off < reach(self.penumbra)) {
            Phase::Lit
        } else if is_behind(self.umbra) && off <= reach(self.umbra) {
            Phase::Umbra
        } else if off <= -reach(self.umbra) {
            Phase::Antumbra
        } else {
            Phase::Penumbra
        }
    }
}
