//! What may be behind a failure: each known fault is turned into the image that it would make, fitted, and named only if it
//! explains what is there.

use super::exact::PixelTruth;
use super::{Data, ImageTerms, Pixel};
use crate::case::Case;
use crate::configuration::Source;
use crate::external::PixelGrid;
use crate::external::image::Stack;
use crate::oracle::Region;
use crate::sampling::{LANES, Squares, Surface, SurfaceBlock};
use crate::statistics::Verdict;
use crate::trial::outcome::JudgedProperty;

/// A fault that explains the images.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// A word for machines: `factor`, `mirrored`, `shifted`, …
    pub name: &'static str,
    pub words: String,
    /// The share of the deviations (χ² above its expectation) that it takes away.
    pub explained: f64,
}

/// An image that a fault would make: values where they are known.
struct Hypothesis {
    name: &'static str,
    words: String,
    values: Vec<Option<f64>>,
    /// What the values may be off by through their own making, relative to the largest difference from the truth.
    slack: f64,
}

/// A named cause leaves no more of the deviations than this.
const LEFT: f64 = 0.05;

/// Looks for a cause of the verdicts' failure.
pub(super) fn find(
    case: &Case,
    data: &Data,
    pixels: &[Pixel],
    stack: &Stack,
    terms: &ImageTerms,
    verdicts: &[JudgedProperty],
) -> Option<Cause> {
    let failed = |property: &str| verdicts.iter().any(|j| j.property == property && j.verdict == Verdict::Fail);
    if !failed("bias") {
        let (name, words) = if failed("neighbours") {
            ("filter", "a reconstruction filter wider than a pixel, or a denoiser")
        } else {
            ("streams", "seeds that lie too near to one another, or images that share their random numbers")
        };
        return Some(Cause { name, words: words.to_owned(), explained: 1.0 });
    }
    let fit = Fit { pixels };
    let mut best: Option<(Cause, f64)> = None;
    let mut consider = |cause: Cause, after: f64| {
        if cause.explained >= 1.0 - LEFT && best.as_ref().is_none_or(|(_, least)| after < *least * 0.9) {
            best = Some((cause, after));
        }
    };
    if let Some((cause, after)) = leak(&fit) {
        consider(cause, after);
    }
    for hypothesis in factors(&fit, terms).into_iter().chain(moved(&fit, &data.grid)) {
        let (explained, after) = fit.explains(&hypothesis);
        consider(Cause { name: hypothesis.name, words: hypothesis.words, explained }, after);
    }
    for hypothesis in others(&fit, case, &data.grid) {
        let (explained, after) = fit.explains(&hypothesis);
        consider(Cause { name: hypothesis.name, words: hypothesis.words, explained }, after);
    }
    let found = best.map(|(cause, _)| cause);
    // Rounding to eleven bits shows in every number.
    if found.is_none() && are_halves(stack) {
        let words =
            "every number is a half-float: the film rounds by up to 4.9e-4 of a value; ask it for 32 bits".to_owned();
        return Some(Cause { name: "half-float", words, explained: 1.0 });
    }
    found
}

fn are_halves(stack: &Stack) -> bool {
    let fits = |x: &f64| {
        // Eleven bits of a fraction: f32 has 24, so thirteen zeros at the end.
        let bits = (*x as f32).to_bits();
        *x == 0.0 || (x.abs() < 65536.0 && x.abs() >= 6.2e-5 && bits & 0x1fff == 0)
    };
    stack.is_half || stack.values.iter().all(fits)
}

struct Fit<'a> {
    pixels: &'a [Pixel],
}

