//! Moments, intervals, evidence and verdicts. Nothing here knows of light.

#[cfg(feature = "studies")]
pub mod budget;
pub mod correlation;
pub mod evidence;
pub mod interval;
pub mod moments;
#[cfg(feature = "studies")]
pub mod occupancy;
#[cfg(feature = "studies")]
pub mod pairs;
#[cfg(feature = "studies")]
pub mod proportion;
mod quantile;
#[cfg(feature = "studies")]
#[cfg(test)]
pub(crate) mod simulated;
#[cfg(feature = "studies")]
pub mod slope;
mod verdict;

pub use correlation::PairSums;
pub use evidence::{Capital, Observed, Statement};
pub use interval::Interval;
pub use moments::{PowerSums, Summary};
#[cfg(feature = "studies")]
pub use slope::Line;
pub use verdict::Verdict;
