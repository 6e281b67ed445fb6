//! Long runs as their user meets them: what Ctrl-C leaves, verdicts that come as cases end, progress in a log, and cases that
//! are run anew as their files change.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Whatever is waited for has come by then, on a busy machine too.
const LONG: Duration = Duration::from_secs(120);

const DISK: &str = r#"
[[source.disk]]
center = [0.0, 0.0, 2.0]
normal = [0.0, 0.0, -1.0]
radius = 0.5
exitance = 1.0
[[measure.point]]
position = [0.1, 0.2, 0.0]
normal = [0.0, 0.0, 1.0]
[study]
"#;

/// A tenth of a second.
const SHORT_STUDY: &str = "samples = [16]\nreplicates = 1000\n";
/// Hours.
const LONG_STUDY: &str = "samples = [1024]\nreplicates = 1000000000\n";

/// What an unfinished run leaves.
pub(crate) const CHECKPOINT: &str = "checkpoint.units";

fn write(folder: &Path, name: &str, study: &str) {
    std::fs::write(folder.join(name), format!("title = \"{name}\"\n{DISK}{study}")).expect("a file");
}

pub(crate) fn etendue(folder: &Path, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_etendue"));
    command.current_dir(folder).args(words).env_remove("COLUMNS").env_remove("CLICOLOR_FORCE");
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A program that is ended with the test, however that ends.
pub(crate) struct Running(Option<Child>);

impl Running {
    pub(crate) fn start(folder: &Path, words: &[&str]) -> Running {
        Running(Some(etendue(folder, words).spawn().expect("the program")))
    }

    pub(crate) fn child(&mut self) -> &mut Child {
        self.0.as_mut().expect("it runs")
    }

    fn lines(&mut self) -> BufReader<std::process::ChildStdout> {
        BufReader::new(self.child().stdout.take().expect("a pipe"))
    }

    pub(crate) fn interrupt(&mut self) {
        let id = self.child().id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill").success());
    }

    pub(crate) fn ended(mut self) -> Output {
        let begun = Instant::now();
        while self.child().try_wait().expect("a state").is_none() {
            assert!(begun.elapsed() < LONG, "it does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
        self.0.take().expect("it ran").wait_with_output().expect("an end")
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("words")
}

pub(crate) fn read(path: PathBuf) -> String {
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Every file in a folder and below.
pub(crate) fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn an_interrupted_run_keeps_whole_cases_as_if_they_had_been_run_alone() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "short.toml", SHORT_STUDY);
    write(folder.path(), "endless.toml", LONG_STUDY);
    let words = ["run", "short.toml", "endless.toml", "--format", "jsonl", "--threads", "2", "--out", "cut"];
    let mut running = Running::start(folder.path(), &words);
    // A case's verdicts are there while another one is still under way.
    let mut lines = running.lines().lines().map(Result::unwrap);
    let first: Vec<Value> = (0..6).map(|_| serde_json::from_str(&lines.next().unwrap()).unwrap()).collect();
    assert!(first.iter().all(|line| line["case"] == "short" && line["type"] == "verdict"), "{first:?}");
    running.interrupt();
    let summary: Value = serde_json::from_str(&lines.next().unwrap()).unwrap();
    assert_eq!((&summary["type"], &summary["missing"]), (&"summary".into(), &serde_json::json!(["endless"])));
    assert_eq!(lines.next(), None);
    let ended = running.ended();
    assert_eq!(ended.status.code(), Some(130));
    let said = text(&ended.stderr);
    assert_eq!(said.lines().count(), 1, "{said}");
    for word in [
        "interrupted: 1 of 2 cases",
        "report: cut;",
        "missing: endless;",
        "what goes on: etendue run short.toml endless.toml --seed 1 --out cut --resume",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    // As a run of that case alone.
    let alone =
        etendue(folder.path(), &["run", "short.toml", "--out", "alone", "--allow-undecided"]).output().unwrap();
    assert_eq!(alone.status.code(), Some(0));
    for table in ["verdicts", "convergence", "rates", "correlation"] {
        let of = |report: &str| read(folder.path().join(report).join(format!("{table}.csv")));
        assert_eq!(of("cut"), of("alone"), "{table}");
    }
    assert_eq!(read(folder.path().join("cut/verdicts.csv")).lines().count(), 1 + 6);
    let whole = |report: &str| {
        let names = files(&folder.path().join(report)).into_iter();
        let mut names: Vec<String> =
            names.map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect();
        names.sort();
        names
    };
    let (mut cut, alone) = (whole("cut"), whole("alone"));
    cut.retain(|name| name != CHECKPOINT);
    assert_eq!(cut, alone, "plots and all, nothing half-written");
    assert!(folder.path().join("cut").join(CHECKPOINT).is_file());
    let manifest = |report: &str| {
        serde_json::from_str::<Value>(&read(folder.path().join(report).join("manifest.json"))).unwrap()
    };
    assert_eq!(manifest("cut")["interrupted"]["missing"], serde_json::json!(["endless"]));
    assert_eq!(manifest("cut")["cases"], manifest("alone")["cases"]);
    assert!(manifest("alone").get("interrupted").is_none());
}

#[test]
fn where_nothing_is_finished_no_report_is_left() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "endless.toml", LONG_STUDY);
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("verdicts.csv"), "of an earlier run").unwrap();
    let mut running = Running::start(folder.path(), &["run", "endless.toml", "--out", "out"]);
    // What an earlier run left is swept away before the work begins.
    until(|| !out.join("verdicts.csv").exists());
    running.interrupt();
    let begun = Instant::now();
    let ended = running.ended();
    assert!(begun.elapsed() < Duration::from_secs(20), "given up between units of work: {:?}", begun.elapsed());
    assert_eq!((ended.status.code(), text(&ended.stdout)), (Some(130), String::new()));
    assert!(text(&ended.stderr).contains("no report was written"), "{}", text(&ended.stderr));
    assert_eq!(files(&out), [out.join(CHECKPOINT)], "what goes on from there");
}

#[test]
fn a_second_interruption_ends_at_once() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "short.toml", SHORT_STUDY);
    // One estimate is one unit of work, and two thousand million samples take a while.
    write(folder.path(), "one-unit.toml", "samples = [2147483648]\nreplicates = 2\nstrategies = [\"random\"]\n");
    let words = ["run", "short.toml", "one-unit.toml", "--threads", "1", "--format", "jsonl", "--out", "out"];
    let mut running = Running::start(folder.path(), &words);
    // One case after the other: the second begins when the first has been told.
    let mut lines = running.lines().lines().map(Result::unwrap);
    assert_eq!(lines.by_ref().take(6).count(), 6);
    std::thread::sleep(Duration::from_secs(1));
    running.interrupt();
    std::thread::sleep(Duration::from_secs(1));
    assert!(running.child().try_wait().unwrap().is_none(), "the first waits for the unit's end");
    running.interrupt();
    let begun = Instant::now();
    assert_eq!(lines.next(), None);
    let ended = running.ended();
    assert!(begun.elapsed() < Duration::from_secs(2), "{:?}", begun.elapsed());
    assert_eq!((ended.status.code(), text(&ended.stderr)), (Some(130), String::new()));
    let out = folder.path().join("out");
    let left = files(&out);
    // Of the lock only a name is left.
    assert!(left.iter().all(|path| [out.join(CHECKPOINT), out.join(".lock")].contains(path)), "{left:?}");
}

