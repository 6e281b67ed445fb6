//! The exact side of one configuration, ready to be asked anywhere.

use std::sync::Arc;

use glam::DVec3;

use super::body::{Body, Figure};
use super::form::Form;
use super::front::{Blocking, Front};
use super::penumbra::{self, Outline, Visible};
use super::piece::Piece;
use super::point_factor::{self, Factor};
use super::quadrature::{self, Strips};
use super::textured::{self, Light};
use super::truth::{Method, Region, Sight, Truth};
use super::variance::Chart;
use crate::configuration::{Configuration, MeasurementPoint, Source};
use crate::number::{Number, Vector, Wide};
use crate::radiometry::{FormFactor, Irradiance};
use crate::texture::Texture;

/// Exact irradiance at any point of a configuration.
///
/// Closed form throughout, but for an occluder that may reach into a sphere source: there, quadrature. Where the closed
/// form's sum cancels (deep in a penumbra; a sliver above the horizon) it is run once more over numbers of twice the
/// width, so that what is left keeps its digits.
///
/// Prepared once (meshes become outlines); then every question is independent of every other.
///
/// ```
/// use etendue::configuration::MeasurementPoint;
/// use etendue::geometry::DVec3;
/// use etendue::oracle::Region;
/// use etendue::{Case, Oracle};
///
/// let case = Case::shipped("penumbra/eclipse")?;
/// let oracle = Oracle::new(&case.configuration);
/// // A point of the penumbra, tilted towards the light: any place and any direction, metres.
/// let truth = oracle.at(&MeasurementPoint::new(DVec3::new(0.7, 0.0, 0.0), DVec3::new(-0.2, 0.0, 1.0))?);
/// assert_eq!(truth.region, Region::Penumbra);
/// assert!(truth.irradiance < truth.unoccluded_irradiance);
/// assert!(truth.bound.watts_per_square_metre() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Oracle {
    /// A power of two that brings the configuration's lengths near one: form factors do not feel it, and nothing
    /// overflows.
    pub(super) scale: f64,
    pub(super) sources: Vec<Emitter>,
    pub(super) occluders: Vec<Body>,
    /// Which occluder of the configuration each body is made from.
    pub(super) occluder_of: Vec<usize>,
}

#[derive(Clone, Debug)]
pub(super) struct Emitter {
    pub(super) body: Body,
    /// Of the unit square that its samples are drawn from, metres.
    pub(super) chart: Chart,
    /// m².
    pub(super) area: f64,
    /// W/m²; of a textured source, its mean.
    pub(super) exitance: f64,
    pub(super) texture: Option<Arc<Texture>>,
    /// What a flat source of constant texels is made of: one body for each run of equal ones that shine, and its exitance,
    /// W/m².
    pub(super) parts: Vec<(Body, f64)>,
}

/// Which body of a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BodyAt {
    Source(usize),
    Occluder(usize),
    /// Of a textured source: source and part.
    Part(usize, usize),
}

impl BodyAt {
    /// The source that it is, or is part of.
    fn source(self) -> Option<usize> {
        match self {
            BodyAt::Source(i) | BodyAt::Part(i, _) => Some(i),
            BodyAt::Occluder(_) => None,
        }
    }
}

/// One source at one point.
#[derive(Debug)]
pub(super) struct Seen {
    pub visible: Factor,
    pub unoccluded: f64,
    pub sight: Sight,
    pub method: Method,
    /// Whether it took numbers of twice the width.
    pub is_wide: bool,
    /// What cuts it.
    pub shadow: Option<Shadow>,
    pub shadow_edge: bool,
    /// Whether all of its own outline is seen, and an occluder's before it.
    pub is_ring: bool,
    /// Whether a small move of anything would change the shadow's topology.
    pub touching: bool,
    /// What a textured source brings; of others, exitance × form factor.
    pub light: Option<Light>,
}

