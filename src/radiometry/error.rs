//! Why a radiometric quantity cannot be.

use thiserror::Error;

use crate::geometry::ShapeError;

/// An argument outside the domain of its law.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RadiometryError {
    #[error("the refractive index is {said}; it is finite and greater than zero")]
    Index { said: f64 },
    #[error("the refractive index is {said}; mean reflectances are of an index from 1 to 1e6, seen from either side")]
    MeanIndex { said: f64 },
    #[error("the cosine is {said}; it lies between 0 and 1")]
    Cosine { said: f64 },
    #[error("the power is {said} W; it is finite, zero or greater")]
    Power { said: f64 },
    #[error("the exitance is {said} W/m²; it is finite, zero or greater")]
    Exitance { said: f64 },
    #[error(transparent)]
    Shape(#[from] ShapeError),
    #[error("the intensity is {said} W/sr; it is finite, zero or greater")]
    Intensity { said: f64 },
    #[error("the element lies at the point source, where the irradiance has no bound")]
    AtSource,
    #[error(
        "the albedo is {said}; inside a closed surface it lies between 0 and 1, without 1, or light never dies out"
    )]
    Albedo { said: f64 },
    #[error("the cap is {said} m high; on a sphere of radius {radius} m it is higher than 0 and at most {} m", 2.0 * radius)]
    CapHeight { said: f64, radius: f64 },
    #[error("the light is {said} m from the centre; inside a sphere of radius {radius} m it is nearer than that")]
    OutsideSphere { said: f64, radius: f64 },
}
