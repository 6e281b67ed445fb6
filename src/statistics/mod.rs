//! Moments, intervals, evidence and verdicts. Nothing here knows of light.

pub mod budget;
pub mod correlation;
pub mod evidence;
pub mod interval;
pub mod moments;
pub mod occupancy;
pub mod pairs;
pub mod proportion;
#[cfg(test)]
mod simulated;
pub mod slope;
mod verdict;

pub use correlation::PairSums;
pub use evidence::{Capital, Observed, Statement};
pub use interval::Interval;
pub use moments::{PowerSums, Summary};
pub use slope::Line;
pub use verdict::Verdict;
