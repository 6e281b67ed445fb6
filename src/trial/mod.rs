//! A run: which estimates are made, what came of them, and what follows.

mod outcome;

pub use outcome::{
    CaseOutcome, Cell, Correlation, JudgedProperty, Measured, Rate, RatePoint, RunOutcome, StrategyOutcome, Timing,
};
