//! Shapes and frames: where things are, with no light in them yet.
//!
//! All lengths are in metres, all angles in radians, all frames right-handed.

mod closed;
mod curved;
mod frame;
mod mesh;
pub mod parametrisation;
pub mod partition;
mod polygon;
mod shape;
pub mod solid_angle;

pub use closed::{PlanoConvex, Slab};
pub use curved::{Cylinder, Paraboloid, SphereCap};
pub use frame::Frame;
pub use mesh::Mesh;
pub use parametrisation::{
    Isoline, MapTriangle, Parametrisation, ParametrisationError, Texel, TexelFinder, TexelGrid,
};
pub use partition::Partition;
pub use polygon::Polygon;
pub use shape::{Disk, Rectangle, Shape, ShapeError, Sphere, Triangle, box_corners};
pub(crate) use shape::{finite as finite_point, positive, unit};

/// `glam`'s double-precision vector, re-exported so that users need not match its version.
pub use glam::DVec3;
