//! `etendue run`: cases measured, judged and reported, to the end or until Ctrl-C.

use std::ops::ControlFlow;

use super::commands::{GENERATOR, endless, fault, select, set_threads};
use super::conclude::{Lines, conclude};
use super::interrupt::Interrupt;
use super::options::{Format, Run};
use super::progress::Board;
use super::{exit, guests, watch};
use crate::case::Case;
use crate::report::{self, ReportOptions};
use crate::trial::{self, Progress, RunOutcome, Settings};

/// Missing cases that are named one by one; the manifest names all.
const NAMED: usize = 5;

pub fn run(options: &Run) -> u8 {
    let code = if options.watch { watch::watch(options) } else { run_to_end(options) };
    code.unwrap_or_else(|code| code)
}

fn run_to_end(options: &Run) -> Result<u8, u8> {
    let cases = select(&options.work.cases)?;
    let sets = guests::sets(&options.points)?;
    let settings = options.work.settings();
    endless(&cases, &settings)?;
    let interrupt = Interrupt::heard()?;
    report::claim(&options.out).map_err(|error| fault(exit::OUTPUT, error))?;
    set_threads(options.work.threads)?;
    let lines = matches!(options.telling.format, Format::Jsonl).then(Lines::default);
    let selectors: Vec<&str> = options.work.cases.iter().map(String::as_str).collect();
    let command = settings.command(&selectors, None) + &guests::words(&options.points);
    let mut outcome = RunOutcome::new(settings.seed, String::new());
    if sets.is_empty() || options.work.strategy.is_some() {
        // What comes of points that were brought along belongs to a case's lines, too.
        let lines = lines.as_ref().filter(|_| sets.is_empty());
        outcome = measured(&cases, &settings, options, &|| interrupt.asked(), lines)?;
    }
    outcome.command = command;
    if !sets.is_empty() {
        guests::join(&mut outcome, &cases, &settings, &sets, &options.points, lines.as_ref(), &interrupt)?;
    }
    if outcome.missing.is_empty() {
        write(&outcome, &cases, &settings, options, &interrupt)?;
        return conclude(&outcome, &options.out, &options.telling, lines, options.quiet, options.allow_undecided);
    }
    if !outcome.cases.is_empty() {
        write(&outcome, &cases, &settings, options, &interrupt)?;
        conclude(&outcome, &options.out, &options.telling, lines, options.quiet, options.allow_undecided)?;
    }
    anstream::eprintln!("{}", told(&outcome, &cases, &settings, options));
    Ok(exit::INTERRUPTED)
}

/// Measures and judges cases, and shows how far that is.
///
/// - `stop`: asked between units of work
/// - `lines`: told of each case that is done
pub(super) fn measured(
    cases: &[Case],
    settings: &Settings,
    options: &Run,
    stop: &(dyn Fn() -> bool + Sync),
    lines: Option<&Lines>,
) -> Result<RunOutcome, u8> {
    let board = Board::new(cases.len(), options.progress, options.quiet);
    let outcome = trial::run_while(cases, settings, &|progress| {
        board.show(progress);
        if let (Some(lines), Progress::Done { index, outcome }) = (lines, progress) {
            lines.done(index, Some(outcome));
        }
        if stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    board.finish();
    outcome.map_err(|error| fault(exit::BUG, error))
}

/// The report, whole.
pub(super) fn write(
    outcome: &RunOutcome,
    cases: &[Case],
    settings: &Settings,
    options: &Run,
    interrupt: &Interrupt,
) -> Result<(), u8> {
    let plots = !options.no_plots;
    let finished = |case: &&Case| plots && outcome.cases.iter().any(|done| done.name == case.name);
    let views = trial::receiver_views(cases.iter().filter(finished), settings);
    let how = ReportOptions { generator: GENERATOR, plots, views: &views, watched: options.watch };
    let written = interrupt.while_writing(&options.out, || report::write(&options.out, outcome, &how));
    written.map(|_| ()).map_err(|error| fault(exit::OUTPUT, error))
}

/// What is said of a run that was interrupted, in one line.
pub(super) fn told(outcome: &RunOutcome, cases: &[Case], settings: &Settings, options: &Run) -> String {
    let (done, all) = (outcome.cases.len(), cases.len());
    if done == 0 {
        let plural = if all == 1 { "the case was not finished" } else { "none of the cases was finished" };
        return format!("interrupted: 0 of {all}: {plural}, and no report was written");
    }
    let missing: Vec<&Case> = cases.iter().filter(|case| outcome.missing.contains(&case.name)).collect();
    let names: Vec<&str> = missing.iter().map(|case| case.name.as_str()).take(NAMED).collect();
    let names = names.join(", ");
    let rest = if missing.len() > NAMED {
        format!("missing: {names} and {} more (manifest.json names them all)", missing.len() - NAMED)
    } else {
        let selectors: Vec<&str> = missing.iter().map(|case| case.selector.as_str()).collect();
        let command = settings.command(&selectors, None) + &guests::words(&options.points);
        format!("missing: {names}; what runs them: {command} --out {}", trial::quoted(&rest(options)))
    };
    format!("interrupted: {done} of {all} cases finished; report: {}; {rest}", options.out.display())
}

/// A folder beside the report's, so that the rest does not take its place.
fn rest(options: &Run) -> String {
    format!("{}-rest", options.out.to_string_lossy().trim_end_matches('/'))
}
