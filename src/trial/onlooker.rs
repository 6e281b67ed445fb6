//! Who looks on while a run goes on: is told how far it is, and may end it between two units of work.

use std::ops::ControlFlow;

use super::desk::{Desk, Portion, Record, Stage};
use super::keeper::{Absent, Keeper, Kept, Unit};
use super::outcome::CaseOutcome;

/// What a run tells while it goes on.
#[derive(Clone, Copy, Debug)]
pub enum Progress<'a> {
    /// A case begins; its name. Several may be under way at a time.
    Begun(&'a str),
    /// So many more rays of a case are to come: shadow rays, rays from the light, paths from the eye.
    Planned { case: &'a str, rays: u64 },
    /// This many rays of a case were traced; nought where only the exact side has come on.
    Traced { case: &'a str, rays: u64 },
    /// A case is done: which of those given, counted from 0, and what came of it.
    Done { index: usize, outcome: &'a CaseOutcome },
    /// What is to be done here of a case is done, the rest is left to others; its name.
    Shared(&'a str),
}

/// Takes what a run tells, and says whether it is to go on.
pub type Tell<'a> = dyn Fn(Progress) -> ControlFlow<()> + Sync + 'a;

/// Nobody wants more of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stopped;

/// Who looks on at one case, and who has its units.
#[derive(Clone, Copy)]
pub(super) struct Onlooker<'a> {
    case: &'a str,
    tell: &'a Tell<'a>,
    /// With the case's place among those of the run.
    keeper: Option<(&'a dyn Keeper, u32)>,
}

impl<'a> Onlooker<'a> {
    /// Nothing is kept.
    pub fn new(case: &'a str, tell: &'a Tell) -> Onlooker<'a> {
        Onlooker { case, tell, keeper: None }
    }

    /// - `index`: the case's place among those of the run
    pub fn with(self, keeper: Option<&'a dyn Keeper>, index: usize) -> Onlooker<'a> {
        Onlooker { keeper: keeper.map(|keeper| (keeper, index as u32)), ..self }
    }

    /// Asked where nothing is to be told.
    pub fn goes_on(&self) -> Result<(), Stopped> {
        self.traced(0)
    }

    fn told(&self, progress: Progress) -> Result<(), Stopped> {
        match (self.tell)(progress) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Stopped),
        }
    }
}

impl Desk for Onlooker<'_> {
    type End = Stopped;

    fn wants(&self, stage: Stage) -> bool {
        self.keeper.is_none_or(|(keeper, case)| keeper.wants(case, stage))
    }

    fn planned(&self, rays: u64) -> Result<(), Stopped> {
        self.told(Progress::Planned { case: self.case, rays })
    }

    fn traced(&self, rays: u64) -> Result<(), Stopped> {
        self.told(Progress::Traced { case: self.case, rays })
    }

    fn unit<T: Record>(
        &self,
        portion: Portion,
        rays: u64,
        fits: impl Fn(&T) -> bool,
        make: impl FnOnce() -> Result<(T, f64), Stopped>,
    ) -> Result<Option<(T, f64)>, Stopped> {
        let Some((keeper, case)) = self.keeper else { return make().map(Some) };
        let unit = Unit { case, portion };
        let read = |kept: Kept| Some((postcard::from_bytes(&kept.bytes).ok().filter(&fits)?, kept.seconds));
        let found = keeper.found(&unit).and_then(read);
        if let Some(found) = found {
            self.traced(rays)?;
            return Ok(Some(found));
        }
        match keeper.absent(&unit) {
            Absent::Make => {}
            Absent::Leave => {
                self.traced(rays)?;
                return Ok(None);
            }
            Absent::GiveUp => return Err(Stopped),
        }
        let (made, seconds) = make()?;
        let bytes = postcard::to_allocvec(&made).expect("numbers and lists of known length are written");
        match keeper.keep(&unit, Kept { bytes, seconds }) {
            ControlFlow::Continue(()) => Ok(Some((made, seconds))),
            ControlFlow::Break(()) => Err(Stopped),
        }
    }
}
