//! The command line: words in, an exit code out. No arithmetic on results.

/// Says a line on standard error, in one piece. Where it cannot be said (the log lies on the disk that is full), the exit code
/// still tells.
macro_rules! say {
    ($($said:tt)*) => {{
        use std::io::Write as _;
        let _ = anstream::stderr().write_all((format!($($said)*) + "\n").as_bytes());
    }};
}

mod cluster;
mod commands;
mod compare;
mod conclude;
mod explain;
mod guests;
mod help;
mod images;
mod interrupt;
mod merge;
mod new;
mod options;
mod progress;
#[cfg(feature = "plots")]
mod render;
mod run;
mod share;
mod standing;
mod watch;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

use clap::Parser;

/// Exit codes: a contract that schedulers and scripts rely on.
mod exit {
    /// Every verdict passed.
    pub const PASSED: u8 = 0;
    /// A verdict failed.
    pub const FAILED: u8 = 1;
    /// The command line is wrong, or a case or a file that it names.
    pub const USAGE: u8 = 2;
    /// None failed, some are undecided.
    pub const UNDECIDED: u8 = 3;
    /// Nothing was selected.
    pub const NOTHING: u8 = 4;
    /// An output could not be written, or an image or a report not read.
    pub const OUTPUT: u8 = 5;
    /// Shards are missing, damaged or foreign.
    pub const SHARDS: u8 = 6;
    /// A fault of this program.
    pub const BUG: u8 = 70;
    /// Nothing is wrong that time will not mend.
    pub const AGAIN: u8 = 75;
    /// Ended by Ctrl-C: what was finished is kept.
    pub const INTERRUPTED: u8 = 130;
}

/// Parses the command line, does what it says, and returns the exit code.
pub fn main() -> ExitCode {
    ExitCode::from(or_bug(|| obey(options::Options::parse())))
}

/// What a command comes to. A panic is a fault of this program, and is told as one.
fn or_bug(command: impl FnOnce() -> u8) -> u8 {
    // Nothing of the command is used afterwards.
    catch_unwind(AssertUnwindSafe(command)).unwrap_or_else(|_| {
        let version = env!("CARGO_PKG_VERSION");
        say!("error: this is a bug of etendue {version}: please report the command and the lines above");
        exit::BUG
    })
}

fn obey(options: options::Options) -> u8 {
    match options.command {
        Some(options::Command::List(list)) => commands::list(&list),
        Some(options::Command::Check(check)) => commands::check(&check),
        Some(options::Command::Exact(exact)) => commands::exact(&exact),
        Some(options::Command::Calibrate(calibrate)) => commands::calibrate(&calibrate),
        Some(options::Command::Plan(plan)) => commands::plan(&plan),
        Some(options::Command::Merge(merge)) => merge::merge(&merge),
        Some(options::Command::Report(report)) => commands::report(&report),
        Some(options::Command::Growth(growth)) => commands::growth(&growth),
        Some(options::Command::Explain(explain)) => commands::explain(&explain),
        Some(options::Command::Compare(compare)) => compare::compare(&compare),
        Some(options::Command::Judge(judge)) => guests::judge(&judge),
        Some(options::Command::Verify(verify)) => guests::verify(&verify),
        Some(options::Command::Export(export)) => images::export(&export),
        Some(options::Command::Points(points)) => guests::points(&points),
        #[cfg(feature = "plots")]
        Some(options::Command::Render(render)) => render::render(&render),
        Some(options::Command::New(new)) => new::new(&new),
        Some(options::Command::Completions(completions)) => help::completions(&completions),
        Some(options::Command::Schema) => help::schema(),
        Some(options::Command::Man(man)) => help::man(&man),
        Some(options::Command::Run(run)) => run::run(&run),
        None => run::run(&options.run),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_as_a_bug() {
        assert_eq!(or_bug(|| exit::UNDECIDED), exit::UNDECIDED);
        assert_eq!(or_bug(|| panic!("in the main thread")), exit::BUG);
        // What other threads panic with comes here, too.
        assert_eq!(or_bug(|| rayon::join(|| exit::PASSED, || panic!("in another")).0), exit::BUG);
    }
}
