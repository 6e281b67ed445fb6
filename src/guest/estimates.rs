//! A file of estimates, in any order.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

use super::error::{AnswerFault, GuestError};
use super::question::{Question, is_silent, parse, read_line};
use crate::case::Case;
use crate::intake::{ESTIMATES, REPLICATES, SAMPLE_COUNTS};
use crate::trial::{CaseOutcome, Invitation, Settings, judge_given};

/// Bytes of a file that tell whether it is one of text.
const HEAD: u64 = 512;

/// For each sample count, ascending: `[replicate][point]`, W/m².
pub type Estimates = Vec<(u64, Vec<Vec<f64>>)>;

/// Judges a file of estimates of a case.
///
/// - `paths`: what each holds is put together
pub fn judge_estimates(
    case: &Case,
    settings: &Settings,
    invitation: &Invitation,
    paths: &[PathBuf],
) -> Result<CaseOutcome, GuestError> {
    let estimates = read_estimates(paths, case.configuration.points().len())?;
    Ok(judge_given(case, settings, invitation, &estimates)?)
}

/// One replicate as far as it is known: NaN where it is not.
struct Row {
    values: Vec<f64>,
    known: usize,
}

/// Reads lines of `point,replicate,samples,value`, a header first if there is one.
///
/// Replicates may have any numbers; their order is that of their numbers. Each has one value for each point.
pub fn read_estimates(paths: &[PathBuf], n_points: usize) -> Result<Estimates, GuestError> {
    let mut table = Table::new(n_points);
    for path in paths {
        table.read(path, open(path)?)?;
    }
    complete(table.cells, n_points, paths)
}

/// The same of one file that lies in memory.
#[cfg(any(fuzzing, test))]
pub(crate) fn estimates_from_memory(bytes: &[u8], n_points: usize) -> Result<Estimates, GuestError> {
    let path = PathBuf::from("memory");
    let mut table = Table::new(n_points);
    refuse_what_is_no_text(&path, &bytes[..bytes.len().min(HEAD as usize)])?;
    table.read(&path, io::Cursor::new(bytes))?;
    complete(table.cells, n_points, &[path])
}

/// By sample count, then by replicate.
type Cells = BTreeMap<u64, BTreeMap<u64, Row>>;

/// Estimates as they come.
struct Table {
    n_points: usize,
    cells: Cells,
    replicates: u64,
}

impl Table {
    fn new(n_points: usize) -> Table {
        Table { n_points, cells: BTreeMap::new(), replicates: 0 }
    }

    fn read(&mut self, path: &Path, mut file: impl BufRead) -> Result<(), GuestError> {
        let n_points = self.n_points;
        let (mut line, mut said) = (0, false);
        let unreadable = |source| GuestError::Unreadable { path: path.to_owned(), source };
        while let Some(text) = read_line(&mut file).map_err(unreadable)? {
            line += 1;
            if is_silent(&text, line == 1) {
                continue;
            }
            let fault = |fault| GuestError::Line { path: path.to_owned(), line, fault };
            let (question, value) = parse(&text).map_err(fault)?;
            let not_asked = |why: String| Err(fault(AnswerFault::NotAsked { question, why }));
            if question.point >= n_points as u64 {
                return not_asked(format!("the case has {n_points} points, counted from 0"));
            }
            if question.samples == 0 {
                return not_asked("an estimate takes one sample or more".to_owned());
            }
            said = true;
            let row = self.row(path, &question)?;
            let kept = &mut row.values[question.point as usize];
            if !kept.is_nan() {
                return Err(fault(AnswerFault::Twice { question }));
            }
            *kept = value;
            row.known += 1;
        }
        if said { Ok(()) } else { Err(GuestError::Empty { path: path.to_owned() }) }
    }

