//! Nothing is lost and nothing counted twice: a run that is cut into shards, killed at any moment, or whose disk is full comes
//! to the same bytes as one that nobody disturbed, and what cannot is refused by name.

use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use crate::long_runs::{CHECKPOINT, Running, etendue, files, read, text, until};

/// A room whose cells are several units each: sixty million rays in the largest.
const LARGE: &str = r#"
title = "Large cells"
[[source.disk]]
center = [0.0, 0.0, 2.0]
normal = [0.0, 0.0, -1.0]
radius = 0.5
exitance = 1.0
[[occluder.disk]]
center = [0.1, 0.0, 1.0]
normal = [0.0, 0.0, 1.0]
radius = 0.3
[[measure.point]]
position = [0.3, 0.2, 0.0]
normal = [0.0, 0.0, 1.0]
[[measure.point]]
position = [0.5, 0.2, 0.0]
normal = [0.0, 0.0, 1.0]
[study]
samples = [16, 64]
replicates = 500000
"#;

/// Everything that units can be of: large cells and small, predicted and with a pilot, rays from the light, eye paths.
const WORDS: [&str; 7] = [
    "run",
    "large.toml",
    "penumbra/half-plane",
    "caustic/glass-ball",
    "interreflection/coaxial-disks",
    "--quick",
    "--strategy",
];
const STRATEGIES: &str = "random,correlated,uniform-jitter";

fn study() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("large.toml"), LARGE).unwrap();
    folder
}

fn words<'a>(more: &[&'a str]) -> Vec<&'a str> {
    WORDS.iter().copied().chain([STRATEGIES, "--no-plots", "--allow-undecided"]).chain(more.iter().copied()).collect()
}

fn done(folder: &Path, words: &[&str]) -> Output {
    etendue(folder, words).output().expect("the program")
}

fn succeeds(folder: &Path, words: &[&str]) -> Output {
    let output = done(folder, words);
    assert_eq!(output.status.code(), Some(0), "{words:?}: {}", text(&output.stderr));
    output
}

/// Of two reports all but the timings are the same bytes.
fn assert_same(one: &Path, other: &Path) {
    let names = |folder: &Path| {
        let below = |path: PathBuf| path.strip_prefix(folder).unwrap().to_owned();
        let mut names: Vec<PathBuf> = files(folder).into_iter().map(below).collect();
        names.sort();
        names
    };
    assert_eq!(names(one), names(other));
    assert!(names(one).len() > 10, "a report");
    for name in names(one).iter().filter(|name| !name.to_string_lossy().starts_with("timings")) {
        assert!(
            std::fs::read(one.join(name)).unwrap() == std::fs::read(other.join(name)).unwrap(),
            "{}",
            name.display()
        );
    }
}

#[test]
fn shards_merge_to_the_bytes_of_one_run() {
    let folder = study();
    succeeds(folder.path(), &words(&["--out", "whole"]));
    for (of, threads) in [(3, "2"), (11, "1")] {
        let parts = format!("parts-{of}");
        for index in (0..of).rev() {
            let shard = format!("{index}/{of}");
            succeeds(folder.path(), &words(&["--shard", &shard, "--out", &parts, "--threads", threads]));
        }
        let merged = format!("merged-{of}");
        succeeds(folder.path(), &["merge", &parts, "-o", &merged, "--no-plots", "--allow-undecided"]);
        assert_same(&folder.path().join("whole"), &folder.path().join(&merged));
    }
    // A shard that is made again is the same, but for the time it took.
    let before = succeeds(folder.path(), &words(&["--shard", "1/3", "--out", "parts-3", "--resume"]));
    assert!(
        text(&before.stdout).contains("was there: parts-3/shard-00001-of-00003.units"),
        "{}",
        text(&before.stdout)
    );
}

