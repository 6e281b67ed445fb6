//! The exact mean over every pixel's footprint, as good as the images' noise asks for.

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;

use crate::configuration::{Configuration, GlassShape, Lamp, ReceiverShape};
use crate::external::PixelGrid;
use crate::external::image::Stack;
use crate::geometry::{Rectangle, Shape};
use crate::oracle::optics::CausticLayout;
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

/// How finely means are worth knowing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    /// Of one pixel's mean over the images, root mean square over the pixels, W/m².
    pub std_error: f64,
}

/// The share of the images' standard error that an exact value may be off by.
const SHARE: f64 = 0.01;
/// Where the images have no noise: relative to the mean value.
const FINEST: f64 = 1e-9;

impl Noise {
    /// Of the images as they are: about their own means, or as the file states.
    pub fn of(stack: &Stack, irradiance_of_value: f64) -> Noise {
        let (n_pixels, n_images) = (stack.n_pixels(), stack.n_images());
        let k = n_images as f64;
        let mut variance = 0.0;
        for p in 0..n_pixels {
            let values = || (0..n_images).map(|k| stack.values[k * n_pixels + p]);
            let mean = values().sum::<f64>() / k;
            variance += match &stack.variance {
                Some(stated) => stated[p],
                None if n_images > 1 => values().map(|x| (x - mean).powi(2)).sum::<f64>() / (k - 1.0) / k,
                // A single image: only a picture is made of it.
                None => (0.01 * mean).powi(2),
            };
        }
        Noise { std_error: (variance / n_pixels as f64).sqrt() * irradiance_of_value }
    }
}

/// The exact means, pixels in parallel. `[row][column]`.
///
/// - `evaluations`: of the exact point value, at most about so many for all of them
pub(super) fn truths(
    oracle: &Oracle,
    grid: &PixelGrid,
    ray_epsilon: f64,
    noise: &Noise,
    evaluations: u64,
) -> Vec<PixelTruth> {
    let n = grid.n_pixels();
    let pixel =
        |p: usize| grid.footprint(grid.place(p)).expect("a grid's pixels are rectangles, or there is no grid");
    let looks: Vec<Footprint> =
        (0..n).into_par_iter().with_min_len(64).map(|p| footprint(oracle, &pixel(p), ray_epsilon)).collect();
    let mean = looks.iter().map(|look| look.average.irradiance.watts_per_square_metre()).sum::<f64>() / n as f64;
    let single = (SHARE * noise.std_error).max(FINEST * mean);
    let coarse = |look: &Footprint, most: f64| look.is_crossed || look.average.bound.watts_per_square_metre() > most;
    // The mean over all pixels has a standard error that is smaller by √n; those that are crossed share what it grants.
    let crossed = looks.iter().filter(|look| coarse(look, single)).count().max(1) as f64;
    let granted = single.min(single * (n as f64).sqrt() / crossed).max(FINEST * mean);
    let most_evaluations = (evaluations / crossed as u64).clamp(FEWEST_EVALUATIONS, MOST_EVALUATIONS);
    let smooth = single.min(single / (n as f64).sqrt().max(1.0)).max(FINEST * mean);
    (0..n)
        .into_par_iter()
        .map(|p| {
            let (look, footprint) = (&looks[p], pixel(p));
            let average = if coarse(look, smooth) {
                let absolute = if look.is_crossed { granted } else { smooth };
                let tolerance = Tolerance { relative: 1e-12, absolute, most_evaluations };
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

/// A beam through a ball of glass, if nothing else of its light lands on the receiver but what passed straight through, as long
/// as paths end at the third surface: what the ball's outside mirrors lands beyond the receiver's corners.
///
/// ```text
/// at the height b over the axis light is mirrored by π − 2θ, sin θ = b/R, and lands at b + (√(R² − b²) + d) tan(π − 2θ) on a
/// screen at the distance d; the beam's rim lands nearest to the axis
/// ```
pub(super) fn caustic(configuration: &Configuration) -> Option<CausticLayout> {
    let ([Lamp::Beam(beam)], [glass]) = (configuration.lamps(), configuration.glass()) else { return None };
    let (GlassShape::Sphere(ball), ReceiverShape::Rectangle(screen)) =
        (glass.shape(), configuration.receiver()?.shape())
    else {
        return None;
    };
    let layout = CausticLayout::of(configuration)?;
    let (radius, rim) = (ball.radius(), beam.radius());
    let reach = screen.corners().iter().map(|corner| (*corner - layout.foot()).length()).fold(0.0, f64::max);
    let distance = (layout.foot() - ball.center()).length();
    let turn = PI - 2.0 * (rim / radius).min(1.0).asin();
    let nearest = rim + ((radius * radius - rim * rim).max(0.0).sqrt() + distance) * turn.tan();
    (turn >= FRAC_PI_2 || reach < nearest).then_some(layout)
}

/// The exact means behind a ball: power over area.
pub(super) fn behind_glass(layout: &CausticLayout, grid: &PixelGrid) -> Vec<PixelTruth> {
    let pixel =
        |p: usize| grid.footprint(grid.place(p)).expect("a grid's pixels are rectangles, or there is no grid");
    let truth = |p: usize| {
        let footprint = pixel(p);
        let power = layout.power_in_rectangle(&footprint);
        let [irradiance, bound] =
            power.map_or([0.0, f64::INFINITY], |x| [x.value, x.bound].map(|x| x / footprint.area()));
        // On the caustic itself there is no value.
        let middle = layout.irradiance_at(footprint.center()).map_or(irradiance, |x| x.value);
        PixelTruth { irradiance, bound, middle, unoccluded: irradiance, region: Some(Region::Lit), shifted: 0.0 }
    };
    (0..grid.n_pixels()).into_par_iter().map(truth).collect()
}

/// Of the exact point value, for all pixels that are crossed together, and for one of them. Where they do not do, the bound
/// says so, and verdicts allow for it.
const EVALUATIONS: u64 = 20_000_000;
const FEWEST_EVALUATIONS: u64 = 500;
const MOST_EVALUATIONS: u64 = 1_000_000;
/// What a value behind a mesh costs, in values behind one of the other shapes.
const COST_OF_A_MESH: u64 = 20;

/// Evaluations that there is time for.
pub(super) fn evaluations(configuration: &Configuration) -> u64 {
    let has_mesh = configuration.occluders().iter().any(|shape| matches!(shape, Shape::Mesh(_)));
    if has_mesh { EVALUATIONS / COST_OF_A_MESH } else { EVALUATIONS }
}

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
