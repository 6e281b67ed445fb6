//! Reading lamps, mirrors, glass and diffuse surfaces.

use std::ops::Range;

use glam::DVec3;

use super::error::CaseError;
use super::schema::{self, Key, Table, Value};
use super::shapes::{Files, disk, examine, polygon, rectangle, sphere, triangle};
use super::walk::{Log, Node};
use crate::configuration::{
    ConfigurationError, DiffuseSurface, Glass, GlassShape, Lamp, Mirror, MirrorShape, ReceiverShape,
};
use crate::geometry::{Cylinder, Disk, Paraboloid, PlanoConvex, Rectangle, Slab, Sphere, SphereCap};
use crate::radiometry::{Albedo, Beam, Exitance, Flux, Irradiance, PointSource, RadiometryError};

/// The sound items of a role in the order of the file, and where each stands.
type Placed<T> = Vec<(Range<usize>, T)>;

/// Every table of a role, in the order of the file, each read by itself. An item with a mistake is left out.
fn each<'t, T>(
    role: &Node<'t>,
    log: &mut Log,
    mut one: impl FnMut(&Node<'t>, &'static Key, &mut Log) -> Option<T>,
) -> Placed<T> {
    let mut found = Vec::new();
    for key in role.schema.keys {
        let Value::Tables(table) = key.value else { continue };
        if key.need == schema::Need::Later {
            continue;
        }
        for node in role.tables(key, table, log) {
            let item = one(&node, key, log);
            found.push((node.span, item));
        }
    }
    found.sort_by_key(|(span, _)| span.start);
    found.into_iter().filter_map(|(span, item)| Some((span, item?))).collect()
}

