//! How much light there is to be had: the most that one sample can bring, and all that the sources could send.

use std::f64::consts::PI;

use glam::DVec3;

use crate::configuration::{Configuration, MeasurementPoint, Source};
use crate::geometry::Shape;
use crate::oracle::{Oracle, Region, Truth};
use crate::sampling::Technique;

/// The sources' light at each point, W/m²: the unoccluded irradiance, and where the point's own horizon cuts a source
/// (which the unoccluded irradiance leaves out) that of an element at the same place turned to the sources' middle.
pub(super) fn full(configuration: &Configuration, oracle: &Oracle, truths: &[Truth]) -> Vec<f64> {
    let bounds = configuration.sources().iter().map(|source| source.shape().bounds());
    let (low, high) = bounds.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let middle = low * 0.5 + high * 0.5;
    configuration
        .points()
        .iter()
        .zip(truths)
        .map(|(point, truth)| {
            let unoccluded = truth.unoccluded_irradiance.watts_per_square_metre();
            let sunk = configuration.sources().iter().any(|source| lowest(source.shape(), point) < 0.0);
            if !sunk {
                return unoccluded;
            }
            // An element in the middle of its sources has no side to turn.
            let turned = MeasurementPoint::new(point.position(), middle - point.position());
            let facing = turned.map(|turned| oracle.at(&turned).unoccluded_irradiance.watts_per_square_metre());
            unoccluded.max(facing.unwrap_or(0.0))
        })
        .collect()
}

/// What a sample would bring were both its cosines one, W/m²: a cosine is off by roundings of one, not of itself, so where
/// light only grazes this is what roundings are relative to. Zero in the umbra, where no cosine counts: blocked is blocked.
///
/// - at most 10⁶ times the exitances, for points that a source may touch
pub(super) fn grazing(configuration: &Configuration, point: &MeasurementPoint, truth: &Truth) -> f64 {
    if truth.region == Region::Umbra {
        return 0.0;
    }
    let of_source = |source: &Source| {
        let (low, high) = source.shape().bounds();
        let x = point.position();
        let distance_squared = (low - x).max(x - high).max(DVec3::ZERO).length_squared();
        let share = source.shape().area() / (PI * distance_squared);
        source.exitance().watts_per_square_metre() * share.min(1e6)
    };
    configuration.sources().iter().map(of_source).sum()
}

/// Least height of a shape over a point's tangent plane, metres.
fn lowest(shape: &Shape, point: &MeasurementPoint) -> f64 {
    let height = |p: DVec3| (p - point.position()).dot(point.normal());
    let lowest_of = |points: &[DVec3]| points.iter().map(|p| height(*p)).fold(f64::INFINITY, f64::min);
    match shape {
        Shape::Disk(s) => {
            let cosine = s.normal().dot(point.normal());
            height(s.center()) - s.radius() * (1.0 - cosine * cosine).max(0.0).sqrt()
        }
        Shape::Sphere(s) => height(s.center()) - s.radius(),
        Shape::Rectangle(s) => lowest_of(&s.corners()),
        Shape::Polygon(s) => lowest_of(s.vertices()),
        Shape::Mesh(s) => lowest_of(s.vertices()),
    }
}

/// The most that one draw of a technique can bring (for techniques that draw on each source, one draw on each), W/m².
///
/// - by area: an upper bound of Σ_S A · M · cosθᵢ cosθₛ / (π r²) over the points of the sources. With d the distance to a
///   source and h the height over its plane, cosθₛ = h/r and r ≥ max(d, h), so the kernel is at most h / (π r³) for a flat
///   source and 1 / (π d²) for a sphere. Distances are to a box around the source, which can only be nearer. Infinite where
///   the point may touch that box and lies in the source's plane
/// - by solid angle: Σ_S M Ω/π. A source fills no more than 2π, and no more than A · max(cosθₛ/r²); the rectangle around a
///   disk no more than 4/π times the disk
/// - by cosine: the largest exitance
/// - by both: the lesser of the peak by area and M for each source, and the largest exitance
pub(super) fn peak(configuration: &Configuration, point: &MeasurementPoint, technique: Technique) -> f64 {
    let exitance = |source: &Source| source.largest_exitance().watts_per_square_metre();
    let sources = configuration.sources().iter();
    let largest = sources.clone().map(exitance).fold(0.0, f64::max);
    match technique {
        Technique::Area => sources.map(|source| peak_by_area(source, point)).sum(),
        Technique::SolidAngle => {
            sources.map(|source| (4.0 / PI * peak_by_area(source, point)).min(2.0 * exitance(source))).sum()
        }
        Technique::Cosine => largest,
        Technique::Mis(_) => {
            largest + sources.map(|source| peak_by_area(source, point).min(exitance(source))).sum::<f64>()
        }
    }
}

fn peak_by_area(source: &Source, point: &MeasurementPoint) -> f64 {
    let x = point.position();
    let (low, high) = source.shape().bounds();
    let to_box = (low - x).max(x - high).max(DVec3::ZERO).length();
    let height = |normal: DVec3, on_plane: DVec3| (x - on_plane).dot(normal);
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
    source.shape().area() * source.largest_exitance().watts_per_square_metre() * kernel
}

fn flat_ceiling(height: f64, to_box: f64) -> f64 {
    if height <= 0.0 {
        return 0.0;
    }
    let r = height.max(to_box);
    height / (PI * r * r * r)
}

#[cfg(feature = "studies")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::Arrangement;
    use crate::estimator::{Job, Scratch, for_technique};
    use crate::geometry::{Disk, Rectangle, Sphere};
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
            for strategy in [Strategy::Random, Strategy::SolidAngle, Strategy::Cosine, Strategy::MisBalance] {
                let technique = strategy.technique();
                let cell = StreamKey::root(5);
                let job = Job { strategy, samples: 1, cell, replicates: 0..4_000, points: room.points() };
                let mut estimates = vec![0.0; 4 * 4_000];
                for_technique(&room, technique).estimate(&job, &mut Scratch::default(), &mut estimates);
                for (point, row) in room.points().iter().zip(estimates.chunks_exact(4_000)) {
                    let largest = row.iter().copied().fold(0.0, f64::max);
                    let ceiling = peak(&room, point, technique);
                    assert!(largest <= ceiling, "{strategy}: {largest} above {ceiling}");
                    assert!(ceiling < 20.0 * largest, "{strategy}: {ceiling} is of the size of {largest}");
                }
            }
        }
    }
}
