//! The gate, measured: false alarms by exact expectation and by simulation, power by simulation.

use statrs::distribution::{Binomial, Discrete};

use super::*;
use crate::statistics::PowerSums;
use crate::statistics::budget::plausible;
use crate::statistics::simulated::Draws;

const LN_THRESHOLD: f64 = THRESHOLD_LOG10 * std::f64::consts::LN_10;

fn observe(n: u64, pivot: f64, mut draw: impl FnMut() -> f64) -> Observed {
    let mut sums = PowerSums::about(pivot);
    (0..n).for_each(|_| sums.add(draw()));
    Observed::values(&sums)
}

/// n values of which `hits` are 1 and the others 0, about 0.
fn hits(n: u64, hits: u64) -> Observed {
    Observed { n, pivot: 0.0, sum: hits as f64, sum_of_squares: hits as f64 }
}

/// Exact mean of the capital when each of n observations is 1 with probability p, else 0.
fn mean_capital_of_hits(statement: &Statement, n: u64, p: f64) -> f64 {
    let count = Binomial::new(p, n).unwrap();
    (0..=n).map(|k| (count.ln_pmf(k) + Capital::of(statement, &hits(n, k), n).ln()).exp()).sum()
}

#[test]
fn delyons_inequality_holds_on_a_grid() {
    for k in -40_000..=40_000 {
        let y = f64::from(k) / 1000.0;
        let (left, right) = ((y - y * y / 6.0).exp(), 1.0 + y + y * y / 3.0);
        assert!(left <= right * (1.0 + 4.0 * f64::EPSILON), "y = {y}: {left} > {right}");
    }
}

#[test]
fn shares_of_the_bets_sum_to_one() {
    assert_eq!(bets::ln_shares().count(), bets::BETS);
    assert!((bets::ln_shares().map(f64::exp).sum::<f64>() - 1.0).abs() < 1e-15);
    assert_eq!(bets::bets(100.0).count() + 1, bets::BETS);
}

#[test]
fn on_average_the_capital_does_not_grow_while_the_statement_holds() {
    for n in [1, 2, 3, 10, 30, 100, 300, 1000, 3000] {
        for p in [1e-6, 1e-4, 1e-3, 0.01, 0.05, 0.2, 0.5, 0.9, 0.999] {
            let statement = Statement::near(p, 0.0, p * (1.0 - p));
            let mean = mean_capital_of_hits(&statement, n, p);
            assert!(mean <= 1.0 + 1e-12, "n = {n}, p = {p}: mean capital {mean}");
        }
    }
}

#[test]
fn a_mean_anywhere_in_the_interval_is_no_evidence_and_one_outside_is() {
    let (low, high) = (0.3, 0.4);
    let statement = Statement { low, high, variance: 0.25 };
    for n in [1, 10, 100, 1000] {
        for p in [low, 0.31, 0.35, 0.39, high] {
            let mean = mean_capital_of_hits(&statement, n, p);
            assert!(mean <= 1.0 + 1e-12, "n = {n}, p = {p}: mean capital {mean}");
        }
    }
    for p in [0.2, 0.5] {
        assert!(mean_capital_of_hits(&statement, 1000, p) > 1e6, "p = {p}");
    }
    // An interval is never more evidence than any point of it.
    for k in (0..=1000).step_by(20) {
        let of = |statement: &Statement| Capital::of(statement, &hits(1000, k), 1000).ln();
        for mean in [low, 0.32, 0.35, 0.38, high] {
            assert!(of(&statement) <= of(&Statement::near(mean, 0.0, 0.25)) + 1e-9, "{k} hits, mean {mean}");
        }
    }
}

