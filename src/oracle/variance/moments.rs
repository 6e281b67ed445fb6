//! What samples bring, as a distribution that is gathered piece by piece: its mass, its mean and its moments about the mean.
//!
//! Moments about the mean, not E X² − (E X)²: what hardly varies over a source has a variance that is lost in the error of
//! its mean square.

use super::Spread;

/// Moments of what one sample brings, or of a part of it: of places that are not blocked, say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleMoments {
    /// Probability of this part.
    pub weight: f64,
    /// Its mean, W/m².
    pub mean: f64,
    /// ∫ (X − mean)ᵠ over it for q = 2, 3, 4, (W/m²)ᵠ, times the weight.
    pub central: [f64; 3],
    /// Whether what the weight lacks of one is blocked or misses, and brings nothing; else it is the rule's error.
    pub has_shadow: bool,
}

impl SampleMoments {
    /// Nothing comes from here.
    pub(super) const SHADOW: SampleMoments =
        SampleMoments { weight: 0.0, mean: 0.0, central: [0.0; 3], has_shadow: true };

    pub(super) fn point(value: f64, weight: f64) -> SampleMoments {
        SampleMoments { weight, mean: value, central: [0.0; 3], has_shadow: false }
    }

    /// Of values with their weights.
    pub(super) fn of(values: &[(f64, f64)]) -> SampleMoments {
        let weight: f64 = values.iter().map(|(_, weight)| weight).sum();
        if weight <= 0.0 {
            return SampleMoments::default();
        }
        let mean = values.iter().map(|(x, w)| x * w).sum::<f64>() / weight;
        let mut central = [0.0; 3];
        for (x, w) in values {
            let off = x - mean;
            let square = w * off * off;
            central[0] += square;
            central[1] += square * off;
            central[2] += square * off * off;
        }
        SampleMoments { weight, mean, central, has_shadow: false }
    }

    /// Both parts (Pébay 2008).
    pub fn plus(self, other: SampleMoments) -> SampleMoments {
        let has_shadow = self.has_shadow || other.has_shadow;
        if self.weight == 0.0 || other.weight == 0.0 {
            let heavier = if self.weight == 0.0 { other } else { self };
            return SampleMoments { has_shadow, ..heavier };
        }
        let weight = self.weight + other.weight;
        let (a, b) = (self.weight / weight, other.weight / weight);
        let apart = other.mean - self.mean;
        let [a2, a3, a4] = self.central;
        let [b2, b3, b4] = other.central;
        let between = self.weight * b * apart * apart;
        let second = a2 + b2 + between;
        let third = a3 + b3 + apart * (between * (a - b) + 3.0 * (a * b2 - b * a2));
        let fourth = a4
            + b4
            + apart
                * (apart * (between * (a * a - a * b + b * b) + 6.0 * (a * a * b2 + b * b * a2))
                    + 4.0 * (a * b3 - b * a3));
        SampleMoments { weight, mean: self.mean + b * apart, central: [second, third, fourth], has_shadow }
    }

    /// ∫ X, W/m².
    pub fn first_moment(&self) -> f64 {
        self.weight * self.mean
    }

    /// With what is missing from a whole in shadow; a weight that misses it by rounding, or by the rule's error, does not.
    pub(super) fn within(self, whole: f64) -> SampleMoments {
        let missing = whole - self.weight;
        if self.has_shadow && missing > 0.0 { self.plus(SampleMoments::point(0.0, missing)) } else { self }
    }

    /// What several kinds of samples that exclude one another (a ray that meets one source or another, or none) come to
    /// together.
    pub fn either(parts: &[SampleMoments]) -> SampleMoments {
        parts.iter().copied().fold(SampleMoments::SHADOW, SampleMoments::plus)
    }

    /// Of a sample that brings this, and nothing otherwise.
    pub fn spread(&self) -> Spread {
        self.spread_within(1.0)
    }

    /// The same of a sample that lands within a part of the whole.
    pub(super) fn spread_within(&self, whole: f64) -> Spread {
        let all = self.within(whole);
        if all.weight <= 0.0 {
            return Spread::default();
        }
        let [second, _, fourth] = all.central.map(|x| x / all.weight);
        let fourth = fourth.max(second * second);
        Spread { variance: second, fourth_cumulant: fourth - 3.0 * second * second }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALUES: [(f64, f64); 5] = [(1.0, 0.1), (3.0, 0.2), (-2.0, 0.05), (0.5, 0.3), (7.0, 0.15)];

    #[test]
    fn parts_joined_are_the_whole() {
        let whole = SampleMoments::of(&VALUES);
        let [a, b] = [SampleMoments::of(&VALUES[..2]), SampleMoments::of(&VALUES[2..])];
        let joined = a.plus(b);
        assert!((joined.weight - whole.weight).abs() < 1e-15);
        assert!((joined.mean - whole.mean).abs() < 1e-14);
        for (x, y) in joined.central.iter().zip(whole.central) {
            assert!((x - y).abs() < 1e-13 * y.abs(), "{x} {y}");
        }
        let points = VALUES
            .iter()
            .map(|(x, w)| SampleMoments::point(*x, *w))
            .fold(SampleMoments::default(), SampleMoments::plus);
        for (x, y) in points.central.iter().zip(whole.central) {
            assert!((x - y).abs() < 1e-13 * y.abs(), "{x} {y}");
        }
    }

    #[test]
    fn shadow_brings_nothing() {
        // 1 with probability ¼: variance p(1 − p), fourth moment p(1 − p)(1 − 3p + 3p²).
        let spread = SampleMoments { has_shadow: true, ..SampleMoments::point(1.0, 0.25) }.spread();
        assert!((spread.variance - 0.1875).abs() < 1e-15);
        assert!((spread.fourth_moment() - 0.1875 * 0.4375).abs() < 1e-15);
        // A weight that is short of one by the error of a rule is no shadow.
        assert_eq!(SampleMoments::point(1.0, 0.999).spread().variance, 0.0);
    }

    #[test]
    fn a_variance_far_below_the_square_of_the_mean_is_not_lost() {
        let values = [(1.0, 0.5), (1.0 + 1e-9, 0.5)];
        let spread = SampleMoments::of(&values).spread();
        assert!((spread.variance / 2.5e-19 - 1.0).abs() < 1e-6, "{}", spread.variance);
    }
}
