//! The run that the README shows is the run that this code makes: `reports/reference/` holds its tables and two of its
//! plots, the README its verdicts.
//!
//! After a change that moves numbers on purpose, `UPDATE_REFERENCE=1 cargo test reference` writes both anew.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What `cargo run --release --` is given in the README.
const COMMAND: &str =
    "run penumbra/eclipse penumbra/three-regions direct/turning-patch --quick --out reports/reference";
const FOLDER: &str = "reports/reference";
/// What is kept of the run. `timings.csv` differs from run to run.
const TABLES: [&str; 7] =
    ["convergence.csv", "means.csv", "rates.csv", "curves.csv", "correlation.csv", "scene.csv", "verdicts.csv"];
const MANIFEST: &str = "manifest.json";
const PLOTS: [&str; 2] = ["plots/penumbra-eclipse-profile.svg", "plots/penumbra-eclipse-variance.svg"];
/// Two numbers of a table are the same within this part of the larger: far above the last digits, in which mathematical
/// libraries may differ, far below anything that a reader could see.
const RELATIVE: f64 = 1e-9;
/// The same for a plot, in its own units, of which 8 are a pixel: a coordinate may round the other way.
const PLOT_UNITS: f64 = 1.0;
/// Around the verdicts in the README.
const BEGIN: &str = "<!-- verdicts of the reference run -->\n```text\n";
const END: &str = "```\n<!-- end -->";
const UPDATE: &str = "to write it anew: UPDATE_REFERENCE=1 cargo test reference";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Makes the run in a folder of its own, and returns what it printed.
fn rerun(folder: &Path) -> String {
    let words = COMMAND.split(' ').map(|word| if word == FOLDER { folder.as_os_str() } else { word.as_ref() });
    let output =
        Command::new(env!("CARGO_BIN_EXE_etendue")).args(words).env("COLUMNS", "100").output().expect("it starts");
    assert!(
        output.status.success(),
        "etendue {COMMAND}: {}\n{}{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    let said = String::from_utf8(output.stdout).expect("words are UTF-8");
    said.replace(folder.to_str().expect("a temporary folder has a plain name"), FOLDER)
}

fn read(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}; {UPDATE}", path.display()));
    text.replace("\r\n", "\n")
}

#[test]
fn the_reference_run_is_what_this_code_makes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let said = rerun(folder.path());
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        update(folder.path(), &said);
    }
    let (kept, made) = (root().join(FOLDER), folder.path());
    let mut differences = Vec::new();
    for table in TABLES {
        differences.extend(differing_cells(table, &kept.join(table), &made.join(table)));
    }
    for plot in PLOTS {
        differences.extend(
            differing_marks(&read(&kept.join(plot)), &read(&made.join(plot))).map(|d| format!("{plot}: {d}")),
        );
    }
    if read(&kept.join(MANIFEST)) != read(&made.join(MANIFEST)) {
        differences.push(format!("{MANIFEST}: version, seed, command or a case's digest differs"));
    }
    let readme = read(&root().join("README.md"));
    assert!(readme.contains(COMMAND), "README.md gives the command of the reference run: {COMMAND}");
    if verdicts_in(&readme) != Some(said.as_str()) {
        differences.push(format!("README.md: its verdicts are not those of the run:\n{said}"));
    }
    let shown = differences.len().min(20);
    assert!(
        differences.is_empty(),
        "{FOLDER} is not what this code makes, {} differences; {UPDATE}\n{}",
        differences.len(),
        differences[..shown].join("\n")
    );
}

fn verdicts_in(readme: &str) -> Option<&str> {
    let (_, rest) = readme.split_once(BEGIN)?;
    rest.split_once(END).map(|(verdicts, _)| verdicts)
}

