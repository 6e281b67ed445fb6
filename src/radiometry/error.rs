//! Why a radiometric quantity cannot be.

use crate::errors::errors;
use crate::geometry::ShapeError;

errors! {
    /// An argument outside the domain of its law.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum RadiometryError {
        /// A refractive index that is none.
        #[error("the refractive index is {said}; it is finite and greater than zero")]
        Index {
            /// Its value.
            said: f64,
        },
        /// A refractive index outside the range of the means.
        #[error("the refractive index is {said}; mean reflectances are of an index from 1 to 1e6, seen from either side")]
        MeanIndex {
            /// Its value.
            said: f64,
        },
        /// A cosine that is none.
        #[error("the cosine is {said}; it lies between 0 and 1")]
        Cosine {
            /// Its value.
            said: f64,
        },
        /// A power that is none.
        #[error("the power is {said} W; it is finite, zero or greater")]
        Power {
            /// Its value.
            said: f64,
        },
        /// An exitance that is none.
        #[error("the exitance is {said} W/m²; it is finite, zero or greater")]
        Exitance {
            /// Its value.
            said: f64,
        },
        /// An irradiance that is none.
        #[error("the irradiance is {said} W/m²; it is finite, zero or greater")]
        Irradiance {
            /// Its value.
            said: f64,
        },
        /// Light so faint or so bright that squares of its variance leave the range of f64.
        #[error("the {what} is {said:e} {unit}; where it is not zero it lies from {:e} to {:e}, or squares of variances are no numbers", super::FAINTEST, super::BRIGHTEST)]
        OutOfRange {
            /// `power` or `irradiance`.
            what: &'static str,
            /// Its unit.
            unit: &'static str,
            /// Its value.
            said: f64,
        },
        /// What is wrong with a shape.
        #[error(transparent)]
        Shape(#[from] ShapeError),
        /// An intensity that is none.
        #[error("the intensity is {said} W/sr; it is finite, zero or greater")]
        Intensity {
            /// Its value.
            said: f64,
        },
        /// An element where the point source is.
        #[error("the element lies at the point source, where the irradiance has no bound")]
        AtSource,
        /// An albedo that a closed surface cannot have.
        #[error(
            "the albedo is {said}; inside a closed surface it lies between 0 and 1, without 1, or light never dies out"
        )]
        Albedo {
            /// Its value.
            said: f64,
        },
        /// A cap that the sphere does not have.
        #[error("the cap is {said} m high; on a sphere of radius {radius} m it is higher than 0 and at most {} m", 2.0 * radius)]
        CapHeight {
            /// What was given, metres.
            said: f64,
            /// The sphere's, metres.
            radius: f64,
        },
        /// A light that is not inside the sphere.
        #[error("the light is {said} m from the centre; inside a sphere of radius {radius} m it is nearer than that")]
        OutsideSphere {
            /// What was given, metres.
            said: f64,
            /// The sphere's, metres.
            radius: f64,
        },
    }
}
