//! Whole-path tests, one module for each subject.

mod certified;
