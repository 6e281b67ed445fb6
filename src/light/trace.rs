//! One run: batches of rays, each a pure function of its key, joined in their order.

use std::convert::Infallible;

use rayon::prelude::*;

use super::chain::{FAINT, Ray, Tracer};
use super::draws::Draws;
use super::emitter::{Emitter, Group, emitters};
use super::ledger::{Ledger, Moments, Sum};
use super::map::{Landing, RingMap, TexelMap, TileMap};
use super::room::{Room, Start};
use super::settings::LightSettings;
use super::tally::Tally;
use crate::configuration::Configuration;
use crate::geometry::{DVec3, TexelGrid};
use crate::number::{Machine, Registers, Work};
use crate::sampling::StreamKey;

/// Rays of a batch, about: a unit of work, and of memory.
const RAYS_A_BATCH: u64 = 1 << 13;
/// Batches that are worked on before any of them is joined.
const BATCHES_A_ROUND: u64 = 32;
/// Batches that one thread works on side by side: a ray is one long chain of roots and quotients, each waiting for the one
/// before, and in the meantime a ray of another batch goes on.
const ABREAST: u64 = 2;
/// Rays of a piece of a run, at least; a large run has so many pieces at most. Part of the format: it fixes the order of
/// additions.
const RAYS_A_PIECE: u64 = 1 << 22;
const MOST_PIECES: u64 = 1 << 10;
/// Keeps the streams of the light apart from those of the estimators: "light" in ASCII.
const PURPOSE: u64 = 0x006c_6967_6874;

/// What the light of a configuration has left, and where it went.
#[derive(Clone, Debug)]
pub struct LightRun {
    pub ledger: Ledger,
    /// The receiver's, if there is one, then one for each diffuse surface.
    pub maps: Vec<TexelMap>,
    /// On the receiver; `None` where the settings name none, or there is no receiver.
    pub rings: Option<RingMap>,
    /// On the receiver; `None` likewise.
    pub tiles: Option<TileMap>,
    /// What was deposited by light of each number of interactions, on each map: `[n_maps][depth + 1]`, W.
    orders: Vec<Moments>,
    depth: usize,
    /// Rays and branches that met each mirror, then each piece of glass. Nought: no light reaches it.
    pub reached: Vec<u64>,
    /// Interactions at which polarised light changed its plane of incidence. It goes on as unpolarised, which is an
    /// approximation.
    pub depolarised: u64,
    /// The flux of them, W, a packet counted each time.
    pub depolarised_flux: f64,
}

impl LightRun {
    /// What light of one order left on a map, W, with its spread over groups.
    pub fn deposited(&self, map: usize, order: usize) -> Moments {
        let in_range = map < self.maps.len() && order <= self.depth;
        if in_range { self.orders[map * (self.depth + 1) + order] } else { Moments::default() }
    }
    /// The largest order that can be deposited.
    pub fn depth(&self) -> usize {
        self.depth
    }
    /// What light of one order left on all maps, W.
    pub fn deposited_by_order(&self, order: usize) -> f64 {
        let mut sum = Sum::default();
        (0..self.maps.len()).for_each(|map| sum += self.deposited(map, order).flux);
        sum.value()
    }
}

/// A piece of a run: so many rounds of batches in a row.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct LightPiece {
    books: Tally,
    /// What was left in texels that any light reached, ascending: twice the texel's number through all maps, plus one for
    /// bent light.
    texels: Vec<(u32, Moments)>,
}

/// Pieces of a run, put together in their order.
pub(crate) struct LightSum<'a> {
    of: &'a LightTracer,
    maps: Vec<TexelMap>,
    total: Tally,
}

/// A configuration, prepared for rays from the light.
pub struct LightTracer {
    room: Room,
    emitters: Vec<Emitter>,
    landings: Vec<Landing>,
    settings: LightSettings,
    source_power: f64,
    root: StreamKey,
    machine: Machine,
}