#[test]
fn what_is_missing_or_damaged_is_named_with_what_makes_it_again() {
    let folder = study();
    let words = |more: &[&'static str]| {
        let mut all = vec!["run", "penumbra/half-plane", "--quick", "--no-plots"];
        all.extend(more);
        all
    };
    succeeds(folder.path(), &words(&["--out", "whole"]));
    for shard in ["0/6", "1/6", "2/6", "3/6", "4/6", "5/6"] {
        succeeds(folder.path(), &words(&["--out", "parts", "--shard", shard]));
    }
    let parts = folder.path().join("parts");
    let shard = |index: u32| parts.join(format!("shard-{index:05}-of-00006.units"));
    // One is gone, two are damaged, one belongs to another run.
    std::fs::remove_file(shard(1)).unwrap();
    let cut = std::fs::read(shard(2)).unwrap();
    std::fs::write(shard(2), &cut[..cut.len() - 9]).unwrap();
    let mut flipped = std::fs::read(shard(3)).unwrap();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 4;
    std::fs::write(shard(3), flipped).unwrap();
    succeeds(folder.path(), &words(&["--out", "parts", "--shard", "5/6", "--seed", "7"]));
    let refused = done(folder.path(), &["merge", "parts", "-o", "merged"]);
    assert_eq!((refused.status.code(), text(&refused.stdout)), (Some(6), String::new()));
    let said = text(&refused.stderr);
    for word in [
        "2 of 6 shards can be used",
        "shard-00002-of-00006.units is damaged",
        "shard-00003-of-00006.units is damaged",
        "shard-00005-of-00006.units belongs to another run: its seed is 7, not 1",
        "missing: 1-3,5",
        "sbatch --array=1-3,5 shards.sbatch",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    assert!(!folder.path().join("merged").exists(), "nothing was written");
    // What is said makes it whole.
    let line = said.lines().find_map(|line| line.trim().strip_prefix("shell:")).expect("a line for a shell");
    let program = Path::new(env!("CARGO_BIN_EXE_etendue")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let shell = Command::new("sh").args(["-ec", line]).env("PATH", path).current_dir(folder.path()).output().unwrap();
    assert!(shell.status.success(), "{line}: {}", text(&shell.stderr));
    succeeds(folder.path(), &["merge", "parts", "-o", "merged", "--no-plots"]);
    assert_same(&folder.path().join("whole"), &folder.path().join("merged"));

    // Cases that are no longer what they were; a folder without shards; one that is not there.
    std::fs::write(folder.path().join("room.toml"), LARGE).unwrap();
    succeeds(folder.path(), &["run", "room.toml", "--samples", "1", "--shard", "0/1", "--out", "other"]);
    std::fs::write(folder.path().join("room.toml"), LARGE.replace("0.3, 0.2", "0.3, 0.1")).unwrap();
    let refused = done(folder.path(), &["merge", "other", "-o", "nowhere"]);
    assert_eq!(refused.status.code(), Some(6));
    assert!(text(&refused.stderr).contains("its case room is another than it is now"), "{}", text(&refused.stderr));
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    for (parts, code, word) in [("empty", 6, "no shard of a run is in empty"), ("absent", 2, "cannot read absent")] {
        let refused = done(folder.path(), &["merge", parts, "-o", "nowhere"]);
        assert_eq!(refused.status.code(), Some(code));
        assert!(text(&refused.stderr).contains(word), "{word}: {}", text(&refused.stderr));
    }
}

#[test]
fn a_run_that_is_killed_at_any_moment_goes_on_to_the_same_bytes() {
    let folder = study();
    let begun = Instant::now();
    succeeds(folder.path(), &words(&["--out", "whole"]));
    let whole = begun.elapsed();
    // Killed again and again, each time a little later; never is what was done before lost.
    let mut kept = 0;
    for k in 1..=8 {
        let resume = if k == 1 { "--quiet" } else { "--resume" };
        let mut running = Running::start(folder.path(), &words(&["--out", "killed", resume]));
        std::thread::sleep(whole * k / 40);
        running.child().kill().unwrap();
        let ended = running.ended();
        if ended.status.signal() == Some(9) {
            let size = std::fs::metadata(folder.path().join("killed").join(CHECKPOINT)).map_or(0, |file| file.len());
            assert!(size >= kept, "{size} bytes after {kept}");
            kept = size;
        }
    }
    assert!(kept > 10_000, "something was done: {kept} bytes");
    let is_left = folder.path().join("killed").join(CHECKPOINT).exists();
    let resumed = succeeds(folder.path(), &words(&["--out", "killed", "--resume", "--threads", "1"]));
    // Unless the last of them came to its end.
    assert_eq!(text(&resumed.stderr).contains("results are there"), is_left, "{}", text(&resumed.stderr));
    // Its lock's name is taken away by who comes next.
    assert_same(&folder.path().join("whole"), &folder.path().join("killed"));
}

#[test]
fn an_interrupted_shard_goes_on_and_so_does_an_interrupted_run() {
    let folder = study();
    std::fs::write(folder.path().join("long.toml"), LARGE.replace("500000", "30000000")).unwrap();
    for (name, more) in [("run", &[][..]), ("shard", &["--shard", "0/2"][..])] {
        let words: Vec<&str> =
            ["run", "long.toml", "--out", name, "--no-plots"].into_iter().chain(more.iter().copied()).collect();
        let mut running = Running::start(folder.path(), &words);
        let size = || -> u64 {
            let there = folder.path().join(name);
            let files = if there.is_dir() { files(&there) } else { Vec::new() };
            files.iter().filter_map(|path| path.metadata().ok()).map(|file| file.len()).sum()
        };
        until(|| size() > 4000);
        running.interrupt();
        let ended = running.ended();
        let said = text(&ended.stderr);
        assert_eq!(ended.status.code(), Some(130), "{said}");
        assert!(said.contains("what goes on: etendue run long.toml --seed 1") && said.contains("--resume"), "{said}");
        assert!(size() > 4000, "{name}: {} bytes are kept", size());
    }
}

#[test]
fn work_of_another_run_is_refused_and_stays() {
    let folder = study();
    std::fs::write(folder.path().join("long.toml"), LARGE.replace("500000", "30000000")).unwrap();
    let mut running = Running::start(folder.path(), &["run", "long.toml", "--out", "out"]);
    std::thread::sleep(Duration::from_millis(1000));

    // While it runs, nobody else writes there.
    let refused = done(folder.path(), &["run", "penumbra/eclipse", "--quick", "--out", "out"]);
    assert_eq!(refused.status.code(), Some(75), "{}", text(&refused.stderr));
    assert!(text(&refused.stderr).contains("out is in use by another run (process "), "{}", text(&refused.stderr));
    running.interrupt();
    assert_eq!(running.ended().status.code(), Some(130));

    let checkpoint = folder.path().join("out").join(CHECKPOINT);
    let before = std::fs::read(&checkpoint).unwrap();
    for (words, word) in [
        (&["run", "long.toml", "--seed", "2", "--out", "out", "--resume"][..], "its seed is 1, not 2"),
        (
            &["run", "long.toml", "--quick", "--out", "out", "--resume"],
            "its options are `--seed 1`, not `--quick --seed 1`",
        ),
        (&["run", "large.toml", "--out", "out", "--resume"], "it has the case long, which is none of this run's"),
    ] {
        let refused = done(folder.path(), words);
        assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
        let said = text(&refused.stderr);
        assert!(said.contains("checkpoint.units belongs to another run") && said.contains(word), "{word}: {said}");
        assert!(std::fs::read(&checkpoint).unwrap() == before, "what is refused stays");
    }
    std::fs::write(folder.path().join("long.toml"), LARGE.replace("500000", "30000001")).unwrap();
    let refused = done(folder.path(), &["run", "long.toml", "--out", "out", "--resume"]);
    assert!(text(&refused.stderr).contains("its case long is another than it is now"), "{}", text(&refused.stderr));
}

/// No file may grow beyond so many blocks of 512 bytes: writing fails at the byte after them, in whatever file that is.
fn limited(folder: &Path, blocks: u64, words: &[&str]) -> Output {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
    let program = env!("CARGO_BIN_EXE_etendue");
    let mut command = Command::new("sh");
    command.args(["-c", &script, "sh", program]).args(words).current_dir(folder);
    command.output().expect("a shell")
}

#[test]
fn wherever_writing_fails_it_is_said_and_what_was_done_is_kept() {
    let folder = study();
    let words = |more: &[&'static str]| {
        let mut all = vec!["run", "penumbra/half-plane", "caustic/paraboloid", "--quick", "--no-plots"];
        all.extend(more);
        all
    };
    succeeds(folder.path(), &words(&["--out", "whole"]));
    let largest =
        files(&folder.path().join("whole")).iter().map(|path| path.metadata().unwrap().len()).max().unwrap();
    let mut faults = 0;
    for blocks in [0, 1, 2, 5, 12, 40, 120, 400, 1200, largest.div_ceil(512)] {
        let output = limited(folder.path(), blocks, &words(&["--out", "limited"]));
        let (said, code) = (text(&output.stderr), output.status.code());
        match code {
            // The checkpoint did not fit, and the run came to its end all the same.
            Some(0) => assert!(blocks * 512 >= largest, "{blocks}: {said}"),
            Some(5) => {
                assert!(said.contains("limited") && said.contains("File too large"), "{blocks}: {said}");
                faults += 1;
            }
            _ => panic!("{blocks} blocks: {code:?}: {said}"),
        }
        assert!(!said.contains("panicked"), "{said}");
        if code == Some(5) && blocks > 2 {
            succeeds(folder.path(), &words(&["--out", "limited", "--resume"]));
            assert_same(&folder.path().join("whole"), &folder.path().join("limited"));
        }
        let shard = limited(folder.path(), blocks, &words(&["--out", "parts", "--shard", "0/1"]));
        let said = text(&shard.stderr);
        assert!(matches!(shard.status.code(), Some(0 | 5)) && !said.contains("panicked"), "{blocks}: {said}");
    }
    assert!(faults >= 5, "{faults}");
    succeeds(folder.path(), &words(&["--out", "parts", "--shard", "0/1", "--resume"]));
    succeeds(folder.path(), &["merge", "parts", "-o", "merged", "--no-plots"]);
    assert_same(&folder.path().join("whole"), &folder.path().join("merged"));
    let left = files(&folder.path().join("parts"));
    assert_eq!(left.len(), 1, "{left:?}");
}

/// All but the report's files can fail last: the verdicts for others, and those on standard output.
#[cfg(target_os = "linux")]
#[test]
fn a_checkpoint_stays_until_all_is_told() {
    let folder = study();
    let words = ["run", "penumbra/half-plane", "--quick", "--no-plots", "--out", "out"];
    let failed = done(folder.path(), &[&words[..], &["--junit", "/dev/full"]].concat());
    assert_eq!(failed.status.code(), Some(5), "{}", text(&failed.stderr));
    let resumed = succeeds(folder.path(), &[&words[..], &["--resume"]].concat());
    assert!(text(&resumed.stderr).contains("going on: "), "{}", text(&resumed.stderr));
    assert!(!folder.path().join("out").join(CHECKPOINT).exists());
}

/// A log lies as a rule on the disk that is full. Found by failing every write: what could not be said ended in a panic.
#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_said_is_told_by_the_exit_code() {
    let folder = study();
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for (words, code) in [
        (&["run", "nothing-of-this-name"][..], 4),
        (&["merge", "nowhere"], 2),
        (&["run", "penumbra/half-plane", "--quick", "--no-plots", "--out", "out", "--progress", "plain"], 0),
        (&["run", "penumbra/half-plane", "--quick", "--no-plots", "--out", "large.toml/out"], 5),
    ] {
        let ended = etendue(folder.path(), words).stderr(full()).output().unwrap();
        assert_eq!(ended.status.code(), Some(code), "{words:?}");
    }
}

/// Folders whose names are no text: found by a reader of the code, every run in one ended in a panic.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_may_be_called_anything() {
    use std::os::unix::ffi::OsStrExt;
    let folder = study();
    let odd = folder.path().join(std::ffi::OsStr::from_bytes(b"n\xff"));
    std::fs::create_dir(&odd).unwrap();
    let words = ["run", "penumbra/half-plane", "--quick", "--no-plots"];
    succeeds(&odd, &[&words[..], &["--out", "whole"]].concat());
    succeeds(&odd, &[&words[..], &["--out", "parts", "--shard", "0/1"]].concat());
    succeeds(&odd, &["merge", "parts", "-o", "merged", "--no-plots"]);
    assert_same(&odd.join("whole"), &odd.join("merged"));
}

