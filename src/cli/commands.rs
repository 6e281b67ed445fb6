//! What each command does.

use std::io::Write;
use std::path::Path;

use clap::CommandFactory;

use super::cluster::{self, Engine};
use super::exit;
use super::explain;
use super::options::{Calibrate, Check, Exact, Explain, Growth, List, Options, Plan, Reaching, Report};
use super::progress::RunBoard;
use super::share;
use crate::calibration;
use crate::case::Replicates;
use crate::case::{self, Case, Ink, SelectError};
use crate::journal::FolderLock;
use crate::oracle::optics::{Arriving, RoomLight};
use crate::oracle::{self, Derivatives, Oracle, Truth};
use crate::report::{self, ExactCase, LimitsCase};
use crate::sampling::Strategy;
use crate::trial::{self, Settings};

/// Says how the random streams are made, for the manifest.
pub(super) const GENERATOR: &str = "8 lanes of xoshiro256++, sample i in lane i mod 8; streams keyed by seed, configuration, purpose, \
                         strategy, samples, replicate, point (0 where points are shared) and source";

/// Cases, or the exit code after saying what is wrong with them.
pub(super) fn select(selectors: &[String], reaching: &Reaching) -> Result<Vec<Case>, u8> {
    case::select_reaching(selectors, reaching.reach()).map_err(|error| {
        let ink = if coloured() { Ink::Coloured } else { Ink::Plain };
        match &error {
            SelectError::Nothing { unmatched } => {
                for one in unmatched {
                    fault(exit::NOTHING, one);
                    if let Some(command) = command_meant(&one.selector) {
                        say!("  tip: `{command}` is a command: etendue {command} --help");
                    }
                }
                exit::NOTHING
            }
            SelectError::Faulty { .. } => {
                say!("{}", error.render(ink));
                exit::USAGE
            }
            SelectError::SameName { .. } => fault(exit::USAGE, &error),
        }
    })
}

/// The command that somebody may have meant who named no case: where no command is said, cases are.
fn command_meant(said: &str) -> Option<String> {
    let known = Options::command();
    case::nearest(said, known.get_subcommands().map(clap::Command::get_name)).map(str::to_owned)
}

pub(super) fn coloured() -> bool {
    anstream::AutoStream::choice(&std::io::stderr()) != anstream::ColorChoice::Never
}

/// An error on stderr, and the code to leave with.
pub(super) fn fault(code: u8, error: impl std::fmt::Display) -> u8 {
    say!("error: {error}");
    code
}

/// A folder for what is to be written, which nobody else writes to meanwhile.
pub(super) fn take(folder: &Path) -> Result<FolderLock, u8> {
    report::probe(folder).map_err(|error| fault(exit::OUTPUT, error))?;
    FolderLock::take(folder).map_err(share::journal)
}

pub(super) fn set_threads(threads: Option<u16>) -> Result<(), u8> {
    let Some(threads) = threads else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads));
    pool.build_global().map_err(|error| fault(exit::AGAIN, error))
}

/// Shadow rays of one case beyond which it is not begun: half a day of one core.
const MOST_RAYS: f64 = (1_u64 << 43) as f64;

/// What would go on for days is refused before it begins, and not found out about.
///
/// - `shards`: that the work is divided among
pub(super) fn endless(cases: &[Case], settings: &Settings, shards: u32) -> Result<(), u8> {
    for case in cases {
        let rays = trial::least_rays(case, settings) / f64::from(shards);
        if rays > MOST_RAYS {
            let points = case.configuration.points().len();
            let (study, name) = (settings.study(&case.study), &case.name);
            let replicates = match study.replicates {
                Replicates::Fixed(n) => n.to_string(),
                Replicates::Auto => "128 or more".to_owned(),
            };
            let samples: Vec<String> = study.samples.iter().map(u64::to_string).collect();
            return Err(fault(
                exit::USAGE,
                format!(
                    "{name} takes {rays:.1e} shadow rays at least ({points} points, {} strategies, samples {}, replicates \
                     {replicates}); at most {MOST_RAYS:.1e}, half a day of one core, are accepted for a case: fewer of \
                     --samples, --replicates, --strategy, or points; or more shards (--shard I/N)",
                    study.strategies.len(),
                    samples.join(","),
                ),
            ));
        }
    }
    Ok(())
}

