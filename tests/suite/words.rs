//! What the command line says, as it was read and found good: the help of every command, and errors.
//!
//! `UPDATE_WORDS=1 cargo test words` writes the files anew; read them before they are committed.

use std::path::{Path, PathBuf};

use assert_cmd::Command;

fn kept(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/words").join(format!("{name}.txt"))
}

/// Standard output, standard error and the exit code of a command, as a text.
fn said(arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("faulty.toml"), include_str!("../data/words/faulty.toml")).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_etendue"))
        .current_dir(folder.path())
        .env("COLUMNS", "100")
        .env_remove("CLICOLOR_FORCE")
        .args(arguments)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    let (out, errors) = (text(&output.stdout), text(&output.stderr));
    let errors = if errors.is_empty() { errors } else { format!("--- standard error\n{errors}") };
    format!("$ etendue {}\n{out}{errors}--- exit code {}\n", arguments.join(" "), output.status.code().unwrap())
}

fn is_as_kept(name: &str, commands: &[&[&str]]) {
    let said: Vec<String> = commands.iter().map(|arguments| said(arguments)).collect();
    let said = said.join("\n");
    if std::env::var_os("UPDATE_WORDS").is_some() {
        std::fs::write(kept(name), &said).unwrap();
    }
    let kept = std::fs::read_to_string(kept(name)).unwrap_or_default();
    let differ = kept.lines().zip(said.lines()).position(|(kept, said)| kept != said);
    assert!(kept == said, "{name}.txt differs from line {:?} on (UPDATE_WORDS=1 writes it anew):\n{said}", differ);
}

const COMMANDS: [&str; 19] = [
    "run",
    "list",
    "check",
    "exact",
    "calibrate",
    "plan",
    "growth",
    "merge",
    "report",
    "compare",
    "judge",
    "verify",
    "export",
    "points",
    "render",
    "explain",
    "new",
    "schema",
    "completions",
];

#[test]
fn help_is_as_it_was_read() {
    is_as_kept("help", &[&["--help"]]);
    for command in COMMANDS {
        is_as_kept(&format!("help-{command}"), &[&[command, "--help"]]);
    }
}

#[test]
fn every_command_with_an_example_names_itself_in_it() {
    for command in COMMANDS {
        let help = said(&[command, "--help"]);
        if let Some((_, examples)) = help.split_once("Examples:\n") {
            let first = examples.lines().next().unwrap_or_default();
            assert!(first.contains("etendue "), "{command}: {first}");
            assert!(examples.contains(&format!("etendue {command}")), "{command}: {examples}");
        }
    }
}

#[test]
fn errors_are_as_they_were_read() {
    is_as_kept(
        "errors",
        &[
            &["run", "penumbra/eclpse"],
            &["run", "eclipse", "--strategy", "stratifed"],
            &["rnu"],
            &["run", "--sampels", "4"],
            &["run", "eclipse", "--samples", "0"],
            &["run", "eclipse", "--replicates", "1"],
            &["run", "nowhere.toml"],
            &["check", "faulty.toml"],
            &["explain", "varience"],
            &["compare", "a", "b"],
            &["judge", "eclipse"],
        ],
    );
}

#[test]
fn tables_are_as_they_were_read() {
    let small = ["run", "penumbra/eclipse", "--samples", "16", "--replicates", "400", "--no-plots", "--strategy"];
    is_as_kept(
        "tables",
        &[
            &[&small[..], &["random", "--out", "report"]].concat(),
            &[&small[..], &["stratified", "--quiet", "--allow-undecided", "--out", "report"]].concat(),
            &["list", "eclipse"],
            &["exact", "penumbra/eclipse", "--limits"],
            &["check", "penumbra/eclipse"],
        ],
    );
}
