//! `etendue merge`: shards put together into the report of one run.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::Parser;

use super::commands::{fault, select, set_threads, take};
use super::conclude::conclude;
use super::exit;
use super::interrupt::Interrupt;
use super::options::{Command, Merge, Options, Reaching, Telling};
use super::run::{Writing, measured};
use super::share::journal;
use crate::case::{Case, Reach};
use crate::journal::{Gathered, Identity, Indices, JournalError, gather, shard_name};
use crate::report;
use crate::trial::{Division, Settings, Shard, quoted};

/// Missing shards that are named one by one in a loop for a shell.
const LOOPED: usize = 200;
/// Said of a shard that is made again: what there is of it is used.
const RESUMED: &str = " --resume";

pub fn merge(options: &Merge) -> u8 {
    merge_to_end(options).unwrap_or_else(|code| code)
}

fn merge_to_end(options: &Merge) -> Result<u8, u8> {
    set_threads(options.threads)?;
    // Another folder may become the current one below.
    let absolute = |path: &PathBuf| std::path::absolute(path).unwrap_or_else(|_| path.clone());
    let telling = Telling { format: options.telling.format, junit: options.telling.junit.as_ref().map(absolute) };
    let folder = std::env::current_dir().unwrap_or_default();
    let mut gathered = gather(&options.folders).map_err(|error| match &error {
        JournalError::Read { source, .. }
            if matches!(source.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) =>
        {
            fault(exit::USAGE, error)
        }
        _ => journal(error),
    })?;
    let Some(run) = gathered.identity.clone().filter(|_| gathered.is_whole()) else {
        return Err(incomplete(&gathered, options, &folder));
    };
    if !options.quiet && !gathered.duplicates.is_empty() {
        let names: Vec<String> = gathered.duplicates.iter().map(|path| path.display().to_string()).collect();
        say!("note: twice there, and the same: {}", names.join(", "));
    }
    if !can_be_asked_for(&run.settings) {
        return Err(fault(exit::SHARDS, "these shards were made with options that no run can have"));
    }
    if run.reach == Reach::Anywhere && !options.reaching.allow_outside {
        return Err(fault(
            exit::USAGE,
            "these shards were made with --allow-outside: their cases may name files anywhere; say it here, too",
        ));
    }
    gathered.settle();
    let out = absolute(&options.out);
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
    let keeper = gathered.keeper();
    let board = super::progress::Board::new(cases.len(), options.progress, options.quiet);
    let outcome = measured(&cases, &settings, Some(&keeper), &board, &|| interrupt.asked(), None);
    board.finish();
    let mut outcome = outcome?;
    if let Some(error) = keeper.fault() {
        let owner = lacking(&error, &cases, &run);
        let code = fault(exit::SHARDS, error);
        if let Some(owner) = owner {
            let name = shard_name(owner);
            say!(
                "take {name} away, wherever it is, and make it again:\n{}",
                again(&run, &[owner.index], options, &folder, RESUMED)
            );
        }
        return Err(code);
    }
    if !outcome.missing.is_empty() {
        say!("interrupted: no report was written");
        return Ok(exit::INTERRUPTED);
    }
    // What was there before stays until there is something to put in its place.
    report::claim(&out).map_err(|error| fault(exit::OUTPUT, error))?;
    outcome.command = run.command();
    let writing = Writing { out: &out, plots: !options.no_plots, watched: false };
    writing.write(&outcome, &cases, &settings, &interrupt)?;
    conclude(&outcome, &options.out, &telling, None, options.quiet, options.allow_undecided)
}

/// Says what is missing and what is not to be trusted, and what is to be run again.
fn incomplete(gathered: &Gathered, options: &Merge, here: &Path) -> u8 {
    let folders: Vec<String> = options.folders.iter().map(|folder| folder.display().to_string()).collect();
    let folders = folders.join(", ");
    let Some(run) = &gathered.identity else {
        let code = fault(exit::SHARDS, format!("no shard of a run is in {folders}"));
        gathered.faults.iter().for_each(|fault| say!("  {fault}"));
        return code;
    };
    let there = gathered.of as usize - gathered.missing.len();
    fault(exit::SHARDS, format!("the run is not whole: {there} of {} shards can be used, in {folders}", gathered.of));
    gathered.faults.iter().for_each(|fault| say!("  {fault}"));
    if gathered.missing.is_empty() {
        say!("every shard is there whole: take away what is named above, and merge again");
        return exit::SHARDS;
    }
    let missing = Indices(&gathered.missing);
    say!("  missing: {missing}");
    // What belongs to another run is in the way of going on: it is not thrown away unasked.
    let is_foreign = |fault: &JournalError| matches!(fault, JournalError::Foreign { .. });
    let resumed = if gathered.faults.iter().any(is_foreign) { "" } else { RESUMED };
    say!("{}", again(run, &gathered.missing, options, here, resumed));
    if resumed.is_empty() {
        say!("(before an array is sent: take away what belongs to another run; the line for a shell writes over it)");
    }
    exit::SHARDS
}

/// Whether the command line takes options like these: a file may say anything.
fn can_be_asked_for(settings: &Settings) -> bool {
    let options = settings.options(None);
    let words = ["etendue", "run"].into_iter().chain(options.split_whitespace());
    let asked = Options::try_parse_from(words).ok().and_then(|options| options.command);
    matches!(asked, Some(Command::Run(run)) if run.work.settings() == *settings)
}

/// The shard that should have what none has.
fn lacking(error: &JournalError, cases: &[Case], run: &Identity) -> Option<Shard> {
    let JournalError::Lacking { unit, .. } = error else { return None };
    let of = run.shard?.of;
    // What every shard makes for itself is made by the first as well.
    let index = Division::new(cases, &run.settings).owner(unit, of).unwrap_or(0);
    Some(Shard { index, of })
}

/// What is to be run again, for a scheduler and for a shell.
///
/// - `here`: where this command was given
fn again(run: &Identity, missing: &[u32], options: &Merge, here: &Path, resumed: &str) -> String {
    let of = run.shard.map_or(1, |shard| shard.of);
    // In the folder in which its cases were named.
    let (place, folder) = match run.place() {
        Some(place) if place != here => (format!("cd {}; ", quoted(&run.folder)), here.join(&options.folders[0])),
        _ => (String::new(), options.folders[0].clone()),
    };
    let command = run.command();
    let out = quoted(&folder.to_string_lossy()) + resumed;
    let array = format!("Slurm:  sbatch --array={} shards.sbatch", Indices(missing));
    if missing.len() > LOOPED {
        return format!(
            "run again:\n  {array}\n  shell:  {place}{command} --shard I/{of} --out {out}, for I of {}",
            Indices(missing)
        );
    }
    let each: Vec<String> = missing.iter().map(u32::to_string).collect();
    let each = each.join(" ");
    format!("run again:\n  {array}\n  shell:  {place}for i in {each}; do {command} --shard $i/{of} --out {out}; done")
}
