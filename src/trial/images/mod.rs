//! Images that another renderer made of a case, judged: where they meet the exact mean over each pixel's footprint.
//!
//! What is judged, each by the gate of [`crate::statistics::evidence`]:
//! - `bias`: pixels have the exact mean over their footprint. Judged are the mean and the regions, low-order contrasts over
//!   the image, and places (squares of pixels, down to as few as hold enough observations; with many images single pixels);
//! - `neighbours`: residuals of neighbouring pixels do not move together (else a filter or a denoiser was on);
//! - `images`: residuals of different images do not move together (else random streams were used twice).
//!
//! Nothing predicts how pixels spread: verdicts lean on the images' own spread, pooled over neighbours of the same region and
//! taken high, or on the variance that the file of a single image states.

mod cause;
mod dependence;
mod evidence;
mod exact;
mod spread;

use std::borrow::Cow;
use std::time::Instant;

use self::dependence::Dependence;
use super::outcome::JudgedProperty;
use crate::case::{Case, SmallestBias};
use crate::external::PixelGrid;
use crate::external::image::Stack;
use crate::oracle::optics::{OpticsError, unfolded};
use crate::oracle::{Oracle, Region};
use crate::statistics::Verdict;
use crate::statistics::evidence::THRESHOLD_LOG10;

pub use cause::Cause;
pub use exact::PixelTruth;

/// Relative: single precision adds up to so much, whatever is asked for.
pub const LEAST_TOLERANCE: f64 = 1e-5;
/// Relative: half-floats round by up to 2⁻¹¹, so nothing finer can be asked of them.
pub const LEAST_TOLERANCE_OF_HALVES: f64 = 1e-3;

/// On what terms images are judged.
#[derive(Clone, Debug)]
pub struct ImageTerms<'a> {
    /// What reports call whoever made them.
    pub name: &'a str,
    pub reproduce: String,
    /// Irradiance for each unit of a pixel's value.
    pub irradiance_of_value: f64,
    /// Reflectance of the receiver in the scene.
    pub rho: f64,
    /// Samples that each pixel's value is the mean of.
    pub samples_per_pixel: u64,
    /// Whether the first of them looks at the middle of the pixel, whatever the seed.
    pub first_sample_at_centre: bool,
    /// Relative; no less than [`LEAST_TOLERANCE`] counts.
    pub tolerance: f64,
    /// Metres by which a renderer may move the start of a shadow ray, and with it the edge of a shadow; `None`: 10⁻⁴ of the
    /// receiver's extent and distance from the origin, as single precision needs.
    pub ray_epsilon: Option<f64>,
    pub smallest_bias: SmallestBias,
}

/// One pixel: what is due, and what is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    pub truth: PixelTruth,
    /// Mean over the images, W/m².
    pub mean: f64,
    /// Of the mean over the images, from the pooled spread, W/m².
    pub std_error: f64,
}

impl Pixel {
    /// Deviations in standard errors; `None` where nothing spreads.
    pub fn z(&self) -> Option<f64> {
        (self.std_error > 0.0).then(|| (self.mean - self.truth.irradiance) / self.std_error)
    }
}

/// Some pixels together.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// `all`, or a region; `edge` where a shadow's edge runs, within the ray epsilon.
    pub name: &'static str,
    pub n_pixels: usize,
    /// Means over them, W/m².
    pub exact: f64,
    pub exact_bound: f64,
    pub mean: f64,
    pub std_error: f64,
    /// Mean of z².
    pub chi_square: Option<f64>,
    /// log10 of the capital of its mean.
    pub evidence: f64,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct ImagesOutcome {
    pub case: String,
    pub name: String,
    pub width: usize,
    pub height: usize,
    pub n_images: usize,
    pub samples_per_pixel: u64,
    /// Metres.
    pub ray_epsilon: f64,
    /// `[row][column]`.
    pub pixels: Vec<Pixel>,
    /// The middle of each pixel, metres.
    pub places: Vec<[f64; 3]>,
    pub parts: Vec<Part>,
    /// The exact side's mean bound over the standard error of the mean; and the largest bound of a pixel over the standard
    /// error of a pixel, root mean square over all.
    pub footprint_error: [f64; 2],
    pub neighbour_correlation: Option<[f64; 2]>,
    pub image_correlation: Option<f64>,
    /// Empty for a single image without a variance.
    pub verdicts: Vec<JudgedProperty>,
    pub cause: Option<Cause>,
    /// What a reader should know.
    pub notes: Vec<String>,
    /// Wall-clock seconds on exact values, and on the rest.
    pub seconds: [f64; 2],
}

