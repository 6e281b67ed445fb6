//! `etendue run --shard I/N`: a part of a run, for another machine to put together.

use std::ops::ControlFlow;

use super::commands::{endless, fault, print, select, set_threads};
use super::exit;
use super::interrupt::Interrupt;
use super::options::{Format, Run};
use super::progress::Board;
use crate::journal::{Beginning, Finished, Identity, JournalError, ShardFile};
use crate::report;
use crate::trial::{self, Division, Shard, TrialError};

pub(super) fn share(options: &Run, shard: Shard) -> Result<u8, u8> {
    let cases = select(&options.work.cases, &options.work.reaching)?;
    endless(&cases, &options.work.settings(), shard.of)?;
    let interrupt = Interrupt::heard()?;
    report::probe(&options.out).map_err(|error| fault(exit::OUTPUT, error))?;
    set_threads(options.work.threads)?;
    let settings = options.work.settings();
    let identity = Identity::new(&cases, &settings, &options.work.cases, options.work.reaching.reach(), Some(shard));
    let division = Division::new(&cases, &settings);
    let file = match ShardFile::begin(&options.out, identity, division, options.resume).map_err(journal)? {
        Beginning::Finished(path, units) => {
            let bytes = std::fs::metadata(&path).map_or(0, |file| file.len());
            return tell(shard, &Finished { path, units: units as u64, bytes }, options, "was there");
        }
        Beginning::Work(file) => file,
    };
    if file.resumed() > 0 && !options.quiet {
        say!("going on: {} results are there", file.resumed());
    }
    if file.left && !options.quiet {
        say!("note: begins anew; earlier tries at this shard have left work (--resume goes on)");
    }
    let board = Board::new(cases.len(), options.progress, options.quiet);
    let all = trial::run_share(&cases, &settings, &*file, &|progress| {
        board.show(progress);
        if interrupt.asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    board.finish();
    if let Some(error) = file.fault() {
        let code = journal(error);
        say!("what was done before is kept; the same command with --resume goes on from there");
        return Err(code);
    }
    if !all.map_err(of_trial)? {
        let command = options.work.command();
        let out = trial::quoted(&options.out.to_string_lossy());
        say!("interrupted: what goes on: {command} --shard {shard} --out {out} --resume");
        return Ok(exit::INTERRUPTED);
    }
    let finished = file.finish().map_err(journal)?;
    tell(shard, &finished, options, "written")
}

fn tell(shard: Shard, finished: &Finished, options: &Run, how: &str) -> Result<u8, u8> {
    let Finished { path, units, bytes } = finished;
    match options.telling.format {
        Format::Text => print(&format!("shard {shard}: {units} results, {bytes} bytes {how}: {}\n", path.display()))?,
        Format::Json | Format::Jsonl => {
            let told = serde_json::json!({
                "shard": shard.index, "of": shard.of, "units": units, "bytes": bytes, "file": path.to_string_lossy(),
            });
            print(&format!("{told}\n"))?;
        }
    }
    Ok(exit::PASSED)
}

/// What is said of a journal that cannot be had, and the code to leave with.
pub(super) fn journal(error: JournalError) -> u8 {
    let code = match &error {
        error if error.may_pass() => exit::AGAIN,
        // The folder that the command names holds another run's work.
        JournalError::Foreign { .. } => exit::USAGE,
        _ => exit::OUTPUT,
    };
    fault(code, error)
}

/// The same of a run.
pub(super) fn of_trial(error: TrialError) -> u8 {
    let code = if matches!(error, TrialError::NoThread) { exit::AGAIN } else { exit::BUG };
    fault(code, error)
}
