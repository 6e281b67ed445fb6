//! How far a run is: a bar on a terminal, cut to its width; a line now and then where lines are wanted; else nothing.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::ValueEnum;

use super::standing::{Standing, bar, plain};
use crate::calibration;
use crate::trial::Progress;

/// A bar is drawn anew no sooner than this.
const BLINK: Duration = Duration::from_millis(100);
/// Plain lines come no sooner than this.
const NOW_AND_THEN: Duration = Duration::from_secs(10);

/// How progress is shown, on standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Manner {
    /// A bar on a terminal (lines on one that is dumb), else nothing
    #[default]
    Auto,
    /// A line now and then, for logs
    Plain,
    /// Nothing
    Never,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    Bar,
    Lines,
    Nothing,
}

impl Manner {
    fn shown(self, quiet: bool, terminal: bool, dumb: bool) -> Shown {
        match self {
            _ if quiet => Shown::Nothing,
            Manner::Never => Shown::Nothing,
            Manner::Plain => Shown::Lines,
            Manner::Auto if !terminal => Shown::Nothing,
            Manner::Auto if dumb => Shown::Lines,
            Manner::Auto => Shown::Bar,
        }
    }

    fn here(self, quiet: bool) -> Shown {
        let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        self.shown(quiet, std::io::stderr().is_terminal(), dumb)
    }
}

/// Draws on standard error without one control sequence: a bar is written over from the start of its line, with blanks
/// where it has become shorter. So there is nothing for `NO_COLOR` to take away, and nothing that a console has to know.
struct Screen {
    shown: Shown,
    begun: Instant,
    drawn: Option<Instant>,
    /// Columns that the last bar took.
    columns: usize,
}

impl Screen {
    fn new(shown: Shown) -> Screen {
        Screen { shown, begun: Instant::now(), drawn: None, columns: 0 }
    }

    /// Whether it is time to show something.
    fn is_due(&self) -> bool {
        match self.shown {
            Shown::Nothing => false,
            Shown::Bar => self.drawn.is_none_or(|drawn| drawn.elapsed() >= BLINK),
            Shown::Lines => self.drawn.unwrap_or(self.begun).elapsed() >= NOW_AND_THEN,
        }
    }

    fn show(&mut self, standing: &Standing) {
        self.drawn = Some(Instant::now());
        let standing = Standing { seconds: self.begun.elapsed().as_secs_f64(), ..*standing };
        match self.shown {
            Shown::Bar => self.draw(&bar(&standing, columns())),
            _ => said(&plain(&standing)),
        }
    }

    /// Takes the bar off; of lines, the last says what it came to.
    fn finish(&mut self, standing: &Standing) {
        match std::mem::replace(&mut self.shown, Shown::Nothing) {
            Shown::Bar => self.draw(""),
            Shown::Lines => {
                said(&plain(&Standing { seconds: self.begun.elapsed().as_secs_f64(), ended: true, ..*standing }));
            }
            Shown::Nothing => {}
        }
    }

    fn draw(&mut self, line: &str) {
        let columns = super::standing::columns_of(line);
        let blanks = " ".repeat(self.columns.saturating_sub(columns));
        // What cannot be shown is no fault of the run.
        let mut error = std::io::stderr().lock();
        let _ = write!(error, "\r{line}{blanks}")
            .and_then(|()| if line.is_empty() { write!(error, "\r") } else { Ok(()) });
        let _ = error.flush();
        self.columns = columns;
    }
}

