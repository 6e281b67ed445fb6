//! An area source seen in a flat mirror, past occluders on both legs of the way.
//!
//! What a point x sees in a flat mirror is what its mirror image x′ sees through the mirror's outline as through a window:
//! the real source, where it stands. So the eye is mirrored, not the source. Three sets of directions from x′ decide:
//!
//! - the window W;
//! - the source S, cut to the mirror's lit side;
//! - what is in the way: between mirror and source the occluders themselves, cut to the lit side; between receiver and mirror
//!   their mirror images, which lie on the side of x′.
//!
//! The light is W less (all that is not S) less what is in the way, by the contour mechanism of the direct light: the source's
//! complement is one more thing in front of the window. Nothing is told as a difference of two near-equal factors.
//!
//! Limits, each told by an error: an occluder that both the mirror's plane and the source's cut; one that cuts into a sphere
//! source. The mirror reflects on both sides; one reflection only.

use std::hash::{DefaultHasher, Hash, Hasher};

use glam::DVec3;

use super::{OpticsError, share};
use crate::configuration::{Configuration, MeasurementPoint};
use crate::geometry::{Disk, Mesh, Polygon, Rectangle, Shape, ShapeError, Sphere};
use crate::number::{Vector, Wide};
use crate::oracle::body::{Body, Figure};
use crate::oracle::exact::{Oracle, PARTED};
use crate::oracle::form::{Form, HalfSpace};
use crate::oracle::front::{Blocking, Front};
use crate::oracle::patch::{Average, Patch, Tolerance, Value, average_of};
use crate::oracle::penumbra::{self, Visible};
use crate::oracle::piece::Piece;
use crate::oracle::point_factor::{self, Factor};
use crate::radiometry::{FormFactor, Irradiance};

/// A flat mirror: its outline, and the share of the power that it sends back, the same for all angles.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneMirror {
    shape: Shape,
    reflectance: f64,
}

impl PlaneMirror {
    /// - `shape`: a disk, rectangle or polygon; it reflects on both sides
    /// - `reflectance`: in [0, 1]
    pub fn new(shape: Shape, reflectance: f64) -> Result<PlaneMirror, OpticsError> {
        match shape {
            Shape::Disk(_) | Shape::Rectangle(_) | Shape::Polygon(_) => {}
            _ => return Err(OpticsError::MirrorShape { said: shape.kind() }),
        }
        Ok(PlaneMirror { shape, reflectance: share("the reflectance", reflectance)? })
    }
    /// Its outline.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }
    /// The share of the power that it sends back.
    pub fn reflectance(&self) -> f64 {
        self.reflectance
    }
}

/// The light of all sources by way of one mirror, at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorTruth {
    /// Of all sources together, each weighed by its exitance, times the mirror's reflectance; W/m². Direct light is not in it.
    pub irradiance: Irradiance,
    /// Of the parts of all sources that are seen in the mirror, with exitance and reflectance 1; a pure number.
    pub form_factor: FormFactor,
    /// The irradiance is off by no more than this; W/m².
    pub bound: Irradiance,
    /// Whether nothing is seen in the mirror, by classification rather than by a comparison of numbers.
    pub is_dark: bool,
    /// Names what the outlines of all that is seen are made of: equal where the irradiance is smooth in between.
    kind: u64,
}

/// Exact irradiance by way of one mirror at any point of a configuration.
///
/// Every source is also in the way, of itself and of the others: its back is opaque. The mirror's own place among the
/// occluders, if it stands there for the sake of the direct light, does not matter here.
///
/// ```
/// use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
/// use etendue::geometry::{DVec3, Disk, Rectangle, Shape};
/// use etendue::oracle::optics::{MirrorOracle, PlaneMirror};
/// use etendue::radiometry::Exitance;
///
/// // A lamp at the ceiling, a mirror on the floor, and a point of the ceiling beside the lamp.
/// let lamp = Source::new(Disk::new(DVec3::Z, -DVec3::Z, 0.2).map(Shape::Disk)?, Exitance::new(1.0))?;
/// let point = MeasurementPoint::new(DVec3::new(0.5, 0.0, 1.0), -DVec3::Z)?;
/// let room = Configuration::new(vec![lamp], vec![], None, vec![point], Arrangement::Scattered).unwrap();
/// let mirror = PlaneMirror::new(Shape::Rectangle(Rectangle::new(DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0)?), 0.9)?;
/// let found = MirrorOracle::new(&room, &mirror)?.at(&point)?;
/// // The lamp's image is a disk two metres below, parallel: seen whole.
/// let (h, d, a) = (2.0_f64, 0.5_f64, 0.2_f64);
/// let sum = h * h + d * d + a * a;
/// let expected = 0.5 * (1.0 - (sum - 2.0 * a * a) / (sum * sum - 4.0 * a * a * d * d).sqrt());
/// assert!((found.form_factor.ratio() - expected).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MirrorOracle {
    oracle: Oracle,
    glass: Body,
    /// Unit; of one of its sides.
    normal: DVec3,
    /// On its plane.
    origin: DVec3,
    /// Mirror images of all occluders, then of all sources, by the index of their originals.
    images: Vec<(Body, usize)>,
    reflectance: f64,
}