impl ImagesOutcome {
    /// The worst of the verdicts; `None` where there is none.
    pub fn verdict(&self) -> Option<Verdict> {
        let any = |verdict| self.verdicts.iter().any(|judged| judged.verdict == verdict);
        if self.verdicts.is_empty() {
            None
        } else if any(Verdict::Fail) {
            Some(Verdict::Fail)
        } else if any(Verdict::Undecided) {
            Some(Verdict::Undecided)
        } else {
            Some(Verdict::Pass)
        }
    }
}

/// The images as irradiance, with what is summed of each pixel. `[image][row][column]`.
struct Data {
    grid: PixelGrid,
    n_images: usize,
    /// Of the exact mean over each footprint, W/m².
    deviations: Vec<f64>,
    /// Sums over the images of deviations to the powers 1 to 4.
    sums: Vec<[f64; 4]>,
    /// Stated by the file of a single image, (W/m²)².
    stated_variance: Option<Vec<f64>>,
}

impl Data {
    fn new(grid: PixelGrid, stack: &Stack, terms: &ImageTerms, truths: &[PixelTruth]) -> Data {
        let n_pixels = grid.n_pixels();
        let factor = terms.irradiance_of_value;
        let mut deviations = stack.values.clone();
        let mut sums = vec![[0.0; 4]; n_pixels];
        for image in deviations.chunks_exact_mut(n_pixels) {
            for ((x, truth), sums) in image.iter_mut().zip(truths).zip(&mut sums) {
                *x = *x * factor - truth.irradiance;
                let square = *x * *x;
                sums[0] += *x;
                sums[1] += square;
                sums[2] += square * *x;
                sums[3] += square * square;
            }
        }
        let stated_variance =
            stack.variance.as_ref().map(|variances| variances.iter().map(|v| v * factor * factor).collect());
        Data { grid, n_images: stack.n_images(), deviations, sums, stated_variance }
    }

    fn n_pixels(&self) -> usize {
        self.sums.len()
    }
    fn image(&self, k: usize) -> &[f64] {
        &self.deviations[k * self.n_pixels()..(k + 1) * self.n_pixels()]
    }
    fn mean_deviation(&self, p: usize) -> f64 {
        self.sums[p][0] / self.n_images as f64
    }
    /// Of one image, about the mean over the images; 0 for a single one.
    fn sample_variance(&self, p: usize) -> f64 {
        if self.n_images < 2 { 0.0 } else { self.squares(p) / (self.n_images as f64 - 1.0) }
    }
    /// Σ (x − x̄)²; 0 where all are equal but for rounding.
    fn squares(&self, p: usize) -> f64 {
        let [first, second, ..] = self.sums[p];
        let squares = second - first * first / self.n_images as f64;
        if squares > ROUNDING * second { squares } else { 0.0 }
    }
    /// Σ (x − x̄)⁴.
    fn fourth_powers(&self, p: usize) -> f64 {
        let [first, second, third, fourth] = self.sums[p];
        let mean = first / self.n_images as f64;
        (fourth - 4.0 * mean * third + 6.0 * mean * mean * second - 3.0 * mean.powi(3) * first).max(0.0)
    }
}

/// Of sums of squares, relative: about the exact value they hold the bias, too.
const ROUNDING: f64 = 1e-13;

