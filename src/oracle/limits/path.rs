//! The line that limits are sought along.

use glam::DVec3;
use thiserror::Error;

use crate::configuration::{Arrangement, Configuration, MeasurementPoint, ReceiverShape};

/// Why a configuration has no line to seek along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoPath {
    /// Scattered points, or a grid of them.
    #[error("limits lie along a line, and its points are no line: give it `measure.line = {{ from, to, points }}`")]
    NotALine,
    /// A line of one point.
    #[error("limits lie along a line, and its line has a single point")]
    NoLength,
    /// Normals that differ along the line, and no sphere that tells how they turn between points.
    #[error("limits lie along a line, and its points turn without a sphere to lie on")]
    TurningNormals,
}

/// A straight segment, or an arc of a great circle on a sphere receiver; measured in metres from its first end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    pub(super) from: MeasurementPoint,
    pub(super) length: f64,
    pub(super) shape: PathShape,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PathShape {
    Segment {
        direction: DVec3,
    },
    /// Outward unit vectors at the first end and a quarter turn on.
    Arc {
        center: DVec3,
        radius: f64,
        start: DVec3,
        across: DVec3,
    },
}

/// Normals of points on one flat receiver differ by no more.
const PARALLEL: f64 = 1e-12;

impl Path {
    /// The line that a configuration's points lie along, from the first to the last.
    pub fn of(configuration: &Configuration) -> Result<Path, NoPath> {
        let points = configuration.points();
        if configuration.arrangement() != Arrangement::Line {
            return Err(NoPath::NotALine);
        }
        let [from, .., to] = points else { return Err(NoPath::NoLength) };
        if let Some(ReceiverShape::Sphere(sphere)) = configuration.receiver().map(|receiver| *receiver.shape()) {
            let (start, end) = (from.normal(), to.normal());
            let angle = start.cross(end).length().atan2(start.dot(end));
            let across = (end - start * start.dot(end)).normalize_or_zero();
            if across == DVec3::ZERO {
                return Err(NoPath::NoLength);
            }
            let shape = PathShape::Arc { center: sphere.center(), radius: sphere.radius(), start, across };
            return Ok(Path { from: *from, length: angle * sphere.radius(), shape });
        }
        if points.iter().any(|point| point.normal().distance(from.normal()) > PARALLEL) {
            return Err(NoPath::TurningNormals);
        }
        let across = to.position() - from.position();
        let length = across.length();
        if !(length > 0.0 && length.is_finite()) {
            return Err(NoPath::NoLength);
        }
        Ok(Path { from: *from, length, shape: PathShape::Segment { direction: across / length } })
    }

    /// Metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The surface element at a distance from the first end.
    ///
    /// - `distance`: metres, in [0, length]; beyond, the line goes on. No number stands for the first end.
    pub fn at(&self, distance: f64) -> MeasurementPoint {
        let (position, normal) = match self.shape {
            PathShape::Segment { direction } => (self.from.position() + direction * distance, self.from.normal()),
            PathShape::Arc { center, radius, start, across } => {
                let (sin, cos) = (distance / radius).sin_cos();
                let outward = start * cos + across * sin;
                (center + outward * radius, outward)
            }
        };
        MeasurementPoint::new(position, normal).unwrap_or(self.from)
    }

    /// A point of the same receiver near one of the path's: on a sphere it is brought back to it, and turns with it.
    pub(super) fn beside(&self, point: &MeasurementPoint, place: DVec3) -> Option<MeasurementPoint> {
        let (place, normal) = match self.shape {
            PathShape::Segment { .. } => (place, point.normal()),
            PathShape::Arc { center, radius, .. } => {
                let outward = (place - center).try_normalize()?;
                (center + outward * radius, outward)
            }
        };
        MeasurementPoint::new(place, normal).ok()
    }
}
