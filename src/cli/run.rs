//! `etendue run`: cases measured, judged and reported, to the end or until Ctrl-C.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use super::commands::{GENERATOR, endless, fault, select, set_threads, take};
use super::conclude::{Lines, conclude};
use super::interrupt::Interrupt;
use super::options::{Format, Run};
use super::progress::Board;
use super::{exit, guests, share, watch};
use crate::case::Case;
use crate::journal::{Checkpoint, Identity, JournalError};
use crate::report::{self, ReportOptions};
use crate::trial::{self, Keeper, Progress, RunOutcome, Settings};

/// Missing cases that are named one by one; the manifest names all.
const NAMED: usize = 5;

pub fn run(options: &Run) -> u8 {
    let code = match options.shard {
        Some(shard) => share::share(options, shard),
        None if options.watch => watch::watch(options),
        None => run_to_end(options),
    };
    code.unwrap_or_else(|code| code)
}

fn run_to_end(options: &Run) -> Result<u8, u8> {
    let cases = select(&options.work.cases, &options.work.reaching)?;
    let sets = guests::sets(&options.points)?;
    let settings = options.work.settings();
    endless(&cases, &settings, 1)?;
    let interrupt = Interrupt::heard()?;
    let _lock = take(&options.out)?;
    set_threads(options.work.threads)?;
    // Points that were brought along are judged by themselves: nothing is kept of that.
    let own = sets.is_empty() || options.work.strategy.is_some();
    let checkpoint = own.then(|| checkpoint(&cases, &settings, options)).transpose()?;
    report::claim(&options.out).map_err(|error| fault(exit::OUTPUT, error))?;
    let lines = matches!(options.telling.format, Format::Jsonl).then(Lines::default);
    let command = options.work.command() + &guests::words(&options.points);
    let mut outcome = RunOutcome::new(settings.seed, String::new());
    if let Some(checkpoint) = &checkpoint {
        // What comes of points that were brought along belongs to a case's lines, too.
        let lines = lines.as_ref().filter(|_| sets.is_empty());
        let board = Board::new(cases.len(), options.progress, options.quiet);
        let warned = AtomicBool::new(false);
        let asked = || {
            if let Some(fault) = checkpoint.fault()
                && !warned.swap(true, Relaxed)
            {
                say!("warning: {fault}; what is done without room for it is lost if the run is interrupted");
            }
            interrupt.asked()
        };
        let measured = measured(&cases, &settings, Some(checkpoint), &board, &asked, lines);
        board.finish();
        asked();
        outcome = measured?;
    }
    outcome.command = command;
    if !sets.is_empty() {
        guests::join(&mut outcome, &cases, &settings, &sets, &options.points, lines.as_ref(), &interrupt)?;
    }
    let writing = Writing { out: &options.out, plots: !options.no_plots, watched: false };
    let conclude =
        |lines| conclude(&outcome, &options.out, &options.telling, lines, options.quiet, options.allow_undecided);
    if outcome.missing.is_empty() {
        let report = writing.write(&outcome, &cases, &settings, &interrupt)?;
        // All is told before what it was made of is gone.
        let code = conclude(lines)?;
        checkpoint.map_or(Ok(()), |checkpoint| checkpoint.remove(&report)).map_err(share::journal)?;
        return Ok(code);
    }
    if !outcome.cases.is_empty() {
        writing.write(&outcome, &cases, &settings, &interrupt)?;
        conclude(lines)?;
    }
    say!("{}", told(&outcome, &cases, options));
    Ok(exit::INTERRUPTED)
}

/// What is kept of this run while it goes on; with what an earlier one left, where that is wanted.
fn checkpoint(cases: &[Case], settings: &Settings, options: &Run) -> Result<Checkpoint, u8> {
    let identity = Identity::new(cases, settings, &options.work.cases, options.work.reaching.reach(), None);
    if !options.resume {
        if Checkpoint::is_in(&options.out) && !options.quiet {
            let out = options.out.display();
            say!("note: begins anew; an interrupted run had left work in {out} (--resume goes on)");
        }
        return Checkpoint::begin(&options.out, &identity).map_err(share::journal);
    }
    let checkpoint = Checkpoint::resume(&options.out, &identity).map_err(|error| {
        let way =
            matches!(error, JournalError::Foreign { .. } | JournalError::Torn { .. } | JournalError::Damaged { .. });
        // A checkpoint that is damaged is not better another time.
        let code = if way { fault(exit::USAGE, error) } else { share::journal(error) };
        if way {
            say!("give the command that it belongs to, another --out, or leave out --resume to begin anew");
        }
        code
    })?;
    if !options.quiet {
        match checkpoint.resumed() {
            0 => say!("note: no interrupted run has left anything in {}", options.out.display()),
            n => say!("going on: {n} results are there"),
        }
    }
    Ok(checkpoint)
}

/// Measures and judges cases, and shows how far that is.
///
/// - `keeper`: has the results of units
/// - `stop`: asked between units of work
/// - `lines`: told of each case that is done
pub(super) fn measured(
    cases: &[Case],
    settings: &Settings,
    keeper: Option<&dyn Keeper>,
    board: &Board,
    stop: &(dyn Fn() -> bool + Sync),
    lines: Option<&Lines>,
) -> Result<RunOutcome, u8> {
    let tell = |progress: Progress| {
        board.show(progress);
        if let (Some(lines), Progress::Done { index, outcome }) = (lines, progress) {
            lines.done(index, Some(outcome));
        }
        if stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let outcome = match keeper {
        Some(keeper) => trial::run_kept(cases, settings, keeper, &tell),
        None => trial::run_while(cases, settings, &tell),
    };
    outcome.map_err(share::of_trial)
}

/// Where a report goes, and what it has.
pub(super) struct Writing<'a> {
    pub out: &'a Path,
    pub plots: bool,
    pub watched: bool,
}

impl Writing<'_> {
    /// The report, whole; returns its files.
    pub fn write(
        &self,
        outcome: &RunOutcome,
        cases: &[Case],
        settings: &Settings,
        interrupt: &Interrupt,
    ) -> Result<Vec<PathBuf>, u8> {
        let finished = |case: &&Case| self.plots && outcome.cases.iter().any(|done| done.name == case.name);
        let views = trial::receiver_views(cases.iter().filter(finished), settings);
        let how = ReportOptions { generator: GENERATOR, plots: self.plots, views: &views, watched: self.watched };
        let written = interrupt.while_writing(self.out, || report::write(self.out, outcome, &how));
        written.map_err(|error| fault(exit::OUTPUT, error))
    }
}

/// What is said of a run that was interrupted, in one line.
pub(super) fn told(outcome: &RunOutcome, cases: &[Case], options: &Run) -> String {
    let (done, all) = (outcome.cases.len(), cases.len());
    let command = options.work.command() + &guests::words(&options.points);
    let out = trial::quoted(&options.out.to_string_lossy());
    let rest = if options.watch { String::new() } else { format!("; what goes on: {command} --out {out} --resume") };
    if done == 0 {
        let which = if all == 1 { "the case was not finished" } else { "none of the cases was finished" };
        return format!("interrupted: 0 of {all}: {which}, and no report was written{rest}");
    }
    let named: Vec<&str> = outcome.missing.iter().map(String::as_str).take(NAMED).collect();
    let more = outcome.missing.len() - named.len();
    let more = if more > 0 { format!(" and {more} more (manifest.json names them all)") } else { String::new() };
    let out = options.out.display();
    format!("interrupted: {done} of {all} cases finished; report: {out}; missing: {}{more}{rest}", named.join(", "))
}
