//! Radiometric quantities and the laws between them.

mod quantity;

pub use quantity::{Albedo, Area, Exitance, Flux, FormFactor, Irradiance, Radiosity};
