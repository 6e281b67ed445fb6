//! Reports read back: what the tables of a folder say, or which place in which file cannot be understood.

use std::path::Path;

use super::ReportError;
use super::record::{Place, Row, manifest};
use crate::statistics::Verdict;
use crate::trial::{Record, RecordedVariance, RecordedVerdict};

/// Reads what two runs are compared by: verdicts, variances and, if there is one, the manifest.
///
/// - `dir`: the folder of a report. Fails where `verdicts.csv` or `convergence.csv` is missing or says what cannot be; a
///   missing manifest leaves its fields empty
pub fn read(dir: &Path) -> Result<Record, ReportError> {
    if !dir.is_dir() {
        return Err(ReportError::NoReport { path: dir.to_owned(), missing: None });
    }
    read_from(Place::Folder(dir))
}

/// The same, from wherever its files are.
pub(super) fn read_from(place: Place) -> Result<Record, ReportError> {
    let mut record = Record::default();
    if let Some(manifest) = manifest(place)? {
        record.version = manifest.etendue_version;
        record.seed = manifest.seed.to_string();
        record.command = manifest.command;
        record.digests = manifest.cases.into_iter().map(|case| (case.name, case.digest)).collect();
    }
    each(place, "verdicts.csv", |row| {
        record.verdicts.push(RecordedVerdict {
            case: row.text("case")?.to_owned(),
            strategy: row.text("strategy")?.to_owned(),
            property: row.text("property")?.to_owned(),
            verdict: Verdict::from_name(row.text("verdict")?)
                .ok_or_else(|| row.wrong("verdict", "pass, fail or undecided"))?,
            effect: row.with_interval(["effect", "effect_low", "effect_high"])?,
            reproduce: row.text("reproduce")?.to_owned(),
        });
        Ok(())
    })?;
    each(place, "convergence.csv", |row| {
        let interval = row.with_interval(["variance_W2_m4", "variance_low", "variance_high"])?;
        record.variances.push(RecordedVariance {
            case: row.text("case")?.to_owned(),
            strategy: row.text("strategy")?.to_owned(),
            point: row.count("point")?,
            samples: row.count("samples")?,
            variance: row.number("variance_W2_m4")?.ok_or_else(|| row.wrong("variance_W2_m4", "a number"))?,
            interval: interval.map(|(_, interval)| interval),
        });
        Ok(())
    })?;
    Ok(record)
}

/// The same as [`Place::each`] of a table that has to be there.
fn each(place: Place, file: &str, take: impl FnMut(&Row) -> Result<(), ReportError>) -> Result<(), ReportError> {
    if place.each(file, take)? {
        return Ok(());
    }
    Err(ReportError::NoReport { path: place.path(""), missing: Some(file.to_owned()) })
}
