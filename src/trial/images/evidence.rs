//! The verdict on the bias of images.
//!
//! An observation is one pixel of one image. Where pixels are independent of one another, each has the exact mean over its
//! footprint and a variance v of its own; then for weights w the product over all observations of
//!
//! ```text
//! exp(λ w d − λ² (w² d² + 2 w² v) / 6)
//! ```
//!
//! is a capital (see [`crate::statistics::evidence`]), and it needs no more than the sums of w d, w² d² and w² v: what
//! [`Capital`] makes of n observations with the mean variance. (For its spread bet: Π (1 + λ² w² v/3) is largest where all
//! are alike.) Where pixels do move together, the variance of sums is larger than Σ w² v; it is measured between the images
//! at each scale ([`super::dependence`]) and taken times that factor.

use super::dependence::Dependence;
use super::exact::PixelTruth;
use super::spread::Variances;
use super::{Data, ImageTerms, PARTS, members, property};
use crate::statistics::evidence::{THRESHOLD_LOG10, ln_average, log10_capped, smallest_shift};
use crate::statistics::interval::Z_95;
use crate::statistics::{Capital, Observed, Statement, Verdict};
use crate::trial::outcome::JudgedProperty;

/// Cosines along each side, 0 included; the mean is judged by itself.
pub(super) const COSINES: usize = 4;
/// Observations that a place has at least: with fewer, no moderate shift is ever seen.
const FEWEST: usize = 48;

/// What a component is about.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Subject {
    /// Of [`PARTS`].
    Part(usize),
    /// Half waves across and downwards.
    Contrast([usize; 2]),
    /// A square of pixels: column, row, side.
    Place([usize; 3]),
}

/// One statement about weighed pixels.
struct Component {
    subject: Subject,
    ln: f64,
    n: u64,
    /// Σ w d / n, W/m².
    deviation: f64,
    /// Of one weighed observation, as judged.
    variance: f64,
    /// The same without what was added for caution.
    plain_variance: f64,
    /// The exact mean, without weights, W/m².
    exact: f64,
    /// The same without occluders.
    unoccluded: f64,
}

/// The verdict, and the evidence of each part's mean.
pub(super) struct Judged {
    pub verdict: JudgedProperty,
    /// Index in [`PARTS`], log10.
    pub parts: Vec<(usize, f64)>,
}

struct Bench<'a> {
    data: &'a Data,
    truths: &'a [PixelTruth],
    variances: &'a Variances,
    tolerance: f64,
}

impl Bench<'_> {
    /// Judges weighed pixels.
    ///
    /// - `inflation`: how much larger the variance of such sums is than that of independent pixels
    fn component(&self, subject: Subject, weighed: impl Iterator<Item = (usize, f64)>, inflation: f64) -> Component {
        let (mut n, mut sum, mut squares, mut margins) = (0.0, 0.0, 0.0, 0.0);
        let (mut variance, mut plain, mut exact, mut unoccluded) = (0.0, 0.0, 0.0, 0.0);
        let mut dark_light = 0.0;
        for (p, w) in weighed {
            let truth = &self.truths[p];
            n += 1.0;
            sum += w * self.data.sums[p][0];
            squares += w * w * self.data.sums[p][1];
            let margin = truth.bound + truth.shifted + self.tolerance * truth.irradiance;
            margins += (w * margin).powi(2);
            variance += w * w * self.variances.high[p];
            plain += w * w * self.variances.plain[p];
            exact += truth.irradiance;
            unoccluded += truth.unoccluded;
            if margin == 0.0 && self.variances.high[p] == 0.0 {
                dark_light += self.data.sums[p][1];
            }
        }
        let images = self.data.n_images as f64;
        let (variance, plain) = (inflation * variance / n, inflation * plain / n);
        let observed = Observed { n: (n * images) as u64, pivot: 0.0, sum, sum_of_squares: squares };
        // Margins as a root mean square: no smaller than their mean, which is what the sum can be off by.
        let statement = Statement::near(0.0, (margins / n).sqrt(), variance);
        let mut ln = Capital::of(&statement, &observed, observed.n).ln();
        if dark_light > 0.0 && matches!(subject, Subject::Part(i) if i > 0) {
            // Light where none is due and none may come is impossible, whatever the others do.
            ln = f64::INFINITY;
        }
        Component {
            subject,
            ln,
            n: observed.n,
            deviation: sum / (n * images),
            variance,
            plain_variance: plain,
            exact: exact / n,
            unoccluded: unoccluded / n,
        }
    }
}