impl LightTracer {
    /// - `seed`: streams are keyed by it, by the configuration's digest, and by nothing else
    pub fn new(configuration: &Configuration, settings: &LightSettings, seed: u64) -> LightTracer {
        let room = Room::new(configuration);
        let emitters = emitters(configuration, &room, settings.aim);
        let side = |n: usize| n.clamp(1, TexelGrid::MAX_SIDE);
        let grid = TexelGrid::new(side(settings.map[0]), side(settings.map[1])).expect("sides within their limits");
        let receiver = configuration.receiver().map(|receiver| *receiver.shape());
        let shapes = receiver.into_iter().chain(configuration.diffuse().iter().map(|surface| *surface.shape()));
        let landings = shapes.enumerate().map(|(k, shape)| Landing::new(&shape, grid, k * grid.n_texels())).collect();
        // Rings lie on the receiver.
        let rings = settings.rings.filter(|_| configuration.receiver().is_some());
        let tiles = settings.tiles.filter(|_| configuration.receiver().is_some());
        let mut source_power = Sum::default();
        emitters.iter().for_each(|emitter| source_power += emitter.power);
        LightTracer {
            room,
            emitters,
            landings,
            settings: LightSettings { rings, tiles, ..settings.clone() },
            source_power: source_power.value(),
            root: StreamKey::root(seed).with(configuration.digest().key()).with(PURPOSE),
            machine: Machine::new(),
        }
    }

    /// What all sources give out, W; each group of rays carries the same share of it.
    pub fn power(&self) -> f64 {
        self.source_power
    }

    /// Independent groups of rays that [`LightTracer::run`] sends.
    pub fn n_groups(&self) -> u64 {
        if self.emitters.is_empty() { 0 } else { self.settings.rays.max(1).div_ceil(self.rays_a_group()) }
    }

    fn rays_a_group(&self) -> u64 {
        self.emitters.iter().map(Emitter::rays_a_group).max().unwrap_or(1) as u64
    }

    /// Sends the rays. The same bytes on any number of threads.
    ///
    /// Rays leave in groups, each from one source, chosen with a probability of its power, and each group carries the same
    /// flux. Groups are independent and alike.
    pub fn run(&self) -> LightRun {
        let Ok(run) = self.run_while(&|_| Ok::<(), Infallible>(()));
        run
    }

    /// The same for who looks on.
    ///
    /// - `progress`: told the rays of each finished batch; where it errs, the run is given up
    pub(crate) fn run_while<E: Send>(&self, progress: &(dyn Fn(u64) -> Result<(), E> + Sync)) -> Result<LightRun, E> {
        let mut sum = self.sum();
        for k in 0..self.n_pieces() {
            sum.add(&self.piece(k, progress)?);
        }
        Ok(sum.finish())
    }

    fn groups_a_batch(&self) -> u64 {
        (RAYS_A_BATCH / self.rays_a_group()).max(1)
    }

    fn batches_a_piece(&self) -> u64 {
        let of_rays = |rays: u64| rays.div_ceil(self.groups_a_batch() * self.rays_a_group());
        let of_large = self.n_groups().div_ceil(self.groups_a_batch()).div_ceil(MOST_PIECES);
        of_rays(RAYS_A_PIECE).max(of_large).next_multiple_of(BATCHES_A_ROUND)
    }

    /// Pieces that the run consists of, fixed by its rays alone.
    pub(crate) fn n_pieces(&self) -> u64 {
        self.n_groups().div_ceil(self.groups_a_batch()).div_ceil(self.batches_a_piece())
    }

    /// Rays of a piece, about.
    pub(crate) fn rays_of_piece(&self, piece: u64) -> u64 {
        let rays = self.batches_a_piece() * self.groups_a_batch() * self.rays_a_group();
        rays.min((self.n_groups() * self.rays_a_group()).saturating_sub(piece * rays))
    }

