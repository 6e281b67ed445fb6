//! A progress bar with rate and remaining time, on a terminal only.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::calibration;
use crate::trial::Progress;

/// Shows how far a run is: by cases, each weighed alike, since only running cases know their cost.
pub struct Bar {
    bar: ProgressBar,
    state: Mutex<State>,
    planned: AtomicU64,
    traced: AtomicU64,
}

struct State {
    finished: u64,
    started: bool,
}

/// Steps of the bar for one case.
const STEPS: u64 = 1000;

impl Bar {
    /// `indicatif` draws on stderr and hides itself where that is no terminal.
    pub fn new(cases: usize, quiet: bool) -> Bar {
        let bar = drawn(cases as u64 * STEPS, quiet);
        let state = Mutex::new(State { finished: 0, started: false });
        Bar { bar, state, planned: AtomicU64::new(0), traced: AtomicU64::new(0) }
    }

    /// Takes a message of the run; cheap enough for every unit of work.
    pub fn show(&self, progress: Progress) {
        let Ok(mut state) = self.state.lock() else { return };
        match progress {
            Progress::Case(name) => {
                state.finished += u64::from(state.started);
                state.started = true;
                self.planned.store(0, Ordering::Relaxed);
                self.traced.store(0, Ordering::Relaxed);
                self.bar.set_message(name.to_owned());
            }
            Progress::Planned(rays) => {
                self.planned.fetch_add(rays, Ordering::Relaxed);
            }
            Progress::Traced(rays) => {
                self.traced.fetch_add(rays, Ordering::Relaxed);
            }
        }
        let (planned, traced) = (self.planned.load(Ordering::Relaxed), self.traced.load(Ordering::Relaxed));
        // A case's plan grows while it runs, so its share may not run ahead of what is known.
        let share = (STEPS * traced).checked_div(planned).unwrap_or(0).min(STEPS);
        let position = state.finished * STEPS + share;
        if position > self.bar.position() {
            self.bar.set_position(position);
        }
    }

    /// Takes the bar off the screen.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

fn drawn(length: u64, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {elapsed} elapsed, {eta} left  {wide_msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

/// Shows how far a calibration is, by runs.
pub struct RunBar(ProgressBar);

impl RunBar {
    pub fn new() -> RunBar {
        RunBar(drawn(0, false))
    }

    pub fn show(&self, progress: calibration::Progress) {
        match progress {
            calibration::Progress::Stage(name) => self.0.set_message(name.to_owned()),
            calibration::Progress::Planned(runs) => self.0.set_length(runs),
            calibration::Progress::Done(runs) => self.0.inc(runs),
        }
    }

    /// Takes the bar off the screen.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
