//! The commands that judge others: `judge`, `verify`, `points`, and `run --points`.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::commands::{GENERATOR, fault, print, select, take};
use super::conclude::{Lines, conclude};
use super::interrupt::Interrupt;
use super::{exit, options};
use crate::case::{Case, Replicates, SmallestBias};
use crate::guest::{self, GuestError, PointSets, Program};
use crate::report::{self, ReportOptions};
use crate::sampling::Strategy;
use crate::statistics::Verdict;
use crate::trial::{
    CaseOutcome, ConvergenceTerms, Effort, Invitation, Leaning, NoConvergence, NotJudged, Overrides, RunOutcome,
    Settings, judge_convergence, quoted,
};

/// Estimates that were judged, as `verify` reads them.
const ESTIMATES: &str = "estimates.csv";

pub(super) const JUDGE_HELP: &str = "\
The program reads lines of  point,x_m,y_m,z_m,nx,ny,nz,samples,replicate,seed  (a header first) until its input ends, and
writes a line  point,replicate,samples,value  for each, in the same order: the irradiance in W/m2 at that point, estimated
with so many samples, all its randomness from that seed. It is started twice: once for a pilot that tells how its estimates
spread, once for what is judged (once only with --variance random). `etendue explain judge` says more.

Exit codes: 0 passed, 1 failed, 2 the command line, a case or the program is wrong (it hangs, dies, answers out of order,
twice, too little, or what is no number), 3 undecided, 4 nothing selected, 5 an output could not be
written, 130 interrupted (answers that came before are kept).";

pub(super) const VERIFY_HELP: &str = "\
Images (NPY, PFM, OpenEXR) of a scene that `etendue export` wrote: K independent ones, or one with the variance of its pixels.
Their manifest is named, or lies beside the first as manifest.json. A report goes to --out.

A CSV holds lines  point,replicate,samples,value  in any order, after a header or none: points as `etendue exact CASE` numbers
them, every replicate with a value for every point. The first quarter of the replicates tells how the estimates spread
(unless --variance random says it), the others are judged. A witness without randomness is judged by --converging, from
estimates at three efforts or more (column samples).

`etendue explain verify` says more.

Exit codes: 0 passed, 1 failed, 2 the command line, a case or the manifest is wrong, or a CSV, 3 undecided (a single image without
a variance too), 4 nothing selected, 5 an image cannot be read or the report not be written.";

/// On what terms somebody else is judged.
#[derive(Args, Debug)]
pub struct Terms {
    /// What reports call the judged
    #[arg(long, value_name = "NAME")]
    pub(super) name: Option<String>,
    /// What the verdict leans on for the variance: a pilot, or the statement that it is at most that of `random`
    #[arg(long, value_name = "pilot|random", default_value = "pilot", value_parser = leaning)]
    variance: Leaning,
    /// Relative biases that a pass must have been able to see: in the mean, and at the worst point
    #[arg(long, value_name = "MEAN[,POINT]", value_parser = options::smallest_bias)]
    pub(super) smallest_bias: Option<SmallestBias>,
    /// Relative deviation that is no fault, such as 1e-5 for a program that works in f32
    #[arg(long, value_name = "SHARE", value_parser = tolerance)]
    pub(super) tolerance: Option<f64>,
    /// Exit with 0 when the verdict is undecided
    #[arg(long)]
    pub(super) allow_undecided: bool,
    #[command(flatten)]
    reaching: options::Reaching,
}

/// Options of `judge`.
#[derive(Args, Debug)]
pub struct JudgeOptions {
    /// A case file or the name of a shipped case
    #[arg(value_name = "CASE")]
    case: String,
    /// The program and its arguments, after `--`
    #[arg(value_name = "PROGRAM", last = true)]
    program: Vec<String>,
    /// Sample counts, separated by commas
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "16",
          value_parser = clap::value_parser!(u64).range(1..=1 << 31))]
    samples: Vec<u64>,
    /// Independent repeats of each estimate, or `auto` for as many as the smallest bias needs
    #[arg(long, value_name = "R", default_value = "auto", value_parser = options::replicates)]
    replicates: Replicates,
    /// Base of the seeds that the program is given
    #[arg(long, value_name = "SEED", default_value_t = Settings::DEFAULT_SEED)]
    seed: u64,
    /// Seconds that the program may be silent while an answer is due
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
    timeout: Duration,
    /// Folder for the report and the answers (estimates.csv), which stay when the program fails
    #[arg(long, value_name = "DIR", default_value = "reports/judge")]
    out: PathBuf,
    /// Only write the questions to stdout, for a program that is run by itself; `verify` judges its answers
    #[arg(long, conflicts_with_all = ["program", "variance"])]
    ask: bool,
    #[command(flatten)]
    telling: options::Telling,
    #[command(flatten)]
    terms: Terms,
}

