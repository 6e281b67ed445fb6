//! What may be said on the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use super::progress::Manner;
use crate::calibration;
use crate::case::{Reach, Replicates, SmallestBias, nearest};
use crate::oracle::Parameter;
use crate::sampling::Strategy;
#[cfg(feature = "plots")]
use crate::trial::PictureSettings;
use crate::trial::{Effort, Overrides, Settings, Shard};

/// The exit codes of what judges, with more before them.
macro_rules! exit_codes {
    ($examples:literal) => {
        concat!(
            $examples,
            "\
Exit codes:
  0   every verdict passed
  1   a verdict failed
  2   the command line is wrong, or a case or a file that it names
  3   none failed but some are undecided (0 under --allow-undecided)
  4   nothing selected
  5   an output could not be written, or an image or a report not read
  70  a bug of ours
  75  worth trying again: another run has the folder, or the system is short of threads
  130 interrupted; what was finished is kept, --resume goes on"
        )
    };
}

const WHOLE_HELP: &str = exit_codes!(
    "\
Examples:
  etendue                                  # every shipped case, judged: half a minute on two cores
  etendue run my-room.toml                 # a case of your own
  etendue exact my-room.toml > exact.csv   # what the irradiance is, with bounds
  etendue judge penumbra/eclipse -- ./my-sampler
  etendue explain verdict

"
);

const RUN_HELP: &str = exit_codes!(
    "\
Examples:
  etendue run eclipse --quick              # a part of a name selects
  etendue run 'direct/*' --strategy random,stratified --samples 16,64,256
  etendue run my-room.toml --smallest-bias 0.001,0.01 --out fine
  etendue run my-room.toml --format json | jq '.verdicts[] | select(.verdict != \"pass\")'
  etendue run --points halton.csv penumbra/eclipse
  etendue run my-room.toml --quick --watch # again whenever the file changes
  etendue run --progress plain 2> run.log  # a line of progress every ten seconds
  etendue run rooms/ --shard 3/100 --out parts   # a part of the work, for another machine to merge

Ctrl-C (or SIGTERM) gives up the cases under way: the report has those that were finished, its
manifest names the missing ones. A second one ends at once. However a run ends, the same command
with --resume goes on from there. Where --watch waits, Ctrl-C is the usual end, with the code of the
last verdicts, or 2 if a case file is wrong at the time.

"
);

#[cfg(feature = "plots")]
const RENDER_HELP: &str = exit_codes!(
    "\
Examples:
  etendue render penumbra/eclipse --strategy correlated --samples 4
  etendue render --lecture --out figures

"
);

const LIST_HELP: &str = "\
Examples:
  etendue list penumbra
  etendue list --json | jq -r '.cases[].name'";

const CHECK_HELP: &str = "\
Examples:
  etendue check my-room.toml
  etendue check rooms/                     # every case in a folder

Exit codes: 0, or 2 with every mistake at its place.";

const EXACT_HELP: &str = "\
Examples:
  etendue exact penumbra/eclipse
  etendue exact penumbra/eclipse --limits
  etendue exact my-room.toml --derivative source.0.radius,occluder.0.center.x";

const PLAN_HELP: &str = "\
Examples:
  etendue plan my-room.toml --smallest-bias 0.001
  etendue plan --thorough --json
  etendue plan --thorough -n 200                          # what each of 200 shards would have
  etendue plan --thorough -n 200 --for slurm -o study     # scripts; study/submit.sh sends them";

const EXPLAIN_HELP: &str = "\
Examples:
  etendue explain                          # what there is
  etendue explain stratified
  etendue explain penumbra/eclipse";

const POINTS_HELP: &str = "\
Examples:
  etendue points stratified -n 64 --sets 1000 > stratified.csv
  etendue run penumbra/eclipse --points stratified.csv";

