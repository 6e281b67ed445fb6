//! A made-up outcome that looks like a real one: a disk over a plane, eclipsed by a smaller disk, with estimates that
//! scatter as theory says. For tests of the report, and to look at its plots.

use std::f64::consts::PI;

use glam::DVec3;
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use crate::geometry::{Disk, Shape};
use crate::light::Moments;
use crate::oracle::{Method, Region, Truth};
use crate::radiometry::{Albedo, Exitance, FormFactor, Irradiance};
use crate::sampling::Strategy;
use crate::statistics::Verdict;
use crate::statistics::interval::{Interval, Z_95};
use crate::trial::{
    CaseOutcome, CausticBin, Cell, Correlation, JudgedProperty, LightOutcome, LightRow, MapRow, Measured,
    PathOutcome, PathRow, Rate, RatePoint, RunOutcome, StrategyOutcome, Timing,
};

const SAMPLES: [u64; 6] = [1, 4, 16, 64, 256, 1024];
const REPLICATES: u64 = 1000;
const HEIGHT: f64 = 2.0;
const RADIUS: f64 = 0.5;

/// Standard normal numbers, the same on every run.
struct Noise(SplitMix64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }
    fn normal(&mut self) -> f64 {
        let (u, v) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * u.ln()).sqrt() * (2.0 * PI * v).cos()
    }
}

/// Level patch to level disk of radius `RADIUS`, `HEIGHT` above, its axis at `aside`.
fn patch_to_disk(aside: f64) -> f64 {
    let (h2, r2, a2) = (HEIGHT * HEIGHT, RADIUS * RADIUS, aside * aside);
    let z = h2 + r2 + a2;
    0.5 * (1.0 - (h2 + a2 - r2) / (z * z - 4.0 * r2 * a2).sqrt())
}

/// The share of the source disk that a disk of radius 0.35 at half the height leaves uncovered, on the source's plane.
fn uncovered(aside: f64) -> f64 {
    let (r, shadow) = (RADIUS, 0.42);
    let d = 2.0 * (0.62 - aside).abs();
    if d >= r + shadow {
        return 1.0;
    }
    if d <= r - shadow {
        return 1.0 - (shadow / r).powi(2);
    }
    let angle = |a: f64, b: f64| ((d * d + a * a - b * b) / (2.0 * d * a)).acos();
    let lens = r * r * (angle(r, shadow) - 0.5 * (2.0 * angle(r, shadow)).sin())
        + shadow * shadow * (angle(shadow, r) - 0.5 * (2.0 * angle(shadow, r)).sin());
    1.0 - lens / (PI * r * r)
}

fn truth(point: DVec3, arrangement: Arrangement) -> Truth {
    let aside = if arrangement == Arrangement::Line { point.x } else { point.length() };
    let dark = (0.58..0.66).contains(&aside) && arrangement == Arrangement::Line;
    let share = if dark { 0.0 } else { uncovered(aside) };
    let form_factor = share * patch_to_disk(aside);
    let region = match share {
        0.0 => Region::Umbra,
        s if s < 1.0 => Region::Penumbra,
        _ => Region::Lit,
    };
    Truth {
        irradiance: Irradiance::new(form_factor),
        unoccluded_irradiance: Irradiance::new(patch_to_disk(aside)),
        form_factor: FormFactor::new(form_factor),
        bound: Irradiance::new(if share == 0.0 { 0.0 } else { 1e-15 }),
        region,
        method: Method::ClosedForm,
        shadow_edge: region == Region::Penumbra,
    }
}

/// Variance of one estimate: the visible share is a coin, the rest a gentle slope; stratified, only the edge stays.
fn predicted_variance(strategy: Strategy, truth: &Truth, n: u64) -> f64 {
    let (n, e) = (n as f64, truth.irradiance.watts_per_square_metre());
    let open = truth.unoccluded_irradiance.watts_per_square_metre();
    let coin = e * (open - e);
    let slope = 0.02 * e * e;
    match strategy {
        Strategy::Stratified => 0.6 * coin / n.powf(1.5) + slope / (n * n),
        _ => (coin + slope) / n,
    }
}

fn measured(noise: &mut Noise, truth: &Truth, variance: f64, shared: f64) -> Measured {
    let replicates = REPLICATES as f64;
    let std_error = (variance / replicates).sqrt();
    let bias = shared * std_error;
    let measured = variance * (1.0 + (2.0 / replicates).sqrt() * noise.normal()).max(0.0);
    let half = Z_95 * (2.0 / replicates).sqrt();
    Measured {
        mean: truth.irradiance.watts_per_square_metre() + bias,
        bias,
        bias_std_error: std_error,
        variance: measured,
        variance_interval: Some(Interval { low: measured * (1.0 - half), high: measured * (1.0 + half) }),
        predicted_variance: (variance > 0.0).then_some(variance),
        mse: measured + bias * bias,
    }
}