/// One source in the mirror.
struct Seen {
    factor: Factor,
    is_dark: bool,
    kind: u64,
}

impl Seen {
    fn nothing() -> Seen {
        Seen { factor: Factor::nothing(), is_dark: true, kind: 0 }
    }
}

/// The mirror image of a receiver.
struct Behind {
    eye: Vector<Wide>,
    normal: Vector<Wide>,
    /// What lies on the receiver's side of the mirror's plane, relative to the mirrored eye.
    lit: HalfSpace<Wide>,
    /// Coordinates in units of the eye's height over the mirror's plane: with it grows the eye's own rounding, as it looks at
    /// the window.
    remoteness: f64,
}

/// What cuts a body that is in the way.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cut {
    Nothing,
    /// The source's front: what lies behind it hides nothing.
    Front,
    /// The mirror's plane: only what lies on the lit side.
    Lit,
    /// The mirror's plane: only what lies on the mirrored eye's side.
    Behind,
}

/// Which body is in the way: itself, or its image.
#[derive(Clone, Copy, Debug)]
enum InTheWay {
    Real(usize),
    Image(usize),
}

/// Relative slack of what lies in a plane.
const FLUSH: f64 = 64.0 * f64::EPSILON;
/// Above this, relative to the value, a bound calls for numbers of twice the width.
const LOOSE: f64 = 1e-13;
/// Above this many heights from the origin a mirrored eye's rounding is more than the terms' own.
const REMOTE: f64 = 32.0;
/// Relative error of what these return; of the sum of the terms' sizes.
const WIDE_EPSILON: f64 = 1e-28;

impl MirrorOracle {
    /// Prepares all shapes and their mirror images once, for any number of points.
    pub fn new(configuration: &Configuration, mirror: &PlaneMirror) -> Result<MirrorOracle, OpticsError> {
        let oracle = Oracle::new(configuration);
        let scale = oracle.scale;
        let (origin, normal) = match &mirror.shape {
            Shape::Disk(s) => (s.center(), s.normal()),
            Shape::Rectangle(s) => (s.center(), s.normal()),
            Shape::Polygon(s) => (s.vertices()[0], s.normal()),
            other => return Err(OpticsError::MirrorShape { said: other.kind() }),
        };
        let kind = mirror.shape.kind();
        let glass = Body::of_shape(&mirror.shape, scale).pop().ok_or(OpticsError::MirrorShape { said: kind })?;
        let sources = configuration.sources().iter().map(|source| source.shape());
        let mut images = Vec::new();
        for (i, shape) in configuration.occluders().iter().chain(sources).enumerate() {
            let image = image(shape, origin, normal)?;
            images.extend(Body::of_shape(&image, scale).into_iter().map(|body| (body, i)));
        }
        Ok(MirrorOracle { oracle, glass, normal, origin: origin * scale, images, reflectance: mirror.reflectance })
    }

    /// The exact irradiance by way of the mirror at a point, with its bound.
    ///
    /// - error: at most `bound`; in general below 10⁻¹³ relative
    /// - source: the image behind a flat mirror; [`crate::oracle::Oracle::at`]'s contours; table `mirror_window`
    pub fn at(&self, point: &MeasurementPoint) -> Result<MirrorTruth, OpticsError> {
        let (mut irradiance, mut form_factor, mut bound) = (0.0, 0.0, 0.0);
        let mut is_dark = true;
        let mut hasher = DefaultHasher::new();
        let behind = self.behind(point)?;
        for (index, source) in self.oracle.sources.iter().enumerate() {
            let seen = self.of_source(index, &behind)?;
            irradiance += source.exitance * seen.factor.value;
            form_factor += seen.factor.value;
            bound += source.exitance * seen.factor.bound;
            is_dark &= seen.is_dark;
            seen.kind.hash(&mut hasher);
        }
        Ok(MirrorTruth {
            irradiance: Irradiance::new(self.reflectance * irradiance),
            form_factor: FormFactor::new(form_factor),
            bound: Irradiance::new(self.reflectance * bound + 2.0 * f64::EPSILON * irradiance),
            is_dark,
            kind: hasher.finish(),
        })
    }