/// Options of `verify`.
#[derive(Args, Debug)]
pub struct VerifyOptions {
    /// A case file or the name of a shipped case
    #[arg(value_name = "CASE")]
    case: String,
    /// Images, or CSV files of estimates; several are put together
    #[arg(value_name = "FILE", required = true)]
    pub(super) files: Vec<PathBuf>,
    /// The CSV holds a witness without randomness at several efforts (column samples): judge where it goes as they grow
    #[arg(long)]
    converging: bool,
    #[command(flatten)]
    pub(super) images: super::images::ImageOptions,
    #[command(flatten)]
    pub(super) terms: Terms,
}

/// Options of `points`.
#[derive(Args, Debug)]
pub struct PointsOptions {
    /// A strategy that draws points of the unit square
    #[arg(value_name = "STRATEGY", value_parser = options::strategy)]
    strategy: Strategy,
    /// Points in each set
    #[arg(short, long = "samples", value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 31))]
    n: u64,
    /// Sets, each by itself
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    sets: u64,
    /// Seed of all random streams
    #[arg(long, value_name = "SEED", default_value_t = Settings::DEFAULT_SEED)]
    seed: u64,
}

fn leaning(name: &str) -> Result<Leaning, String> {
    match name {
        "pilot" => Ok(Leaning::Pilot),
        "random" => Ok(Leaning::Random),
        _ => Err("`pilot` or `random`".to_owned()),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..1.0).contains(&share) => Ok(share),
        _ => Err("a number from 0 to below 1".to_owned()),
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= 1e9 => Ok(Duration::from_secs_f64(seconds)),
        _ => Err("seconds, greater than zero".to_owned()),
    }
}

impl Terms {
    /// One case, with the terms in its study.
    fn case(&self, selector: &str) -> Result<Case, u8> {
        let mut cases = select(&[selector.to_owned()], &self.reaching)?;
        if cases.len() > 1 {
            let names: Vec<&str> = cases.iter().map(|case| case.name.as_str()).take(4).collect();
            let more = if cases.len() > names.len() { ", …" } else { "" };
            return Err(fault(
                exit::USAGE,
                format!("`{selector}` names several cases ({}{more}); one is judged at a time", names.join(", ")),
            ));
        }
        let mut case = cases.remove(0);
        case.study.tolerance = self.tolerance.unwrap_or(case.study.tolerance);
        Ok(case)
    }

    fn settings(&self, seed: u64, samples: Option<Vec<u64>>, replicates: Option<Replicates>) -> Settings {
        let overrides = Overrides { strategies: None, samples, replicates, smallest_bias: self.smallest_bias };
        Settings { seed, effort: Effort::Standard, overrides }
    }

    /// The options among them that move a verdict.
    pub(super) fn words(&self) -> String {
        let mut words = String::new();
        if let Some(name) = &self.name {
            words += &format!(" --name {}", quoted(name));
        }
        if self.variance == Leaning::Random {
            words += " --variance random";
        }
        if let Some(tolerance) = self.tolerance {
            words += &format!(" --tolerance {tolerance}");
        }
        words
    }
}

/// A case in a command that repeats its reading.
pub(super) fn case_words(case: &Case) -> String {
    quoted(&case.selector) + case.reach.words()
}

pub fn judge(options: &JudgeOptions) -> u8 {
    judge_to_end(options).unwrap_or_else(|code| code)
}

