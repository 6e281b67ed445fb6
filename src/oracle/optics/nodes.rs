//! Gauss's nodes in any number, on one panel or several.

/// Nodes and weights of Gauss's rule with n points on [−1, 1], in order.
///
/// Newton's method on Legendre's polynomial from Tricomi's first guesses; the weights 2/((1 − x²) P′²).
///
/// - error: a few 2⁻⁵³
pub(super) fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut last, mut value) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (last, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * last) / k);
        }
        // P and P′ from P_n and P_{n−1}.
        (value, n as f64 * (last - x * value) / ((1.0 - x) * (1.0 + x)))
    };
    let node = |i: usize| {
        let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..8 {
            let (value, slope) = legendre(x);
            x -= value / slope;
        }
        let (_, slope) = legendre(x);
        (x, 2.0 / ((1.0 - x) * (1.0 + x) * slope * slope))
    };
    (0..n).map(node).collect()
}

/// The same rule on equal panels of [from, to].
pub(super) fn composite(from: f64, to: f64, panels: usize, points: usize) -> Vec<(f64, f64)> {
    let rule = gauss_legendre(points);
    let half = 0.5 * (to - from) / panels as f64;
    let middle = |i: usize| from + half * (2 * i + 1) as f64;
    (0..panels)
        .flat_map(|i| rule.iter().map(move |(x, w)| (middle(i) + half * x, half * w)).collect::<Vec<_>>())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn gauss_is_exact_for_what_it_is_made_for() {
        for n in [2, 5, 16, 40] {
            let degree = 2 * n as i32 - 2;
            let sum: f64 = gauss_legendre(n).iter().map(|(x, w)| w * x.powi(degree)).sum();
            assert_relative_eq!(sum, 2.0 / f64::from(degree + 1), max_relative = 2e-13);
        }
        let sum: f64 = composite(1.0, 4.0, 7, 12).iter().map(|(x, w)| w / x).sum();
        assert_relative_eq!(sum, 4.0_f64.ln(), max_relative = 1e-14);
    }
}
