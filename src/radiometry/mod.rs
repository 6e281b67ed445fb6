//! Radiometric quantities, the laws between them, and the closed forms that need no scene.

mod beam;
#[cfg(feature = "studies")]
pub mod enclosure;
mod error;
#[cfg(feature = "studies")]
mod fresnel;
mod point_source;
mod quantity;

pub use beam::Beam;
pub use error::RadiometryError;
#[cfg(feature = "studies")]
pub use fresnel::{Fresnel, mean_reflectance_from_inside, mean_reflectance_from_outside};
pub use point_source::PointSource;
pub use quantity::{
    Albedo, Area, Exitance, Flux, FormFactor, Intensity, Irradiance, ProjectedSolidAngle, Radiance, Radiosity,
    SolidAngle,
};
