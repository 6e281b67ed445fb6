//! `etendue plan --for slurm`: the scripts of a run in many shards.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::commands::{fault, print};
use super::exit;
use super::options::Plan;
use crate::case::Reach;
use crate::trial::{Bill, ShardCost, quoted};

/// What a run in shards can be written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Engine {
    // An array job, and a job that merges. (Words for readers would give every option of `plan` a paragraph.)
    Slurm,
}

/// A task may take so many times what it should, and a minute, before it is ended; and use so many times the memory.
const PATIENCE: f64 = 4.0;
const SPARE_MEMORY: u64 = 3;
/// Names of the files.
const SHARDS: &str = "shards.sbatch";
const MERGE: &str = "merge.sbatch";
const SUBMIT: &str = "submit.sh";

/// Writes the scripts, and says what they will do.
pub(super) fn write(options: &Plan, bill: &Bill, of: u32, out: &Path) -> Result<u8, u8> {
    let scripts = Scripts::new(options, bill, of, out)?;
    let failed = |path: &Path, error| fault(exit::OUTPUT, format!("cannot write {}: {error}", path.display()));
    for folder in [&scripts.out, &scripts.out.join("logs"), &scripts.out.join("parts")] {
        fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
    }
    for (name, text) in [(SHARDS, scripts.shards()), (MERGE, scripts.merge()), (SUBMIT, scripts.submit())] {
        let path = scripts.out.join(name);
        fs::write(&path, text).and_then(|()| executable(&path)).map_err(|error| failed(&path, error))?;
    }
    print(&scripts.told(out))?;
    Ok(exit::PASSED)
}

