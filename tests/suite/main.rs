//! Whole-path tests, one module per subject.

mod case_files;
mod shipped_cases;