/// The case that images of a case are judged by: of a room with a flat mirror, the room [unfolded](unfolded), in which its light
/// is direct; a beam through a ball of glass onto a screen that it alone lights remains what it is.
///
/// - error: why images of a room with mirrors or glass cannot be judged
pub fn as_judged(case: &Case) -> Result<Cow<'_, Case>, OpticsError> {
    if !case.configuration.has_optics() || exact::caustic(&case.configuration).is_some() {
        return Ok(Cow::Borrowed(case));
    }
    let configuration = unfolded(&case.configuration)?;
    Ok(Cow::Owned(Case { configuration, ..case.clone() }))
}

/// Judges images of a case.
///
/// - `case`: [as it is judged](as_judged)
/// - `grid`: the pixels, on the case's receiver
/// - `stack`: of the same size, one image or more
pub fn judge_images(case: &Case, grid: &PixelGrid, stack: &Stack, terms: &ImageTerms) -> ImagesOutcome {
    assert_eq!((grid.width, grid.height), (stack.width, stack.height), "the images have the grid's size");
    let begin = Instant::now();
    let oracle = Oracle::new(&case.configuration);
    let ray_epsilon = terms.ray_epsilon.unwrap_or_else(|| usual_epsilon(grid));
    let noise = exact::Noise::of(stack, terms.irradiance_of_value);
    let mut truths = match exact::caustic(&case.configuration) {
        Some(layout) => exact::behind_glass(&layout, grid),
        None => exact::truths(&oracle, grid, ray_epsilon, &noise, exact::evaluations(&case.configuration)),
    };
    if terms.first_sample_at_centre {
        truths.iter_mut().for_each(|truth| truth.lean_on_the_middle(terms.samples_per_pixel));
    }
    let on_exact = begin.elapsed().as_secs_f64();
    let data = Data::new(*grid, stack, terms, &truths);
    let most = spread::ceilings(&case.configuration, grid, &truths, terms.samples_per_pixel);
    let variances = spread::variances(&data, &truths, &most);
    let pixels: Vec<Pixel> = (0..data.n_pixels())
        .map(|p| Pixel {
            truth: truths[p],
            mean: truths[p].irradiance + data.mean_deviation(p),
            std_error: (variances.plain[p] / data.n_images as f64).sqrt(),
        })
        .collect();
    let tolerance = terms.tolerance.max(LEAST_TOLERANCE);
    let has_spread = data.n_images > 1 || data.stated_variance.is_some();
    let mut notes = Vec::new();
    let (mut verdicts, mut cause) = (Vec::new(), None);
    let mut dependence = Dependence::default();
    let mut evidences = Vec::new();
    if has_spread {
        dependence = dependence::measure(&data, &truths, &variances.plain);
        let judged = evidence::bias(&data, &truths, &variances, &dependence, terms, tolerance);
        evidences = judged.parts;
        verdicts.push(judged.verdict);
        verdicts.extend(dependence.verdicts(&data, terms));
        if verdicts.iter().any(|judged| judged.verdict == Verdict::Fail) {
            cause = cause::find(case, &data, &pixels, stack, terms, &verdicts);
        }
        if let (Some(cause), Some(bias)) = (&cause, verdicts.first_mut())
            && bias.verdict == Verdict::Fail
        {
            bias.words += &format!(". Likely cause: {}", cause.words);
        }
    } else {
        notes.push(
            "one image without a variance: nothing tells its noise, so it gets a picture and no verdict. Render more images \
             with other seeds, or name the variance of its pixels (--pixel-variance)"
                .to_owned(),
        );
    }
    if let Some(note) = dependence.inflation_note() {
        notes.push(note);
    }
    let parts = parts(&pixels, &evidences, has_spread);
    let footprint_error = footprint_error(&pixels, parts.first());
    let places = (0..data.n_pixels()).map(|p| grid.middle(grid.place(p)).to_array()).collect();
    ImagesOutcome {
        case: case.name.clone(),
        name: terms.name.to_owned(),
        width: grid.width,
        height: grid.height,
        n_images: data.n_images,
        samples_per_pixel: terms.samples_per_pixel,
        ray_epsilon,
        pixels,
        places,
        parts,
        footprint_error,
        neighbour_correlation: dependence.neighbours.map(|n| n.map(|pairs| pairs.correlation())),
        image_correlation: dependence.images.map(|pairs| dependence::between(&pairs, data.n_images)),
        verdicts,
        cause,
        notes,
        seconds: [on_exact, begin.elapsed().as_secs_f64() - on_exact],
    }
}

