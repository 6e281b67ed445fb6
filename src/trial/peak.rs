//! The most that one sample can bring: a rigorous ceiling for variances that a pilot cannot see.

use std::f64::consts::PI;

use crate::configuration::{Configuration, MeasurementPoint};
use crate::geometry::Shape;

/// An upper bound of Σ_S A · M · cosθᵢ cosθₛ / (π r²) over the points of the sources, W/m².
///
/// With d the distance to a source and h the height over its plane, cosθₛ = h/r and r ≥ max(d, h), so the kernel is at
/// most h / (π r³) for a flat source and 1 / (π d²) for a sphere. Distances are to a box around the source, which can
/// only be nearer. Infinite where the point may touch that box and lies in the source's plane.
pub(super) fn peak(configuration: &Configuration, point: &MeasurementPoint) -> f64 {
    let x = point.position();
    configuration
        .sources()
        .iter()
        .map(|source| {
            let (low, high) = source.shape().bounds();
            let to_box = (low - x).max(x - high).max(glam::DVec3::ZERO).length();
            let height = |normal: glam::DVec3, on_plane: glam::DVec3| (x - on_plane).dot(normal);
            let kernel = match source.shape() {
                Shape::Sphere(s) => {
                    let distance = (x - s.center()).length() - s.radius();
                    if distance > 0.0 { 1.0 / (PI * distance * distance) } else { 0.0 }
                }
                Shape::Disk(s) => flat_ceiling(height(s.normal(), s.center()), to_box),
                Shape::Rectangle(s) => flat_ceiling(height(s.normal(), s.center()), to_box),
                Shape::Polygon(s) => flat_ceiling(height(s.normal(), s.vertices()[0]), to_box),
                Shape::Mesh(_) => f64::INFINITY,
            };
            source.shape().area() * source.exitance().watts_per_square_metre() * kernel
        })
        .sum()
}

fn flat_ceiling(height: f64, to_box: f64) -> f64 {
    if height <= 0.0 {
        return 0.0;
    }
    let r = height.max(to_box);
    height / (PI * r * r * r)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Arrangement, Source};
    use crate::estimator::{AreaEstimator, Scratch};
    use crate::geometry::{DVec3, Disk, Rectangle, Sphere};
    use crate::radiometry::Exitance;
    use crate::sampling::{Strategy, StreamKey};

    #[test]
    fn no_single_sample_exceeds_the_peak() {
        let shapes = [
            Shape::Disk(Disk::new(DVec3::Z, DVec3::new(0.3, 0.0, -1.0), 0.7).unwrap()),
            Shape::Rectangle(Rectangle::new(DVec3::Z, DVec3::Y, DVec3::new(1.0, 0.0, 0.4)).unwrap()),
            Shape::Sphere(Sphere::new(DVec3::Z, 0.6).unwrap()),
        ];
        for shape in shapes {
            let source = Source::new(shape, Exitance::new(3.0)).unwrap();
            let at =
                |x: f64, z: f64| MeasurementPoint::new(DVec3::new(x, 0.1, z), DVec3::new(0.1, 0.2, 1.0)).unwrap();
            let points = vec![at(0.0, 0.0), at(0.5, 0.3), at(2.0, 0.2), at(0.2, -1.0)];
            let room = Configuration::new(vec![source], vec![], None, points, Arrangement::Scattered).unwrap();
            let estimator = AreaEstimator::new(&room);
            let (mut scratch, mut estimates) = (Scratch::default(), [0.0; 4]);
            let mut largest = [0.0_f64; 4];
            for replicate in 0..4_000 {
                let key = StreamKey::root(5);
                estimator.replicate(Strategy::Random, 1, key, replicate, room.points(), &mut scratch, &mut estimates);
                for (largest, estimate) in largest.iter_mut().zip(estimates) {
                    *largest = largest.max(estimate);
                }
            }
            for (point, largest) in room.points().iter().zip(largest) {
                let ceiling = peak(&room, point);
                assert!(largest <= ceiling, "{largest} above {ceiling}");
                assert!(ceiling < 20.0 * largest, "the ceiling {ceiling} is of the size of {largest}");
            }
        }
    }
}
