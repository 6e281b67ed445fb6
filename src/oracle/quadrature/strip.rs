//! The integral along one strip.
//!
//! Along a strip at distance y from the eye, t from the foot's perpendicular, the form factor's integrand is
//!
//! ```text
//! h (α + γ t) / (π (t² + c)²),    c = y² = h² + s²,  α + γ t = n·r
//! ```
//!
//! with an antiderivative; of an exitance that varies it is integrated numerically.

use std::cell::Cell;

use glam::DVec3;

use super::grain::SeenGrain;
use super::rule::{self, Demand, Ends, PER_PI, around_a_peak};
use super::view::{Cosine, Stretch, Strip, View};
use crate::number::gauss_10;

/// Exitance (any unit) at a place on the source, given relative to the source's centre in the bodies' unit.
pub(super) type Emission<'a> = &'a dyn Fn(DVec3) -> f64;

/// What one strip, or all of them together, hold of the source's form factor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Held {
    /// Of what is seen, and of what is above the horizon.
    pub visible: f64,
    pub whole: f64,
    /// How far off `visible` may be because its ends are.
    pub doubt: f64,
    /// The same with the emission as a weight.
    pub visible_emission: f64,
    pub whole_emission: f64,
    /// ∫ |emission|, and the error of the integrals along strips.
    pub emission_size: f64,
    pub emission_error: f64,
}

pub(super) const N: usize = 7;

impl Held {
    pub fn to_array(self) -> [f64; N] {
        let Held { visible, whole, doubt, visible_emission, whole_emission, emission_size, emission_error } = self;
        [visible, whole, doubt, visible_emission, whole_emission, emission_size, emission_error]
    }
    pub fn from_array(a: [f64; N]) -> Held {
        let [visible, whole, doubt, visible_emission, whole_emission, emission_size, emission_error] = a;
        Held { visible, whole, doubt, visible_emission, whole_emission, emission_size, emission_error }
    }
}

/// What was met on any strip.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sight {
    pub seen: bool,
    pub hidden: bool,
    /// Part of the source is below the horizon.
    pub cut: bool,
}

/// Goes along strips; keeps its lists from one to the next.
pub(super) struct Walk<'a> {
    view: &'a View<'a>,
    emission: Option<Emission<'a>>,
    grain: Option<&'a SeenGrain>,
    pub sight: Sight,
    /// Times the emission was asked for.
    pub asked: Cell<usize>,
    inside: Vec<Stretch>,
    covered: Vec<Stretch>,
}

/// Times that an emission is asked for at one measurement point before what was found has to do.
pub(super) const PATIENCE: usize = 20_000_000;

