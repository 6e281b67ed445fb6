//! Who keeps what units of work came to, and whose they are.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::desk::{Portion, Stage};

/// A unit of a run: the smallest part whose result is kept by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Unit {
    /// The case, counted from 0 in the order of the run.
    pub case: u32,
    pub portion: Portion,
}

/// What came of a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// A pure function of the unit and of the run's settings.
    pub bytes: Vec<u8>,
    /// That it took. Differs from time to time.
    pub seconds: f64,
}

/// What to do about a unit that nobody has kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absent {
    /// It is made now, and kept.
    Make,
    /// It is somebody else's share.
    Leave,
    /// It should have been there: the run ends.
    GiveUp,
}

/// Who keeps the results of units. Asked from many threads at a time.
pub trait Keeper: Sync {
    /// What a unit came to, if it is here.
    fn found(&self, unit: &Unit) -> Option<Kept>;

    fn absent(&self, unit: &Unit) -> Absent;

    /// Takes what came of a unit. `Break`: it cannot be kept, and without that the run is in vain.
    fn keep(&self, unit: &Unit, kept: Kept) -> ControlFlow<()>;

    /// Whether anything of a stage of a case is to be made here, or to be had.
    fn wants(&self, _case: u32, _stage: Stage) -> bool {
        true
    }

    /// Whether units are made here, rather than all had.
    fn makes(&self) -> bool {
        true
    }

    /// Whether some units may be somebody else's, so that nothing is judged.
    fn shares(&self) -> bool {
        false
    }
}