/// An outline of what is seen of a source, and what it is made from.
#[derive(Debug)]
pub(super) struct Shadow {
    outline: Outline,
    /// The outline's pieces after the source's, and whether each is cut off by the source's front.
    blockers: Vec<(BodyAt, bool)>,
    /// Whether parts of the source's own boundary are hidden; else the source is whole less what the occluders take.
    source_hidden: bool,
}

impl Seen {
    fn new(visible: Factor, unoccluded: f64, sight: Sight) -> Seen {
        Seen {
            visible,
            unoccluded,
            sight,
            method: Method::ClosedForm,
            is_wide: false,
            shadow: None,
            shadow_edge: false,
            is_ring: false,
            touching: false,
            light: None,
        }
    }
    fn below() -> Seen {
        Seen::new(Factor::nothing(), 0.0, Sight::Below)
    }
    fn hidden(unoccluded: f64) -> Seen {
        Seen::new(Factor::nothing(), unoccluded, Sight::Hidden)
    }
}

/// Above this, relative to the value, a bound calls for numbers of twice the width.
const LOOSE: f64 = 1e-12;
/// Further from the plain value than this, in units of its bound, a wide one belongs to another topology.
pub(super) const PARTED: f64 = 100.0;
/// A plane is grazed where its height over the eye is less than this, in units of its body's distance and size.
const GRAZING: f64 = 1e-3;
/// Relative error of what these return, beside its rounding to `f64`; of the sum of the terms' sizes.
const WIDE_EPSILON: f64 = 1e-28;

/// Equal numbers where the visible parts' outlines are made of the same stretches of the same curves: between places
/// with different ones the irradiance need not be smooth.
///
/// - `sources`: every source as a point sees it
pub(super) fn topology(sources: &[Seen]) -> u64 {
    use std::hash::{DefaultHasher, Hash, Hasher};
    let mut hasher = DefaultHasher::new();
    for seen in sources {
        seen.sight.hash(&mut hasher);
        if let Some(shadow) = &seen.shadow {
            shadow.source_hidden.hash(&mut hasher);
            shadow.outline.topology(&mut hasher);
        }
    }
    hasher.finish()
}

/// What a point sees of all sources together.
pub(super) fn region(sources: &[Seen]) -> Region {
    Region::of(sources.iter().map(|seen| seen.sight))
}

/// Whether all outlines of the sources are seen, and something before one of them: a closed ring of it is left.
pub(super) fn is_annular(sources: &[Seen]) -> bool {
    sources.iter().all(|seen| seen.sight == Sight::Whole || seen.is_ring) && sources.iter().any(|seen| seen.is_ring)
}

impl Oracle {
    /// Prepares all shapes once, for any number of points.
    pub fn new(configuration: &Configuration) -> Oracle {
        let shapes = || configuration.sources().iter().map(Source::shape).chain(configuration.blockers());
        let largest = shapes()
            .map(|shape| {
                let (low, high) = shape.bounds();
                low.abs().max(high.abs()).max_element()
            })
            .fold(f64::MIN_POSITIVE, f64::max);
        let scale = (-largest.log2().ceil()).clamp(-1000.0, 1000.0).exp2();
        let emitter = |source: &Source| {
            let shape = source.shape();
            let exitance = source.exitance().watts_per_square_metre();
            // A source is no mesh: one body, and a chart.
            let body = Body::of_shape(shape, scale).pop()?;
            let texture = source.texture().cloned();
            let parts = texture.as_ref().map(|texture| textured::parts(texture, scale)).unwrap_or_default();
            Some(Emitter { body, chart: Chart::of(shape)?, area: shape.area(), exitance, texture, parts })
        };
        let of_occluder = |(i, shape)| Body::of_shape(shape, scale).into_iter().map(move |body| (body, i));
        let (occluders, occluder_of) = configuration.blockers().iter().enumerate().flat_map(of_occluder).unzip();
        Oracle {
            scale,
            sources: configuration.sources().iter().filter_map(emitter).collect(),
            occluders,
            occluder_of,
        }
    }

    /// The exact irradiance at a point, with its bound.
    ///
    /// - error: at most `bound`; a few ulp of the unoccluded form factor in general, more near a rim or an edge
    pub fn at(&self, point: &MeasurementPoint) -> Truth {
        self.together(&self.seen(point))
    }

