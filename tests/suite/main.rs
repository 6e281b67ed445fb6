//! Whole-path tests, one module per subject: `cargo test convergence` runs everything in `convergence.rs`.

mod certified;
mod exact;
