//! Whole-path tests, one module per subject: `cargo test convergence` runs everything in `convergence.rs`.

mod case_files;
mod certified;
mod exact;
mod papers;
#[cfg(all(feature = "cli", feature = "plots"))]
mod reference;
mod shipped_cases;
