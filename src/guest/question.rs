//! Questions and answers as lines of text: what a program reads, and what it says.

use std::fmt;
use std::io::{self, BufRead, Read, Write};

use super::error::AnswerFault;
use crate::configuration::MeasurementPoint;
use crate::intake::LINE;
use crate::sampling::{Draws, StreamKey};
use crate::trial::{Asked, AskedCell};

/// The first line that a program reads: metres, the unit normal, the number of samples N, the number of the replicate, and a
/// seed below 2⁵³, which a double holds, of this estimate's own.
pub const QUESTION_HEADER: &str = "point,x_m,y_m,z_m,nx,ny,nz,samples,replicate,seed";
/// The first line of what it says, if it likes; the value is the irradiance in W/m².
pub const ANSWER_HEADER: &str = "point,replicate,samples,value";

/// Of a line that is no answer so much is shown, characters.
const SHOWN: usize = 60;

/// Which estimate is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Question {
    /// Counted from 0, in the order of the case.
    pub point: u64,
    /// Counted from 0.
    pub replicate: u64,
    pub samples: u64,
}

impl fmt::Display for Question {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Question { point, replicate, samples } = self;
        write!(f, "point {point}, replicate {replicate}, samples {samples}")
    }
}

/// All questions in their order: cell by cell, replicate by replicate, point by point.
pub(super) struct Questions<'a> {
    cells: &'a [AskedCell],
    n_points: u64,
}

impl<'a> Questions<'a> {
    pub fn new(cells: &'a [AskedCell], n_points: usize) -> Questions<'a> {
        Questions { cells, n_points: n_points as u64 }
    }

    pub fn count(&self) -> u64 {
        self.cells.iter().map(|cell| cell.replicates * self.n_points).sum()
    }

    /// The k-th question, and the index of its cell.
    pub fn get(&self, mut k: u64) -> Option<(usize, Question)> {
        for (index, cell) in self.cells.iter().enumerate() {
            let here = cell.replicates * self.n_points;
            if k < here {
                let (replicate, point) = (k / self.n_points, k % self.n_points);
                return Some((index, Question { point, replicate, samples: cell.samples }));
            }
            k -= here;
        }
        None
    }

    /// Where a question stands, or why it was not asked.
    pub fn place(&self, question: &Question) -> Result<u64, AnswerFault> {
        let mut before = 0;
        let not_asked = |why| Err(AnswerFault::NotAsked { question: *question, why });
        for cell in self.cells {
            if cell.samples == question.samples {
                if question.point >= self.n_points {
                    return not_asked(format!("there are {} points, counted from 0", self.n_points));
                }
                if question.replicate >= cell.replicates {
                    return not_asked(format!("there are {} replicates, counted from 0", cell.replicates));
                }
                return Ok(before + question.replicate * self.n_points + question.point);
            }
            before += cell.replicates * self.n_points;
        }
        let counts = self.cells.iter().map(|cell| cell.samples.to_string()).collect::<Vec<_>>().join(", ");
        not_asked(format!("the samples are {counts}"))
    }
}

/// The seed of one estimate.
fn seed(cell: StreamKey, replicate: u64, point: u64) -> u64 {
    Draws::of(cell.with(replicate).with(point + 1)).next_u64() >> 11
}

/// Writes all questions.
pub fn write_questions(out: &mut dyn Write, asked: &Asked) -> io::Result<()> {
    write_all(out, asked.points, &asked.cells)
}

pub(super) fn write_all(out: &mut dyn Write, points: &[MeasurementPoint], cells: &[AskedCell]) -> io::Result<()> {
    writeln!(out, "{QUESTION_HEADER}")?;
    let poses: Vec<String> = points
        .iter()
        .map(|point| {
            let (x, n) = (point.position(), point.normal());
            format!("{:?},{:?},{:?},{:?},{:?},{:?}", x.x, x.y, x.z, n.x, n.y, n.z)
        })
        .collect();
    for cell in cells {
        for replicate in 0..cell.replicates {
            for (point, pose) in poses.iter().enumerate() {
                let seed = seed(cell.key, replicate, point as u64);
                writeln!(out, "{point},{pose},{},{replicate},{seed}", cell.samples)?;
            }
        }
    }
    out.flush()
}

/// Reads a line of at most 4096 bytes; `None` at the end. What is longer comes in pieces, none of which is an answer.
pub(super) fn read_line(input: &mut impl BufRead) -> io::Result<Option<String>> {
    let mut line = Vec::new();
    input.take(LINE).read_until(b'\n', &mut line)?;
    Ok((!line.is_empty()).then(|| String::from_utf8_lossy(&line).trim_end_matches(['\n', '\r']).to_owned()))
}

/// Whether a line says nothing: it is blank, or the header where that may stand.
pub(super) fn is_silent(line: &str, first: bool) -> bool {
    let same = |a: &str, b: &str| a.split(',').map(str::trim).eq(b.split(','));
    line.trim().is_empty() || (first && same(line, ANSWER_HEADER))
}

/// The estimate that a line gives.
pub(super) fn parse(line: &str) -> Result<(Question, f64), AnswerFault> {
    let garbage = |why| {
        let mut said: String = line.chars().take(SHOWN).map(|c| if c.is_control() { '·' } else { c }).collect();
        if line.chars().nth(SHOWN).is_some() {
            said.push('…');
        }
        AnswerFault::Garbage { said, why }
    };
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    let [point, replicate, samples, value] = fields[..] else {
        return Err(garbage("it has not four fields"));
    };
    let count = |field: &str| field.parse::<u64>();
    let (Ok(point), Ok(replicate), Ok(samples)) = (count(point), count(replicate), count(samples)) else {
        return Err(garbage("point, replicate and samples are whole numbers"));
    };
    let question = Question { point, replicate, samples };
    match value.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok((question, value)),
        Ok(value) => Err(AnswerFault::NotFinite { question, value }),
        // As C prints them.
        Err(_) if value.to_ascii_lowercase().contains("nan") => {
            Err(AnswerFault::NotFinite { question, value: f64::NAN })
        }
        Err(_) => Err(garbage("its value is no number")),
    }
}

