//! The lecture's estimator, once more, as plainly as it can be written: one ray after another, own maps, own strata, own
//! shadow rays. It shares shapes and streams with the library and nothing else, and it can make one slip at a time.
//!
//! With [`Slip::None`] it is right, which tests hold. Every slip is a mistake that somebody made somewhere.

use std::f64::consts::{PI, TAU};

use etendue::configuration::{Configuration, MeasurementPoint, Source};
use etendue::estimator::{Estimator, Job, Scratch};
use etendue::geometry::{DVec3, Frame, Shape};
use etendue::sampling::{PointSet, Stream, StreamKey};
use rand::RngExt;

/// One mistake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slip {
    None,
    // What a ray brings.
    NoReceiverCosine,
    NoSourceCosine,
    SourceShinesBackwards,
    ReceiverFeelsBothSides,
    NoPi,
    InverseDistance,
    DistanceToCentre,
    CosineAtCentre,
    AreaDensityAsSolidAngle,
    TurnedNormal,
    SinglePrecision,
    // Areas and maps.
    TessellatedArea,
    HalfTheSphere,
    RadiusU,
    RadiusTwoRootU,
    StretchedSquare,
    PolesCrowded,
    TriangleWithoutRoot,
    CoarseNumbers,
    // Textures.
    HalfATexelOff,
    EvenSphereMap,
    MeanExitance,
    // Shadow rays.
    NoOccluder,
    StartsLate(f64),
    EndsEarly(f64),
    BlindBeyond(f64),
    CullsBackFaces,
    OccluderAsSquare,
    LiftedPoint(f64),
    // Which points.
    SameJitter,
    SkippedStratum,
    UnequalStrata,
    HalfACellOff,
    CellCentres,
    HalfJitter,
    RevisitedStrata,
    WholeSquare,
    OneShift,
    GridForRandom,
    Mirrored,
    EachTwice,
    // Streams.
    SameReplicate,
    SharedByNeighbours,
    NotShared,
    OverlappingReplicates,
    // Sums.
    OneTooMany,
    DividedByArrived,
    ClampedRays(f64),
    SourceByPowerWeighedEvenly,
    FirstSourceOnly,
}

pub struct Plain {
    configuration: Configuration,
    slip: Slip,
}

impl Plain {
    pub fn new(configuration: &Configuration, slip: Slip) -> Plain {
        Plain { configuration: configuration.clone(), slip }
    }
}

impl Estimator for Plain {
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        self.configuration.sources().len() as u64 * samples
    }

    fn estimate(&self, job: &Job, _: &mut Scratch, estimates: &mut [f64]) {
        let replicates = (job.replicates.end - job.replicates.start) as usize;
        let mut squares = Vec::new();
        for (p, point) in job.points.iter().enumerate() {
            for (r, replicate) in job.replicates.clone().enumerate() {
                let mut from = |source: usize| {
                    self.choose(job, replicate, p as u64, source, &mut squares);
                    self.average(point, source, &squares)
                };
                let n_sources = self.configuration.sources().len();
                estimates[p * replicates + r] = match self.slip {
                    Slip::FirstSourceOnly => from(0),
                    Slip::SourceByPowerWeighedEvenly => {
                        let luck = Stream::new(key(job, replicate, p as u64 + 1, n_sources)).random::<f64>();
                        from(self.by_power(luck)) * n_sources as f64
                    }
                    _ => (0..n_sources).map(from).sum(),
                };
            }
        }
    }
}

impl Plain {
    fn stream(&self, job: &Job, replicate: u64, point: u64, source: usize) -> Stream {
        let shares = match self.slip {
            Slip::NotShared => false,
            _ => job.strategy.shares_points(),
        };
        let point = match self.slip {
            _ if shares => 0,
            Slip::SharedByNeighbours => point / 2 + 1,
            _ => point + 1,
        };
        let replicate = if self.slip == Slip::SameReplicate { 0 } else { replicate };
        Stream::new(key(job, replicate, point, source))
    }

