//! Sampling by area: the lecture's estimator.
//!
//! For each source S of exitance M and area A, with N points u_k uniform by area (N strata, or one shared set),
//!
//! ```text
//! E(x) ≈ Σ_S (1/N) Σ_k  A · M · cosθᵢ cosθₛ / (π r²) · Vis(x, u_k)      r = |u_k − x|
//! ```
//!
//! Everything is f64. Sample k adds to lane k mod 8; the lanes are added pairwise at the end, so that the sum does not
//! depend on the width of the instruction set.

use std::num::NonZero;

use super::between::VisibilityMaps;
use super::emitter::{Block, Emitter, Scratch, add_lanes, emitters};
use super::{Estimator, Job};
use crate::configuration::Configuration;
use crate::number::Machine;
use crate::sampling::{BLOCK, LANES, Lanes, Pattern, Squares, Strategy, StreamKey, SurfaceBlock, fill_side_by_side};
use crate::scene::Surroundings;

/// Estimates irradiance at any point of a configuration.
pub struct AreaEstimator {
    emitters: Vec<Emitter>,
    machine: Machine,
}

impl AreaEstimator {
    /// Prepares surfaces and hierarchies.
    pub fn new(configuration: &Configuration) -> AreaEstimator {
        let emitters = emitters(configuration, &Surroundings::new(configuration));
        AreaEstimator { emitters, machine: Machine::new() }
    }
}

impl Estimator for AreaEstimator {
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        self.emitters.len() as u64 * samples
    }

    fn estimate(&self, job: &Job, scratch: &mut Scratch, estimates: &mut [f64]) {
        estimates.fill(0.0);
        let Some(stride) = NonZero::new((job.replicates.end - job.replicates.start) as usize) else { return };
        for (index, emitter) in self.emitters.iter().enumerate() {
            let place = Place { machine: self.machine, emitter, source: index as u64, stride: stride.get() };
            // Small estimates fill a block only together.
            match job.samples {
                1 => place.several_at_once::<1>(job, scratch, estimates),
                2 => place.several_at_once::<2>(job, scratch, estimates),
                4 => place.several_at_once::<4>(job, scratch, estimates),
                8 => place.several_at_once::<8>(job, scratch, estimates),
                _ => place.one_by_one(job, scratch, estimates),
            }
        }
    }
}

/// One source's part of a job.
struct Place<'a> {
    /// Blocks of samples are worked on in its registers, by one text compiled for each instruction set: that changes the
    /// speed and no bit.
    machine: Machine,
    emitter: &'a Emitter,
    source: u64,
    /// Replicates of the job.
    stride: usize,
}

