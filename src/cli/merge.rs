//! `etendue merge`: shards put together into the report of one run.

use std::io::ErrorKind;
use std::path::Path;

use super::commands::{fault, select, set_threads, take};
use super::conclude::conclude;
use super::exit;
use super::interrupt::Interrupt;
use super::options::Merge;
use super::options::Reaching;
use super::run::{Writing, measured};
use super::share::journal;
use crate::case::Reach;
use crate::journal::{Gathered, Identity, Indices, JournalError, gather};
use crate::report;
use crate::trial::{Settings, quoted};

/// Missing shards that are named one by one in a loop for a shell.
const LOOPED: usize = 200;

pub fn merge(options: &Merge) -> u8 {
    merge_to_end(options).unwrap_or_else(|code| code)
}

fn merge_to_end(options: &Merge) -> Result<u8, u8> {
    set_threads(options.threads)?;
    let gathered = gather(&options.folders).map_err(|error| match &error {
        JournalError::Read { source, .. } if source.kind() == ErrorKind::NotFound => fault(exit::USAGE, error),
        _ => journal(error),
    })?;
    let Some(run) = gathered.identity.clone().filter(|_| gathered.is_whole()) else {
        return Err(incomplete(&gathered, options));
    };
    if !options.quiet && !gathered.duplicates.is_empty() {
        let names: Vec<String> = gathered.duplicates.iter().map(|path| path.display().to_string()).collect();
        anstream::eprintln!("note: twice there, and the same: {}", names.join(", "));
    }
    let out = std::path::absolute(&options.out).unwrap_or_else(|_| options.out.clone());
    let _lock = take(&out)?;
    // Cases are read where they were read for the shards, so that everything is called what it was called there.
    if let Some(folder) = run.place() {
        let _ = std::env::set_current_dir(folder);
    }
    let cases = select(&run.selectors, &Reaching { allow_outside: run.reach == Reach::Anywhere })?;
    let settings: Settings = run.settings.clone();
    let here = Identity::new(&cases, &settings, &run.selectors, run.reach, run.shard);
    if let Some(why) = here.difference(&run) {
        return Err(fault(exit::SHARDS, format!("these shards belong to another run than can be made here: {why}")));
    }
    let interrupt = Interrupt::heard()?;
    report::claim(&out).map_err(|error| fault(exit::OUTPUT, error))?;
    let keeper = gathered.keeper();
    let board = super::progress::Board::new(cases.len(), options.progress, options.quiet);
    let outcome = measured(&cases, &settings, Some(&keeper), &board, &|| interrupt.asked(), None);
    board.finish();
    let mut outcome = outcome?;
    if let Some(error) = keeper.fault() {
        return Err(fault(exit::SHARDS, error));
    }
    if !outcome.missing.is_empty() {
        anstream::eprintln!("interrupted: no report was written");
        return Ok(exit::INTERRUPTED);
    }
    outcome.command = run.command();
    let writing = Writing { out: &out, plots: !options.no_plots, watched: false };
    writing.write(&outcome, &cases, &settings, &interrupt)?;
    conclude(&outcome, &options.out, &options.telling, None, options.quiet, options.allow_undecided)
}

/// Says what is missing and what is not to be trusted, and what is to be run again.
fn incomplete(gathered: &Gathered, options: &Merge) -> u8 {
    let folders: Vec<String> = options.folders.iter().map(|folder| folder.display().to_string()).collect();
    let folders = folders.join(", ");
    let Some(run) = &gathered.identity else {
        let code = fault(exit::SHARDS, format!("no shard of a run is in {folders}"));
        gathered.faults.iter().for_each(|fault| anstream::eprintln!("  {fault}"));
        return code;
    };
    let there = gathered.of as usize - gathered.missing.len();
    fault(exit::SHARDS, format!("the run is not whole: {there} of {} shards can be used, in {folders}", gathered.of));
    gathered.faults.iter().for_each(|fault| anstream::eprintln!("  {fault}"));
    if gathered.missing.is_empty() {
        anstream::eprintln!("every shard is there whole: take away what is named above, and merge again");
        return exit::SHARDS;
    }
    let missing = Indices(&gathered.missing);
    anstream::eprintln!("  missing: {missing}");
    anstream::eprintln!("{}", again(run, &gathered.missing, &options.folders[0]));
    exit::SHARDS
}

/// What is to be run again, for a scheduler and for a shell.
fn again(run: &Identity, missing: &[u32], folder: &Path) -> String {
    let of = run.shard.map_or(1, |shard| shard.of);
    let command = run.command();
    let out = quoted(&folder.to_string_lossy());
    let array = format!("Slurm:  sbatch --array={} shards.sbatch", Indices(missing));
    if missing.len() > LOOPED {
        return format!(
            "run again:\n  {array}\n  shell:  {command} --shard I/{of} --out {out}, for I of {}",
            Indices(missing)
        );
    }
    let each: Vec<String> = missing.iter().map(u32::to_string).collect();
    let each = each.join(" ");
    format!("run again:\n  {array}\n  shell:  for i in {each}; do {command} --shard $i/{of} --out {out}; done")
}