impl<'a> Walk<'a> {
    pub fn new(view: &'a View<'a>, emission: Option<Emission<'a>>, grain: Option<&'a SeenGrain>) -> Walk<'a> {
        Walk {
            view,
            emission,
            grain,
            sight: Sight::default(),
            asked: Cell::new(0),
            inside: Vec::new(),
            covered: Vec::new(),
        }
    }

    pub fn along(&mut self, sigma: f64) -> Held {
        let mut held = Held::default();
        let view = self.view;
        let strip = view.strip(sigma);
        let line = Line::new(view, &strip);
        let mut inside = std::mem::take(&mut self.inside);
        view.inside(sigma, &mut inside);
        self.covered.clear();
        for blocker in &view.blockers {
            blocker.cover(view, &strip, &mut self.covered);
        }
        self.covered.sort_by(|a, b| a.from.total_cmp(&b.from));
        for stretch in &inside {
            if let Some(above) = self.above(&line, *stretch) {
                self.stretch(&line, above, &mut held);
            }
        }
        self.inside = inside;
        held
    }

    /// What of a stretch is above the horizon.
    fn above(&mut self, line: &Line, mut stretch: Stretch) -> Option<Stretch> {
        let horizon = -line.cosine.level / line.cosine.slope;
        let rounding = (line.cosine.level_doubt + line.cosine.slope_doubt * horizon.abs()) / line.cosine.slope.abs();
        let all_above = |at: f64| line.cosine.level + line.cosine.slope * at > 0.0;
        match (all_above(stretch.from), all_above(stretch.to)) {
            (true, true) => return Some(stretch),
            (true, false) => (stretch.to, stretch.doubt_to) = (horizon, rounding),
            (false, true) => (stretch.from, stretch.doubt_from) = (horizon, rounding),
            (false, false) => {}
        }
        self.sight.cut = true;
        (all_above(stretch.from) || all_above(stretch.to)).then_some(stretch)
    }

    fn stretch(&mut self, line: &Line, own: Stretch, held: &mut Held) {
        if own.to <= own.from {
            return;
        }
        let whole = line.integral(own.from, own.to);
        held.whole += whole;
        let mut is_whole = true;
        let mut at = (own.from, own.doubt_from);
        let covered = std::mem::take(&mut self.covered);
        for next in &covered {
            if next.from >= own.to {
                break;
            }
            if next.to <= at.0 {
                continue;
            }
            is_whole = false;
            self.gap(line, at, (next.from, next.doubt_from), held);
            let hidden = next.to.min(own.to) - next.from.max(own.from);
            self.sight.hidden |= hidden > next.doubt_from + next.doubt_to + own.doubt_from + own.doubt_to;
            at = (next.to, next.doubt_to);
        }
        self.covered = covered;
        if is_whole {
            held.visible += whole;
            self.sight.seen = true;
            held.doubt += line.value(own.from) * own.doubt_from + line.value(own.to) * own.doubt_to;
            held.doubt += line.cosine_doubt(own.from, own.to);
        } else {
            self.gap(line, at, (own.to, own.doubt_to), held);
        }
        if let Some(emission) = self.emission {
            let (value, size, error) = self.emitted(line, emission, own.from, own.to);
            held.whole_emission += value;
            held.emission_size += size;
            held.emission_error += error;
            if is_whole {
                held.visible_emission += value;
            }
        }
    }

    /// A stretch that is seen, if it is one.
    fn gap(&mut self, line: &Line, from: (f64, f64), to: (f64, f64), held: &mut Held) {
        let doubt = from.1 + to.1;
        if to.0 - from.0 <= -doubt {
            return;
        }
        // Between outlines that lie on one another there is a gap or none, as rounding will have it.
        let (low, high) = (from.0.min(to.0), from.0.max(to.0));
        held.doubt += line.value(low) * from.1 + line.value(high) * to.1;
        if to.0 - from.0 <= doubt {
            return;
        }
        self.sight.seen = true;
        held.visible += line.integral(from.0, to.0);
        held.doubt += line.cosine_doubt(from.0, to.0);
        if let Some(emission) = self.emission {
            let (value, _, error) = self.emitted(line, emission, from.0, to.0);
            held.visible_emission += value;
            held.emission_error += error;
        }
    }

    /// ∫ emission × integrand, ∫ |emission| × integrand, and the error.
    ///
    /// Features of the emission that are narrower than a hundredth of the source may be missed.
    fn emitted(&self, line: &Line, emission: Emission, from: f64, to: f64) -> (f64, f64, f64) {
        /// Equal parts of a strip to begin with.
        const PARTS: i32 = 4;
        const BUDGET: usize = 800;
        let view = self.view;
        let emitted = |tau: f64| {
            self.asked.set(self.asked.get() + 1);
            emission(view.on_source(line.strip, tau) * view.unit)
        };
        if let Some(grain) = self.grain.filter(|grain| grain.is_constant_between) {
            let mut ends = vec![from, to];
            grain.cross(view, line.strip, from, to, &mut ends);
            ends.sort_by(f64::total_cmp);
            let parts = ends.windows(2).filter(|pair| pair[1] > pair[0]);
            // What is constant comes out of the integral.
            let (mut value, mut size) = (0.0, 0.0);
            for pair in parts {
                let part = emitted(0.5 * (pair[0] + pair[1])) * line.integral(pair[0], pair[1]);
                value += part;
                size += part.abs();
            }
            return (value, size, 0.0);
        }
        let mut ends: Vec<f64> = (1..PARTS).map(|i| from + (to - from) * (f64::from(i) / f64::from(PARTS))).collect();
        around_a_peak(-view.anchor[1], line.strip.y, from, to, &mut ends);
        match self.grain {
            Some(grain) => grain.cross(view, line.strip, from, to, &mut ends),
            None => jumps(from, to, emitted, &mut ends),
        }
        ends.extend([from, to]);
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let integrand = |tau: f64| {
            let weighted = emitted(tau) * line.value(tau);
            [weighted, weighted.abs()]
        };
        let demand = |sum: &[f64; 2]| Demand {
            goal: [1e-13 * sum[1], f64::INFINITY],
            floor: |panel| [8.0 * f64::EPSILON * panel[1], 0.0],
        };
        // A sphere turns away at its silhouette.
        let form = if view.ball.is_some() { Ends::Roots } else { Ends::Smooth };
        let budget = if self.asked.get() < PATIENCE { BUDGET } else { 0 };
        let narrowest = 4.0 * f64::EPSILON * from.abs().max(to.abs());
        let found = rule::integrate(&ends, form, narrowest, budget, integrand, demand);
        (found.value[0], found.value[1], found.error[0])
    }
}