impl Place<'_> {
    /// The points of one estimate; `point` counted from 1, 0 where points are shared.
    fn pattern(&self, job: &Job, replicate: u64, point: u64) -> Pattern {
        let key = job.cell.with(replicate).with(point).with(self.source);
        let lanes = Lanes::new_on(self.machine, key, job.samples.min(LANES as u64) as usize);
        Pattern::new(job.strategy, job.samples, lanes)
    }

    fn one_by_one(&self, job: &Job, scratch: &mut Scratch, estimates: &mut [f64]) {
        if job.strategy.shares_points() {
            self.shared(job, scratch, estimates);
        } else {
            self.fresh(job, scratch, estimates);
        }
    }

    /// Points of its own for each shading point.
    fn fresh(&self, job: &Job, scratch: &mut Scratch, estimates: &mut [f64]) {
        let Scratch { squares, places, shading, .. } = scratch;
        let rays = job.samples * self.stride as u64;
        for (p, point) in job.points.iter().enumerate() {
            let visibilities = self.emitter.between.visibilities(self.machine, point.position(), rays);
            for (r, replicate) in job.replicates.clone().enumerate() {
                let mut pattern = self.pattern(job, replicate, p as u64 + 1);
                let mut sum = [0.0; LANES];
                let mut left = job.samples;
                while left > 0 {
                    let len = left.min(BLOCK as u64) as usize;
                    pattern.fill_on(self.machine, squares, len);
                    self.emitter.place(self.machine, squares, len, places);
                    let block = Block { places, exitances: None, visibilities: &visibilities, len, shading };
                    self.emitter.gather(self.machine, point, block, &mut sum);
                    left -= len as u64;
                }
                estimates[p * self.stride + r] += self.emitter.strength * add_lanes(&sum) / job.samples as f64;
            }
        }
    }

    /// One set of points for all shading points of a replicate.
    fn shared(&self, job: &Job, scratch: &mut Scratch, estimates: &mut [f64]) {
        let Scratch { squares, places, exitances, shading, sums, .. } = scratch;
        let rays = job.samples * self.stride as u64;
        let visibilities: Vec<VisibilityMaps> = job
            .points
            .iter()
            .map(|point| self.emitter.between.visibilities(self.machine, point.position(), rays))
            .collect();
        for (r, replicate) in job.replicates.clone().enumerate() {
            let mut pattern = self.pattern(job, replicate, 0);
            sums.clear();
            sums.resize(job.points.len(), [0.0; LANES]);
            let mut left = job.samples;
            while left > 0 {
                let len = left.min(BLOCK as u64) as usize;
                pattern.fill_on(self.machine, squares, len);
                self.emitter.place(self.machine, squares, len, places);
                self.emitter.read(places, len, exitances);
                for ((point, visibilities), sum) in job.points.iter().zip(&visibilities).zip(sums.iter_mut()) {
                    let block = Block { places, exitances: Some(exitances), visibilities, len, shading };
                    self.emitter.gather(self.machine, point, block, sum);
                }
                left -= len as u64;
            }
            for (p, sum) in sums.iter().enumerate() {
                estimates[p * self.stride + r] += self.emitter.strength * add_lanes(sum) / job.samples as f64;
            }
        }
    }

    /// Points of small estimates, side by side; `point` as in [`Place::pattern`].
    fn scatter<const N: usize>(
        &self,
        strategy: Strategy,
        keys: &[StreamKey],
        point: u64,
        squares: &mut Squares,
        places: &mut SurfaceBlock,
    ) {
        fill_side_by_side(self.machine, strategy, N, keys, [point, self.source], squares);
        self.emitter.place(self.machine, squares, N * keys.len(), places);
    }

    /// As many replicates of a small estimate as a block holds, side by side: the same numbers, bit for bit, as one by
    /// one, without the empty lanes.
    fn several_at_once<const N: usize>(&self, job: &Job, scratch: &mut Scratch, estimates: &mut [f64]) {
        let Scratch { squares, places, exitances, shading, keys, .. } = scratch;
        for start in (0..self.stride).step_by(BLOCK / N) {
            let count = (self.stride - start).min(BLOCK / N);
            let first = job.replicates.start + start as u64;
            keys.clear();
            keys.extend((first..first + count as u64).map(|replicate| job.cell.with(replicate)));
            if job.strategy.shares_points() {
                self.scatter::<N>(job.strategy, keys, 0, squares, places);
                self.emitter.read(places, N * count, exitances);
            }
            for (p, point) in job.points.iter().enumerate() {
                if !job.strategy.shares_points() {
                    self.scatter::<N>(job.strategy, keys, p as u64 + 1, squares, places);
                }
                let visibilities =
                    self.emitter.between.visibilities(self.machine, point.position(), (N * count) as u64);
                self.emitter.illuminate(self.machine, point, places, &visibilities, N * count, shading);
                if job.strategy.shares_points() {
                    self.emitter.weigh_by(self.machine, exitances, N * count, shading);
                } else {
                    self.emitter.weigh(places, N * count, shading);
                }
                let row = &mut estimates[p * self.stride + start..][..count];
                let (contributions, _) = shading.contributions.as_flattened().as_chunks::<N>();
                for (estimate, lanes) in row.iter_mut().zip(contributions) {
                    let sum: [f64; LANES] = std::array::from_fn(|lane| if lane < N { lanes[lane] } else { 0.0 });
                    *estimate += self.emitter.strength * add_lanes(&sum) / N as f64;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Arrangement, MeasurementPoint, Source};
    use crate::geometry::{DVec3, Disk, Mesh, Rectangle, Shape, Sphere};
    use crate::radiometry::Exitance;
    use crate::sampling::{Strategy, Technique};

    fn over_the_origin(shape: Shape, occluders: Vec<Shape>) -> Configuration {
        let source = Source::new(shape, Exitance::new(2.0)).unwrap();
        let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
        Configuration::new(vec![source], occluders, None, vec![point], Arrangement::Scattered).unwrap()
    }

    /// Mean and standard error of replicates at the only point.
    fn measure(configuration: &Configuration, strategy: Strategy, samples: u64, replicates: u64) -> (f64, f64) {
        let estimator = AreaEstimator::new(configuration);
        let points = configuration.points();
        let job = Job { strategy, samples, cell: StreamKey::root(77), replicates: 0..replicates, points };
        let mut out = vec![0.0; replicates as usize];
        estimator.estimate(&job, &mut Scratch::default(), &mut out);
        let (sum, squares) = out.iter().fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
        let mean = sum / replicates as f64;
        (mean, ((squares / replicates as f64 - mean * mean) / replicates as f64).sqrt())
    }

    fn by_area() -> impl Iterator<Item = Strategy> {
        Strategy::ALL.into_iter().filter(|strategy| strategy.technique() == Technique::Area)
    }

    fn disk(z: f64, radius: f64) -> Shape {
        Shape::Disk(Disk::new(DVec3::Z * z, -DVec3::Z, radius).unwrap())
    }

    #[test]
    fn every_strategy_finds_the_coaxial_disk() {
        // R² / (R² + h²) with R = 1, h = 2: 1/5 of 2 W/m².
        let configuration = over_the_origin(disk(2.0, 1.0), vec![]);
        for strategy in by_area() {
            for samples in [1, 7, 64, 200] {
                let (mean, error) = measure(&configuration, strategy, samples, 2_000);
                assert!((mean - 0.4).abs() < 6.0 * error, "{strategy} N = {samples}: {mean} ± {error}");
            }
        }
    }

    #[test]
    fn a_coaxial_occluder_takes_its_own_share() {
        // From the origin a disk of radius ¼ at height 1 hides a disk of radius ½ at height 2: 1/5 − 1/17.
        let configuration = over_the_origin(disk(2.0, 1.0), vec![disk(1.0, 0.25)]);
        let (mean, error) = measure(&configuration, Strategy::Stratified, 256, 2_000);
        assert!((mean - 2.0 * (1.0 / 5.0 - 1.0 / 17.0)).abs() < 6.0 * error, "{mean} ± {error}");
    }

    #[test]
    fn a_sphere_is_its_silhouette() {
        // (R/d)² with R = 1, d = 2.
        let ball = Shape::Sphere(Sphere::new(DVec3::Z * 2.0, 1.0).unwrap());
        let (mean, error) = measure(&over_the_origin(ball, vec![]), Strategy::Stratified, 256, 2_000);
        assert!((mean - 0.5).abs() < 6.0 * error, "{mean} ± {error}");
    }

    #[test]
    fn nothing_arrives_behind_a_cover_or_from_the_dark_side() {
        let cover = Rectangle::new(DVec3::Z, DVec3::X * 9.0, DVec3::Y * 9.0).unwrap();
        let covered = over_the_origin(disk(2.0, 1.0), vec![Shape::Rectangle(cover)]);
        let turned = Shape::Disk(Disk::new(DVec3::Z * 2.0, DVec3::Z, 1.0).unwrap());
        for configuration in [covered, over_the_origin(turned, vec![])] {
            assert_eq!(measure(&configuration, Strategy::Random, 64, 50).0, 0.0);
        }
    }

    #[test]
    fn shared_points_are_shared_and_fresh_points_are_not() {
        let source = Source::new(disk(2.0, 1.0), Exitance::new(1.0)).unwrap();
        let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
        let twice =
            Configuration::new(vec![source], vec![], None, vec![point, point], Arrangement::Scattered).unwrap();
        let estimator = AreaEstimator::new(&twice);
        for strategy in by_area() {
            let mut out = [0.0; 2];
            let job =
                Job { strategy, samples: 16, cell: StreamKey::root(1), replicates: 0..1, points: twice.points() };
            estimator.estimate(&job, &mut Scratch::default(), &mut out);
            assert_eq!(out[0] == out[1], strategy.shares_points(), "{strategy}");
        }
    }

    #[test]
    fn instruction_sets_move_no_bit() {
        for strategy in by_area() {
            crate::estimator::tests::same_bits(strategy, |room, machine| AreaEstimator {
                machine,
                ..AreaEstimator::new(room)
            });
        }
    }

    #[test]
    fn replicates_that_see_a_mesh_together_are_those_one_by_one_bit_for_bit() {
        // Together they look for its silhouette; of one alone the rays are too few for that.
        let plate = Rectangle::new(DVec3::new(0.1, 0.2, 1.0), DVec3::X * 0.6, DVec3::new(0.0, 0.5, 0.1)).unwrap();
        let corners = plate.corners().to_vec();
        let mesh = Shape::Mesh(Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap().subdivided(5));
        let ball = Shape::Sphere(Sphere::new(DVec3::new(0.2, 0.1, 2.0), 0.6).unwrap());
        for (source, strategies) in [(disk(2.0, 0.8), Strategy::ALL), (ball, Strategy::ALL)] {
            let room = over_the_origin(source, vec![mesh.clone()]);
            for strategy in strategies {
                let estimator = super::super::for_technique(&room, strategy.technique());
                let all =
                    Job { strategy, samples: 49, cell: StreamKey::root(9), replicates: 3..53, points: room.points() };
                let mut together = vec![0.0; 50];
                estimator.estimate(&all, &mut Scratch::default(), &mut together);
                assert!(together.iter().sum::<f64>() > 0.0);
                for (r, together) in together.iter().enumerate() {
                    let mut alone = [0.0];
                    let one = Job { replicates: 3 + r as u64..4 + r as u64, ..all.clone() };
                    // An estimator of its own, which has sent too few rays to know anything yet.
                    let estimator = super::super::for_technique(&room, strategy.technique());
                    estimator.estimate(&one, &mut Scratch::default(), &mut alone);
                    assert_eq!(alone[0].to_bits(), together.to_bits(), "{strategy} replicate {r}");
                }
            }
        }
    }

    #[test]
    fn estimates_side_by_side_are_those_one_by_one_bit_for_bit() {
        let ball = Shape::Sphere(Sphere::new(DVec3::new(0.2, 0.1, 2.0), 0.6).unwrap());
        let room = over_the_origin(ball, vec![disk(1.0, 0.25)]);
        let estimator = AreaEstimator::new(&room);
        for strategy in by_area() {
            for samples in [1, 2, 4, 8] {
                let cell = StreamKey::root(9);
                let all = Job { strategy, samples, cell, replicates: 5..305, points: room.points() };
                let mut together = vec![0.0; 300];
                estimator.estimate(&all, &mut Scratch::default(), &mut together);
                let mut scratch = Scratch::default();
                for (r, together) in together.iter().enumerate() {
                    let one = Job { replicates: 5 + r as u64..6 + r as u64, ..all.clone() };
                    let mut alone = [0.0];
                    let place =
                        Place { machine: Machine::Any, emitter: &estimator.emitters[0], source: 0, stride: 1 };
                    place.one_by_one(&one, &mut scratch, &mut alone);
                    assert_eq!(alone[0].to_bits(), together.to_bits(), "{strategy} N = {samples} replicate {r}");
                }
            }
        }
    }
}