fn update(made: &Path, said: &str) {
    let kept = root().join(FOLDER);
    fs::create_dir_all(kept.join("plots")).expect("the reference folder can be made");
    for file in TABLES.iter().chain(&PLOTS).chain(&[MANIFEST]) {
        fs::copy(made.join(file), kept.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    }
    let path: PathBuf = root().join("README.md");
    let readme = read(&path);
    let old = verdicts_in(&readme).expect("the README has a place for the verdicts");
    let replaced = readme.replacen(&format!("{BEGIN}{old}{END}"), &format!("{BEGIN}{said}{END}"), 1);
    fs::write(&path, replaced).expect("the README can be written");
}

/// Every cell that differs, by its row's first cells and its column's name.
fn differing_cells(name: &str, kept: &Path, made: &Path) -> Vec<String> {
    let records = |path: &Path| -> Vec<csv::StringRecord> {
        let text = read(path);
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
        reader.records().map(|record| record.unwrap_or_else(|error| panic!("{}: {error}", path.display()))).collect()
    };
    let (kept, made) = (records(kept), records(made));
    let mut differences = Vec::new();
    if kept.len() != made.len() || kept.is_empty() {
        differences.push(format!("{name}: {} rows are kept, {} are made", kept.len(), made.len()));
    }
    for (line, (kept_row, made_row)) in kept.iter().zip(&made).enumerate() {
        for (column, (was, is)) in kept_row.iter().zip(made_row).enumerate() {
            if !same_cell(was, is) {
                let head = kept[0].get(column).unwrap_or("?");
                let row = kept_row.iter().take(3).collect::<Vec<_>>().join(" ");
                differences.push(format!("{name}:{} ({row}), {head}: kept {was}, made {is}", line + 1));
            }
        }
    }
    differences
}

/// Text is equal; numbers are equal within [`RELATIVE`].
fn same_cell(was: &str, is: &str) -> bool {
    match (was.parse::<f64>(), is.parse::<f64>()) {
        (Ok(was), Ok(is)) => (was - is).abs() <= RELATIVE * was.abs().max(is.abs()),
        _ => was == is,
    }
}

/// The first place where two drawings differ by more than a rounded coordinate.
fn differing_marks(was: &str, is: &str) -> Option<String> {
    let (was_marks, is_marks) = (marks(was), marks(is));
    if was_marks.len() != is_marks.len() {
        return Some(format!("{} marks are kept, {} are made", was_marks.len(), is_marks.len()));
    }
    let differ = |was: &str, is: &str| match (was.parse::<f64>(), is.parse::<f64>()) {
        (Ok(was), Ok(is)) => (was - is).abs() > PLOT_UNITS,
        _ => was != is,
    };
    was_marks
        .iter()
        .zip(&is_marks)
        .find(|(was, is)| differ(was, is))
        .map(|(was, is)| format!("kept {was}, made {is}"))
}

/// A drawing as numbers and what stands between them, in turn.
fn marks(text: &str) -> Vec<&str> {
    let digit = |c: char| c.is_ascii_digit() || c == '.';
    let mut marks = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_digit = digit(first);
        let end = rest.find(|c| digit(c) != is_digit).unwrap_or(rest.len());
        marks.push(&rest[..end]);
        rest = &rest[end..];
    }
    marks
}

#[test]
fn a_moved_number_is_seen() {
    assert!(same_cell("random", "random") && same_cell("", "") && same_cell("0.1", "0.10000000000001"));
    assert!(same_cell("0", "0.0") && same_cell("1e-30", "1.0000000001e-30"));
    for (was, is) in [("random", "stratified"), ("", "0"), ("0", "1e-30"), ("0.1", "0.100000001"), ("1", "-1")] {
        assert!(!same_cell(was, is), "{was} and {is}");
    }
    let drawing = r#"<line x1="100" y1="7.5"/> N = 64"#;
    assert_eq!(differing_marks(drawing, &drawing.replace("100", "101")), None);
    for (from, to) in [("100", "102"), ("line", "rect"), ("7.5", "9"), ("64", "64 ")] {
        assert!(differing_marks(drawing, &drawing.replacen(from, to, 1)).is_some(), "{from} to {to}");
    }
}