/// 10⁻⁴ m for a receiver of about a metre at the origin; more where coordinates are larger.
fn usual_epsilon(grid: &PixelGrid) -> f64 {
    let corners = [[0, 0], [grid.width - 1, grid.height - 1]].map(|place| grid.middle(place).abs().max_element());
    1e-4 * (1.0 + corners[0].max(corners[1]))
}

/// The regions' names in the order of tables.
const PARTS: [(&str, Option<Option<Region>>); 6] = [
    ("all", None),
    ("lit", Some(Some(Region::Lit))),
    ("penumbra", Some(Some(Region::Penumbra))),
    ("umbra", Some(Some(Region::Umbra))),
    ("below_horizon", Some(Some(Region::BelowHorizon))),
    ("edge", Some(None)),
];

/// The pixels of each part, in the order of [`PARTS`].
fn members(truths: impl Iterator<Item = Option<Region>> + Clone) -> [Vec<usize>; 6] {
    PARTS.map(|(_, region)| {
        let own = truths.clone().enumerate().filter(|(_, found)| region.is_none_or(|region| region == *found));
        own.map(|(p, _)| p).collect()
    })
}

fn parts(pixels: &[Pixel], evidences: &[(usize, f64)], has_spread: bool) -> Vec<Part> {
    let members = members(pixels.iter().map(|pixel| pixel.truth.region));
    let part = |(i, members): (usize, &Vec<usize>)| {
        let n = members.len() as f64;
        let mean = |value: &dyn Fn(&Pixel) -> f64| members.iter().map(|p| value(&pixels[*p])).sum::<f64>() / n;
        let squares: Vec<f64> = members.iter().filter_map(|p| pixels[*p].z()).map(|z| z * z).collect();
        let chi_square =
            (has_spread && !squares.is_empty()).then(|| squares.iter().sum::<f64>() / squares.len() as f64);
        (!members.is_empty()).then(|| Part {
            name: PARTS[i].0,
            n_pixels: members.len(),
            exact: mean(&|pixel| pixel.truth.irradiance),
            exact_bound: mean(&|pixel| pixel.truth.bound),
            mean: mean(&|pixel| pixel.mean),
            std_error: (mean(&|pixel| pixel.std_error.powi(2)) / n).sqrt(),
            chi_square,
            evidence: evidences.iter().find(|(part, _)| *part == i).map_or(0.0, |(_, evidence)| *evidence),
        })
    };
    members.iter().enumerate().filter_map(part).collect()
}

/// How far the exact means may be off, in standard errors: of the whole mean; and of the worst pixel, in those of a pixel as
/// pixels are on the whole (root mean square).
fn footprint_error(pixels: &[Pixel], all: Option<&Part>) -> [f64; 2] {
    let ratio = |bound: f64, error: f64| if error > 0.0 { bound / error } else { 0.0 };
    let whole = all.map_or(0.0, |all| ratio(all.exact_bound, all.std_error));
    let squares = pixels.iter().map(|pixel| pixel.std_error.powi(2)).sum::<f64>();
    let usual = (squares / pixels.len() as f64).sqrt();
    [whole, pixels.iter().map(|pixel| ratio(pixel.truth.bound, usual)).fold(0.0, f64::max)]
}

/// A verdict of this room.
fn property(
    property: &'static str,
    verdict: Verdict,
    evidence: f64,
    [effect, effect_low, effect_high]: [f64; 3],
    words: String,
    reproduce: &str,
) -> JudgedProperty {
    JudgedProperty {
        property,
        verdict,
        evidence,
        threshold: THRESHOLD_LOG10,
        effect,
        effect_low,
        effect_high,
        smallest_bias_mean: None,
        smallest_bias_point: None,
        words,
        note: None,
        reproduce: reproduce.to_owned(),
    }
}

#[cfg(test)]
mod tests;