    /// The mean over a patch of the irradiance by way of the mirror: times the patch's area, the power that the mirror sends
    /// there.
    ///
    /// Where a point has no answer (it lies in the mirror's plane, or shapes cut each other there) the bound is infinite.
    ///
    /// - `patch`: receives on the side of its normal; it blocks no light
    /// - error: `bound`, an estimate (as of [`crate::oracle::patch::average_irradiance`])
    pub fn average_irradiance(&self, patch: &Patch, tolerance: Tolerance) -> Average {
        let field = |point: &MeasurementPoint| match self.at(point) {
            Ok(truth) => {
                let irradiance = truth.irradiance.watts_per_square_metre();
                Value {
                    irradiance,
                    bound: truth.bound.watts_per_square_metre(),
                    unoccluded: irradiance,
                    kind: truth.kind,
                }
            }
            Err(_) => Value { irradiance: 0.0, bound: f64::INFINITY, unoccluded: 0.0, kind: u64::MAX },
        };
        average_of(&field, patch, tolerance)
    }

    /// The receiver's mirror image, to twice the digits: the mirror's plane from the numbers it was given with.
    fn behind(&self, point: &MeasurementPoint) -> Result<Behind, OpticsError> {
        let eye = Vector::constant(point.position()) * Wide::from(self.oracle.scale);
        let (plane, on_plane) = match Form::refined(&self.glass, eye) {
            Form::Disk { center, normal, .. } => (normal, center),
            Form::Flat(flat) => (flat.normal, flat.corners[0]),
            _ => return Err(OpticsError::InMirrorPlane),
        };
        let height = plane.dot(on_plane);
        let size = eye.primal().length() + self.glass.center.length() + self.glass.reach;
        if height.narrow().abs() <= FLUSH * size {
            return Err(OpticsError::InMirrorPlane);
        }
        // Towards the receiver.
        let (plane, height) = if height.narrow() > 0.0 { (-plane, -height) } else { (plane, height) };
        let normal = Vector::constant(point.normal_as_given()).normalize();
        let mirrored = normal - plane * (plane.dot(normal) * 2.0);
        Ok(Behind {
            eye: eye + plane * (height * 2.0),
            normal: mirrored,
            lit: HalfSpace { normal: plane, k: height },
            remoteness: (point.position().length() * self.oracle.scale + self.origin.length())
                / height.narrow().abs(),
        })
    }

    fn body(&self, at: InTheWay) -> &Body {
        let occluders = &self.oracle.occluders;
        match at {
            InTheWay::Image(i) => &self.images[i].0,
            InTheWay::Real(i) if i < occluders.len() => &occluders[i],
            InTheWay::Real(i) => &self.oracle.sources[i - occluders.len()].body,
        }
    }

    /// What a refusal calls a body: its place among the occluders, then the sources.
    fn named(&self, at: InTheWay) -> usize {
        let occluders = &self.oracle.occluder_of;
        match at {
            InTheWay::Image(i) => self.images[i].1,
            InTheWay::Real(i) => match occluders.get(i) {
                Some(occluder) => *occluder,
                None => i - occluders.len() + occluders.last().map_or(0, |last| last + 1),
            },
        }
    }

