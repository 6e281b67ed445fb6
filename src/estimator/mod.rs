//! The full estimator: points on the source, a shadow ray to each, the average.
//!
//! Knows nothing of the exact side; the two meet in the judge.

mod area;

pub use area::{AreaEstimator, Job, Scratch};
