//! A progress bar with rate and remaining time, on a terminal only.

use std::collections::BTreeMap;
use std::sync::Mutex;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::calibration;
use crate::trial::Progress;

/// Shows how far a run is: by cases, each weighed alike, since only running cases know their cost.
pub struct Bar {
    bar: ProgressBar,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    done: u64,
    /// Rays of the cases that are under way: planned so far, and traced.
    under_way: BTreeMap<String, (u64, u64)>,
}

/// Steps of the bar for one case.
const STEPS: u64 = 1000;

impl Bar {
    /// `indicatif` draws on stderr and hides itself where that is no terminal.
    pub fn new(cases: usize, quiet: bool) -> Bar {
        let bar = drawn(cases as u64 * STEPS, quiet);
        Bar { bar, state: Mutex::default() }
    }

    /// Takes a message of the run; cheap enough for every unit of work.
    pub fn show(&self, progress: Progress) {
        let Ok(mut state) = self.state.lock() else { return };
        match progress {
            Progress::Begun(name) => {
                state.under_way.insert(name.to_owned(), (0, 0));
            }
            Progress::Planned { case, rays } => {
                if let Some((planned, _)) = state.under_way.get_mut(case) {
                    *planned += rays;
                }
            }
            Progress::Traced { case, rays } => {
                if let Some((_, traced)) = state.under_way.get_mut(case) {
                    *traced += rays;
                }
            }
            Progress::Done(name) => {
                state.under_way.remove(name);
                state.done += 1;
            }
        }
        if let Progress::Begun(_) | Progress::Done(_) = progress {
            let names: Vec<&str> = state.under_way.keys().map(String::as_str).collect();
            self.bar.set_message(names.join(", "));
        }
        // A case's plan grows while it runs, so its share may not run ahead of what is known.
        let share = |(planned, traced): &(u64, u64)| (STEPS * traced).checked_div(*planned).unwrap_or(0).min(STEPS);
        let position = state.done * STEPS + state.under_way.values().map(share).sum::<u64>();
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
