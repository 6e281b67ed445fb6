//! Tables read back, row by row: every field is asked for by its column's name, and what cannot be says where it stands.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::io::{self, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::intake::{COLUMNS, MANIFEST_BYTES, ROW_BYTES, TABLE_BYTES};
use crate::report::ReportError;
use crate::statistics::Interval;

/// Where the files of a report are.
#[derive(Clone, Copy, Debug)]
pub(in crate::report) enum Place<'a> {
    Folder(&'a Path),
    /// Written already, and still at hand.
    Memory(&'a [(&'static str, Vec<u8>)]),
}

impl Place<'_> {
    /// How a file of it is told to people.
    pub fn path(&self, file: &str) -> PathBuf {
        match self {
            Place::Folder(dir) => dir.join(file),
            Place::Memory(_) => PathBuf::from(file),
        }
    }

    /// `None` where there is no such file.
    pub fn open(&self, file: &str) -> Result<Option<Box<dyn Read + '_>>, ReportError> {
        match self {
            Place::Memory(files) => {
                let found = files.iter().find(|(name, _)| *name == file);
                Ok(found.map(|(_, content)| Box::new(content.as_slice()) as Box<dyn Read>))
            }
            Place::Folder(dir) => {
                let path = dir.join(file);
                let limit = if file.ends_with(".json") { MANIFEST_BYTES } else { TABLE_BYTES };
                // Before it is opened: a pipe would be waited for.
                match std::fs::metadata(&path) {
                    Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
                    Err(source) => Err(ReportError::Unreadable { path, source }),
                    Ok(what) if what.is_dir() => {
                        Err(ReportError::Unreadable { path, source: io::Error::from(ErrorKind::IsADirectory) })
                    }
                    Ok(what) if !what.is_file() => {
                        let source = io::Error::new(ErrorKind::InvalidInput, "it is no regular file");
                        Err(ReportError::Unreadable { path, source })
                    }
                    Ok(what) if what.len() > limit => {
                        let reason = format!("{} bytes; up to {limit} are accepted", what.len());
                        Err(ReportError::NotOurs { path, line: 1, reason })
                    }
                    Ok(_) => match std::fs::File::open(&path) {
                        Ok(opened) => Ok(Some(Box::new(BufReader::new(opened)))),
                        Err(source) => Err(ReportError::Unreadable { path, source }),
                    },
                }
            }
        }
    }

    /// Hands every row of a table to `take`, to the end or to the first that cannot be understood. False where there is no
    /// such table.
    pub fn each(
        &self,
        file: &str,
        mut take: impl FnMut(&Row) -> Result<(), ReportError>,
    ) -> Result<bool, ReportError> {
        let Some(opened) = self.open(file)? else { return Ok(false) };
        let path = self.path(file);
        // Of what cannot be read at all, the row before is known.
        let broken = |error: csv::Error, before: u64| ReportError::NotOurs {
            path: path.clone(),
            line: error.position().map_or(before, csv::Position::line),
            reason: match error.kind() {
                csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                    format!("{len} fields where the header has {expected_len}: is the file whole?")
                }
                _ => error.to_string(),
            },
        };
        let left = Cell::new(ROW_BYTES);
        let mut reader = csv::Reader::from_reader(Metered { inner: opened, left: &left });
        let headers = reader.headers().map_err(|error| broken(error, 1))?;
        if headers.len() as u64 > COLUMNS {
            let reason = format!("{} columns; up to {COLUMNS} are accepted", headers.len());
            return Err(ReportError::NotOurs { path, line: 1, reason });
        }
        let columns = headers.iter().enumerate().map(|(place, name)| (name.to_owned(), place)).collect();
        let mut fields = csv::StringRecord::new();
        loop {
            left.set(ROW_BYTES);
            let before = reader.position().line();
            if !reader.read_record(&mut fields).map_err(|error| broken(error, before))? {
                return Ok(true);
            }
            take(&Row { path: &path, columns: &columns, fields: &fields })?;
        }
    }
}

/// What a row may still take: rows are held as a whole, and a quote that is never closed makes one of all that follows.
struct Metered<'a, R> {
    inner: R,
    left: &'a Cell<u64>,
}

impl<R: Read> Read for Metered<'_, R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.left.get() == 0 {
            return Err(io::Error::new(ErrorKind::InvalidData, TOO_LONG));
        }
        let most = into.len().min(self.left.get() as usize);
        let read = self.inner.read(&mut into[..most])?;
        self.left.set(self.left.get() - read as u64);
        Ok(read)
    }
}

const TOO_LONG: &str = "a row goes on for more than a mebibyte, the most that is accepted: is a quote left open?";

/// A row of a table.
pub(in crate::report) struct Row<'a> {
    path: &'a PathBuf,
    columns: &'a BTreeMap<String, usize>,
    fields: &'a csv::StringRecord,
}

impl Row<'_> {
    pub fn text(&self, column: &str) -> Result<&str, ReportError> {
        match self.columns.get(column) {
            Some(place) => Ok(&self.fields[*place]),
            None => Err(ReportError::NotOurs {
                path: self.path.clone(),
                line: 1,
                reason: format!("there is no column `{column}`"),
            }),
        }
    }

    pub fn wrong(&self, column: &str, due: &str) -> ReportError {
        let said = self.text(column).unwrap_or_default();
        ReportError::NotOurs {
            path: self.path.clone(),
            line: self.fields.position().map_or(0, csv::Position::line),
            reason: format!("`{column}` says `{}`; {due} is due", shortened(said)),
        }
    }

    pub fn too_many(&self, what: &str, limit: u64) -> ReportError {
        let line = self.fields.position().map_or(0, csv::Position::line);
        ReportError::NotOurs { path: self.path.clone(), line, reason: format!("more than {limit} {what}") }
    }

    pub fn count(&self, column: &str) -> Result<u64, ReportError> {
        self.text(column)?.parse().map_err(|_| self.wrong(column, "a whole number"))
    }

    /// `None` of an empty field.
    pub fn number(&self, column: &str) -> Result<Option<f64>, ReportError> {
        match self.text(column)? {
            "" => Ok(None),
            text => match text.parse() {
                Ok(x) if f64::is_finite(x) => Ok(Some(x)),
                _ => Err(self.wrong(column, "a number")),
            },
        }
    }

    /// A value and the ends of its interval; `None` where one of them is empty.
    pub fn with_interval(&self, [value, low, high]: [&str; 3]) -> Result<Option<(f64, Interval)>, ReportError> {
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
