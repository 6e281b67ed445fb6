//! What a run found: everything that reports show, and nothing about how it is shown.

#[cfg(feature = "studies")]
use crate::configuration::Figure;
use crate::configuration::{Arrangement, Digest, MeasurementPoint};
use crate::geometry::DVec3;
use crate::light::Moments;
use crate::oracle::{Region, Truth};
use crate::radiometry::Albedo;
use crate::sampling::Strategy;
use crate::statistics::Verdict;
use crate::statistics::interval::Interval;

/// A whole run, cases in the order they were given.
#[derive(Clone, Debug)]
pub struct RunOutcome {
    pub seed: u64,
    /// The command that reproduces the run: only options that move numbers.
    pub command: String,
    pub cases: Vec<CaseOutcome>,
    /// The names of those that were not finished because the run was stopped; none of a whole run.
    pub missing: Vec<String>,
}

impl RunOutcome {
    /// Nothing yet.
    pub fn new(seed: u64, command: String) -> RunOutcome {
        RunOutcome { seed, command, cases: Vec::new(), missing: Vec::new() }
    }

    /// A whole run of one case.
    pub fn of_one(seed: u64, command: String, case: CaseOutcome) -> RunOutcome {
        RunOutcome { cases: vec![case], ..RunOutcome::new(seed, command) }
    }
}

/// One case.
#[derive(Clone, Debug)]
pub struct CaseOutcome {
    pub name: String,
    pub title: String,
    pub digest: Digest,
    pub arrangement: Arrangement,
    /// What stands in the room, for a drawing of it.
    #[cfg(feature = "studies")]
    pub figures: Vec<Figure>,
    /// The receiver's, one for each point.
    pub albedos: Option<Vec<Albedo>>,
    pub points: Vec<MeasurementPoint>,
    /// One for each point.
    pub truths: Vec<Truth>,
    pub strategies: Vec<StrategyOutcome>,
    /// Where there are mirrors, glass or lamps.
    pub light: Option<LightOutcome>,
    /// Where light is bent, or diffuse surfaces light each other.
    pub paths: Option<PathOutcome>,
    /// Stages that belong to no strategy (exact values, the hierarchy against brute force).
    pub timings: Vec<Timing>,
}

impl CaseOutcome {
    /// All verdicts in the order of the report, each with the name of the strategy that it is about, `light`,
    /// `eye_paths` or `next_event`.
    pub fn verdicts(&self) -> impl Iterator<Item = (&str, &JudgedProperty)> {
        let of_strategies = self.strategies.iter().flat_map(|s| s.verdicts.iter().map(|judged| (s.name(), judged)));
        let of_light = self.light.iter().flat_map(|light| light.verdicts.iter().map(|judged| ("light", judged)));
        let of_paths =
            self.paths.iter().flat_map(|paths| paths.verdicts.iter().map(|(name, judged)| (*name, judged)));
        of_strategies.chain(of_light).chain(of_paths)
    }
}

/// What light that was followed from the sources has left.
#[derive(Clone, Debug)]
pub struct LightOutcome {
    /// The books, one row for each budget of rays, ascending.
    pub rows: Vec<LightRow>,
    /// Rings of the largest budget that an exact value is known of, by order and then outwards.
    pub bins: Vec<CausticBin>,
    /// What the receiver's map is off by, for each budget of rays and size of texels; empty where it is not known.
    pub texels: Vec<MapRow>,
    pub verdicts: Vec<JudgedProperty>,
    pub timing: Timing,
}