/// Finds where a function jumps, by halving where it changes much between samples: cheaper by far than by quadrature.
/// What it misses is left to the rule's own error.
fn jumps(from: f64, to: f64, f: impl Fn(f64) -> f64, found: &mut Vec<f64>) {
    const SAMPLES: i32 = 64;
    /// Of the range of all samples.
    const MUCH: f64 = 0.04;
    let at = |i: i32| from + (to - from) * ((f64::from(i) + 0.5) / f64::from(SAMPLES));
    let samples: Vec<(f64, f64)> = (0..SAMPLES).map(|i| (at(i), f(at(i)))).collect();
    let (low, high) =
        samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, y)| (low.min(*y), high.max(*y)));
    for pair in samples.windows(2) {
        let (mut left, mut right) = (pair[0], pair[1]);
        let step = (right.1 - left.1).abs();
        // It may jump twice: then one of both is found here.
        while (right.1 - left.1).abs() > (0.5 * step).max(MUCH * (high - low)) {
            let middle = 0.5 * (left.0 + right.0);
            if middle <= left.0 || middle >= right.0 {
                found.push(middle);
                break;
            }
            let here = (middle, f(middle));
            if (here.1 - left.1).abs() < (here.1 - right.1).abs() {
                left = here;
            } else {
                right = here;
            }
        }
    }
}

/// The integrand on one strip.
struct Line<'a> {
    strip: &'a Strip,
    height: f64,
    /// t of τ = 0.
    middle: f64,
    cosine: Cosine,
}