fn judge_to_end(options: &JudgeOptions) -> Result<u8, u8> {
    let JudgeOptions { terms, program, out, .. } = options;
    let case = terms.case(&options.case)?;
    let settings = terms.settings(options.seed, Some(options.samples.clone()), Some(options.replicates));
    if options.ask {
        let asked = crate::trial::questions(&case, &settings).map_err(|error| fault(exit::NOTHING, error))?;
        let mut text = BufWriter::new(anstream::stdout().lock());
        return match guest::write_questions(&mut text, &asked) {
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(fault(exit::OUTPUT, error)),
            _ => Ok(exit::PASSED),
        };
    }
    let Some(first) = program.first() else {
        return Err(fault(exit::USAGE, "no program is named; it follows after `--`: etendue judge CASE -- PROGRAM…"));
    };
    let stem = Path::new(first).file_stem().map_or(first.clone(), |stem| stem.to_string_lossy().into_owned());
    let name = terms.name.clone().unwrap_or(format!("program:{stem}"));
    let words = program.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ");
    let reproduce =
        format!("etendue judge {}{}{} -- {words}", case_words(&case), settings.options(None), terms.words());
    let _lock = take(out)?;
    report::claim(out).map_err(|error| fault(exit::OUTPUT, error))?;
    let kept = out.join(ESTIMATES);
    let unwritable = |error: std::io::Error| fault(exit::OUTPUT, format!("{}: {error}", kept.display()));
    let mut keep = BufWriter::new(File::create(&kept).map_err(unwritable)?);
    let invitation = Invitation { name: &name, leaning: terms.variance, reproduce: reproduce.clone() };
    let asked = Program { command: program.clone(), timeout: options.timeout };
    let interrupt = Interrupt::heard()?;
    let judged = guest::judge_program(&case, &settings, &invitation, &asked, &mut keep, &|| interrupt.asked());
    let outcome = judged.map_err(|error| {
        // A terminal interrupts the program, too: it may have ended before it was ended.
        let code = if interrupt.asked() { exit::INTERRUPTED } else { code_of(&error) };
        match code {
            exit::INTERRUPTED => say!("interrupted: there is no verdict on {name}, and no report"),
            _ => _ = fault(code, &error),
        }
        let answers = std::fs::read_to_string(&kept).map_or(0, |text| text.lines().count().saturating_sub(1));
        if [exit::USAGE, exit::INTERRUPTED].contains(&code) && answers > 0 {
            say!(
                "{answers} answers, in whole replicates, are kept: etendue verify {} {}",
                case_words(&case),
                quoted(&kept.to_string_lossy())
            );
        }
        code
    })?;
    let outcome = RunOutcome::of_one(settings.seed, reproduce, outcome);
    let how = ReportOptions { generator: GENERATOR, plots: true, views: &[], watched: false };
    interrupt
        .while_writing(out, || report::write(out, &outcome, &how))
        .map_err(|error| fault(exit::OUTPUT, error))?;
    conclude(&outcome, out, &options.telling, None, false, terms.allow_undecided)
}

pub fn verify(options: &VerifyOptions) -> u8 {
    verify_to_end(options).unwrap_or_else(|code| code)
}

fn verify_to_end(options: &VerifyOptions) -> Result<u8, u8> {
    let VerifyOptions { terms, files, .. } = options;
    let case = terms.case(&options.case)?;
    if super::images::are_images(options) {
        return super::images::verify(options, &case);
    }
    let settings = terms.settings(Settings::DEFAULT_SEED, None, None);
    let stem = files[0].file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into_owned());
    let name = terms.name.clone().unwrap_or(format!("file:{stem}"));
    let paths: Vec<String> = files.iter().map(|file| quoted(&file.to_string_lossy())).collect();
    // A file is judged without random numbers of ours.
    let bias = terms.smallest_bias.map_or(String::new(), |b| format!(" --smallest-bias {},{}", b.mean, b.point));
    let reproduce = format!("etendue verify {} {}{bias}{}", case_words(&case), paths.join(" "), terms.words());
    let out = &options.images.out;
    if options.converging {
        return converging(&case, terms, &name, &reproduce, files, out);
    }
    let invitation = Invitation { name: &name, leaning: terms.variance, reproduce: reproduce.clone() };
    let _lock = take(out)?;
    report::claim(out).map_err(|error| fault(exit::OUTPUT, error))?;
    let outcome = guest::judge_estimates(&case, &settings, &invitation, files)
        .map_err(|error| fault(code_of(&error), &error))?;
    let outcome = RunOutcome::of_one(settings.seed, reproduce, outcome);
    report::write(out, &outcome, &ReportOptions { generator: GENERATOR, plots: true, views: &[], watched: false })
        .map_err(|error| fault(exit::OUTPUT, error))?;
    conclude(&outcome, out, &options::Telling::default(), None, false, terms.allow_undecided)
}

fn converging(
    case: &Case,
    terms: &Terms,
    name: &str,
    reproduce: &str,
    files: &[PathBuf],
    out: &Path,
) -> Result<u8, u8> {
    let given = guest::read_estimates(files, case.configuration.points().len())
        .map_err(|error| fault(code_of(&error), &error))?;
    let judged = ConvergenceTerms {
        name,
        reproduce: format!("{reproduce} --converging"),
        tolerance: case.study.tolerance,
        smallest_bias: terms.smallest_bias.unwrap_or(case.study.smallest_bias),
    };
    let outcome = judge_convergence(case, &given, &judged).map_err(|error| {
        let code = if matches!(error, NoConvergence::NoLight { .. }) { exit::NOTHING } else { exit::USAGE };
        fault(code, error)
    })?;
    report::write_convergence(out, &outcome).map_err(|error| fault(exit::OUTPUT, error))?;
    print(&report::convergence_table(&outcome, out))?;
    Ok(match outcome.verdict.verdict {
        Verdict::Fail => exit::FAILED,
        Verdict::Undecided if !terms.allow_undecided => exit::UNDECIDED,
        _ => exit::PASSED,
    })
}

