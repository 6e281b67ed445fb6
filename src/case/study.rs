//! How a case is studied: strategies, sample counts, replicates and the bias that a pass must have been able to see.

use crate::sampling::Strategy;

/// Independent repeats of each estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub enum Replicates {
    /// As many as the smallest bias needs.
    Auto,
    /// This many, ≥ 2.
    Fixed(u64),
}

/// The relative deviations that a pass must have been able to see with 99 % probability.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct SmallestBias {
    /// Of the mean over the points.
    pub mean: f64,
    /// At every point that a tenth or more of the sources' light reaches.
    pub point: f64,
}

/// Settings of a study. Every one has a default; the command line overrides all cases.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    pub strategies: Vec<Strategy>,
    /// Points on each source, per shading point, per replicate; each ≥ 1, ascending.
    pub samples: Vec<u64>,
    pub replicates: Replicates,
    pub smallest_bias: SmallestBias,
    /// Relative; a deviation up to this is no fault.
    pub tolerance: f64,
    /// Deviations that are known and accepted.
    pub accepted: Vec<Accepted>,
}

/// A deviation that is known and accepted: a verdict that fails by no more than it passes, and says so.
#[derive(Clone, Debug, PartialEq)]
pub struct Accepted {
    /// `bias`, `variance` or `covariance`.
    pub property: &'static str,
    /// `None`: every strategy.
    pub strategy: Option<Strategy>,
    /// Relative; the failure's whole 95 % interval must lie within.
    pub size: f64,
    pub reason: String,
}

/// What can be accepted.
pub const PROPERTIES: [&str; 3] = ["bias", "variance", "covariance"];

impl Default for Study {
    fn default() -> Study {
        Study {
            strategies: Strategy::LECTURE.to_vec(),
            samples: vec![1, 4, 16, 64, 256, 1024],
            replicates: Replicates::Auto,
            smallest_bias: SmallestBias { mean: 1e-2, point: 1e-1 },
            tolerance: 0.0,
            accepted: Vec::new(),
        }
    }
}
