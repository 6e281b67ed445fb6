//! Where the work of a run is done: who hears of it, and who has kept what was done before.
//!
//! A run is made of units, each a pure function of its key. Whoever keeps their results can break off anywhere and go on
//! later, or have others do a part: what comes of them, put together in the order of the run, is the same bytes.

use crate::sampling::{Purpose, Strategy};

/// Shadow rays up to which a cell is one unit, tens of milliseconds: what is kept of it is then small.
const WHOLE: u64 = 1 << 24;

/// What a unit is a part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub enum Stage {
    /// Exact values.
    Exact,
    /// Predicted spreads.
    Predictions,
    /// A cell's pilot.
    Pilot { strategy: Strategy, samples: u64 },
    /// A cell.
    Measure { strategy: Strategy, samples: u64 },
    /// Rays from the light, so many.
    Light { rays: u64 },
    /// Eye paths from the points.
    Paths { next_event: bool },
    /// Eye paths from all over the receiver.
    Survey,
    /// The map that is compared with them.
    Compared,
}

impl Stage {
    pub(super) fn of_cell(purpose: Purpose, strategy: Strategy, samples: u64) -> Stage {
        match purpose {
            Purpose::Pilot => Stage::Pilot { strategy, samples },
            Purpose::Measurement => Stage::Measure { strategy, samples },
        }
    }
}

#[cfg(feature = "studies")]
impl std::fmt::Display for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Stage::Exact => f.write_str("the exact values"),
            Stage::Predictions => f.write_str("the predicted spreads"),
            Stage::Pilot { strategy, samples } => write!(f, "the pilot of {strategy} with {samples} samples"),
            Stage::Measure { strategy, samples } => write!(f, "{strategy} with {samples} samples"),
            Stage::Light { rays } => write!(f, "{rays} rays from the light"),
            Stage::Paths { next_event: true } => f.write_str("the eye paths with shadow rays"),
            Stage::Paths { next_event: false } => f.write_str("the eye paths"),
            Stage::Survey => f.write_str("the eye paths from the receiver"),
            Stage::Compared => f.write_str("the map that eye paths are compared with"),
        }
    }
}

/// What can be kept.
#[cfg(feature = "studies")]
pub trait Record: serde::Serialize + serde::de::DeserializeOwned {}
#[cfg(feature = "studies")]
impl<T: serde::Serialize + serde::de::DeserializeOwned> Record for T {}
/// What can be kept: nothing is.
#[cfg(not(feature = "studies"))]
pub trait Record {}
#[cfg(not(feature = "studies"))]
impl<T> Record for T {}

/// One of the equal parts of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct Portion {
    pub stage: Stage,
    /// Counted from 0.
    pub index: u32,
    /// How many there are; ≥ 1.
    pub of: u32,
}

impl Portion {
    /// A stage that is done in one go.
    pub(super) fn whole(stage: Stage) -> Portion {
        Portion { stage, index: 0, of: 1 }
    }
}

/// Who looks on at one case, and has its units.
pub(super) trait Desk: Sync {
    /// Nobody wants more.
    type End: Send + Sync;

    /// Whether anything of a stage is to be made here, or to be had.
    fn wants(&self, _stage: Stage) -> bool {
        true
    }

    /// So many more rays are to come.
    fn planned(&self, rays: u64) -> Result<(), Self::End>;

    /// So many rays were traced; nought where nobody traces any, but may want to end.
    fn traced(&self, rays: u64) -> Result<(), Self::End>;

    /// What a unit comes to, and its seconds: as it was kept, or made now.
    ///
    /// - `rays`: that `make` tells of
    /// - `fits`: whether what was kept has the shape of what `make` returns; else it is not what was asked for
    /// - `None`: it is somebody else's
    fn unit<T: Record>(
        &self,
        _portion: Portion,
        _rays: u64,
        _fits: impl Fn(&T) -> bool,
        make: impl FnOnce() -> Result<(T, f64), Self::End>,
    ) -> Result<Option<(T, f64)>, Self::End> {
        make().map(Some)
    }
}

/// Nobody.
pub(super) struct Alone;

impl Desk for Alone {
    type End = std::convert::Infallible;

    fn planned(&self, _: u64) -> Result<(), Self::End> {
        Ok(())
    }
    fn traced(&self, _: u64) -> Result<(), Self::End> {
        Ok(())
    }
}

/// Somebody who looks on, and keeps nothing of a part: it is within a unit.
pub(super) struct Within<'a, D>(pub &'a D);

impl<D: Desk> Desk for Within<'_, D> {
    type End = D::End;

    fn planned(&self, rays: u64) -> Result<(), D::End> {
        self.0.planned(rays)
    }
    fn traced(&self, rays: u64) -> Result<(), D::End> {
        self.0.traced(rays)
    }
}

/// Whether a cell is one unit, rather than one for each of its parts.
pub(super) fn is_whole(rays: u64) -> bool {
    rays <= WHOLE
}