pub fn plan(options: &Plan) -> u8 {
    plan_to_end(options).unwrap_or_else(|code| code)
}

fn plan_to_end(options: &Plan) -> Result<u8, u8> {
    let cases = select(&options.work.cases, &options.work.reaching)?;
    set_threads(options.work.threads)?;
    let settings = options.work.settings();
    endless(&cases, &settings, options.shards.unwrap_or(1))?;
    let bill = options.shards.map(|_| trial::Bill::new(&cases, &settings));
    if let (Some(bill), Some(of), Some(out), Some(Engine::Slurm)) =
        (&bill, options.shards, &options.out, options.engine)
    {
        return cluster::write(options, bill, of, out);
    }
    let shards = bill.as_ref().zip(options.shards).map(|(bill, of)| bill.shards(of));
    let forecasts = bill.map_or_else(|| trial::forecast(&cases, &settings), |bill| bill.forecasts);
    if options.json {
        print(&report::forecast_json(&forecasts, shards.as_deref()))?;
    } else {
        print(&report::forecast_table(&forecasts, shards.as_deref(), rayon::current_num_threads()))?;
    }
    let all = forecasts.iter().all(|plan| plan.suffices);
    Ok(if all || options.work.replicates.is_none() { exit::PASSED } else { exit::UNDECIDED })
}

pub fn report(options: &Report) -> u8 {
    report_to_end(options).unwrap_or_else(|code| code)
}

fn report_to_end(options: &Report) -> Result<u8, u8> {
    let _lock = options.dir.is_dir().then(|| take(&options.dir)).transpose()?;
    let rebuilt = report::rebuild(&options.dir, !options.no_plots).map_err(|error| fault(exit::OUTPUT, error))?;
    for fault in &rebuilt.faults {
        say!("warning: {fault}");
    }
    print(&format!("{}\n", options.dir.join("index.html").display()))?;
    Ok(if rebuilt.faults.is_empty() { exit::PASSED } else { exit::OUTPUT })
}

pub fn growth(options: &Growth) -> u8 {
    growth_to_end(options).map_or_else(|code| code, |()| exit::PASSED)
}

fn growth_to_end(options: &Growth) -> Result<(), u8> {
    let _lock = take(&options.out)?;
    report::claim_growth(&options.out).map_err(|error| fault(exit::OUTPUT, error))?;
    let told = |study: &str| say!("timing {study}");
    let studies = trial::growth(options.effort(), &told).map_err(|error| fault(exit::BUG, error))?;
    report::write_growth(&options.out, &studies).map_err(|error| fault(exit::OUTPUT, error))?;
    print(&report::growth_table(&studies, &options.out))
}

pub fn explain(options: &Explain) -> u8 {
    explain_to_end(options).map_or_else(|code| code, |()| exit::PASSED)
}

fn explain_to_end(options: &Explain) -> Result<(), u8> {
    let Some(name) = &options.name else { return print(&explain::contents()) };
    match explain::text(name) {
        Some(text) => print(&text),
        None => Err(fault(exit::USAGE, explain::unknown(name))),
    }
}

pub fn list(options: &List) -> u8 {
    list_to_end(options).map_or_else(|code| code, |()| exit::PASSED)
}

fn list_to_end(options: &List) -> Result<(), u8> {
    let cases = select(&options.cases, &options.reaching)?;
    if options.json {
        let cases: Vec<_> = cases
            .iter()
            .map(|case| {
                serde_json::json!({
                    "name": case.name,
                    "title": case.title,
                    "points": case.configuration.points().len(),
                    "digest": case.configuration.digest().to_string(),
                })
            })
            .collect();
        let strategies = Strategy::ALL.map(Strategy::name);
        let all = serde_json::json!({
            "schema_version": 1,
            "cases": cases,
            "strategies": strategies,
            "estimators": ["area"],
        });
        return print(&format!("{all:#}\n"));
    }
    let widest = cases.iter().map(|case| case.name.len()).max().unwrap_or(0);
    let mut text = String::from("Cases\n");
    for case in &cases {
        text += &format!("  {:widest$}  {}\n", case.name, case.title);
    }
    text += "\nStrategies\n";
    for strategy in Strategy::ALL {
        text += &format!("  {:widest$}  {}\n", strategy.name(), strategy.meaning());
    }
    text +=
        &format!("\nEstimators\n  {:widest$}  points uniform by area, a shadow ray to each, the average\n", "area");
    print(&text)
}

