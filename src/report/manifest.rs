//! Where a report comes from: enough to make it again, and no clock time.

use serde::Serialize;

use crate::configuration::Arrangement;
use crate::trial::RunOutcome;

/// Rises when a reader of an older manifest would misread a newer one.
const SCHEMA_VERSION: u32 = 1;

/// Keys are written in the order in which they stand here.
#[derive(Serialize)]
struct Manifest<'a> {
    schema_version: u32,
    etendue_version: &'static str,
    seed: u64,
    generator: &'a str,
    command: &'a str,
    /// Features of the machine that change bits. There are none: elementary functions come from one portable
    /// library, results merge in index order, and nothing fuses or reorders floating-point operations.
    machine_features_that_change_bits: [&'static str; 0],
    /// Only where the run was interrupted: a whole run says nothing of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    interrupted: Option<Interrupted<'a>>,
    cases: Vec<ManifestCase<'a>>,
}

#[derive(Serialize)]
struct Interrupted<'a> {
    /// Names of the cases that were not finished.
    missing: &'a [String],
}

#[derive(Serialize)]
struct ManifestCase<'a> {
    name: &'a str,
    title: &'a str,
    digest: String,
    points: usize,
    /// Columns and rows, where the points are a grid; whether they follow a line. For whoever draws them.
    #[serde(skip_serializing_if = "Option::is_none")]
    grid: Option<[usize; 2]>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    line: bool,
    strategies: Vec<&'a str>,
}

/// The text of `manifest.json`.
pub(super) fn manifest(outcome: &RunOutcome, generator: &str) -> String {
    let manifest = Manifest {
        schema_version: SCHEMA_VERSION,
        etendue_version: env!("CARGO_PKG_VERSION"),
        seed: outcome.seed,
        generator,
        command: &outcome.command,
        machine_features_that_change_bits: [],
        interrupted: (!outcome.missing.is_empty()).then_some(Interrupted { missing: &outcome.missing }),
        cases: outcome
            .cases
            .iter()
            .map(|case| ManifestCase {
                name: &case.name,
                title: &case.title,
                digest: case.digest.to_string(),
                points: case.points.len(),
                grid: match case.arrangement {
                    Arrangement::Grid { nu, nv } => Some([nu, nv]),
                    _ => None,
                },
                line: case.arrangement == Arrangement::Line && !case.points.is_empty(),
                strategies: case.strategies.iter().map(|s| s.name()).collect(),
            })
            .collect(),
    };
    let mut text = serde_json::to_string_pretty(&manifest).expect("texts and counts serialise");
    text.push('\n');
    text
}