    /// One piece; the same bytes on any number of threads.
    ///
    /// - `progress`: as for [`LightTracer::run_while`]
    pub(crate) fn piece<E: Send>(
        &self,
        piece: u64,
        progress: &(dyn Fn(u64) -> Result<(), E> + Sync),
    ) -> Result<LightPiece, E> {
        let (n_groups, groups_a_batch) = (self.n_groups(), self.groups_a_batch());
        let n_batches = n_groups.div_ceil(groups_a_batch);
        let batches = piece * self.batches_a_piece()..((piece + 1) * self.batches_a_piece()).min(n_batches);
        let tracer = Tracer::new(&self.room, &self.landings, &self.settings);
        let flux = self.source_power / n_groups as f64;
        let mut books = self.tally();
        let n_texels: usize = self.landings.iter().map(|landing| landing.grid.n_texels()).sum();
        let mut texels = vec![Moments::default(); 2 * n_texels];
        for first in batches.clone().step_by(BATCHES_A_ROUND as usize) {
            let end = (first + BATCHES_A_ROUND).min(batches.end);
            // No thread shall be idle for it.
            let abreast = ((end - first) / rayon::current_num_threads() as u64).clamp(1, ABREAST);
            let batch = |k: u64| {
                let groups = (n_groups - k * groups_a_batch).min(groups_a_batch);
                self.batch(&tracer, k, groups, flux)
            };
            let side_by_side = |k: u64| {
                progress(0)?;
                let from = first + k * abreast;
                let mut batches: Vec<Batch> = (from..(from + abreast).min(end)).map(batch).collect();
                // One source text, compiled for each instruction set and chosen at run time. Rust never fuses a
                // multiplication and an addition by itself, so the set changes the speed and no bit.
                self.machine.run(SideBySide(&mut batches));
                let tallies: Vec<Tally> = batches.into_iter().map(|batch| batch.tally).collect();
                progress(tallies.iter().map(|tally| tally.rays).sum())?;
                Ok(tallies)
            };
            let n_tasks = (end - first).div_ceil(abreast);
            let done: Vec<Vec<Tally>> = (0..n_tasks).into_par_iter().map(side_by_side).collect::<Result<_, E>>()?;
            for tally in done.iter().flatten() {
                books.merge(tally);
                for (cell, flux) in &tally.texels {
                    texels[*cell as usize].add(*flux);
                }
            }
        }
        let lit = texels.into_iter().enumerate().filter(|(_, left)| *left != Moments::default());
        Ok(LightPiece { books, texels: lit.map(|(cell, left)| (cell as u32, left)).collect() })
    }

    /// No piece yet.
    pub(crate) fn sum(&self) -> LightSum<'_> {
        LightSum { of: self, maps: self.landings.iter().map(TexelMap::new).collect(), total: self.tally() }
    }

    fn tally(&self) -> Tally {
        let n_rings = self.settings.rings.map_or(0, |rings| rings.count);
        let n_tiles = self.settings.tiles.map_or(0, TexelGrid::n_texels);
        Tally::new(self.room.n_maps(), self.settings.depth, [n_rings, n_tiles], self.room.n_optics())
    }

    fn batch<'a>(&'a self, tracer: &'a Tracer<'a>, batch: u64, groups: u64, flux: f64) -> Batch<'a> {
        Batch {
            of: self,
            tracer,
            groups,
            flux,
            draws: Draws::new(self.root.with(batch)),
            group: Group::default(),
            next: 0,
            ray: Ray::new(DVec3::ZERO, DVec3::Z, Start::Nowhere, None, 0.0),
            goes_on: false,
            faint: 0.0,
            branches: Vec::new(),
            tally: self.tally(),
        }
    }

    /// A source, with a probability of its share of the power.
    #[inline(always)]
    fn pick(&self, draws: &mut Draws) -> &Emitter {
        let (last, others) = self.emitters.split_last().expect("a batch has an emitter");
        if others.is_empty() {
            return last;
        }
        let mut left = draws.unit() * self.source_power;
        for emitter in others {
            if left < emitter.power {
                return emitter;
            }
            left -= emitter.power;
        }
        last
    }
}

