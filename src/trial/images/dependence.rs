//! Whether pixels and images are independent of one another, as far as their residuals tell.
//!
//! Residuals are deviations from the mean over the images, so a bias is not in them, over the pooled spread:
//! r = (x − x̄)/s. Products of residuals of two pixels have mean 0 if these are independent; of two images, −1/(K − 1) after
//! the factor K/(K − 1) that gives residuals a variance of one.

use super::evidence::{contrasts, pixels_of, sides, tiles};
use super::exact::PixelTruth;
use super::{Data, ImageTerms, property};
use crate::oracle::Region;
use crate::statistics::evidence::{ln_average, log10_capped, smallest_shift};
use crate::statistics::{Capital, Observed, Statement, Verdict};
use crate::trial::outcome::JudgedProperty;

/// Correlations up to this are no fault.
const HARMLESS: f64 = 0.05;
/// A pass must have been able to see a correlation of this size: a tent filter's is 0.22, a Gaussian's 0.34.
const ASKED: f64 = 0.2;
/// Products that are looked at, between images and between pixels of one image and the next.
const MOST_PRODUCTS: usize = 1 << 27;
/// Images that correlations of single pixels with others are looked for in, at least.
const FEWEST_IMAGES: usize = 24;

/// Sums of products of residuals.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pairs {
    n: u64,
    sum: f64,
    squares: f64,
}

impl Pairs {
    fn add(&mut self, product: f64) {
        self.n += 1;
        self.sum += product;
        self.squares += product * product;
    }
    pub fn correlation(&self) -> f64 {
        if self.n == 0 { 0.0 } else { self.sum / self.n as f64 }
    }
    /// ln capital against a correlation within [`HARMLESS`] of `expected`.
    fn ln(&self, expected: f64) -> f64 {
        let observed = Observed { n: self.n, pivot: 0.0, sum: self.sum, sum_of_squares: self.squares };
        Capital::of(&Statement::near(expected, HARMLESS, 1.0), &observed, self.n).ln()
    }
}

/// Pixels of one image that follow pixels of the image before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Followers {
    pub pairs: usize,
    pub largest: f64,
    /// Index of a pixel, and of the one that follows it in the next image.
    pub example: [usize; 2],
}

/// What was found.
#[derive(Clone, Debug, Default)]
pub(super) struct Dependence {
    /// Along rows, and along columns.
    pub neighbours: Option<[Pairs; 2]>,
    /// The same pixel in different images.
    pub images: Option<Pairs>,
    /// ln of the capital against independent images.
    images_ln: f64,
    pub followers: Option<Followers>,
    /// How much larger the variance of the mean and of contrasts is than that of independent pixels.
    pub whole: f64,
    /// The same of squares of a side.
    sides: Vec<(usize, f64)>,
}

impl Dependence {
    pub fn at_side(&self, side: usize) -> f64 {
        self.sides.iter().find(|(own, _)| *own == side).map_or(1.0, |(_, factor)| *factor)
    }

    /// What a reader should know of sums that vary more than those of independent pixels.
    pub fn inflation_note(&self) -> Option<String> {
        let most = self.sides.iter().map(|(_, factor)| *factor).fold(self.whole, f64::max);
        (most > 1.5).then(|| {
            format!(
                "pixels move together: sums over them vary up to {most:.1} times as much as those of independent pixels would; \
                 verdicts allow for it"
            )
        })
    }