/// What eye paths have found.
#[derive(Clone, Debug, Default)]
pub struct PathOutcome {
    /// One for each point of each estimator, and where there are optics two for the whole receiver: eye paths and the map.
    pub rows: Vec<PathRow>,
    /// Each with the name of the estimator that it is about.
    pub verdicts: Vec<(&'static str, JudgedProperty)>,
    pub timings: Vec<Timing>,
}

/// What eye paths found at one point, or all over the receiver.
#[derive(Clone, Debug, PartialEq)]
pub struct PathRow {
    /// `eye_paths`, `next_event`, or `light_map` for what rays from the light left.
    pub estimator: &'static str,
    /// Which measurement point, and where; `None` for the whole receiver.
    pub point: Option<(usize, DVec3)>,
    /// Which light: `total`, `caustic` or `indirect`.
    pub part: &'static str,
    /// From this place; of the map, rays.
    pub paths: u64,
    /// Of the paths, those that came upon a source by chance and by such a way; `None` for the map.
    pub reached_share: Option<f64>,
    /// W/m².
    pub measured: f64,
    pub std_error: Option<f64>,
    /// W/m², and what it is off by at most.
    pub exact: Option<f64>,
    pub bound: Option<f64>,
    /// Of one path, estimated, W²/m⁴.
    pub variance: Option<f64>,
    /// What it is at most, by the exact side.
    pub largest_variance: Option<f64>,
    /// `None` where nothing is judged.
    pub verdict: Option<Verdict>,
}

/// The books of one run, W.
#[derive(Clone, Debug, PartialEq)]
pub struct LightRow {
    pub rays: u64,
    /// In closed form.
    pub source_power: f64,
    pub emitted: f64,
    pub deposited: f64,
    /// `None` below two independent groups of rays.
    pub deposited_std_error: Option<f64>,
    pub absorbed: f64,
    pub escaped: f64,
    pub terminated: f64,
    /// What is unaccounted for.
    pub residual: f64,
    /// What all maps hold.
    pub map_integral: f64,
    /// What `deposited` should be; `None` where it is not known.
    pub exact_deposited: Option<f64>,
    /// Whether all of it is in balance, to 10⁻¹².
    pub verdict: Verdict,
}

impl LightRow {
    /// The largest gap in the books, relative to the sources' power.
    pub fn largest_gap(&self) -> f64 {
        let gaps = [self.residual, self.emitted - self.source_power, self.map_integral - self.deposited];
        gaps.into_iter().map(f64::abs).fold(0.0, f64::max) / self.source_power.max(f64::MIN_POSITIVE)
    }
}

/// Squares of texels of one size, and what they are off by.
#[derive(Clone, Debug, PartialEq)]
pub struct MapRow {
    pub rays: u64,
    /// Root of a square's area, metres.
    pub size: f64,
    /// Squares.
    pub places: usize,
    /// Exact, at their middles, on average, W/m².
    pub irradiance: f64,
    /// Root mean square of what squares are off their middles' exact irradiance, less the predicted noise, W/m².
    pub bias: f64,
    /// The same by exact values alone, W/m².
    pub exact_bias: f64,
    /// Mean square of what squares are off their own exact means, W²/m⁴.
    pub variance: f64,
    /// The same as the counts of rays predict it, W²/m⁴.
    pub predicted_variance: f64,
}

/// One ring around the axis of a caustic, one tile of the receiver, or all of it, and what light of one order brought to it.
#[derive(Clone, Debug, PartialEq)]
pub struct CausticBin {
    /// Interactions on the way.
    pub order: usize,
    pub bin: usize,
    /// Inner and outer, metres; `None` for the whole receiver.
    pub radii: Option<[f64; 2]>,
    /// Which tile of the receiver, along s and t; `None` for rings and for the whole receiver.
    pub tile: Option<[usize; 2]>,
    /// Square metres.
    pub area: f64,
    /// W.
    pub measured: f64,
    pub std_error: Option<f64>,
    /// W, and what it is off by at most.
    pub exact: f64,
    pub bound: f64,
    pub verdict: Verdict,
    /// Over the independent groups of rays.
    pub(crate) found: Moments,
}

/// One case under one strategy.
#[derive(Clone, Debug)]
pub struct StrategyOutcome {
    /// Of a guest: `random`, which a guest is measured against.
    pub strategy: Strategy,
    /// Who made the estimates, where it was not etendue.
    pub guest: Option<String>,
    /// One for each sample count, ascending.
    pub cells: Vec<Cell>,
    pub rates: Vec<Rate>,
    pub correlations: Vec<Correlation>,
    pub verdicts: Vec<JudgedProperty>,
    pub timings: Vec<Timing>,
}

impl StrategyOutcome {
    /// The name that reports use: the strategy's, or the guest's.
    pub fn name(&self) -> &str {
        self.guest.as_deref().unwrap_or(self.strategy.name())
    }
}

/// All points at one sample count.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Points on each source.
    pub samples: u64,
    pub replicates: u64,
    /// Processor seconds of all its estimates, summed over threads. Like every time, it differs from run to run.
    pub seconds: f64,
    /// One for each measurement point.
    pub points: Vec<Measured>,
    /// Mean over the points of the bias, W/m².
    pub mean_bias: f64,
    /// Its standard error, taken across replicates because points may err together, W/m².
    pub mean_bias_std_error: f64,
}