pub fn check(options: &Check) -> u8 {
    match select(&options.cases, &options.reaching) {
        Ok(cases) => {
            let plural = if cases.len() == 1 { "case is" } else { "cases are" };
            print(&format!("{} {plural} valid\n", cases.len())).map_or_else(|code| code, |()| exit::PASSED)
        }
        Err(code) => code,
    }
}

pub fn exact(options: &Exact) -> u8 {
    exact_to_end(options).map_or_else(|code| code, |()| exit::PASSED)
}

fn exact_to_end(options: &Exact) -> Result<(), u8> {
    let cases = select(&options.cases, &options.reaching)?;
    if options.limits {
        return limits(&cases);
    }
    let mut truths: Vec<Vec<Truth>> = Vec::new();
    let mut derivatives: Vec<Vec<Derivatives>> = Vec::new();
    for case in &cases {
        let oracle = Oracle::new(&case.configuration);
        let points = case.configuration.points();
        if options.derivative.is_empty() {
            truths.push(points.iter().map(|point| oracle.at(point)).collect());
            continue;
        }
        let parameters = oracle
            .parameters(&case.configuration, &options.derivative)
            .map_err(|error| fault(exit::USAGE, format!("{}: {error}", case.name)))?;
        let found: Vec<Derivatives> = points.iter().map(|point| oracle.derivatives(point, &parameters)).collect();
        truths.push(found.iter().map(|found| found.truth).collect());
        derivatives.push(found);
    }
    let albedos: Vec<_> = cases.iter().map(|case| case.configuration.albedos()).collect();
    let arriving: Vec<Vec<Arriving>> = cases
        .iter()
        .map(|case| {
            let light = RoomLight::new(&case.configuration);
            case.configuration.points().iter().map(|point| light.at(point)).collect()
        })
        .collect();
    let rows = cases.iter().zip(&truths).enumerate().map(|(i, (case, truths))| ExactCase {
        name: &case.name,
        albedos: albedos[i].as_deref(),
        points: case.configuration.points(),
        truths,
        arriving: &arriving[i],
        derivatives: derivatives.get(i).map_or(&[], Vec::as_slice),
    });
    let mut text = Vec::new();
    report::write_exact(&mut text, rows, &options.derivative).map_err(|error| fault(exit::OUTPUT, error))?;
    write_out(&text)
}

/// Cases without a line are told of on stderr; if none is left, that is an error.
fn limits(cases: &[Case]) -> Result<(), u8> {
    let mut found = Vec::new();
    for case in cases {
        match oracle::limits::limits(&case.configuration) {
            Ok(limits) => found.push((case, limits)),
            Err(none) if cases.len() == 1 => return Err(fault(exit::USAGE, format!("{}: {none}", case.name))),
            Err(none) => say!("note: {}: {none}", case.name),
        }
    }
    if found.is_empty() {
        return Err(fault(exit::USAGE, "none of these cases has a measured line"));
    }
    let rows = found.iter().map(|(case, limits)| LimitsCase { name: &case.name, limits });
    let mut text = Vec::new();
    report::write_limits(&mut text, rows).map_err(|error| fault(exit::OUTPUT, error))?;
    write_out(&text)
}

pub fn calibrate(options: &Calibrate) -> u8 {
    calibrate_to_end(options).unwrap_or_else(|code| code)
}

fn calibrate_to_end(options: &Calibrate) -> Result<u8, u8> {
    let _lock = take(&options.out)?;
    report::claim_calibration(&options.out).map_err(|error| fault(exit::OUTPUT, error))?;
    set_threads(options.threads)?;
    let bar = RunBoard::new();
    let calibration = calibration::calibrate(&options.options(), &|progress| bar.show(progress))
        .map_err(|error| fault(exit::BUG, error))?;
    bar.finish();
    report::write_calibration(&options.out, &calibration).map_err(|error| fault(exit::OUTPUT, error))?;
    print(&report::calibration_table(&calibration))?;
    Ok(if calibration.fails() { exit::FAILED } else { exit::PASSED })
}

pub(super) fn print(text: &str) -> Result<(), u8> {
    write_out(text.as_bytes())
}

/// A reader that has seen enough (`| head`) is no fault.
fn write_out(bytes: &[u8]) -> Result<(), u8> {
    let mut out = anstream::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(fault(exit::OUTPUT, format!("standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}
