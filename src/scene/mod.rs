//! What stands in the way of a ray: analytic shapes tested as themselves, meshes through a hierarchy.
//!
//! A shadow ray runs from a shading point to a point on a source and is blocked by anything strictly between the two. A ray
//! without an end is followed to what it meets first.

mod blocker;
#[cfg(feature = "studies")]
mod first_met;
#[cfg(test)]
mod halves;
#[cfg_attr(not(feature = "fast"), path = "halves.rs")]
mod hierarchy;
mod segment;
mod shadow_cache;
mod surroundings;
mod visibility;
#[cfg(feature = "fast")]
mod wide;

pub use blocker::{Blocker, ShadowRays};
pub(crate) use blocker::{Displacement, Help, Stop};
#[cfg(feature = "studies")]
pub use first_met::Met;
pub use hierarchy::Hierarchy;
pub use shadow_cache::ShadowCache;
pub use surroundings::{Surroundings, reach};
pub(crate) use visibility::{Target, VisibilityMap};