/// Points and beams among the sources.
pub(super) fn lamps(role: &Node, log: &mut Log) -> Vec<Lamp> {
    let mut found: Placed<Lamp> = Vec::new();
    let tables: [(&str, &'static Table); 2] = [("point", &schema::SOURCE_POINT), ("beam", &schema::SOURCE_BEAM)];
    for (name, table) in tables {
        let key = schema::SOURCES.key(name).expect("the schema names both lamps");
        for node in role.tables(key, table, log) {
            let lamp = if name == "point" { point(&node, log) } else { beam(&node, log) };
            found.extend(lamp.map(|lamp| (node.span.clone(), lamp)));
        }
    }
    found.sort_by_key(|(span, _)| span.start);
    found.into_iter().map(|(_, lamp)| lamp).collect()
}

fn point(node: &Node, log: &mut Log) -> Option<Lamp> {
    let position = node.vector(&schema::POSITION, log);
    let power = node.number(&schema::POWER, log);
    // Without a position the power is examined all the same.
    let lamp = refused(PointSource::new(position.unwrap_or_default(), Flux::new(power?)), node, &schema::POWER, log)?;
    position.map(|_| Lamp::Point(lamp))
}

fn beam(node: &Node, log: &mut Log) -> Option<Lamp> {
    // The disk that the light comes through, examined as any disk.
    let center = node.vector(&schema::CENTER, log);
    let direction = node.direction(&schema::DIRECTION, log);
    let radius = node.number(&schema::RADIUS, log);
    let irradiance = node.number(&schema::IRRADIANCE, log);
    let section = examine(node, log, center.is_some() && direction.is_some() && radius.is_some(), |faulty| {
        let direction = faulty.or(direction, &schema::DIRECTION, DVec3::Z);
        let made = Disk::new(
            faulty.or(center, &schema::CENTER, DVec3::ZERO),
            direction,
            faulty.or(radius, &schema::RADIUS, 1.0),
        );
        made.map_err(|error| match error {
            crate::geometry::ShapeError::NoDirection { .. } => {
                crate::geometry::ShapeError::NoDirection { field: schema::DIRECTION.name }
            }
            other => other,
        })
    });
    let stand_in = Disk::new(DVec3::ZERO, DVec3::Z, 1.0).expect("a unit disk");
    let disk = section.unwrap_or(stand_in);
    let beam = Beam::new(disk.center(), disk.normal_as_given(), disk.radius(), Irradiance::new(irradiance?));
    let beam = refused(beam, node, &schema::IRRADIANCE, log)?;
    section.map(|_| Lamp::Beam(beam))
}

/// Notes what the laws refuse, at the key that said it.
fn refused<T>(made: Result<T, RadiometryError>, node: &Node, key: &Key, log: &mut Log) -> Option<T> {
    made.map_err(|error| log.add(node.span_of(key.name), CaseError::Lamp { table: node.schema.path, error })).ok()
}

/// Notes what a configuration refuses of one part, at the key that said it.
fn judged<T>(made: Result<T, ConfigurationError>, node: &Node, key: &Key, log: &mut Log) -> Option<T> {
    made.map_err(|error| log.add(node.span_of(key.name), CaseError::Configuration(error))).ok()
}

fn ordinary<T>(node: &Node, shape: T, area: f64, log: &mut Log) -> Option<T> {
    if (schema::MIN_AREA..=schema::MAX_MAGNITUDE * schema::MAX_MAGNITUDE).contains(&area) {
        return Some(shape);
    }
    log.add(node.span.clone(), CaseError::Area { table: node.schema.path, said: area });
    None
}

fn unit_ball() -> Sphere {
    Sphere::new(DVec3::ZERO, 1.0).expect("a unit ball")
}

pub(super) fn mirrors(role: &Node, files: &mut Files, log: &mut Log) -> Placed<Mirror> {
    each(role, log, |node, key, log| {
        let shape = mirror_shape(node, key, files, log);
        let shape = shape.and_then(|shape| {
            let area = shape.area();
            ordinary(node, shape, area, log)
        });
        let reflectance = node.number(&schema::REFLECTANCE, log)?;
        let sound = shape.is_some();
        let shape = shape.unwrap_or_else(|| MirrorShape::Sphere(unit_ball()));
        judged(Mirror::new(shape, reflectance), node, &schema::REFLECTANCE, log).filter(|_| sound)
    })
}

fn mirror_shape(node: &Node, key: &Key, files: &mut Files, log: &mut Log) -> Option<MirrorShape> {
    match key.name {
        schema::RECTANGLE => rectangle(node, log).map(MirrorShape::Rectangle),
        schema::POLYGON => polygon(node, files, log).map(MirrorShape::Polygon),
        schema::DISK => disk(node, log).map(MirrorShape::Disk),
        schema::SPHERE => sphere_or_cap(node, log),
        "cylinder" => cylinder(node, log).map(MirrorShape::Cylinder),
        "paraboloid" => paraboloid(node, log).map(MirrorShape::Paraboloid),
        other => unreachable!("the schema names a mirror {other} that nothing reads"),
    }
}

fn sphere_or_cap(node: &Node, log: &mut Log) -> Option<MirrorShape> {
    let whole = sphere(node, log);
    let (has_axis, has_rim) = (node.has(&schema::CAP_AXIS), node.has(&schema::CAP_RIM));
    if !has_axis && !has_rim {
        return whole.map(MirrorShape::Sphere);
    }
    for (there, key) in [(has_axis, &schema::CAP_AXIS), (has_rim, &schema::CAP_RIM)] {
        if !there {
            let expected = key.value.expected().to_string();
            log.add(node.span.clone(), CaseError::MissingKey { table: node.schema.title(), key: key.name, expected });
        }
    }
    let axis = node.direction(&schema::CAP_AXIS, log);
    let rim = node.number(&schema::CAP_RIM, log);
    let complete = whole.is_some() && axis.is_some() && rim.is_some();
    let whole = whole.unwrap_or_else(unit_ball);
    let cap = examine(node, log, complete, |faulty| {
        // Any rim fits a stand-in.
        let rim = faulty.or(rim, &schema::CAP_RIM, 0.5 * whole.radius());
        let rim = if complete { rim } else { rim.clamp(f64::MIN, whole.radius()) };
        SphereCap::new(whole, faulty.or(axis, &schema::CAP_AXIS, DVec3::Z), rim)
    });
    cap.map(MirrorShape::SphereCap)
}

fn cylinder(node: &Node, log: &mut Log) -> Option<Cylinder> {
    let center = node.vector(&schema::CENTER, log);
    let axis = node.direction(&schema::AXIS, log);
    let radius = node.number(&schema::RADIUS, log);
    let height = node.number(&schema::HEIGHT, log);
    let toward = if node.has(&schema::TOWARD) { Some(node.direction(&schema::TOWARD, log)?) } else { None };
    let arc = if node.has(&schema::ARC) { node.number(&schema::ARC, log)? } else { 1.0 };
    if toward.is_none() && arc < 1.0 {
        let (key, expected) = (schema::TOWARD.name, schema::TOWARD.value.expected().to_string());
        log.add(node.span.clone(), CaseError::MissingKey { table: node.schema.title(), key, expected });
        return None;
    }
    let complete = center.is_some() && axis.is_some() && radius.is_some() && height.is_some();
    examine(node, log, complete, |faulty| {
        let axis = faulty.or(axis, &schema::AXIS, DVec3::Z);
        let whole = Cylinder::new(
            faulty.or(center, &schema::CENTER, DVec3::ZERO),
            axis,
            faulty.or(radius, &schema::RADIUS, 1.0),
            faulty.or(height, &schema::HEIGHT, 1.0),
        )?;
        let sideways = whole.toward();
        whole.part(faulty.or(toward, &schema::TOWARD, sideways), faulty.or(Some(arc), &schema::ARC, 1.0))
    })
}

fn paraboloid(node: &Node, log: &mut Log) -> Option<Paraboloid> {
    let vertex = node.vector(&schema::VERTEX, log);
    let axis = node.direction(&schema::FOCUS_AXIS, log);
    let focal = node.number(&schema::FOCAL_LENGTH, log);
    let rim = node.number(&schema::RIM_RADIUS, log);
    let complete = vertex.is_some() && axis.is_some() && focal.is_some() && rim.is_some();
    examine(node, log, complete, |faulty| {
        Paraboloid::new(
            faulty.or(vertex, &schema::VERTEX, DVec3::ZERO),
            faulty.or(axis, &schema::FOCUS_AXIS, DVec3::Z),
            faulty.or(focal, &schema::FOCAL_LENGTH, 1.0),
            faulty.or(rim, &schema::RIM_RADIUS, 1.0),
        )
    })
}

pub(super) fn glass(role: &Node, log: &mut Log) -> Placed<Glass> {
    each(role, log, |node, key, log| {
        let shape = match key.name {
            schema::SPHERE => sphere(node, log).map(GlassShape::Sphere),
            "slab" => slab(node, log).map(GlassShape::Slab),
            "plano_convex" => plano_convex(node, log).map(GlassShape::PlanoConvex),
            other => unreachable!("the schema names glass {other} that nothing reads"),
        };
        let shape = shape.and_then(|shape| ordinary(node, shape, shape.area(), log));
        let ior = node.number(&schema::IOR, log)?;
        let stand_in = GlassShape::Sphere(unit_ball());
        let made = Glass::new(shape.unwrap_or(stand_in), ior);
        judged(made, node, &schema::IOR, log).filter(|_| shape.is_some())
    })
}

fn slab(node: &Node, log: &mut Log) -> Option<Slab> {
    let middle = rectangle(node, log);
    let thickness = node.number(&schema::THICKNESS, log);
    let stand_in = || Rectangle::new(DVec3::ZERO, DVec3::X, DVec3::Y).expect("a unit square");
    let complete = middle.is_some() && thickness.is_some();
    examine(node, log, complete, |faulty| {
        Slab::new(middle.unwrap_or_else(stand_in), faulty.or(thickness, &schema::THICKNESS, 1.0))
    })
}

fn plano_convex(node: &Node, log: &mut Log) -> Option<PlanoConvex> {
    let vertex = node.vector(&schema::VERTEX, log);
    let axis = node.direction(&schema::LENS_AXIS, log);
    let curvature = node.number(&schema::CURVATURE_RADIUS, log);
    let rim = node.number(&schema::LENS_RIM, log);
    let complete = vertex.is_some() && axis.is_some() && curvature.is_some() && rim.is_some();
    examine(node, log, complete, |faulty| {
        let rim = faulty.or(rim, &schema::LENS_RIM, f64::MIN_POSITIVE);
        PlanoConvex::new(
            faulty.or(vertex, &schema::VERTEX, DVec3::ZERO),
            faulty.or(axis, &schema::LENS_AXIS, DVec3::Z),
            faulty.or(curvature, &schema::CURVATURE_RADIUS, rim.abs().max(1.0)),
            rim,
        )
    })
}

pub(super) fn diffuse(role: &Node, log: &mut Log) -> Placed<DiffuseSurface> {
    each(role, log, |node, key, log| {
        let shape = match key.name {
            schema::RECTANGLE => rectangle(node, log).map(ReceiverShape::Rectangle),
            schema::DISK => disk(node, log).map(ReceiverShape::Disk),
            schema::TRIANGLE => triangle(node, log).map(ReceiverShape::Triangle),
            schema::SPHERE => sphere(node, log).map(ReceiverShape::Sphere),
            other => unreachable!("the schema names a diffuse {other} that nothing reads"),
        };
        let albedo = node.number(&schema::DIFFUSE_ALBEDO, log).map(Albedo::new);
        let has = |key: &Key| node.schema.keys.iter().any(|known| known.name == key.name) && node.has(key);
        let optional = |key: &Key, log: &mut Log| if has(key) { node.number(key, log) } else { Some(0.0) };
        let exitance = optional(&schema::DIFFUSE_EXITANCE, log).map(Exitance::new);
        let inward = if node.has(&schema::INWARD) { node.flag(&schema::INWARD, log) } else { Some(false) };
        // Each number is examined, whatever the others are.
        let stand_in = ReceiverShape::Sphere(unit_ball());
        let (none, dark) = (Albedo::new(0.0), Exitance::new(0.0));
        let reflects = DiffuseSurface::new(stand_in, albedo.unwrap_or(none), dark, false);
        judged(reflects, node, &schema::DIFFUSE_ALBEDO, log)?;
        let emits = DiffuseSurface::new(stand_in, none, exitance.unwrap_or(dark), false);
        judged(emits, node, &schema::DIFFUSE_EXITANCE, log)?;
        let transmittance = optional(&schema::TRANSMITTANCE, log);
        let made = judged(DiffuseSurface::new(shape?, albedo?, exitance?, inward?), node, &schema::INWARD, log)?;
        judged(made.translucent(transmittance?), node, &schema::TRANSMITTANCE, log)
    })
}