    pub fn verdicts(&self, data: &Data, terms: &ImageTerms) -> Vec<JudgedProperty> {
        let mut found = Vec::new();
        if let Some(pairs) = self.neighbours {
            let evidence = ln_average(pairs.iter().filter(|p| p.n > 0).map(|pairs| pairs.ln(0.0)));
            let [across, down] = pairs.map(|pairs| pairs.correlation());
            let worst = if across.abs() >= down.abs() { 0 } else { 1 };
            let correlation = pairs[worst].correlation();
            let smallest = pairs.iter().filter(|p| p.n > 0).map(|p| HARMLESS + smallest_shift(1.0, p.n, 2));
            let smallest = smallest.fold(0.0, f64::max);
            let verdict = verdict(evidence, smallest);
            let words = match verdict {
                Verdict::Fail => format!(
                    "residuals of neighbouring pixels are correlated by {across:+.2} along rows, {down:+.2} along columns: a \
                     reconstruction filter or a denoiser was on (a box filter of one pixel gives 0)"
                ),
                Verdict::Pass => format!(
                    "residuals of neighbouring pixels: {across:+.3} along rows, {down:+.3} along columns; none above {smallest:.2}"
                ),
                Verdict::Undecided => format!(
                    "too few pixels: a correlation of neighbours of {smallest:.2} would have been seen ({ASKED} asked); more images would do"
                ),
            };
            found.push(property(
                "neighbours",
                verdict,
                log10_capped(evidence),
                around(correlation, pairs[worst].n),
                words,
                &terms.reproduce,
            ));
        }
        if let Some(pairs) = self.images {
            let smallest = HARMLESS + smallest_shift(1.0, pairs.n, 1);
            let mut verdict = verdict(self.images_ln, smallest);
            let correlation = between(&pairs, data.n_images);
            let words = match (&self.followers, verdict) {
                (Some(Followers { pairs, largest, example }), _) => {
                    verdict = Verdict::Fail;
                    let place = |p: usize| {
                        let [column, row] = data.grid.place(p);
                        format!("column {column}, row {row}")
                    };
                    format!(
                        "random streams were used twice: {pairs} pixels of an image follow pixels of the image before (correlation up \
                         to {largest:.2}: {} after {}). Seeds lie too near to one another",
                        place(example[1]),
                        place(example[0])
                    )
                }
                (None, Verdict::Fail) => format!(
                    "residuals of different images are correlated ({correlation:+.2}): random streams were used twice, or images \
                     were copied or averaged; every image needs a seed of its own"
                ),
                (None, Verdict::Pass) => {
                    format!("residuals of different images: {correlation:+.3}; none above {smallest:.2}")
                }
                (None, Verdict::Undecided) => format!(
                    "too few pixels: a correlation between images of {smallest:.2} would have been seen ({ASKED} asked)"
                ),
            };
            found.push(property(
                "images",
                verdict,
                log10_capped(self.images_ln),
                around(correlation, pairs.n),
                words,
                &terms.reproduce,
            ));
        }
        found
    }
}

fn verdict(evidence_ln: f64, smallest: f64) -> Verdict {
    if log10_capped(evidence_ln) >= crate::statistics::evidence::THRESHOLD_LOG10 {
        Verdict::Fail
    } else if smallest <= ASKED {
        Verdict::Pass
    } else {
        Verdict::Undecided
    }
}

/// Between images, without what the mean over them brings: residuals from it sum to nought.
pub(super) fn between(pairs: &Pairs, n_images: usize) -> f64 {
    pairs.correlation() + 1.0 / (n_images as f64 - 1.0).max(1.0)
}

/// A correlation of n products, with its 95 % interval.
fn around(correlation: f64, n: u64) -> [f64; 3] {
    let reach = crate::statistics::interval::Z_95 / (n.max(1) as f64).sqrt();
    [correlation, correlation - reach, correlation + reach]
}

/// Looks for all of it.
///
/// - `variances`: of a pixel of one image, pooled, as measured
pub(super) fn measure(data: &Data, truths: &[PixelTruth], variances: &[f64]) -> Dependence {
    let images = data.n_images;
    let scale: Vec<f64> = variances
        .iter()
        .map(|variance| {
            let freed = if images > 1 { (images as f64 / (images as f64 - 1.0)).sqrt() } else { 1.0 };
            if *variance > 0.0 { freed / variance.sqrt() } else { 0.0 }
        })
        .collect();
    let centre: Vec<f64> =
        (0..data.n_pixels()).map(|p| if images > 1 { data.mean_deviation(p) } else { 0.0 }).collect();
    let residual = |k: usize, p: usize| (data.image(k)[p] - centre[p]) * scale[p];
    let mut found =
        Dependence { whole: 1.0, neighbours: Some(neighbours(data, &scale, &residual)), ..Dependence::default() };
    if images < 2 {
        return found;
    }
    found.whole = of_contrasts(data);
    found.sides = sides(data).into_iter().map(|side| (side, of_places(data, side))).collect();
    (found.images, found.images_ln) = between_images(data, &scale, &residual);
    found.followers = followers(data, truths, &scale, &residual);
    found
}

