//! The exact side: irradiance in closed form, with a bound on its error.
//!
//! No random number, no bounding-volume hierarchy, none of the estimator's intersection code.

mod truth;

pub use truth::{Method, Region, Truth};
