//! The command as a user or a scheduler meets it: exit codes, what goes where, and commands that can be run again.
//!
//! Exit code 1 needs an estimator that is wrong, which this program has no switch for; the judge's own tests hold that
//! a bias fails, and `commands.rs` has one line from there to the code.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command as Process, Stdio};

use assert_cmd::Command;
use etendue::case::shipped;
use etendue::sampling::Strategy;
use predicates::prelude::*;
use predicates::str::{contains, is_empty};

const BINARY: &str = env!("CARGO_BIN_EXE_etendue");

fn etendue() -> Command {
    let mut command = Command::new(BINARY);
    // A folder of its own: what is written by mistake is no part of the source.
    command.current_dir(env!("CARGO_TARGET_TMPDIR")).env_remove("COLUMNS").env_remove("CLICOLOR_FORCE");
    command
}

/// A case that takes no time.
const SMALL: &str = r#"
title = "A disk"
[[source.disk]]
center = [0.0, 0.0, 2.0]
normal = [0.0, 0.0, -1.0]
radius = 0.5
exitance = 1.0
[[measure.point]]
position = [0.1, 0.2, 0.0]
normal = [0.0, 0.0, 1.0]
"#;

/// Three mistakes: a negative radius, a misspelt key, and an exitance that is no number.
const FAULTY: &str = r#"
[[source.disk]]
center = [0.0, 0.0, 2.0]
normal = [0.0, 0.0, -1.0]
radius = -0.5
exitance = "bright"
[[measure.point]]
position = [0.1, 0.2, 0.0]
normal = [0.0, 0.0, 1.0]
[study]
sampels = [1]
"#;

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("a file");
    path.to_str().expect("a plain path").to_owned()
}

fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

#[test]
fn a_run_that_passes_ends_with_zero_and_leaves_its_report() {
    let folder = tempfile::tempdir().unwrap();
    let case = write(folder.path(), "small.toml", SMALL);
    let out = folder.path().join("report");
    let report = format!("report: {}", out.display());
    etendue()
        .args(["run", &case, "--quick", "--out"])
        .arg(&out)
        .assert()
        .code(0)
        .stdout(contains("PASS").count(6).and(contains("6 passed, 0 failed, 0 undecided")).and(contains(report)))
        .stderr(is_empty());
    for file in [
        "convergence.csv",
        "rates.csv",
        "correlation.csv",
        "verdicts.csv",
        "timings.csv",
        "timings.html",
        "manifest.json",
    ] {
        assert!(out.join(file).is_file(), "{file}");
    }
    assert!(out.join("plots/small-variance.svg").is_file());
    let verdicts = rows(&out.join("verdicts.csv"));
    assert_eq!(
        verdicts.iter().map(|row| [&row["strategy"][..], &row["property"]].join(" ")).collect::<Vec<_>>(),
        [
            "random bias",
            "random variance",
            "correlated bias",
            "correlated variance",
            "stratified bias",
            "stratified variance"
        ]
    );
    let manifest: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("manifest.json")).unwrap()).unwrap();
    assert_eq!(manifest["command"], format!("etendue run {case} --quick --seed 1"));
}

#[test]
fn without_a_command_run_is_meant() {
    let folder = tempfile::tempdir().unwrap();
    let case = write(folder.path(), "small.toml", SMALL);
    let run = |words: &[&str], out: &str| {
        let out = folder.path().join(out);
        etendue().args(words).args([&case, "--quick", "--no-plots", "--out"]).arg(&out).assert().code(0);
        std::fs::read(out.join("convergence.csv")).unwrap()
    };
    assert_eq!(run(&[], "a"), run(&["run"], "b"));
}

#[test]
fn a_quiet_run_prints_the_summary_alone() {
    let folder = tempfile::tempdir().unwrap();
    let case = write(folder.path(), "small.toml", SMALL);
    let out = folder.path().join("report");
    let said = format!("6 verdicts: 6 passed, 0 failed, 0 undecided\nreport: {}\n", out.display());
    etendue()
        .args([&case, "--quick", "--quiet", "--no-plots", "--out"])
        .arg(&out)
        .assert()
        .code(0)
        .stdout(said)
        .stderr(is_empty());
}

