//! The papers say what is so: their case file is valid, their counts are right. (Links, and the pages of `docs/`: `docs.rs`.)

use std::fs;
use std::path::Path;

use etendue::case::{Case, shipped};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn paper(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The fenced blocks of one language.
fn blocks<'a>(text: &'a str, language: &'a str) -> impl Iterator<Item = &'a str> {
    let fence = format!("```{language}\n");
    text.match_indices(&fence)
        .map(|(at, fence)| &text[at + fence.len()..])
        .map(|rest| rest.split_once("```").map_or(rest, |(block, _)| block))
        .collect::<Vec<_>>()
        .into_iter()
}

#[test]
fn the_case_in_the_readme_is_valid() {
    let readme = paper("README.md");
    let text = blocks(&readme, "toml").find(|block| block.contains("[measure]")).expect("the README shows a case");
    let case = Case::from_toml("my-room", text).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(case.configuration.points().len(), 33);
}

#[test]
fn shipped_cases_are_counted_right() {
    let count = shipped().count();
    assert!(paper("README.md").contains(&format!("({count} rooms")), "there are {count} shipped cases");
    assert!(paper("CHANGELOG.md").contains(&format!("{count} shipped cases")), "there are {count} shipped cases");
}

#[test]
fn the_readme_gives_the_two_commands() {
    let readme = paper("README.md");
    let (_, rest) = readme.split_once("<!-- the two commands").expect("the mark that .ci/run looks for");
    assert_eq!(blocks(rest, "sh").next(), Some("cargo run --release\ncargo test\n"));
}

/// A command of the README, in a folder of its own, with our binary and the examples where it looks for them.
#[cfg(unix)]
fn tried(command: &str, input: &str) -> (Option<i32>, String, tempfile::TempDir) {
    use std::io::Write;
    use std::process::{Command, Stdio};
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(root().join("examples"), folder.path().join("examples")).unwrap();
    let binary = Path::new(env!("CARGO_BIN_EXE_etendue")).parent().unwrap();
    let path = format!("{}:{}", binary.display(), std::env::var("PATH").unwrap_or_default());
    let mut child = Command::new("bash")
        .args(["-c", command])
        .current_dir(folder.path())
        .env("PATH", path)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("bash");
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    (output.status.code(), String::from_utf8(output.stdout).unwrap(), folder)
}

#[cfg(unix)]
fn has_python() -> bool {
    std::process::Command::new("python3").arg("--version").output().is_ok()
}

#[cfg(unix)]
#[test]
fn the_python_of_the_readme_reads_verdicts() {
    if !has_python() {
        return;
    }
    let readme = paper("README.md");
    let snippet = blocks(&readme, "python").find(|block| block.contains("--format")).expect("it reads JSON");
    let (code, told, _) = tried("python3 -", snippet);
    assert_eq!(code, Some(0));
    assert_eq!(told.lines().filter(|line| line.starts_with("stratified ")).count(), 3, "{told}");
    assert!(told.lines().all(|line| line.contains(" pass ") && line.ends_with(" %")), "{told}");
}

#[cfg(unix)]
#[test]
fn the_workflow_of_the_readme_runs_as_written() {
    if !has_python() {
        return;
    }
    let readme = paper("README.md");
    let workflow = blocks(&readme, "yaml").next().expect("there is a workflow");
    let steps: Vec<&str> = workflow.lines().filter_map(|line| line.trim().strip_prefix("- run: ")).collect();
    let [install, judge] = steps[..] else { panic!("{steps:?}") };
    assert_eq!(install, "cargo install --locked etendue");
    let (code, told, folder) = tried(judge, "");
    assert_eq!(code, Some(0), "{told}");
    let junit = fs::read_to_string(folder.path().join("light.xml")).unwrap();
    assert!(junit.contains("program:python3 bias") && junit.contains("failures=\"0\""), "{junit}");
    assert!(folder.path().join("light/verdicts.csv").exists());
}

#[test]
fn the_architecture_names_every_room() {
    let text = paper("ARCHITECTURE.md");
    for entry in fs::read_dir(root().join("src")).expect("there is a source") {
        let entry = entry.expect("it can be listed");
        if entry.path().is_dir() {
            let room = format!("`{}/`", entry.file_name().to_string_lossy());
            assert!(text.contains(&room), "ARCHITECTURE.md does not name {room}");
        }
    }
    let words = text.split_whitespace().count();
    assert!(words < 1400, "under two pages; {words} words");
}
