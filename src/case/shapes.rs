//! Reading shapes.

use glam::DVec3;

use super::error::{CaseError, MeshFileFault};
use super::folder::Folder;
use super::obj;
use super::schema::{self, Key, Value};
use super::walk::{Log, Node};
use crate::geometry::{Disk, Mesh, Polygon, Rectangle, Shape, ShapeError, Sphere, Triangle};
use crate::intake::{MESH_BYTES, NAMED_BYTES, POLYGON_VERTICES, SUBDIVIDE, TEXELS_IN_ALL, TRIANGLES, VERTICES};

/// Where a case file stands, and how much it has asked for so far.
pub(super) struct Files<'f> {
    folder: &'f Folder,
    /// The case file's path below the folder.
    case: &'f str,
    /// Bytes of the files that it named.
    bytes: u64,
    triangles: u64,
    /// Of polygons.
    vertices: u64,
    texels: u64,
}

impl<'f> Files<'f> {
    pub(super) fn new(folder: &'f Folder, case: &'f str) -> Files<'f> {
        Files { folder, case, bytes: 0, triangles: 0, vertices: 0, texels: 0 }
    }

    /// The content of a file that the case names, at most `limit` bytes of it.
    pub(super) fn read(&mut self, said: &str, limit: u64) -> Result<Vec<u8>, MeshFileFault> {
        let content =
            self.folder.read(self.case, said, limit.min(NAMED_BYTES - self.bytes)).map_err(|fault| match fault {
                MeshFileFault::TooLarge { limit: left } if left < limit => {
                    MeshFileFault::TooLargeTogether { limit: NAMED_BYTES }
                }
                fault => fault,
            })?;
        self.bytes += content.len() as u64;
        Ok(content)
    }

    /// Makes room for the texels of one more texture; else how many that would be.
    pub(super) fn take_texels(&mut self, count: u64) -> Result<(), CaseError> {
        taken(&mut self.texels, count, "texels in this case", TEXELS_IN_ALL)
    }
}

/// Adds to a count that has a limit.
fn taken(so_far: &mut u64, count: u64, what: &'static str, limit: u64) -> Result<(), CaseError> {
    let said = so_far.saturating_add(count);
    if said > limit {
        return Err(CaseError::TooMany { what, said: said.into(), limit });
    }
    *so_far = said;
    Ok(())
}

/// What [`all`] reads; other tables of a role (lamps) are read elsewhere.
const SURFACES: [&str; 5] = [schema::DISK, schema::RECTANGLE, schema::POLYGON, schema::SPHERE, schema::MESH];

/// Every shape table of a role (`source`, `occluder`), in the order of the file. A shape with a mistake is `None`.
pub(super) fn all<'t>(role: &Node<'t>, files: &mut Files, log: &mut Log) -> Vec<(Node<'t>, Option<Shape>)> {
    let mut shapes = Vec::new();
    for key in role.schema.keys {
        let Value::Tables(table) = key.value else { continue };
        if key.need == schema::Need::Later || !SURFACES.contains(&key.name) {
            continue;
        }
        for node in role.tables(key, table, log) {
            let shape = one(&node, key, files, log).and_then(|shape| of_ordinary_area(&node, shape, log));
            shapes.push((node, shape));
        }
    }
    shapes.sort_by_key(|(node, _)| node.span.start);
    shapes
}

fn one(node: &Node, key: &Key, files: &mut Files, log: &mut Log) -> Option<Shape> {
    match key.name {
        schema::DISK => disk(node, log).map(Shape::Disk),
        schema::RECTANGLE => rectangle(node, log).map(Shape::Rectangle),
        schema::POLYGON => polygon(node, files, log).map(Shape::Polygon),
        schema::SPHERE => sphere(node, log).map(Shape::Sphere),
        schema::MESH => mesh(node, files, log).map(Shape::Mesh),
        other => unreachable!("the schema names a shape {other} that nothing reads"),
    }
}

fn of_ordinary_area(node: &Node, shape: Shape, log: &mut Log) -> Option<Shape> {
    let said = shape.area();
    if (schema::MIN_AREA..=schema::MAX_MAGNITUDE * schema::MAX_MAGNITUDE).contains(&said) {
        return Some(shape);
    }
    log.add(node.span.clone(), CaseError::Area { table: node.schema.path, said });
    None
}

pub(super) fn disk(node: &Node, log: &mut Log) -> Option<Disk> {
    let center = node.vector(&schema::CENTER, log);
    let normal = node.direction(&schema::NORMAL, log);
    let radius = node.number(&schema::RADIUS, log);
    examine(node, log, center.is_some() && normal.is_some() && radius.is_some(), |faulty| {
        Disk::new(
            faulty.or(center, &schema::CENTER, DVec3::ZERO),
            faulty.or(normal, &schema::NORMAL, DVec3::Z),
            faulty.or(radius, &schema::RADIUS, 1.0),
        )
    })
}

