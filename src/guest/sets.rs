//! Files of point sets.
//!
//! One point a line, its two coordinates in [0, 1) with blanks or a comma between them. An empty line, or one that begins
//! with `#`, stands between sets, and may stand before and behind them; all sets have as many points.
//!
//! ```text
//! # two sets of two points
//! 0.25 0.25
//! 0.75 0.75
//!
//! 0.1 0.6
//! 0.9 0.4
//! ```
//!
//! A set is one replicate, at all shading points and on all sources; none is used twice, since a set that is used again is no
//! new evidence.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::question::read_line;
use crate::case::Case;
use crate::intake::{ESTIMATES, REPLICATES};
use crate::sampling::{BLOCK, LANES, Lanes, Pattern, Purpose, Squares, Strategy, StreamKey, Technique};
use crate::trial::{CaseOutcome, Invitation, NotJudged, Settings, judge_sets};

/// Sets of points in the unit square.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSets {
    /// `points:` and the file's stem.
    pub name: String,
    /// As many points in each; at least one set of at least one.
    sets: Vec<Vec<[f64; 2]>>,
}

impl PointSets {
    pub fn sets(&self) -> &[Vec<[f64; 2]>] {
        &self.sets
    }
    /// Points in each set.
    pub fn samples(&self) -> u64 {
        self.sets[0].len() as u64
    }
}

/// What is wrong with a file of point sets.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SetsError {
    #[error("{}: {source}", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    #[error("{}:{line}: `{said}` is no point; accepted: two numbers with blanks or a comma between them, such as `0.25 0.75`", path.display())]
    Garbage { path: PathBuf, line: u64, said: String },
    #[error("{}:{line}: ({u}, {v}) lies outside of the unit square; accepted: coordinates from 0 to below 1", path.display())]
    Outside { path: PathBuf, line: u64, u: f64, v: f64 },
    #[error("{}:{line}: the set that ends here has {said} points, the first has {expected}; accepted: as many in every set, an empty line between sets", path.display())]
    Uneven { path: PathBuf, line: u64, said: usize, expected: usize },
    #[error("{}: there is no point in it; accepted: one point a line, such as `0.25 0.75`, an empty line between sets", path.display())]
    Empty { path: PathBuf },
    #[error("{}: there are more than {limit} {what} in it, the most that are held in memory", path.display())]
    TooLarge { path: PathBuf, what: &'static str, limit: u64 },
}

/// Reads a file of point sets.
pub fn read_sets(path: &Path) -> Result<PointSets, SetsError> {
    let file = File::open(path).map_err(|source| SetsError::Unreadable { path: path.to_owned(), source })?;
    read_from(path, BufReader::new(file))
}

/// The same of a file that lies in memory.
#[cfg(any(fuzzing, test))]
pub(crate) fn sets_from_memory(bytes: &[u8]) -> Result<PointSets, SetsError> {
    read_from(Path::new("memory"), io::Cursor::new(bytes))
}

fn read_from(path: &Path, mut file: impl BufRead) -> Result<PointSets, SetsError> {
    let unreadable = |source| SetsError::Unreadable { path: path.to_owned(), source };
    let mut sets: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut set = Vec::new();
    let (mut line, mut held) = (0, 0);
    let mut end_set = |set: &mut Vec<[f64; 2]>, line| {
        if set.is_empty() {
            return Ok(());
        }
        let expected = sets.first().map_or(set.len(), Vec::len);
        if set.len() != expected {
            return Err(SetsError::Uneven { path: path.to_owned(), line, said: set.len(), expected });
        }
        if sets.len() as u64 >= REPLICATES {
            return Err(SetsError::TooLarge { path: path.to_owned(), what: "sets", limit: REPLICATES });
        }
        sets.push(std::mem::take(set));
        Ok(())
    };
    while let Some(text) = read_line(&mut file).map_err(unreadable)? {
        line += 1;
        let text = text.trim_start_matches('\u{feff}').trim();
        if text.is_empty() || text.starts_with('#') {
            end_set(&mut set, line)?;
            continue;
        }
        set.push(point(text, path, line)?);
        held += 1;
        if held > ESTIMATES {
            return Err(SetsError::TooLarge { path: path.to_owned(), what: "points", limit: ESTIMATES });
        }
    }
    end_set(&mut set, line)?;
    if sets.is_empty() {
        return Err(SetsError::Empty { path: path.to_owned() });
    }
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(PointSets { name: format!("points:{stem}"), sets })
}