    /// Every source as a point sees it.
    pub(super) fn seen(&self, point: &MeasurementPoint) -> Vec<Seen> {
        let with_light =
            |(i, seen)| Seen { light: self.light_of_texture(i, point, &seen, textured::PRECISE), ..seen };
        self.shapes_seen(point).into_iter().enumerate().map(with_light).collect()
    }

    /// Every source as a point sees it, but for what a textured one brings: for who asks only what hides it.
    pub(super) fn shapes_seen(&self, point: &MeasurementPoint) -> Vec<Seen> {
        (0..self.sources.len()).map(|i| self.of_body(BodyAt::Source(i), point)).collect()
    }

    pub(super) fn together(&self, sources: &[Seen]) -> Truth {
        let (mut irradiance, mut unoccluded, mut form_factor, mut bound) = (0.0, 0.0, 0.0, 0.0);
        let (mut shadow_edge, mut method) = (false, Method::ClosedForm);
        for (seen, source) in sources.iter().zip(&self.sources) {
            let light = seen.light.unwrap_or_else(|| Light::uniform(source.exitance, seen));
            irradiance += light.value;
            unoccluded += light.unoccluded;
            form_factor += seen.visible.value;
            bound += light.bound;
            // Where the exitance jumps the integrand does, too.
            shadow_edge |= seen.shadow_edge || light.jumps;
            if light.method == Method::Quadrature {
                method = Method::Quadrature;
            }
        }
        Truth {
            irradiance: Irradiance::new(irradiance),
            unoccluded_irradiance: Irradiance::new(unoccluded),
            form_factor: FormFactor::new(form_factor),
            bound: Irradiance::new(bound),
            region: region(sources),
            method,
            shadow_edge,
        }
    }

    pub(super) fn body(&self, at: BodyAt) -> &Body {
        match at {
            BodyAt::Source(i) => &self.sources[i].body,
            BodyAt::Occluder(i) => &self.occluders[i],
            BodyAt::Part(i, part) => &self.sources[i].parts[part].0,
        }
    }

    /// One source, or a part of one, as a point sees it.
    pub(super) fn of_body(&self, own: BodyAt, point: &MeasurementPoint) -> Seen {
        let (eye, n) = (point.position() * self.scale, point.normal());
        let body = self.body(own);
        let form = Form::plain(body, eye);
        let Some(front) = Front::of(body, &form) else { return Seen::below() };
        let Some(piece) = Piece::of_source(&form, Vector::constant(n)) else { return Seen::below() };
        let unoccluded = point_factor::unoccluded(&form, &piece, Vector::constant(n));
        let (unoccluded, is_wide) = self.sharpened(unoccluded, own, None, point, is_grazing(body, eye));
        let others = (0..self.occluders.len()).map(BodyAt::Occluder);
        let others = others.chain((0..self.sources.len()).filter(|i| Some(*i) != own.source()).map(BodyAt::Source));
        let (mut pieces, mut blockers) = (Vec::new(), Vec::new());
        for at in others.clone() {
            match front.before(self.body(at), eye) {
                Blocking::None => {}
                Blocking::All => return Seen::hidden(unoccluded.value),
                Blocking::Part { piece, is_clipped } => {
                    pieces.push(piece);
                    blockers.push((at, is_clipped));
                }
                Blocking::Within => {
                    let others: Vec<&Body> = others.map(|at| self.body(at)).collect();
                    return by_strips(quadrature::visible(n, body, &others, eye), unoccluded, &piece);
                }
            }
        }
        let sight = if piece.is_cut { Sight::Part } else { Sight::Whole };
        let whole = || Seen { is_wide, ..Seen::new(unoccluded, unoccluded.value, sight) };
        if blockers.is_empty() {
            return whole();
        }
        let seen = penumbra::visible(n, &piece, &pieces);
        let doubt = seen.doubt / (2.0 * std::f64::consts::PI);
        if seen.nothing_seen() && doubt == 0.0 {
            return Seen { touching: seen.touching, ..Seen::hidden(unoccluded.value) };
        }
        if seen.nothing_hidden() && doubt == 0.0 {
            return Seen { touching: seen.touching, ..whole() };
        }
        // Where the contours of all of them leave it open, one alone may settle it: more in the way makes nothing lighter.
        let hides = |one: &Piece| {
            let seen = penumbra::visible(n, &piece, std::slice::from_ref(one));
            seen.nothing_seen() && seen.doubt == 0.0
        };
        if !seen.surely_seen && pieces.len() > 1 && pieces.iter().any(hides) {
            return Seen { touching: seen.touching, ..Seen::hidden(unoccluded.value) };
        }
        self.judged(seen, unoccluded, &piece, blockers, own, point)
    }

