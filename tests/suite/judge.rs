//! Programs behind a pipe, files of estimates and of points, as a user meets them: what is judged, and what is said of those
//! that break the rules.
#![cfg(all(feature = "cli", unix))]

use std::path::{Path, PathBuf};
use std::process::{Command as Process, Stdio};

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::{contains, is_empty};

const BINARY: &str = env!("CARGO_BIN_EXE_etendue");

fn etendue() -> Command {
    let mut command = Command::new(BINARY);
    command.current_dir(env!("CARGO_TARGET_TMPDIR")).env_remove("COLUMNS").env_remove("CLICOLOR_FORCE");
    command
}

/// Two points under a disk.
const SMALL: &str = r#"
[[source.disk]]
center = [0.0, 0.0, 2.0]
normal = [0.0, 0.0, -1.0]
radius = 0.5
exitance = 1.0
[[measure.point]]
position = [0.1, 0.2, 0.0]
normal = [0.0, 0.0, 1.0]
[[measure.point]]
position = [0.3, 0.2, 0.0]
normal = [0.0, 0.0, 1.0]
"#;

struct Room {
    folder: tempfile::TempDir,
    case: String,
}

impl Room {
    fn new() -> Room {
        let folder = tempfile::tempdir().unwrap();
        let case = folder.path().join("small.toml");
        std::fs::write(&case, SMALL).unwrap();
        Room { case: case.to_str().unwrap().to_owned(), folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn file(&self, name: &str, text: impl AsRef<[u8]>) -> String {
        std::fs::write(self.path(name), text).unwrap();
        self.path(name).to_str().unwrap().to_owned()
    }

    fn judge(&self, options: &[&str], program: &[&str]) -> Command {
        let mut command = etendue();
        command.args(["judge", &self.case]).args(options).arg("--out").arg(self.path("out")).arg("--").args(program);
        command
    }

    /// Judges an awk program with a few replicates, and no pilot: 2 points, 40 replicates, 80 questions.
    fn awk(&self, program: &str) -> Command {
        let options = ["--replicates", "40", "--variance", "random", "--timeout", "2"];
        self.judge(&options, &["awk", "-F,", program])
    }
}

/// An answer in awk to the question at hand.
const ANSWER: &str = r#"print $1 "," $9 "," $8 "," 0.05"#;

fn found(program: &str) -> bool {
    let there = Process::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    let there = there.is_ok_and(|status| status.success());
    if !there {
        eprintln!("SKIPPED: there is no `{program}` here, so its example was not judged");
    }
    there
}

fn example(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/judge").join(name).to_str().unwrap().to_owned()
}

/// Quick terms for the examples.
const QUICK: [&str; 2] = ["--smallest-bias", "0.05,0.5"];

#[test]
fn the_example_in_c_passes_as_it_is_written() {
    if !found("cc") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("eclipse");
    let mut cc = Process::new("cc");
    cc.args(["-O2", "-Wall", "-Werror", "-o"]).arg(&program).arg(example("eclipse.c")).arg("-lm");
    assert!(cc.status().unwrap().success());
    let run = |more: &[&str], out: &str| {
        let mut command = etendue();
        command.args(["judge", "penumbra/eclipse"]).args(QUICK).args(more).arg("--out").arg(folder.path().join(out));
        command.arg("--").arg(&program);
        command.assert().code(0).stdout(contains("PASS").and(contains("program:eclipse")))
    };
    run(&[], "a").stdout(contains("leans on a pilot of 512 replicates"));
    // The same seeds, the same answers, byte for byte.
    run(&[], "b");
    let kept = |out: &str| std::fs::read(folder.path().join(out).join("estimates.csv")).unwrap();
    assert_eq!(kept("a"), kept("b"));
    run(&["--seed", "2", "--samples", "1,64", "--variance", "random"], "c")
        .stdout(contains("no larger than that of `random`"));
    for file in ["convergence.csv", "verdicts.csv", "manifest.json", "plots/penumbra-eclipse-profile.svg"] {
        assert!(folder.path().join("a").join(file).is_file(), "{file}");
    }
    let verdicts = std::fs::read_to_string(folder.path().join("a/verdicts.csv")).unwrap();
    assert!(verdicts.contains("program:eclipse"), "{verdicts}");
    // The answers are a file that can be judged by itself, on the same terms.
    etendue()
        .args(["verify", "penumbra/eclipse", "--variance", "random"])
        .args(QUICK)
        .arg(folder.path().join("c/estimates.csv"))
        .arg("--out")
        .arg(folder.path().join("d"))
        .assert()
        .code(0)
        .stdout(contains("PASS"));
    assert!(folder.path().join("d/verdicts.csv").is_file());
}

#[test]
fn the_example_in_python_passes_as_it_is_written() {
    if !found("python3") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    etendue()
        .args([
            "judge",
            "penumbra/eclipse",
            "--samples",
            "4",
            "--smallest-bias",
            "0.05,0.8",
            "--name",
            "mine:eclipse",
        ])
        .arg("--out")
        .arg(folder.path())
        .args(["--", "python3", &example("eclipse.py")])
        .assert()
        .code(0)
        .stdout(contains("PASS").and(contains("mine:eclipse")));
}

#[test]
fn a_slip_in_the_example_is_caught_with_the_line_that_shows_it_again() {
    if !found("cc") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let right = std::fs::read_to_string(example("eclipse.c")).unwrap();
    for (k, (from, to)) in
        [("sqrt(unit(&seed))", "unit(&seed)"), ("facing * dz / (d2 * d2)", "facing / (d2 * sqrt(d2))")]
            .iter()
            .enumerate()
    {
        assert!(right.contains(from), "{from}");
        let source = folder.path().join(format!("slip-{k}.c"));
        let program = folder.path().join(format!("slip-{k}"));
        std::fs::write(&source, right.replace(from, to)).unwrap();
        assert!(
            Process::new("cc").arg("-O2").arg("-o").args([&program, &source]).arg("-lm").status().unwrap().success()
        );
        let mut command = etendue();
        command.args(["judge", "penumbra/eclipse"]).args(QUICK).arg("--out").arg(folder.path().join("out"));
        let shown = format!(
            "again: etendue judge penumbra/eclipse --samples 16 --replicates auto --smallest-bias 0.05,0.5 --seed 1 -- {}",
            program.display()
        );
        command
            .arg("--")
            .arg(&program)
            .assert()
            .code(1)
            .stdout(contains("FAIL").and(contains("is biased by")).and(contains(shown)));
    }
}

#[test]
fn what_a_program_does_wrong_is_told() {
    let room = Room::new();
    for (program, said) in [
        (
            "NR > 1 && NR < 7 { ANSWER; fflush() } NR == 7 { system(\"sleep 6\") }",
            "hangs: nothing came for 2 s after 5 of 80 answers; next was point 1, replicate 2, samples 16",
        ),
        ("NR == 4 { exit 3 } NR > 1 { ANSWER }", "died (exit status: 3) after 2 of 80 answers"),
        ("NR > 1 { ANSWER } END { exit 4 }", "died (exit status: 4) after 80 of 80 answers"),
        (
            "NR > 1 && NR < 7 { ANSWER }",
            "answered too little: it ended after 5 of 80 answers; next was point 1, replicate 2, samples 16",
        ),
        (
            "NR % 2 { if (NR > 1) { ANSWER; print held } } !(NR % 2) { held = $1 \",\" $9 \",\" $8 \",1\" }",
            "line 1 of its output: point 1, replicate 0, samples 16 is answered out of order: next was point 0, replicate 0",
        ),
        (
            "NR > 1 { ANSWER; ANSWER }",
            "line 2 of its output: point 0, replicate 0, samples 16 is answered a second time",
        ),
        (
            "NR > 1 { ANSWER } END { ANSWER }",
            "line 81 of its output: point 1, replicate 39, samples 16 is answered a second time",
        ),
        ("NR > 1 { ANSWER } END { print \"7,0,16,1\" }", "there are more answers than the 80 questions"),
        (
            "NR > 1 { print $1 \",\" $9 \",\" $8 \",nan\" }",
            "the answer to point 0, replicate 0, samples 16 is NaN; a finite number is accepted",
        ),
        ("NR > 1 { print $1 \",\" $9 \",\" $8 \",-inf\" }", "is -inf; a finite number"),
        (
            "NR == 3 { print \"Segmentation fault\" } NR > 1 { ANSWER }",
            "line 2 of its output: `Segmentation fault` is no answer (it has not four fields); accepted: point,replicate,samples,value",
        ),
        ("NR > 1 { print $1 \",\" $9 \",\" $8 \",lots\" }", "its value is no number"),
        (
            "NR > 1 { print 5 \",\" $9 \",\" $8 \",1\" }",
            "point 5, replicate 0, samples 16 was not asked: there are 2 points, counted from 0",
        ),
        ("NR > 1 { print $1 \",\" 40 \",\" $8 \",1\" }", "was not asked: there are 40 replicates"),
        ("NR > 1 { print $1 \",\" $9 \",1,1\" }", "was not asked: the samples are 16"),
    ] {
        let assert = room.awk(&program.replace("ANSWER", ANSWER)).assert();
        assert.code(2).stdout(is_empty()).stderr(contains(said));
    }
    room.judge(&[], &["/no/such/program"]).assert().code(2).stderr(contains("`/no/such/program` cannot be started"));
    etendue().args(["judge", &room.case]).assert().code(2).stderr(contains("no program is named"));
    room.judge(&["--timeout", "1"], &["sleep", "9"])
        .assert()
        .code(2)
        .stderr(contains("hangs: nothing came for 1 s after 0 of"));
}

#[test]
fn a_program_that_does_not_end_is_told_of() {
    let room = Room::new();
    let program = format!("awk -F, 'NR > 1 {{ {ANSWER} }}'; exec 1>&-; sleep 9");
    let options = ["--replicates", "40", "--variance", "random", "--timeout", "1"];
    let said = "does not end: it has answered all 80 questions";
    room.judge(&options, &["sh", "-c", &program]).assert().code(2).stderr(contains(said));
}

#[test]
fn answers_that_came_before_a_fault_are_kept_and_can_be_judged() {
    let room = Room::new();
    let kept = room.path("out/estimates.csv");
    room.awk(&format!("NR == 73 {{ exit 3 }} NR > 1 {{ {ANSWER} }}")).assert().code(2).stderr(
        contains("died (exit status: 3) after 71 of 80 answers")
            .and(contains("70 answers, in whole replicates, are kept: etendue verify"))
            .and(contains(kept.to_str().unwrap())),
    );
    etendue()
        .args(["verify", &room.case])
        .arg(&kept)
        .arg("--out")
        .arg(room.path("again"))
        .assert()
        .stdout(contains("file:estimates"));
}

#[test]
fn a_program_that_ignores_its_seeds_brings_no_new_evidence() {
    let room = Room::new();
    let program = "NR > 1 { print $1 \",\" $9 \",\" $8 \",\" 0.05 + 0.01 * (($9 * 7919) % 13) / 13 }";
    room.judge(&["--replicates", "64"], &["awk", "-F,", program])
        .assert()
        .code(2)
        .stderr(contains("does not use the seeds").and(contains("the first 8 replicates")));
}

#[test]
fn neither_side_waits_for_the_other() {
    // Far more than a pipe holds, either way: answers at once, and answers when the input has ended.
    let room = Room::new();
    let options = ["--replicates", "40000", "--variance", "random"];
    for program in [
        format!("NR > 1 {{ {ANSWER} }}"),
        "NR > 1 { held[NR] = $1 \",\" $9 \",\" $8 \",0.05\" } END { for (k = 2; k <= NR; k++) print held[k] }"
            .to_owned(),
    ] {
        // 0.05 is no estimate of what is there; it is judged, and that is what is asked here.
        room.judge(&options, &["awk", "-F,", &program]).assert().code(1).stdout(contains("FAIL"));
        let kept = std::fs::read_to_string(room.path("out/estimates.csv")).unwrap();
        assert_eq!(kept.lines().count(), 80_001);
    }
}

#[test]
fn questions_can_be_taken_away_and_answers_brought_back() {
    let room = Room::new();
    let asked =
        etendue().args(["judge", &room.case, "--ask", "--samples", "4", "--replicates", "50"]).assert().code(0);
    let questions = String::from_utf8(asked.get_output().stdout.clone()).unwrap();
    let mut lines = questions.lines();
    assert_eq!(lines.next(), Some("point,x_m,y_m,z_m,nx,ny,nz,samples,replicate,seed"));
    assert!(lines.next().unwrap().starts_with("0,0.1,0.2,0.0,0.0,0.0,1.0,4,0,"));
    assert_eq!(lines.count(), 99);
    for (text, code, said) in [
        ("rubbish\n", 2, "mine.csv:1: `rubbish` is no answer"),
        ("0,0,4,0.1\n", 2, "point 1, replicate 0, samples 4 has no answer"),
        ("0,0,4,0.1\n1,0,4,0.1\n", 2, "too few replicates (1); at least 32 are needed"),
        ("\x00", 2, "this is no text"),
    ] {
        let file = room.file("mine.csv", text);
        etendue()
            .args(["verify", &room.case, &file, "--out"])
            .arg(room.path("again"))
            .assert()
            .code(code)
            .stdout(is_empty())
            .stderr(contains(said));
    }
    etendue()
        .args(["verify", &room.case, "/no/such.csv", "--out"])
        .arg(room.path("again"))
        .assert()
        .code(2)
        .stderr(contains("/no/such.csv"));
}

#[test]
fn a_witness_without_randomness_is_judged_by_where_it_goes() {
    let room = Room::new();
    let case = etendue::Case::read(std::path::Path::new(&room.case)).unwrap();
    let oracle = etendue::oracle::Oracle::new(&case.configuration);
    let due = case.configuration.points().iter().map(|p| oracle.at(p).irradiance.watts_per_square_metre());
    let due: Vec<f64> = due.collect();
    let estimates = |limit: f64| -> String {
        let of = |n: u64| (0..2).map(move |p| (n, p));
        let lines = [8, 16, 32, 64, 128, 256, 512]
            .into_iter()
            .flat_map(of)
            .map(|(n, p)| format!("{p},0,{n},{}\n", due[p] * (limit + 0.3 / n as f64)));
        lines.collect()
    };
    for (limit, code, said) in [(1.0, 0, "converges"), (1.02, 1, "settles off the exact value"), (f64::NAN, 2, "NaN")]
    {
        let file = room.file("lattice.csv", estimates(limit));
        let out = room.path("lattice");
        let assert = etendue().args(["verify", &room.case, &file, "--converging", "--out"]).arg(&out).assert();
        if code == 2 {
            assert.code(2).stdout(is_empty()).stderr(contains(said));
            continue;
        }
        assert.code(code).stdout(contains("file:lattice").and(contains(said)));
        for name in ["levels.csv", "limits.csv", "verdict.json", "junit.xml"] {
            assert!(out.join(name).is_file(), "{name}");
        }
    }
    let file = room.file("one.csv", "0,0,4,0.1\n1,0,4,0.1\n");
    etendue()
        .args(["verify", &room.case, &file, "--converging", "--out"])
        .arg(room.path("again"))
        .assert()
        .code(2)
        .stderr(contains("convergence shows from 3 on"));
}

#[test]
fn points_are_written_and_judged_as_a_strategy() {
    let room = Room::new();
    let written = |strategy: &str| {
        let command =
            etendue().args(["points", strategy, "-n", "16", "--sets", "6000", "--seed", "5"]).assert().code(0);
        command.get_output().stdout.clone()
    };
    let file = room.file("mine.txt", written("sobol"));
    let run = |file: &str, more: &[&str]| {
        let mut command = etendue();
        command.args(["run", &room.case, "--points", file]).args(more).arg("--out").arg(room.path("out"));
        command.assert()
    };
    run(&file, &[]).code(0).stdout(
        contains("points:mine").and(contains("1 verdict: 1 passed")).and(contains("a pilot of 1500 replicates")),
    );
    run(&file, &["--strategy", "random", "--quick"]).code(0).stdout(contains("points:mine").and(contains("random")));
    let table = std::fs::read_to_string(room.path("out/convergence.csv")).unwrap();
    assert!(table.contains("points:mine") && table.contains(",random,"), "{table}");
    // The same points, all drawn to one side.
    let drawn = String::from_utf8(written("random")).unwrap();
    let drawn: String = drawn
        .lines()
        .map(|line| match line.split_once(' ').filter(|_| !line.starts_with('#')) {
            Some((u, v)) => format!("{} {v}\n", 0.9 * u.parse::<f64>().unwrap()),
            None => format!("{line}\n"),
        })
        .collect();
    let aside = room.file("aside.txt", drawn);
    run(&aside, &[])
        .code(1)
        .stdout(contains("FAIL").and(contains("points:aside is biased")).and(contains("--points")));
    for (text, said) in [
        ("0.5\n", "faulty.txt:1: `0.5` is no point; accepted: two numbers"),
        ("0.5 1.5\n", "faulty.txt:1: (0.5, 1.5) lies outside of the unit square; accepted"),
        ("0.5 0.5\n\n0.5 0.5\n0.5 0.5\n", "faulty.txt:4: the set that ends here has 2 points, the first has 1"),
        ("0.5 0.5\n", "too few sets (1); at least 32 are needed"),
    ] {
        let file = room.file("faulty.txt", text);
        run(&file, &[]).code(2).stdout(is_empty()).stderr(contains(said));
    }
    etendue().args(["points", "cosine", "-n", "4"]).assert().code(2).stderr(contains("draws directions"));
}