/// Measures Monte Carlo estimators of area-source lighting against exact values, and judges them.
///
/// Without a command, `run` is meant: every shipped case is measured, judged and reported.
#[derive(Debug, Parser)]
#[command(version, after_help = WHOLE_HELP, args_conflicts_with_subcommands = true)]
pub struct Options {
    #[command(subcommand)]
    pub command: Option<Command>,
    #[command(flatten)]
    pub run: Run,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Measure, judge, and write tables and plots (the default)
    #[command(after_help = RUN_HELP)]
    Run(Run),
    /// The shipped cases and the strategies
    #[command(after_help = LIST_HELP)]
    List(List),
    /// Read cases and report every mistake in them
    #[command(arg_required_else_help = true, after_help = CHECK_HELP)]
    Check(Check),
    /// Exact values at the measured points, as CSV
    #[command(after_help = EXACT_HELP)]
    Exact(Exact),
    /// Measure the gate itself: false alarms, coverage of intervals, power (minutes)
    #[command(after_help = "Exit codes: 0, or 1 where a figure misses its bar for certain.")]
    Calibrate(Calibrate),
    /// What a run would cost and could see, before it is spent
    #[command(after_help = PLAN_HELP)]
    Plan(Plan),
    /// How cost grows with samples, occluders, triangles, points and light rays: timed, plotted, fitted
    Growth(Growth),
    /// Put shards together into the report of one run, or say what is missing
    #[command(after_help = MERGE_HELP)]
    Merge(Merge),
    /// A report's page and plots, made anew from its tables
    #[command(after_help = REPORT_HELP)]
    Report(Report),
    /// Two reports: which verdicts changed, and where estimates vary more or less
    #[command(after_help = super::compare::COMPARE_HELP)]
    Compare(super::compare::Compare),
    /// Judge a program in any language: points on its standard input, estimates from its standard output
    #[command(after_help = super::guests::JUDGE_HELP)]
    Judge(super::guests::JudgeOptions),
    /// Judge images of another renderer, or a file of estimates
    #[command(after_help = super::guests::VERIFY_HELP)]
    Verify(super::guests::VerifyOptions),
    /// Write a case as a scene of another renderer, with a manifest and a script that renders it
    #[command(after_help = super::images::EXPORT_HELP)]
    Export(super::images::ExportOptions),
    /// Write a strategy's points in the unit square, as `run --points` reads them
    #[command(after_help = POINTS_HELP)]
    Points(super::guests::PointsOptions),
    /// Pictures of cases: by their cameras, and of their receivers beside what is exact there
    #[cfg(feature = "plots")]
    #[command(after_help = RENDER_HELP)]
    Render(Render),
    /// A verdict, a strategy, a case or a word of the reports: what it means, and what it does not say
    #[command(after_help = EXPLAIN_HELP)]
    Explain(Explain),
    /// A commented case file to start from
    New(New),
    /// The JSON schema of case files, for editors, to standard output
    #[command(after_help = SCHEMA_HELP)]
    Schema,
    /// Completions for a shell, to standard output
    #[command(after_help = COMPLETIONS_HELP)]
    Completions(Completions),
    /// The manual page of a command, to standard output
    #[command(after_help = "Example: etendue man > etendue.1; etendue man run | man -l -")]
    Man(Man),
}

const REPORT_HELP: &str = "\
Example: etendue report reports/latest

Draws plots/ and index.html from the tables (CSV), manifest.json and pictures that lie in the folder. What is missing or broken is
listed, on the page too; the rest is shown, and the exit code is 5. Page and plots are those of the run, byte for byte.";

const MERGE_HELP: &str = "\
Examples:
  etendue run rooms/ --shard 0/2 --out a
  etendue run rooms/ --shard 1/2 --out b
  etendue merge a b -o whole               # the same bytes as `etendue run rooms/ --out whole`

Files of shards are taken in any order, from any folders; two of the same shard are as good as one.
What is missing, damaged or of another run is named, with what is to be run again.

Exit codes: those of `run`, and
  6   shards are missing, damaged or foreign: nothing was written";

const SCHEMA_HELP: &str = "\
Editors that read TOML by a schema (Taplo, Even Better TOML) complete keys and mark mistakes where a case begins with

  #:schema ./etendue.schema.json

and `etendue schema > etendue.schema.json` was said beside it.";

const COMPLETIONS_HELP: &str = "\
Examples:
  etendue completions bash > ~/.local/share/bash-completion/completions/etendue
  etendue completions zsh > ~/.zfunc/_etendue
  etendue completions fish > ~/.config/fish/completions/etendue.fish";

#[derive(Args, Debug)]
pub struct New {
    /// Name of the case: `NAME.toml` is written, and the folders before it; a file that is there stays as it is
    #[arg(value_name = "NAME")]
    pub name: PathBuf,
}

