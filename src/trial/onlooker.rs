//! Who looks on while a run goes on: is told how far it is, and may end it between two units of work.

use std::ops::ControlFlow;

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
}

/// Takes what a run tells, and says whether it is to go on.
pub type Tell<'a> = dyn Fn(Progress) -> ControlFlow<()> + Sync + 'a;

/// Nobody wants more of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stopped;

/// Who looks on at one case.
#[derive(Clone, Copy)]
pub(super) struct Onlooker<'a> {
    case: &'a str,
    tell: &'a Tell<'a>,
}

impl<'a> Onlooker<'a> {
    pub fn new(case: &'a str, tell: &'a Tell) -> Onlooker<'a> {
        Onlooker { case, tell }
    }

    /// So many more rays are to come.
    pub fn planned(&self, rays: u64) -> Result<(), Stopped> {
        self.told(Progress::Planned { case: self.case, rays })
    }

    /// So many rays were traced.
    pub fn traced(&self, rays: u64) -> Result<(), Stopped> {
        self.told(Progress::Traced { case: self.case, rays })
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