#[test]
fn too_little_evidence_is_neither_a_pass_nor_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let case = write(folder.path(), "small.toml", SMALL);
    let run = |more: &[&str]| {
        let mut command = etendue();
        command
            .args([&case, "--replicates", "2", "--no-plots", "--out"])
            .arg(folder.path().join("report"))
            .args(more);
        command.assert()
    };
    run(&[]).code(3).stdout(contains("UNDECIDED").and(contains("replicates would do")));
    run(&["--allow-undecided"]).code(0).stdout(contains("0 passed, 0 failed, 6 undecided"));
    run(&["--quiet"])
        .code(3)
        .stdout(contains("0 passed, 0 failed, 6 undecided").and(contains("too little evidence")));
}

#[test]
fn every_mistake_of_every_case_is_told_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    let sound = write(folder.path(), "sound.toml", SMALL);
    let faulty = write(folder.path(), "faulty.toml", FAULTY);
    let broken = write(folder.path(), "broken.toml", "[[source.disk\n");
    let out = folder.path().join("report");
    for (command, more) in [("run", true), ("check", false), ("exact", false)] {
        let mut process = etendue();
        process.args([command, &sound, &faulty, &broken]);
        if more {
            process.arg("--out").arg(&out);
        }
        let told = contains("faulty.toml:5:")
            .and(contains("faulty.toml:6:"))
            .and(contains("faulty.toml:11:"))
            .and(contains("samples"))
            .and(contains("broken.toml:1:"))
            .and(contains("sound.toml").not());
        process.assert().code(2).stdout(is_empty()).stderr(told);
    }
    assert!(!out.exists(), "no report folder for a run that never was");
}

#[test]
fn a_wrong_command_line_is_a_mistake_too() {
    for words in [
        &["run", "--strategy", "guess"][..],
        &["run", "--samples", "0"],
        &["run", "--samples", "1.5"],
        &["run", "--replicates", "1"],
        &["run", "--smallest-bias", "-1"],
        &["run", "--threads", "0"],
        &["run", "--quick", "--thorough"],
        &["run", "--no-such-option"],
        &["check"],
    ] {
        etendue().args(words).assert().code(2).stdout(is_empty()).stderr(is_empty().not());
    }
}

#[test]
fn an_unknown_name_selects_nothing_and_is_told_its_neighbours() {
    for command in ["run", "check", "exact"] {
        etendue()
            .args([command, "penumbra/eclipze"])
            .assert()
            .code(4)
            .stdout(is_empty())
            .stderr(contains("penumbra/eclipze").and(contains("nearest: penumbra/eclipse")));
    }
    let empty = tempfile::tempdir().unwrap();
    etendue().arg("check").arg(empty.path()).assert().code(4).stderr(contains("without a case file"));
}

#[test]
fn an_output_that_cannot_be_is_found_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let taken = write(folder.path(), "taken", "a file");
    let start = std::time::Instant::now();
    etendue()
        .args(["run", "--thorough", "--out", &taken])
        .assert()
        .code(5)
        .stdout(is_empty())
        .stderr(contains("taken"));
    // The thorough run over all cases takes hours.
    assert!(start.elapsed().as_secs() < 60);
    assert_eq!(std::fs::read_to_string(taken).unwrap(), "a file");
}

#[test]
fn list_names_every_case_and_strategy() {
    let said = etendue().arg("list").assert().code(0).stderr(is_empty());
    let text = String::from_utf8(said.get_output().stdout.clone()).unwrap();
    for name in shipped().map(|case| case.name()).chain(Strategy::ALL.map(Strategy::name)).chain(["area"]) {
        assert!(text.lines().any(|line| line.trim_start().starts_with(name)), "{name}");
    }
    let said = etendue().args(["list", "--json"]).assert().code(0).stderr(is_empty());
    let json: serde_json::Value = serde_json::from_slice(&said.get_output().stdout).unwrap();
    let names: Vec<&str> =
        json["cases"].as_array().unwrap().iter().map(|case| case["name"].as_str().unwrap()).collect();
    assert_eq!(names, shipped().map(|case| case.name()).collect::<Vec<_>>());
    assert_eq!(json["strategies"], serde_json::json!(Strategy::ALL.map(Strategy::name)));
    for case in json["cases"].as_array().unwrap() {
        assert!(case["points"].is_u64() && !case["title"].as_str().unwrap().is_empty(), "{case}");
    }
}

#[test]
fn check_counts_what_is_valid() {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    let said = format!("{} cases are valid\n", shipped().count());
    etendue().arg("check").arg(cases).assert().code(0).stdout(said).stderr(is_empty());
    etendue().args(["check", "penumbra/three-regions"]).assert().code(0).stdout("1 case is valid\n");
}

