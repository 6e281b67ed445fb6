//! Reading textures: what varies over a source or a receiver.

use glam::DVec3;
use toml::de::DeValue;

use super::error::CaseError;
use super::picture;
use super::schema::{self, Key};
use super::shapes::Files;
use super::walk::{Log, Node};
use crate::configuration::ReceiverShape;
use crate::geometry::{
    Disk, MapTriangle, Parametrisation, ParametrisationError, Rectangle, Shape, Sphere, TexelGrid,
};
use crate::intake::{PICTURE_BYTES, TEXELS};
use crate::texture::{Encoding, ExitancePolynomial, Lookup, OnRectangle, Raster, Texels, Texture, TextureError};

/// What a texture is laid on.
#[derive(Clone, Copy, Debug)]
pub(super) enum Canvas {
    Rectangle(Rectangle),
    Disk(Disk),
    Triangle([DVec3; 3]),
    Sphere(Sphere),
    /// A polygon with so many vertices.
    Polygon(usize),
    Mesh,
}

impl Canvas {
    pub(super) fn of_source(shape: &Shape) -> Canvas {
        match shape {
            Shape::Rectangle(s) => Canvas::Rectangle(*s),
            Shape::Disk(s) => Canvas::Disk(*s),
            Shape::Sphere(s) => Canvas::Sphere(*s),
            Shape::Polygon(s) => match *s.vertices() {
                [a, b, c] => Canvas::Triangle([a, b, c]),
                ref more => Canvas::Polygon(more.len()),
            },
            Shape::Mesh(_) => Canvas::Mesh,
        }
    }

    pub(super) fn of_receiver(shape: &ReceiverShape) -> Canvas {
        match shape {
            ReceiverShape::Rectangle(s) => Canvas::Rectangle(*s),
            ReceiverShape::Disk(s) => Canvas::Disk(*s),
            ReceiverShape::Triangle(s) => Canvas::Triangle(s.vertices()),
            ReceiverShape::Sphere(s) => Canvas::Sphere(*s),
        }
    }

    fn kind(&self) -> &'static str {
        match self {
            Canvas::Rectangle(_) => "rectangle",
            Canvas::Disk(_) => "disk",
            Canvas::Triangle(_) => "triangle",
            Canvas::Sphere(_) => "sphere",
            Canvas::Polygon(_) => "polygon",
            Canvas::Mesh => "mesh",
        }
    }
}

/// The keys that are for one shape only, with the shape.
const OF_ONE_SHAPE: [(&Key, &str, &str); 5] = [
    (&schema::POLYNOMIAL, "rectangle", "rectangles"),
    (&schema::MAP, "triangle", "triangles"),
    (&schema::NORTH, "sphere", "spheres"),
    (&schema::EQUATOR, "sphere", "spheres"),
    (&schema::ZERO, "disk", "disks"),
];

/// A texture, or nothing where the table has a mistake, which is noted.
///
/// - `canvas`: what it is laid on; without one the table is examined all the same, and nothing made
pub(super) fn texture(node: &Node, canvas: Option<Canvas>, files: &mut Files, log: &mut Log) -> Option<Texture> {
    let before = log.len();
    if let Some(canvas) = &canvas {
        for (key, kind, accepted) in OF_ONE_SHAPE {
            if node.has(key) && canvas.kind() != kind {
                let key_name = node.schema.full_name(key.name);
                let error = CaseError::ForeignKey { key: key_name, accepted, shape: canvas.kind() };
                log.add(node.span_of(key.name), error);
            }
        }
    }
    let contents = [&schema::IMAGE, &schema::CHECKER, &schema::POLYNOMIAL];
    let given: Vec<&Key> = contents.into_iter().filter(|key| node.has(key)).collect();
    let key = node.schema.path.to_owned();
    match given[..] {
        [_] => {}
        [] if contents.iter().any(|key| node.misspells(key)) => {}
        [] => {
            let accepted = contents.map(|key| key.name).to_vec();
            log.add(node.span.clone(), CaseError::NoTexture { key, accepted });
        }
        [first, second, ..] => {
            let error = CaseError::TwoTextures { key, first: first.name, second: second.name };
            log.add(node.span_of(second.name), error);
        }
    }
    let map = canvas.map(|canvas| map(node, &canvas, log));
    let polynomial = if node.has(&schema::POLYNOMIAL) { node.numbers(&schema::POLYNOMIAL, log) } else { None };
    let raster = raster(node, files, log);
    let lookup = lookup(node, log);
    if log.len() > before {
        return None;
    }
    if let (Some([e00, e10, e01, e20, e11, e02]), Some(Canvas::Rectangle(rectangle))) = (polynomial, canvas) {
        let polynomial = ExitancePolynomial { e00, e10, e01, e20, e11, e02 };
        return match OnRectangle::new(rectangle, polynomial) {
            Ok(on) => Some(Texture::Polynomial(on)),
            Err(error) => refuse(node, &schema::POLYNOMIAL, error, log),
        };
    }
    Some(Texture::Texels(Texels::new(map??, raster?, lookup?)))
}