    /// Points of the unit square for one estimate.
    fn choose(&self, job: &Job, replicate: u64, point: u64, source: usize, squares: &mut Vec<[f64; 2]>) {
        squares.clear();
        let mut stream = self.stream(job, replicate, point, source);
        let mut next = move || [stream.random::<f64>(), stream.random::<f64>()];
        let n = job.samples as usize;
        if self.slip == Slip::OverlappingReplicates && n > 1 {
            let mut other = self.stream(job, replicate + 1, point, source);
            squares.extend((0..n / 2).map(|_| next()));
            squares.extend((n / 2..n).map(|_| [other.random::<f64>(), other.random::<f64>()]));
            return;
        }
        let stratified = job.strategy.point_set() == PointSet::Stratified || self.slip == Slip::GridForRandom;
        if !stratified || self.slip == Slip::WholeSquare {
            for k in 0..n {
                let fresh = match self.slip {
                    Slip::EachTwice if k % 2 == 1 => squares[k - 1],
                    Slip::Mirrored if k % 2 == 1 => squares[k - 1].map(|x| 1.0 - x),
                    Slip::CoarseNumbers => next().map(|x| (8.0 * x).floor() / 8.0),
                    _ => next(),
                };
                squares.push(fresh);
            }
            return;
        }
        let side = n.isqrt();
        assert_eq!(side * side, n, "the plain strata are a square grid");
        let shift = next();
        for k in 0..n {
            let cell = match self.slip {
                Slip::SkippedStratum if k + 1 == n => 0,
                Slip::RevisitedStrata => ((next()[0] * n as f64) as usize).min(n - 1),
                _ => k,
            };
            let [a, b] = next();
            let jitter = match self.slip {
                Slip::SameJitter => [a, a],
                Slip::CellCentres => [0.5, 0.5],
                Slip::HalfJitter => [0.5 * a, 0.5 * b],
                Slip::HalfACellOff => [a + 0.5, b],
                Slip::OneShift => shift,
                _ => [a, b],
            };
            let place = |index: usize, jitter: f64| (index as f64 + jitter) / side as f64;
            let (column, row) = (cell % side, cell / side);
            let v = match self.slip {
                Slip::UnequalStrata => {
                    let edge = |index: usize| place(index, 0.0).powf(1.5);
                    edge(row) + jitter[1] * (edge(row + 1) - edge(row))
                }
                _ => place(row, jitter[1]),
            };
            squares.push([place(column, jitter[0]), v]);
        }
    }

    /// The source that a number in [0, 1) falls to, each with its share of the power.
    fn by_power(&self, luck: f64) -> usize {
        let sources = self.configuration.sources();
        let powers: Vec<f64> =
            sources.iter().map(|s| s.exitance().watts_per_square_metre() * s.shape().area()).collect();
        let mut left = luck * powers.iter().sum::<f64>();
        let passed = |power: &&f64| {
            left -= **power;
            left >= 0.0
        };
        powers.iter().take_while(passed).count().min(sources.len() - 1)
    }

    /// A · M · (1/N) Σ cosθᵢ cosθₛ / (π r²) · Vis.
    fn average(&self, point: &MeasurementPoint, source: usize, squares: &[[f64; 2]]) -> f64 {
        let emitter = &self.configuration.sources()[source];
        let scale = self.area(emitter.shape());
        let (mut sum, mut arrived) = (0.0, 0_usize);
        for square in squares {
            let (at, normal) = self.place(emitter.shape(), *square);
            let mut brought = self.exitance(emitter, at) * self.kernel(point, emitter.shape(), at, normal);
            if brought > 0.0 && !self.is_blocked(point, source, at) {
                if let Slip::ClampedRays(most) = self.slip {
                    brought = brought.min(most);
                }
                sum += brought;
                arrived += 1;
            }
        }
        let count = match self.slip {
            Slip::OneTooMany => squares.len() + 1,
            Slip::DividedByArrived => arrived.max(1),
            _ => squares.len(),
        };
        scale * sum / count as f64
    }