#[test]
fn a_program_that_is_judged_ends_with_its_judge() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "room.toml", SHORT_STUDY);
    // Answers the pilot and the first half of what is judged, then says no more.
    let program = r#"
answer() { awk -F, -v n=$1 'NR > 1 && NR <= n + 1 { print $1 "," $9 "," $8 "," 0.1 + 0.001 * ($9 % 7) }'; }
if [ ! -e asked ]; then touch asked; answer 1000000; else answer 160; touch half; exec sleep 1000; fi"#;
    let words = ["judge", "room.toml", "--replicates", "320", "--out", "out", "--", "sh", "-c", program];
    let mut running = Running::start(folder.path(), &words);
    until(|| folder.path().join("half").exists());
    std::thread::sleep(Duration::from_millis(300));
    running.interrupt();
    let ended = running.ended();
    let said = text(&ended.stderr);
    assert_eq!((ended.status.code(), text(&ended.stdout)), (Some(130), String::new()), "{said}");
    assert!(said.starts_with("interrupted: ") && said.contains("answers, in whole replicates, are kept"), "{said}");
    let kept = read(folder.path().join("out/estimates.csv"));
    assert!(kept.ends_with('\n') && kept.lines().skip(1).all(|line| line.split(',').count() == 4), "{kept}");
    assert!(!folder.path().join("out/manifest.json").exists());
}

pub(crate) fn until(mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < LONG, "it does not come to that");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn lines_are_the_same_bytes_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    // The first is the longest, so that others are done before it.
    write(folder.path(), "a.toml", "samples = [64]\nreplicates = 30000\n");
    for name in ["b", "c", "d"] {
        write(folder.path(), &format!("{name}.toml"), SHORT_STUDY);
    }
    let said = |threads: &str| {
        let words = [
            "run",
            ".",
            "--format",
            "jsonl",
            "--no-plots",
            "--allow-undecided",
            "--threads",
            threads,
            "--out",
            "out",
        ];
        let output = etendue(folder.path(), &words).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let one = said("1");
    let cases = one.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()["case"].clone());
    let mut cases: Vec<Value> = cases.collect();
    assert_eq!(cases.pop(), Some(Value::Null), "a summary comes last");
    assert!(cases.len() == 24 && cases.is_sorted_by_key(|case| case.as_str()), "{cases:?}");
    assert_eq!(said("4"), one);
}