#[cfg(unix)]
fn executable(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn executable(_: &Path) -> std::io::Result<()> {
    Ok(())
}

struct Scripts {
    /// Absolute: jobs start wherever they were sent from.
    out: PathBuf,
    program: PathBuf,
    folder: PathBuf,
    /// The run's own command, after the program's name.
    command: String,
    reach: Reach,
    of: u32,
    costs: Vec<ShardCost>,
    /// Processor seconds in all, and of one that merges.
    seconds: f64,
    merge_seconds: f64,
    megabytes: u64,
}

impl Scripts {
    fn new(options: &Plan, bill: &Bill, of: u32, out: &Path) -> Result<Scripts, u8> {
        let here = |error| fault(exit::OUTPUT, format!("this folder cannot be named: {error}"));
        let command = options.work.command();
        let command = command.strip_prefix("etendue ").unwrap_or(&command).to_owned();
        let cases = bill.exact_seconds.len() as f64;
        Ok(Scripts {
            out: std::path::absolute(out).map_err(here)?,
            program: std::env::current_exe().map_err(here)?,
            folder: std::env::current_dir().map_err(here)?,
            command,
            reach: options.work.reaching.reach(),
            of,
            costs: bill.shards(of),
            seconds: bill.seconds(),
            // A case's plots and page, and a shard's file.
            merge_seconds: 5.0 + cases * 0.2 + f64::from(of) * 0.01,
            megabytes: bill.bytes.div_ceil(1 << 20),
        })
    }

    fn longest(&self) -> f64 {
        self.costs.iter().map(|cost| cost.seconds).fold(0.0, f64::max)
    }

    /// What every script begins with.
    fn head(&self, name: &str, what: &str, more: &str, seconds: f64) -> String {
        let logs = self.out.join("logs");
        let mut text = format!("#!/bin/sh\n# {what}\n#\n");
        let _ = writeln!(text, "#   etendue {}\n#", self.command);
        let _ = writeln!(text, "#SBATCH --job-name={name}");
        text.push_str(more);
        let _ = writeln!(text, "#SBATCH --ntasks=1\n#SBATCH --cpus-per-task=1\n#SBATCH --time={}", limit(seconds));
        let _ = writeln!(text, "#SBATCH --mem={}M", (SPARE_MEMORY * self.megabytes).max(256));
        text.push_str("#SBATCH --requeue\n#SBATCH --open-mode=append\n");
        let number = if name == "etendue" { "shard-%a" } else { "merge" };
        let _ = writeln!(text, "#SBATCH --output=\"{}\"", logs.join(format!("{number}.txt")).display());
        text.push_str(
            "\n# Set these in the environment of sbatch, not by --export: with a list of names there, Slurm starts a login shell\n\
             # before each task.\n",
        );
        let set = |name: &str, value: &Path| format!(": \"${{{name}:={}}}\"\n", inside(&value.to_string_lossy()));
        text.push_str(&set("ETENDUE", &self.program));
        text.push_str(&set("PARTS", &self.out.join("parts")));
        if name != "etendue" {
            text.push_str(&set("REPORT", &self.out.join("report")));
        }
        let _ = writeln!(text, "\ncd {} || exit 5", quoted(&self.folder.to_string_lossy()));
        text
    }

    fn shards(&self) -> String {
        let what = format!(
            "One of {} shards of a run. A task that fails, or is lost with its node, can be sent again at any time:\n\
             # `sbatch --array=3,17-19 {SHARDS}` (merging names them). The number of shards stays what it is.",
            self.of
        );
        let array = format!("#SBATCH --array=0-{}\n", self.of - 1);
        let mut text = self.head("etendue", &what, &array, self.longest());
        let _ = writeln!(
            text,
            "exec \"$ETENDUE\" {} --shard \"$SLURM_ARRAY_TASK_ID/{}\" --resume --out \"$PARTS\" \\\n    \
             --threads \"${{SLURM_CPUS_PER_TASK:-1}}\" --quiet --progress never",
            self.command, self.of
        );
        text
    }

    fn merge(&self) -> String {
        let what = "Puts the shards of a run together; says what is missing, damaged or of another run, and what to send again:";
        let mut text = self.head("etendue-merge", what, "", self.merge_seconds);
        let reach = self.reach.words();
        let _ =
            writeln!(text, "exec \"$ETENDUE\" merge \"$PARTS\" --out \"$REPORT\"{reach} --quiet --progress never");
        text
    }

    fn submit(&self) -> String {
        format!(
            "#!/bin/sh\n\
             # Sends the shards of a run, and after them, however they end, the job that merges. What is said here is passed on to\n\
             # sbatch: `{SUBMIT} --array=3,17-19` sends some again, `{SUBMIT} --partition=short` all.\n\
             set -eu\n\
             here=$(cd \"$(dirname \"$0\")\" && pwd)\n\
             shards=$(sbatch --parsable \"$@\" \"$here/{SHARDS}\")\n\
             # Of several clusters the name follows the number.\n\
             merge=$(sbatch --parsable --dependency=afterany:\"${{shards%%;*}}\" \"$here/{MERGE}\")\n\
             echo \"shards: job $shards; merging: job $merge, which tells in $here/logs/merge.txt\"\n"
        )
    }

    fn told(&self, out: &Path) -> String {
        let units: u64 = self.costs.iter().map(|cost| cost.units).sum();
        let all: f64 = self.costs.iter().map(|cost| cost.seconds).sum();
        let empty = self.costs.iter().filter(|cost| cost.units == 0).count();
        let mut text = format!(
            "{units} units of work in {} shards, {:.1} s of processor time ({:.1} s in one piece: the exact side of a case is found \
             by every shard that has some of it); the longest shard {:.1} s, memory {} MiB\n",
            self.of,
            all,
            self.seconds,
            self.longest(),
            self.megabytes
        );
        if empty > 0 {
            let _ = writeln!(text, "{empty} shards have nothing to do: fewer would do as well");
        }
        let _ = writeln!(
            text,
            "what sends them: {}   (a task is ended after {}, a merge after {})",
            out.join(SUBMIT).display(),
            limit(self.longest()),
            limit(self.merge_seconds)
        );
        text
    }
}

/// Text between double quotes in a shell.
fn inside(text: &str) -> String {
    text.chars().flat_map(|c| if "\"\\$`}".contains(c) { vec!['\\', c] } else { vec![c] }).collect()
}

/// A limit of time as Slurm takes it: hours, minutes, seconds.
fn limit(seconds: f64) -> String {
    let minutes = (PATIENCE * seconds / 60.0 + 1.0).ceil().min(1e6) as u64;
    format!("{:02}:{:02}:00", minutes / 60, minutes % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_generous_and_whole_minutes() {
        assert_eq!(limit(0.0), "00:01:00");
        assert_eq!(limit(14.0), "00:02:00");
        assert_eq!(limit(3600.0), "04:01:00");
        assert_eq!(limit(1e6), "1111:08:00".replace("1111:08", &format!("{}:{:02}", 66668 / 60, 66668 % 60)));
    }

    #[test]
    fn what_a_shell_would_take_for_its_own_is_quoted() {
        assert_eq!(inside("/a b/$c`d}"), "/a b/\\$c\\`d\\}");
    }
}
