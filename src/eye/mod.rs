//! The eye pass: what a camera sees of a room, each pixel with the light that the estimators and the caustic map bring.
//!
//! A pixel's ray is followed through mirrors and glass ([`crate::light::Sight`]) to what shines or scatters. Where it
//! scatters,
//!
//! ```text
//! radiosity = albedo × (direct + caustic)                                                     W/m²
//!   direct   N points on each source by a strategy ([`crate::estimator`]); lamps as they are
//!   caustic  flux over area in the map of rays from the light that took a bend ([`crate::light::TexelMap`])
//! ```
//!
//! A pixel holds π times the radiance that reaches the eye: the radiosity or exitance of what it sees. One ray goes through
//! the middle of each pixel.
//!
//! ```
//! use etendue::case::Case;
//! use etendue::eye::{Caustics, Direct, Eye, Shading, View};
//! use etendue::sampling::Strategy;
//!
//! let case = Case::from_toml("lamp", r#"
//!     [source.disk]
//!     center = [0.0, 0.0, 2.0]
//!     normal = [0.0, 0.0, -1.0]
//!     radius = 0.5
//!     exitance = 1.0
//!     [receiver]
//!     albedo = 0.5
//!     [receiver.rectangle]
//!     center = [0.0, 0.0, 0.0]
//!     edge_u = [2.0, 0.0, 0.0]
//!     edge_v = [0.0, 2.0, 0.0]
//!     [measure]
//!     grid = [1, 1]
//! "#)?;
//! let room = &case.configuration;
//! // The receiver itself, 32 pixels along its longer side.
//! let eye = Eye::new(room, View::of_receiver(room, 32)?, Direct::new(room))?;
//! let shading = Shading { strategy: Strategy::Stratified, samples: 64, seed: 1 };
//! let picture = eye.picture(&shading, &Caustics::none());
//! let middle = picture.pixel(16, 16).lit.expect("the receiver is everywhere");
//! // R²/(R² + h²) = 1/17 below the middle of the disk, somewhat less beside it.
//! assert!((middle.direct - 1.0 / 17.0).abs() < 2e-3);
//! assert_eq!(picture.pixel(16, 16).radiosity, 0.5 * middle.direct);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is not seen
//!
//! Light that was scattered more than once. Lamps have no area and are not seen themselves. Where a lens or a curved mirror
//! may stand between a surface and a source with area, its direct light is read from the map of rays too
//! ([`Direct::is_from_map`]): the estimators have no outline to test.

mod camera;
#[cfg(feature = "studies")]
mod direct;
mod error;
#[cfg(feature = "studies")]
mod picture;
#[cfg(feature = "studies")]
mod view;

pub use camera::{Camera, CameraError, Projection};
#[cfg(feature = "studies")]
pub use direct::Direct;
pub use error::EyeError;
#[cfg(feature = "studies")]
pub use picture::{Caustics, Eye, Lit, Picture, Pixel, RowSight, Shading, Spot};
#[cfg(feature = "studies")]
pub use view::{ReceiverView, View};