fn said(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Columns of the terminal that standard error is.
fn columns() -> usize {
    let told = || std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let size = terminal_size::terminal_size_of(std::io::stderr());
    size.map(|(width, _)| usize::from(width.0)).or_else(told).unwrap_or(80)
}

/// Shows how far a run is: by cases, each weighed alike, since only running cases know their cost.
pub struct Board(Mutex<State>);

struct State {
    screen: Screen,
    cases: usize,
    done: usize,
    /// Rays of the cases that are under way: planned so far, and traced.
    under_way: BTreeMap<String, (u64, u64)>,
    rays: u64,
    /// The largest share that was shown: a plan that grows takes nothing back.
    share: f64,
}

impl State {
    fn take(&mut self, progress: Progress) {
        match progress {
            Progress::Begun(name) => {
                self.under_way.insert(name.to_owned(), (0, 0));
            }
            Progress::Planned { case, rays } => {
                if let Some((planned, _)) = self.under_way.get_mut(case) {
                    *planned += rays;
                }
            }
            Progress::Traced { case, rays } => {
                self.rays += rays;
                if let Some((_, traced)) = self.under_way.get_mut(case) {
                    *traced += rays;
                }
            }
            Progress::Done { outcome, .. } => self.done(&outcome.name),
            Progress::Shared(name) => self.done(name),
        }
        // A case's plan grows while it runs, so its share may not run ahead of what is known.
        let share = |(planned, traced): &(u64, u64)| match planned {
            0 => 0.0,
            _ => (*traced as f64 / *planned as f64).min(1.0),
        };
        let cases = self.done as f64 + self.under_way.values().map(share).sum::<f64>();
        self.share = self.share.max(cases / self.cases.max(1) as f64);
    }

    fn done(&mut self, case: &str) {
        self.under_way.remove(case);
        self.done += 1;
    }

    fn with<T>(&mut self, then: impl FnOnce(&mut Screen, &Standing) -> T) -> T {
        let names: Vec<&str> = self.under_way.keys().map(String::as_str).collect();
        let doing = names.join(", ");
        let standing = Standing {
            done: self.done as u64,
            all: self.cases as u64,
            what: "cases",
            share: self.share,
            rays: Some(self.rays),
            doing: &doing,
            seconds: 0.0,
            ended: false,
        };
        then(&mut self.screen, &standing)
    }
}

impl Board {
    pub fn new(cases: usize, manner: Manner, quiet: bool) -> Board {
        let screen = Screen::new(manner.here(quiet));
        Board(Mutex::new(State { screen, cases, done: 0, under_way: BTreeMap::new(), rays: 0, share: 0.0 }))
    }

    /// Takes a message of the run; cheap enough for every unit of work.
    pub fn show(&self, progress: Progress) {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.take(progress);
        if state.screen.is_due() {
            state.with(Screen::show);
        }
    }

    /// Takes it off the screen.
    pub fn finish(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).with(Screen::finish);
    }
}

/// Shows how far a calibration is, by runs.
pub struct RunBoard(Mutex<(Screen, u64, u64, String)>);

impl RunBoard {
    pub fn new() -> RunBoard {
        RunBoard(Mutex::new((Screen::new(Manner::Auto.here(false)), 0, 0, String::new())))
    }

    pub fn show(&self, progress: calibration::Progress) {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (screen, done, all, stage) = &mut *state;
        match progress {
            calibration::Progress::Stage(name) => name.clone_into(stage),
            calibration::Progress::Planned(runs) => *all = runs,
            calibration::Progress::Done(runs) => *done += runs,
        }
        if screen.is_due() {
            screen.show(&Self::standing(*done, *all, stage));
        }
    }

    fn standing(done: u64, all: u64, stage: &str) -> Standing<'_> {
        let share = done as f64 / all.max(1) as f64;
        Standing { done, all, what: "runs", share, rays: None, doing: stage, seconds: 0.0, ended: false }
    }

    /// Takes it off the screen.
    pub fn finish(&self) {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (screen, done, all, stage) = &mut *state;
        screen.finish(&Self::standing(*done, *all, stage));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_for_terminals_and_quiet_is_quiet() {
        let shown = |manner: Manner, terminal, dumb| manner.shown(false, terminal, dumb);
        assert_eq!(shown(Manner::Auto, true, false), Shown::Bar);
        assert_eq!(shown(Manner::Auto, true, true), Shown::Lines);
        for dumb in [false, true] {
            assert_eq!(shown(Manner::Auto, false, dumb), Shown::Nothing);
            for terminal in [false, true] {
                assert_eq!(shown(Manner::Plain, terminal, dumb), Shown::Lines);
                assert_eq!(shown(Manner::Never, terminal, dumb), Shown::Nothing);
                for manner in [Manner::Auto, Manner::Plain, Manner::Never] {
                    assert_eq!(manner.shown(true, terminal, dumb), Shown::Nothing);
                }
            }
        }
    }

    #[test]
    fn a_plan_that_grows_takes_nothing_back() {
        let board = Board::new(2, Manner::Never, false);
        let share = |progress| {
            board.show(progress);
            board.0.lock().unwrap().share
        };
        assert_eq!(share(Progress::Begun("a")), 0.0);
        assert_eq!(share(Progress::Traced { case: "a", rays: 10 }), 0.0, "nothing is known of a case without a plan");
        share(Progress::Planned { case: "a", rays: 40 });
        assert_eq!(share(Progress::Traced { case: "a", rays: 10 }), 0.25);
        assert_eq!(share(Progress::Planned { case: "a", rays: 1000 }), 0.25);
        assert_eq!(share(Progress::Traced { case: "a", rays: 5000 }), 0.5, "no case is more than whole");
        assert_eq!(board.0.lock().unwrap().rays, 5020);
    }
}
