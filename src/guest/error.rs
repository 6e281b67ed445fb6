//! What can be wrong with what others answer.

use std::io;
use std::path::PathBuf;
use std::process::ExitStatus;

use thiserror::Error;

use super::question::Question;
use crate::trial::NotJudged;

/// What is wrong with one line of answers.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AnswerFault {
    #[error("`{said}` is no answer ({why}); accepted: point,replicate,samples,value, such as `0,0,16,0.125`")]
    Garbage { said: String, why: &'static str },
    #[error("the answer to {question} is {value}; a finite number is accepted")]
    NotFinite { question: Question, value: f64 },
    #[error("{question} is answered a second time")]
    Twice { question: Question },
    #[error("{question} is answered out of order: next was {next}; answers come in the order of the questions")]
    OutOfOrder { question: Question, next: Question },
    #[error("{question} was not asked: {why}")]
    NotAsked { question: Question, why: String },
    #[error("there are more answers than the {asked} questions")]
    TooMany { asked: u64 },
}

/// Why a guest from outside gets no verdict.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GuestError {
    #[error(transparent)]
    NotJudged(#[from] NotJudged),
    #[error("`{program}` cannot be started: {source}")]
    Start { program: String, source: io::Error },
    /// A line of its output.
    #[error("`{program}`, line {line} of its output: {fault}")]
    Answer { program: String, line: u64, fault: AnswerFault },
    #[error(
        "`{program}` hangs: nothing came for {seconds} s after {answered} of {asked} answers; next was {next}. It was ended. (A program that needs longer: --timeout; one that keeps its answers until its input ends is fine)"
    )]
    Silent { program: String, seconds: f64, answered: u64, asked: u64, next: Question },
    #[error(
        "`{program}` does not end: it has answered all {asked} questions, its input is closed, and {seconds} s went by. It was ended"
    )]
    DoesNotEnd { program: String, seconds: f64, asked: u64 },
    #[error("`{program}` died ({status}) after {answered} of {asked} answers")]
    Died { program: String, status: ExitStatus, answered: u64, asked: u64 },
    #[error("`{program}` answered too little: it ended after {answered} of {asked} answers; next was {next}")]
    TooFew { program: String, answered: u64, asked: u64, next: Question },
    #[error(
        "`{program}` does not use the seeds: with other seeds it gave the very estimates of the pilot again (N = {samples}, the first {replicates} replicates), so they are no new evidence"
    )]
    SeedsIgnored { program: String, samples: u64, replicates: usize },
    #[error("{}: {source}", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    /// A line of a file.
    #[error("{}:{line}: {fault}", path.display())]
    Line { path: PathBuf, line: u64, fault: AnswerFault },
    #[error("{}: {question} has no answer{others}; every replicate has one for each point", path.display(),
        others = if *others > 0 { format!(" ({others} more replicates lack some)") } else { String::new() })]
    Incomplete { path: PathBuf, question: Question, others: u64 },
    #[error("{}: there is no estimate in it; accepted: lines of point,replicate,samples,value", path.display())]
    Empty { path: PathBuf },
    #[error("{}: there are more than {limit} {what} in it, the most that are held in memory", path.display())]
    TooLarge { path: PathBuf, what: &'static str, limit: u64 },
    #[error("{}: {what}; accepted: a CSV of estimates (point,replicate,samples,value)", path.display())]
    Foreign { path: PathBuf, what: &'static str },
    /// Whoever asked wanted no more.
    #[error("`{program}` was ended after {answered} of {asked} answers")]
    Stopped { program: String, answered: u64, asked: u64 },
    #[error("what was answered cannot be kept: {source}")]
    Keep { source: io::Error },
}
