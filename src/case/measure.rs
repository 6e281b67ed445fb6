//! Reading the receiver and where to look.

use std::ops::Range;

use super::error::CaseError;
use super::schema::{self, Key, Value};
use super::shapes::{self, Files};
use super::texture;
use super::walk::{Log, Node};
use crate::configuration::{Arrangement, ConfigurationError, MeasurementPoint, Receiver, ReceiverShape};
use crate::intake::POINTS;
use crate::radiometry::Albedo;

/// The receiver, unless something is wrong with it.
pub(super) fn receiver(node: &Node, files: &mut Files, log: &mut Log) -> Option<Receiver> {
    let before = log.len();
    let table = node.texture(&schema::ALBEDO, log);
    let albedo = if table.is_none() { node.number(&schema::ALBEDO, log).map(Albedo::new) } else { None };
    let mut given = Vec::new();
    for key in node.schema.keys {
        let Value::Table(table) = key.value else { continue };
        if let Some(shape) = node.table(key, table, log) {
            let read = one(&shape, key, log);
            given.push((key.name, shape.span, read));
        } else if node.has(key) {
            given.push((key.name, node.span_of(key.name), None));
        }
    }
    given.sort_by_key(|(_, span, _)| span.start);
    for (said, span, _) in given.iter().skip(1) {
        log.add(span.clone(), CaseError::SecondReceiverShape { said });
    }
    if given.is_empty() && !node.schema.keys.iter().any(|key| node.misspells(key)) {
        let accepted = node.schema.accepted().filter(|name| *name != schema::ALBEDO.name).collect();
        log.add(node.span.clone(), CaseError::NoReceiverShape { accepted });
    }
    let shape = given.into_iter().next().and_then(|(_, _, shape)| shape);
    if let Some(table) = table {
        let texture = texture::texture(&table, shape.as_ref().map(texture::Canvas::of_receiver), files, log);
        return match Receiver::textured(shape?, texture?) {
            Ok(receiver) => (log.len() == before).then_some(receiver),
            Err(error) => {
                log.add(table.span.clone(), CaseError::Configuration(error));
                None
            }
        };
    }
    // Without a shape the albedo is examined all the same.
    let stand_in =
        || ReceiverShape::Sphere(crate::geometry::Sphere::new(glam::DVec3::ZERO, 1.0).expect("a unit ball"));
    match Receiver::new(shape.unwrap_or_else(stand_in), albedo) {
        Ok(receiver) => (log.len() == before).then_some(receiver),
        Err(error) => {
            log.add(node.span_of(schema::ALBEDO.name), CaseError::Configuration(error));
            None
        }
    }
}

fn one(node: &Node, key: &Key, log: &mut Log) -> Option<ReceiverShape> {
    match key.name {
        schema::RECTANGLE => shapes::rectangle(node, log).map(ReceiverShape::Rectangle),
        schema::DISK => shapes::disk(node, log).map(ReceiverShape::Disk),
        schema::TRIANGLE => shapes::triangle(node, log).map(ReceiverShape::Triangle),
        schema::SPHERE => shapes::sphere(node, log).map(ReceiverShape::Sphere),
        other => unreachable!("the schema names a receiver {other} that nothing reads"),
    }
}

/// The receiver as a line or a grid sees it.
pub(super) enum Ground<'r> {
    /// The case names none.
    None,
    /// It is there, but faulty.
    Faulty,
    Sound(&'r Receiver),
}

/// The points of a case, and which text asked for them.
pub(super) struct Measured {
    pub(super) points: Vec<MeasurementPoint>,
    pub(super) arrangement: Arrangement,
    /// How many points each line, grid or point of the file asked for, in order, and where it stands.
    pub(super) asked: Vec<(usize, Range<usize>)>,
    /// Whether the file asks for any point, sound or not.
    pub(super) any: bool,
}

impl Measured {
    pub(super) fn nothing() -> Measured {
        Measured { points: Vec::new(), arrangement: Arrangement::Scattered, asked: Vec::new(), any: false }
    }

    /// The text that asked for a point.
    pub(super) fn span_of(&self, point: usize) -> Option<Range<usize>> {
        let mut before = 0;
        let asked = self.asked.iter().find(|(n, _)| {
            before += n;
            point < before
        });
        asked.map(|(_, span)| span.clone())
    }
}

/// A request that is understood, before any point is made.
enum Request {
    Line([glam::DVec3; 2], usize),
    Grid { nu: usize, nv: usize },
    Point(MeasurementPoint),
}

impl Request {
    fn n_points(&self) -> u128 {
        match self {
            Request::Line(_, n) => *n as u128,
            Request::Grid { nu, nv } => *nu as u128 * *nv as u128,
            Request::Point(_) => 1,
        }
    }
}