#[test]
fn true_statements_raise_no_alarm() {
    let mut draws = Draws::named("true_statements_raise_no_alarm");
    // One point on a half-visible source with a kernel that varies: zero or a skewed value.
    let (runs, n) = (4000, 256);
    let mut null = |name: &str, mean: f64, variance: f64, draw: &mut dyn FnMut(&mut Draws) -> f64| {
        let statement = Statement::near(mean, 0.0, variance);
        let capitals: Vec<f64> =
            (0..runs).map(|_| Capital::of(&statement, &observe(n, mean, || draw(&mut draws)), n).ln()).collect();
        assert!(capitals.iter().all(|&ln| ln < LN_THRESHOLD), "{name}: a false alarm");
        // A mean of at most 1 bounds every tail, and the mean of what is cut off above.
        for level in [2.0, 10.0, 100.0f64] {
            let above = capitals.iter().filter(|&&ln| ln >= level.ln()).count() as u64;
            assert!(plausible(above, runs, 0.0, 1.0 / level), "{name}: {above} of {runs} reach {level}");
        }
        let average = capitals.iter().map(|ln| ln.exp().min(1000.0)).sum::<f64>() / runs as f64;
        assert!(average < 1.0, "{name}: mean capital {average}");
    };
    null("normal", 0.0, 1.0, &mut |draws| draws.normal());
    null("exponential", 1.0, 1.0, &mut |draws| draws.exponential());
    null("one hit in a thousand", 1e-3, 1e-3 * 0.999, &mut |draws| draws.hit(1e-3));
    // Half hidden, exponential where seen: E x = 1/2, E x² = 1.
    null("half visible", 0.5, 0.75, &mut |draws| draws.hit(0.5) * draws.exponential());
}

#[test]
fn looking_after_every_batch_does_not_raise_the_rate_of_alarms() {
    let mut draws = Draws::named("looking_after_every_batch_does_not_raise_the_rate_of_alarms");
    let statement = Statement::near(1.0, 0.0, 1.0);
    let (runs, looks, batch) = (4000, 50, 10);
    let alarms = (0..runs)
        .filter(|_| {
            let mut capital = Capital::new();
            (0..looks).any(|_| {
                capital.times(&Capital::of(&statement, &observe(batch, 1.0, || draws.exponential()), looks * batch));
                capital.ln() >= 20f64.ln()
            })
        })
        .count();
    assert!(plausible(alarms as u64, runs, 0.0, 0.05), "{alarms} of {runs} at a capital of 20");
}

/// How many of `runs` are caught when observations with mean 0 and variance 1 are shifted by `shift`, with `components`
/// capitals averaged of which this is one and the others are worth nothing.
fn caught(runs: u64, n: u64, shift: f64, components: usize, mut draw: impl FnMut() -> f64) -> u64 {
    let statement = Statement::near(0.0, 0.0, 1.0);
    let needed = LN_THRESHOLD + (components as f64).ln();
    (0..runs).filter(|_| Capital::of(&statement, &observe(n, 0.0, || draw() + shift), n).ln() >= needed).count()
        as u64
}

#[test]
fn the_planned_shift_is_caught_99_times_in_100() {
    let mut draws = Draws::named("the_planned_shift_is_caught_99_times_in_100");
    for (n, components, runs) in [(24, 1, 4000), (64, 1, 3000), (256, 1, 2000), (256, 100, 2000), (1024, 10, 1000)] {
        let shift = smallest_shift(1.0, n, components);
        let normal = caught(runs, n, shift, components, || draws.normal());
        // No less than nominal, and not so much more that the plan wastes samples: 7 % less shift is caught less often.
        assert!(plausible(normal, runs, 0.987, 1.0), "n = {n}: {normal} of {runs} caught");
        let smaller = caught(runs, n, 0.93 * shift, components, || draws.normal());
        assert!(plausible(smaller, runs, 0.0, 0.985), "n = {n}: {smaller} of {runs} caught at 0.93 of the shift");
    }
}

#[test]
fn eight_standard_errors_are_caught_at_256() {
    let mut draws = Draws::named("eight_standard_errors_are_caught_at_256");
    let found = caught(4000, 256, 8.1 / 16.0, 1, || draws.normal());
    assert!(plausible(found, 4000, 0.99, 1.0), "{found} of 4000");
    let planned = smallest_shift(1.0, 256, 1) * 16.0;
    assert!((7.8..8.2).contains(&planned), "{planned}");
}

