//! Other renderers: a case written as a scene of theirs, and the images that they made of it.
//!
//! - [`recipe`] writes a scene with a [`Manifest`] that says what its pixels are;
//! - [`image`] reads stacks of images: NPY, PFM, OpenEXR (feature `plots`).
//!
//! Whether the images are right is judged by [`crate::trial`], where they meet the exact side.

pub mod image;
mod manifest;
mod pixels;
pub mod recipe;

pub use manifest::{Manifest, ManifestError, Seeds};
pub use pixels::PixelGrid;
