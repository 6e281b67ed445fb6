//! Where the points on a source come from: seeds, strategies and the maps from the unit square to a surface.

mod strategy;

pub use strategy::Strategy;