fn refuse<T>(node: &Node, key: &Key, error: TextureError, log: &mut Log) -> Option<T> {
    log.add(node.span_of(key.name), CaseError::Texture { key: node.schema.full_name(key.name), error });
    None
}

/// How the surface is laid out.
fn map(node: &Node, canvas: &Canvas, log: &mut Log) -> Option<Parametrisation> {
    let direction = |key: &Key, default: DVec3, log: &mut Log| {
        if node.has(key) { node.direction(key, log) } else { Some(default) }
    };
    let (key, made) = match canvas {
        Canvas::Rectangle(rectangle) => return Some(Parametrisation::rectangle(rectangle)),
        Canvas::Disk(disk) => {
            let zero = if node.has(&schema::ZERO) { Some(node.direction(&schema::ZERO, log)?) } else { None };
            (&schema::ZERO, Parametrisation::disk(disk, zero))
        }
        Canvas::Sphere(sphere) => {
            let north = direction(&schema::NORTH, DVec3::Z, log);
            let equator = direction(&schema::EQUATOR, DVec3::X, log);
            (&schema::EQUATOR, Parametrisation::sphere(sphere, north?, equator?))
        }
        Canvas::Triangle(vertices) => {
            let triangle = map_triangle(node, *vertices, log)?;
            (&schema::MAP, triangle.and_then(|map| Parametrisation::triangle(*vertices, map)))
        }
        Canvas::Polygon(said) => {
            log.add(node.span.clone(), CaseError::NoMap { said: *said });
            return None;
        }
        // No source, and told elsewhere.
        Canvas::Mesh => return None,
    };
    match made {
        Ok(map) => Some(map),
        Err(error) => refuse(node, key, error.into(), log),
    }
}

/// Where a triangle's vertices lie in the map; `None` where what is said is no such thing.
fn map_triangle(
    node: &Node,
    vertices: [DVec3; 3],
    log: &mut Log,
) -> Option<Result<MapTriangle, ParametrisationError>> {
    let key = &schema::MAP;
    let Some(value) = node.raw(key) else { return Some(MapTriangle::similar_to(vertices)) };
    match value.get_ref() {
        DeValue::Array(items) => {
            let corners: Vec<Option<[f64; 2]>> = items.iter().map(|item| node.numbers_of(key, item, log)).collect();
            let [a, b, c] = corners[..] else {
                let key = node.schema.full_name(key.name);
                log.add(value.span(), CaseError::Length { key, what: "corners", said: corners.len(), expected: 3 });
                return None;
            };
            Some(MapTriangle::new([a?, b?, c?]))
        }
        DeValue::String(_) => match node.name_among(key, value, &["similar", "half-square"], log)? {
            "similar" => Some(MapTriangle::similar_to(vertices)),
            _ => Some(Ok(MapTriangle::HALF_SQUARE)),
        },
        _ => {
            node.refuse_type(key, value, key.value.expected(), log);
            None
        }
    }
}