    fn of_source(&self, index: usize, behind: &Behind) -> Result<Seen, OpticsError> {
        let (eye, n) = (behind.eye.primal(), behind.normal.primal());
        let lit = HalfSpace { normal: Vector::constant(behind.lit.normal.primal()), k: behind.lit.k.narrow() };
        let shaded = HalfSpace { normal: -lit.normal, k: -lit.k };
        let body = &self.oracle.sources[index].body;
        let [low, high] = self.heights(body, lit.normal.primal());
        let Some(window) = Piece::of_source(&Form::plain(&self.glass, eye), Vector::constant(n)) else {
            return Ok(Seen::nothing());
        };
        let form = Form::plain(body, eye);
        let Some(front) = Front::of(body, &form).filter(|_| high > 0.0) else { return Ok(Seen::nothing()) };
        let cut = if low < 0.0 { Cut::Lit } else { Cut::Nothing };
        let keep = |cut: Cut| match cut {
            Cut::Nothing => None,
            Cut::Front => Some(form.front()),
            Cut::Lit => Some(lit),
            Cut::Behind => Some(shaded),
        };
        let Some(image) = Piece::of_occluder(&form, keep(cut)) else { return Ok(Seen::nothing()) };
        let mut pieces = vec![image.complement()];
        let mut blockers = Vec::new();
        let others = self.oracle.occluders.len();
        for i in (0..others + self.oracle.sources.len()).filter(|i| *i != others + index) {
            let at = InTheWay::Real(i);
            let occluder = self.body(at);
            let [low, high] = self.heights(occluder, lit.normal.primal());
            if high <= 0.0 {
                continue;
            }
            let (piece, cut) = if low < 0.0 {
                if holds(occluder, eye) {
                    return Err(OpticsError::TwiceCut { said: self.named(at) });
                }
                let before = form.front();
                let plane = before.normal.primal();
                let [low, high] = span(occluder, plane).map(|h| h - plane.dot(eye) + before.k);
                let noise = FLUSH * (eye.length() + occluder.center.length() + occluder.reach + body.reach);
                if high <= noise {
                    continue;
                } else if low < -noise {
                    return Err(OpticsError::TwiceCut { said: self.named(at) });
                }
                (Piece::of_occluder(&Form::plain(occluder, eye), keep(Cut::Lit)), Cut::Lit)
            } else {
                match front.before(occluder, eye) {
                    Blocking::None => continue,
                    Blocking::All => return Ok(Seen::nothing()),
                    Blocking::Part { piece, is_clipped } => {
                        (Some(piece), if is_clipped { Cut::Front } else { Cut::Nothing })
                    }
                    Blocking::Within => {
                        return Err(OpticsError::CutsIntoSource { said: index, occluder: self.named(at) });
                    }
                }
            };
            if let Some(piece) = piece {
                pieces.push(piece);
                blockers.push((at, cut));
            }
        }
        for i in 0..self.images.len() {
            let at = InTheWay::Image(i);
            let occluder = self.body(at);
            let [low, high] = self.heights(occluder, lit.normal.primal());
            if low >= 0.0 {
                continue;
            }
            if holds(occluder, eye) {
                // The receiver is inside the original.
                return Ok(Seen::nothing());
            }
            let cut = if high > 0.0 { Cut::Behind } else { Cut::Nothing };
            if let Some(piece) = Piece::of_occluder(&Form::plain(occluder, eye), keep(cut)) {
                pieces.push(piece);
                blockers.push((at, cut));
            }
        }
        let seen = penumbra::visible(n, &window, &pieces);
        let doubt = seen.doubt / (2.0 * std::f64::consts::PI);
        if seen.nothing_seen() && doubt == 0.0 {
            return Ok(Seen::nothing());
        }
        let mut hasher = DefaultHasher::new();
        seen.source_hidden.hash(&mut hasher);
        seen.outline.topology(&mut hasher);
        let mut factor = self.factor(index, &seen, &window, cut, &blockers, behind);
        factor.bound *= 1.0 + behind.remoteness * 1e-3;
        factor.bound += doubt + self.blur(&seen, &blockers, eye, lit.k.abs());
        factor.value = factor.value.max(0.0);
        Ok(Seen { factor, is_dark: false, kind: hasher.finish() })
    }

    /// An image's coordinates are rounded: how far that may move what its outline lets through.
    ///
    /// An outline that is off by an angle moves a factor by no more than that angle times its length over π, and a great
    /// circle's length at most twice over is what one body's outline has.
    ///
    /// - `height`: of the eye over the mirror's plane, in which an image may be cut
    fn blur(&self, seen: &Visible, blockers: &[(InTheWay, Cut)], eye: DVec3, height: f64) -> f64 {
        let involved = seen.outline.pieces().into_iter().filter(|i| *i > 1).map(|i| blockers[i - 2].0);
        let of = |at: InTheWay| {
            let InTheWay::Image(_) = at else { return 0.0 };
            let body = self.body(at);
            let size = body.center.length() + body.reach + self.origin.length();
            4.0 * 8.0 * f64::EPSILON * size / to_outline(body, eye).min(height)
        };
        involved.map(of).fold(0.0, |sum, one| sum + one)
    }

    /// The contour's value, over numbers of twice the width where the plain ones lose too much.
    fn factor(
        &self,
        index: usize,
        seen: &Visible,
        window: &Piece,
        cut: Cut,
        blockers: &[(InTheWay, Cut)],
        behind: &Behind,
    ) -> Factor {
        let (eye, n) = (behind.eye.primal(), Vector::constant(behind.normal.primal()));
        let glass = || point_factor::unoccluded(&Form::plain(&self.glass, eye), window, n);
        let own = if seen.source_hidden { point_factor::from_terms(seen.source) } else { glass() };
        let shade = point_factor::from_terms(seen.occluders);
        // As `blur` has it: an eye that is off moves all outlines.
        let far = behind.remoteness;
        let moved = if far > REMOTE { 4.0 * 4.0 * f64::EPSILON * far } else { 0.0 };
        let plain = Factor { value: own.value - shade.value, bound: own.bound + shade.bound + moved };
        let is_grazing = |body: &Body| {
            let normal = match &body.figure {
                Figure::Disk { normal, .. } => *normal,
                Figure::Flat(flat) => flat.normal,
                Figure::Ball { .. } | Figure::Mesh(_) => return false,
            };
            normal.dot(body.center - eye).abs() < 1e-3 * (body.center.distance(eye) + body.reach)
        };
        let mut bodies =
            blockers.iter().map(|(at, _)| self.body(*at)).chain([&self.glass, &self.oracle.sources[index].body]);
        if plain.bound <= LOOSE * plain.value && !bodies.any(is_grazing) {
            return plain;
        }
        match self.wide(index, seen, cut, blockers, behind) {
            Some(wide) if (wide - plain.value).abs() <= PARTED * plain.bound => Factor {
                value: wide,
                bound: 4.0 * f64::EPSILON * wide.abs() + WIDE_EPSILON * plain.bound / f64::EPSILON,
            },
            _ => plain,
        }
    }

