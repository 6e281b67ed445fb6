//! A program in any language, asked over its standard input and output.
//!
//! It is started, given all questions, and told that there are no more by the end of its input; it may answer line by line or
//! all at the end. Questions are written while answers are read, so neither waits for the other. What it says on its standard
//! error goes where ours goes.

use std::io::{self, BufReader, BufWriter, Write};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use super::error::{AnswerFault, GuestError};
use super::question::{ANSWER_HEADER, Question, Questions, is_silent, parse, read_line, write_all, write_answer};
use crate::case::Case;
use crate::sampling::Purpose;
use crate::trial::{Asked, CaseOutcome, Invitation, Settings, judge_answers};

/// Lines that may wait to be looked at.
const WAITING_LINES: usize = 4096;
/// How often it is looked whether a program has ended.
const GLANCE: Duration = Duration::from_millis(5);
/// How often it is asked whether to stop, while no answer comes.
const BETWEEN: Duration = Duration::from_millis(100);
/// Replicates by which a program that does not use its seeds is recognised.
const COMPARED: usize = 8;

/// A program that can answer what the irradiance is.
#[derive(Clone, Debug)]
pub struct Program {
    /// The program and its arguments.
    pub command: Vec<String>,
    /// How long it may be silent while an answer is due.
    pub timeout: Duration,
}

/// Asks a program for the estimates of a pilot, then of the judgement; each time it is started anew.
///
/// - `keep`: gets every answer that is judged, replicate by replicate, as a file that [`super::read_estimates`] reads. What came
///   before a fault is there
/// - `stop`: asked between answers; once it says so the program is ended, and there is no verdict
pub fn judge_program(
    case: &Case,
    settings: &Settings,
    invitation: &Invitation,
    program: &Program,
    keep: &mut dyn Write,
    stop: &dyn Fn() -> bool,
) -> Result<CaseOutcome, GuestError> {
    let kept = |result: io::Result<()>| result.map_err(|source| GuestError::Keep { source });
    kept(writeln!(keep, "{ANSWER_HEADER}"))?;
    // [cell][replicate][point] of the first replicates of the pilot.
    let mut pilot: Vec<Vec<Vec<f64>>> = Vec::new();
    let outcome = judge_answers(case, settings, invitation, &mut |purpose, asked, take| {
        let mut rows = vec![0_u64; asked.cells.len()];
        let mut repeated = vec![0_usize; asked.cells.len()];
        pilot.resize(asked.cells.len(), Vec::new());
        let answered = program.ask(asked, stop, &mut |cell, row| {
            let replicate = rows[cell];
            rows[cell] += 1;
            if purpose == Purpose::Pilot {
                if pilot[cell].len() < COMPARED {
                    pilot[cell].push(row.to_vec());
                }
            } else {
                let same = pilot[cell].get(replicate as usize).is_some_and(|before| before == row);
                repeated[cell] += usize::from(same);
                let samples = asked.cells[cell].samples;
                for (point, value) in row.iter().enumerate() {
                    let question = Question { point: point as u64, replicate, samples };
                    kept(write_answer(keep, &question, *value))?;
                }
            }
            take(cell, row);
            Ok(())
        });
        kept(keep.flush())?;
        answered?;
        for (cell, repeated) in repeated.iter().enumerate() {
            // A program without randomness gives the same for every replicate, and needs no seed.
            let varies = pilot[cell].windows(2).any(|pair| pair[0] != pair[1]);
            if varies && *repeated == COMPARED {
                let (program, samples) = (program.name(), asked.cells[cell].samples);
                return Err(GuestError::SeedsIgnored { program, samples, replicates: COMPARED });
            }
        }
        Ok(())
    })?;
    Ok(outcome)
}

/// Takes one replicate; may refuse it.
type Taken<'a> = dyn FnMut(usize, &[f64]) -> Result<(), GuestError> + 'a;

impl Program {
    fn name(&self) -> String {
        self.command.join(" ")
    }

    /// Asks all questions of one start.
    fn ask(&self, asked: &Asked, stop: &dyn Fn() -> bool, take: &mut Taken) -> Result<(), GuestError> {
        let mut running =
            Running::start(&self.command).map_err(|source| GuestError::Start { program: self.name(), source })?;
        let mut input = BufWriter::new(running.0.stdin.take().expect("it was asked for"));
        let output = BufReader::new(running.0.stdout.take().expect("it was asked for"));
        let (points, cells) = (asked.points.to_vec(), asked.cells.clone());
        // A program that reads no further has closed its end; what it answers is all that counts.
        thread::spawn(move || drop(write_all(&mut input, &points, &cells)));
        let lines = read_aside(output);
        let result = self.listen(asked, &lines, &mut running, stop, take);
        drop(running);
        result
    }