type Residual<'a> = dyn Fn(usize, usize) -> f64 + 'a;

fn neighbours(data: &Data, scale: &[f64], residual: &Residual) -> [Pairs; 2] {
    let (width, height) = (data.grid.width, data.grid.height);
    let mut pairs = [Pairs::default(); 2];
    for k in 0..data.n_images {
        for p in 0..data.n_pixels() {
            if scale[p] == 0.0 {
                continue;
            }
            let [column, row] = data.grid.place(p);
            let right = (column + 1 < width).then_some(p + 1);
            let below = (row + 1 < height).then_some(p + width);
            for (pairs, q) in pairs.iter_mut().zip([right, below]) {
                if let Some(q) = q.filter(|q| scale[*q] > 0.0) {
                    pairs.add(residual(k, p) * residual(k, q));
                }
            }
        }
    }
    pairs
}

/// The variance of sums over the variance of sums of independent terms: at least 1; where it is beyond doubt larger, two
/// standard errors more.
fn factor(measured: f64, independent: f64, freedom: f64) -> f64 {
    if independent <= 0.0 || freedom <= 0.0 {
        return 1.0;
    }
    let (ratio, error) = (measured / independent, (2.0 / freedom).sqrt());
    if ratio * (1.0 - 2.0 * error) <= 1.0 { ratio.max(1.0) } else { ratio * (1.0 + 2.0 * error) }
}

/// Between the images, of the mean and of low contrasts. The mean by itself counts where it varies more than they all do.
fn of_contrasts(data: &Data) -> f64 {
    let variances: Vec<f64> = (0..data.n_pixels()).map(|p| data.sample_variance(p)).collect();
    let freedom = (data.n_images - 1) as f64;
    let ratio = |weights: &[f64]| {
        let sums = (0..data.n_images).map(|k| data.image(k).iter().zip(weights).map(|(x, w)| x * w).sum());
        let sums: Vec<f64> = sums.collect();
        let mean = sums.iter().sum::<f64>() / sums.len() as f64;
        let measured = sums.iter().map(|sum| (sum - mean).powi(2)).sum::<f64>() / freedom;
        let independent: f64 = variances.iter().zip(weights).map(|(v, w)| v * w * w).sum();
        if independent > 0.0 { measured / independent } else { 1.0 }
    };
    let mean = ratio(&vec![1.0; data.n_pixels()]);
    let others = contrasts(data);
    let others: Vec<f64> = others
        .iter()
        .map(|wave| ratio(&(0..data.n_pixels()).map(|p| wave.weight(data.grid.place(p))).collect::<Vec<_>>()))
        .collect();
    let all = (mean + others.iter().sum::<f64>()) / (1.0 + others.len() as f64);
    let pooled = factor(all, 1.0, freedom * (1.0 + others.len() as f64));
    // By itself only where chance does not explain it: five standard errors.
    if mean > 1.0 + 5.0 * (2.0 / freedom).sqrt() { pooled.max(factor(mean, 1.0, freedom)) } else { pooled }
}

