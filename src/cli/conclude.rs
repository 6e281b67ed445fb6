//! What is told of a run on standard output, and the exit code that its verdicts come to.

use std::collections::BTreeMap;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use super::commands::{fault, print};
use super::exit;
use super::options::{Format, Telling};
use crate::report::{self, TableOptions};
use crate::statistics::Verdict;
use crate::trial::{CaseOutcome, RunOutcome};

/// Verdicts as JSON Lines: those of a case as soon as it is done and all before it are. So the bytes are the same in
/// whatever order the cases end.
#[derive(Default)]
pub(super) struct Lines(Mutex<State>);

#[derive(Default)]
struct State {
    /// Of the cases, counted in their order: the first that is not done.
    next: usize,
    /// Those that are done before it is.
    waiting: BTreeMap<usize, String>,
    /// Whether nobody reads any more.
    unread: bool,
    fault: Option<u8>,
}

impl Lines {
    /// One more case is done.
    ///
    /// - `index`: its place among the cases
    /// - `outcome`: `None` where there is nothing to tell of it
    pub fn done(&self, index: usize, outcome: Option<&CaseOutcome>) {
        let text = outcome.map(report::case_json_lines).unwrap_or_default();
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.waiting.insert(index, text);
        loop {
            let next = state.next;
            let Some(text) = state.waiting.remove(&next) else { return };
            state.put(&text);
            state.next += 1;
        }
    }

    /// Those that are done behind one that is not, and the summary.
    fn finish(self, outcome: &RunOutcome, folder: &str) -> Result<(), u8> {
        let mut state = self.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        for text in std::mem::take(&mut state.waiting).into_values() {
            state.put(&text);
        }
        state.put(&report::summary_json_line(outcome, Some(folder)));
        state.fault.map_or(Ok(()), Err)
    }
}

impl State {
    /// Writes at once. A reader that has seen enough (`| head`) is no fault, and the run goes on to its report.
    fn put(&mut self, text: &str) {
        if self.unread || self.fault.is_some() {
            return;
        }
        let mut out = std::io::stdout().lock();
        if let Err(error) = out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
            match error.kind() {
                ErrorKind::BrokenPipe => self.unread = true,
                _ => self.fault = Some(fault(exit::OUTPUT, format!("standard output cannot be written: {error}"))),
            }
        }
    }
}

/// The verdicts on stdout, and wherever else they are to be told; and the code that they come to.
///
/// - `lines`: those that were told before, where verdicts are told as JSON Lines
pub(super) fn conclude(
    outcome: &RunOutcome,
    out: &Path,
    telling: &Telling,
    lines: Option<Lines>,
    quiet: bool,
    allow_undecided: bool,
) -> Result<u8, u8> {
    if let Some(path) = &telling.junit {
        std::fs::write(path, report::verdicts_junit(outcome, allow_undecided))
            .map_err(|error| fault(exit::OUTPUT, format!("cannot write {}: {error}", path.display())))?;
    }
    let folder = out.to_string_lossy();
    match telling.format {
        Format::Text => {
            let styled = anstream::AutoStream::choice(&std::io::stdout()) != anstream::ColorChoice::Never;
            let layout = TableOptions { styled, width: terminal_width(), report: Some(out), quiet };
            print(&report::table(outcome, &layout))?;
        }
        Format::Json => print(&report::verdicts_json(outcome, Some(&folder)))?,
        Format::Jsonl => {
            let all = || {
                let lines = Lines::default();
                outcome.cases.iter().enumerate().for_each(|(index, case)| lines.done(index, Some(case)));
                lines
            };
            lines.unwrap_or_else(all).finish(outcome, &folder)?;
        }
    }
    Ok(code(outcome, allow_undecided))
}

/// What the verdicts come to.
fn code(outcome: &RunOutcome, allow_undecided: bool) -> u8 {
    let verdicts = || outcome.cases.iter().flat_map(|case| case.verdicts().map(|(_, judged)| judged));
    let any = |verdict| verdicts().any(|judged| judged.verdict == verdict);
    if any(Verdict::Fail) {
        exit::FAILED
    } else if any(Verdict::Undecided) && !allow_undecided {
        exit::UNDECIDED
    } else {
        exit::PASSED
    }
}

/// Columns of the terminal, or enough for any table in a log.
fn terminal_width() -> usize {
    let asked = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    asked.unwrap_or(if std::io::stdout().is_terminal() { 100 } else { 120 })
}
