//! Whole-path tests, one module per subject: `cargo test exact` runs everything in `exact.rs`.

mod exact;
mod laws;