/// Judges the images' bias.
pub(super) fn bias(
    data: &Data,
    truths: &[PixelTruth],
    variances: &Variances,
    dependence: &Dependence,
    terms: &ImageTerms,
    tolerance: f64,
) -> Judged {
    let bench = Bench { data, truths, variances, tolerance };
    let members = members(truths.iter().map(|truth| truth.region));
    let of_part = |(i, members): (usize, &Vec<usize>)| {
        let weighed = members.iter().map(|p| (*p, 1.0));
        (!members.is_empty()).then(|| bench.component(Subject::Part(i), weighed, dependence.whole))
    };
    let parts: Vec<Component> = members.iter().enumerate().filter_map(of_part).collect();
    let waves = contrasts(data);
    let contrasts: Vec<Component> = waves
        .iter()
        .map(|wave| {
            let weighed = (0..data.n_pixels()).map(|p| (p, wave.weight(data.grid.place(p))));
            bench.component(Subject::Contrast(wave.halves), weighed, dependence.whole)
        })
        .collect();
    let scales: Vec<Vec<Component>> = sides(data)
        .into_iter()
        .map(|side| {
            let inflation = dependence.at_side(side);
            let places = tiles(data, side).map(|place| {
                let weighed = pixels_of(data, place).map(|p| (p, 1.0));
                bench.component(Subject::Place(place), weighed, inflation)
            });
            places.collect()
        })
        .collect();
    let places: Vec<f64> = scales.iter().map(|scale| ln_average(scale.iter().map(|c| c.ln))).collect();
    let mut kinds = vec![ln_average(parts.iter().map(|c| c.ln))];
    kinds.extend((!contrasts.is_empty()).then(|| ln_average(contrasts.iter().map(|c| c.ln))));
    kinds.extend((!places.is_empty()).then(|| ln_average(places.iter().copied())));
    let evidence = log10_capped(ln_average(kinds.iter().copied()));

    let whole = &parts[0];
    let mean =
        (whole.exact > 0.0).then(|| smallest_shift(whole.variance, whole.n, kinds.len() * parts.len()) / whole.exact);
    let finest = scales.last();
    let side = sides(data).last().copied();
    let point = finest.and_then(|scale| {
        let among = kinds.len() * scales.len() * scale.len();
        let reached = scale.iter().filter(|c| c.exact >= 0.1 * c.unoccluded && c.exact > 0.0);
        let mut last = (0, 0.0);
        let found = reached.map(|c| {
            if last.0 != c.n {
                last = (c.n, smallest_shift(1.0, c.n, among));
            }
            last.1 * c.variance.sqrt() / c.exact
        });
        found.reduce(f64::max)
    });
    let asked = terms.smallest_bias;
    let seen = |found: Option<f64>, asked: f64| found.is_none_or(|found| found <= asked * (1.0 + 1e-9));
    let verdict = if evidence >= THRESHOLD_LOG10 {
        Verdict::Fail
    } else if finest.is_some() && seen(mean, asked.mean) && seen(point, asked.point) {
        Verdict::Pass
    } else {
        Verdict::Undecided
    };
    let all = parts.iter().chain(&contrasts).chain(scales.iter().flatten());
    // The first of equals: a region before the places in it.
    let worst = all.fold(&parts[0], |worst, component| if component.ln > worst.ln { component } else { worst });
    let shown = if verdict == Verdict::Fail { worst } else { whole };
    let effect = effect(shown, whole);
    let words = match verdict {
        Verdict::Fail => fail_words(data, terms.name, shown, effect),
        Verdict::Pass => pass_words(mean, point, side),
        Verdict::Undecided => undecided_words(data, terms, mean, point, side),
    };
    let mut judged = property("bias", verdict, evidence, effect, words, &terms.reproduce);
    judged.smallest_bias_mean = mean;
    judged.smallest_bias_point = point;
    judged.note = Some(match &data.stated_variance {
        Some(_) => {
            "the variance is not predicted: this leans on what the file states, and on pixels that are independent"
                .to_owned()
        }
        None => format!(
            "the variance is not predicted: this leans on the spread of the {} images, pooled over neighbours and taken two \
             standard errors high",
            data.n_images
        ),
    });
    Judged { verdict: judged, parts: parts.iter().filter_map(part_evidence).collect() }
}

fn part_evidence(component: &Component) -> Option<(usize, f64)> {
    match component.subject {
        Subject::Part(i) => Some((i, log10_capped(component.ln))),
        _ => None,
    }
}

/// A half-wave pattern over the image; its weights have a mean square of one.
pub(super) struct Wave {
    pub halves: [usize; 2],
    pub size: [usize; 2],
}

impl Wave {
    pub fn weight(&self, place: [usize; 2]) -> f64 {
        let along = |axis: usize| {
            let halves = self.halves[axis];
            let phase = std::f64::consts::PI * halves as f64 * (place[axis] as f64 + 0.5) / self.size[axis] as f64;
            if halves == 0 { 1.0 } else { std::f64::consts::SQRT_2 * libm::cos(phase) }
        };
        along(0) * along(1)
    }
}

/// Cosines across and downwards, as far as there are pixels for them; without the mean.
pub(super) fn contrasts(data: &Data) -> Vec<Wave> {
    let size = [data.grid.width, data.grid.height];
    let halves = (0..COSINES.min(size[1])).flat_map(|j| (0..COSINES.min(size[0])).map(move |i| [i, j]));
    halves.filter(|halves| *halves != [0, 0]).map(|halves| Wave { halves, size }).collect()
}

