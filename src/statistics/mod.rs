//! Moments, intervals, evidence and verdicts. Nothing here knows of light.

mod verdict;

pub use verdict::Verdict;