impl Fit<'_> {
    fn truth(&self, p: usize) -> &PixelTruth {
        &self.pixels[p].truth
    }

    /// Squared weight of a pixel: one over its variance, with the exact side's bound.
    fn weight(&self, p: usize) -> f64 {
        let pixel = &self.pixels[p];
        let variance = pixel.std_error.powi(2) + pixel.truth.bound.powi(2) + pixel.truth.shifted.powi(2);
        if variance > 0.0 { 1.0 / variance } else { 0.0 }
    }

    /// The share of the deviations that a hypothesis takes away, and what is left of them for each pixel.
    fn explains(&self, hypothesis: &Hypothesis) -> (f64, f64) {
        let (mut before, mut after, mut n) = (0.0, 0.0, 0.0);
        let largest = self
            .pixels
            .iter()
            .zip(&hypothesis.values)
            .filter_map(|(p, h)| Some((h.as_ref()? - p.truth.irradiance).abs()));
        let slack = hypothesis.slack * largest.fold(0.0, f64::max);
        for (p, value) in hypothesis.values.iter().enumerate() {
            let (weight, Some(value)) = (self.weight(p), value) else { continue };
            if weight == 0.0 {
                continue;
            }
            let pixel = &self.pixels[p];
            before += weight * (pixel.mean - pixel.truth.irradiance).powi(2);
            let off = ((pixel.mean - value).abs() - slack).max(0.0);
            after += weight * off.powi(2);
            n += 1.0;
        }
        // A few pixels of many do not stand for the image.
        let known = self.pixels.iter().filter(|pixel| pixel.std_error > 0.0).count() as f64;
        if n < 4.0 || n < 0.5 * known.min(64.0) || before <= 1.5 * n {
            return (0.0, f64::INFINITY);
        }
        (1.0 - (after - n).max(0.0) / (before - n), after / n)
    }

    /// The factor that fits best, and its standard error: as the pixels scatter about it, where that is more than they should.
    fn factor(&self) -> Option<(f64, f64)> {
        let (mut top, mut bottom) = (0.0, 0.0);
        for (p, pixel) in self.pixels.iter().enumerate() {
            // Weighed by what is due: the spread of a wrong image is itself wrong by the factor.
            let weight = if pixel.truth.irradiance > 0.0 { self.weight(p) } else { 0.0 };
            top += weight * pixel.truth.irradiance * pixel.mean;
            bottom += weight * pixel.truth.irradiance.powi(2);
        }
        let factor = (bottom > 0.0).then(|| top / bottom)?;
        let lit = || self.pixels.iter().enumerate().filter(|(_, pixel)| pixel.truth.irradiance > 0.0);
        let left = lit().map(|(p, pixel)| self.weight(p) * (pixel.mean - factor * pixel.truth.irradiance).powi(2));
        let scatter = left.sum::<f64>() / (lit().count() as f64 - 1.0).max(1.0);
        Some((factor, (scatter.max(1.0) / bottom).sqrt()))
    }
}

/// Wrong by a factor: a known one where one is near, else whatever it is.
fn factors(fit: &Fit, terms: &ImageTerms) -> Vec<Hypothesis> {
    let Some((factor, error)) = fit.factor() else { return Vec::new() };
    let (pi, rho) = (std::f64::consts::PI, terms.rho);
    let known = [
        (pi, "pi", "radiance and exitance (M = pi L) are mixed up"),
        (1.0 / pi, "1/pi", "radiance and exitance (M = pi L) are mixed up, or the BSDF lacks its 1/pi"),
        (2.0, "2", "both sides of a source count, or a light is listed twice"),
        (0.5, "1/2", "half of the samples are lost, or a probability counts twice"),
        (1.0 / rho, "1/rho", "the receiver's reflectance is 1 in the scene, or was divided by twice"),
        (rho, "rho", "the receiver's reflectance counts twice"),
        (rho / pi, "rho/pi", "the pixels hold radiance, and were taken for irradiance before they came here"),
        (pi / rho, "pi/rho", "the pixels hold irradiance already: they were made into it twice"),
        (pi * pi, "pi^2", "the factor pi counts twice more"),
        (4.0, "4", "the area or the power of the source is wrong"),
        (0.25, "1/4", "the area or the power of the source is wrong"),
    ];
    let near = |value: f64| (factor / value - 1.0).abs() <= (4.0 * error / factor.abs()).max(2e-3) && value != 1.0;
    let named: Vec<_> = known.iter().filter(|(value, ..)| near(*value)).collect();
    let words = if named.is_empty() {
        format!(
            "a factor of {factor:.4} ± {:.4}, the same everywhere: exposure, a scaled light, a wrong reflectance",
            2.0 * error
        )
    } else {
        let names: Vec<&str> = named.iter().map(|(_, name, _)| *name).collect();
        let whys: Vec<&str> = named.iter().map(|(_, _, why)| *why).collect();
        format!("a factor {} (fitted: {factor:.4}): {}", names.join(" = "), whys.join("; or "))
    };
    let values = fit.pixels.iter().map(|pixel| Some(factor * pixel.truth.irradiance)).collect();
    vec![Hypothesis { name: "factor", words, values, slack: 0.0 }]
}