#[test]
fn a_reader_of_lines_that_has_seen_enough_is_no_fault() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "a.toml", SHORT_STUDY);
    write(folder.path(), "b.toml", SHORT_STUDY);
    let words = ["run", ".", "--format", "jsonl", "--no-plots", "--allow-undecided", "--out", "out"];
    let mut running = Running::start(folder.path(), &words);
    drop(running.lines());
    let ended = running.ended();
    assert_eq!((ended.status.code(), text(&ended.stderr)), (Some(0), String::new()));
    assert!(folder.path().join("out/manifest.json").exists(), "the run goes on to its report");
}

#[test]
fn progress_in_a_log_is_plain_or_nothing() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "a.toml", SHORT_STUDY);
    let said = |more: &[&str]| {
        let words = [&["run", "a.toml", "--no-plots", "--allow-undecided", "--out", "out"], more].concat();
        let output = etendue(folder.path(), &words).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stderr)
    };
    let plain = said(&["--progress", "plain"]);
    assert!(plain.starts_with("1/1 cases, 4.8e4 rays, ") && plain.contains(" rays/s, in "), "{plain}");
    assert!(plain.ends_with('\n') && !plain.trim_end().contains(char::is_control), "{plain:?}");
    for none in [&[][..], &["--progress", "auto"], &["--progress", "never"], &["--progress", "plain", "--quiet"]] {
        assert_eq!(said(none), "", "{none:?}");
    }
}

/// A terminal of that width, by the tool that records terminals; `None` where it is not there.
fn on_a_terminal(folder: &Path, columns: usize, variables: &str, words: &str) -> Option<String> {
    let program = env!("CARGO_BIN_EXE_etendue");
    let command = format!("stty rows 24 cols {columns} < /dev/tty; {variables} {program} {words} > /dev/null");
    let mut script = Command::new("script");
    script.args(["-q", "-e", "-c", &command, "/dev/null"]).current_dir(folder).env_remove("COLUMNS");
    let output = script.stdin(Stdio::null()).output().ok()?;
    output.status.success().then(|| text(&output.stdout))
}

#[test]
fn a_bar_never_wraps_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a-case-with-a-long-name.toml", "b.toml", "c.toml"] {
        write(folder.path(), name, "samples = [64]\nreplicates = 30000\n");
    }
    let words = "run . --no-plots --allow-undecided --out out";
    for columns in [20, 40, 60, 120] {
        let Some(said) = on_a_terminal(folder.path(), columns, "env -u TERM", words) else { return };
        let drawn: Vec<&str> = said.split('\r').collect();
        assert!(said.contains('%') && !said.contains(['\x1b', '\n']), "{said:?}");
        assert!(drawn.iter().all(|line| line.chars().count() < columns), "{columns}: {drawn:?}");
        let last = drawn.iter().rev().find(|line| !line.is_empty());
        assert!(last.is_some_and(|line| line.trim().is_empty()) && said.ends_with('\r'), "{drawn:?}");
    }
    let dumb = on_a_terminal(folder.path(), 80, "TERM=dumb", words).unwrap_or_default();
    assert!(dumb.starts_with("3/3 cases, ") && dumb.lines().count() == 1, "{dumb:?}");
}

#[test]
fn what_is_part_of_the_program_cannot_be_watched() {
    let folder = tempfile::tempdir().unwrap();
    for words in [&["run", "--watch"][..], &["run", "penumbra/eclipse", "--watch"]] {
        let output = etendue(folder.path(), words).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let said = text(&output.stderr);
        assert!(said.contains("part of the program") && said.contains("give a case file or a folder"), "{said}");
    }
    let output = etendue(folder.path(), &["run", "eclipze", "--watch"]).output().unwrap();
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
}

/// Reads aside what a program says, so that it can be waited for.
struct Heard(std::sync::Arc<std::sync::Mutex<String>>);

