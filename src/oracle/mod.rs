//! The exact side: irradiance in closed form, with a bound on its error.
//!
//! No random number, no bounding-volume hierarchy, none of the estimator's intersection code.
//!
//! [`Oracle`] answers for one configuration. A source and its occluders are taken as sets of directions; the visible
//! part's form factor is a sum of contour integrals over great-circle arcs (straight edges) and circular arcs (rims and
//! silhouettes), each in closed form.

mod body;
mod crossing;
mod derivative;
#[cfg(test)]
mod derivative_tests;
mod exact;
mod form;
mod front;
mod great_arc;
pub mod limits;
mod outline;
pub mod patch;
mod penumbra;
mod piece;
mod point_factor;
mod polynomial;
mod quadrature;
mod rim;
mod silhouette;
mod surface;
mod trigonometric;
mod truth;
pub mod variance;

pub use derivative::{Derivatives, Parameter, ParameterError, Parameters, Side};
pub use exact::Oracle;
pub use polynomial::ExitancePolynomial;
pub use truth::{Method, Region, Truth};