/// The columns of `exact`, in their order: a promise to whoever reads the table by program.
const EXACT_COLUMNS: [&str; 17] = [
    "case",
    "point",
    "x_m",
    "y_m",
    "z_m",
    "nx",
    "ny",
    "nz",
    "region",
    "form_factor",
    "direct_W_m2",
    "caustic_W_m2",
    "indirect_W_m2",
    "irradiance_W_m2",
    "radiosity_W_m2",
    "error_bound",
    "method",
];

#[test]
fn exact_values_are_finite_and_bounded_for_every_case() {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    let said = etendue().arg("exact").arg(cases).assert().code(0).stderr(is_empty());
    let mut reader = csv::Reader::from_reader(&said.get_output().stdout[..]);
    assert_eq!(reader.headers().unwrap().iter().collect::<Vec<_>>(), EXACT_COLUMNS);
    let mut points: BTreeMap<String, usize> = BTreeMap::new();
    for row in reader.deserialize() {
        let row: BTreeMap<String, String> = row.unwrap();
        let number = |column: &str| -> f64 {
            let text = &row[column];
            let number = text.parse().unwrap_or_else(|_| panic!("{column}: {text} of {row:?}"));
            assert!(f64::is_finite(number), "{column}: {row:?}");
            number
        };
        for column in &EXACT_COLUMNS[2..8] {
            number(column);
        }
        let (value, bound) = (number("irradiance_W_m2"), number("error_bound"));
        assert!(value >= 0.0 && (0.0..=1.0).contains(&number("form_factor")), "{row:?}");
        let dark = ["umbra", "below_horizon"].contains(&row["region"].as_str());
        // What is not known is empty; the parts of what goes through glass to and fro are not told apart.
        let known = |column: &str| (!row[column].is_empty()).then(|| number(column));
        let direct = known("direct_W_m2");
        assert!(if dark { direct == Some(0.0) } else { bound > 0.0 }, "{row:?}");
        assert!(bound >= 0.0 && bound <= 1e-9 * value.max(1e-3), "{row:?}");
        if let Some(direct) = direct {
            let others = ["caustic_W_m2", "indirect_W_m2"].map(|column| known(column).unwrap_or(0.0));
            assert_eq!(direct + others[0] + others[1], value, "{row:?}");
        }
        assert!(["closed-form", "quadrature"].contains(&row["method"].as_str()), "{row:?}");
        if !row["radiosity_W_m2"].is_empty() {
            assert!(number("radiosity_W_m2") <= value, "{row:?}");
        }
        let at = points.entry(row["case"].clone()).or_default();
        assert_eq!(row["point"], at.to_string(), "points are counted from 0, in order");
        *at += 1;
    }
    for case in shipped() {
        let expected = case.read().unwrap().configuration.points().len();
        assert_eq!(points.remove(case.name()).unwrap_or(0), expected, "{}", case.name());
    }
    assert!(points.is_empty(), "{points:?}");
}

/// The eclipse's own comment in its case file: umbra to 0.2 m, penumbra to 1.2 m.
#[test]
fn limits_tell_where_umbra_and_penumbra_end() {
    let said = etendue().args(["exact", "--limits", "penumbra/eclipse"]).assert().code(0).stderr(is_empty());
    let mut reader = csv::Reader::from_reader(&said.get_output().stdout[..]);
    let columns = "case,limit,distance_m,x_m,y_m,z_m,region_before,region_after,bound_m,method";
    assert_eq!(reader.headers().unwrap().iter().collect::<Vec<_>>().join(","), columns);
    let rows: Vec<BTreeMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    let expected = [("umbra_ends", 0.2, "umbra", "penumbra"), ("penumbra_ends", 1.2, "penumbra", "lit")];
    assert_eq!(rows.len(), expected.len(), "{rows:?}");
    for (row, (limit, distance, before, after)) in rows.iter().zip(expected) {
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        assert_eq!((&*row["limit"], &*row["region_before"], &*row["region_after"]), (limit, before, after));
        assert!((number("distance_m") - distance).abs() <= number("bound_m") && number("bound_m") < 1e-13, "{row:?}");
        assert_eq!(number("x_m"), number("distance_m"));
        assert_eq!(row["method"], "closed-form");
    }
}