fn strategy_outcome(
    noise: &mut Noise,
    strategy: Strategy,
    points: &[MeasurementPoint],
    truths: &[Truth],
) -> StrategyOutcome {
    let cells: Vec<Cell> = SAMPLES
        .iter()
        .map(|&samples| {
            let common = noise.normal();
            let points: Vec<Measured> = truths
                .iter()
                .map(|t| {
                    let own = noise.normal();
                    let z = if strategy == Strategy::Correlated { 0.9 * common + 0.43 * own } else { own };
                    measured(noise, t, predicted_variance(strategy, t, samples), z)
                })
                .collect();
            let n = points.len() as f64;
            let errors = points.iter().map(|p| p.bias_std_error);
            let mean_bias_std_error = match strategy {
                Strategy::Correlated => errors.sum::<f64>() / n,
                _ => errors.map(|e| e * e).sum::<f64>().sqrt() / n,
            };
            let mean_bias = points.iter().map(|p| p.bias).sum::<f64>() / n;
            let seconds = REPLICATES as f64 * n * (2e-8 + 4e-9 * samples as f64);
            Cell { samples, replicates: REPLICATES, seconds, points, mean_bias, mean_bias_std_error }
        })
        .collect();
    let rates = [None, Some(Region::Lit), Some(Region::Penumbra)]
        .into_iter()
        .filter_map(|region| rate(strategy, &cells, truths, region))
        .collect();
    let farthest = points.iter().map(|p| (p.position() - points[0].position()).length()).fold(0.0, f64::max);
    let separations: Vec<f64> = (1..=32).map(|k| farthest * f64::from(k) / 32.0).collect();
    let correlations = [1, 64, 1024]
        .into_iter()
        .flat_map(|samples| separations.iter().map(move |s| (samples, *s)))
        .map(|(samples, separation)| {
            let predicted = if strategy == Strategy::Correlated { (-separation / 0.4).exp() } else { 0.0 };
            let correlation = (predicted + 0.02 * noise.normal()).clamp(-1.0, 1.0);
            Correlation {
                samples,
                separation,
                correlation,
                low: (correlation - 0.04).max(-1.0),
                high: (correlation + 0.04).min(1.0),
                predicted: (strategy == Strategy::Correlated).then_some(predicted),
            }
        })
        .collect();
    StrategyOutcome {
        strategy,
        guest: None,
        cells,
        rates,
        correlations,
        verdicts: vec![JudgedProperty {
            property: "bias",
            verdict: Verdict::Pass,
            evidence: -0.31,
            threshold: 6.0,
            effect: 1.2e-4,
            effect_low: -8.3e-4,
            effect_high: 1.07e-3,
            smallest_bias_mean: Some([0.0042, 0.0093, 0.0011][strategy as usize]),
            smallest_bias_point: Some(0.081),
            words: "no bias above 0.42 % in the mean, 8.1 % at the worst point".to_owned(),
            note: None,
            reproduce: format!("etendue run penumbra/eclipse --strategy {strategy} --seed 1"),
        }],
        timings: vec![Timing { stage: "estimate", rays: 88_725_000, seconds: 1.25, efficiency: Some(3.1e7) }],
    }
}

/// The mean variance over a region's points, and a straight line through its logarithms.
fn rate(strategy: Strategy, cells: &[Cell], truths: &[Truth], region: Option<Region>) -> Option<Rate> {
    let chosen: Vec<usize> = (0..truths.len())
        .filter(|i| region.map_or(truths[*i].region != Region::Umbra, |r| truths[*i].region == r))
        .collect();
    if chosen.is_empty() {
        return None;
    }
    let points: Vec<RatePoint> = cells
        .iter()
        .map(|cell| {
            let value = chosen.iter().map(|i| cell.points[*i].variance).sum::<f64>() / chosen.len() as f64;
            RatePoint { samples: cell.samples, value, low: 0.9 * value, high: 1.12 * value }
        })
        .collect();
    let logs: Vec<(f64, f64)> = points.iter().map(|p| ((p.samples as f64).ln(), p.value.ln())).collect();
    let n = logs.len() as f64;
    let (mx, my) = (logs.iter().map(|l| l.0).sum::<f64>() / n, logs.iter().map(|l| l.1).sum::<f64>() / n);
    let slope = logs.iter().map(|l| (l.0 - mx) * (l.1 - my)).sum::<f64>()
        / logs.iter().map(|l| (l.0 - mx).powi(2)).sum::<f64>();
    let expected_slope = match (strategy, region) {
        (Strategy::Stratified, Some(Region::Lit)) => -2.0,
        (Strategy::Stratified, _) => -1.5,
        _ => -1.0,
    };
    Some(Rate {
        quantity: "variance",
        region,
        slope,
        slope_low: slope - 0.012,
        slope_high: slope + 0.012,
        intercept: my - slope * mx,
        expected_slope,
        asymptote: expected_slope,
        verdict: region.map(|_| Verdict::Pass),
        points,
    })
}