#[derive(Args, Debug)]
pub struct Completions {
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

#[derive(Args, Debug)]
pub struct Man {
    /// Which command (default: the whole)
    #[arg(value_name = "COMMAND")]
    pub command: Option<String>,
}

/// How far the paths in case files may reach.
#[derive(Args, Debug)]
pub struct Reaching {
    /// Let cases name meshes and pictures anywhere, not only in the folder that is given (of a single file: its own)
    #[arg(long)]
    pub allow_outside: bool,
}

impl Reaching {
    pub fn reach(&self) -> Reach {
        if self.allow_outside { Reach::Anywhere } else { Reach::Inside }
    }
}

/// Which cases, and how hard to look: what moves numbers.
#[derive(Args, Debug)]
pub struct Work {
    /// Case files, folders, or names (whole, a part, or a pattern) of shipped cases; none: all shipped cases
    #[arg(value_name = "CASE")]
    pub cases: Vec<String>,
    /// A quick look: five times coarser, at most 64 samples
    #[arg(long, conflicts_with = "thorough")]
    pub quick: bool,
    /// Ten times finer than the cases ask
    #[arg(long)]
    pub thorough: bool,
    /// Strategies, separated by commas
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = strategy)]
    pub strategy: Option<Vec<Strategy>>,
    /// Points on each source, one or several counts separated by commas
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u64).range(1..=1 << 31))]
    pub samples: Option<Vec<u64>>,
    /// Independent repeats of each estimate: a number from 2 on, or `auto` for as many as the smallest bias needs
    #[arg(long, value_name = "R", value_parser = replicates)]
    pub replicates: Option<Replicates>,
    /// Relative biases that a pass must have been able to see: in the mean, and at the worst point (default: ten times
    /// the mean's)
    #[arg(long, value_name = "MEAN[,POINT]", value_parser = smallest_bias)]
    pub smallest_bias: Option<SmallestBias>,
    /// Seed of all random streams
    #[arg(long, value_name = "SEED", default_value_t = Settings::DEFAULT_SEED)]
    pub seed: u64,
    /// Threads (default: one for each core); the numbers do not depend on it
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub reaching: Reaching,
}

/// Options of `run`.
#[derive(Args, Debug)]
pub struct Run {
    #[command(flatten)]
    pub work: Work,
    /// Folder that the report is written to
    #[arg(long, value_name = "DIR", default_value = "reports/latest")]
    pub out: PathBuf,
    /// Print only failures and the summary, and no progress
    #[arg(long, short)]
    pub quiet: bool,
    /// How progress is shown on standard error
    #[arg(long, value_enum, default_value_t = Manner::Auto)]
    pub progress: Manner,
    /// Wait for case files to change, and run those anew that did; goes well with --quick
    #[arg(long, conflicts_with = "points")]
    pub watch: bool,
    /// Go on with what an interrupted run of the same command has left in the folder
    #[arg(long, conflicts_with = "watch")]
    pub resume: bool,
    /// One of N shares of the work, counted from 0, into a file in the folder; `etendue merge` puts them together
    #[arg(long, value_name = "I/N", value_parser = shard, conflicts_with_all = ["watch", "points", "junit"])]
    pub shard: Option<Shard>,
    /// Exit with 0 when some verdicts are undecided and none failed
    #[arg(long)]
    pub allow_undecided: bool,
    /// Write tables only
    #[arg(long)]
    pub no_plots: bool,
    #[command(flatten)]
    pub telling: Telling,
    /// File of point sets, as a strategy `points:NAME`; alone, unless --strategy names others beside it
    #[arg(long, value_name = "FILE")]
    pub points: Vec<PathBuf>,
}

/// Options of `merge`.
#[derive(Args, Debug)]
pub struct Merge {
    /// Folders that hold shards
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    #[command(flatten)]
    pub reaching: Reaching,
    /// Folder that the report is written to
    #[arg(long, short, value_name = "DIR", default_value = "reports/latest")]
    pub out: PathBuf,
    /// Print only failures and the summary, and no progress
    #[arg(long, short)]
    pub quiet: bool,
    /// Exit with 0 when some verdicts are undecided and none failed
    #[arg(long)]
    pub allow_undecided: bool,
    /// Write tables only
    #[arg(long)]
    pub no_plots: bool,
    /// How progress is shown on standard error
    #[arg(long, value_enum, default_value_t = Manner::Auto)]
    pub progress: Manner,
    #[command(flatten)]
    pub telling: Telling,
    /// Threads (default: one for each core)
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// How verdicts are told, and to whom.
#[derive(Args, Debug, Default)]
pub struct Telling {
    /// How the verdicts are told on standard output
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
    /// Write the verdicts as JUnit, too
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

/// What verdicts look like on standard output.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub enum Format {
    /// A table for a terminal
    #[default]
    Text,
    /// One object
    Json,
    /// One object a line: each verdict as soon as its case is done, then a summary
    Jsonl,
}

impl Work {
    /// The command that gives the same numbers: only what moves them.
    pub fn command(&self) -> String {
        let selectors: Vec<&str> = self.cases.iter().map(String::as_str).collect();
        self.settings().command(&selectors, None) + self.reaching.reach().words()
    }

