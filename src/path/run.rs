//! Many paths: batches, each a pure function of its key, joined in their order.

use std::convert::Infallible;

use rayon::prelude::*;

use super::settings::{Part, PathSettings};
use super::skin::{Skin, Target, shape_of, skins, start_of, targets};
use super::walk::{AsItIs, Found, Place, Walker, Weighing};
use crate::configuration::{Configuration, Lamp};
use crate::geometry::DVec3;
use crate::light::{Draws, LightSettings, Moments, Ray, Room, Split, Start, Tally, Tracer};
use crate::number::{Machine, Registers, Work};
use crate::sampling::{StreamKey, Surface};

/// Paths of a batch from each place: a unit of work.
const PATHS_A_BATCH: u64 = 1 << 10;
/// Batches that are worked on before any of them is joined.
const BATCHES_A_ROUND: u64 = 32;
/// Paths of a piece of a run over all places, at least; a large run has so many pieces at most. Part of the format: it fixes
/// the order of additions.
const PATHS_A_PIECE: u64 = 1 << 22;
const MOST_PIECES: u64 = 1 << 10;
/// Keeps the streams of eye paths apart from all others: "eye" in ASCII.
const PURPOSE: u64 = 0x0065_7965;

/// What paths from one place found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct PathPoint {
    /// In the order of [`Part::ALL`].
    parts: [Moments; 3],
    /// Paths that came upon a source by chance, by the same parts.
    reached: [u64; 3],
    /// Paths that a limit of length ended.
    pub terminated: u64,
}

impl PathPoint {
    /// Σ x over paths, and Σ x², of irradiances in W/m².
    pub fn moments(&self, part: Part) -> Moments {
        self.parts[part.index()]
    }
    /// W/m²; nought for no paths.
    pub fn mean(&self, part: Part, paths: u64) -> f64 {
        self.moments(part).watts() / paths.max(1) as f64
    }
    /// Estimated variance of one path, W²/m⁴; `None` below two.
    pub fn variance(&self, part: Part, paths: u64) -> Option<f64> {
        self.moments(part).variance(paths).map(|of_sum| of_sum / paths as f64)
    }
    /// Paths that came upon a source by chance and by such a way.
    pub fn reached(&self, part: Part) -> u64 {
        self.reached[part.index()]
    }
    #[inline(always)]
    fn add(&mut self, found: &Found) {
        self.parts.iter_mut().zip(found.parts()).for_each(|(sums, light)| sums.add(light));
        self.reached.iter_mut().zip(found.reached).for_each(|(count, reached)| *count += u64::from(reached));
        self.terminated += u64::from(found.terminated);
    }
    fn merge(&mut self, other: &PathPoint) {
        self.parts.iter_mut().zip(&other.parts).for_each(|(sums, other)| sums.merge(other));
        self.reached.iter_mut().zip(other.reached).for_each(|(count, other)| *count += other);
        self.terminated += other.terminated;
    }
}

/// What a run of paths found.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct PathRun {
    /// From each place.
    pub paths: u64,
    /// One for each measurement point.
    pub points: Vec<PathPoint>,
    /// Of the mean over the points, whose paths are independent of each other.
    pub mean: PathPoint,
    /// Directions that were followed, shadow rays not counted.
    pub segments: u64,
}

impl PathRun {
    fn new(places: usize) -> PathRun {
        PathRun { paths: 0, points: vec![PathPoint::default(); places], mean: PathPoint::default(), segments: 0 }
    }
    /// The next piece, or batch.
    pub(crate) fn merge(&mut self, other: &PathRun) {
        self.paths += other.paths;
        self.points.iter_mut().zip(&other.points).for_each(|(sums, other)| sums.merge(other));
        self.mean.merge(&other.mean);
        self.segments += other.segments;
    }
}

/// A configuration, prepared for eye paths.
pub struct PathTracer {
    room: Room,
    skins: Vec<Skin>,
    targets: Vec<Target>,
    lamps: Vec<Lamp>,
    places: Vec<Place>,
    /// The receiver, and which surface of the room it is.
    receiver: Option<(Surface, Start)>,
    settings: PathSettings,
    root: StreamKey,
    machine: Machine,
}

