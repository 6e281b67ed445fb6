//! Whole-path tests, one module per subject: `cargo test convergence` runs everything in `convergence.rs`.

mod case_files;
mod certified;
mod exact;
mod laws;
mod shipped_cases;
