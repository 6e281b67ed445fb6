//! Gauss–Legendre quadrature, and panels that shrink towards an end.

use std::f64::consts::PI;

/// A rule on [0, 1].
pub struct Gauss(Vec<[f64; 2]>);

impl Gauss {
    /// Nodes by Newton's method on Pₙ; exact for polynomials of degree 2 n − 1.
    pub fn new(n: u32) -> Gauss {
        let order = f64::from(n);
        let node = |i: u32| {
            let mut x = (PI * (f64::from(i) + 0.75) / (order + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..8 {
                let (mut last, mut value) = (1.0, x);
                for k in 2..=n {
                    let k = f64::from(k);
                    (last, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * last) / k);
                }
                slope = order * (x * value - last) / ((x - 1.0) * (x + 1.0));
                x -= value / slope;
            }
            [0.5 * (1.0 + x), 1.0 / ((1.0 - x) * (1.0 + x) * slope * slope)]
        };
        Gauss((0..n).map(node).collect())
    }

    /// ∫ f over [low, high].
    pub fn over(&self, [low, high]: [f64; 2], mut f: impl FnMut(f64) -> f64) -> f64 {
        (high - low) * self.0.iter().map(|[x, weight]| weight * f(low + (high - low) * x)).sum::<f64>()
    }

    /// The same over panels between the given places.
    pub fn between(&self, places: &[f64], mut f: impl FnMut(f64) -> f64) -> f64 {
        places.windows(2).map(|pair| self.over([pair[0], pair[1]], &mut f)).sum()
    }

    /// ∫ f over [low, high], where f may leave either end like a half-integer power: t = middle + half · sin φ.
    pub fn over_with_roots(&self, [low, high]: [f64; 2], mut f: impl FnMut(f64) -> f64) -> f64 {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        self.between(&[-0.5 * PI, 0.0, 0.5 * PI], |phi| half * phi.cos() * f(middle + half * phi.sin()))
    }
}

/// Places from 0 up to `high`, each a quarter of the next, the first at most `least`.
pub fn graded(high: f64, least: f64) -> Vec<f64> {
    let mut places = vec![high];
    let mut at = high;
    while at > least {
        at *= 0.25;
        places.push(at);
    }
    places.push(0.0);
    places.reverse();
    places
}

/// The places within [low, high], its ends included, and as many between that no panel is longer than `longest`.
pub fn panels(low: f64, high: f64, places: &[f64], longest: f64) -> Vec<f64> {
    let mut ends: Vec<f64> = places.iter().copied().filter(|t| *t > low && *t < high).chain([low, high]).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let mut all = vec![low];
    for pair in ends.windows(2) {
        let parts = ((pair[1] - pair[0]) / longest).ceil().max(1.0);
        all.extend((1..=parts as u32).map(|i| pair[0] + (pair[1] - pair[0]) * f64::from(i) / parts));
    }
    all
}

#[test]
fn gauss_is_exact_for_polynomials() {
    for n in [1, 2, 7, 20, 32] {
        let degree = 2 * n as i32 - 1;
        let found = Gauss::new(n).over([0.0, 2.0], |x| x.powi(degree));
        approx::assert_relative_eq!(found, 2.0_f64.powi(degree + 1) / f64::from(degree + 1), max_relative = 1e-14);
    }
    let rooted = Gauss::new(20).over_with_roots([1.0, 3.0], |t| ((t - 1.0) * (3.0 - t)).sqrt());
    approx::assert_relative_eq!(rooted, 0.5 * PI, max_relative = 1e-14);
}