    fn listen(
        &self,
        asked: &Asked,
        lines: &Receiver<String>,
        running: &mut Running,
        stop: &dyn Fn() -> bool,
        take: &mut Taken,
    ) -> Result<(), GuestError> {
        let questions = Questions::new(&asked.cells, asked.points.len());
        let (count, program) = (questions.count(), || self.name());
        let seconds = self.timeout.as_secs_f64();
        let mut row = Vec::with_capacity(asked.points.len());
        let (mut answered, mut line) = (0, 0);
        loop {
            let next = questions.get(answered);
            let Some(received) = self.wait(lines, stop) else {
                return Err(GuestError::Stopped { program: program(), answered, asked: count });
            };
            match (received, next) {
                (Ok(text), next) => {
                    line += 1;
                    if is_silent(&text, line == 1) {
                        continue;
                    }
                    let fault = |fault| GuestError::Answer { program: program(), line, fault };
                    let (question, value) = parse(&text).map_err(fault)?;
                    let Some((cell, next)) = next else {
                        return Err(fault(match questions.place(&question) {
                            Ok(_) => AnswerFault::Twice { question },
                            Err(_) => AnswerFault::TooMany { asked: count },
                        }));
                    };
                    if question != next {
                        return Err(fault(match questions.place(&question) {
                            Err(not_asked) => not_asked,
                            Ok(place) if place < answered => AnswerFault::Twice { question },
                            Ok(_) => AnswerFault::OutOfOrder { question, next },
                        }));
                    }
                    row.push(value);
                    answered += 1;
                    if row.len() == asked.points.len() {
                        take(cell, &row)?;
                        row.clear();
                    }
                }
                (Err(RecvTimeoutError::Timeout), Some((_, next))) => {
                    return Err(GuestError::Silent { program: program(), seconds, answered, asked: count, next });
                }
                (Err(RecvTimeoutError::Timeout), None) => {
                    return Err(GuestError::DoesNotEnd { program: program(), seconds, asked: count });
                }
                (Err(RecvTimeoutError::Disconnected), next) => {
                    let Some(status) = running.end_within(self.timeout, stop) else {
                        return Err(GuestError::DoesNotEnd { program: program(), seconds, asked: count });
                    };
                    return match next {
                        _ if !status.success() => {
                            Err(GuestError::Died { program: program(), status, answered, asked: count })
                        }
                        Some((_, next)) => {
                            Err(GuestError::TooFew { program: program(), answered, asked: count, next })
                        }
                        None => Ok(()),
                    };
                }
            }
        }
    }

    /// The next line, or why none came; `None` where nobody wants it any more.
    fn wait(&self, lines: &Receiver<String>, stop: &dyn Fn() -> bool) -> Option<Result<String, RecvTimeoutError>> {
        let mut left = self.timeout;
        while !stop() {
            let part = left.min(BETWEEN);
            match lines.recv_timeout(part) {
                Err(RecvTimeoutError::Timeout) if part < left => left -= part,
                received => return Some(received),
            }
        }
        None
    }
}

/// Reads lines on a thread of its own, which ends with what it reads from.
fn read_aside(mut output: BufReader<std::process::ChildStdout>) -> Receiver<String> {
    let (send, receive) = sync_channel(WAITING_LINES);
    thread::spawn(move || {
        while let Ok(Some(line)) = read_line(&mut output) {
            if send.send(line).is_err() {
                return;
            }
        }
    });
    receive
}

/// A program that is ended when nobody listens any more.
struct Running(Child);

impl Running {
    fn start(command: &[String]) -> io::Result<Running> {
        let Some((program, arguments)) = command.split_first() else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "no program is named"));
        };
        let mut command = Command::new(program);
        command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit());
        Ok(Running(command.spawn()?))
    }

    fn end_within(&mut self, timeout: Duration, stop: &dyn Fn() -> bool) -> Option<ExitStatus> {
        let mut waited = Duration::ZERO;
        loop {
            if let Ok(Some(status)) = self.0.try_wait() {
                return Some(status);
            }
            if waited >= timeout || stop() {
                return None;
            }
            thread::sleep(GLANCE);
            waited += GLANCE;
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already; then there is nothing to do.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