#[test]
fn no_shift_is_too_large_to_be_seen() {
    // A bet tuned to the threshold alone is blind past 2√n standard deviations.
    for n in [16u64, 32, 64, 256, 4096, 1 << 20] {
        for components in [1, 10, 1000] {
            let least = smallest_shift(1.0, n, components);
            let needed = LN_THRESHOLD + (components as f64).ln();
            let mut shift = least;
            while shift < 1e12 {
                let (sum, count) = (n as f64 * shift, n as f64);
                let observed = Observed { n, pivot: 0.0, sum, sum_of_squares: count * (1.0 + shift * shift) };
                let ln = Capital::of(&Statement::near(0.0, 0.0, 1.0), &observed, n).ln();
                assert!(ln >= needed, "n = {n}: a shift of {shift} standard deviations has {ln} of {needed}");
                shift *= 1.03;
            }
        }
    }
}

#[test]
fn more_observations_are_planned_for_smaller_shifts() {
    for components in [1, 66, 1000] {
        for shift in [1e-4, 1e-2, 0.1, 1.0] {
            let n = replicates_for(shift, 2.0, components);
            assert!(smallest_shift(2.0, n, components) <= shift);
            assert!(smallest_shift(2.0, n - 1, components) > shift, "{shift}: {n} is not the least");
        }
    }
    assert_eq!(replicates_for(1e-3, 0.0, 5), 1);
    assert_eq!(replicates_for(0.0, 1.0, 5), u64::MAX);
    assert_eq!(replicates_for(0.1, f64::NAN, 5), u64::MAX);
    assert_eq!(smallest_shift(1.0, 0, 1), f64::INFINITY);
}

#[test]
fn a_shift_too_small_for_any_batch_is_caught_by_their_product() {
    let mut draws = Draws::named("a_shift_too_small_for_any_batch_is_caught_by_their_product");
    let statement = Statement::near(0.0, 0.0, 1.0);
    let (batches, n) = (16, 256);
    let shift = smallest_shift(1.0, batches * n, 1);
    let mut product = Capital::new();
    for _ in 0..batches {
        let capital = Capital::of(&statement, &observe(n, 0.0, || draws.normal() + shift), batches * n);
        assert!(capital.ln() < LN_THRESHOLD);
        product.times(&capital);
    }
    assert!(product.ln() >= LN_THRESHOLD, "{}", product.ln());
}

#[test]
fn batches_multiply_to_the_whole() {
    let mut draws = Draws::named("batches_multiply_to_the_whole");
    let statement = Statement::near(0.9, 0.0, 1.0);
    let values: Vec<f64> = (0..1000).map(|_| draws.exponential()).collect();
    let of = |part: &[f64]| {
        let mut part = part.iter();
        Capital::of(&statement, &observe(part.len() as u64, 1.0, || *part.next().unwrap()), 1000)
    };
    let mut product = of(&values[..300]);
    product.times(&of(&values[300..]));
    let whole = of(&values);
    // All but the spread bet, whose product is the larger: (1 + a)(1 + b) ≥ 1 + a + b.
    assert!(product.ln() >= whole.ln() - 1e-9 && product.ln() < whole.ln() + 0.1, "{product:?} {whole:?}");
}

#[test]
fn a_certain_value_is_refuted_by_any_other_and_by_nothing_else() {
    let umbra = Statement::near(0.0, 0.0, 0.0);
    let ln = |statement: &Statement, values: &[f64], pivot: f64| {
        let mut values = values.iter();
        Capital::of(statement, &observe(values.len() as u64, pivot, || *values.next().unwrap()), 100).ln()
    };
    assert_eq!(ln(&umbra, &[0.0; 100], 0.0), 0.0);
    assert_eq!(ln(&umbra, &[0.0, 1e-100], 0.0), f64::INFINITY);
    // Values that cancel in the sum are seen by their squares.
    assert_eq!(ln(&umbra, &[1e-9, -1e-9], 0.0), f64::INFINITY);
    let certain = Statement::near(0.1, 0.0, 0.0);
    assert_eq!(ln(&certain, &[0.1; 1000], 0.1), 0.0);
    assert_eq!(ln(&certain, &[0.1; 1000], 0.0), 0.0, "rounding of sums about a distant pivot is no evidence");
    assert_eq!(ln(&certain, &[0.1001; 1000], 0.0), f64::INFINITY);
    let nearly = Statement::near(0.1, 1e-12, 0.0);
    assert_eq!(ln(&nearly, &[0.1 + 1e-13, 0.1 - 3e-13], 0.1), 0.0);
    assert_eq!(ln(&nearly, &[0.1 + 2e-12], 0.1), f64::INFINITY);
    assert_eq!(ln(&nearly, &[0.1 + 2e-12, 0.1 - 2e-12], 0.1), f64::INFINITY);
    assert_eq!(log10_capped(f64::INFINITY), 300.0);
}

