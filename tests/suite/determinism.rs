//! The same case and the same seed give the same bytes, and nothing but what is physical moves a number.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

use etendue::case::{Case, Replicates, shipped};
use etendue::report::{self, ReportOptions};
use etendue::sampling::Strategy;
use etendue::trial::{self, Effort, Overrides, RunOutcome, Settings};

/// A few cases with the different kinds of work: many sources, a grid, a mesh would be slow and is a shape like others.
const NAMES: [&str; 3] = ["penumbra/two-shadows", "direct/disk-receiver", "penumbra/three-regions"];

fn cases() -> Vec<Case> {
    NAMES.map(|name| shipped().find(|case| case.name() == name).expect(name).read().expect(name)).to_vec()
}

/// What differs from run to run: times.
const TIMES: [&str; 2] = ["timings.csv", "timings.html"];

/// Sample counts beside and beyond a block, replicates that do not divide into the batches.
fn settings(seed: u64) -> Settings {
    let overrides = Overrides {
        strategies: Some(Strategy::ALL.to_vec()),
        samples: Some(vec![1, 4, 37, 200]),
        replicates: Some(Replicates::Fixed(77)),
        ..Overrides::default()
    };
    Settings { seed, effort: Effort::Standard, overrides }
}

fn run(cases: &[Case], settings: &Settings, threads: usize) -> RunOutcome {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| trial::run(cases, settings, &|_| {})).expect("a run")
}

/// The run that the others are held against: all cases, seed 3, two threads.
fn whole() -> &'static RunOutcome {
    static WHOLE: LazyLock<RunOutcome> = LazyLock::new(|| run(&cases(), &settings(3), 2));
    &WHOLE
}

/// Every file of the report by its path.
fn files(outcome: &RunOutcome, plots: bool) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().expect("a folder");
    let options = ReportOptions { generator: "a test", plots, views: &[], watched: false };
    report::write(folder.path(), outcome, &options).expect("a report");
    let mut files = BTreeMap::new();
    gather(folder.path(), "", &mut files);
    files
}

fn gather(folder: &Path, below: &str, files: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = format!("{below}{}", path.file_name().expect("a name").to_string_lossy());
        if path.is_dir() {
            gather(&path, &format!("{name}/"), files);
        } else {
            files.insert(name, std::fs::read(&path).expect("a file"));
        }
    }
}

/// Names of files that are not the same in both.
fn differing(a: &RunOutcome, b: &RunOutcome, plots: bool) -> Vec<String> {
    let (a, b) = (files(a, plots), files(b, plots));
    assert!(a.keys().eq(b.keys()), "{:?}\n{:?}", a.keys(), b.keys());
    a.into_iter().filter(|(name, bytes)| b[name] != *bytes).map(|(name, _)| name).collect()
}

/// Rows of `convergence.csv` for one case, without its name.
fn rows(outcome: &RunOutcome, case: &str) -> Vec<String> {
    let files = files(outcome, false);
    let text = String::from_utf8(files["convergence.csv"].clone()).expect("text");
    let start = format!("{case},");
    let rows: Vec<String> = text.lines().filter_map(|row| row.strip_prefix(&start)).map(str::to_owned).collect();
    assert!(!rows.is_empty(), "{case} has rows");
    rows
}

#[test]
fn threads_move_no_byte_but_the_timings() {
    let (cases, settings) = (cases(), settings(3));
    for (threads, plots) in [(1, true), (2, false), (5, false)] {
        let differing = differing(whole(), &run(&cases, &settings, threads), plots);
        assert!(differing.iter().all(|name| TIMES.contains(&name.as_str())), "{threads} threads: {differing:?}");
    }
}

#[test]
fn another_seed_is_another_run() {
    let (a, b) = (whole(), &run(&cases(), &settings(4), 2));
    let differing = differing(a, b, false);
    for file in ["convergence.csv", "rates.csv", "correlation.csv", "verdicts.csv", "manifest.json"] {
        assert!(differing.iter().any(|name| name == file), "{file}");
    }
    for (a, b) in a.cases.iter().zip(&b.cases) {
        assert_eq!(a.truths, b.truths, "exact values know no seed");
    }
}

#[test]
fn neighbours_and_names_move_no_number() {
    let cases = cases();
    let settings = settings(3);
    let all = whole();
    let mut renamed = cases[0].clone();
    renamed.name = "quite/another".to_owned();
    renamed.title = "Under another name".to_owned();
    let alone = run(&[renamed.clone()], &settings, 2);
    let turned = run(&[cases[2].clone(), renamed], &settings, 2);
    let expected = rows(all, NAMES[0]);
    assert_eq!(rows(&alone, "quite/another"), expected);
    assert_eq!(rows(&turned, "quite/another"), expected);
    assert_eq!(rows(&turned, NAMES[2]), rows(all, NAMES[2]));
    let evidence = |outcome: &RunOutcome, case: usize| -> Vec<f64> {
        outcome.cases[case].strategies.iter().flat_map(|s| &s.verdicts).map(|judged| judged.evidence).collect()
    };
    assert_eq!(evidence(&alone, 0), evidence(all, 0));
}

#[test]
fn what_stands_in_the_room_moves_numbers() {
    let settings = settings(3);
    let text = |radius: f64| {
        format!(
            "[[source.disk]]\ncenter = [0, 0, 2]\nnormal = [0, 0, -1]\nradius = {radius}\nexitance = 1\n\
             [[measure.point]]\nposition = [0, 0, 0]\nnormal = [0, 0, 1]"
        )
    };
    let of = |radius| {
        let case = Case::from_toml("room", &text(radius)).expect("a case");
        run(&[case], &settings, 1).cases[0].strategies[0].cells[0].points[0].mean
    };
    // The same squares warped to a disk a hair larger would err by the same amount; another room draws other squares.
    let exact = |radius: f64| radius * radius / (radius * radius + 4.0);
    let (a, b) = (of(0.5) / exact(0.5), of(0.5 + 1e-9) / exact(0.5 + 1e-9));
    assert!((a - b).abs() > 1e-6, "{a} {b}");
}

#[test]
fn a_part_of_a_study_has_the_numbers_of_the_whole() {
    let cases = cases();
    let whole = whole();
    for strategy in Strategy::ALL {
        let mut part = settings(3);
        part.overrides.strategies = Some(vec![strategy]);
        part.overrides.samples = Some(vec![37, 4]);
        let part = run(&cases, &part, 2);
        for (case, all) in part.cases.iter().zip(&whole.cases) {
            assert_eq!(case.strategies.len(), 1);
            let found = &case.strategies[0].cells;
            let every = all.strategies.iter().find(|s| s.strategy == strategy).expect("every strategy");
            assert_eq!(found.iter().map(|cell| cell.samples).collect::<Vec<_>>(), [4, 37]);
            for cell in found {
                let same = every.cells.iter().find(|c| c.samples == cell.samples).expect("every count");
                assert_eq!(cell.points, same.points, "{} {strategy} N = {}", case.name, cell.samples);
                assert_eq!((cell.mean_bias, cell.replicates), (same.mean_bias, same.replicates));
            }
        }
    }
}