pub(super) fn measure(node: &Node, ground: &Ground, log: &mut Log) -> Measured {
    let before = log.len();
    let points = node.tables(&schema::POINT, &schema::MEASURE_POINT, log);
    let any = !points.is_empty()
        || log.len() > before
        || node.has(&schema::LINE)
        || node.has(&schema::GRID)
        || schema::MEASURES.keys.iter().any(|key| node.misspells(key));
    let mut requests = Vec::new();
    if let Some(line) = line(node, ground, log) {
        requests.push((line, node.span_of(schema::LINE.name)));
    }
    if let Some(grid) = grid(node, ground, log) {
        requests.push((grid, node.span_of(schema::GRID.name)));
    }
    requests.extend(points.iter().filter_map(|point| {
        let span = point.span_of(schema::POSITION.name);
        Some((self::point(point, log)?, span))
    }));
    let mut measured = Measured { any, ..Measured::nothing() };
    let said: u128 = requests.iter().map(|(request, _)| request.n_points()).sum();
    if said > u128::from(POINTS) {
        let (_, span) = requests.iter().max_by_key(|(request, _)| request.n_points()).expect("more than none");
        log.add(span.clone(), CaseError::TooMany { what: "measurement points", said, limit: POINTS });
        return measured;
    }
    if let [(request, _)] = &requests[..] {
        measured.arrangement = match request {
            Request::Line(..) => Arrangement::Line,
            Request::Grid { nu, nv } => Arrangement::Grid { nu: *nu, nv: *nv },
            Request::Point(_) => Arrangement::Scattered,
        };
    }
    for (request, span) in requests {
        let before = measured.points.len();
        match (request, ground) {
            (Request::Point(point), _) => measured.points.push(point),
            (Request::Grid { nu, nv }, Ground::Sound(receiver)) => measured.points.extend(receiver.grid(nu, nv)),
            (Request::Line([from, to], n), Ground::Sound(receiver)) => match receiver.line(from, to, n) {
                Ok(points) => measured.points.extend(points),
                Err(error) => log.add(span.clone(), CaseError::Configuration(error)),
            },
            _ => {}
        }
        measured.asked.push((measured.points.len() - before, span));
    }
    measured
}

fn line(node: &Node, ground: &Ground, log: &mut Log) -> Option<Request> {
    let line = node.table(&schema::LINE, &schema::MEASURE_LINE, log)?;
    let from = line.vector(&schema::FROM, log);
    let to = line.vector(&schema::TO, log);
    let points = line.count(&schema::POINTS, 2, POINTS, log);
    if from.is_some() && from == to {
        log.add(line.span.clone(), CaseError::LineWithoutLength);
        return None;
    }
    match ground {
        Ground::None => {
            log.add(line.span.clone(), CaseError::NoReceiver { key: schema::LINE.name });
            return None;
        }
        Ground::Faulty => {}
        Ground::Sound(receiver) => {
            let mut off = false;
            for (end, key) in [(from, &schema::FROM), (to, &schema::TO)] {
                // A line of this end alone asks whether the end lies on the receiver.
                let Some(Err(ConfigurationError::OffReceiver { distance, .. })) =
                    end.map(|end| receiver.line(end, end, 2))
                else {
                    continue;
                };
                let error = ConfigurationError::OffReceiver { end: key.name, distance };
                log.add(line.span_of(key.name), CaseError::Configuration(error));
                off = true;
            }
            if off {
                return None;
            }
        }
    }
    Some(Request::Line([from?, to?], usize::try_from(points?).ok()?))
}

fn grid(node: &Node, ground: &Ground, log: &mut Log) -> Option<Request> {
    let value = node.raw(&schema::GRID)?;
    if let Ground::None = ground {
        log.add(value.span(), CaseError::NoReceiver { key: schema::GRID.name });
    }
    let items = node.items(&schema::GRID, value, log)?;
    let counts: Vec<_> = items.iter().map(|item| node.count_of(&schema::GRID, item, 1, POINTS, log)).collect();
    match counts[..] {
        [nu, nv] => Some(Request::Grid { nu: usize::try_from(nu?).ok()?, nv: usize::try_from(nv?).ok()? }),
        _ => {
            let key = node.schema.full_name(schema::GRID.name);
            log.add(value.span(), CaseError::Length { key, what: "numbers", said: counts.len(), expected: 2 });
            None
        }
    }
}

fn point(node: &Node, log: &mut Log) -> Option<Request> {
    let position = node.vector(&schema::POSITION, log);
    let normal = node.direction(&schema::NORMAL, log);
    // Without a position the normal is examined all the same.
    match MeasurementPoint::new(position.unwrap_or_default(), normal?) {
        Ok(point) => position.map(|_| Request::Point(point)),
        Err(error) => {
            let span = error.field().map_or(node.span.clone(), |field| node.span_of(field));
            log.add(span, CaseError::Shape { table: node.schema.path, error });
            None
        }
    }
}
