//! `docs/reference/case-files.md`: the format as a page, from the tables that the reader asks.

use std::fmt::Write;
use std::path::PathBuf;

use super::schema::{EXITANCE_TEXTURE, Key, MAX_COUNT, MAX_MAGNITUDE, MIN_AREA, Need, ROOT, Table, Value};
use super::{Case, PROPERTIES};
use crate::radiometry::{BRIGHTEST, FAINTEST};
use crate::sampling::Strategy;

const HEAD: &str = "\
# Case files

A case says what stands in a room, where light is measured, and how estimators are studied there: one
[TOML](https://toml.io) file. Metres, W/m², right-handed, z up by custom. This one is complete:

```toml
title = \"A round lamp behind a board\"

[[source.disk]]
center = [0.0, 0.0, 2.0]
normal = [0.0, 0.0, -1.0]
radius = 0.3
exitance = 1.0

[[occluder.rectangle]]
center = [0.5, 0.0, 1.0]
edge_u = [1.0, 0.0, 0.0]
edge_v = [0.0, 1.0, 0.0]

[receiver.rectangle]
center = [0.0, 0.0, 0.0]
edge_u = [2.0, 0.0, 0.0]
edge_v = [0.0, 2.0, 0.0]

[measure]
line = { from = [-0.6, 0.0, 0.0], to = [0.6, 0.0, 0.0], points = 33 }

[study]
strategies = [\"random\", \"stratified\"]
```

`etendue new NAME` writes one to start from, `etendue check FILE` tells every mistake at once, `etendue schema` gives the same format
to editors ([how](../how-to/write-a-case.md#completion-and-marks-in-an-editor)). A key that is not on this page is a mistake, and is told with the
nearest that is. Headers in two brackets, `[[source.disk]]`, may stand any number of times.

*(This page is written from the tables that the reader of case files asks: `cargo test --lib write_the_case_reference -- --ignored`.)*
";

/// Ranges that stand beside the keys' own.
fn ranges() -> [(&'static str, String); 4] {
    [
        ("largest magnitude of any number but a normal's component", format!("{MAX_MAGNITUDE:e}")),
        ("smallest area of a shape", format!("{MIN_AREA:e} m²")),
        (
            "faintest and brightest exitance, irradiance or power that is not zero",
            format!("{FAINTEST:e}, {BRIGHTEST:e}"),
        ),
        ("largest sample count and replicate count", MAX_COUNT.to_string()),
    ]
}

/// The whole page.
fn case_reference() -> String {
    let mut page = HEAD.to_owned();
    describe(&ROOT, "", &mut page);
    page.push_str(
        "\n## A texture\n\nIn the place of a number, `exitance` of a source and `albedo` of a receiver take a table with one of `image`, \
         `checker` and `polynomial`. Exitances are in W/m², an albedo is a pure number.\n",
    );
    keys(&EXITANCE_TEXTURE, &mut page);
    page.push_str("\n## Limits\n\n| | |\n|---|---|\n");
    for (what, limit) in ranges() {
        let _ = writeln!(page, "| {what} | {limit} |");
    }
    page.push_str("\nHow large a file, a polygon, a mesh or a texture may be, how many there may be, and where paths may lead: [Limits](limits.md).\n");
    page
}

/// Of a table that may stand more than once.
const ANY: &str = "Any number.";

/// A table and all below it.
///
/// - `said`: what its key means, and how often it may stand
fn describe(table: &Table, said: &str, page: &mut String) {
    let title = match (table.path, said) {
        ("", _) => "The top of the file".to_owned(),
        (path, said) if said.ends_with(ANY) => format!("`[[{path}]]`"),
        (path, _) => format!("`[{path}]`"),
    };
    let level = if table.path.contains('.') { "###" } else { "##" };
    let _ = writeln!(page, "\n{level} {title}");
    if !said.is_empty() {
        let _ = writeln!(page, "\n{said}");
    }
    keys(table, page);
    match table.path {
        "receiver" => page.push_str("\nOne of the shapes.\n"),
        "study" => {
            let names: Vec<String> = Strategy::ALL.iter().map(|strategy| format!("`{strategy}`")).collect();
            let _ = writeln!(page, "\nStrategies: {} (`etendue list` says what each is).", names.join(", "));
        }
        "study.accepted" => {
            let _ = writeln!(page, "\nProperties: `{}`.", PROPERTIES.join("`, `"));
        }
        _ => {}
    }
    for key in table.keys.iter().filter(|key| key.need != Need::Later) {
        let (below, times) = match key.value {
            Value::Table(below) => (below, ""),
            Value::Tables(below) => (below, ANY),
            _ => continue,
        };
        // What a kind of shape is stands with its kind; the head of a group tells of itself.
        let said = if table.path.is_empty() { key.meaning.to_owned() } else { format!("{} {times}", key.meaning) };
        describe(below, said.trim_end(), page);
    }
}

fn keys(table: &Table, page: &mut String) {
    page.push_str("\n| key | what | unit | if left out | meaning and range |\n|---|---|---|---|---|\n");
    for key in table.keys.iter().filter(|key| key.need != Need::Later) {
        let left_out = match key.need {
            Need::Required => "**required**".to_owned(),
            Need::Default(default) => default.to_owned(),
            Need::Later => continue,
        };
        let Key { name, unit, meaning, .. } = key;
        let _ = writeln!(page, "| `{name}` | {} | {unit} | {left_out} | {meaning} |", what(key));
    }
}

fn what(key: &Key) -> String {
    let anchor = |below: &Table| below.path.chars().filter(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    match key.value {
        Value::Table(below) => format!("[a table](#{})", anchor(below)),
        Value::Tables(below) => format!("[tables](#{})", anchor(below)),
        Value::Field(_) => "a number or [a texture](#a-texture)".to_owned(),
        _ => key.value.expected().to_owned(),
    }
}

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("docs/reference/case-files.md")
}

/// To write it anew: `cargo test --lib write_the_case_reference -- --ignored`.
#[test]
fn the_committed_case_reference_is_the_codes() {
    assert_eq!(
        std::fs::read_to_string(path()).unwrap_or_default(),
        case_reference(),
        "write it anew with `cargo test --lib write_the_case_reference -- --ignored`"
    );
}

#[test]
#[ignore = "writes docs/reference/case-files.md"]
fn write_the_case_reference() {
    std::fs::write(path(), case_reference()).unwrap();
}

#[test]
fn the_case_of_the_reference_is_valid() {
    let (_, rest) = HEAD.split_once("```toml\n").unwrap();
    let (text, _) = rest.split_once("```").unwrap();
    let case = Case::from_toml("reference", text).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    assert_eq!(case.configuration.points().len(), 33);
}