impl PathTracer {
    /// - `seed`: streams are keyed by it, by the configuration's digest, and by whether shadow rays are sent
    pub fn new(configuration: &Configuration, settings: &PathSettings, seed: u64) -> PathTracer {
        let room = Room::new(configuration);
        let (skins, targets) = (skins(configuration, &room), targets(configuration, &room));
        let place = |at: DVec3, normal: DVec3| {
            let start = start_of(configuration, &room, at);
            Place { at, normal, start, medium: room.medium_at(at) }
        };
        let places = configuration.points().iter().map(|point| place(point.position(), point.normal())).collect();
        let surface = configuration.receiver().and_then(|receiver| Surface::new(&shape_of(receiver.shape())));
        let receiver = surface.zip(room.of_receiver().map(Start::Face));
        let root = StreamKey::root(seed).with(configuration.digest().key()).with(PURPOSE);
        PathTracer {
            skins,
            targets,
            lamps: configuration.lamps().to_vec(),
            places,
            receiver,
            settings: *settings,
            root: root.with(u64::from(settings.next_event)),
            machine: Machine::new(),
            room,
        }
    }

    /// Whether a path can come upon a source: one with area.
    pub fn can_reach(&self) -> bool {
        !self.targets.is_empty()
    }

    /// Paths from every measurement point. The same bytes on any number of threads.
    ///
    /// - `paths`: from each, at least; as many as fill the last batch
    pub fn at_points(&self, paths: u64) -> PathRun {
        self.at_points_weighing(paths, &AsItIs)
    }

    pub(crate) fn at_points_weighing(&self, paths: u64, weighing: &impl Weighing) -> PathRun {
        let Ok(run) = self.at_points_while(paths, weighing, &|_| Ok::<(), Infallible>(()));
        run
    }

    /// - `progress`: told the paths of each finished batch; where it errs, the run is given up
    fn at_points_while<E: Send>(
        &self,
        paths: u64,
        weighing: &impl Weighing,
        progress: &(dyn Fn(u64) -> Result<(), E> + Sync),
    ) -> Result<PathRun, E> {
        let asked = self.asked(paths);
        let mut total = asked.nothing();
        for k in 0..asked.n_pieces() {
            total.merge(&self.piece_at_points(&asked, k, weighing, progress)?);
        }
        Ok(total)
    }

    /// So many paths from every measurement point, in pieces.
    pub(crate) fn asked(&self, paths: u64) -> Asked {
        Asked { paths, places: self.places.len() as u64 }
    }

    /// - `progress`: as for [`PathTracer::at_points_while`]
    pub(crate) fn piece_at_points<E: Send>(
        &self,
        asked: &Asked,
        piece: u64,
        weighing: &impl Weighing,
        progress: &(dyn Fn(u64) -> Result<(), E> + Sync),
    ) -> Result<PathRun, E> {
        self.in_batches(0, asked, piece, weighing, progress, |k, _| self.places[k])
    }

    /// Paths from places anywhere on the receiver, uniform by area: the only point is the receiver's mean. `None` without a
    /// receiver.
    pub fn over_receiver(&self, paths: u64) -> Option<PathRun> {
        let asked = self.asked_over_receiver(paths)?;
        let mut total = asked.nothing();
        for k in 0..asked.n_pieces() {
            let Ok(piece) = self.piece_over_receiver(&asked, k, &|_| Ok::<(), Infallible>(()));
            total.merge(&piece);
        }
        Some(total)
    }

    /// The same in pieces; `None` without a receiver.
    pub(crate) fn asked_over_receiver(&self, paths: u64) -> Option<Asked> {
        self.receiver.as_ref().map(|_| Asked { paths, places: 1 })
    }

    /// - `progress`: as for [`PathTracer::at_points_while`]
    pub(crate) fn piece_over_receiver<E: Send>(
        &self,
        asked: &Asked,
        piece: u64,
        progress: &(dyn Fn(u64) -> Result<(), E> + Sync),
    ) -> Result<PathRun, E> {
        let (surface, start) = self.receiver.as_ref().expect("who asks has a receiver");
        self.in_batches(1, asked, piece, &AsItIs, progress, |_, draws| {
            let offset = draws.on(surface);
            let at = surface.origin() + offset;
            let normal = surface.flat_normal().unwrap_or_else(|| offset.normalize());
            Place { at, normal, start: *start, medium: self.room.medium_at(at) }
        })
    }