/// Every shipped case that has a line: limits in order along it, each within the line, regions that follow one another.
#[test]
fn limits_of_all_cases_follow_one_another() {
    let said = etendue().args(["exact", "--limits"]).assert().code(0).stderr(contains("measure.line"));
    let mut reader = csv::Reader::from_reader(&said.get_output().stdout[..]);
    let rows: Vec<BTreeMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    assert!(rows.len() > 20, "{} rows", rows.len());
    for pair in rows.windows(2).filter(|pair| pair[0]["case"] == pair[1]["case"]) {
        let distance = |row: &BTreeMap<String, String>| row["distance_m"].parse::<f64>().unwrap();
        assert!(distance(&pair[0]) < distance(&pair[1]), "{pair:?}");
        assert_eq!(pair[0]["region_after"], pair[1]["region_before"], "{pair:?}");
    }
    for row in &rows {
        assert!(row["bound_m"].parse::<f64>().unwrap() < 1e-6, "{row:?}");
    }
}

#[test]
fn limits_need_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let small = write(folder.path(), "small.toml", SMALL);
    let needs = contains("measure.line");
    etendue().args(["exact", "--limits", &small]).assert().code(2).stdout(is_empty()).stderr(needs.clone());
    let said = etendue().args(["exact", "--limits", &small, "penumbra/eclipse"]).assert().code(0).stderr(needs);
    let text = String::from_utf8(said.get_output().stdout.clone()).unwrap();
    assert_eq!(text.lines().filter(|line| line.starts_with("penumbra/eclipse,")).count(), 2, "{text}");
}

/// A disk half behind another, as seen from the point.
fn eclipsed(occluder_x: f64, radius: f64) -> String {
    let rest = SMALL.replace("radius = 0.5", &format!("radius = {radius:?}"));
    format!("{rest}[[occluder.disk]]\ncenter = [{occluder_x:?}, 0.0, 1.0]\nnormal = [0.0, 0.0, 1.0]\nradius = 0.35\n")
}

#[test]
fn derivatives_stand_beside_the_values() {
    let folder = tempfile::tempdir().unwrap();
    let exact = |name: &str, text: &str, more: &[&str]| -> (Vec<String>, BTreeMap<String, String>) {
        let case = write(folder.path(), name, text);
        let said = etendue().args(["exact", &case]).args(more).assert().code(0).stderr(is_empty());
        let mut reader = csv::Reader::from_reader(&said.get_output().stdout[..]);
        let header = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let mut rows: Vec<BTreeMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 1);
        (header, rows.remove(0))
    };
    let number = |row: &BTreeMap<String, String>, column: &str| -> f64 {
        let number = row[column].parse().unwrap_or_else(|_| panic!("{column} of {row:?}"));
        assert!(f64::is_finite(number), "{column} of {row:?}");
        number
    };
    let asked = "occluder.0.center.x,source.0.radius,source.0.exitance,point.position.z,point.normal.y";
    let (header, row) = exact("eclipsed.toml", &eclipsed(0.4, 0.5), &["--derivative", asked]);
    let more = [
        "d_occluder.0.center.x_W_m3",
        "d_source.0.radius_W_m3",
        "d_source.0.exitance_1",
        "d_point.position.z_W_m3",
        "d_point.normal.y_W_m2",
        "derivative_side",
    ];
    assert_eq!(header, [&EXACT_COLUMNS[..], &more].concat());
    assert_eq!((&*row["region"], &*row["derivative_side"]), ("penumbra", "both"));
    for column in &more[..5] {
        assert_ne!(number(&row, column), 0.0, "{column}");
    }
    // The value is linear in the exitance, which is 1 here.
    assert!((number(&row, more[2]) / number(&row, "irradiance_W_m2") - 1.0).abs() < 1e-13);
    // Central differences of the same program on edited cases, extrapolated: what is left falls with the step's fourth
    // power.
    let value = |x: f64, radius: f64| number(&exact("moved.toml", &eclipsed(x, radius), &[]).1, "irradiance_W_m2");
    let extrapolated = |value: &dyn Fn(f64) -> f64| {
        let central = |h: f64| (value(h) - value(-h)) / (2.0 * h);
        (4.0 * central(5e-4) - central(1e-3)) / 3.0
    };
    let moved = [extrapolated(&|h| value(0.4 + h, 0.5)), extrapolated(&|h| value(0.4, 0.5 + h))];
    for (column, difference) in more.iter().zip(moved) {
        let derivative = number(&row, column);
        assert!((derivative - difference).abs() < 1e-9 * derivative.abs(), "{column}: {derivative} or {difference}");
    }
    // One case with derivatives has the same values as without.
    let (plain_header, plain) = exact("eclipsed.toml", &eclipsed(0.4, 0.5), &[]);
    assert!(plain_header.iter().all(|column| row[column] == plain[column]), "{row:?}\n{plain:?}");
}