    fn wide(
        &self,
        index: usize,
        seen: &Visible,
        cut: Cut,
        blockers: &[(InTheWay, Cut)],
        behind: &Behind,
    ) -> Option<f64> {
        let (eye, n) = (behind.eye, behind.normal);
        let glass = Form::refined(&self.glass, eye);
        let window = Piece::of_source(&glass, n)?;
        let whole = (!seen.source_hidden).then(|| point_factor::unoccluded(&glass, &window, n));
        let form = Form::refined(&self.oracle.sources[index].body, eye);
        let keep = |cut: Cut| match cut {
            Cut::Nothing => None,
            Cut::Front => Some(form.front()),
            Cut::Lit => Some(behind.lit),
            Cut::Behind => Some(HalfSpace { normal: -behind.lit.normal, k: -behind.lit.k }),
        };
        let mut pieces = vec![None; 2 + blockers.len()];
        pieces[0] = Some(window);
        for i in seen.outline.pieces() {
            if i == 1 {
                pieces[1] = Some(Piece::of_occluder(&form, keep(cut))?.complement());
            } else if i > 1 {
                let (at, cut) = blockers[i - 2];
                pieces[i] = Piece::of_occluder(&Form::refined(self.body(at), eye), keep(cut));
            }
        }
        let [own, shade] = seen.outline.contour(n, &pieces)?.map(point_factor::from_terms);
        let own = whole.unwrap_or(own);
        Some((own.value - shade.value).narrow())
    }

    /// The lowest and the highest a body reaches over the mirror's plane; what lies in it within rounding, counts as zero.
    ///
    /// - `towards`: the plane's unit normal on the side that counts as up
    fn heights(&self, body: &Body, towards: DVec3) -> [f64; 2] {
        let towards = if towards.dot(self.normal) < 0.0 { -self.normal } else { self.normal };
        let noise = FLUSH * (self.origin.length() + body.center.length() + body.reach);
        let level = towards.dot(self.origin);
        span(body, towards).map(|h| if (h - level).abs() <= noise { 0.0 } else { h - level })
    }
}

/// The least and the greatest of a body along a unit direction.
fn span(body: &Body, along: DVec3) -> [f64; 2] {
    let around = |middle: f64, reach: f64| [middle - reach, middle + reach];
    let of = |points: &mut dyn Iterator<Item = DVec3>| {
        points
            .map(|p| along.dot(p))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)])
    };
    match &body.figure {
        Figure::Disk { normal, radius, .. } => around(along.dot(body.center), radius * along.cross(*normal).length()),
        Figure::Ball { radius } => around(along.dot(body.center), *radius),
        Figure::Flat(flat) => of(&mut flat.offsets.iter().map(|offset| flat.origin + *offset)),
        Figure::Mesh(surface) => of(&mut surface.points.iter().copied()),
    }
}