    /// W/m² at a place of a source.
    fn exitance(&self, source: &Source, at: DVec3) -> f64 {
        let Some(texels) = source.texture().and_then(|texture| texture.texels()) else {
            return source.exitance().watts_per_square_metre();
        };
        let (grid, [mut s, mut t]) = (texels.raster().grid(), texels.map().to_map(at));
        match self.slip {
            Slip::HalfATexelOff => s = (s + 0.5 / grid.ns() as f64).fract(),
            // As if its rows were of equal area: sin² of half the angle is the share of the area below.
            Slip::EvenSphereMap => t = (0.5 * PI * t).sin().powi(2),
            Slip::MeanExitance => return source.exitance().watts_per_square_metre(),
            _ => {}
        }
        texels.raster().value(grid.texel([s, t]))
    }

    fn area(&self, shape: &Shape) -> f64 {
        match (self.slip, shape) {
            (Slip::TessellatedArea, Shape::Disk(disk)) => 6.0 * (TAU / 12.0).sin() * disk.radius() * disk.radius(),
            (Slip::HalfTheSphere, Shape::Sphere(sphere)) => TAU * sphere.radius() * sphere.radius(),
            _ => shape.area(),
        }
    }

    /// From the unit square to a point of the surface and its normal.
    fn place(&self, shape: &Shape, [u, v]: [f64; 2]) -> (DVec3, DVec3) {
        match shape {
            Shape::Rectangle(s) => (s.center() + s.edge_u() * (u - 0.5) + s.edge_v() * (v - 0.5), s.normal()),
            Shape::Disk(s) => {
                let frame = Frame::around(s.normal());
                let polar = |radius: f64| [radius * (TAU * v).cos(), radius * (TAU * v).sin()];
                let [x, y] = match self.slip {
                    Slip::RadiusU => polar(u),
                    Slip::RadiusTwoRootU => polar(2.0 * u.sqrt()),
                    Slip::StretchedSquare => {
                        let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
                        [a * (1.0 - 0.5 * b * b).sqrt(), b * (1.0 - 0.5 * a * a).sqrt()]
                    }
                    _ => concentric(u, v),
                };
                (s.center() + (frame.tangent * x + frame.bitangent * y) * s.radius(), s.normal())
            }
            Shape::Sphere(s) => {
                let height = match self.slip {
                    Slip::PolesCrowded => (PI * u).cos(),
                    _ => 1.0 - 2.0 * u,
                };
                let ring = (1.0 - height * height).max(0.0).sqrt();
                let out = DVec3::new(ring * (TAU * v).cos(), ring * (TAU * v).sin(), height);
                (s.center() + out * s.radius(), out)
            }
            Shape::Polygon(s) => {
                let [a, b, c] = s.vertices() else { panic!("a triangle") };
                let root = if self.slip == Slip::TriangleWithoutRoot { u } else { u.sqrt() };
                (*a + (*b - *a) * (root * (1.0 - v)) + (*c - *a) * (root * v), s.normal())
            }
            other => panic!("no such source: {}", other.kind()),
        }
    }

    /// cosθᵢ cosθₛ / (π r²).
    fn kernel(&self, point: &MeasurementPoint, shape: &Shape, at: DVec3, normal: DVec3) -> f64 {
        let mut ray = at - point.position();
        if self.slip == Slip::SinglePrecision {
            ray = (at.as_vec3() - point.position().as_vec3()).as_dvec3();
        }
        let r = ray.length();
        let (mut arriving, mut leaving) = (point.normal().dot(ray) / r, -normal.dot(ray) / r);
        let to_centre = || middle(shape) - point.position();
        let mut r2 = r * r;
        match self.slip {
            Slip::NoReceiverCosine if arriving > 0.0 => arriving = 1.0,
            Slip::NoSourceCosine if leaving > 0.0 => leaving = 1.0,
            Slip::SourceShinesBackwards => leaving = leaving.abs(),
            Slip::ReceiverFeelsBothSides => arriving = arriving.abs(),
            Slip::InverseDistance => r2 = r,
            Slip::DistanceToCentre => r2 = to_centre().length_squared(),
            Slip::CosineAtCentre => leaving = -normal.dot(to_centre()) / to_centre().length(),
            Slip::AreaDensityAsSolidAngle if leaving > 0.0 => (leaving, r2) = (1.0, 1.0),
            Slip::TurnedNormal => leaving = -leaving,
            _ => {}
        }
        let pi = if self.slip == Slip::NoPi { 1.0 } else { PI };
        arriving.max(0.0) * leaving.max(0.0) / (pi * r2)
    }

