//! What other programs read: verdicts as JSON, JSON Lines and JUnit, completions, manual pages, the schema; and `new`.

use std::path::Path;
use std::process::Command as Process;

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::{contains, is_empty};
use serde_json::Value;

fn etendue(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_etendue"));
    command.current_dir(folder).env_remove("COLUMNS").env_remove("CLICOLOR_FORCE");
    command
}

/// Standard output of a small run that passes.
fn run(folder: &Path, arguments: &[&str]) -> String {
    let small =
        ["run", "penumbra/eclipse", "--samples", "16", "--replicates", "400", "--no-plots", "--allow-undecided"];
    let output = etendue(folder).args(small).args(arguments).assert().code(0).stderr(is_empty()).get_output().clone();
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn verdicts_are_one_object_or_a_line_each() {
    let folder = tempfile::tempdir().unwrap();
    let whole: Value = serde_json::from_str(&run(folder.path(), &["--format", "json", "--out", "a"])).unwrap();
    let verdicts = whole["verdicts"].as_array().unwrap();
    assert!(!verdicts.is_empty());
    let n = |name: &str| whole["summary"][name].as_u64().unwrap();
    assert_eq!(n("passed") + n("failed") + n("undecided"), verdicts.len() as u64);
    assert_eq!((n("failed"), whole["report"].as_str()), (0, Some("a")));
    // The same as in the table of the report, row by row.
    let mut table = csv::Reader::from_path(folder.path().join("a/verdicts.csv")).unwrap();
    let columns = table.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.unwrap()).collect();
    assert_eq!(rows.len(), verdicts.len());
    for (row, verdict) in rows.iter().zip(verdicts) {
        for (name, field) in columns.iter().zip(row) {
            match &verdict[name] {
                Value::String(text) => assert_eq!(text, field, "{name}"),
                Value::Number(x) => assert_eq!(x.as_f64(), field.parse().ok(), "{name}"),
                other => assert!(other.is_null() && field.is_empty(), "{name}: {other}"),
            }
        }
    }
    let lines = run(folder.path(), &["--format", "jsonl", "--out", "b"]);
    let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (summary, lines) = lines.split_last().unwrap();
    assert_eq!((summary["type"].as_str(), &summary["summary"]), (Some("summary"), &whole["summary"]));
    assert_eq!(lines.len(), verdicts.len());
    for (line, verdict) in lines.iter().zip(verdicts) {
        assert_eq!((line["type"].as_str(), &line["evidence"]), (Some("verdict"), &verdict["evidence"]));
    }
}

#[test]
fn verdicts_are_tests_to_who_reads_junit() {
    let folder = tempfile::tempdir().unwrap();
    // Names are text in XML, too.
    let case = include_str!("../../cases/penumbra/eclipse.toml");
    std::fs::write(folder.path().join("a<b>&c.toml"), case).unwrap();
    let small = ["--samples", "16", "--replicates", "3", "--strategy", "random", "--no-plots", "--junit", "out.xml"];
    etendue(folder.path()).args(["run", "a<b>&c.toml"]).args(small).assert().code(3);
    let text = std::fs::read_to_string(folder.path().join("out.xml")).unwrap();
    assert!(text.contains("a&lt;b") && !text.contains("a<b"), "{text}");
    assert!(
        text.contains("name=\"random bias\"") && text.contains("type=\"undecided\"") && text.contains("<error "),
        "{text}"
    );
    assert!(text.contains("reproduce: etendue run"), "{text}");
    etendue(folder.path()).args(["run", "a<b>&c.toml", "--allow-undecided"]).args(small).assert().code(0);
    let text = std::fs::read_to_string(folder.path().join("out.xml")).unwrap();
    assert!(text.contains("<skipped") && !text.contains("<error"), "{text}");
    etendue(folder.path())
        .args(["run", "a<b>&c.toml"])
        .args(&small[..7])
        .args(["--junit", "no/where.xml"])
        .assert()
        .code(5);
}

