//! Three verdicts, not two.

use std::fmt;

/// What a test with stated error rates concludes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Verdict {
    /// No evidence against the statement, and a deviation that matters would have been caught.
    Pass,
    /// Evidence against the statement beyond the fixed threshold.
    Fail,
    /// No evidence against it, but too little data to have caught a deviation that matters.
    Undecided,
}

impl Verdict {
    /// The name that reports use.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::Fail => "fail",
            Verdict::Undecided => "undecided",
        }
    }

    /// The verdict that reports call so.
    pub fn from_name(name: &str) -> Option<Verdict> {
        [Verdict::Pass, Verdict::Fail, Verdict::Undecided].into_iter().find(|verdict| verdict.name() == name)
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