/// Irradiance estimates at one point with one sample count, over all replicates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// W/m².
    pub mean: f64,
    /// Mean less exact value, W/m².
    pub bias: f64,
    /// Standard error of the bias, W/m².
    pub bias_std_error: f64,
    /// Variance of one estimate, W²/m⁴ (divisor n − 1).
    pub variance: f64,
    /// 95 % interval of the variance, W²/m⁴; `None` where too few rays decide it (`trial/rare.rs`).
    pub variance_interval: Option<Interval>,
    /// Of the exact side, W²/m⁴; `None` where it is not predicted.
    pub predicted_variance: Option<f64>,
    /// Mean squared error against the exact value, W²/m⁴.
    pub mse: f64,
}

/// How a quantity falls with the number of samples, over the points of one region.
#[derive(Clone, Debug, PartialEq)]
pub struct Rate {
    /// `variance`.
    pub quantity: &'static str,
    /// `None`: all points that light reaches.
    pub region: Option<Region>,
    /// Of log quantity over log N: the fit and its 95 % interval.
    pub slope: f64,
    pub slope_low: f64,
    pub slope_high: f64,
    /// Natural log of the fitted quantity at N = 1.
    pub intercept: f64,
    /// The same fit of the predicted variances; the asymptote where they are not predicted.
    pub expected_slope: f64,
    /// What theory gives for large N.
    pub asymptote: f64,
    /// `None` where the slope is shown, not judged: where variances are not predicted.
    pub verdict: Option<Verdict>,
    /// What the line was fitted to, ascending in N.
    pub points: Vec<RatePoint>,
}

/// One point of a variance curve: the mean over the region's points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatePoint {
    pub samples: u64,
    /// W²/m⁴, with its 95 % interval.
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// Correlation of the errors of points at one separation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct Correlation {
    pub samples: u64,
    /// Metres.
    pub separation: f64,
    /// In [−1, 1], with its 95 % interval.
    pub correlation: f64,
    pub low: f64,
    pub high: f64,
    pub predicted: Option<f64>,
}

/// One line of the verdict table.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedProperty {
    /// `bias`, `variance` or `covariance`; of light `energy` or `caustic`.
    pub property: &'static str,
    pub verdict: Verdict,
    /// log10 of the test's capital.
    pub evidence: f64,
    /// log10 of the capital at which a verdict fails.
    pub threshold: f64,
    /// Relative deviation (0.01 is one per cent too much) with its 95 % interval: of the mean over points, or of what failed worst.
    pub effect: f64,
    /// Lower end of that interval, relative.
    pub effect_low: f64,
    /// Upper end, relative.
    pub effect_high: f64,
    /// What would have been caught with 99 % probability, relative; `None` where no light is due anywhere. Of a variance: a
    /// deviation of all variances alike.
    pub smallest_bias_mean: Option<f64>,
    /// The same at the worst point that a tenth or more of the light reaches. Of a variance: at the worst sample count.
    pub smallest_bias_point: Option<f64>,
    /// One sentence that a reader cannot misread.
    pub words: String,
    /// What a reader should know of a pass: that it leans on an accepted deviation, or that one is no longer needed.
    pub note: Option<String>,
    /// The command line that gives the same verdict.
    pub reproduce: String,
}

/// Time spent on one stage. The only part of an outcome that differs from run to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    pub stage: &'static str,
    /// Shadow rays (or exact evaluations) made.
    pub rays: u64,
    /// CPU seconds, summed over threads.
    pub seconds: f64,
    /// 1 / (mean variance × time) of one estimate at the largest N; `None` where nothing is estimated.
    pub efficiency: Option<f64>,
}