/// The right image in the wrong place.
fn moved(fit: &Fit, grid: &PixelGrid) -> Vec<Hypothesis> {
    let (width, height) = (grid.width as isize, grid.height as isize);
    let at = |column: isize, row: isize| {
        let inside = (0..width).contains(&column) && (0..height).contains(&row);
        inside.then(|| fit.truth((row * width + column) as usize).irradiance)
    };
    let picture =
        |name: &'static str, words: &str, slack: f64, value: &dyn Fn(isize, isize) -> Option<f64>| Hypothesis {
            name,
            words: words.to_owned(),
            values: (0..height)
                .flat_map(|row| (0..width).map(move |column| (column, row)))
                .map(|(c, r)| value(c, r))
                .collect(),
            slack,
        };
    let mut found = vec![
        picture("mirrored", "the image is mirrored left to right", 0.0, &|c, r| at(width - 1 - c, r)),
        picture("mirrored", "the image is upside down (mirrored top to bottom)", 0.0, &|c, r| at(c, height - 1 - r)),
        picture("turned", "the image is turned by half a turn", 0.0, &|c, r| at(width - 1 - c, height - 1 - r)),
    ];
    if width == height {
        found.push(picture("transposed", "the image is transposed: rows and columns are exchanged", 0.0, &|c, r| {
            at(r, c)
        }));
        found.push(picture("turned", "the image is turned by a quarter to the right", 0.0, &|c, r| {
            at(r, height - 1 - c)
        }));
        found.push(picture("turned", "the image is turned by a quarter to the left", 0.0, &|c, r| {
            at(width - 1 - r, c)
        }));
    }
    // Half a pixel on: the mean of two exact means is that of the two halves, but for third derivatives.
    let name = |step: isize, plus: &'static str, minus: &'static str| match step {
        0 => "",
        1 => plus,
        _ => minus,
    };
    for (half, slack, what) in [(true, 0.02, "half a pixel"), (false, 0.0, "a pixel")] {
        for (dc, dr) in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)] {
            let sideways = [name(dc, "right", "left"), name(dr, "down", "up")];
            let words = format!(
                "the image is shifted by {what}: {}",
                sideways.into_iter().filter(|w| !w.is_empty()).collect::<Vec<_>>().join(" and ")
            );
            let value = |c: isize, r: isize| {
                if half { half_shifted(&at, [c, r], [dc, dr]) } else { at(c - dc, r - dr) }
            };
            found.push(picture("shifted", &words, slack, &value));
        }
    }
    found
}

/// The mean over a footprint half a pixel back, from the exact means of four pixels: (9 (a + b) − (c + d)) / 16, which the
/// integral of a cubic gives (the same rule, of its primitive, at both ends).
fn half_shifted(at: &dyn Fn(isize, isize) -> Option<f64>, [c, r]: [isize; 2], [dc, dr]: [isize; 2]) -> Option<f64> {
    let between = |value: &dyn Fn(isize) -> Option<f64>, step: isize| -> Option<f64> {
        if step == 0 {
            return value(0);
        }
        let near = value(0)? + value(-step)?;
        match (value(step), value(-2 * step)) {
            (Some(a), Some(b)) => Some((9.0 * near - (a + b)) / 16.0),
            _ => Some(0.5 * near),
        }
    };
    between(&|j| between(&|i| at(c + i, r + j), dc), dr)
}

/// Light where none is due, everything else being right.
fn leak(fit: &Fit) -> Option<(Cause, f64)> {
    let dark = |pixel: &&Pixel| pixel.truth.region == Some(Region::Umbra);
    let (count, light) =
        fit.pixels.iter().filter(dark).fold((0.0, 0.0), |(n, sum), pixel| (n + 1.0, sum + pixel.mean));
    if light <= 0.0 {
        return None;
    }
    let rest = fit.pixels.iter().enumerate().filter(|(_, pixel)| !dark(pixel));
    let (mut squares, mut n) = (0.0, 0.0);
    for (p, pixel) in rest.filter(|(p, _)| fit.weight(*p) > 0.0) {
        squares += fit.weight(p) * (pixel.mean - pixel.truth.irradiance).powi(2);
        n += 1.0;
    }
    let is_right = n > 0.0 && squares <= n + 6.0 * (2.0_f64 * n).sqrt();
    let unoccluded = fit.pixels.iter().filter(dark).map(|pixel| pixel.truth.unoccluded).sum::<f64>();
    is_right.then(|| {
        let words = format!(
            "light leaks into the umbra ({:.3e} W/m2 on average, {:.3} % of what would be there without occluders); the rest is right: \
             a bias of shadow rays that is too large, an occluder with a gap, or interreflection",
            light / count,
            100.0 * light / unoccluded.max(f64::MIN_POSITIVE)
        );
        (Cause { name: "leak", words, explained: 1.0 }, 0.0)
    })
}

