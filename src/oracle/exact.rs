//! The exact side of one configuration, ready to be asked anywhere.

use glam::DVec3;

use super::body::{Body, Figure};
use super::penumbra::{self, Visible};
use super::piece::{HalfSpace, Piece};
use super::point_factor::{self, Factor};
use super::quadrature::{self, Strips};
use super::truth::{Method, Region, Truth};
use crate::configuration::{Configuration, MeasurementPoint, Source};
use crate::radiometry::{FormFactor, Irradiance};

/// Exact irradiance at any point of a configuration.
///
/// Closed form throughout, but for an occluder that may reach into a sphere source: there, quadrature.
///
/// Prepared once (meshes become outlines); then every question is independent of every other.
#[derive(Clone, Debug)]
pub struct Oracle {
    /// A power of two that brings the configuration's lengths near one: form factors do not feel it, and nothing
    /// overflows.
    pub(super) scale: f64,
    pub(super) sources: Vec<Emitter>,
    pub(super) occluders: Vec<Body>,
}

#[derive(Clone, Debug)]
pub(super) struct Emitter {
    pub(super) body: Body,
    /// W/m².
    pub(super) exitance: f64,
}

/// How a point sees one source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sight {
    Whole,
    Part,
    Hidden,
    Below,
    Unclear,
}

/// One source at one point.
struct Contribution {
    visible: Factor,
    unoccluded: f64,
    sight: Sight,
    shadow_edge: bool,
    method: Method,
}

impl Contribution {
    fn new(visible: Factor, unoccluded: f64, sight: Sight) -> Contribution {
        Contribution { visible, unoccluded, sight, shadow_edge: false, method: Method::ClosedForm }
    }
    fn below() -> Contribution {
        Contribution::new(Factor::default(), 0.0, Sight::Below)
    }
    fn hidden(unoccluded: f64) -> Contribution {
        Contribution::new(Factor::default(), unoccluded, Sight::Hidden)
    }
}

impl Oracle {
    pub fn new(configuration: &Configuration) -> Oracle {
        let shapes = || configuration.sources().iter().map(Source::shape).chain(configuration.occluders());
        let largest = shapes()
            .map(|shape| {
                let (low, high) = shape.bounds();
                low.abs().max(high.abs()).max_element()
            })
            .fold(f64::MIN_POSITIVE, f64::max);
        let scale = (-largest.log2().ceil()).clamp(-1000.0, 1000.0).exp2();
        let emitter = |source: &Source| {
            let bodies = Body::of_shape(source.shape(), scale);
            let exitance = source.exitance().watts_per_square_metre();
            bodies.into_iter().map(move |body| Emitter { body, exitance })
        };
        Oracle {
            scale,
            sources: configuration.sources().iter().flat_map(emitter).collect(),
            occluders: configuration.occluders().iter().flat_map(|shape| Body::of_shape(shape, scale)).collect(),
        }
    }

    /// The exact irradiance at a point, with its bound.
    ///
    /// - error: at most `bound`; a few ulp of the unoccluded form factor in general, more near a rim or an edge
    pub fn at(&self, point: &MeasurementPoint) -> Truth {
        let (eye, n) = (point.position() * self.scale, point.normal());
        let (mut irradiance, mut unoccluded, mut form_factor, mut bound) = (0.0, 0.0, 0.0, 0.0);
        let (mut shadow_edge, mut method) = (false, Method::ClosedForm);
        let (mut whole, mut below, mut hidden, mut unclear) = (0, 0, 0, 0);
        for i in 0..self.sources.len() {
            let exitance = self.sources[i].exitance;
            let seen = self.of_source(i, eye, n);
            irradiance += exitance * seen.visible.value;
            unoccluded += exitance * seen.unoccluded;
            form_factor += seen.visible.value;
            bound += exitance * seen.visible.bound;
            shadow_edge |= seen.shadow_edge;
            if seen.method == Method::Quadrature {
                method = Method::Quadrature;
            }
            match seen.sight {
                Sight::Whole => whole += 1,
                Sight::Below => below += 1,
                Sight::Hidden => hidden += 1,
                Sight::Unclear => unclear += 1,
                Sight::Part => {}
            }
        }
        let count = self.sources.len();
        let region = if whole == count {
            Region::Lit
        } else if below == count {
            Region::BelowHorizon
        } else if hidden + below == count {
            Region::Umbra
        } else if unclear > 0 && (whole + unclear == count || hidden + below + unclear == count) {
            Region::Edge
        } else {
            Region::Penumbra
        };
        Truth {
            irradiance: Irradiance::new(irradiance),
            unoccluded_irradiance: Irradiance::new(unoccluded),
            form_factor: FormFactor::new(form_factor),
            bound: Irradiance::new(bound),
            region,
            method,
            shadow_edge,
        }
    }