/// How near a body's outline comes to an eye outside it.
fn to_outline(body: &Body, eye: DVec3) -> f64 {
    let to_edge = |a: DVec3, b: DVec3| {
        let along = b - a;
        let share = ((eye - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (a + along * share).distance(eye)
    };
    let center = body.center - eye;
    match &body.figure {
        Figure::Disk { normal, radius, .. } => {
            let height = normal.dot(center);
            height.hypot((center - *normal * height).length() - radius)
        }
        Figure::Ball { radius } => (center.length_squared() - radius * radius).max(0.0).sqrt(),
        Figure::Flat(flat) => {
            let corner = |i: u32| flat.origin + flat.offsets[i as usize];
            flat.edges.iter().map(|[i, j]| to_edge(corner(*i), corner(*j))).fold(f64::INFINITY, f64::min)
        }
        Figure::Mesh(surface) => {
            let corner = |i: u32| surface.points[i as usize];
            surface.edges.iter().map(|[i, j]| to_edge(corner(*i), corner(*j))).fold(f64::INFINITY, f64::min)
        }
    }
}

/// Whether an eye is inside a solid ball.
fn holds(body: &Body, eye: DVec3) -> bool {
    matches!(body.figure, Figure::Ball { radius } if body.center.distance(eye) <= radius)
}

/// A shape's mirror image, as something that blocks from both sides.
pub(super) fn image(shape: &Shape, origin: DVec3, normal: DVec3) -> Result<Shape, ShapeError> {
    let direction = |v: DVec3| v - normal * (2.0 * normal.dot(v));
    let point = |p: DVec3| p - normal * (2.0 * normal.dot(p - origin));
    Ok(match shape {
        Shape::Disk(s) => Shape::Disk(Disk::new(point(s.center()), direction(s.normal()), s.radius())?),
        Shape::Sphere(s) => Shape::Sphere(Sphere::new(point(s.center()), s.radius())?),
        Shape::Rectangle(s) => {
            Shape::Rectangle(Rectangle::new(point(s.center()), direction(s.edge_u()), direction(s.edge_v()))?)
        }
        Shape::Polygon(s) => Shape::Polygon(Polygon::new(s.vertices().iter().rev().map(|v| point(*v)).collect())?),
        Shape::Mesh(s) => {
            Shape::Mesh(Mesh::new(s.vertices().iter().map(|v| point(*v)).collect(), s.triangles().to_vec())?)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Arrangement, Source};
    use crate::radiometry::Exitance;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    fn room(source: Shape, occluders: Vec<Shape>, points: Vec<MeasurementPoint>) -> Configuration {
        let source = Source::new(source, Exitance::new(1.0)).unwrap();
        Configuration::new(vec![source], occluders, None, points, Arrangement::Scattered).unwrap()
    }

    fn vector(reach: f64) -> impl proptest::strategy::Strategy<Value = DVec3> {
        let x = move || -reach..reach;
        (x(), x(), x()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    /// A shape around a centre; `kind` 0 to 3.
    fn shape(kind: u8, center: DVec3, axis: DVec3, a: f64, b: f64) -> Option<Shape> {
        let frame = crate::geometry::Frame::around(axis.try_normalize()?);
        let (u, v) = (frame.tangent, frame.bitangent);
        Some(match kind {
            0 => Shape::Disk(Disk::new(center, axis, a).ok()?),
            1 => Shape::Rectangle(Rectangle::new(center, u * (2.0 * a), v * (2.0 * b)).ok()?),
            2 => Shape::Sphere(Sphere::new(center, 0.7 * a).ok()?),
            _ => {
                let corners = [u * a, v * b - u * a, -u * (0.3 * a), -v * b - u * a];
                Shape::Polygon(Polygon::new(corners.iter().map(|c| center + *c).collect()).ok()?)
            }
        })
    }

    /// A mirror in the plane z = 0.
    fn glass(kind: u8, middle: DVec3, a: f64, b: f64) -> Shape {
        let kind = if kind == 2 { 0 } else { kind };
        shape(kind, DVec3::new(middle.x, middle.y, 0.0), DVec3::Z, a, b).unwrap()
    }

    fn below(shape: &Shape) -> Shape {
        image(shape, DVec3::ZERO, DVec3::Z).unwrap()
    }

    /// What the mirrored eye sees of the source with nothing in the window, less what it sees with the window shut: by the
    /// direct light's oracle, with all occluders and their images standing about.
    fn by_difference(source: &Shape, glass: &Shape, occluders: &[Shape], x: DVec3, n: DVec3) -> Option<(f64, f64)> {
        let flip = |v: DVec3| DVec3::new(v.x, v.y, -v.z);
        let eye = MeasurementPoint::new(flip(x), flip(n)).unwrap();
        let mut all: Vec<Shape> = occluders.iter().cloned().chain(occluders.iter().map(below)).collect();
        all.push(below(source));
        let oracle = |all: Vec<Shape>| {
            let emitter = Source::new(source.clone(), Exitance::new(1.0)).unwrap();
            Configuration::new(vec![emitter], all, None, vec![eye], Arrangement::Scattered)
                .ok()
                .map(|c| Oracle::new(&c))
        };
        let open = oracle(all.clone())?.at(&eye);
        all.push(glass.clone());
        let shut = oracle(all)?.at(&eye);
        let value = open.form_factor.ratio() - shut.form_factor.ratio();
        Some((value, open.bound.watts_per_square_metre() + shut.bound.watts_per_square_metre()))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn the_image_is_what_the_window_lets_through(
            kinds in (0..4u8, 0..4u8, 0..4u8, 0..4u8),
            (lamp, lamp_axis) in (vector(1.0), vector(1.0)),
            (first, first_axis) in (vector(0.8), vector(1.0)),
            (second, second_axis) in (vector(0.8), vector(1.0)),
            middle in vector(0.5),
            sizes in (0.1..0.9, 0.1..0.9, 0.1..0.5, 0.1..0.5, 0.2..1.5, 0.2..1.5),
            (x, n) in (vector(1.0), vector(1.0)),
        ) {
            let up = |v: DVec3, by: f64| v + DVec3::Z * by;
            let Some(source) = shape(kinds.0, up(lamp, 3.0), lamp_axis - DVec3::Z, sizes.0, sizes.1) else { return Ok(()) };
            let blockers = [
                shape(kinds.1, up(first, 1.5), first_axis, sizes.2, sizes.3),
                shape(kinds.2, up(second, 1.5), second_axis, sizes.3, sizes.2),
            ];
            let occluders: Vec<Shape> = blockers.into_iter().flatten().collect();
            let glass = glass(kinds.3, middle, sizes.4, sizes.5);
            let Ok(point) = MeasurementPoint::new(up(x, 1.6), n - DVec3::Z) else { return Ok(()) };
            let Some((wanted, doubt)) = by_difference(&source, &glass, &occluders, point.position(), point.normal()) else {
                return Ok(());
            };
            let source = Source::new(source, Exitance::new(1.0)).unwrap();
            let Ok(room) = Configuration::new(vec![source], occluders, None, vec![point], Arrangement::Scattered) else {
                return Ok(());
            };
            let oracle = MirrorOracle::new(&room, &PlaneMirror::new(glass, 1.0).unwrap()).unwrap();
            match oracle.at(&point) {
                Ok(found) => {
                    let (f, bound) = (found.form_factor.ratio(), found.bound.watts_per_square_metre());
                    prop_assert!((f - wanted).abs() <= bound + doubt + 2e-15, "{f:e} ± {bound:e} against {wanted:e} ± {doubt:e}");
                    prop_assert!(bound < 1e-11, "a bound of {bound:e}");
                    prop_assert!(!found.is_dark || f == 0.0);
                }
                Err(OpticsError::CutsIntoSource { .. }) => {}
                Err(other) => prop_assert!(false, "{other}"),
            }
        }
    }

    fn down(at: DVec3) -> MeasurementPoint {
        MeasurementPoint::new(at, -DVec3::Z).unwrap()
    }

    fn mirrored(room: &Configuration, glass: Shape, at: &MeasurementPoint) -> Result<f64, OpticsError> {
        let mirror = PlaneMirror::new(glass, 1.0)?;
        MirrorOracle::new(room, &mirror)?.at(at).map(|truth| truth.form_factor.ratio())
    }

    /// A mirror that ends nowhere near shows the whole image, as a window that wide would.
    #[test]
    fn a_wide_mirror_shows_the_whole_source() {
        let point = down(DVec3::new(0.7, 0.2, 1.0));
        for kind in [0, 1, 2, 3] {
            let lamp = shape(kind, DVec3::new(-0.3, 0.1, 1.4), DVec3::new(0.3, 0.1, -1.0), 0.2, 0.3).unwrap();
            let found =
                mirrored(&room(lamp.clone(), vec![], vec![point]), glass(1, DVec3::ZERO, 9.0, 9.0), &point).unwrap();
            let image = match below(&lamp) {
                // Rectangles keep their lit side by the order of their edges.
                Shape::Rectangle(s) => Shape::Rectangle(Rectangle::new(s.center(), s.edge_v(), s.edge_u()).unwrap()),
                other => other,
            };
            let direct = Oracle::new(&room(image, vec![], vec![point])).at(&point).form_factor.ratio();
            assert_relative_eq!(found, direct, max_relative = 1e-13);
            assert!(found > 1e-3);
        }
    }

    /// A source that reaches through the mirror's plane shows the part above it: a rectangle, as if it had been cut.
    #[test]
    fn a_source_is_cut_at_the_plane() {
        let point = down(DVec3::new(0.9, 0.1, 1.0));
        let wall = |low: f64, high: f64| {
            let (y, z) = (DVec3::Y * 0.6, DVec3::Z * (high - low));
            Shape::Rectangle(Rectangle::new(DVec3::Z * (0.5 * (low + high)), y, z).unwrap())
        };
        let seen = |lamp: Shape| {
            mirrored(&room(lamp, vec![], vec![point]), glass(1, DVec3::X * 0.4, 0.5, 0.5), &point).unwrap()
        };
        let (whole, above) = (seen(wall(-0.4, 0.5)), seen(wall(0.0, 0.5)));
        assert_relative_eq!(whole, above, max_relative = 1e-12);
        assert!(above > 1e-3);
        assert_eq!(seen(wall(-0.4, -0.1)), 0.0);
    }

    /// The same for what is in the way: a fence through the plane hides what its part above it hides.
    #[test]
    fn an_occluder_is_cut_at_the_plane() {
        let point = down(DVec3::new(0.8, 0.0, 1.0));
        let lamp = || Shape::Disk(Disk::new(DVec3::new(-0.6, 0.0, 1.0), -DVec3::Z, 0.3).unwrap());
        let fence = |low: f64| {
            let (y, z) = (DVec3::Y * 0.2, DVec3::Z * (0.4 - low));
            Shape::Rectangle(Rectangle::new(DVec3::new(-0.2, 0.05, 0.5 * (low + 0.4)), y, z).unwrap())
        };
        let seen = |occluders: Vec<Shape>| {
            mirrored(&room(lamp(), occluders, vec![point]), glass(1, DVec3::ZERO, 2.0, 2.0), &point).unwrap()
        };
        let (through, above, nothing) = (seen(vec![fence(-0.5)]), seen(vec![fence(0.0)]), seen(vec![]));
        assert_relative_eq!(through, above, max_relative = 1e-12);
        assert!(above < 0.95 * nothing, "{above} {nothing}");
        // The mirror itself, standing among the occluders for the direct light's sake, hides nothing.
        assert_relative_eq!(seen(vec![glass(1, DVec3::ZERO, 2.0, 2.0)]), nothing, max_relative = 1e-15);
    }

    /// What the mirror sends to a receiver, told from the other end: by reciprocity the same as what a lamp on the receiver
    /// would send to the source.
    #[test]
    fn power_by_way_of_a_mirror_is_told_from_either_end() {
        let a = Rectangle::new(DVec3::new(-0.5, 0.1, 1.0), DVec3::Y * 0.4, DVec3::X * 0.3).unwrap();
        let b = Rectangle::new(DVec3::new(0.6, -0.1, 1.3), DVec3::Y * 0.5, DVec3::X * 0.6).unwrap();
        let power = |from: Rectangle, to: Rectangle| {
            let at = MeasurementPoint::new(to.center() + DVec3::Z * 9.0, DVec3::Z).unwrap();
            let room = room(Shape::Rectangle(from), vec![], vec![at]);
            let mirror = PlaneMirror::new(glass(1, DVec3::X * 0.05, 0.3, 0.2), 0.8).unwrap();
            let oracle = MirrorOracle::new(&room, &mirror).unwrap();
            let mean = oracle.average_irradiance(&Patch::Rectangle(to), Tolerance::relative(1e-8));
            (mean.irradiance.watts_per_square_metre() * to.area(), mean.bound.watts_per_square_metre() * to.area())
        };
        let ((there, doubt), (back, _)) = (power(a, b), power(b, a));
        assert_relative_eq!(there, back, max_relative = 1e-7);
        assert!(there > 1e-4 && doubt < 1e-6 * there);
    }

    #[test]
    fn what_has_no_answer_says_so() {
        let lamp = || Shape::Disk(Disk::new(DVec3::Z, -DVec3::Z, 0.3).unwrap());
        let point = down(DVec3::new(0.8, 0.0, 1.0));
        let wide = || glass(1, DVec3::ZERO, 2.0, 2.0);
        let ball = Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0).unwrap());
        assert!(matches!(PlaneMirror::new(ball, 1.0), Err(OpticsError::MirrorShape { .. })));
        assert!(matches!(PlaneMirror::new(wide(), 1.2), Err(OpticsError::Share { .. })));
        let flush = MeasurementPoint::new(DVec3::X * 3.0, DVec3::Z).unwrap();
        assert_eq!(mirrored(&room(lamp(), vec![], vec![flush]), wide(), &flush), Err(OpticsError::InMirrorPlane));
        // A pole through the mirror and through the lamp's plane.
        let pole = Rectangle::new(DVec3::new(0.1, 0.0, 0.5), DVec3::Y * 0.1, DVec3::Z * 4.0).unwrap();
        let crowded = room(lamp(), vec![Shape::Rectangle(pole)], vec![point]);
        assert_eq!(mirrored(&crowded, wide(), &point), Err(OpticsError::TwiceCut { said: 0 }));
        let globe = Shape::Sphere(Sphere::new(DVec3::Z, 0.3).unwrap());
        let nail = Shape::Disk(Disk::new(DVec3::new(0.0, 0.0, 0.8), DVec3::X, 0.2).unwrap());
        let nailed = room(globe, vec![nail], vec![point]);
        assert_eq!(mirrored(&nailed, wide(), &point), Err(OpticsError::CutsIntoSource { said: 0, occluder: 0 }));
        // On the other side of the mirror there is no lamp; a lamp that looks away from it shows nothing.
        let under = MeasurementPoint::new(-DVec3::Z, DVec3::Z).unwrap();
        assert_abs_diff_eq!(mirrored(&room(lamp(), vec![], vec![under]), wide(), &under).unwrap(), 0.0);
        let away = Shape::Disk(Disk::new(DVec3::Z, DVec3::Z, 0.3).unwrap());
        assert_abs_diff_eq!(mirrored(&room(away, vec![], vec![point]), wide(), &point).unwrap(), 0.0);
    }
}