    /// What the classification of the contour makes of a source.
    fn judged(
        &self,
        seen: Visible,
        unoccluded: Factor,
        piece: &Piece,
        blockers: Vec<(BodyAt, bool)>,
        at: BodyAt,
        point: &MeasurementPoint,
    ) -> Seen {
        let doubt = seen.doubt / (2.0 * std::f64::consts::PI);
        let shade = point_factor::from_terms(seen.occluders);
        let own = if seen.source_hidden { point_factor::from_terms(seen.source) } else { unoccluded };
        let bodies = blockers.iter().map(|(at, _)| *at).chain([at]);
        let is_grazing = bodies.map(|at| self.body(at)).any(|body| is_grazing(body, point.position() * self.scale));
        let told = seen.surely_seen && (seen.surely_hidden || piece.is_cut);
        let shadow = Shadow { outline: seen.outline, blockers, source_hidden: seen.source_hidden };
        let visible = Factor { value: own.value - shade.value, bound: own.bound + shade.bound };
        let (mut visible, is_wide) = self.sharpened(visible, at, Some(&shadow), point, is_grazing);
        visible.value = visible.value.clamp(0.0, unoccluded.value);
        visible.bound += doubt;
        Seen {
            is_wide,
            shadow_edge: seen.shadow_edge,
            is_ring: told
                && seen.shadow_edge
                && !seen.source_hidden
                && !piece.is_cut
                && !seen.touching
                && doubt == 0.0,
            touching: seen.touching || doubt > 0.0,
            shadow: Some(shadow),
            ..Seen::new(visible, unoccluded.value, if told { Sight::Part } else { Sight::Unclear })
        }
    }

    /// The same factor over numbers of twice the width, where its bound is too loose for its size or cannot be trusted;
    /// and whether it was.
    ///
    /// - `is_grazing`: whether the eye lies next to the plane of a surface involved
    fn sharpened(
        &self,
        plain: Factor,
        source: BodyAt,
        shadow: Option<&Shadow>,
        point: &MeasurementPoint,
        is_grazing: bool,
    ) -> (Factor, bool) {
        if plain.bound <= LOOSE * plain.value && !is_grazing {
            return (plain, false);
        }
        let eye = Vector::constant(point.position()) * Wide::constant(self.scale);
        let n = Vector::constant(point.normal_as_given()).normalize();
        let form = |at| Form::refined(self.body(at), eye);
        match self.factor(source, shadow, n, form) {
            // Where outlines touch, wide digits may see another topology than the one that was decided: then they tell nothing.
            Some(wide) if (wide.value.primal() - plain.value).abs() <= PARTED * plain.bound => {
                let value = wide.value.primal();
                let bound = 4.0 * f64::EPSILON * value.abs() + WIDE_EPSILON * plain.bound / f64::EPSILON;
                (Factor { value, bound }, true)
            }
            _ => (plain, false),
        }
    }