    fn of_source(&self, index: usize, eye: DVec3, n: DVec3) -> Contribution {
        let body = &self.sources[index].body;
        let Some(limit) = Limit::of(body, eye) else { return Contribution::below() };
        let Some(piece) = Piece::of_source(body, eye, n) else { return Contribution::below() };
        let unoccluded = unoccluded(body, &piece, eye, n);
        let others = self.sources.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, s)| &s.body);
        let mut blockers = Vec::new();
        for other in self.occluders.iter().chain(others.clone()) {
            match limit.before(other, eye) {
                Blocking::None => {}
                Blocking::All => return Contribution::hidden(unoccluded.value),
                Blocking::Part(piece) => blockers.push(piece),
                Blocking::Within => {
                    let others: Vec<&Body> = self.occluders.iter().chain(others).collect();
                    return by_strips(quadrature::visible(n, body, &others, eye), unoccluded, &piece);
                }
            }
        }
        let sight = if piece.is_cut { Sight::Part } else { Sight::Whole };
        let whole = |visible| Contribution::new(visible, unoccluded.value, sight);
        if blockers.is_empty() {
            return whole(unoccluded);
        }
        let seen = penumbra::visible(n, &piece, &blockers);
        judged(&seen, unoccluded, &piece, whole)
    }
}

/// What the classification of the contour makes of a source.
fn judged(seen: &Visible, unoccluded: Factor, piece: &Piece, whole: impl Fn(Factor) -> Contribution) -> Contribution {
    let doubt = seen.doubt / (2.0 * std::f64::consts::PI);
    let nothing_seen = !seen.source_seen && !seen.shadow_edge;
    let nothing_hidden = !seen.source_hidden && !seen.shadow_edge;
    if nothing_seen && doubt == 0.0 {
        return Contribution::hidden(unoccluded.value);
    }
    if nothing_hidden && doubt == 0.0 {
        return whole(unoccluded);
    }
    let shade = point_factor::from_terms(seen.occluders);
    let own = if seen.source_hidden { point_factor::from_terms(seen.source) } else { unoccluded };
    let value = (own.value - shade.value).clamp(0.0, unoccluded.value);
    let told = seen.surely_seen && (seen.surely_hidden || piece.is_cut);
    Contribution {
        visible: Factor { value, bound: own.bound + shade.bound + doubt },
        shadow_edge: seen.shadow_edge,
        ..Contribution::new(Factor::default(), unoccluded.value, if told { Sight::Part } else { Sight::Unclear })
    }
}

/// What the strips make of a source.
fn by_strips(strips: Strips, unoccluded: Factor, piece: &Piece) -> Contribution {
    let sight = match (strips.seen, strips.hidden) {
        (false, _) => return Contribution::hidden(unoccluded.value),
        (true, false) if !piece.is_cut => Sight::Whole,
        _ => Sight::Part,
    };
    let visible = Factor { value: strips.value.clamp(0.0, unoccluded.value), bound: strips.error };
    Contribution {
        shadow_edge: strips.hidden,
        method: Method::Quadrature,
        ..Contribution::new(visible, unoccluded.value, sight)
    }
}

fn unoccluded(body: &Body, piece: &Piece, eye: DVec3, n: DVec3) -> Factor {
    let center = body.center - eye;
    match &body.figure {
        Figure::Ball { radius } => point_factor::sphere(n, center, *radius),
        Figure::Disk { .. } => match point_factor::whole_rim(piece) {
            Some(rim) => point_factor::disk(n, rim),
            None => positive(point_factor::contour(n, piece)),
        },
        Figure::Flat(shape) if !piece.is_cut && body.reach < point_factor::SMALL * center.length() => {
            point_factor::small_flat(n, shape, center, body.center - shape.origin)
        }
        Figure::Flat(_) => positive(point_factor::contour(n, piece)),
    }
}

fn positive(factor: Factor) -> Factor {
    Factor { value: factor.value.max(0.0), ..factor }
}

/// What an occluder must lie before to block a source.
struct Limit<'a> {
    source: &'a Body,
    /// Relative to the eye.
    center: DVec3,
    /// A flat source's own plane; the plane of a sphere's silhouette.
    keep: HalfSpace,
}

