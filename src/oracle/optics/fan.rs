//! Rays with an axis of symmetry, and where they land: the map from a ray's parameter to its landing radius, its folds, and
//! all rays that land at one radius.

use smallvec::SmallVec;

use crate::number::{Dual, Number, Wide};

/// Rays around an axis, told by one parameter u ≥ 0 that is zero on it.
///
/// The text is written once over any number: `f64` for a first look, [`Wide`] for the last bits, duals of either for slopes.
pub(super) trait Fan {
    /// Where the ray meets the receiver's plane: distance from the axis, negative where it has crossed it. Metres; an odd
    /// function of u.
    fn landing<T: Number>(&self, u: T) -> T;
    /// Incident flux between the axis and the ray, over 2π: m² for a beam of unit irradiance, sr for a unit intensity. An
    /// even function of u.
    fn flux<T: Number>(&self, u: T) -> T;
    /// The share of it that arrives, in [0, 1].
    fn share(&self, u: f64) -> f64;
    /// Whether that share is one for all rays.
    fn is_lossless(&self) -> bool;
    /// The last ray.
    fn last(&self) -> Wide;
    /// A length that the layout's others are compared with, metres.
    fn size(&self) -> f64;
}

/// A ray between which and the next such one the landing radius is monotone, or an end of the fan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    pub u: Wide,
    pub landing: Wide,
    /// Whether the map turns around here: a ring caustic at this radius.
    pub is_fold: bool,
}

/// Places at which the second derivative is first looked at for changes of its sign. Limit: two changes between neighbouring
/// places would go unnoticed, and with them a pair of folds that close together.
const LOOKS: u32 = 256;

type First<T> = Dual<1, T>;
type Second<T> = Dual<1, Dual<1, T>>;

fn with_slope<T: Number>(u: T) -> First<T> {
    Dual { value: u, slopes: [T::constant(1.0)] }
}

fn with_bend<T: Number>(u: T) -> Second<T> {
    Dual { value: with_slope(u), slopes: [Dual::constant(1.0)] }
}

/// f and f′.
pub(super) fn jet<T: Number>(f: impl Fn(First<T>) -> First<T>, u: T) -> (T, T) {
    let at = f(with_slope(u));
    (at.value, at.slopes[0])
}

/// f, f′ and f″.
pub(super) fn second_jet<T: Number>(f: impl Fn(Second<T>) -> Second<T>, u: T) -> [T; 3] {
    let at = f(with_bend(u));
    [at.value.value, at.value.slopes[0], at.slopes[0].slopes[0]]
}

/// The landing radius and its first two derivatives.
pub(super) fn landing_jet<F: Fan, T: Number>(fan: &F, u: T) -> [T; 3] {
    second_jet(|u| fan.landing(u), u)
}

/// The fan's ends and the folds between them, in order.
///
/// The second derivative is looked at in 256 places; between its zeros the slope is monotone and has at most one zero, which
/// its signs at the ends tell, and which is taken to the last bits of a [`Wide`].
pub(super) fn knots<F: Fan>(fan: &F) -> Vec<Knot> {
    let last = fan.last();
    let at = |i: u32| last.primal() * (f64::from(i) / f64::from(LOOKS));
    let jets: Vec<[f64; 3]> = (0..LOOKS).map(|i| landing_jet(fan, at(i))).collect();
    let mut inflections: Vec<f64> = vec![0.0];
    for (i, pair) in jets.windows(2).enumerate() {
        if pair[0][2] * pair[1][2] < 0.0 {
            // Roughly: the slope is near its extreme all around.
            let (mut low, mut high) = (at(i as u32), at(i as u32 + 1));
            for _ in 0..48 {
                let middle = 0.5 * (low + high);
                if landing_jet(fan, middle)[2] * pair[0][2] > 0.0 { low = middle } else { high = middle }
            }
            inflections.push(0.5 * (low + high));
        }
    }
    let knot = |u: Wide, is_fold: bool| Knot { u, landing: fan.landing(u), is_fold };
    let mut knots = vec![knot(Wide::ZERO, false)];
    let stretches = inflections.iter().map(|u| Wide::from(*u)).chain([last]).collect::<Vec<_>>();
    for pair in stretches.windows(2) {
        let slope = |u: Wide| {
            let [_, slope, bend] = landing_jet(fan, u);
            (slope, bend)
        };
        if slope(pair[0]).0.primal() * slope(pair[1]).0.primal() < 0.0 {
            knots.push(knot(root(pair[0], pair[1], None, slope), true));
        }
    }
    knots.push(knot(last, false));
    knots
}