/// Shards are merged wherever they have been brought, by names that are relative to there.
#[test]
fn shards_are_merged_from_another_folder() {
    let folder = study();
    let (made, other) = (folder.path().join("made"), folder.path().join("other"));
    [&made, &other].into_iter().for_each(|dir| std::fs::create_dir(dir).unwrap());
    std::fs::copy(folder.path().join("large.toml"), made.join("large.toml")).unwrap();
    let words = ["run", "large.toml", "--samples", "4", "--replicates", "1000", "--no-plots"];
    for shard in ["0/2", "1/2"] {
        succeeds(&made, &[&words[..], &["--out", "../other/parts", "--shard", shard]].concat());
    }
    succeeds(&other, &["merge", "parts", "-o", "merged", "--junit", "verdicts.xml", "--allow-undecided"]);
    assert!(other.join("merged/verdicts.csv").is_file() && other.join("verdicts.xml").is_file());
    // What was there before stays where nothing can be put in its place; and what is said can be done from here.
    std::fs::remove_file(other.join("parts/shard-00001-of-00002.units")).unwrap();
    let refused = done(&other, &["merge", "parts", "-o", "merged"]);
    let said = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(6), "{said}");
    assert!(other.join("merged/verdicts.csv").is_file());
    let made = made.canonicalize().unwrap();
    assert!(said.contains(&format!("cd {}; for i in 1; do etendue run large.toml", made.display())), "{said}");
    assert!(said.contains("other/parts --resume; done"), "{said}");
}