#[expect(clippy::large_enum_variant, reason = "lives for one match, where a box would cost an allocation")]
enum Blocking {
    None,
    Part(Piece),
    All,
    /// It cuts into a sphere source: no outline of directions tells what is before what.
    Within,
}

impl Limit<'_> {
    /// `None` where the source turns its dark side, or the eye is inside it.
    fn of(source: &Body, eye: DVec3) -> Option<Limit<'_>> {
        let center = source.center - eye;
        let (normal, on_plane) = match &source.figure {
            Figure::Disk { normal, .. } => (*normal, center),
            Figure::Flat(shape) => (shape.normal, shape.origin - eye + shape.offsets[0]),
            Figure::Ball { radius } => {
                let distance = center.length();
                let k = (distance - radius) * (distance + radius) / distance;
                return (distance > *radius).then(|| Limit {
                    source,
                    center,
                    keep: HalfSpace { normal: -center / distance, k },
                });
            }
        };
        let k = -normal.dot(on_plane);
        (k > 4.0 * f64::EPSILON * (on_plane.length() + source.reach)).then_some(Limit {
            source,
            center,
            keep: HalfSpace { normal, k },
        })
    }

    /// What an occluder can hide of the source.
    fn before(&self, occluder: &Body, eye: DVec3) -> Blocking {
        let center = occluder.center - eye;
        if let Figure::Ball { radius } = occluder.figure
            && center.length() <= radius
        {
            return Blocking::All;
        }
        if self.keep.normal.dot(center) + self.keep.k <= -occluder.reach || self.is_beside(center, occluder.reach) {
            return Blocking::None;
        }
        let piece = match (&self.source.figure, &occluder.figure) {
            (Figure::Ball { .. }, Figure::Ball { radius }) => {
                let between = self.center.distance(center);
                let own = self.source.reach;
                if between + radius <= own {
                    return Blocking::None;
                } else if between + own <= *radius {
                    return Blocking::All;
                } else if between < own + radius {
                    return Blocking::Within;
                } else if self.sphere_comes_first(center, *radius) {
                    return Blocking::None;
                }
                Piece::of_occluder(occluder, eye, None)
            }
            (Figure::Ball { radius }, Figure::Disk { normal, .. })
                if self.is_cut_by(occluder, center, *normal, center, *radius) =>
            {
                return Blocking::Within;
            }
            (Figure::Ball { radius }, Figure::Flat(shape))
                if self.is_cut_by(occluder, center, shape.normal, shape.origin - eye + shape.offsets[0], *radius) =>
            {
                return Blocking::Within;
            }
            _ => Piece::of_occluder(occluder, eye, Some(self.keep)),
        };
        piece.map_or(Blocking::None, Blocking::Part)
    }

    /// Whether a flat occluder may reach into a sphere source.
    fn is_cut_by(&self, occluder: &Body, center: DVec3, normal: DVec3, on_plane: DVec3, radius: f64) -> bool {
        normal.dot(self.center - on_plane).abs() < radius && center.distance(self.center) < occluder.reach + radius
    }

    /// Whether the cones around a body and around the source surely share no direction.
    fn is_beside(&self, center: DVec3, reach: f64) -> bool {
        let (own, other) = (self.center.length(), center.length());
        let (s, t) = (self.source.reach / own, reach / other);
        if s >= 1.0 || t >= 1.0 {
            return false;
        }
        let apart = self.center.dot(center) / (own * other);
        let touching = ((1.0 - s * s) * (1.0 - t * t)).sqrt() - s * t;
        // Beyond a half turn the cones always meet.
        s * s + t * t < 1.0 && apart < touching - 1e-12
    }

    /// Two balls apart have a plane between them; whichever lies on the eye's side of it is met first.
    fn sphere_comes_first(&self, center: DVec3, radius: f64) -> bool {
        let between = self.center - center;
        let gap = between.length() - self.source.reach - radius;
        let direction = between.normalize();
        direction.dot(center + direction * (radius + 0.5 * gap)) < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::Arrangement;
    use crate::geometry::{Disk, Polygon, Rectangle, Shape, Sphere};
    use crate::radiometry::Exitance;
    use proptest::prelude::*;

    fn vector(reach: f64) -> impl proptest::strategy::Strategy<Value = DVec3> {
        let x = move || -reach..reach;
        (x(), x(), x()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    fn shape(
        center: impl proptest::strategy::Strategy<Value = DVec3>,
    ) -> impl proptest::strategy::Strategy<Value = Shape> {
        (center, vector(1.0), 0.1..0.9, 0.1..0.9, 0..4).prop_filter_map("a shape", |(center, axis, a, b, kind)| {
            let frame = crate::geometry::Frame::around(axis.try_normalize()?);
            let (u, v) = (frame.tangent, frame.bitangent);
            Some(match kind {
                0 => Shape::Disk(Disk::new(center, axis, a).ok()?),
                1 => Shape::Rectangle(Rectangle::new(center, u * (2.0 * a), v * (2.0 * b)).ok()?),
                2 => Shape::Sphere(Sphere::new(center, 0.7 * a).ok()?),
                _ => {
                    // A concave arrowhead.
                    let corners = [u * a, v * b - u * a, -u * (0.3 * a), -v * b - u * a];
                    Shape::Polygon(Polygon::new(corners.iter().map(|c| center + *c).collect()).ok()?)
                }
            })
        })
    }

    /// Shapes on a coarse lattice: contacts, shared edges, coincident rims and edges through corners by the dozen.
    fn lattice_shape(level: f64) -> impl proptest::strategy::Strategy<Value = Shape> {
        let x = || (-4..=4).prop_map(|i| 0.25 * f64::from(i));
        (x(), x(), x(), 0..6usize, 1..5, 1..5, 0..4).prop_map(move |(x, y, z, axis, a, b, kind)| {
            let center = DVec3::new(x, y, level + 0.5 * z);
            let (a, b) = (0.25 * f64::from(a), 0.25 * f64::from(b));
            let (w, u) = [
                (DVec3::Z, DVec3::X),
                (-DVec3::Z, DVec3::X),
                (-DVec3::Z, DVec3::Y),
                (DVec3::X, DVec3::Y),
                (DVec3::new(0.0, 3.0, -4.0), DVec3::X),
                (DVec3::new(-3.0, 0.0, -4.0), DVec3::Y),
            ][axis];
            let v = w.normalize().cross(u);
            match kind {
                0 => Shape::Disk(Disk::new(center, w, a).unwrap()),
                1 => Shape::Rectangle(Rectangle::new(center, u * a, v * b).unwrap()),
                2 => Shape::Sphere(Sphere::new(center, 0.5 * a).unwrap()),
                _ => {
                    let corners = [u * a, v * b - u * a, -u * (0.25 * a), -v * b - u * a];
                    Shape::Polygon(Polygon::new(corners.iter().map(|c| center + *c).collect()).unwrap())
                }
            }
        })
    }

    /// Contour sums and strips share no formula but the shapes.
    fn compare(source: Shape, occluders: Vec<Shape>, normal: DVec3) -> Result<(), TestCaseError> {
        let source = Source::new(source, Exitance::new(1.0)).unwrap();
        let Ok(point) = MeasurementPoint::new(DVec3::ZERO, normal) else { return Ok(()) };
        let built = Configuration::new(vec![source], occluders, None, vec![point], Arrangement::Scattered);
        let Ok(configuration) = built else { return Ok(()) };
        let oracle = Oracle::new(&configuration);
        let truth = oracle.at(&point);
        let others: Vec<&Body> = oracle.occluders.iter().collect();
        let strips = quadrature::visible(point.normal(), &oracle.sources[0].body, &others, DVec3::ZERO);
        let (f, bound) = (truth.form_factor.ratio(), truth.bound.watts_per_square_metre());
        let (value, error) = (strips.value, strips.error);
        prop_assert!(error < 1e-11, "strips {value:e} within no less than {error:e}");
        prop_assert!(
            (f - value).abs() <= bound + error,
            "{f:e} against strips {value:e} within {error:e}: {truth:?}"
        );
        prop_assert!(bound < 1e-9, "a bound of {bound:e} is of no use");
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn contours_agree_with_strips(
            source in shape(vector(0.6).prop_map(|c| c + DVec3::Z * 3.0)),
            occluders in proptest::collection::vec(shape(vector(0.8).prop_map(|c| c + DVec3::Z * 1.5)), 0..4),
            normal in vector(1.0).prop_map(|n| n + DVec3::Z * 0.7),
        ) {
            compare(source, occluders, normal)?;
        }

        #[test]
        fn contours_agree_with_strips_where_things_touch(
            source in lattice_shape(3.0),
            occluders in proptest::collection::vec(lattice_shape(1.5), 0..5),
            tilt in (-2..=2, -2..=2),
        ) {
            compare(source, occluders, DVec3::new(f64::from(tilt.0), f64::from(tilt.1), 2.0))?;
        }
    }
}
