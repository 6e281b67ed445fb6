//! A report as its own files tell it: what plots and the page are drawn from, right after a run and years later alike.

mod fill;
mod table;

use crate::configuration::{Arrangement, Role, Stroke};
use crate::geometry::DVec3;
use crate::oracle::Region;
use crate::sampling::Strategy;
use crate::statistics::Verdict;
use crate::trial::{Correlation, LightRow, MapRow, Measured, RatePoint};

pub(super) use fill::{manifest, read};
pub(super) use table::{Place, Row};

/// A whole report, or what of it could be read.
#[derive(Clone, Debug, Default)]
pub(super) struct ReportRecord {
    /// Of the etendue that measured.
    pub version: String,
    pub seed: String,
    pub command: String,
    /// In the order of the run.
    pub cases: Vec<CaseRecord>,
    /// What is missing or could not be read, a sentence each.
    pub faults: Vec<String>,
}

/// One case.
#[derive(Clone, Debug)]
pub(super) struct CaseRecord {
    pub name: String,
    pub title: String,
    pub digest: String,
    pub arrangement: Arrangement,
    pub figures: Vec<FigureRecord>,
    pub points: Vec<PointRecord>,
    pub strategies: Vec<StrategyRecord>,
    /// The books, by budget of rays.
    pub ledger: Vec<LightRow>,
    pub rings: Vec<RingRecord>,
    pub texels: Vec<MapRow>,
    pub paths: Vec<PathRecord>,
    pub verdicts: Vec<VerdictRecord>,
}

impl CaseRecord {
    fn named(name: &str) -> CaseRecord {
        CaseRecord {
            name: name.to_owned(),
            title: name.to_owned(),
            digest: String::new(),
            arrangement: Arrangement::Scattered,
            figures: Vec::new(),
            points: Vec::new(),
            strategies: Vec::new(),
            ledger: Vec::new(),
            rings: Vec::new(),
            texels: Vec::new(),
            paths: Vec::new(),
            verdicts: Vec::new(),
        }
    }
}

impl CaseRecord {
    /// The sample count of profiles, maps and advice: the measured one nearest to 64, on a logarithmic scale.
    pub fn shown_samples(&self) -> Option<u64> {
        let counts = self.strategies.iter().flat_map(|s| &s.cells).map(|c| c.samples).filter(|n| *n > 0);
        let away = |n: u64| (n as f64 / SHOWN_SAMPLES).ln().abs();
        counts.min_by(|a, b| away(*a).total_cmp(&away(*b)).then(a.cmp(b)))
    }

    /// Distance from the first point along the way through all of them, metres; else the points' numbers.
    pub fn places(&self) -> Vec<f64> {
        if self.arrangement != Arrangement::Line || self.points.is_empty() {
            return (0..self.points.len()).map(|k| k as f64).collect();
        }
        let mut gone = 0.0;
        let mut places = vec![0.0];
        for pair in self.points.windows(2) {
            gone += (pair[1].position - pair[0].position).length();
            places.push(gone);
        }
        places
    }
}

const SHOWN_SAMPLES: f64 = 64.0;
/// Sample counts of correlations that are shown: the fewest, one between, the most.
const SHOWN_COUNTS: usize = 3;

/// One thing of the room.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FigureRecord {
    pub role: Role,
    pub shape: String,
    pub is_textured: bool,
    pub strokes: Vec<Stroke>,
}

/// Where light was measured, and what is due there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PointRecord {
    pub position: DVec3,
    pub region: Region,
    /// W/m², and what it is off by at most.
    pub exact: f64,
    pub bound: f64,
}

/// All that one strategy, or a guest, did in a case.
#[derive(Clone, Debug)]
pub(super) struct StrategyRecord {
    pub name: String,
    pub cells: Vec<CellRecord>,
    pub rates: Vec<RateRecord>,
    pub correlations: Vec<Correlation>,
}

impl StrategyRecord {
    /// `None` of a guest.
    pub fn known(&self) -> Option<Strategy> {
        Strategy::from_name(&self.name)
    }

    /// At most three sample counts of its correlations, spread over those that there are.
    pub fn shown_counts(&self) -> Vec<u64> {
        let counts: std::collections::BTreeSet<u64> = self.correlations.iter().map(|c| c.samples).collect();
        let counts: Vec<u64> = counts.into_iter().collect();
        if counts.len() <= SHOWN_COUNTS {
            return counts;
        }
        (0..SHOWN_COUNTS).map(|k| counts[k * (counts.len() - 1) / (SHOWN_COUNTS - 1)]).collect()
    }
}

/// All points at one sample count.
#[derive(Clone, Debug)]
pub(super) struct CellRecord {
    pub samples: u64,
    pub replicates: u64,
    /// One for each point of the case.
    pub points: Vec<Measured>,
    /// Mean over the points of the bias, and its standard error, W/m².
    pub mean_bias: Option<[f64; 2]>,
}

/// How a quantity falls with the number of samples, over the points of one region.
#[derive(Clone, Debug)]
pub(super) struct RateRecord {
    pub quantity: String,
    /// `None`: all points that light reaches.
    pub region: Option<Region>,
    pub slope: f64,
    pub slope_low: f64,
    pub slope_high: f64,
    pub expected_slope: f64,
    /// What theory gives for large N, and the fit's natural log at N = 1; `None` without `curves.csv`.
    pub line: Option<RateLine>,
    pub points: Vec<RatePoint>,
}

impl RateRecord {
    /// What the fitted line has at N, W²/m⁴.
    pub fn fitted(&self, n: f64) -> Option<f64> {
        self.line.map(|line| (line.intercept + self.slope * n.ln()).exp())
    }
    pub fn asymptote(&self) -> Option<f64> {
        self.line.map(|line| line.asymptote)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RateLine {
    pub asymptote: f64,
    pub intercept: f64,
}

/// One ring of a caustic, one tile of the receiver, or all of it; W/m².
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RingRecord {
    pub order: usize,
    pub bin: usize,
    /// The middle of a ring's radii; `None` of tiles and of the whole receiver.
    pub position: Option<f64>,
    pub measured: f64,
    pub std_error: Option<f64>,
    pub exact: f64,
    pub verdict: Verdict,
}

/// What eye paths, or the map beside them, found at one place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PathRecord {
    pub estimator: String,
    pub point: Option<u64>,
    pub part: String,
    pub paths: u64,
    pub measured: f64,
    pub std_error: Option<f64>,
    pub exact: Option<f64>,
    pub verdict: Option<Verdict>,
}

/// A line of the verdict table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct VerdictRecord {
    pub strategy: String,
    pub property: String,
    pub verdict: Verdict,
    pub evidence: Option<f64>,
    pub threshold: Option<f64>,
    /// With the ends of its interval.
    pub effect: Option<[f64; 3]>,
    pub smallest_bias_mean: Option<f64>,
    pub smallest_bias_point: Option<f64>,
    pub reproduce: String,
}
