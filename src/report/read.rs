//! Reports read back: what the tables of a folder say, or which place in which file cannot be understood.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::ReportError;
use crate::statistics::{Interval, Verdict};
use crate::trial::{Record, RecordedVariance, RecordedVerdict};

/// A file larger than this is no table of ours: bytes.
const LARGEST: u64 = 4 << 30;

/// Reads what two runs are compared by: verdicts, variances and, if there is one, the manifest.
///
/// - `dir`: the folder of a report. Fails where `verdicts.csv` or `convergence.csv` is missing or says what cannot be; a
///   missing manifest leaves its fields empty
pub fn read(dir: &Path) -> Result<Record, ReportError> {
    if !dir.is_dir() {
        return Err(ReportError::NoReport { path: dir.to_owned(), missing: None });
    }
    let mut record = Record::default();
    manifest(dir, &mut record)?;
    each(dir, "verdicts.csv", |row| {
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
    each(dir, "convergence.csv", |row| {
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

#[derive(Deserialize)]
struct Manifest {
    etendue_version: String,
    seed: u64,
    command: String,
    cases: Vec<ManifestCase>,
}

#[derive(Deserialize)]
struct ManifestCase {
    name: String,
    digest: String,
}

fn manifest(dir: &Path, record: &mut Record) -> Result<(), ReportError> {
    let path = dir.join("manifest.json");
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(ReportError::Unreadable { path, source }),
    };
    let manifest: Manifest = serde_json::from_str(&text).map_err(|error| ReportError::NotOurs {
        path,
        line: error.line() as u64,
        reason: error.to_string(),
    })?;
    record.version = manifest.etendue_version;
    record.seed = manifest.seed.to_string();
    record.command = manifest.command;
    record.digests = manifest.cases.into_iter().map(|case| (case.name, case.digest)).collect();
    Ok(())
}

/// A row of a table.
struct Row<'a> {
    path: &'a PathBuf,
    columns: &'a BTreeMap<String, usize>,
    fields: &'a csv::StringRecord,
}

impl Row<'_> {
    fn text(&self, column: &str) -> Result<&str, ReportError> {
        match self.columns.get(column) {
            Some(place) => Ok(&self.fields[*place]),
            None => Err(ReportError::NotOurs {
                path: self.path.clone(),
                line: 1,
                reason: format!("there is no column `{column}`"),
            }),
        }
    }

    fn wrong(&self, column: &str, due: &str) -> ReportError {
        let said = self.text(column).unwrap_or_default();
        ReportError::NotOurs {
            path: self.path.clone(),
            line: self.fields.position().map_or(0, csv::Position::line),
            reason: format!("`{column}` says `{}`; {due} is due", shortened(said)),
        }
    }

    fn count(&self, column: &str) -> Result<u64, ReportError> {
        self.text(column)?.parse().map_err(|_| self.wrong(column, "a whole number"))
    }

    /// `None` of an empty field.
    fn number(&self, column: &str) -> Result<Option<f64>, ReportError> {
        match self.text(column)? {
            "" => Ok(None),
            text => match text.parse() {
                Ok(x) if f64::is_finite(x) => Ok(Some(x)),
                _ => Err(self.wrong(column, "a number")),
            },
        }
    }

    /// A value and the ends of its interval; `None` where one of them is empty.
    fn with_interval(&self, [value, low, high]: [&str; 3]) -> Result<Option<(f64, Interval)>, ReportError> {
        let (Some(x), Some(from), Some(to)) = (self.number(value)?, self.number(low)?, self.number(high)?) else {
            return Ok(None);
        };
        if from > to {
            return Err(self.wrong(low, "what is not above the other end"));
        }
        Ok(Some((x, Interval { low: from, high: to })))
    }
}

/// Of a field that may be anything.
fn shortened(text: &str) -> String {
    let mut short: String = text.chars().filter(|c| !c.is_control()).take(40).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}

/// Hands every row of a table to `take`.
fn each(dir: &Path, file: &str, mut take: impl FnMut(&Row) -> Result<(), ReportError>) -> Result<(), ReportError> {
    let path = dir.join(file);
    let opened = std::fs::File::open(&path).and_then(|opened| Ok((opened.metadata()?.len(), opened)));
    let (size, opened) = opened.map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => {
            ReportError::NoReport { path: dir.to_owned(), missing: Some(file.to_owned()) }
        }
        _ => ReportError::Unreadable { path: path.clone(), source },
    })?;
    if size > LARGEST {
        let reason = format!("{size} bytes are more than a table of ours has");
        return Err(ReportError::NotOurs { path, line: 1, reason });
    }
    let broken = |error: csv::Error| ReportError::NotOurs {
        path: path.clone(),
        line: error.position().map_or(0, csv::Position::line),
        reason: match error.kind() {
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                format!("{len} fields where the header has {expected_len}: is the file whole?")
            }
            _ => error.to_string(),
        },
    };
    let mut reader = csv::Reader::from_reader(std::io::BufReader::new(opened));
    let columns =
        reader.headers().map_err(broken)?.iter().enumerate().map(|(place, name)| (name.to_owned(), place)).collect();
    let mut fields = csv::StringRecord::new();
    while reader.read_record(&mut fields).map_err(broken)? {
        take(&Row { path: &path, columns: &columns, fields: &fields })?;
    }
    Ok(())
}
