//! What a pixel records: the mean of the exact irradiance over its footprint, and what of the sources the footprint sees.
//!
//! Where everything in a footprint sees the sources in the same way the field is analytic, and nine Gauss points do; what
//! they miss is told by a rule of a lower degree. Where a shadow edge crosses it, the adaptive average of this room takes
//! over.
//!
//! Limit: as for [`average_irradiance`], a shadow that meets no node and no point of the outline is not seen.

use glam::DVec3;

use super::average::{Average, Tolerance, average_irradiance};
use super::surface::Patch;
use crate::configuration::MeasurementPoint;
use crate::geometry::Rectangle;
use crate::oracle::exact::{self, Oracle};
use crate::oracle::{Region, Truth};
use crate::radiometry::Irradiance;

/// A footprint as nine points and its outline see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// By nine points; its bound is what a rule of the third degree differs by, and says nothing where `is_crossed`.
    pub average: Average,
    /// In the middle, W/m².
    pub middle: Irradiance,
    /// In the middle, without occluders, W/m².
    pub unoccluded: Irradiance,
    /// What every point of it sees, and of its surroundings as far as the margin; `None` where they differ.
    pub region: Option<Region>,
    /// The least and the most that any of the points sees, W/m².
    pub range: [Irradiance; 2],
    /// Whether some curve along which the field is not analytic runs through it.
    pub is_crossed: bool,
}

/// Gauss's three points on [−1, 1], and their weights, halved (Abramowitz & Stegun 1964, table 25.4).
const GAUSS_3: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 18.0), (0.0, 4.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 18.0)];

/// A first look at a footprint.
///
/// - `margin`: metres around it within which nothing else may be seen, for it to belong to a region
/// - error: `average.bound` is the difference between rules of the fifth and of the third degree, so it is cautious
pub fn footprint(oracle: &Oracle, pixel: &Rectangle, margin: f64) -> Footprint {
    let (half_u, half_v) = (pixel.edge_u() * 0.5, pixel.edge_v() * 0.5);
    let mut met = Met::new(oracle, pixel.normal());
    let (mut mean, mut own_bound) = (0.0, 0.0);
    let mut middle = None;
    for (s, weight_s) in GAUSS_3 {
        for (t, weight_t) in GAUSS_3 {
            let Some(truth) = met.at(pixel.center() + half_u * s + half_v * t) else { continue };
            mean += weight_s * weight_t * truth.irradiance.watts_per_square_metre();
            own_bound += weight_s * weight_t * truth.bound.watts_per_square_metre();
            if s == 0.0 && t == 0.0 {
                middle = Some(truth);
            }
        }
    }
    // The outline lies a margin outside: a = 1 + margin / half.
    let reach = [half_u, half_v].map(|half| 1.0 + margin / half.length());
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[s, t]| met.at(pixel.center() + half_u * (s * reach[0]) + half_v * (t * reach[1])));
    let value = |truth: &Option<Truth>| truth.map_or(0.0, |truth| truth.irradiance.watts_per_square_metre());
    let centre = value(&middle);
    // Exact for third degree: the middle and the corners at (±a, ±b); with a ≠ b nearly so.
    let share = 1.0 / (12.0 * reach[0] * reach[1]);
    let cruder = (1.0 - 4.0 * share) * centre + share * corners.iter().map(value).sum::<f64>();
    if met.is_dark() {
        met.along_outline(pixel, half_u * reach[0], half_v * reach[1], margin);
    }
    let irradiance = |x: f64| Irradiance::new(x);
    Footprint {
        average: Average {
            irradiance: irradiance(mean),
            bound: irradiance((mean - cruder).abs() + own_bound),
            evaluations: met.evaluations,
        },
        middle: irradiance(centre),
        unoccluded: middle.map_or(irradiance(0.0), |truth| truth.unoccluded_irradiance),
        region: met.region.flatten(),
        range: met.range.map(irradiance),
        is_crossed: met.is_crossed,
    }
}

/// The mean over a footprint that is crossed, or that nine points do not do for.
pub fn footprint_average(oracle: &Oracle, pixel: &Rectangle, tolerance: Tolerance) -> Average {
    average_irradiance(oracle, &Patch::Rectangle(*pixel), tolerance)
}

/// What has been met so far.
struct Met<'a> {
    oracle: &'a Oracle,
    normal: DVec3,
    kind: Option<u64>,
    /// `None` before the first point; then `None` where they differ.
    region: Option<Option<Region>>,
    range: [f64; 2],
    is_crossed: bool,
    evaluations: u64,
}