#[test]
fn rounding_is_no_evidence() {
    // A nearly certain value, its variance far below the rounding of sums about a distant pivot.
    for variance in [1e-40, 1e-34, 1e-30, 1e-20] {
        let mut sums = PowerSums::about(0.0);
        (0..10_000).for_each(|_| sums.add(0.1));
        let ln = Capital::of(&Statement::near(0.1, 0.0, variance), &Observed::values(&sums), 10_000).ln();
        assert!(ln <= 0.0, "variance {variance}: {ln}");
    }
    // Hits with probability ½: the squared deviations from the mean are certain.
    let mut sums = PowerSums::about(0.3);
    (0..1000).for_each(|k| sums.add(if k % 2 == 0 { 0.0 } else { 0.6 }));
    for variance in [0.0, 1e-18] {
        let ln = Capital::of(&Statement::near(0.09, 0.0, variance), &Observed::squared_deviations(&sums), 1000).ln();
        assert!(ln <= 0.0, "variance {variance}: {ln}");
    }
}

#[test]
fn a_variance_is_judged_like_a_mean() {
    let mut draws = Draws::named("a_variance_is_judged_like_a_mean");
    let mut sums = PowerSums::about(0.0);
    (0..4000).for_each(|_| sums.add(draws.normal()));
    let observed = Observed::squared_deviations(&sums);
    // Normal data: v = 1, fourth moment 3, so the squares vary by 2.
    assert!(Capital::of(&Statement::near(1.0, 0.0, 2.0), &observed, 4000).ln() < 0.0);
    for wrong in [0.8f64, 1.25] {
        let statement = Statement::near(wrong, 0.0, 2.0 * wrong * wrong);
        assert!(Capital::of(&statement, &observed, 4000).ln() > LN_THRESHOLD, "{wrong}");
    }
}

#[test]
fn nothing_observed_or_stated_is_no_evidence_and_impossible_values_are() {
    let statement = Statement::near(1.0, 0.0, 1.0);
    let none = Observed { n: 0, pivot: 0.0, sum: 0.0, sum_of_squares: 0.0 };
    assert_eq!(Capital::of(&statement, &none, 10), Capital::new());
    assert!(Capital::new().ln().abs() < 1e-15);
    let some = hits(10, 3);
    for variance in [f64::NAN, f64::INFINITY, -1.0] {
        assert_eq!(Capital::of(&Statement::near(0.0, 0.0, variance), &some, 10), Capital::new());
        assert_eq!(smallest_shift(variance, 10, 1), f64::INFINITY);
    }
    for sum in [f64::NAN, f64::INFINITY] {
        assert_eq!(Capital::of(&statement, &Observed { sum, ..some }, 10).ln(), f64::INFINITY);
    }
    // Extreme scales overflow to certainty or to nothing, never to NaN.
    for variance in [1e-320, 1e-300, 1e300] {
        for sum in [0.0, 1e-300, 1.0, 1e150] {
            for planned in [0, 1, u64::MAX] {
                let observed = Observed { n: 1, pivot: 0.0, sum, sum_of_squares: sum * sum };
                let mut capital = Capital::of(&Statement::near(0.0, 0.0, variance), &observed, planned);
                assert!(!capital.ln().is_nan());
                capital.times(&Capital::of(&Statement::near(0.0, 0.0, 0.0), &hits(2, 1), 1));
                assert_eq!(capital.ln(), f64::INFINITY);
            }
        }
    }
}