fn case_outcome(name: &str, title: &str, arrangement: Arrangement) -> CaseOutcome {
    let up = |x: f64, y: f64| MeasurementPoint::new(DVec3::new(x, y, 0.0), DVec3::Z).unwrap();
    let points: Vec<MeasurementPoint> = match arrangement {
        Arrangement::Line => (0..65).map(|i| up(1.5 * f64::from(i) / 64.0, 0.0)).collect(),
        Arrangement::Grid { nu, nv } => (0..nu * nv)
            .map(|k| {
                up(3.0 * ((k % nu) as f64 + 0.5) / nu as f64 - 1.5, 2.0 * ((k / nu) as f64 + 0.5) / nv as f64 - 1.0)
            })
            .collect(),
        Arrangement::Scattered => {
            [(0.0, 0.0), (0.3, 0.1), (0.62, 0.0), (0.9, 0.4), (1.4, 0.0)].map(|(x, y)| up(x, y)).to_vec()
        }
    };
    let truths: Vec<Truth> = points.iter().map(|p| truth(p.position(), arrangement)).collect();
    let source = Disk::new(DVec3::Z * HEIGHT, DVec3::NEG_Z, RADIUS).unwrap();
    let source = Source::new(Shape::Disk(source), Exitance::new(1.0)).unwrap();
    let room = Configuration::new(vec![source], vec![], None, points.clone(), arrangement).unwrap();
    let digest = room.digest();
    let mut noise = Noise(SplitMix64::seed_from_u64(digest.key()));
    let strategies = Strategy::LECTURE.map(|s| strategy_outcome(&mut noise, s, &points, &truths)).to_vec();
    CaseOutcome {
        name: name.to_owned(),
        title: title.to_owned(),
        digest,
        arrangement,
        figures: room.figures(),
        albedos: Some(vec![Albedo::new(0.5); points.len()]),
        points,
        truths,
        strategies,
        light: Some(light()),
        paths: Some(paths()),
        timings: vec![Timing { stage: "exact", rays: 65, seconds: 2.1e-4, efficiency: None }],
    }
}

/// One budget of rays and one ring.
fn light() -> LightOutcome {
    let row = LightRow {
        rays: 1000,
        source_power: 2.0,
        emitted: 2.0,
        deposited: 1.5,
        deposited_std_error: Some(0.01),
        absorbed: 0.25,
        escaped: 0.25,
        terminated: 0.0,
        residual: 0.0,
        map_integral: 1.5,
        exact_deposited: None,
        verdict: Verdict::Pass,
    };
    let bin = CausticBin {
        order: 2,
        bin: 0,
        radii: Some([0.0, 0.5]),
        tile: None,
        area: 0.25 * PI,
        measured: 0.5,
        std_error: Some(0.01),
        exact: 0.51,
        bound: 1e-16,
        verdict: Verdict::Pass,
        found: Moments::default(),
    };
    let texel = |size: f64| MapRow {
        rays: 1000,
        size,
        places: 64,
        irradiance: 1.0,
        bias: 0.011 * size * size,
        exact_bias: 0.01 * size * size,
        variance: 1.1e-5 / (size * size),
        predicted_variance: 1e-5 / (size * size),
    };
    let texels = [0.01, 0.03, 0.05].map(texel).to_vec();
    let timing = Timing { stage: "light", rays: 1000, seconds: 1e-3, efficiency: None };
    LightOutcome { rows: vec![row], bins: vec![bin], texels, verdicts: Vec::new(), timing }
}

/// Three cases: a line, a grid, and scattered points.
pub(super) fn outcome() -> RunOutcome {
    RunOutcome {
        seed: 1,
        command: "etendue run --seed 1".to_owned(),
        cases: vec![
            case_outcome("penumbra/eclipse", "Disk source, smaller disk occluder: an eclipse", Arrangement::Line),
            case_outcome("direct/disk-grid", "Disk over a plane, on a grid", Arrangement::Grid { nu: 30, nv: 20 }),
            case_outcome("../three points", "The lecture's shadow regions & <points>", Arrangement::Scattered),
        ],
        missing: Vec::new(),
    }
}

fn paths() -> PathOutcome {
    let row = PathRow {
        estimator: "next_event",
        point: Some((0, DVec3::ZERO)),
        part: "indirect",
        paths: 4096,
        reached_share: Some(0.25),
        measured: 0.21,
        std_error: Some(1e-3),
        exact: Some(0.2105),
        bound: Some(1e-15),
        variance: Some(4e-3),
        largest_variance: Some(6e-3),
        verdict: Some(Verdict::Pass),
    };
    let timing = Timing { stage: "next_event", rays: 12_000, seconds: 2e-3, efficiency: Some(5e8) };
    PathOutcome { rows: vec![row], verdicts: Vec::new(), timings: vec![timing] }
}