    /// The row of a question, made if there is room for another one.
    fn row(&mut self, path: &Path, question: &Question) -> Result<&mut Row, GuestError> {
        let too_large = |what, limit| GuestError::TooLarge { path: path.to_owned(), what, limit };
        let n_cells = self.cells.len() as u64;
        let rows = match self.cells.entry(question.samples) {
            Entry::Occupied(there) => there.into_mut(),
            Entry::Vacant(_) if n_cells >= SAMPLE_COUNTS => return Err(too_large("sample counts", SAMPLE_COUNTS)),
            Entry::Vacant(free) => free.insert(BTreeMap::new()),
        };
        match rows.entry(question.replicate) {
            Entry::Occupied(there) => Ok(there.into_mut()),
            Entry::Vacant(free) => {
                self.replicates += 1;
                if self.replicates > REPLICATES {
                    return Err(too_large("replicates", REPLICATES));
                }
                if self.replicates.saturating_mul(self.n_points as u64) > ESTIMATES {
                    return Err(too_large("estimates", ESTIMATES));
                }
                Ok(free.insert(Row { values: vec![f64::NAN; self.n_points], known: 0 }))
            }
        }
    }
}

fn complete(cells: Cells, n_points: usize, paths: &[PathBuf]) -> Result<Estimates, GuestError> {
    let missing = |(samples, rows): (&u64, &BTreeMap<u64, Row>)| {
        let lacking = rows.iter().filter(|(_, row)| row.known < n_points);
        let questions = lacking.map(|(replicate, row)| {
            let point = row.values.iter().position(|value| value.is_nan()).unwrap_or(0) as u64;
            Question { point, replicate: *replicate, samples: *samples }
        });
        questions.collect::<Vec<_>>()
    };
    let missing: Vec<Question> = cells.iter().flat_map(missing).collect();
    if let Some(question) = missing.first() {
        let path = paths.last().cloned().unwrap_or_default();
        return Err(GuestError::Incomplete { path, question: *question, others: missing.len() as u64 - 1 });
    }
    let whole = |rows: BTreeMap<u64, Row>| rows.into_values().map(|row| row.values).collect();
    Ok(cells.into_iter().map(|(samples, rows)| (samples, whole(rows))).collect())
}

/// Opens a file that may be one of estimates; what is known to be something else is named.
fn open(path: &Path) -> Result<BufReader<File>, GuestError> {
    let unreadable = |source| GuestError::Unreadable { path: path.to_owned(), source };
    let mut file = File::open(path).map_err(unreadable)?;
    let mut head = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut head).map_err(unreadable)?;
    refuse_what_is_no_text(path, &head)?;
    file.seek(io::SeekFrom::Start(0)).map_err(unreadable)?;
    Ok(BufReader::new(file))
}

/// - `head`: how the file begins
fn refuse_what_is_no_text(path: &Path, head: &[u8]) -> Result<(), GuestError> {
    let foreign = |what| Err(GuestError::Foreign { path: path.to_owned(), what });
    if [&b"\x76\x2f\x31\x01"[..], b"PF", b"Pf", b"\x93NUMPY", b"\x89PNG"].iter().any(|magic| head.starts_with(magic))
    {
        return foreign("this is an image or an array, which is judged by itself (`trial::judge_images`)");
    }
    if head.contains(&0) {
        return foreign("this is no text");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Estimates, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("estimates.csv");
        std::fs::write(&path, text).unwrap();
        read_estimates(&[path], 2).map_err(|error| error.to_string())
    }

    #[test]
    fn the_order_of_lines_is_free() {
        let text =
            "point,replicate,samples,value\r\n1,7,4,0.5\n0,2,4,0.1\n\n0,7,4,0.4\n1,2,4,0.2\n0,0,1,9\n1,0,1,8\n";
        assert_eq!(read(text), Ok(vec![(1, vec![vec![9.0, 8.0]]), (4, vec![vec![0.1, 0.2], vec![0.4, 0.5]])]));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, said) in [
            ("0,0,1,2\n0,0,1,2\n", "estimates.csv:2: point 0, replicate 0, samples 1 is answered a second time"),
            ("0,0,1,2\n", "point 1, replicate 0, samples 1 has no answer"),
            ("0,0,1,nan\n", "estimates.csv:1: the answer to point 0, replicate 0, samples 1 is NaN"),
            ("0,0,1,2\n2,0,1,2\n", "the case has 2 points"),
            ("0,0,0,2\n", "one sample or more"),
            ("0,0,1,2\nrubbish\n", "estimates.csv:2: `rubbish` is no answer"),
            ("", "no estimate"),
            ("point,replicate,samples,value\n", "no estimate"),
            ("\x00\x01", "no text"),
            ("PF\n512 512\n", "image"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(said), "{text:?}: {error}");
        }
    }
}