/// The values, of a picture or a chessboard; `None` after a mistake, or where the texture is a polynomial.
fn raster(node: &Node, files: &mut Files, log: &mut Log) -> Option<Raster> {
    let level = |key: &Key, default: f64, log: &mut Log| {
        let said = if node.has(key) { node.number(key, log)? } else { default };
        if said < 0.0 {
            let (key_name, accepted) = (node.schema.full_name(key.name), "it is zero or greater");
            log.add(node.span_of(key.name), CaseError::Number { key: key_name, said, accepted });
            return None;
        }
        Some(said)
    };
    let white = level(&schema::WHITE, 1.0, log);
    let black = level(&schema::BLACK, 0.0, log);
    if node.has(&schema::CHECKER) {
        let counts = checker(node, log)?;
        take_texels((counts[0] * counts[1]) as u64, node, &schema::CHECKER, files, log)?;
        let (white, black) = (white?, black?);
        let grid = TexelGrid::new(counts[0], counts[1]).map_err(TextureError::from);
        return match grid.and_then(|grid| Raster::checker(grid, white, black)) {
            Ok(raster) => Some(raster),
            Err(error) => refuse(node, &schema::CHECKER, error, log),
        };
    }
    if !node.has(&schema::IMAGE) {
        return None;
    }
    let file = node.text(&schema::IMAGE, log);
    let encoding = encoding(node, log);
    let (file, encoding, span) = (file?, encoding?, node.span_of(schema::IMAGE.name));
    let bytes = match files.read(file, PICTURE_BYTES) {
        Ok(bytes) => bytes,
        Err(fault) => {
            log.add(span, CaseError::MeshFile { file: file.into(), fault });
            return None;
        }
    };
    let picture = match picture::read(&bytes, encoding) {
        Ok(picture) => picture,
        Err(said) => {
            log.add(span, CaseError::Picture { file: file.into(), said });
            return None;
        }
    };
    take_texels(picture.values.len() as u64, node, &schema::IMAGE, files, log)?;
    let (white, black) = (white?, black?);
    let values = picture.values.iter().map(|grey| black * (1.0 - grey) + white * grey).collect();
    match Raster::new(picture.grid, values) {
        Ok(raster) => Some(raster),
        Err(error) => refuse(node, &schema::IMAGE, error, log),
    }
}

fn take_texels(count: u64, node: &Node, key: &Key, files: &mut Files, log: &mut Log) -> Option<()> {
    files.take_texels(count).map_err(|error| log.add(node.span_of(key.name), error)).ok()
}

/// Columns and rows.
fn checker(node: &Node, log: &mut Log) -> Option<[usize; 2]> {
    let key = &schema::CHECKER;
    let value = node.raw(key)?;
    let items = node.items(key, value, log)?;
    let most = TexelGrid::MAX_SIDE as u64;
    let counts: Vec<_> = items.iter().map(|item| node.count_of(key, item, 1, most, log)).collect();
    let [ns, nt] = counts[..] else {
        let key = node.schema.full_name(key.name);
        log.add(value.span(), CaseError::Length { key, what: "numbers", said: counts.len(), expected: 2 });
        return None;
    };
    let (ns, nt) = (ns?, nt?);
    if ns * nt > TEXELS {
        let said = u128::from(ns * nt);
        log.add(value.span(), CaseError::TooMany { what: "texels", said, limit: TEXELS });
        return None;
    }
    Some([usize::try_from(ns).ok()?, usize::try_from(nt).ok()?])
}

fn encoding(node: &Node, log: &mut Log) -> Option<Encoding> {
    let key = &schema::ENCODING;
    let Some(value) = node.raw(key) else {
        let expected = "\"linear\" or \"srgb\"".to_owned();
        log.add(node.span.clone(), CaseError::MissingKey { table: node.schema.title(), key: key.name, expected });
        return None;
    };
    Some(match node.name_among(key, value, &["linear", "srgb"], log)? {
        "linear" => Encoding::Linear,
        _ => Encoding::Srgb,
    })
}

fn lookup(node: &Node, log: &mut Log) -> Option<Lookup> {
    let key = &schema::LOOKUP;
    let Some(value) = node.raw(key) else { return Some(Lookup::Nearest) };
    Some(match node.name_among(key, value, &["texel", "bilinear"], log)? {
        "texel" => Lookup::Nearest,
        _ => Lookup::Bilinear,
    })
}
