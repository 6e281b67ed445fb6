//! How pixels spread: measured between the images and pooled over neighbours of the same region, or stated by the file.
//!
//! K images alone say little of one pixel's spread, and nothing of a tail that none of them has met: a pixel deep in a
//! penumbra where one ray in a thousand arrives. Where the fourth moments of a neighbourhood say that fewer than thirty
//! events made its spread, what independent samples could have stands in: no more than the largest contribution times the
//! mean, over the samples of a pixel.

use super::Data;
use super::exact::PixelTruth;
use crate::configuration::{Configuration, MeasurementPoint};
use crate::external::PixelGrid;
use crate::oracle::Region;
use crate::sampling::Technique;
use crate::trial::reach::peak;

/// Variances of a pixel of one image, (W/m²)².
pub(super) struct Variances {
    /// As measured, or stated.
    pub plain: Vec<f64>,
    /// Two standard errors higher; what cannot be told from the images included.
    pub high: Vec<f64>,
}

/// Squares that a neighbourhood adds up, at least, where there are so many.
const OBSERVATIONS: usize = 240;
/// Pixels from its middle that a neighbourhood reaches, at most.
const FARTHEST: usize = 8;
/// With fewer events a variance is no more than a guess.
const FEWEST_EVENTS: f64 = 30.0;

/// What the variance of a pixel of one image can be at most, if its samples are independent, each a point on a source by
/// area or a direction: (largest contribution) · (what is due) / N, (W/m²)².
pub(super) fn ceilings(
    configuration: &Configuration,
    grid: &PixelGrid,
    truths: &[PixelTruth],
    samples: u64,
) -> Vec<f64> {
    let largest = configuration.sources().iter().map(|source| source.largest_exitance().watts_per_square_metre());
    let largest = largest.fold(0.0, f64::max);
    let of_pixel = |(p, truth): (usize, &PixelTruth)| {
        let normal = grid.footprint(grid.place(p)).map(|footprint| footprint.normal());
        let point = normal.and_then(|normal| MeasurementPoint::new(grid.middle(grid.place(p)), normal).ok());
        let by_area = point.map(|point| peak(configuration, &point, Technique::Area)).filter(|peak| peak.is_finite());
        let due = truth.irradiance + truth.bound + truth.shifted;
        by_area.unwrap_or(largest).max(largest) * due / samples as f64
    };
    truths.iter().enumerate().map(of_pixel).collect()
}

/// Of every pixel. `[row][column]`.
///
/// - `ceilings`: what stands in where too little was seen
pub(super) fn variances(data: &Data, truths: &[PixelTruth], ceilings: &[f64]) -> Variances {
    if let Some(stated) = &data.stated_variance {
        return Variances { plain: stated.clone(), high: stated.clone() };
    }
    let reach = reach(data.n_images);
    let (mut plain, mut high) = (Vec::with_capacity(data.n_pixels()), Vec::with_capacity(data.n_pixels()));
    for p in 0..data.n_pixels() {
        let truth = &truths[p];
        let dark = matches!(truth.region, Some(Region::Umbra | Region::BelowHorizon));
        let pool = Pool::around(data, truths, p, reach);
        let measured = pool.variance();
        plain.push(measured);
        high.push(if dark && truth.irradiance == 0.0 {
            // Where no light is due none may come: no spread excuses it.
            0.0
        } else if truth.region == Some(Region::Lit) || pool.events() >= FEWEST_EVENTS {
            pool.high()
        } else {
            pool.high().max(ceilings[p])
        });
    }
    Variances { plain, high }
}

/// As few pixels to each side as hold enough squares.
fn reach(n_images: usize) -> usize {
    let freedom = n_images.saturating_sub(1).max(1);
    (0..FARTHEST).find(|reach| (2 * reach + 1).pow(2) * freedom >= OBSERVATIONS).unwrap_or(FARTHEST)
}

/// The pixels up to `reach` to each side of one, itself included.
fn around(grid: &PixelGrid, p: usize, reach: usize) -> impl Iterator<Item = usize> {
    let ([column, row], width) = (grid.place(p), grid.width);
    let columns = column.saturating_sub(reach)..(column + reach + 1).min(width);
    let rows = row.saturating_sub(reach)..(row + reach + 1).min(grid.height);
    rows.flat_map(move |r| columns.clone().map(move |c| r * width + c))
}

/// Sums over a neighbourhood.
struct Pool {
    /// Σ (K − 1) s², and Σ (K − 1).
    squares: f64,
    freedom: f64,
    /// How many, and Σ (x − x̄)⁴.
    n: f64,
    fourth: f64,
}

impl Pool {
    fn around(data: &Data, truths: &[PixelTruth], p: usize, reach: usize) -> Pool {
        let mut pool = Pool { squares: 0.0, freedom: 0.0, n: 0.0, fourth: 0.0 };
        let freedom = data.n_images.saturating_sub(1) as f64;
        for q in around(&data.grid, p, reach).filter(|q| truths[*q].region == truths[p].region) {
            pool.squares += data.squares(q);
            pool.freedom += freedom;
            pool.n += data.n_images as f64;
            pool.fourth += data.fourth_powers(q);
        }
        pool
    }

    fn variance(&self) -> f64 {
        if self.freedom > 0.0 { self.squares / self.freedom } else { 0.0 }
    }
    fn kurtosis(&self) -> f64 {
        if self.squares > 0.0 { self.n * self.fourth / (self.squares * self.squares) } else { f64::INFINITY }
    }
    /// Squares of so many equal hits have this kurtosis.
    fn events(&self) -> f64 {
        self.n / self.kurtosis()
    }
    /// Two standard errors higher.
    fn high(&self) -> f64 {
        let relative = ((self.kurtosis() - 1.0).clamp(2.0, 100.0) / self.freedom.max(1.0)).sqrt();
        self.variance() * (1.0 + 2.0 * relative)
    }
}
