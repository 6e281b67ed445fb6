//! The exact mean over every pixel's footprint, as good as the images' noise asks for.

use rayon::prelude::*;

use super::spread::{around, reach};
use crate::external::PixelGrid;
use crate::external::image::Stack;
use crate::geometry::Rectangle;
use crate::oracle::patch::{Footprint, Tolerance, footprint, footprint_average};
use crate::oracle::{Oracle, Region};

/// What is due in a pixel, W/m².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelTruth {
    /// Mean over the footprint.
    pub irradiance: f64,
    /// What quadrature may have missed.
    pub bound: f64,
    /// In the middle.
    pub middle: f64,
    /// In the middle, without occluders.
    pub unoccluded: f64,
    /// What all of the footprint sees, and of its surroundings as far as the ray epsilon; `None`: a shadow's edge is in it.
    pub region: Option<Region>,
    /// What moving shadows by the ray epsilon could change.
    pub shifted: f64,
}

impl PixelTruth {
    /// What is due where the first of N samples looks at the middle: (mean · (N − 1) + middle)/N.
    pub(super) fn lean_on_the_middle(&mut self, samples: u64) {
        let share = 1.0 / samples as f64;
        self.irradiance += share * (self.middle - self.irradiance);
        self.bound *= 1.0 - share;
    }
}

/// How finely means are worth knowing: what the images' noise is.
#[derive(Clone, Debug)]
pub(super) struct Noise {
    /// Of each pixel's mean over the images, by itself, (W/m²)².
    variances: Vec<f64>,
    n_images: usize,
}

/// The share of the images' standard error that an exact value may be off by.
const SHARE: f64 = 0.01;
/// Where the images have no noise: relative to the mean value.
const FINEST: f64 = 1e-9;
/// Where the images hardly have any: relative to their noise on the whole.
const QUIETEST: f64 = 1e-2;

impl Noise {
    /// Of the images as they are: about their own means, or as the file states.
    pub fn of(stack: &Stack, irradiance_of_value: f64) -> Noise {
        let (n_pixels, n_images) = (stack.n_pixels(), stack.n_images());
        let k = n_images as f64;
        let variance = |p: usize| {
            let values = || (0..n_images).map(|k| stack.values[k * n_pixels + p]);
            let mean = values().sum::<f64>() / k;
            let variance = match &stack.variance {
                Some(stated) => stated[p],
                None if n_images > 1 => values().map(|x| (x - mean).powi(2)).sum::<f64>() / (k - 1.0) / k,
                // A single image: only a picture is made of it.
                None => (0.01 * mean).powi(2),
            };
            variance * irradiance_of_value.powi(2)
        };
        Noise { variances: (0..n_pixels).map(variance).collect(), n_images }
    }

    /// Standard error of a pixel's mean, root mean square over all of them, W/m².
    fn on_the_whole(&self) -> f64 {
        (self.variances.iter().sum::<f64>() / self.variances.len() as f64).sqrt()
    }

    /// Standard error of a pixel's mean, from its neighbours of the same region, W/m².
    fn around(&self, grid: &PixelGrid, looks: &[Footprint], p: usize) -> f64 {
        let (mut sum, mut n) = (0.0, 0.0);
        for q in around(grid, p, reach(self.n_images)).filter(|q| looks[*q].region == looks[p].region) {
            sum += self.variances[q];
            n += 1.0;
        }
        (sum / f64::max(n, 1.0)).sqrt()
    }
}

/// The exact means, pixels in parallel. `[row][column]`.
pub(super) fn truths(oracle: &Oracle, grid: &PixelGrid, ray_epsilon: f64, noise: &Noise) -> Vec<PixelTruth> {
    let n = grid.n_pixels();
    let pixel =
        |p: usize| grid.footprint(grid.place(p)).expect("a grid's pixels are rectangles, or there is no grid");
    let looks: Vec<Footprint> =
        (0..n).into_par_iter().with_min_len(64).map(|p| footprint(oracle, &pixel(p), ray_epsilon)).collect();
    let mean = looks.iter().map(|look| look.average.irradiance.watts_per_square_metre()).sum::<f64>() / n as f64;
    let whole = (SHARE * noise.on_the_whole()).max(FINEST * mean);
    let singles: Vec<f64> =
        (0..n).map(|p| (SHARE * noise.around(grid, &looks, p)).max(QUIETEST * whole).min(whole)).collect();
    let coarse = |look: &Footprint, most: f64| look.is_crossed || look.average.bound.watts_per_square_metre() > most;
    // The mean over all pixels has a standard error that is smaller by √n; those that are crossed share what it grants.
    let crossed = looks.iter().zip(&singles).filter(|(look, single)| coarse(look, **single)).count().max(1) as f64;
    let granted = (whole * (n as f64).sqrt() / crossed).max(FINEST * mean);
    let smooth = whole / (n as f64).sqrt().max(1.0);
    (0..n)
        .into_par_iter()
        .map(|p| {
            let (look, footprint) = (&looks[p], pixel(p));
            let own = if look.is_crossed { granted } else { smooth }.min(singles[p]).max(FINEST * mean);
            let average = if coarse(look, own) {
                let tolerance = Tolerance { relative: 1e-12, absolute: own, most_evaluations: MOST_EVALUATIONS };
                footprint_average(oracle, &footprint, tolerance)
            } else {
                look.average
            };
            truth(
                look,
                average.irradiance.watts_per_square_metre(),
                average.bound.watts_per_square_metre(),
                &footprint,
                ray_epsilon,
            )
        })
        .collect()
}

/// Of the exact point value, for one pixel.
const MOST_EVALUATIONS: u64 = 1_000_000;

fn truth(look: &Footprint, irradiance: f64, bound: f64, footprint: &Rectangle, ray_epsilon: f64) -> PixelTruth {
    let [least, most] = look.range.map(|x| x.watts_per_square_metre());
    let size = footprint.edge_u().length().min(footprint.edge_v().length());
    // The field changes by its range over a pixel, and no more steeply on average.
    let shifted = if look.region.is_none() { (most - least).max(0.0) * (ray_epsilon / size).min(1.0) } else { 0.0 };
    PixelTruth {
        irradiance,
        bound,
        middle: look.middle.watts_per_square_metre(),
        unoccluded: look.unoccluded.watts_per_square_metre(),
        region: look.region,
        shifted,
    }
}