#[test]
fn completions_are_words_of_their_shell() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let said = etendue(folder.path()).args(["completions", shell]).assert().code(0).stderr(is_empty());
        let text = String::from_utf8(said.get_output().stdout.clone()).unwrap();
        for word in ["calibrate", "smallest-bias", "compare", "junit"] {
            assert!(text.contains(word), "{shell}: {word}");
        }
        if shell == "bash" {
            let path = folder.path().join("etendue.bash");
            // Loaded as a shell would, then asked for what may follow.
            let ask = "\nCOMP_WORDS=(etendue comp); COMP_CWORD=1; _etendue etendue comp etendue; echo \"${COMPREPLY[@]}\"\n";
            std::fs::write(&path, text + ask).unwrap();
            let output = Process::new("bash").arg(&path).output().expect("bash");
            assert_eq!(String::from_utf8_lossy(&output.stderr), "");
            assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "compare completions");
        }
    }
    etendue(folder.path()).args(["completions", "tcsh"]).assert().code(2).stderr(contains("bash"));
}

#[test]
fn manual_pages_tell_options_and_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    etendue(folder.path())
        .arg("man")
        .assert()
        .code(0)
        .stdout(contains(".TH etendue 1").and(contains("etendue\\-compare")));
    etendue(folder.path())
        .args(["man", "run"])
        .assert()
        .code(0)
        .stdout(contains("smallest\\-bias").and(contains("Exit codes")));
    etendue(folder.path()).args(["man", "fly"]).assert().code(2).stderr(contains("calibrate"));
}

#[test]
fn a_new_case_holds_and_is_never_written_over() {
    let folder = tempfile::tempdir().unwrap();
    etendue(folder.path())
        .args(["new", "rooms/lamp"])
        .assert()
        .code(0)
        .stdout(contains("etendue check rooms/lamp.toml"));
    etendue(folder.path()).args(["check", "rooms/lamp.toml"]).assert().code(0);
    let path = folder.path().join("rooms/lamp.toml");
    // What is commented out holds as well.
    let text = std::fs::read_to_string(&path).unwrap();
    let (about, case) = text.split_once("\ntitle").unwrap();
    assert!(about.lines().all(|line| line.is_empty() || line.starts_with('#')));
    let is_code = |line: &str| {
        let words = line.strip_prefix("# ").unwrap_or_default();
        words.starts_with('[') || words.split_once(" = ").is_some_and(|(key, _)| !key.contains(' '))
    };
    let uncommented: Vec<&str> =
        case.lines().map(|line| if is_code(line) { line.trim_start_matches("# ") } else { line }).collect();
    std::fs::write(&path, format!("title{}", uncommented.join("\n"))).unwrap();
    etendue(folder.path()).args(["check", "rooms/lamp.toml"]).assert().code(0);
    let changed = std::fs::read(&path).unwrap();
    etendue(folder.path()).args(["new", "rooms/lamp.toml"]).assert().code(5).stderr(contains("stays as it is"));
    assert_eq!(std::fs::read(&path).unwrap(), changed);
    etendue(folder.path()).args(["new", "rooms/lamp.toml/x"]).assert().code(5).stderr(contains("cannot write"));
}

#[test]
fn the_schema_is_one_of_json_and_lists_take_filters() {
    let folder = tempfile::tempdir().unwrap();
    let said = etendue(folder.path()).arg("schema").assert().code(0);
    let schema: Value = serde_json::from_slice(&said.get_output().stdout).unwrap();
    let radius = &schema["properties"]["source"]["properties"]["disk"]["anyOf"][0]["properties"]["radius"];
    assert!(radius["description"].as_str().unwrap().contains("Unit: m."), "{radius}");
    etendue(folder.path())
        .args(["list", "eclipse"])
        .assert()
        .code(0)
        .stdout(contains("penumbra/eclipse").and(contains("direct/").not()));
    etendue(folder.path()).args(["list", "no-such-case"]).assert().code(4);
}