/// One answer as a line.
pub(super) fn write_answer(out: &mut dyn Write, question: &Question, value: f64) -> io::Result<()> {
    let Question { point, replicate, samples } = question;
    writeln!(out, "{point},{replicate},{samples},{value:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells() -> Vec<AskedCell> {
        [(1, 3), (16, 2)]
            .map(|(samples, replicates)| AskedCell { samples, replicates, key: StreamKey::root(samples) })
            .to_vec()
    }

    #[test]
    fn every_question_has_its_place() {
        let cells = cells();
        let questions = Questions::new(&cells, 4);
        assert_eq!(questions.count(), 20);
        for k in 0..20 {
            let (cell, question) = questions.get(k).unwrap();
            assert_eq!((questions.place(&question), cell), (Ok(k), usize::from(k >= 12)));
        }
        assert_eq!(questions.get(20), None);
        for (point, replicate, samples, why) in
            [(4, 0, 1, "4 points"), (0, 2, 16, "2 replicates"), (0, 0, 2, "1, 16")]
        {
            let fault = questions.place(&Question { point, replicate, samples }).unwrap_err();
            assert!(fault.to_string().contains(why), "{fault}");
        }
    }

    #[test]
    fn a_line_is_an_answer_or_says_why_not() {
        let question = Question { point: 3, replicate: 0, samples: 16 };
        for line in ["3,0,16,0.25", " 3 , 0,16, 2.5e-1 ", "3,0,16,.25"] {
            assert_eq!(parse(line), Ok((question, 0.25)), "{line}");
        }
        for line in ["3,0,16,nan", "3,0,16,-nan", "3,0,16,NaN", "3,0,16,inf", "3,0,16,-nan(ind)"] {
            assert!(matches!(parse(line), Err(AnswerFault::NotFinite { .. })), "{line}");
        }
        for line in ["hello", "3,0,16", "3,0,16,0.25,1", "3.0,0,16,0.25", "-1,0,16,0.25", "3,0,16,x", "3,0,16,"] {
            assert!(matches!(parse(line), Err(AnswerFault::Garbage { .. })), "{line}");
        }
        assert!(parse(&"x".repeat(500)).unwrap_err().to_string().contains('…'));
        assert!(is_silent("point, replicate, samples, value", true) && !is_silent(ANSWER_HEADER, false));
    }

    #[test]
    fn endless_lines_come_in_pieces() {
        let text = "x".repeat(10_000) + "\n0,0,1,2\r\n";
        let mut input = io::Cursor::new(text);
        let mut lines = Vec::new();
        while let Some(line) = read_line(&mut input).unwrap() {
            assert!(line.len() <= LINE as usize);
            lines.push(line);
        }
        assert_eq!((lines.len(), lines[3].as_str()), (4, "0,0,1,2"));
    }

    #[test]
    fn seeds_are_their_own_and_fit_a_double() {
        let key = StreamKey::root(1);
        let mut seeds: Vec<u64> =
            (0..100).flat_map(|replicate| (0..50).map(move |point| seed(key, replicate, point))).collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 5000);
        assert!(seeds.iter().all(|seed| *seed < 1 << 53));
    }
}