/// Sides of places, in pixels, from a quarter of the image to the smallest that holds enough observations.
pub(super) fn sides(data: &Data) -> Vec<usize> {
    let longest = data.grid.width.max(data.grid.height);
    let mut side = (longest / 4).max(1).next_power_of_two();
    let mut sides = Vec::new();
    loop {
        if side * side * data.n_images >= FEWEST {
            sides.push(side);
        }
        if side == 1 {
            return sides;
        }
        side /= 2;
    }
}

/// Squares of that side that fill the image, from the upper left; those at the end may be narrower.
pub(super) fn tiles(data: &Data, side: usize) -> impl Iterator<Item = [usize; 3]> {
    let (width, height) = (data.grid.width, data.grid.height);
    (0..height).step_by(side).flat_map(move |row| (0..width).step_by(side).map(move |column| [column, row, side]))
}

pub(super) fn pixels_of(data: &Data, [column, row, side]: [usize; 3]) -> impl Iterator<Item = usize> {
    let (width, height) = (data.grid.width, data.grid.height);
    let columns = column..(column + side).min(width);
    (row..(row + side).min(height)).flat_map(move |r| columns.clone().map(move |c| r * width + c))
}

/// Relative deviation and its 95 % interval; of a contrast relative to the mean, of the dark to what would be without
/// occluders.
fn effect(component: &Component, whole: &Component) -> [f64; 3] {
    let scale = match component.subject {
        Subject::Contrast(_) => whole.exact,
        _ if component.exact > 0.0 => component.exact,
        _ if component.unoccluded > 0.0 => component.unoccluded,
        _ => 1.0,
    };
    let reach = Z_95 * (component.plain_variance / component.n as f64).sqrt() / scale;
    let effect = component.deviation / scale;
    [effect, effect - reach, effect + reach]
}

fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

/// What a place of that side is called.
fn squares(side: Option<usize>) -> String {
    match side {
        Some(1) => "pixel".to_owned(),
        Some(side) => format!("{side} x {side} pixels"),
        None => "pixel".to_owned(),
    }
}

fn pass_words(mean: Option<f64>, point: Option<f64>, side: Option<usize>) -> String {
    let whose = squares(side);
    match (mean, point) {
        (Some(mean), Some(point)) => format!(
            "no bias above {} in the mean, {} at the worst {whose} that a tenth of the light reaches",
            percent(mean),
            percent(point)
        ),
        (Some(mean), None) => {
            format!("no bias above {} in the mean; no {whose} is lit by a tenth or more", percent(mean))
        }
        (None, _) => "no light is due in any pixel and none arrived".to_owned(),
    }
}

fn fail_words(data: &Data, name: &str, component: &Component, [effect, low, high]: [f64; 3]) -> String {
    let place = match component.subject {
        Subject::Part(0) => "in the mean over the image".to_owned(),
        Subject::Part(i) if component.exact == 0.0 => {
            return format!(
                "{name} has light where none is due, in the {}: {:.3e} W/m2 on average, {:.3} % of what would be without occluders",
                PARTS[i].0,
                component.deviation,
                100.0 * effect
            );
        }
        Subject::Part(i) => format!("in the mean over the region `{}`", PARTS[i].0),
        Subject::Contrast([i, j]) => {
            format!("in a contrast of {i} half waves across and {j} downwards, relative to the mean")
        }
        Subject::Place([column, row, 1]) => format!("in the pixel of column {column}, row {row}"),
        Subject::Place([column, row, side]) => {
            let end = [(column + side).min(data.grid.width) - 1, (row + side).min(data.grid.height) - 1];
            format!("in the pixels of columns {column} to {}, rows {row} to {}", end[0], end[1])
        }
    };
    format!("{name} is biased by {:+.3} % ± {:.3} % {place}", 100.0 * effect, 50.0 * (high - low))
}

fn undecided_words(
    data: &Data,
    terms: &ImageTerms,
    mean: Option<f64>,
    point: Option<f64>,
    side: Option<usize>,
) -> String {
    let asked = terms.smallest_bias;
    if side.is_none() {
        return format!(
            "too little evidence: {} images of {} x {} pixels are too few observations for any place; {FEWEST} of a pixel \
             would do",
            data.n_images, data.grid.width, data.grid.height
        );
    }
    let mut factor = 1.0_f64;
    for (found, asked) in [(mean, asked.mean), (point, asked.point)] {
        factor = factor.max(found.map_or(1.0, |found| (found / asked).powi(2)));
    }
    let found = |x: Option<f64>| x.map_or("nothing".to_owned(), percent);
    let images = data.n_images as f64 * factor;
    let how = if images.is_finite() {
        format!("about {images:.0} images would do")
    } else {
        "no number is enough".to_owned()
    };
    format!(
        "too little evidence: a bias of {} in the mean ({} asked) and {} at the worst {} ({} asked) would have been seen; {how}",
        found(mean),
        percent(asked.mean),
        found(point),
        squares(side),
        percent(asked.point)
    )
}
