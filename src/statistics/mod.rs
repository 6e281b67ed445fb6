//! Moments, intervals, evidence and verdicts. Nothing here knows of light.

pub mod budget;
pub mod evidence;
pub mod moments;
#[cfg(test)]
mod simulated;
mod verdict;
mod wide;

pub use evidence::{Capital, Observed, Statement};
pub use moments::{PowerSums, Summary};
pub use verdict::Verdict;