fn code_of(error: &GuestError) -> u8 {
    match error {
        GuestError::Keep { .. } => exit::OUTPUT,
        GuestError::NotJudged(NotJudged::NoDirectLight { .. }) => exit::NOTHING,
        _ => exit::USAGE,
    }
}

pub fn points(options: &PointsOptions) -> u8 {
    let PointsOptions { strategy, n, sets, seed } = options;
    let mut out = BufWriter::new(anstream::stdout().lock());
    match guest::write_sets(&mut out, *strategy, *n, *sets, *seed) {
        Ok(true) => exit::PASSED,
        Ok(false) => fault(
            exit::USAGE,
            format!("`{strategy}` draws directions; points of the unit square are written of {}", area_strategies()),
        ),
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => exit::PASSED,
        Err(error) => fault(exit::OUTPUT, format!("standard output cannot be written: {error}")),
    }
}

fn area_strategies() -> String {
    let by_area = Strategy::ALL.into_iter().filter(|s| s.technique() == crate::sampling::Technique::Area);
    by_area.map(Strategy::name).collect::<Vec<_>>().join(", ")
}

/// The files of `run --points`, or the code after saying what is wrong with them.
pub(super) fn sets(paths: &[PathBuf]) -> Result<Vec<PointSets>, u8> {
    let read: Vec<_> = paths.iter().map(|path| guest::read_sets(path)).collect();
    let faults = read.iter().filter_map(|result| result.as_ref().err());
    let code = faults.fold(None, |_, error| Some(fault(exit::USAGE, error)));
    let mut sets: Vec<PointSets> = Vec::new();
    for found in read.into_iter().flatten() {
        if sets.iter().any(|other| other.name == found.name) {
            return Err(fault(exit::USAGE, format!("two files are called `{}`; rename one", found.name)));
        }
        sets.push(found);
    }
    code.map_or(Ok(sets), Err)
}

/// The options that name files of points.
pub(super) fn words(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| format!(" --points {}", quoted(&path.to_string_lossy()))).collect()
}

/// Judges point sets on each case, and joins what came of it to what the strategies did.
///
/// - `lines`: where the verdicts of each case are told as soon as they are there
/// - `interrupt`: asked before each case
pub(super) fn join(
    outcome: &mut RunOutcome,
    cases: &[Case],
    settings: &Settings,
    sets: &[PointSets],
    paths: &[PathBuf],
    lines: Option<&Lines>,
    interrupt: &Interrupt,
) -> Result<(), u8> {
    for (index, case) in cases.iter().enumerate() {
        if interrupt.asked() {
            outcome.missing = cases[index..].iter().map(|case| case.name.clone()).collect();
            outcome.cases.retain(|found| !outcome.missing.contains(&found.name));
            return Ok(());
        }
        for (set, path) in sets.iter().zip(paths) {
            let alone = Settings {
                overrides: Overrides { strategies: None, ..settings.overrides.clone() },
                ..settings.clone()
            };
            let reproduce =
                alone.command(&[&case.selector], None) + case.reach.words() + &words(std::slice::from_ref(path));
            let invitation = Invitation { name: &set.name, leaning: Leaning::Pilot, reproduce };
            let judged = match guest::judge_point_sets(case, settings, &invitation, set) {
                Ok(judged) => judged,
                Err(error @ NotJudged::NoDirectLight { .. }) => {
                    say!("note: {error}");
                    continue;
                }
                Err(error) => return Err(fault(exit::USAGE, format!("{}: {error}", path.display()))),
            };
            let own = |found: &&mut CaseOutcome| found.name == judged.name;
            match outcome.cases.iter_mut().find(own) {
                Some(found) => found.strategies.extend(judged.strategies),
                None => outcome.cases.push(judged),
            }
        }
        if let Some(lines) = lines {
            lines.done(index, outcome.cases.iter().find(|found| found.name == case.name));
        }
    }
    if outcome.cases.is_empty() {
        return Err(fault(exit::NOTHING, "none of these cases has a point that looks at a source with an area"));
    }
    Ok(())
}
