//! Radiometric quantities, the laws between them, and the closed forms that need no scene.

mod beam;
#[cfg(feature = "studies")]
pub mod enclosure;
mod error;
#[cfg(feature = "studies")]
mod fresnel;
mod point_source;
mod quantity;

/// Of a source's light, W or W/m²: what is judged are squares of variances, fourth powers, and those of a small share of it.
pub(crate) const FAINTEST: f64 = 1e-30;
pub(crate) const BRIGHTEST: f64 = 1e30;

/// Whether a source may be as bright.
pub(crate) fn is_in_range(light: f64) -> bool {
    light == 0.0 || (FAINTEST..=BRIGHTEST).contains(&light)
}

pub use beam::Beam;
pub use error::RadiometryError;
#[cfg(feature = "studies")]
pub use fresnel::{Fresnel, mean_reflectance_from_inside, mean_reflectance_from_outside};
pub use point_source::PointSource;
pub use quantity::{
    Albedo, Area, Exitance, Flux, FormFactor, Intensity, Irradiance, ProjectedSolidAngle, Radiance, Radiosity,
    SolidAngle,
};
