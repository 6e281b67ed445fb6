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

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use crate::configuration::{Configuration, MeasurementPoint};
use crate::geometry::Shape;
use crate::sampling::{
    BLOCK, LANES, Lanes, Pattern, Row, Squares, Strategy, StreamKey, Surface, SurfaceBlock, groups,
};
use crate::scene::{Blocker, ShadowRays};

/// Estimates irradiance at any point of a configuration.
pub struct AreaEstimator {
    emitters: Vec<Emitter>,
    arch: pulp::Arch,
}

/// A source, and what can come between it and a shading point.
struct Emitter {
    surface: Surface,
    /// Area × exitance / π, W/sr.
    strength: f64,
    blockers: Vec<Arc<Blocker>>,
}

/// Working memory of one thread; its size does not depend on the number of samples.
#[derive(Default)]
pub struct Scratch {
    squares: Squares,
    places: SurfaceBlock,
    shading: Shading,
    /// One sum of lanes for each point, where points are shared.
    sums: Vec<[f64; LANES]>,
}

/// Rays of one block from one point, and what each brings.
struct Shading {
    rays: ShadowRays,
    contributions: Row,
}

impl Default for Shading {
    fn default() -> Shading {
        Shading { rays: ShadowRays::default(), contributions: [[0.0; LANES]; BLOCK / LANES] }
    }
}

impl AreaEstimator {
    /// Prepares surfaces and hierarchies.
    pub fn new(configuration: &Configuration) -> AreaEstimator {
        let reach = reach(configuration);
        let blocker = |shape: &Shape| Arc::new(Blocker::new(shape, reach));
        let occluders: Vec<_> = configuration.occluders().iter().map(blocker).collect();
        let sources: Vec<_> = configuration.sources().iter().map(|source| blocker(source.shape())).collect();
        let emitters = configuration.sources().iter().enumerate().map(|(own, source)| {
            let surface = Surface::new(source.shape()).expect("a source is no mesh");
            // A source does not block itself: a flat one cannot, a sphere's far side is the cosine's business.
            let others = sources.iter().enumerate().filter(|(other, _)| *other != own).map(|(_, blocker)| blocker);
            Emitter {
                strength: surface.area() * source.exitance().watts_per_square_metre() / PI,
                surface,
                blockers: others.chain(&occluders).cloned().collect(),
            }
        });
        AreaEstimator { emitters: emitters.collect(), arch: pulp::Arch::new() }
    }

    /// Shadow rays of one estimate with `samples` points on each source.
    pub fn rays_per_estimate(&self, samples: u64) -> u64 {
        self.emitters.len() as u64 * samples
    }

    /// One replicate: an estimate of the irradiance at each point, W/m².
    ///
    /// - `cell`: key of this strategy and sample count ([`StreamKey::cell`]); replicate, point and source are absorbed
    ///   below it, the point only where points are fresh
    /// - `samples`: N ≥ 1 points on each source
    /// - `estimates`: as many as `points`
    pub fn replicate(
        &self,
        strategy: Strategy,
        samples: u64,
        cell: StreamKey,
        replicate: u64,
        points: &[MeasurementPoint],
        scratch: &mut Scratch,
        estimates: &mut [f64],
    ) {
        // One source text, compiled for each instruction set and chosen at run time. Rust never fuses a multiplication
        // and an addition by itself, so the set changes the speed and no bit.
        let Self { emitters, arch } = self;
        arch.dispatch(Replicate {
            emitters,
            strategy,
            samples,
            key: cell.with(replicate),
            points,
            scratch,
            estimates,
        });
    }
}

/// The arguments of one replicate, as a function that can be compiled for any instruction set.
struct Replicate<'a> {
    emitters: &'a [Emitter],
    strategy: Strategy,
    samples: u64,
    key: StreamKey,
    points: &'a [MeasurementPoint],
    scratch: &'a mut Scratch,
    estimates: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Replicate<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Replicate { emitters, strategy, samples, key, points, scratch, estimates } = self;
        estimates.fill(0.0);
        for (index, emitter) in emitters.iter().enumerate() {
            let pattern = |stream: u64| {
                let lanes = Lanes::new(key.with(stream).with(index as u64), samples.min(LANES as u64) as usize);
                Pattern::new(strategy, samples, lanes)
            };
            if strategy.shares_points() {
                emitter.add_shared(pattern(0), samples, points, scratch, estimates);
            } else {
                for (i, (point, estimate)) in points.iter().zip(estimates.iter_mut()).enumerate() {
                    *estimate += emitter.fresh(pattern(i as u64 + 1), samples, point, scratch);
                }
            }
        }
    }
}

impl Emitter {
    /// The estimate at one point from points of its own.
    #[inline(always)]
    fn fresh(&self, mut pattern: Pattern, samples: u64, point: &MeasurementPoint, scratch: &mut Scratch) -> f64 {
        let mut sum = [0.0; LANES];
        let mut left = samples;
        while left > 0 {
            let len = left.min(BLOCK as u64) as usize;
            pattern.fill(&mut scratch.squares, len);
            self.surface.place(&scratch.squares, len, &mut scratch.places);
            self.gather(point, &scratch.places, len, &mut scratch.shading, &mut sum);
            left -= len as u64;
        }
        self.strength * add_lanes(&sum) / samples as f64
    }

