//! Gauss's rules of quadrature, for what is known to be smooth.

/// ∫ over [middle − half, middle + half] by Gauss's ten points.
///
/// - error: relative to the largest value, below 1e-17 for what is analytic within four half-lengths of the middle
pub(crate) fn gauss_10(middle: f64, half: f64, mut integrand: impl FnMut(f64) -> f64) -> f64 {
    let pair = |(x, w): (f64, f64)| w * (integrand(middle - half * x) + integrand(middle + half * x));
    half * GAUSS_10.into_iter().map(pair).sum::<f64>()
}

/// Positive nodes and weights of Gauss's 10-point rule on [−1, 1] (Abramowitz & Stegun 1964, table 25.4).
const GAUSS_10: [(f64, f64); 5] = [
    (0.148_874_338_981_631_22, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// Gauss–Legendre nodes and weights on [0, 1], order 8 (Abramowitz and Stegun, table 25.4, halved).
pub(crate) const GAUSS_8: [(f64, f64); 8] = [
    (0.5 - 0.5 * 0.960_289_856_497_536_3, 0.5 * 0.101_228_536_290_376_26),
    (0.5 - 0.5 * 0.796_666_477_413_626_7, 0.5 * 0.222_381_034_453_374_48),
    (0.5 - 0.5 * 0.525_532_409_916_329, 0.5 * 0.313_706_645_877_887_3),
    (0.5 - 0.5 * 0.183_434_642_495_649_8, 0.5 * 0.362_683_783_378_362),
    (0.5 + 0.5 * 0.183_434_642_495_649_8, 0.5 * 0.362_683_783_378_362),
    (0.5 + 0.5 * 0.525_532_409_916_329, 0.5 * 0.313_706_645_877_887_3),
    (0.5 + 0.5 * 0.796_666_477_413_626_7, 0.5 * 0.222_381_034_453_374_48),
    (0.5 + 0.5 * 0.960_289_856_497_536_3, 0.5 * 0.101_228_536_290_376_26),
];

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn ten_points_are_exact_for_degree_19() {
        let found = gauss_10(0.5, 0.5, |x| 20.0 * x.powi(19));
        assert_relative_eq!(found, 1.0, max_relative = 2e-15);
    }

    #[test]
    fn eight_points_are_exact_for_degree_15() {
        let found: f64 = GAUSS_8.iter().map(|(x, weight)| weight * 16.0 * x.powi(15)).sum();
        assert_relative_eq!(found, 1.0, max_relative = 2e-15);
    }
}
