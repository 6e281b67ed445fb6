//! Eye paths: from where light is measured, backwards to where it comes from. The reference for light that goes to and fro
//! between diffuse surfaces, and what caustic maps are measured against.
//!
//! ```
//! use etendue::configuration::{Configuration, Contents, DiffuseSurface, MeasurementPoint, ReceiverShape};
//! use etendue::geometry::{DVec3, Sphere};
//! use etendue::path::{Part, PathSettings, PathTracer};
//! use etendue::radiometry::{Albedo, Exitance};
//!
//! // A furnace: the inside of a sphere that emits what it does not send back. Everywhere 1 W/m² arrives.
//! let sphere = ReceiverShape::Sphere(Sphere::new(DVec3::ZERO, 1.0)?);
//! let room = Configuration::of(Contents {
//!     diffuse: vec![DiffuseSurface::new(sphere, Albedo::new(0.6), Exitance::new(0.4), true)?],
//!     points: vec![MeasurementPoint::new(DVec3::NEG_Z, DVec3::Z)?],
//!     ..Contents::default()
//! })
//! .expect("nothing in this room contradicts itself");
//! let run = PathTracer::new(&room, &PathSettings::default(), 1).at_points(100_000);
//! let found = run.points[0].mean(Part::Total, run.paths);
//! assert!((found - 1.0).abs() < 0.02, "{found}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # One path
//!
//! From the point it leaves in a direction drawn with density cosθ/π, so that its mean is irradiance: π × the radiance that
//! it finds. Mirrors and glass send it on as they do packets from the light ([`crate::light`]: reversed, the shares are the
//! same), one branch chosen at random. A diffuse surface adds what it emits, and sends the path on with the weight of its
//! albedo. After [`PathSettings::roulette_after`] reflections it goes on only with a probability of the albedo, and its
//! weight is divided by that: Russian roulette, without bias.
//!
//! With *next-event estimation* each diffuse surface on the way (the measured place too) also asks every source straight
//! away: a shadow ray to one point of each. What a path then meets by chance counts only where no shadow ray could have
//! found it: by way of mirrors or glass. Without it, only what is met by chance counts, and a lamp without extent is never
//! met.
//!
//! A path ends that has made [`PathSettings::depth`] diffuse reflections, or passed [`PathSettings::chain`] mirrors and faces
//! of glass between two of them; [`PathPoint::terminated`] counts those. None does in rooms that lose light.

mod next_event;
mod run;
mod settings;
mod skin;
mod walk;

pub use run::{PathPoint, PathRun, PathTracer};
pub use settings::{Part, PathSettings};
pub(crate) use walk::AsItIs;
#[cfg(test)]
pub(crate) use walk::Weighing;