/// Heads may say anything; checksums are no proof of sense.
#[test]
fn shards_with_options_that_no_run_can_have_are_refused() {
    use etendue::case::{Case, Reach};
    use etendue::journal::{Beginning, Identity, ShardFile};
    use etendue::trial::{Division, Overrides, Settings, Shard};

    let cases = [Case::shipped("penumbra/half-plane").unwrap()];
    let settings = |samples: Option<Vec<u64>>, strategies| Settings {
        seed: 1,
        effort: Default::default(),
        overrides: Overrides { samples, strategies, ..Overrides::default() },
    };
    let sound = settings(None, None);
    let odd = [
        (settings(Some(vec![0]), None), Reach::Inside, 6, "options that no run can have"),
        (settings(Some(Vec::new()), None), Reach::Inside, 6, "options that no run can have"),
        (settings(Some(vec![1 << 60]), None), Reach::Inside, 6, "options that no run can have"),
        (settings(None, Some(Vec::new())), Reach::Inside, 6, "options that no run can have"),
        (sound.clone(), Reach::Anywhere, 2, "say it here, too"),
        // Whole to look at, and empty.
        (sound.clone(), Reach::Inside, 6, "no shard holds the exact values of penumbra/half-plane"),
    ];
    for (settings, reach, code, due) in odd {
        let folder = tempfile::tempdir().unwrap();
        let shard = Some(Shard { index: 0, of: 1 });
        let identity = Identity::new(&cases, &settings, &["penumbra/half-plane".to_owned()], reach, shard);
        let division = Division::new(&cases, &sound);
        let parts = folder.path().join("parts");
        let Beginning::Work(file) = ShardFile::begin(&parts, identity, division, false).unwrap() else {
            panic!("there is none")
        };
        file.finish().unwrap();
        let refused = done(folder.path(), &["merge", "parts", "-o", "merged"]);
        let said = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(code), "{said}");
        assert!(said.contains(due) && !said.contains("panicked"), "{due}: {said}");
        assert!(!folder.path().join("merged/verdicts.csv").exists());
    }
}