#[test]
fn a_wrong_parameter_is_told_what_is_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let case = write(folder.path(), "eclipsed.toml", &eclipsed(0.4, 0.5));
    for (wrong, accepted) in [
        ("source.0.colour", "source.N.FIELD, occluder.N.FIELD and point.FIELD"),
        ("point.exitance", "source.N.FIELD, occluder.N.FIELD and point.FIELD"),
        ("occluder.1.radius", "there are 1 occluders, counted from 0"),
        ("occluder.0.edge_u.x", "a disk has center"),
    ] {
        let told = contains(wrong).and(contains(accepted));
        let said = etendue().args(["exact", &case, "--derivative", wrong]).assert().code(2).stdout(is_empty());
        said.stderr(told);
    }
    etendue().args(["exact", &case, "--limits", "--derivative", "source.0.radius"]).assert().code(2);
}

#[test]
fn a_reader_that_has_seen_enough_is_no_fault() {
    for words in [&["exact"][..], &["list"]] {
        let mut child = Process::new(BINARY)
            .args(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program");
        // Closed unread: the first write meets a broken pipe.
        drop(child.stdout.take());
        let ended = child.wait_with_output().expect("an end");
        assert_eq!(ended.status.code(), Some(0), "{}", String::from_utf8_lossy(&ended.stderr));
        assert!(ended.stderr.is_empty(), "{}", String::from_utf8_lossy(&ended.stderr));
    }
}

#[test]
fn the_command_beside_a_verdict_gives_that_verdict_again() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("it's mine");
    std::fs::create_dir_all(own.join("deep")).unwrap();
    write(&own.join("deep"), "small.toml", SMALL);
    let first = folder.path().join("first");
    etendue()
        .args(["run", "penumbra/three-regions"])
        .arg(&own)
        .args(["--samples", "1,5,16", "--replicates", "300", "--smallest-bias", "0.5,2", "--seed", "9", "--no-plots"])
        .args(["--allow-undecided", "--out"])
        .arg(&first)
        .assert()
        .code(0);
    let verdicts = rows(&first.join("verdicts.csv"));
    // Bias and variance of two cases under three strategies, and the covariance of the one with several points.
    assert_eq!(verdicts.len(), 15);
    let again = folder.path().join("again");
    for verdict in &verdicts {
        let command = verdict["reproduce"].strip_prefix("etendue ").expect("our command");
        // Through a shell, as a reader would paste it.
        let ended = Process::new("sh")
            .arg("-c")
            .arg(format!("exec \"$ETENDUE\" {command} --allow-undecided --no-plots --out \"$AGAIN\""))
            .env("ETENDUE", BINARY)
            .env("AGAIN", &again)
            .current_dir(env!("CARGO_TARGET_TMPDIR"))
            .output()
            .expect("a shell");
        assert_eq!(ended.status.code(), Some(0), "{command}: {}", String::from_utf8_lossy(&ended.stderr));
        let found = rows(&again.join("verdicts.csv"));
        let mut same = found.iter().filter(|row| row["property"] == verdict["property"]);
        let (Some(again), None) = (same.next(), same.next()) else { panic!("{command}: {found:?}") };
        for column in ["strategy", "property", "verdict", "evidence", "effect", "effect_low", "effect_high"] {
            assert_eq!(again[column], verdict[column], "{column} of {command}");
        }
    }
}

#[test]
fn threads_move_no_byte_but_the_timings() {
    let folder = tempfile::tempdir().unwrap();
    let run = |threads: &str| {
        let out = folder.path().join(threads);
        etendue()
            .args(["run", "penumbra/three-regions", "direct/turning-patch", "--quick", "--threads", threads, "--out"])
            .arg(&out)
            .assert()
            .code(0);
        out
    };
    let (one, two) = (run("1"), run("2"));
    for file in ["convergence.csv", "rates.csv", "correlation.csv", "verdicts.csv", "manifest.json"] {
        assert_eq!(std::fs::read(one.join(file)).unwrap(), std::fs::read(two.join(file)).unwrap(), "{file}");
    }
}

