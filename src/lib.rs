//! **etendue**: a radiometry verification harness.
//!
//! It holds exact, closed-form irradiance for area sources behind occluders, measures how far Monte Carlo estimators
//! are from it and how noisy they are, and says so in verdicts whose error rates are known.
#![forbid(unsafe_code)]

pub mod case;
#[cfg(feature = "cli")]
pub mod cli;
pub mod configuration;
pub mod estimator;
pub mod geometry;
pub mod oracle;
pub mod radiometry;
pub mod report;
pub mod sampling;
pub mod scene;
pub mod statistics;
pub mod trial;
