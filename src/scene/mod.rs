//! What stands in the way of a shadow ray: analytic shapes tested as themselves, meshes through a hierarchy.
//!
//! A shadow ray runs from a shading point to a point on a source and is blocked by anything strictly between the two.

mod blocker;
mod hierarchy;

pub use blocker::{Blocker, ShadowRays};
pub use hierarchy::Hierarchy;