    /// What a run is to do to the cases' own studies.
    pub fn settings(&self) -> Settings {
        let effort = match (self.quick, self.thorough) {
            (true, _) => Effort::Quick,
            (_, true) => Effort::Thorough,
            _ => Effort::Standard,
        };
        let overrides = Overrides {
            strategies: self.strategy.clone(),
            samples: self.samples.clone(),
            replicates: self.replicates,
            smallest_bias: self.smallest_bias,
        };
        Settings { seed: self.seed, effort, overrides }
    }
}

/// Options of `render`.
#[cfg(feature = "plots")]
#[derive(Args, Debug)]
pub struct Render {
    /// Case files, folders, or names (whole, a part, or a pattern) of shipped cases
    #[arg(value_name = "CASE", required_unless_present = "lecture")]
    pub cases: Vec<String>,
    /// The figures of the lecture instead
    #[arg(long, conflicts_with_all = ["cases", "strategy", "samples", "size"])]
    pub lecture: bool,
    /// Strategy of the points on the sources
    #[arg(long, value_name = "NAME", value_parser = strategy, default_value = "stratified")]
    pub strategy: Strategy,
    /// Points on each source for each pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 20), default_value_t = 16)]
    pub samples: u64,
    /// Width and height of the pictures (default: the camera's; 256 along the longer side of a receiver)
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[usize; 2]>,
    /// Seed of all random streams
    #[arg(long, value_name = "SEED", default_value_t = Settings::DEFAULT_SEED)]
    pub seed: u64,
    /// Folder that the pictures are written to
    #[arg(long, short, value_name = "DIR", default_value = "pictures")]
    pub out: PathBuf,
    /// Exit with 0 when some verdicts are undecided and none failed
    #[arg(long)]
    pub allow_undecided: bool,
    /// Threads (default: one for each core); the numbers do not depend on it
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub reaching: Reaching,
}

#[cfg(feature = "plots")]
impl Render {
    pub fn settings(&self) -> PictureSettings {
        let Render { strategy, samples, seed, size: pixels, .. } = *self;
        PictureSettings { strategy, samples, seed, pixels }
    }
}

#[derive(Args, Debug)]
pub struct Plan {
    #[command(flatten)]
    pub work: Work,
    /// Machine-readable
    #[arg(long)]
    pub json: bool,
    /// Shards that the work is divided among, from 1 to 100,000
    #[arg(short = 'n', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub shards: Option<u32>,
    /// Write the scripts that send the shards
    #[arg(long = "for", value_enum, value_name = "ENGINE", requires_all = ["shards", "out"])]
    pub engine: Option<super::cluster::Engine>,
    /// Folder that the scripts are written to
    #[arg(long, short, value_name = "DIR", requires = "engine")]
    pub out: Option<PathBuf>,
}

/// Options of `growth`.
#[derive(Args, Debug)]
pub struct Growth {
    /// Folder that the table, the page and the plots are written to
    #[arg(long, value_name = "DIR", default_value = "reports/growth")]
    pub out: PathBuf,
    /// Fewer sizes, and no mesh of a million triangles
    #[arg(long)]
    pub quick: bool,
}

impl Growth {
    pub fn effort(&self) -> Effort {
        if self.quick { Effort::Quick } else { Effort::Standard }
    }
}

#[derive(Args, Debug)]
pub struct Report {
    /// The folder of a report
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Make the page alone, no plots
    #[arg(long)]
    pub no_plots: bool,
}

#[derive(Args, Debug)]
pub struct Explain {
    /// verdict, bias, variance, covariance, judge, rate, correlation, region, a strategy, or a shipped case; none: what there is
    #[arg(value_name = "NAME")]
    pub name: Option<String>,
}

#[derive(Args, Debug)]
pub struct List {
    /// Names (whole, a part, or a pattern) of shipped cases, files or folders; none: all shipped cases
    #[arg(value_name = "CASE")]
    pub cases: Vec<String>,
    /// Machine-readable
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub reaching: Reaching,
}

#[derive(Args, Debug)]
pub struct Check {
    /// Case files, folders, or names of shipped cases
    #[arg(value_name = "CASE", required = true)]
    pub cases: Vec<String>,
    #[command(flatten)]
    pub reaching: Reaching,
}

#[derive(Args, Debug)]
pub struct Exact {
    /// Case files, folders, or names of shipped cases; none: all shipped cases
    #[arg(value_name = "CASE")]
    pub cases: Vec<String>,
    /// Where umbra and penumbra begin and end along each case's measured line, instead
    #[arg(long)]
    pub limits: bool,
    /// Adds the exact derivatives of the irradiance with respect to numbers of the case, separated by commas: such as
    /// source.0.center.x, occluder.1.radius, point.normal.z
    #[arg(long, value_name = "PARAMETER", value_delimiter = ',', conflicts_with = "limits")]
    pub derivative: Vec<Parameter>,
    #[command(flatten)]
    pub reaching: Reaching,
}

/// Options of `calibrate`.
#[derive(Args, Debug)]
pub struct Calibrate {
    /// Null runs, at least (default: 56000; 2000 with --quick)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    pub runs: Option<u64>,
    /// Folder that the tables are written to
    #[arg(long, value_name = "DIR", default_value = "reports/reference/calibration")]
    pub out: PathBuf,
    /// Base of the seeds of all runs
    #[arg(long, value_name = "SEED", default_value_t = calibration::Options::STANDARD.seed)]
    pub seed: u64,
    /// A look: too few runs for the smallest levels
    #[arg(long)]
    pub quick: bool,
    /// Threads (default: one for each core); the numbers do not depend on it
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

impl Calibrate {
    pub fn options(&self) -> calibration::Options {
        let usual = if self.quick { calibration::Options::QUICK } else { calibration::Options::STANDARD };
        calibration::Options { seed: self.seed, runs: self.runs.unwrap_or(usual.runs), ..usual }
    }
}

/// `I/N`, counted from 0.
fn shard(text: &str) -> Result<Shard, String> {
    let way = format!("a share of the work is I/N with I from 0 to N - 1, and N from 1 to {}", Shard::MOST);
    let (index, of) = text.split_once('/').ok_or(&way)?;
    match (index.parse(), of.parse()) {
        (Ok(index), Ok(of)) => Some(Shard { index, of }).filter(|shard| shard.is_valid()).ok_or(way),
        _ => Err(way),
    }
}

pub(super) fn strategy(name: &str) -> Result<Strategy, String> {
    Strategy::from_name(name).ok_or_else(|| {
        let known = Strategy::ALL.map(Strategy::name);
        let meant = nearest(name, known).map_or(String::new(), |meant| format!(" (did you mean {meant}?)"));
        format!("no such strategy{meant}; there are {}", known.join(", "))
    })
}

#[cfg(feature = "plots")]
fn size(text: &str) -> Result<[usize; 2], String> {
    let sides = text.split_once(['x', 'X', '×']).map(|(width, height)| (width.parse(), height.parse()));
    match sides {
        Some((Ok(width), Ok(height))) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("a width and a height in pixels, such as 512x512".to_owned()),
    }
}

pub(super) fn replicates(text: &str) -> Result<Replicates, String> {
    match text {
        "auto" => Ok(Replicates::Auto),
        _ => match text.parse() {
            Ok(n) if n >= 2 => Ok(Replicates::Fixed(n)),
            _ => Err("a whole number from 2 on, or `auto`".to_owned()),
        },
    }
}

pub(super) fn smallest_bias(text: &str) -> Result<SmallestBias, String> {
    let number = |text: &str| match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err("one or two numbers greater than zero, such as 0.01 or 0.01,0.1".to_owned()),
    };
    match text.split_once(',') {
        None => number(text).map(|mean| SmallestBias { mean, point: 10.0 * mean }),
        Some((mean, point)) => Ok(SmallestBias { mean: number(mean)?, point: number(point)? }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Options::command().debug_assert();
    }

    #[test]
    fn biases_come_alone_or_as_a_pair() {
        assert_eq!(smallest_bias("0.02"), Ok(SmallestBias { mean: 0.02, point: 0.2 }));
        assert_eq!(smallest_bias("0.02,0.05"), Ok(SmallestBias { mean: 0.02, point: 0.05 }));
        for wrong in ["", "-1", "0", "nan", "1,", "inf"] {
            assert!(smallest_bias(wrong).is_err(), "{wrong}");
        }
    }
}