impl LightSum<'_> {
    /// Whether what is said to be a piece of such a run has its shape.
    pub fn fits(&self, index: u64, piece: &LightPiece) -> bool {
        let n_texels: usize = self.of.landings.iter().map(|landing| landing.grid.n_texels()).sum();
        piece.books.groups == self.of.rays_of_piece(index) / self.of.rays_a_group()
            && self.total.is_alike(&piece.books)
            && piece.texels.iter().all(|(cell, _)| (*cell as usize) < 2 * n_texels)
    }

    /// The next piece.
    pub fn add(&mut self, piece: &LightPiece) {
        self.total.merge(&piece.books);
        let n_texels = self.of.landings.first().map_or(1, |landing| landing.grid.n_texels());
        for (cell, left) in &piece.texels {
            let (texel, light) = (*cell as usize / 2, *cell as usize % 2);
            self.maps[texel / n_texels].merge(texel % n_texels, light, left);
        }
    }

    /// After the last.
    pub fn finish(self) -> LightRun {
        let LightSum { of, mut maps, total } = self;
        maps.iter_mut().for_each(|map| map.close(total.groups));
        let ledger = Ledger {
            rays: total.rays,
            groups: total.groups,
            source_power: of.source_power,
            emitted: total.emitted.value(),
            deposited: total.deposited.watts(),
            deposited_std_error: total.deposited.std_error(total.groups),
            absorbed: total.absorbed.value(),
            escaped: total.escaped.value(),
            terminated: total.terminated.value(),
        };
        let rings =
            of.settings.rings.map(|rings| RingMap { rings, cells: total.rings.cells, n_groups: total.groups });
        let tiles = of.settings.tiles.map(|tiles| TileMap {
            parametrisation: of.landings[0].parametrisation,
            tiles,
            cells: total.tiles.cells,
            n_groups: total.groups,
        });
        LightRun {
            ledger,
            maps,
            rings,
            tiles,
            orders: total.orders.cells,
            depth: of.settings.depth,
            reached: total.reached,
            depolarised: total.depolarised,
            depolarised_flux: total.depolarised_flux.value(),
        }
    }
}

/// A batch on its way: group after group, ray after ray, branch after branch.
struct Batch<'a> {
    of: &'a LightTracer,
    tracer: &'a Tracer<'a>,
    /// Groups that are still to be sent, and the flux of each, W.
    groups: u64,
    flux: f64,
    draws: Draws,
    group: Group,
    /// The ray of the group that comes next.
    next: usize,
    /// The ray or branch under way, while it `goes_on`.
    ray: Ray,
    goes_on: bool,
    /// Flux below which it splits no further, W.
    faint: f64,
    /// Those that wait until it has ended.
    branches: Vec<Ray>,
    tally: Tally,
}

impl Batch<'_> {
    /// Follows one ray to its next meeting; whether there was one to follow.
    #[inline(always)]
    fn advance(&mut self) -> bool {
        if !self.goes_on && !self.start() {
            return false;
        }
        let Batch { ray, faint, branches, draws, tally, .. } = self;
        self.goes_on = self.tracer.step(ray, *faint, branches, draws, tally);
        if self.goes_on {
            return true;
        }
        if let Some(branch) = self.branches.pop() {
            (self.ray, self.goes_on) = (branch, true);
        } else if self.next == self.group.rays.len() {
            self.tally.settle();
        }
        true
    }

    /// Starts on the next ray; whether there is one.
    #[inline(always)]
    fn start(&mut self) -> bool {
        let Batch { of, group, draws, tally, .. } = self;
        if self.next == group.rays.len() {
            if self.groups == 0 {
                return false;
            }
            of.pick(draws).send(&of.room, self.flux, draws, group);
            (self.groups, self.next) = (self.groups - 1, 0);
        }
        self.ray = group.rays[self.next];
        self.next += 1;
        self.faint = self.ray.flux() * FAINT;
        tally.rays += 1;
        tally.emitted += self.ray.flux();
        true
    }
}

/// Batches that take turns, as a function that can be compiled for any instruction set.
struct SideBySide<'a, 'b>(&'a mut [Batch<'b>]);

impl Work for SideBySide<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, _: R) {
        let mut any = true;
        while any {
            any = false;
            for batch in &mut *self.0 {
                any |= batch.advance();
            }
        }
    }
}

/// Follows the light of a configuration from its sources.
///
/// - `seed`: other seeds give independent runs
pub fn trace(configuration: &Configuration, settings: &LightSettings, seed: u64) -> LightRun {
    LightTracer::new(configuration, settings, seed).run()
}
