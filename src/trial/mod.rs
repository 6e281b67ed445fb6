//! A run: which estimates are made, what came of them, and what follows.
//!
//! A pilot of its own streams estimates the variance of each cell (strategy and sample count); the plan turns that into
//! replicates; the measurement is judged against the exact side. A run is a list of work units, each a pure function of
//! its key, and their results are merged in the order of the list: one thread or many give the same bytes.

mod accept;
mod converge;
mod correlation;
mod forecast;
mod guest;
mod images;
mod indirect;
mod judge;
mod lean;
mod lecture;
mod light;
mod map_error;
mod measure;
mod outcome;
mod picture;
mod plan;
mod predict;
mod rare;
mod rates;
mod reach;
mod ready;
mod repeat;
mod run;
mod settings;
mod spread;

pub use converge::{ConvergenceOutcome, ConvergenceTerms, Level, NoConvergence, judge_convergence};
pub use forecast::{Forecast, forecast};
pub use guest::{
    Asked, AskedCell, FEWEST_PILOT_REPLICATES, Invitation, NotJudged, Take, judge_answers, judge_given, judge_guest,
    judge_sets, questions,
};
pub use images::{
    Cause, ImageTerms, ImagesOutcome, LEAST_TOLERANCE, LEAST_TOLERANCE_OF_HALVES, Part, Pixel, PixelTruth,
    judge_images,
};
pub use lean::Leaning;
pub use lecture::{Lecture, LectureError, lecture};
pub use outcome::{
    CaseOutcome, CausticBin, Cell, Correlation, JudgedProperty, LightOutcome, LightRow, MapRow, Measured,
    PathOutcome, PathRow, Rate, RatePoint, RunOutcome, StrategyOutcome, Timing,
};
pub use picture::{
    Due, Judged, PictureSettings, ReceiverPicture, camera_picture, receiver_picture, receiver_picture_with,
};
pub use repeat::Repeated;
pub use run::{Maker, Progress, TrialError, run, run_with};
pub use settings::{Effort, Overrides, Settings, quoted};