/// Between the images, of the sums over squares of a side.
fn of_places(data: &Data, side: usize) -> f64 {
    if side == 1 {
        return 1.0;
    }
    let freedom = (data.n_images - 1) as f64;
    let (mut measured, mut independent, mut n) = (0.0, 0.0, 0.0);
    for place in tiles(data, side) {
        let pixels: Vec<usize> = pixels_of(data, place).collect();
        let sums = (0..data.n_images).map(|k| pixels.iter().map(|p| data.image(k)[*p]).sum::<f64>());
        let sums: Vec<f64> = sums.collect();
        let mean = sums.iter().sum::<f64>() / sums.len() as f64;
        measured += sums.iter().map(|sum| (sum - mean).powi(2)).sum::<f64>() / freedom;
        independent += pixels.iter().map(|p| data.sample_variance(*p)).sum::<f64>();
        n += freedom;
    }
    factor(measured, independent, n)
}

/// The same pixel in different images: of pairs of images as far apart as time allows.
fn between_images(data: &Data, scale: &[f64], residual: &Residual) -> (Option<Pairs>, f64) {
    let images = data.n_images;
    let expected = -1.0 / (images as f64 - 1.0);
    let mut together = Pairs::default();
    let mut capitals = Vec::new();
    let mut products = 0;
    'lags: for lag in 1..images {
        let mut of_lag = Pairs::default();
        for k in 0..images - lag {
            let mut of_pair = Pairs::default();
            for p in (0..data.n_pixels()).filter(|p| scale[*p] > 0.0) {
                of_pair.add(residual(k, p) * residual(k + lag, p));
            }
            of_lag.n += of_pair.n;
            of_lag.sum += of_pair.sum;
            of_lag.squares += of_pair.squares;
            // Two images alone are told apart only where they have many pixels.
            if of_pair.n >= 64 && images <= 256 {
                capitals.push(of_pair.ln(expected));
            }
            products += data.n_pixels();
            if products > MOST_PRODUCTS {
                break 'lags;
            }
        }
        if lag == 1 {
            together = of_lag;
        }
        capitals.push(of_lag.ln(expected));
        if lag >= 16 && images > 256 {
            break;
        }
    }
    // Half of the weight on the next image, which neighbouring seeds would hurt.
    let first = together.ln(expected);
    let evidence = ln_average([first, ln_average(capitals)]);
    ((together.n > 0).then_some(together), evidence)
}

/// Pixels that follow another pixel of the image before: where seeds are neighbours, streams are taken up by other pixels.
/// Among lit pixels, whose residuals are nearly normal; by Fisher's z, beyond chance among all pairs.
fn followers(data: &Data, truths: &[PixelTruth], scale: &[f64], residual: &Residual) -> Option<Followers> {
    let lit: Vec<usize> =
        (0..data.n_pixels()).filter(|p| truths[*p].region == Some(Region::Lit) && scale[*p] > 0.0).collect();
    let steps = data.n_images - 1;
    if data.n_images < FEWEST_IMAGES || lit.len().pow(2).saturating_mul(steps) > MOST_PRODUCTS {
        return None;
    }
    let all = (lit.len() * lit.len()) as f64;
    // A normal variable exceeds √(2 ln (pairs / 10⁻⁸)) among so many with probability below 10⁻⁸.
    let needed = (2.0 * (all / 1e-8).ln()).sqrt() / (steps as f64 - 3.0).sqrt();
    let rows: Vec<Vec<f64>> = lit.iter().map(|p| (0..data.n_images).map(|k| residual(k, *p)).collect()).collect();
    let mut found: Option<Followers> = None;
    for (i, leader) in rows.iter().enumerate() {
        for (j, follower) in rows.iter().enumerate() {
            let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
            for (a, b) in leader[..steps].iter().zip(&follower[1..]) {
                ab += a * b;
                aa += a * a;
                bb += b * b;
            }
            let correlation = if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 };
            // Two thirds at least: what chance may do to tails is less.
            if correlation.abs() < 0.66 || libm::atanh(correlation.abs().min(1.0 - 1e-12)) < needed {
                continue;
            }
            let found = found.get_or_insert(Followers { pairs: 0, largest: 0.0, example: [0, 0] });
            found.pairs += 1;
            if correlation.abs() > found.largest {
                (found.largest, found.example) = (correlation.abs(), [lit[i], lit[j]]);
            }
        }
    }
    found
}
