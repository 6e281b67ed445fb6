//! Form factors between finite patches, and averages over them: closed forms where they exist, and for any pair behind any
//! occluders quadrature of the exact point value.
//!
//! A factor `a_to_b` leaves a and arrives at b: the power that b receives from a is exitance × area of a × `a_to_b`.
//! Reciprocity turns it around: area of a × `a_to_b` = area of b × `b_to_a`.

mod adaptive;
mod average;
mod closed;
mod footprint;
mod surface;

#[cfg(test)]
mod tests;

use thiserror::Error;

use crate::configuration::ConfigurationError;

pub use average::{Average, PatchFactor, Tolerance, average_irradiance, patch_to_patch};
pub(super) use average::{Value, average_of};
pub use closed::{
    disk_to_disk, patch_to_patch_inside_sphere, rectangle_to_adjoining_rectangle, rectangle_to_opposite_rectangle,
};
pub use footprint::{Footprint, footprint, footprint_average};
pub use surface::Patch;

/// Why a pair of patches was refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PatchError {
    /// A length or an area that is none.
    #[error("{field} is {said}; it is finite and greater than zero (metres, an area square metres)")]
    Length {
        /// Which of the arguments.
        field: &'static str,
        /// Its value.
        said: f64,
    },
    /// Lengths so uneven that the closed form leaves the range of f64.
    #[error(
        "the lengths differ by a factor of {ratio:.3e}; up to {:e} the formula keeps its digits",
        Self::MOST_UNEVEN
    )]
    TooUneven {
        /// The largest length over the smallest.
        ratio: f64,
    },
    /// A patch that does not fit on its sphere.
    #[error("the patch is {share} times as large as the sphere that it lies on")]
    LargerThanSphere {
        /// The patch's area over the sphere's.
        share: f64,
    },
    /// A patch that lies so far out that what is added to its coordinates overflows.
    #[error("the coordinates leave the range of f64")]
    OutOfRange,
    /// What is wrong with the patches and occluders as a configuration.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Configuration(Vec<ConfigurationError>),
}

impl PatchError {
    /// The largest ratio of two lengths of a pair: beyond it, squares of squares leave the range of f64.
    pub const MOST_UNEVEN: f64 = 1e60;
}

impl From<Vec<ConfigurationError>> for PatchError {
    fn from(mistakes: Vec<ConfigurationError>) -> PatchError {
        PatchError::Configuration(mistakes)
    }
}