#[test]
fn averages_of_logarithms_do_not_overflow() {
    assert_eq!(ln_average([]), 0.0);
    assert!((ln_average([0.0, 3f64.ln()]) - 2f64.ln()).abs() < 1e-15);
    assert!((ln_average([1e5, 1e5 + 3f64.ln()]) - 1e5 - 2f64.ln()).abs() < 1e-10);
    assert_eq!(ln_average([-1e300, f64::INFINITY, 3.0]), f64::INFINITY);
    assert_eq!(ln_average([f64::NEG_INFINITY; 3]), f64::NEG_INFINITY);
    assert!((ln_average([f64::NEG_INFINITY, 0.0]) + 2f64.ln()).abs() < 1e-15);
    assert_eq!((log10_capped(1e5), log10_capped(f64::NEG_INFINITY)), (300.0, -300.0));
    assert!((log10_capped(ALPHA.ln()) + THRESHOLD_LOG10).abs() < 1e-12);
}

/// Rare hits: the shift adds light to every value (a leak), the spread stays that of the hits.
#[test]
fn a_leak_beside_rare_hits_is_caught_as_planned() {
    let mut draws = Draws::named("a_leak_beside_rare_hits_is_caught_as_planned");
    // One ray in a thousand arrives; 256 of them an estimate, so that one estimate in four is not zero.
    let p = 1e-3;
    let (samples, n, runs) = (256, 1024, 300);
    let count = Binomial::new(p, samples).unwrap();
    let cumulative: Vec<f64> = (0..12)
        .map(|k| count.pmf(k))
        .scan(0.0, |sum, p| {
            Some({
                *sum += p;
                *sum
            })
        })
        .collect();
    let (mean, variance) = (p, p * (1.0 - p) / samples as f64);
    let statement = Statement::near(mean, 0.0, variance);
    for (sign, least) in [(1.0, 0.98), (-1.0, 0.97)] {
        let shift = sign * smallest_shift(variance, n, 1);
        let caught = (0..runs)
            .filter(|_| {
                let observed = observe(n, mean, || {
                    let u = draws.uniform();
                    cumulative.iter().filter(|&&below| u >= below).count() as f64 / samples as f64 + shift
                });
                Capital::of(&statement, &observed, n).ln() >= LN_THRESHOLD
            })
            .count() as u64;
        println!("sign {sign}: {caught} of {runs}");
        assert!(plausible(caught, runs, least, 1.0), "{caught} of {runs}");
    }
}

/// Where the shift is a share of the light itself, the spread grows with it: the worst case of planning. Exact sums.
#[test]
fn too_many_or_too_few_rare_hits_are_caught() {
    let (p, n) = (1e-3, 20_000u64);
    let statement = Statement::near(p, 0.0, p * (1.0 - p));
    let caught = |planted: f64| -> f64 {
        let count = Binomial::new(planted, n).unwrap();
        let alarm = |k: &u64| Capital::of(&statement, &hits(n, *k), n).ln() >= LN_THRESHOLD;
        (0..400).filter(alarm).map(|k| count.pmf(k)).sum()
    };
    // Twenty hits are expected, with a standard error of 4.47.
    let shifted = |std_errors: f64| p + std_errors * (p * (1.0 - p) / n as f64).sqrt();
    assert!(caught(p) <= ALPHA, "false alarms: {:e}", caught(p));
    let planned = smallest_shift(p * (1.0 - p), n, 1) / (p * (1.0 - p) / n as f64).sqrt();
    assert!((7.8..8.2).contains(&planned), "{planned}");
    // A leak of that size would be caught; twice or three times the hits scatter more, and 99 % takes half as much again.
    assert!(caught(shifted(9.5)) > 0.89, "{}", caught(shifted(9.5)));
    assert!(caught(shifted(1.5 * planned)) > 0.99, "{}", caught(shifted(1.5 * planned)));
    // Darkness is seen where thirty hits are expected, and more evidence is not to be had from it.
    let darkness = |expected: u64| Capital::of(&statement, &hits(1000 * expected, 0), 1000 * expected).ln();
    assert!(darkness(20) < LN_THRESHOLD && darkness(30) > LN_THRESHOLD, "{} {}", darkness(20), darkness(30));
}