impl Line<'_> {
    fn new<'a>(view: &View, strip: &'a Strip) -> Line<'a> {
        Line { strip, height: view.height, middle: view.anchor[1], cosine: view.cosine(strip) }
    }

    fn value(&self, tau: f64) -> f64 {
        let t = self.middle + tau;
        let square = t * t + self.strip.y * self.strip.y;
        // Ends at infinity belong to gaps that are none.
        if square.is_finite() {
            self.height * PER_PI * (self.cosine.level + self.cosine.slope * tau).max(0.0) / (square * square)
        } else {
            0.0
        }
    }

    /// What rounding of n·r makes of the integral: close to the horizon much of it.
    fn cosine_doubt(&self, from: f64, to: f64) -> f64 {
        let Cosine { level_doubt, slope_doubt, .. } = self.cosine;
        let off = if self.middle == 0.0 {
            // ∫ |t| dt/(t² + c)² = t |t| / (2 c (t² + c))
            let c = self.strip.y * self.strip.y;
            let odd = |t: f64| t * t.abs() / (2.0 * c * (t * t + c));
            level_doubt * self.even(from, to) + slope_doubt * (odd(to) - odd(from)).abs()
        } else {
            (level_doubt + slope_doubt * from.abs().max(to.abs())) * self.even(from, to)
        };
        off * self.height * PER_PI
    }

    /// ∫ dt/(t² + c)² from τ = `from` to `to`.
    fn even(&self, from: f64, to: f64) -> f64 {
        let y = self.strip.y;
        let c = y * y;
        let (a, b) = (self.middle + from, self.middle + to);
        let (aa, bb) = (a * a + c, b * b + c);
        // Terms of one sign, or the difference of two that are far from equal if the ends are.
        if a * b <= c {
            let angle = ((b - a) * y).atan2(c + a * b);
            ((b - a) * (c - a * b) / (aa * bb) + angle / y) / (2.0 * c)
        } else {
            let (near, far) = (a.abs().min(b.abs()), a.abs().max(b.abs()));
            let tail = |t: f64| above_sine(2.0 * y.atan2(t));
            (tail(near) - tail(far)) / (4.0 * c * y)
        }
    }

    /// ∫ h (α + γ t)/(π (t² + c)²) dt from τ = `from` to `to`.
    ///
    /// - error: relative to the integral of the integrand's magnitude, below 1e-15
    fn integral(&self, from: f64, to: f64) -> f64 {
        let y = self.strip.y;
        let c = y * y;
        let half = 0.5 * (to - from);
        let middle = self.middle + 0.5 * (from + to);
        if half <= 0.25 * middle.hypot(y) {
            return gauss_10(0.5 * (from + to), half, |tau| self.value(tau));
        }
        let (a, b) = (self.middle + from, self.middle + to);
        let (aa, bb) = (a * a + c, b * b + c);
        let even = self.even(from, to);
        let odd = (b - a) * (b + a) / (2.0 * aa * bb);
        let at_foot = self.cosine.level - self.cosine.slope * self.middle;
        self.height * PER_PI * (at_foot * even + self.cosine.slope * odd)
    }
}

/// x − sin x, for x in [0, π], to a few units in the last place.
fn above_sine(x: f64) -> f64 {
    if x > 1.0 {
        return x - x.sin();
    }
    let square = x * x;
    let mut term = x * square / 6.0;
    let mut sum = term;
    let mut k = 4.0;
    while term.abs() > 1e-17 * sum {
        term *= -square / (k * (k + 1.0));
        sum += term;
        k += 2.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Closed forms against many small Gauss panels, wherever the strip lies.
    #[test]
    fn all_forms_of_the_integral_agree() {
        for y in [1e-6, 1e-3, 0.3, 1.0] {
            for (from, to) in
                [(-1.0, 1.0), (0.0, 1.0), (1e-5, 1.0), (0.01, 0.5), (-1.0, -1e-3), (0.3, 0.4), (-1e-7, 1.0)]
            {
                let strip = Strip { sigma: 0.0, ahead: DVec3::Z, y, across: DVec3::Y };
                let cosine = Cosine { level: 2.0, slope: 0.5, level_doubt: 0.0, slope_doubt: 0.0 };
                let line = Line { strip: &strip, height: y, middle: 0.0, cosine };
                let mut ends = Vec::new();
                around_a_peak(0.0, 0.1 * y, from, to, &mut ends);
                ends.extend([from, to]);
                ends.sort_by(f64::total_cmp);
                let mut expected = 0.0;
                for pair in ends.windows(2) {
                    for i in 0..8 {
                        let width = (pair[1] - pair[0]) / 8.0;
                        let middle = pair[0] + (f64::from(i) + 0.5) * width;
                        expected += gauss_10(middle, 0.5 * width, |t| line.value(t));
                    }
                }
                assert_relative_eq!(line.integral(from, to), expected, max_relative = 5e-15);
            }
        }
    }
}
