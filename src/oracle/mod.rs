//! The exact side: irradiance in closed form, with a bound on its error.
//!
//! No random number, no bounding-volume hierarchy, none of the estimator's intersection code.
//!
//! [`Oracle`] answers for one configuration. A source and its occluders are taken as sets of directions; the visible
//! part's form factor is a sum of contour integrals over great-circle arcs (straight edges) and circular arcs (rims and
//! silhouettes), each in closed form. A mesh that is not flat is one occluder, bounded by the edges of its silhouette.
//!
//! | question | answer |
//! |---|---|
//! | irradiance at a point, how much of the sources it sees | [`Oracle::at`]; where there is no closed form, by quadrature, and it says so |
//! | the same without any of the contour code | [`Oracle::by_quadrature`], the second witness: strips across each source |
//! | with an exitance that varies over the source | [`Oracle::at`] of a [textured](crate::texture) source; [`ExitancePolynomial`] (a rectangle, nothing in the way); [`Oracle::by_quadrature_with`] |
//! | derivatives with respect to the numbers of a case | [`Oracle::derivatives`]: the same contours over dual numbers |
//! | where shadows begin and end along a line | [`limits::limits`] |
//! | form factors between patches, means over a patch | [`patch`] |
//! | light by way of mirrors and glass, caustics, surfaces that light each other | [`optics`] |

mod body;
mod crossing;
#[cfg(feature = "studies")]
mod derivative;
#[cfg(feature = "studies")]
#[cfg(test)]
mod derivative_tests;
mod exact;
mod form;
mod front;
mod great_arc;
#[cfg(feature = "studies")]
pub mod limits;
#[cfg(feature = "studies")]
pub mod optics;
mod outline;
#[cfg(feature = "studies")]
pub mod patch;
mod penumbra;
mod piece;
mod point_factor;
mod polynomial;
mod quadrature;
mod rim;
mod silhouette;
mod surface;
mod textured;
#[cfg(test)]
mod textured_tests;
mod trigonometric;
mod truth;
pub mod variance;

#[cfg(feature = "studies")]
pub use derivative::{Derivatives, Parameter, ParameterError, Parameters, Side};
pub use exact::Oracle;
pub use polynomial::ExitancePolynomial;
pub use truth::{Method, Region, Truth};
