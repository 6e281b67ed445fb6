//! A run: which estimates are made, what came of them, and what follows.
//!
//! A pilot of its own streams estimates the variance of each cell (strategy and sample count); the plan turns that into
//! replicates; the measurement is judged against the exact side. A run is a list of work units, each a pure function of
//! its key, and their results are merged in the order of the list: one thread or many give the same bytes.

mod accept;
#[cfg(feature = "studies")]
mod bill;
#[cfg(feature = "studies")]
mod compare;
#[cfg(feature = "studies")]
mod converge;
mod correlation;
#[cfg(feature = "studies")]
mod cost;
mod desk;
#[cfg(feature = "studies")]
mod division;
#[cfg(feature = "studies")]
mod fingerprint;
#[cfg(feature = "studies")]
mod forecast;
#[cfg(feature = "studies")]
mod growth;
mod guest;
#[cfg(feature = "studies")]
mod images;
#[cfg(feature = "studies")]
mod indirect;
mod judge;
#[cfg(feature = "studies")]
mod keeper;
mod lean;
#[cfg(feature = "studies")]
mod lecture;
#[cfg(feature = "studies")]
mod light;
#[cfg(feature = "studies")]
mod map_error;
mod measure;
#[cfg(feature = "studies")]
mod mesh_rays;
#[cfg(feature = "studies")]
mod onlooker;
mod outcome;
#[cfg(feature = "studies")]
mod picture;
#[cfg(feature = "studies")]
mod pieces;
mod plan;
mod predict;
mod rare;
#[cfg(feature = "studies")]
mod rates;
mod reach;
mod ready;
#[cfg(feature = "studies")]
mod repeat;
#[cfg(feature = "studies")]
mod run;
mod settings;
mod shown;
#[cfg(feature = "studies")]
mod spread;
#[cfg_attr(not(feature = "studies"), path = "points_by_area.rs")]
mod techniques;
#[cfg(feature = "studies")]
mod views;

#[cfg(feature = "studies")]
pub use bill::{Bill, Item, ShardCost};
#[cfg(feature = "studies")]
pub use compare::{
    Comparison, Pairing, Record, RecordedVariance, RecordedVerdict, VarianceChange, VerdictChange, compare,
};
#[cfg(feature = "studies")]
pub use converge::{ConvergenceOutcome, ConvergenceTerms, Level, NoConvergence, judge_convergence};
#[cfg(feature = "studies")]
pub use cost::{HierarchyCost, TimeTo, median};
pub use desk::{Portion, Stage};
#[cfg(feature = "studies")]
pub use division::{Division, Shard};
#[cfg(feature = "studies")]
pub use fingerprint::numeric_fingerprint;
#[cfg(feature = "studies")]
pub use forecast::{Forecast, forecast, least_rays};
#[cfg(feature = "studies")]
pub use growth::{Affine, Fits, GrowthStudy, Law, Observation, PowerLaw, growth};
pub use guest::{
    Asked, AskedCell, FEWEST_PILOT_REPLICATES, Invitation, NotJudged, Take, judge_answers, judge_given, judge_guest,
    judge_sets, questions,
};
#[cfg(feature = "studies")]
pub use images::{
    Cause, ImageTerms, ImagesOutcome, LEAST_TOLERANCE, LEAST_TOLERANCE_OF_HALVES, Part, Pixel, PixelTruth, as_judged,
    judge_images,
};
#[cfg(feature = "studies")]
pub use keeper::{Absent, Keeper, Kept, Unit};
pub use lean::Leaning;
#[cfg(feature = "studies")]
pub use lecture::{Lecture, LectureError, lecture};
#[cfg(feature = "studies")]
pub use onlooker::{Progress, Tell};
pub use outcome::{
    CaseOutcome, CausticBin, Cell, Correlation, JudgedProperty, LightOutcome, LightRow, MapRow, Measured,
    PathOutcome, PathRow, Rate, RatePoint, RunOutcome, StrategyOutcome, Timing,
};
#[cfg(feature = "studies")]
pub use picture::{
    Due, Judged, PictureSettings, ReceiverPicture, camera_picture, receiver_picture, receiver_picture_with,
};
pub use ready::Maker;
#[cfg(feature = "studies")]
pub use repeat::Repeated;
#[cfg(feature = "studies")]
pub use run::{TrialError, run, run_kept, run_share, run_while, run_with};
pub use settings::{Effort, Overrides, Settings, quoted};
#[cfg(feature = "studies")]
pub use views::{ReceiverViews, receiver_views};
