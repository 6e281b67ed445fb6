//! `etendue compare`: two reports beside each other.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::commands::{fault, print};
use super::exit;
use crate::report::{self, ComparisonFormat};
use crate::trial;

pub(super) const COMPARE_HELP: &str = "\
Worse is: a verdict that passed and does not any more, one that fails and did not before, and a variance that rose
beyond doubt (chance alone would tell so of one comparison in a million) in a case that is the same in both.

Examples:
  etendue run --out before            # on the main branch
  etendue run --out after             # with the change
  etendue compare before after
  etendue compare before after --format markdown >> \"$GITHUB_STEP_SUMMARY\"
  etendue compare after after --strategy random,stratified     # two strategies of one run

Exit codes:
  0   nothing got worse
  1   something did
  2   the command line is wrong
  4   the reports have nothing in common
  5   a report cannot be read";

/// Options of `compare`.
#[derive(Args, Debug)]
pub struct Compare {
    /// Folder of the report before
    pub before: PathBuf,
    /// Folder of the report after
    pub after: PathBuf,
    /// Compare one strategy of the run before with another of the run after
    #[arg(long, value_name = "BEFORE,AFTER", value_parser = pairing)]
    pub strategy: Option<(String, String)>,
    /// How the comparison is told
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
    /// List the variances, too, that did not change by more than chance may
    #[arg(long)]
    pub all: bool,
}

/// What is written to standard output.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Format {
    /// For a terminal
    Text,
    /// Tables for a pull request
    Markdown,
    /// One object
    Json,
}

fn pairing(text: &str) -> Result<(String, String), String> {
    match text.split_once(',') {
        Some((before, after)) if !before.is_empty() && !after.is_empty() => Ok((before.to_owned(), after.to_owned())),
        _ => Err("two names with a comma between, such as random,stratified".to_owned()),
    }
}

pub fn compare(options: &Compare) -> u8 {
    compare_to_end(options).unwrap_or_else(|code| code)
}

fn compare_to_end(options: &Compare) -> Result<u8, u8> {
    let read = |dir: &PathBuf| report::read(dir).map_err(|error| fault(exit::OUTPUT, error));
    let (before, after) = (read(&options.before)?, read(&options.after)?);
    let comparison = trial::compare(&before, &after, &options.strategy);
    if comparison.is_empty() {
        return Err(fault(
            exit::NOTHING,
            "the two reports have no case and strategy in common; `etendue list` has the names",
        ));
    }
    let format = match options.format {
        Format::Text => ComparisonFormat::Text,
        Format::Markdown => ComparisonFormat::Markdown,
        Format::Json => ComparisonFormat::Json,
    };
    let names = [&options.before, &options.after].map(|dir| dir.to_string_lossy());
    let names = [names[0].as_ref(), names[1].as_ref()];
    print(&report::comparison_text(&comparison, names, [&before, &after], format, options.all))?;
    Ok(if comparison.regresses() { exit::FAILED } else { exit::PASSED })
}