/// Values at the middles of pixels, something added, highlights cut off, a cosine lost.
fn others(fit: &Fit, case: &Case, grid: &PixelGrid) -> Vec<Hypothesis> {
    let all = |value: &dyn Fn(&Pixel) -> f64| fit.pixels.iter().map(|pixel| Some(value(pixel))).collect::<Vec<_>>();
    let centres = Hypothesis {
        name: "middles",
        words: "pixels hold the value in their middle, not their mean: jitter within the pixel is off".to_owned(),
        values: all(&|pixel| pixel.truth.middle),
        slack: 0.0,
    };
    let (mut weighed, mut weights) = (0.0, 0.0);
    for (p, pixel) in fit.pixels.iter().enumerate() {
        weighed += fit.weight(p) * (pixel.mean - pixel.truth.irradiance);
        weights += fit.weight(p);
    }
    let added = if weights > 0.0 { weighed / weights } else { 0.0 };
    let constant = Hypothesis {
        name: "added",
        words: format!("{added:+.3e} W/m2 is added everywhere: ambient light, an environment, or a background"),
        values: all(&|pixel| pixel.truth.irradiance + added),
        slack: 0.0,
    };
    let most = fit.pixels.iter().map(|pixel| pixel.mean).fold(0.0, f64::max);
    let clamped = Hypothesis {
        name: "clamped",
        words: format!("highlights are clamped at {most:.4} W/m2"),
        values: all(&|pixel| pixel.truth.irradiance.min(most)),
        slack: 0.0,
    };
    let mut found = vec![centres, constant, clamped];
    for (lost, words) in [
        ([true, false], "the cosine at the receiver is missing"),
        ([false, true], "the cosine at the source is missing"),
        ([true, true], "both cosines are missing"),
    ] {
        let values = (0..fit.pixels.len()).map(|p| without_cosines(fit, case, grid, p, lost)).collect();
        found.push(Hypothesis { name: "cosine", words: words.to_owned(), values, slack: 0.01 });
    }
    found
}

/// The exact mean of a lit pixel times what the lost cosines make of its middle.
fn without_cosines(
    fit: &Fit,
    case: &Case,
    grid: &PixelGrid,
    p: usize,
    [at_receiver, at_source]: [bool; 2],
) -> Option<f64> {
    let truth = fit.truth(p);
    if truth.region != Some(Region::Lit) {
        return None;
    }
    let normal = grid.footprint(grid.place(p))?.normal();
    let x = grid.middle(grid.place(p));
    let (mut whole, mut lacking) = (0.0, 0.0);
    for source in case.configuration.sources() {
        for (y, on_source, area) in points_on(source) {
            let to = y - x;
            let distance = to.length();
            let (cos_i, cos_s) = (normal.dot(to) / distance, -on_source.dot(to) / distance);
            if cos_i <= 0.0 || cos_s <= 0.0 {
                continue;
            }
            let rest = area * source.exitance().watts_per_square_metre() / (distance * distance);
            whole += rest * cos_i * cos_s;
            lacking += rest * if at_receiver { 1.0 } else { cos_i } * if at_source { 1.0 } else { cos_s };
        }
    }
    (whole > 0.0).then(|| truth.irradiance * lacking / whole)
}

/// 128 points on a source in the middles of equal squares: place, normal, area, metres.
fn points_on(source: &Source) -> Vec<(glam::DVec3, glam::DVec3, f64)> {
    let Some(surface) = Surface::new(source.shape()) else { return Vec::new() };
    let mut squares = Squares::default();
    let rows = squares.u.len();
    for g in 0..rows {
        for l in 0..LANES {
            squares.u[g][l] = (g as f64 + 0.5) / rows as f64;
            squares.v[g][l] = (l as f64 + 0.5) / LANES as f64;
        }
    }
    let mut block = SurfaceBlock::default();
    let n = rows * LANES;
    surface.place(&squares, n, &mut block);
    let place = |i: usize| {
        let (g, l) = (i / LANES, i % LANES);
        let offset = glam::DVec3::new(block.x[g][l], block.y[g][l], block.z[g][l]);
        let normal = surface.flat_normal().unwrap_or_else(|| offset.normalize_or_zero());
        (surface.origin() + offset, normal, surface.area() / n as f64)
    };
    (0..n).map(place).collect()
}