/// All rays that land on a circle around the axis, to the digits of the number asked for.
///
/// - `radius`: ≥ 0 (on the axis both signs of the landing radius are one)
/// - `narrowed`: a [`Wide`] as the number asked for
pub(super) fn preimages<F: Fan, T: Number>(
    fan: &F,
    knots: &[Knot],
    radius: f64,
    narrowed: impl Fn(Wide) -> T,
) -> SmallVec<[T; 4]> {
    let mut found: SmallVec<[T; 4]> = SmallVec::new();
    let signed: &[f64] = if radius == 0.0 { &[0.0] } else { &[1.0, -1.0] };
    for sign in signed {
        let wanted = sign * radius;
        for pair in knots.windows(2) {
            let over = |knot: &Knot| (knot.landing + Wide::from(-wanted)).primal();
            let (low, high) = (over(&pair[0]), over(&pair[1]));
            // A ray on a knot between two stretches is one ray; the first and the last belong to the fan.
            let is_last = pair[1].u.primal() >= knots[knots.len() - 1].u.primal();
            let u = if low == 0.0 {
                narrowed(pair[0].u)
            } else if high == 0.0 {
                if !is_last {
                    continue;
                }
                narrowed(pair[1].u)
            } else if low * high < 0.0 {
                let start = root(pair[0].u.primal(), pair[1].u.primal(), None, |u: f64| {
                    let (landing, slope) = jet(|u| fan.landing(u), u);
                    (landing - wanted, slope)
                });
                let f = |u: T| {
                    let (landing, slope) = jet(|u| fan.landing(u), u);
                    (landing + -wanted, slope)
                };
                if T::CANCELS_FREELY {
                    root(narrowed(pair[0].u), narrowed(pair[1].u), Some(start), f)
                } else {
                    T::constant(start)
                }
            } else {
                continue;
            };
            found.push(u);
        }
    }
    found
}

/// Steps after which a root is taken as it is: halving alone brings any interval to the last bits of a [`Wide`] in this many.
const MOST_STEPS: u32 = 240;

/// The root of a function between two places where its signs differ: Newton's steps, and halving where they leave the bracket
/// or do not get shorter.
///
/// - `f`: value and slope
/// - `start`: a first guess
/// - error: the last bits of the number, times the function's rounding over its slope
pub(super) fn root<T: Number>(low: T, high: T, start: Option<f64>, f: impl Fn(T) -> (T, T)) -> T {
    let (mut low, mut high) = (low, high);
    let last_bits = if T::CANCELS_FREELY { 1e-30 } else { 0.5 * f64::EPSILON };
    let rises = f(low).0.primal() < 0.0;
    let middle = |low: T, high: T| low + (high - low) * 0.5;
    let within = |x: T, low: T, high: T| (x - low).primal() > 0.0 && (high - x).primal() > 0.0;
    let mut x = match start {
        Some(start) if within(T::constant(start), low, high) => T::constant(start),
        _ => middle(low, high),
    };
    let mut last_step = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let (value, slope) = f(x);
        let said = value.primal();
        if said == 0.0 {
            return x;
        }
        if (said < 0.0) == rises {
            low = x
        } else {
            high = x
        }
        let newton = x - value / slope;
        let step = (newton - x).primal().abs();
        let is_good = step.is_finite() && within(newton, low, high) && step <= 0.5 * last_step;
        let next = if is_good { newton } else { middle(low, high) };
        let moved = (next - x).primal().abs();
        // A Newton step this short is the error of the last guess: the next would square it.
        if step <= last_bits * x.primal().abs()
            || moved == 0.0
            || (high - low).primal() <= last_bits * x.primal().abs()
        {
            return if is_good { newton } else { x };
        }
        last_step = if is_good { step } else { f64::INFINITY };
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_to_the_last_bits_of_each_number() {
        let cube = |x: f64| (x * x * x - 2.0, 3.0 * x * x);
        assert!((root(0.0, 2.0, None, cube) - 2.0_f64.cbrt()).abs() < 4e-16);
        let wide = root(Wide::ZERO, Wide::from(2.0), Some(1.26), |x| (x * x * x + -2.0, x * x * 3.0));
        assert!((wide * wide * wide + -2.0).primal().abs() < 1e-28);
        // Flat at the root's side: Newton alone would crawl.
        let flat = root(-1.0, 1.0, None, |x: f64| (x.powi(5), 5.0 * x.powi(4)));
        assert!(flat.abs() < 1e-60, "{flat:e}");
    }
}