#[test]
fn a_folder_that_vanishes_is_told() {
    let folder = study();
    std::fs::write(folder.path().join("long.toml"), LARGE.replace("500000", "8000000")).unwrap();
    let words = ["run", "long.toml", "--out", "gone", "--samples", "64", "--no-plots"];
    let running = Running::start(folder.path(), &words);
    std::thread::sleep(Duration::from_millis(700));
    std::fs::remove_dir_all(folder.path().join("gone")).unwrap();
    let ended = running.ended();
    let said = text(&ended.stderr);
    assert!(matches!(ended.status.code(), Some(0 | 5)) && !said.contains("panicked"), "{said}");
    if ended.status.code() == Some(5) {
        assert!(said.contains("gone"), "{said}");
    }
}

#[test]
fn the_scripts_for_a_scheduler_do_what_a_run_does() {
    let folder = study();
    let words = ["large.toml", "--samples", "4,16", "--replicates", "1000"];
    let with = |first: &[&'static str], more: &[&'static str]| {
        first.iter().chain(&words).chain(more).copied().collect::<Vec<&str>>()
    };
    succeeds(folder.path(), &with(&["run"], &["--out", "whole", "--allow-undecided"]));
    let told = succeeds(folder.path(), &with(&["plan"], &["-n", "5", "--for", "slurm", "-o", "a study"]));
    assert!(text(&told.stdout).contains("in 5 shards"), "{}", text(&told.stdout));
    let script = folder.path().join("a study/shards.sbatch");
    assert!(read(script.clone()).contains("\n#SBATCH --array=0-4\n"));
    for index in 0..5 {
        let task =
            Command::new("sh").arg(&script).env("SLURM_ARRAY_TASK_ID", index.to_string()).current_dir("/").output();
        let task = task.unwrap();
        assert!(task.status.success(), "{}", text(&task.stderr));
    }
    let merge = Command::new("sh").arg(folder.path().join("a study/merge.sbatch")).current_dir("/").output().unwrap();
    assert!(matches!(merge.status.code(), Some(0 | 3)), "{}", text(&merge.stderr));
    assert_same(&folder.path().join("whole"), &folder.path().join("a study/report"));
}