fn point(text: &str, path: &Path, line: u64) -> Result<[f64; 2], SetsError> {
    let garbage = || {
        let said = text.chars().take(60).map(|c| if c.is_control() { '·' } else { c }).collect();
        SetsError::Garbage { path: path.to_owned(), line, said }
    };
    let mut numbers = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    let (Some(u), Some(v), None) = (numbers.next(), numbers.next(), numbers.next()) else { return Err(garbage()) };
    let (Ok(u), Ok(v)) = (u.parse::<f64>(), v.parse::<f64>()) else { return Err(garbage()) };
    if !((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v)) {
        return Err(SetsError::Outside { path: path.to_owned(), line, u, v });
    }
    Ok([u, v])
}

/// Judges sets of points.
pub fn judge_point_sets(
    case: &Case,
    settings: &Settings,
    invitation: &Invitation,
    sets: &PointSets,
) -> Result<CaseOutcome, NotJudged> {
    judge_sets(case, settings, invitation, &sets.sets)
}

/// Writes sets of a strategy's points; `false`, and nothing, where the strategy draws no points of the unit square for the
/// sources' area.
pub fn write_sets(out: &mut dyn Write, strategy: Strategy, n: u64, n_sets: u64, seed: u64) -> io::Result<bool> {
    if strategy.technique() != Technique::Area {
        return Ok(false);
    }
    let plural = if n_sets == 1 { "set" } else { "sets" };
    writeln!(out, "# etendue points {strategy} -n {n} --sets {n_sets} --seed {seed}")?;
    writeln!(out, "# {n_sets} {plural} of {n}: u v in [0, 1); an empty line between sets")?;
    let key = StreamKey::cell(seed, 0, Purpose::Measurement, strategy, n);
    let mut squares = Squares::default();
    for set in 0..n_sets {
        if set > 0 {
            writeln!(out)?;
        }
        let mut pattern = Pattern::new(strategy, n, Lanes::new(key.with(set), n.min(LANES as u64) as usize));
        let mut left = n;
        while left > 0 {
            let len = left.min(BLOCK as u64) as usize;
            pattern.fill(&mut squares, len);
            let (u, v) = (squares.u.as_flattened(), squares.v.as_flattened());
            for (u, v) in u.iter().zip(v).take(len) {
                writeln!(out, "{u:?} {v:?}")?;
            }
            left -= len as u64;
        }
    }
    out.flush()?;
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<PointSets, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.txt");
        std::fs::write(&path, text).unwrap();
        read_sets(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn sets_are_read_as_they_come() {
        let sets = vec![vec![[0.25, 0.5], [0.0, 0.75]], vec![[0.1, 0.2], [0.3, 0.4]]];
        let expected = Ok(PointSets { name: "points:mine".to_owned(), sets });
        for text in [
            "# mine\n0.25 0.5\n0 .75\n\n0.1 0.2\n0.3 0.4\n",
            "0.25,0.5\r\n0.0, 7.5e-1\r\n#\r\n0.1\t0.2\r\n0.3 0.4",
            "\n\n0.25 0.5\n0 0.75\n\n\n# another\n0.1 0.2\n0.3 0.4\n\n",
        ] {
            assert_eq!(read(text), expected, "{text:?}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line_and_what_is_accepted() {
        for (text, said) in [
            ("0.5 0.5\n0.5\n", "mine.txt:2: `0.5` is no point"),
            ("0.5 0.5 0.5\n", "mine.txt:1: `0.5 0.5 0.5` is no point"),
            ("0.5 half\n", "mine.txt:1: `0.5 half` is no point"),
            ("0.5 1.0\n", "mine.txt:1: (0.5, 1) lies outside"),
            ("0.5 -0.1\n", "(0.5, -0.1) lies outside"),
            ("nan 0.5\n", "(NaN, 0.5) lies outside"),
            ("0.5 0.5\n0.1 0.1\n\n0.2 0.2\n", "mine.txt:4: the set that ends here has 1 points, the first has 2"),
            ("# nothing\n\n", "mine.txt: there is no point in it"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(said) && error.contains("accepted: "), "{text:?}: {error}");
        }
        assert!(read_sets(Path::new("/no/such/file.txt")).unwrap_err().to_string().contains("/no/such/file.txt"));
    }

    #[test]
    fn what_is_written_is_read_again() {
        for strategy in Strategy::ALL {
            let mut text = Vec::new();
            let written = write_sets(&mut text, strategy, 37, 3, 5).unwrap();
            assert_eq!(written, strategy.technique() == Technique::Area, "{strategy}");
            if written {
                let sets = read(std::str::from_utf8(&text).unwrap()).unwrap();
                assert_eq!((sets.sets().len(), sets.samples()), (3, 37), "{strategy}");
                assert_ne!(sets.sets()[0], sets.sets()[1]);
            }
        }
    }
}