impl Heard {
    fn of(mut from: impl Read + Send + 'static) -> Heard {
        let heard = Heard(std::sync::Arc::default());
        let text = heard.0.clone();
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(n @ 1..) = from.read(&mut bytes) {
                text.lock().unwrap().push_str(&String::from_utf8_lossy(&bytes[..n]));
            }
        });
        heard
    }

    fn text(&self) -> String {
        self.0.lock().unwrap().clone()
    }

    /// Waits until it was said that often in all.
    fn until(&self, said: &str, times: usize) {
        let begun = Instant::now();
        while self.text().matches(said).count() < times {
            assert!(begun.elapsed() < LONG, "`{said}` was not said {times} times:\n{}", self.text());
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

#[test]
fn a_watched_case_is_run_anew_when_its_file_changes() {
    let folder = tempfile::tempdir().unwrap();
    let rooms = folder.path().join("rooms");
    std::fs::create_dir(&rooms).unwrap();
    write(&rooms, "a.toml", SHORT_STUDY);
    write(&rooms, "b.toml", SHORT_STUDY);
    let words = ["run", "rooms", "--watch", "--no-plots", "--allow-undecided", "--out", "out"];
    let mut running = Running::start(folder.path(), &words);
    let out = Heard::of(running.child().stdout.take().unwrap());
    let errors = Heard::of(running.child().stderr.take().unwrap());
    let waiting = "waiting for a change";
    errors.until("running 2 of 2: a, b", 1);
    errors.until(waiting, 1);
    out.until("12 verdicts", 1);
    let verdicts = || read(folder.path().join("out/verdicts.csv"));
    let first = verdicts();
    // As editors save: into a file beside it, which then takes its place. Only that case is run.
    write(&rooms, ".a.toml.swp", "samples = [4]\nreplicates = 1000\n");
    std::fs::rename(rooms.join(".a.toml.swp"), rooms.join("a.toml")).unwrap();
    errors.until("running 1 of 2: a", 1);
    errors.until(waiting, 2);
    out.until("12 verdicts", 2);
    let of =
        |table: &str, case: &str| table.lines().filter(|line| line.starts_with(case)).collect::<Vec<_>>().join("\n");
    assert_ne!(of(&verdicts(), "a,"), of(&first, "a,"));
    assert_eq!(of(&verdicts(), "b,"), of(&first, "b,"));
    // A mistake is shown where it stands, and waited out.
    let before = verdicts();
    write(&rooms, "b.toml", "sampels = [4]\n");
    errors.until(waiting, 3);
    let said = errors.text();
    assert!(said.contains("b.toml:") && said.contains("sampels = [4]"), "{said}");
    assert_eq!(verdicts(), before, "the last report stays");
    // Mended, and another case joins.
    write(&rooms, "b.toml", "samples = [8]\nreplicates = 1000\n");
    errors.until("running 1 of 2: b", 1);
    errors.until(waiting, 4);
    write(&rooms, "c.toml", SHORT_STUDY);
    errors.until("running 1 of 3: c", 1);
    errors.until(waiting, 5);
    out.until("18 verdicts", 1);
    assert_eq!(out.text().matches("report: out\n").count(), 4, "one table a round:\n{}", out.text());
    running.interrupt();
    let ended = running.ended();
    assert_eq!(ended.status.code(), Some(0), "the code of the last verdicts; {}", errors.text());
    // What a report of the same files says, byte for byte.
    let watched = verdicts();
    let again = etendue(folder.path(), &["run", "rooms", "--no-plots", "--allow-undecided", "--out", "out"]).output();
    assert_eq!(again.unwrap().status.code(), Some(0));
    assert_eq!(verdicts(), watched);
}

#[test]
fn a_mesh_that_changes_runs_its_case_and_an_old_round_is_given_up() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    let mesh = |size: f64| {
        let text = format!("v 0 0 1\nv {size} 0 1\nv 0 {size} 1\nf 1 2 3\n");
        std::fs::write(folder.path().join("meshes/roof.obj"), text).unwrap();
    };
    mesh(0.1);
    write(folder.path(), "room.toml", &format!("{LONG_STUDY}[[occluder.mesh]]\nfile = \"meshes/roof.obj\"\n"));
    let mut running = Running::start(folder.path(), &["run", "room.toml", "--watch", "--no-plots", "--out", "out"]);
    let errors = Heard::of(running.child().stderr.take().unwrap());
    errors.until("running 1 of 1: room", 1);
    mesh(0.2);
    errors.until("running 1 of 1: room", 2);
    running.interrupt();
    let ended = running.ended();
    assert_eq!(ended.status.code(), Some(130), "in the middle of a round");
    assert!(text(&ended.stdout).is_empty(), "{}", text(&ended.stdout));
}

#[test]
fn mistakes_that_are_there_from_the_start_are_waited_out_and_told_by_the_code() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "room.toml", "sampels = [4]\n");
    let mut running = Running::start(folder.path(), &["run", "room.toml", "--watch", "--out", "out"]);
    let errors = Heard::of(running.child().stderr.take().unwrap());
    errors.until("waiting for a change", 1);
    assert!(errors.text().contains("room.toml:"), "{}", errors.text());
    running.interrupt();
    assert_eq!(running.ended().status.code(), Some(2));
}