    /// The estimates at all points from one shared set of points.
    #[inline(always)]
    fn add_shared(
        &self,
        mut pattern: Pattern,
        samples: u64,
        points: &[MeasurementPoint],
        scratch: &mut Scratch,
        estimates: &mut [f64],
    ) {
        scratch.sums.clear();
        scratch.sums.resize(points.len(), [0.0; LANES]);
        let mut left = samples;
        while left > 0 {
            let len = left.min(BLOCK as u64) as usize;
            pattern.fill(&mut scratch.squares, len);
            self.surface.place(&scratch.squares, len, &mut scratch.places);
            for (point, sum) in points.iter().zip(&mut scratch.sums) {
                self.gather(point, &scratch.places, len, &mut scratch.shading, sum);
            }
            left -= len as u64;
        }
        for (estimate, sum) in estimates.iter_mut().zip(&scratch.sums) {
            *estimate += self.strength * add_lanes(sum) / samples as f64;
        }
    }

    /// Adds cosθᵢ cosθₛ / r² · Vis of one block of source points to the lanes of a sum.
    #[inline(always)]
    fn gather(
        &self,
        point: &MeasurementPoint,
        places: &SurfaceBlock,
        len: usize,
        shading: &mut Shading,
        sum: &mut [f64; LANES],
    ) {
        let offset = self.surface.origin() - point.position();
        let normal = point.normal();
        let Shading { rays, contributions } = shading;
        for g in 0..groups(len) {
            for l in 0..LANES {
                rays.x[g][l] = offset.x + places.x[g][l];
                rays.y[g][l] = offset.y + places.y[g][l];
                rays.z[g][l] = offset.z + places.z[g][l];
            }
        }
        if let Some(source_normal) = self.surface.flat_normal() {
            // r cosθₛ is the height of the point over the source's plane, the same for the whole source.
            let height = -offset.dot(source_normal);
            if height <= 0.0 {
                return;
            }
            for g in 0..groups(len) {
                for l in 0..LANES {
                    let d = rays.ray(g, l);
                    let r2 = d.length_squared();
                    contributions[g][l] = normal.dot(d).max(0.0) * height / (r2 * r2);
                }
            }
        } else if let Some(radius) = self.surface.sphere_radius() {
            for g in 0..groups(len) {
                for l in 0..LANES {
                    let d = rays.ray(g, l);
                    let r2 = d.length_squared();
                    // r cosθₛ with the sphere's normal at the point, its offset over the radius.
                    let height = -(places.x[g][l] * d.x + places.y[g][l] * d.y + places.z[g][l] * d.z) / radius;
                    contributions[g][l] = normal.dot(d).max(0.0) * height.max(0.0) / (r2 * r2);
                }
            }
        }
        if len % LANES != 0 {
            contributions[len / LANES][len % LANES..].fill(0.0);
        }
        for blocker in &self.blockers {
            blocker.shade(point.position(), rays, len, contributions);
        }
        for group in &contributions[..groups(len)] {
            for (sum, contribution) in sum.iter_mut().zip(group) {
                *sum += contribution;
            }
        }
    }
}

/// The lanes of a sum, added in a fixed order.
fn add_lanes(lanes: &[f64; LANES]) -> f64 {
    let [a, b, c, d, e, f, g, h] = *lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// A box that holds every shading point and every source: all ends of all shadow rays, metres.
fn reach(configuration: &Configuration) -> (DVec3, DVec3) {
    let mut reach = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for source in configuration.sources() {
        let (low, high) = source.shape().bounds();
        reach = (reach.0.min(low), reach.1.max(high));
    }
    for point in configuration.points() {
        reach = (reach.0.min(point.position()), reach.1.max(point.position()));
    }
    reach
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Arrangement, Source};
    use crate::geometry::{Disk, Rectangle, Sphere};
    use crate::radiometry::Exitance;

    fn over_the_origin(shape: Shape, occluders: Vec<Shape>) -> Configuration {
        let source = Source::new(shape, Exitance::new(2.0)).unwrap();
        let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
        Configuration::new(vec![source], occluders, None, vec![point], Arrangement::Scattered).unwrap()
    }

    /// Mean and standard error of replicates at the only point.
    fn measure(configuration: &Configuration, strategy: Strategy, samples: u64, replicates: u64) -> (f64, f64) {
        let estimator = AreaEstimator::new(configuration);
        let (mut scratch, mut out) = (Scratch::default(), [0.0]);
        let (mut sum, mut squares) = (0.0, 0.0);
        for replicate in 0..replicates {
            let key = StreamKey::root(77);
            estimator.replicate(strategy, samples, key, replicate, configuration.points(), &mut scratch, &mut out);
            sum += out[0];
            squares += out[0] * out[0];
        }
        let mean = sum / replicates as f64;
        (mean, ((squares / replicates as f64 - mean * mean) / replicates as f64).sqrt())
    }

    fn disk(z: f64, radius: f64) -> Shape {
        Shape::Disk(Disk::new(DVec3::Z * z, -DVec3::Z, radius).unwrap())
    }

    #[test]
    fn every_strategy_finds_the_coaxial_disk() {
        // R² / (R² + h²) with R = 1, h = 2: 1/5 of 2 W/m².
        let configuration = over_the_origin(disk(2.0, 1.0), vec![]);
        for strategy in Strategy::ALL {
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
        for strategy in Strategy::ALL {
            let mut out = [0.0; 2];
            estimator.replicate(
                strategy,
                16,
                StreamKey::root(1),
                0,
                twice.points(),
                &mut Scratch::default(),
                &mut out,
            );
            assert_eq!(out[0] == out[1], strategy.shares_points(), "{strategy}");
        }
    }
}
