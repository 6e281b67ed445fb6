//! Whole-path tests, one module per subject: `cargo test convergence` runs everything in `convergence.rs`.

mod calibration;
mod case_files;
mod caustics;
mod certified;
mod closed_forms;
#[cfg(feature = "cli")]
mod command_line;
mod compare;
mod convergence;
mod determinism;
mod docs;
mod edge;
mod estimator_laws;
mod exact;
mod examples;
mod first_met;
mod gauss;
mod guests;
mod icosphere;
mod images;
mod interreflections;
mod judge;
mod laws;
mod light;
#[cfg(all(feature = "cli", unix))]
mod long_runs;
mod machine_output;
mod meshes;
#[cfg(all(feature = "cli", unix))]
mod mitsuba;
#[cfg(all(feature = "cli", unix))]
mod nothing_lost;
mod optics;
mod page;
mod papers;
mod published;
mod radiometry;
#[cfg(all(feature = "cli", feature = "plots"))]
mod reference;
mod render;
mod samplers;
mod shipped_cases;
mod supply;
mod techniques;
mod walls;
mod witness;
mod words;
