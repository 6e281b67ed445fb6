//! Two ways of finding a disk source, mixed: places on the disk, and directions by the receiver's cosine that may or may not
//! find it. Veach's balance heuristic weighs each ray by its own density over the sum of both, taken in one measure; then
//! the weights of any one path add up to 1 and the mean is right.

use std::f64::consts::{PI, TAU};

use etendue::configuration::{Configuration, MeasurementPoint};
use etendue::estimator::{Estimator, Job, Scratch};
use etendue::geometry::{DVec3, Disk, Frame, Shape};
use etendue::sampling::Stream;
use rand::RngExt;

/// How the weights are formed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weights {
    /// Both densities per solid angle.
    Balance,
    /// A direction that found the source compares its density per solid angle with the other's per area.
    MeasuresMixed,
    /// Squares over squares on one side, the balance heuristic on the other.
    HeuristicsMixed,
}

/// One disk, nothing before it.
pub struct Mixed {
    disk: Disk,
    /// W/m².
    exitance: f64,
    weights: Weights,
}

impl Mixed {
    pub fn new(configuration: &Configuration, weights: Weights) -> Mixed {
        let [source] = configuration.sources() else { panic!("one source") };
        let Shape::Disk(disk) = source.shape() else { panic!("a disk") };
        assert!(configuration.occluders().is_empty());
        Mixed { disk: *disk, exitance: source.exitance().watts_per_square_metre(), weights }
    }

    /// One ray of each kind.
    fn pair(&self, point: &MeasurementPoint, stream: &mut Stream) -> f64 {
        let mut next = || stream.random::<f64>();
        let in_disk = |[u, v]: [f64; 2]| [u.sqrt() * (TAU * v).cos(), u.sqrt() * (TAU * v).sin()];
        let frame = Frame::around(self.disk.normal());
        let [x, y] = in_disk([next(), next()]);
        let at = self.disk.center() + (frame.tangent * x + frame.bitangent * y) * self.disk.radius();
        let by_area = self.brought(point, at - point.position(), true);
        // Malley: a point of the disk, lifted to the hemisphere.
        let [x, y] = in_disk([next(), next()]);
        let frame = Frame::around(point.normal());
        let direction =
            frame.tangent * x + frame.bitangent * y + point.normal() * (1.0 - x * x - y * y).max(0.0).sqrt();
        let t = (self.disk.center() - point.position()).dot(self.disk.normal()) / direction.dot(self.disk.normal());
        let found = t > 0.0 && (point.position() + direction * t - self.disk.center()).length() < self.disk.radius();
        let by_cosine = if found { self.brought(point, direction * t, false) } else { 0.0 };
        by_area + by_cosine
    }

    /// Weight × radiance × cosine / density, for a ray that ends on the disk.
    fn brought(&self, point: &MeasurementPoint, ray: DVec3, by_area: bool) -> f64 {
        let r = ray.length();
        let (arriving, leaving) = (point.normal().dot(ray) / r, -self.disk.normal().dot(ray) / r);
        if arriving <= 0.0 || leaving <= 0.0 {
            return 0.0;
        }
        let per_area = 1.0 / self.disk.area();
        let area_per_solid_angle = per_area * r * r / leaving;
        let cosine_per_solid_angle = arriving / PI;
        let (own, mut other) = if by_area {
            (area_per_solid_angle, cosine_per_solid_angle)
        } else {
            (cosine_per_solid_angle, area_per_solid_angle)
        };
        if self.weights == Weights::MeasuresMixed && !by_area {
            other = per_area;
        }
        let weight = if self.weights == Weights::HeuristicsMixed && by_area {
            own * own / (own * own + other * other)
        } else {
            own / (own + other)
        };
        weight * self.exitance / PI * arriving / own
    }
}

impl Estimator for Mixed {
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        2 * samples
    }

    fn estimate(&self, job: &Job, _: &mut Scratch, estimates: &mut [f64]) {
        let replicates = (job.replicates.end - job.replicates.start) as usize;
        for (p, point) in job.points.iter().enumerate() {
            for (r, replicate) in job.replicates.clone().enumerate() {
                let mut stream = Stream::new(job.cell.with(replicate).with(p as u64 + 1).with(0));
                let sum: f64 = (0..job.samples).map(|_| self.pair(point, &mut stream)).sum();
                estimates[p * replicates + r] = sum / job.samples as f64;
            }
        }
    }
}
