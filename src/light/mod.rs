//! Rays from the light: from sources through mirrors and glass to the diffuse surfaces where they leave their flux.
//!
//! ```
//! use etendue::configuration::{Configuration, Contents, Glass, GlassShape, Lamp, Receiver, ReceiverShape};
//! use etendue::geometry::{DVec3, Rectangle, Sphere};
//! use etendue::light::{self, Light, LightSettings};
//! use etendue::radiometry::{Beam, Irradiance};
//!
//! // A beam of 1 W/m² falls through a glass ball onto a screen.
//! let beam = Beam::new(DVec3::Z * 3.0, -DVec3::Z, 0.8, Irradiance::new(1.0))?;
//! let ball = GlassShape::Sphere(Sphere::new(DVec3::ZERO, 1.0)?);
//! let screen = Rectangle::new(DVec3::Z * -2.0, DVec3::X * 6.0, DVec3::Y * 6.0)?;
//! let room = Configuration::of(Contents {
//!     lamps: vec![Lamp::Beam(beam)],
//!     glass: vec![Glass::new(ball, 1.5)?],
//!     receiver: Some(Receiver::new(ReceiverShape::Rectangle(screen), None)?),
//!     ..Contents::default()
//! })
//! .expect("nothing in this room contradicts itself");
//! let run = light::trace(&room, &LightSettings { rays: 10_000, ..LightSettings::default() }, 1);
//!
//! // Every watt is booked, and the map holds what was deposited.
//! assert!(run.ledger.relative_residual() < 1e-12);
//! assert!((run.ledger.emitted / beam.power().watts() - 1.0).abs() < 1e-12);
//! assert!((run.maps[0].total(Light::Both) / run.ledger.deposited - 1.0).abs() < 1e-12);
//! // Most of it went straight through: in and out are two interactions.
//! assert!(run.deposited_by_order(2) > 0.85 * run.ledger.emitted);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is modelled
//!
//! - Sources with area (cosine emission), points, beams; unpolarised light.
//! - Smooth mirrors of one reflectance, both sides; clear convex glass by Snell and Fresnel. s and p are carried apart as
//!   long as a path stays in one plane of incidence; where it leaves it, it goes on unpolarised, and
//!   [`LightRun::depolarised`] counts how often.
//! - A packet stops at the first diffuse surface. What a diffuse surface sends on is not followed, but for shades: spheres
//!   that let a share through, scattered.
//! - Glass bodies do not share space. A mirror that touches glass, or glass that touches glass, face on face, is not
//!   modelled: which of the two faces comes first is then left to rounding.
//!
//! # Order
//!
//! Light is counted by its interactions: order 0 is direct, order 2 through a glass ball is the first pass, order 1 from it
//! is reflected off its outside.

#[cfg(feature = "studies")]
mod aim;
#[cfg(feature = "studies")]
mod body;
#[cfg(feature = "studies")]
mod chain;
#[cfg(feature = "studies")]
mod draws;
#[cfg(feature = "studies")]
mod emitter;
#[cfg(feature = "studies")]
mod face;
#[cfg(feature = "studies")]
mod interface;
mod ledger;
#[cfg(feature = "studies")]
mod map;
#[cfg(feature = "studies")]
mod room;
mod settings;
#[cfg(feature = "studies")]
mod sight;
#[cfg(feature = "studies")]
mod tally;
#[cfg(feature = "studies")]
mod trace;

#[cfg(feature = "studies")]
pub(crate) use chain::{End, Ray, Tracer, cosine_direction};
#[cfg(feature = "studies")]
pub(crate) use draws::Draws;
#[cfg(feature = "studies")]
pub(crate) use room::{Met, Role, Room, Start};
#[cfg(feature = "studies")]
pub(crate) use tally::Tally;

#[cfg(feature = "studies")]
pub use interface::{Interface, reflected};
pub use ledger::{Ledger, Moments, Sum};
#[cfg(feature = "studies")]
pub use map::{Light, RingMap, TexelMap, TileMap};
pub use settings::{Aim, LightSettings, Rings, Split};
#[cfg(feature = "studies")]
pub use sight::{First, Seen, Sight, Sighting};
#[cfg(feature = "studies")]
pub(crate) use trace::LightPiece;
#[cfg(feature = "studies")]
pub use trace::{LightRun, LightTracer, trace};