    fn in_batches<W: Weighing, E: Send>(
        &self,
        stream: u64,
        asked: &Asked,
        piece: u64,
        weighing: &W,
        progress: &(dyn Fn(u64) -> Result<(), E> + Sync),
        place: impl Fn(usize, &mut Draws) -> Place + Sync,
    ) -> Result<PathRun, E> {
        let mut total = asked.nothing();
        let places = total.points.len();
        let batches = asked.batches(piece);
        let root = self.root.with(stream);
        for first in batches.clone().step_by(BATCHES_A_ROUND as usize) {
            let round = first..(first + BATCHES_A_ROUND).min(batches.end);
            // One source text, compiled for each instruction set and chosen at run time, as for rays from the light.
            let batch = |k: u64| {
                progress(0)?;
                let run = self.machine.run(Batch { of: self, key: root.with(k), places, weighing, place: &place });
                progress(PATHS_A_BATCH * places as u64)?;
                Ok(run)
            };
            let done: Vec<PathRun> = round.into_par_iter().map(batch).collect::<Result<_, E>>()?;
            done.iter().for_each(|run| total.merge(run));
        }
        Ok(total)
    }
}

/// How many paths, and from how many places: what fixes the pieces of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    paths: u64,
    places: u64,
}

impl Asked {
    /// No path yet.
    pub fn nothing(&self) -> PathRun {
        PathRun::new(self.places as usize)
    }

    fn n_batches(&self) -> u64 {
        if self.places == 0 { 0 } else { self.paths.div_ceil(PATHS_A_BATCH) }
    }

    fn batches_a_piece(&self) -> u64 {
        let enough = PATHS_A_PIECE.div_ceil(PATHS_A_BATCH * self.places.max(1));
        enough.max(self.n_batches().div_ceil(MOST_PIECES)).next_multiple_of(BATCHES_A_ROUND)
    }

    pub fn n_pieces(&self) -> u64 {
        self.n_batches().div_ceil(self.batches_a_piece())
    }

    fn batches(&self, piece: u64) -> std::ops::Range<u64> {
        let of = self.batches_a_piece();
        piece * of..((piece + 1) * of).min(self.n_batches())
    }

    /// Paths of a piece from all places, about.
    pub fn paths_of_piece(&self, piece: u64) -> u64 {
        let batches = self.batches(piece);
        (batches.end - batches.start) * PATHS_A_BATCH * self.places
    }
}

/// A batch as a function that can be compiled for any instruction set.
struct Batch<'a, W: Weighing, P: Fn(usize, &mut Draws) -> Place> {
    of: &'a PathTracer,
    key: StreamKey,
    places: usize,
    weighing: &'a W,
    place: &'a P,
}

impl<W: Weighing, P: Fn(usize, &mut Draws) -> Place> Work for Batch<'_, W, P> {
    type Output = PathRun;

    #[inline(always)]
    fn run<R: Registers>(self, _: R) -> PathRun {
        let Batch { of, key, places, weighing, place } = self;
        let mut run = PathRun::new(places);
        let mut draws = Draws::new(key);
        let light = LightSettings { depth: of.settings.chain, split: Split::One, ..LightSettings::default() };
        let tracer = Tracer::new(&of.room, &[], &light);
        let mut tally = Tally::new(0, 0, [0, 0], of.room.n_optics());
        let mut branches: Vec<Ray> = Vec::new();
        let (room, skins, targets, lamps) = (&of.room, &of.skins[..], &of.targets[..], &of.lamps[..]);
        let walker = Walker { room, skins, targets, lamps, settings: of.settings, weighing };
        let share = 1.0 / places as f64;
        for _ in 0..PATHS_A_BATCH {
            let mut mean = Found::default();
            for (k, point) in run.points.iter_mut().enumerate() {
                let from = place(k, &mut draws);
                let found = walker.walk(from, &tracer, &mut branches, &mut tally, &mut draws);
                point.add(&found);
                mean.direct += share * found.direct;
                mean.caustic += share * found.caustic;
                mean.indirect += share * found.indirect;
                (0..3).for_each(|k| mean.reached[k] |= found.reached[k]);
                mean.terminated |= found.terminated;
                run.segments += found.segments;
            }
            run.mean.add(&mean);
        }
        run.paths = PATHS_A_BATCH;
        run
    }
}