    /// The visible form factor of one source, or a part of one, over any number.
    ///
    /// - `shadow`: what cuts the source, `None` where nothing does
    /// - `form`: each body relative to the eye
    /// - returns `None` where the number's own digits would decide differently from those of an `f64`
    pub(super) fn factor<'a, T: Number>(
        &self,
        source: BodyAt,
        shadow: Option<&Shadow>,
        n: Vector<T>,
        form: impl Fn(BodyAt) -> Form<'a, T>,
    ) -> Option<Factor<T>> {
        let source = form(source);
        let piece = Piece::of_source(&source, n)?;
        let Some(shadow) = shadow else { return Some(point_factor::unoccluded(&source, &piece, n)) };
        let whole = (!shadow.source_hidden).then(|| point_factor::unoccluded(&source, &piece, n));
        let front = source.front();
        let mut pieces = vec![None; 1 + shadow.blockers.len()];
        pieces[0] = Some(piece);
        for i in shadow.outline.pieces() {
            if i > 0 {
                let (at, is_clipped) = shadow.blockers[i - 1];
                pieces[i] = Piece::of_occluder(&form(at), is_clipped.then_some(front));
            }
        }
        let [own, shade] = shadow.outline.contour(n, &pieces)?.map(point_factor::from_terms);
        let own = whole.unwrap_or(own);
        Some(Factor { value: own.value - shade.value, bound: own.bound + shade.bound })
    }
}

/// Whether the eye lies so close to a flat body's plane that rounding of its height over it tells in the result. (A bound
/// that follows this through every formula would be as loose; over wide numbers there is nothing to follow.)
fn is_grazing(body: &Body, eye: DVec3) -> bool {
    let normal = match &body.figure {
        Figure::Disk { normal, .. } => *normal,
        Figure::Flat(shape) => shape.normal,
        // Of many faces some are always seen edge-on, and those are small.
        Figure::Ball { .. } | Figure::Mesh(_) => return false,
    };
    let center = body.center - eye;
    normal.dot(center).abs() < GRAZING * (center.length() + body.reach)
}

/// What the strips make of a source.
fn by_strips(strips: Strips, unoccluded: Factor, piece: &Piece) -> Seen {
    let sight = match (strips.seen, strips.hidden) {
        (false, _) => return Seen::hidden(unoccluded.value),
        (true, false) if !piece.is_cut => Sight::Whole,
        _ => Sight::Part,
    };
    let visible = Factor { value: strips.value.clamp(0.0, unoccluded.value + unoccluded.bound), bound: strips.error };
    Seen { shadow_edge: strips.hidden, method: Method::Quadrature, ..Seen::new(visible, unoccluded.value, sight) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::Arrangement;
    use crate::geometry::{Disk, Polygon, Rectangle, Shape, Sphere};
    use crate::radiometry::Exitance;
    use glam::DVec3;
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
        // The strips take unit normals as rounded, the contour as given: a factor feels that by no more than this.
        let normals = 1e-15;
        prop_assert!(
            (f - value).abs() <= bound + error + normals,
            "{f:e} against strips {value:e} within {error:e}: {truth:?}"
        );
        prop_assert!(bound < 1e-9, "a bound of {bound:e} is of no use");
        // The same text over numbers of twice the width: what its bound covers, and no more than rounding.
        let seen = oracle.seen(&point).pop().unwrap();
        let is_told = !seen.touching && !matches!(seen.sight, Sight::Hidden | Sight::Below | Sight::Unclear);
        if is_told && seen.method == Method::ClosedForm {
            let eye = Vector::constant(point.position()) * Wide::constant(oracle.scale);
            let n = Vector::constant(point.normal_as_given()).normalize();
            let wide =
                oracle.factor(BodyAt::Source(0), seen.shadow.as_ref(), n, |at| Form::refined(oracle.body(at), eye));
            let wide = wide.map_or(f, |wide| wide.value.primal());
            prop_assert!((f - wide).abs() <= bound + normals, "{f:e} against {wide:e} over wide numbers: {truth:?}");
        }
        Ok(())
    }

    /// Rooms for each of the two sweeps below: few by default; `ETENDUE_SWEEP` sets another number.
    fn rooms() -> u32 {
        std::env::var("ETENDUE_SWEEP").ok().and_then(|said| said.parse().ok()).unwrap_or(300)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: rooms(), failure_persistence: None, ..ProptestConfig::default() })]
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