    fn is_blocked(&self, point: &MeasurementPoint, source: usize, at: DVec3) -> bool {
        if self.slip == Slip::NoOccluder {
            return false;
        }
        let from = match self.slip {
            Slip::LiftedPoint(height) => point.position() + point.normal() * height,
            _ => point.position(),
        };
        let ray = at - from;
        let others = self.configuration.sources().iter().enumerate().filter(|(other, _)| *other != source);
        let blockers = others.map(|(_, source)| source.shape()).chain(self.configuration.occluders());
        let length = || ray.length();
        blockers.into_iter().any(|shape| {
            self.crossings(shape, from, ray).into_iter().flatten().filter(|t| 0.0 < *t && *t < 1.0).any(
                |t| match self.slip {
                    Slip::StartsLate(metres) => t * length() > metres,
                    Slip::EndsEarly(metres) => (1.0 - t) * length() > metres,
                    Slip::BlindBeyond(metres) => t * length() < metres,
                    Slip::CullsBackFaces => flat_normal(shape).is_none_or(|normal| normal.dot(ray) < 0.0),
                    _ => true,
                },
            )
        })
    }

    /// Where a ray meets a shape, as parts of its length.
    fn crossings(&self, shape: &Shape, from: DVec3, ray: DVec3) -> [Option<f64>; 2] {
        let plane = |anchor: DVec3, normal: DVec3| {
            let t = (anchor - from).dot(normal) / ray.dot(normal);
            (t, from + ray * t - anchor)
        };
        let hit = |t: f64, inside: bool| [inside.then_some(t), None];
        match shape {
            Shape::Disk(s) => {
                let (t, offset) = plane(s.center(), s.normal());
                let inside = match self.slip {
                    Slip::OccluderAsSquare => {
                        let frame = Frame::around(s.normal());
                        offset.dot(frame.tangent).abs().max(offset.dot(frame.bitangent).abs()) < s.radius()
                    }
                    _ => offset.length() < s.radius(),
                };
                hit(t, inside)
            }
            Shape::Rectangle(s) => {
                let (t, offset) = plane(s.center(), s.normal());
                let along = |edge: DVec3| (offset.dot(edge) / edge.length_squared()).abs() < 0.5;
                hit(t, along(s.edge_u()) && along(s.edge_v()))
            }
            Shape::Sphere(s) => {
                let (to, a) = (from - s.center(), ray.length_squared());
                let (b, c) = (to.dot(ray), to.length_squared() - s.radius() * s.radius());
                let root = (b * b - a * c).max(0.0).sqrt();
                let found = b * b > a * c;
                [found.then(|| (-b - root) / a), found.then(|| (-b + root) / a)]
            }
            other => panic!("no such occluder: {}", other.kind()),
        }
    }
}

fn key(job: &Job, replicate: u64, point: u64, source: usize) -> StreamKey {
    job.cell.with(replicate).with(point).with(source as u64)
}

/// Concentric squares to concentric circles (Shirley and Chiu 1997), on the unit disk.
fn concentric(u: f64, v: f64) -> [f64; 2] {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        [0.0, 0.0]
    } else if a.abs() > b.abs() {
        let (sine, cosine) = (PI / 4.0 * b / a).sin_cos();
        [a * cosine, a * sine]
    } else {
        let (sine, cosine) = (PI / 4.0 * a / b).sin_cos();
        [b * sine, b * cosine]
    }
}

fn middle(shape: &Shape) -> DVec3 {
    let (low, high) = shape.bounds();
    low * 0.5 + high * 0.5
}

fn flat_normal(shape: &Shape) -> Option<DVec3> {
    match shape {
        Shape::Disk(s) => Some(s.normal()),
        Shape::Rectangle(s) => Some(s.normal()),
        _ => None,
    }
}
