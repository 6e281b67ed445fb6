//! Judging others: a sampler or an estimator handed over in code, a program behind a pipe, a file of estimates, a file of
//! points.
//!
//! A test of your own sampler is five lines:
//!
//! ```
//! use etendue::{Case, Draws, judge};
//!
//! fn mine(draws: &mut Draws, points: &mut [[f64; 2]]) {
//!     points.fill_with(|| [draws.unit(), draws.unit()]);
//! }
//!
//! # fn main() -> Result<(), etendue::case::SelectError> {
//! let case = Case::shipped("penumbra/eclipse")?;
//! judge(&case).quick().points("mine", &mine).assert_passes();
//! # Ok(())
//! # }
//! ```
//!
//! - [`judge`] asks a [`PointSampler`](crate::estimator::PointSampler) or an
//!   [`IrradianceEstimator`](crate::estimator::IrradianceEstimator) of this process; closures are both;
//! - [`Program`] asks a program in any language, over its standard input and output;
//! - [`read_estimates`] and [`read_sets`] read what was made before.
//!
//! Nothing predicts how the estimates of a guest spread. A verdict leans on a pilot run, or on a bound that the guest states
//! ([`Leaning`](crate::trial::Leaning)), and says which.

#[cfg(feature = "studies")]
mod error;
#[cfg(feature = "studies")]
mod estimates;
mod judgement;
#[cfg(feature = "studies")]
mod program;
#[cfg(feature = "studies")]
mod question;
#[cfg(feature = "studies")]
mod sets;

#[cfg(feature = "studies")]
pub use error::{AnswerFault, GuestError};
#[cfg(feature = "studies")]
pub use estimates::{judge_estimates, read_estimates};
pub use judgement::{Judge, Judgement, judge};
#[cfg(feature = "studies")]
pub use program::{Program, judge_program};
#[cfg(feature = "studies")]
pub use question::{ANSWER_HEADER, QUESTION_HEADER, write_questions};
#[cfg(feature = "studies")]
pub use sets::{PointSets, SetsError, judge_point_sets, read_sets, write_sets};
#[cfg(all(feature = "studies", any(fuzzing, test)))]
pub(crate) use {estimates::estimates_from_memory, sets::sets_from_memory};