pub(super) fn rectangle(node: &Node, log: &mut Log) -> Option<Rectangle> {
    let center = node.vector(&schema::CENTER, log);
    let edge_u = node.vector(&schema::EDGE_U, log);
    let edge_v = node.vector(&schema::EDGE_V, log);
    let across = |edge: Option<DVec3>| {
        edge.map(|edge| edge.any_orthogonal_vector()).filter(|edge| *edge != DVec3::ZERO).unwrap_or(DVec3::X)
    };
    examine(node, log, center.is_some() && edge_u.is_some() && edge_v.is_some(), |faulty| {
        let center = faulty.or(center, &schema::CENTER, DVec3::ZERO);
        let u = faulty.or(edge_u, &schema::EDGE_U, across(faulty.keep(edge_v, &schema::EDGE_V)));
        let v = faulty.or(edge_v, &schema::EDGE_V, across(Some(u)));
        Rectangle::new(center, u, v)
    })
}

pub(super) fn sphere(node: &Node, log: &mut Log) -> Option<Sphere> {
    let center = node.vector(&schema::CENTER, log);
    let radius = node.number(&schema::RADIUS, log);
    examine(node, log, center.is_some() && radius.is_some(), |faulty| {
        Sphere::new(faulty.or(center, &schema::CENTER, DVec3::ZERO), faulty.or(radius, &schema::RADIUS, 1.0))
    })
}

pub(super) fn polygon(node: &Node, files: &mut Files, log: &mut Log) -> Option<Polygon> {
    let vertices = node.vectors(&schema::VERTICES, POLYGON_VERTICES, log)?;
    if let Err(error) =
        taken(&mut files.vertices, vertices.len() as u64, "vertices of polygons in this case", VERTICES)
    {
        log.add(node.span_of(schema::VERTICES.name), error);
        return None;
    }
    Polygon::new(vertices).map_err(|error| note(node, log, error)).ok()
}

pub(super) fn triangle(node: &Node, log: &mut Log) -> Option<Triangle> {
    let vertices = node.vectors(&schema::VERTICES, POLYGON_VERTICES, log)?;
    let Ok(corners) = <[DVec3; 3]>::try_from(vertices.as_slice()) else {
        let key = node.schema.full_name(schema::VERTICES.name);
        let span = node.span_of(schema::VERTICES.name);
        log.add(span, CaseError::Length { key, what: "points", said: vertices.len(), expected: 3 });
        return None;
    };
    Triangle::new(corners).map_err(|error| note(node, log, error)).ok()
}

fn mesh(node: &Node, files: &mut Files, log: &mut Log) -> Option<Mesh> {
    let file = node.text(&schema::FILE, log);
    let levels = match node.has(&schema::SUBDIVIDE) {
        true => node.count(&schema::SUBDIVIDE, 0, SUBDIVIDE, log),
        false => Some(0),
    };
    let (file, span) = (file?, node.span_of(schema::FILE.name));
    let content = match files.read(file, MESH_BYTES) {
        Ok(content) => content,
        Err(fault) => {
            log.add(span, CaseError::MeshFile { file: file.into(), fault });
            return None;
        }
    };
    let mesh = match obj::read(&content) {
        Ok(mesh) => mesh,
        Err(error) => {
            log.add(span, CaseError::Mesh { file: file.into(), error });
            return None;
        }
    };
    let levels = levels?;
    let count = (mesh.triangles().len() as u64) << (2 * levels);
    if let Err(error) = taken(&mut files.triangles, count, "triangles in this case", TRIANGLES) {
        let span = if levels > 0 { node.span_of(schema::SUBDIVIDE.name) } else { span };
        log.add(span, error);
        return None;
    }
    Some(mesh.subdivided(levels as u32))
}

/// The keys of a shape that were missing or refused. Stand-ins take their place, so that the others are still examined.
pub(super) struct Faulty(Vec<&'static str>);

impl Faulty {
    pub(super) fn keep<T>(&self, given: Option<T>, key: &Key) -> Option<T> {
        given.filter(|_| !self.0.contains(&key.name))
    }
    pub(super) fn or<T>(&self, given: Option<T>, key: &Key, stand_in: T) -> T {
        self.keep(given, key).unwrap_or(stand_in)
    }
}

/// Makes a shape, noting all that its constructor refuses and not only the first.
///
/// `complete`: whether all keys could be read; what could not was noted then.
pub(super) fn examine<T>(
    node: &Node,
    log: &mut Log,
    complete: bool,
    make: impl Fn(&Faulty) -> Result<T, ShapeError>,
) -> Option<T> {
    let mut faulty = Faulty(Vec::new());
    loop {
        match make(&faulty) {
            Ok(shape) => return (complete && faulty.0.is_empty()).then_some(shape),
            Err(error) => match note(node, log, error) {
                Some(field) if !faulty.0.contains(&field) => faulty.0.push(field),
                _ => return None,
            },
        }
    }
}

/// Notes why a shape was refused, at the key at fault, which is returned.
pub(super) fn note(node: &Node, log: &mut Log, error: ShapeError) -> Option<&'static str> {
    let field = error.field();
    let span = field.map_or(node.span.clone(), |field| node.span_of(field));
    log.add(span, CaseError::Shape { table: node.schema.path, error });
    field
}