#[test]
fn a_calibration_leaves_its_tables_and_says_whether_any_figure_misses() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("gate");
    let output = etendue()
        .args(["calibrate", "--quick", "--runs", "42", "--seed", "3", "--out"])
        .arg(&out)
        .output()
        .expect("it starts");
    let tables = ["false_alarms.csv", "coverage.csv", "power.csv"].map(|name| rows(&out.join(name)));
    assert!(tables.iter().all(|table| table.len() >= 7));
    let missed = tables.iter().flatten().any(|row| row["verdict"] == "fail");
    assert_eq!(output.status.code(), Some(i32::from(missed)), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).expect("words");
    assert!(said.contains("False alarms") && said.contains("Coverage") && said.contains("Power"), "{said}");
}

#[test]
fn the_growth_of_cost_is_measured_fitted_and_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("growth");
    std::fs::create_dir_all(out.join("plots")).expect("a folder");
    std::fs::write(out.join("plots/growth-samples.svg"), "of an earlier run").expect("a file");
    etendue()
        .args(["growth", "--quick", "--out"])
        .arg(&out)
        .assert()
        .code(0)
        .stdout(contains("exponent").and(contains("mesh-rays").and(contains("light-rays"))));
    let rows = rows(&out.join("growth.csv"));
    let of = |study: &str| {
        let own = rows.iter().filter(|row| row["study"] == study);
        own.map(|row| [&row["x"], &row["seconds"]].map(|cell| cell.parse::<f64>().expect("a number")))
            .collect::<Vec<_>>()
    };
    for study in ["samples", "occluders", "mesh-build", "mesh-rays", "points", "light-rays"] {
        let seen = of(study);
        assert!(seen.len() >= 3 && seen.iter().all(|[x, seconds]| *x >= 1.0 && *seconds > 0.0), "{study}: {seen:?}");
        for format in ["svg", "png"] {
            let plot = std::fs::read(out.join(format!("plots/growth-{study}.{format}"))).expect("a plot");
            assert!(plot.len() > 2000, "{study}.{format}");
        }
    }
    // Whatever else runs here: thousands of samples take longer than a few.
    let samples = of("samples");
    assert!(samples[samples.len() - 1][1] > samples[0][1], "{samples:?}");
    let page = std::fs::read_to_string(out.join("growth.html")).expect("a page");
    assert!(page.starts_with("<!DOCTYPE html>") && page.matches("<svg").count() == 6);
}

#[test]
fn a_case_names_files_outside_of_its_folder_only_where_that_is_said() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("room")).unwrap();
    write(folder.path(), "sail.obj", "v 5 0 1\nv 6 0 1\nv 5 1 1\nf 1 2 3\n");
    let case = write(folder.path(), "room/a.toml", &format!("{SMALL}[[occluder.mesh]]\nfile = \"../sail.obj\"\n"));
    let out = folder.path().join("report");
    let out = out.to_str().unwrap();
    let (scene, other) = (folder.path().join("scene"), folder.path().join("other"));
    let estimates = write(folder.path(), "e.csv", "0,0,1,1\n");
    let (scene, other) = (scene.to_str().unwrap(), other.to_str().unwrap());
    // Every command that reads cases, and its exit code where the mesh may be read.
    let commands: [(&[&str], i32); 9] = [
        (&["check"], 0),
        (&["list"], 0),
        (&["exact"], 0),
        (&["plan", "--quick"], 0),
        (&["run", "--quick", "--no-plots", "--out", out], 0),
        (&["judge", "--ask", "--replicates", "2"], 0),
        (&["verify", "--out", other], 2),
        (&["export", "--for", "json", "-o", scene], 0),
        #[cfg(feature = "plots")]
        (&["render", "-o", other], 2),
    ];
    for (words, code) in commands {
        let command = || {
            let mut command = etendue();
            command.arg(words[0]).arg(&case).args(&words[1..]);
            if words[0] == "verify" {
                command.arg(&estimates);
            }
            command
        };
        command().assert().code(2).stderr(contains("`../sail.obj` leaves the folder of the cases"));
        let allowed = command().arg("--allow-outside").assert().code(code);
        allowed.stderr(contains("leaves the folder").not());
    }
    let verdicts = rows(&Path::new(out).join("verdicts.csv"));
    assert!(verdicts.iter().all(|row| row["reproduce"].ends_with(" --allow-outside")), "{verdicts:?}");
    let manifest = std::fs::read_to_string(Path::new(out).join("manifest.json")).unwrap();
    assert!(manifest.contains("--allow-outside\""), "{manifest}");
    // The folder that holds both is given: nothing is outside.
    etendue().args(["check", folder.path().to_str().unwrap()]).assert().code(0);
}