impl Met<'_> {
    fn new(oracle: &Oracle, normal: DVec3) -> Met<'_> {
        let range = [f64::INFINITY, 0.0];
        Met { oracle, normal, kind: None, region: None, range, is_crossed: false, evaluations: 0 }
    }

    fn at(&mut self, position: DVec3) -> Option<Truth> {
        self.evaluations += 1;
        let point = MeasurementPoint::new(position, self.normal).ok()?;
        let seen = self.oracle.seen(&point);
        let truth = self.oracle.together(&seen);
        let kind = exact::topology(&seen);
        self.is_crossed |= *self.kind.get_or_insert(kind) != kind;
        // What cannot be told lies on an edge.
        let region = Some(truth.region).filter(|region| *region != Region::Edge);
        let known = self.region.get_or_insert(region);
        if *known != region {
            *known = None;
        }
        let value = truth.irradiance.watts_per_square_metre();
        self.range = [self.range[0].min(value), self.range[1].max(value)];
        Some(truth)
    }

    fn is_dark(&self) -> bool {
        self.region == Some(Some(Region::Umbra))
    }

    /// Where no light is due one ray is too many: the outline is looked at so closely that no shadow edge as round as the
    /// footprint can bulge in by more than the margin unseen. A chord c of a circle of radius R ≥ c has a sagitta of about
    /// c² / 8R.
    fn along_outline(&mut self, pixel: &Rectangle, half_u: DVec3, half_v: DVec3, margin: f64) {
        for (corner, side) in [
            (-half_u - half_v, half_u),
            (half_u - half_v, half_v),
            (half_u + half_v, -half_u),
            (-half_u + half_v, -half_v),
        ] {
            let pieces = (2.0 * side.length() / (8.0 * margin)).sqrt().ceil().clamp(4.0, 64.0) as u32;
            for i in 1..pieces {
                if !self.is_dark() {
                    return;
                }
                self.at(pixel.center() + corner + side * (2.0 * f64::from(i) / f64::from(pieces)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Arrangement, Configuration, Source};
    use crate::geometry::{Disk, Shape};
    use crate::radiometry::Exitance;

    fn eclipse(with_occluder: bool) -> Oracle {
        let disk = |z: f64, radius: f64| Shape::Disk(Disk::new(DVec3::Z * z, -DVec3::Z, radius).unwrap());
        let source = Source::new(disk(2.0, 0.5), Exitance::new(1.0)).unwrap();
        let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
        let occluders = if with_occluder { vec![disk(1.0, 0.35)] } else { vec![] };
        Oracle::new(&Configuration::new(vec![source], occluders, None, vec![point], Arrangement::Scattered).unwrap())
    }

    fn pixel(x: f64, width: f64) -> Rectangle {
        Rectangle::new(DVec3::X * x, DVec3::X * width, DVec3::Y * width).unwrap()
    }

    #[test]
    fn smooth_footprints_are_within_their_bounds() {
        let oracle = eclipse(false);
        for (x, width) in [(0.0, 0.02), (0.3, 0.1), (0.7, 0.42), (2.0, 1.0)] {
            let found = footprint(&oracle, &pixel(x, width), 1e-4);
            let exact = footprint_average(&oracle, &pixel(x, width), Tolerance::relative(1e-11));
            let off =
                (found.average.irradiance.watts_per_square_metre() - exact.irradiance.watts_per_square_metre()).abs();
            assert!(off <= found.average.bound.watts_per_square_metre(), "{x} {width}: {off:e} {found:?}");
            assert!(!found.is_crossed && found.region == Some(Region::Lit));
        }
    }

    /// Umbra up to 0.2 m, penumbra up to 1.2 m: a footprint belongs to a region only with all of its margin.
    #[test]
    fn regions_are_told_apart_from_edges() {
        let oracle = eclipse(true);
        let region = |x: f64, margin: f64| footprint(&oracle, &pixel(x, 0.1), margin).region;
        assert_eq!(region(0.0, 1e-3), Some(Region::Umbra));
        // Its right corners at (0.19, 0.05) lie within 0.2 m; the middle of that side is nearer than they are.
        assert_eq!(region(0.14, 1e-4), Some(Region::Umbra));
        assert_eq!((region(0.149, 1e-4), region(0.14, 0.01)), (None, None));
        assert_eq!((region(0.2, 1e-4), region(0.7, 1e-4)), (None, Some(Region::Penumbra)));
        assert_eq!((region(1.2, 1e-4), region(1.4, 1e-4)), (None, Some(Region::Lit)));
        let dark = footprint(&oracle, &pixel(0.0, 0.1), 1e-3);
        assert_eq!(
            (dark.average.irradiance.watts_per_square_metre(), dark.average.bound.watts_per_square_metre()),
            (0.0, 0.0)
        );
    }
}
