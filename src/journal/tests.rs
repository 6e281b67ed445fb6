//! Whatever is done to a file of units, it is told, and what can be used of it is.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use super::*;
use crate::case::{Case, Reach, Replicates};
use crate::sampling::Strategy;
use crate::trial::{Absent, Division, Effort, Keeper, Kept, Overrides, Portion, Settings, Shard, Stage, Unit};

fn settings(seed: u64) -> Settings {
    let overrides =
        Overrides { samples: Some(vec![1, 4]), replicates: Some(Replicates::Fixed(64)), ..Overrides::default() };
    Settings { seed, effort: Effort::Standard, overrides }
}

fn cases() -> Vec<Case> {
    ["penumbra/eclipse", "direct/two-sources"].map(|name| Case::shipped(name).unwrap()).to_vec()
}

fn identity(seed: u64, shard: Option<Shard>) -> Identity {
    Identity::new(&cases(), &settings(seed), &[], Reach::Inside, shard)
}

fn unit(case: u32, index: u32) -> Unit {
    let stage = Stage::Measure { strategy: Strategy::Random, samples: 4 };
    Unit { case, portion: Portion { stage, index, of: 7 } }
}

fn kept(n: u8) -> Kept {
    Kept { bytes: (0..40 + n).map(|k| k.wrapping_mul(n)).collect(), seconds: f64::from(n) }
}

/// A shard with some units of its own.
fn write_shard(folder: &Path, seed: u64, shard: Shard, units: u8) -> PathBuf {
    let division = Division::new(&cases(), &settings(seed));
    match ShardFile::begin(folder, identity(seed, Some(shard)), division, false).unwrap() {
        Beginning::Work(file) => {
            // Not in their order: the file is.
            for k in (0..units).rev() {
                assert!(file.keep(&unit(shard.index, u32::from(k)), kept(k)).is_continue());
            }
            file.finish().unwrap().path
        }
        Beginning::Finished(path, _) => panic!("{} was not asked for", path.display()),
    }
}

fn shards(folder: &Path, of: u32) -> Vec<PathBuf> {
    (0..of).map(|index| write_shard(folder, 1, Shard { index, of }, 5)).collect()
}

#[test]
fn what_is_kept_is_found_again() {
    let dir = tempfile::tempdir().unwrap();
    let own = identity(1, None);
    let first = Checkpoint::begin(dir.path(), &own).unwrap();
    for k in 0..20 {
        assert_eq!(first.absent(&unit(0, k)), Absent::Make);
        assert!(first.keep(&unit(0, k), kept(k as u8)).is_continue());
    }
    drop(first);
    let again = Checkpoint::resume(dir.path(), &own).unwrap();
    assert_eq!(again.resumed(), 20);
    for k in 0..20 {
        assert_eq!(again.found(&unit(0, k)), Some(kept(k as u8)));
    }
    assert_eq!((again.found(&unit(1, 0)), again.found(&unit(0, 20))), (None, None));
    assert!(again.keep(&unit(1, 0), kept(9)).is_continue());
    drop(again);
    assert_eq!(Checkpoint::resume(dir.path(), &own).unwrap().resumed(), 21);
    // It goes when the report is on the disk, and not before.
    let report = [dir.path().join("verdicts.csv")];
    let refused = Checkpoint::resume(dir.path(), &own).unwrap().remove(&report).unwrap_err();
    assert!(refused.to_string().contains("verdicts.csv"), "{refused}");
    assert!(Checkpoint::is_in(dir.path()));
    std::fs::write(&report[0], "case").unwrap();
    Checkpoint::resume(dir.path(), &own).unwrap().remove(&report).unwrap();
    assert!(!Checkpoint::is_in(dir.path()));
}

#[test]
fn a_checkpoint_that_is_cut_anywhere_gives_what_was_whole_before() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(CHECKPOINT);
    let own = identity(1, None);
    let whole = Checkpoint::begin(dir.path(), &own).unwrap();
    let head = fs::metadata(&path).unwrap().len();
    let mut ends = vec![head];
    for k in 0..6 {
        let _ = whole.keep(&unit(0, k), kept(k as u8));
        ends.push(fs::metadata(&path).unwrap().len());
    }
    drop(whole);
    let bytes = fs::read(&path).unwrap();
    for cut in head as usize..=bytes.len() {
        fs::write(&path, &bytes[..cut]).unwrap();
        let resumed = Checkpoint::resume(dir.path(), &own).unwrap();
        let due = ends.iter().filter(|end| **end <= cut as u64).count() - 1;
        assert_eq!(resumed.resumed(), due, "cut at {cut}");
        // What is written now does not lie behind a half.
        let _ = resumed.keep(&unit(1, 1), kept(3));
        drop(resumed);
        assert_eq!(Checkpoint::resume(dir.path(), &own).unwrap().resumed(), due + 1, "cut at {cut}");
    }
    // Not even a head: nothing was done yet, or it is no such file. A power cut may leave zeros.
    for torn in [bytes[..20].to_vec(), bytes[..head as usize - 1].to_vec(), vec![0; 400], Vec::new()] {
        fs::write(&path, &torn).unwrap();
        assert_eq!(Checkpoint::resume(dir.path(), &own).unwrap().resumed(), 0, "{} bytes", torn.len());
    }
    fs::write(&path, [b'x'; 200]).unwrap();
    let refused = Checkpoint::resume(dir.path(), &own).err().unwrap();
    assert!(refused.to_string().contains("does not begin as a file of units does"), "{refused}");
}

#[test]
fn a_checkpoint_of_another_run_is_refused_by_what_is_different() {
    let dir = tempfile::tempdir().unwrap();
    let own = identity(1, None);
    drop(Checkpoint::begin(dir.path(), &own).unwrap());
    let before = fs::read(dir.path().join(CHECKPOINT)).unwrap();
    let mut others: Vec<(Identity, &str)> = vec![
        (identity(2, None), "its seed is 1, not 2"),
        (identity(1, Some(Shard { index: 0, of: 2 })), "it is a whole run, not a shard"),
    ];
    let mut other = own.clone();
    other.etendue_version = "9.9.9".to_owned();
    others.push((other, "not 9.9.9"));
    let mut other = own.clone();
    other.settings.overrides.samples = Some(vec![16]);
    others.push((other, "`--samples 1,4 --replicates 64 --seed 1`, not `--samples 16 --replicates 64 --seed 1`"));
    let mut other = own.clone();
    other.cases[1].digest = "0".to_owned();
    others.push((other, "its case direct/two-sources is another than it is now"));
    let mut other = own.clone();
    other.cases.remove(1);
    others.push((other, "it has the case direct/two-sources, which is none of this run's"));
    let mut other = own.clone();
    other.cases.swap(0, 1);
    others.push((other, "another order"));
    let mut other = own.clone();
    other.machine = "0123456789abcdef".to_owned();
    others.push((other, "gives other numbers"));
    for (other, due) in others {
        let refused = Checkpoint::resume(dir.path(), &other).err().expect(due);
        assert!(matches!(refused, JournalError::Foreign { .. }) && refused.to_string().contains(due), "{refused}");
    }
    assert_eq!(fs::read(dir.path().join(CHECKPOINT)).unwrap(), before, "what is refused stays");
}

#[test]
fn a_shard_is_the_same_file_in_whatever_order_it_was_made() {
    let dirs = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let shard = Shard { index: 1, of: 3 };
    let first = fs::read(write_shard(dirs[0].path(), 1, shard, 9)).unwrap();
    let begin = |resume| {
        ShardFile::begin(dirs[1].path(), identity(1, Some(shard)), Division::new(&cases(), &settings(1)), resume)
    };
    let Beginning::Work(file) = begin(false).unwrap() else { panic!("there is none") };
    for k in 0..4 {
        let _ = file.keep(&unit(1, k), kept(k as u8));
    }
    drop(file);
    let Beginning::Work(file) = begin(true).unwrap() else { panic!("it is not finished") };
    assert_eq!(file.resumed(), 4);
    assert_eq!(file.found(&unit(1, 3)), Some(kept(3)));
    for k in 4..9 {
        let _ = file.keep(&unit(1, k), kept(k as u8));
    }
    let finished = file.finish().unwrap();
    assert_eq!((finished.units, fs::read(&finished.path).unwrap() == first), (9, true));
    assert_eq!(fs::read_dir(dirs[1].path()).unwrap().count(), 1, "nothing else is left");
    let Beginning::Finished(path, 9) = begin(true).unwrap() else { panic!("it is there") };
    assert_eq!(path, finished.path);
}

#[test]
fn two_that_make_one_shard_at_once_do_no_harm() {
    let dir = tempfile::tempdir().unwrap();
    let shard = Shard { index: 0, of: 1 };
    let files = [begun(dir.path(), shard), begun(dir.path(), shard), begun(dir.path(), shard)];
    for k in 0..6 {
        files.iter().for_each(|file| assert!(file.keep(&unit(0, k), kept(k as u8)).is_continue()));
    }
    let ends: Vec<Finished> = files.into_iter().map(|file| file.finish().unwrap()).collect();
    assert!(ends.iter().all(|end| *end == ends[0]), "{ends:?}");
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    assert!(gather(&[dir.path().to_owned()]).unwrap().is_whole());
}

fn begun(folder: &Path, shard: Shard) -> Box<ShardFile> {
    let division = Division::new(&cases(), &settings(1));
    match ShardFile::begin(folder, identity(1, Some(shard)), division, true) {
        Ok(Beginning::Work(file)) => file,
        _ => panic!("nobody has finished it"),
    }
}

/// Found by a reader of the code: the file was ended with a checksum of what was left of it, and called finished.
#[test]
fn a_shard_whose_units_were_altered_while_it_was_made_is_not_finished() {
    let dir = tempfile::tempdir().unwrap();
    let shard = Shard { index: 0, of: 1 };
    let file = begun(dir.path(), shard);
    (0..9).for_each(|k| assert!(file.keep(&unit(0, k), kept(k as u8)).is_continue()));
    let passing = fs::read_dir(dir.path()).unwrap().next().unwrap().unwrap().path();
    let mut bytes = fs::read(&passing).unwrap();
    let middle = bytes.len() - 200;
    bytes[middle] ^= 1;
    fs::write(&passing, bytes).unwrap();
    let refused = file.finish().unwrap_err().to_string();
    assert!(refused.contains("is damaged: the checksum of a unit does not match"), "{refused}");
    assert!(!dir.path().join(shard_name(shard)).exists());
    // What is before the place is used.
    let again = begun(dir.path(), shard);
    let there = again.resumed() as u32;
    assert!((1..9).contains(&there), "{there}");
    (there..9).for_each(|k| assert!(again.keep(&unit(0, k), kept(k as u8)).is_continue()));
    assert_eq!(again.finish().unwrap().units, 9);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
}

/// Likewise: what an earlier try had left was read when the shard was put in order, and could be gone by then.
#[test]
fn a_shard_that_another_finishes_first_is_finished() {
    let dir = tempfile::tempdir().unwrap();
    let shard = Shard { index: 0, of: 1 };
    let tried = begun(dir.path(), shard);
    (0..3).for_each(|k| assert!(tried.keep(&unit(0, k), kept(k as u8)).is_continue()));
    drop(tried);
    let [slow, quick] = [begun(dir.path(), shard), begun(dir.path(), shard)];
    for file in [&slow, &quick] {
        assert_eq!(file.resumed(), 3);
        (3..6).for_each(|k| assert!(file.keep(&unit(0, k), kept(k as u8)).is_continue()));
    }
    let first = quick.finish().unwrap();
    assert_eq!(slow.finish().unwrap(), first);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    // Killed after it was finished, and before it was swept: one of two hundred kills. Not while somebody is at work.
    let name = |k: u32| dir.path().join(format!(".{}.{k:016x}.partial", shard_name(shard)));
    (0..2).for_each(|k| fs::write(name(k), "half").unwrap());
    let busy = fs::File::open(name(1)).unwrap();
    busy.try_lock().unwrap();
    let division = Division::new(&cases(), &settings(1));
    let there = ShardFile::begin(dir.path(), identity(1, Some(shard)), division, true).unwrap();
    assert!(matches!(there, Beginning::Finished(_, 6)));
    assert_eq!((name(0).exists(), name(1).exists()), (false, true));
}

/// What is found and does not fit is made anew: that is what the file has.
#[test]
fn what_was_made_now_is_taken_rather_than_what_was_left() {
    let dir = tempfile::tempdir().unwrap();
    let shard = Shard { index: 0, of: 1 };
    let tried = begun(dir.path(), shard);
    assert!(tried.keep(&unit(0, 0), kept(7)).is_continue());
    drop(tried);
    let again = begun(dir.path(), shard);
    assert_eq!(again.found(&unit(0, 0)), Some(kept(7)));
    assert!(again.keep(&unit(0, 0), kept(8)).is_continue());
    assert_eq!(again.finish().unwrap().units, 1);
    let whole = gather(&[dir.path().to_owned()]).unwrap();
    assert_eq!(whole.keeper().found(&unit(0, 0)), Some(kept(8)));
}

#[test]
fn shards_are_gathered_in_any_order_and_what_is_not_there_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let paths = shards(dir.path(), 12);
    let folder = || [dir.path().to_owned()];
    let whole = gather(&folder()).unwrap();
    assert!(whole.is_whole());
    assert_eq!((whole.units(), whole.files, whole.of), (60, 12, 12));
    let keeper = whole.keeper();
    assert_eq!(keeper.found(&unit(7, 2)), Some(kept(2)));
    assert_eq!((keeper.found(&unit(7, 5)), keeper.absent(&unit(7, 5))), (None, Absent::GiveUp));
    assert!(keeper.fault().unwrap().to_string().contains("no shard holds"));

    for gone in [3, 4, 5, 9] {
        fs::remove_file(&paths[gone]).unwrap();
    }
    let rest = gather(&folder()).unwrap();
    assert_eq!((rest.is_whole(), &rest.missing[..]), (false, &[3, 4, 5, 9][..]));
    assert_eq!(Indices(&rest.missing).to_string(), "3-5,9");

    // From two folders, one of them with shards that the other has.
    let more = tempfile::tempdir().unwrap();
    shards(more.path(), 12);
    let both = gather(&[more.path().to_owned(), dir.path().to_owned()]).unwrap();
    assert_eq!((both.is_whole(), both.duplicates.len(), both.units()), (true, 8, 60));
    assert!(gather(&[dir.path().join("nowhere")]).is_err());
    let none = tempfile::tempdir().unwrap();
    assert!(gather(&[none.path().to_owned()]).unwrap().identity.is_none());
}

#[test]
fn every_bit_that_is_flipped_and_every_byte_that_is_missing_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let paths = shards(dir.path(), 3);
    let bytes = fs::read(&paths[1]).unwrap();
    let told = |bytes: &[u8]| {
        fs::write(&paths[1], bytes).unwrap();
        let found = gather(&[dir.path().to_owned()]).unwrap();
        assert!(!found.is_whole());
        assert_eq!(found.missing, [1]);
        let [fault] = &found.faults[..] else { panic!("{:?}", found.faults) };
        fault.to_string()
    };
    for k in 0..bytes.len() {
        let mut flipped = bytes.clone();
        flipped[k] ^= 1 << (k % 8);
        let told = told(&flipped);
        assert!(told.contains("shard-00001-of-00003.units"), "byte {k}: {told}");
    }
    for length in (0..bytes.len()).step_by(7) {
        assert!(told(&bytes[..length]).contains("damaged"), "{length} bytes");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(told(&longer).contains("damaged"));
    // What is in the right place under another name, too.
    fs::copy(&paths[2], &paths[1]).unwrap();
    let found = gather(&[dir.path().to_owned()]).unwrap();
    assert!(
        found.faults[0].to_string().contains("it holds shard 2/3, which its name does not say"),
        "{:?}",
        found.faults
    );
}

#[test]
fn a_head_that_names_what_cannot_be_is_refused_before_memory_is_taken() {
    for shard in [Shard { index: 3, of: 3 }, Shard { index: 0, of: 0 }, Shard { index: 7, of: u32::MAX }] {
        let head = serde_json::to_vec(&identity(1, Some(shard))).unwrap();
        let mut bytes = frame::MARK.to_vec();
        bytes.extend(frame::frame(frame::Kind::Head, &[&head]));
        let told = try_bytes(&bytes).unwrap_err().to_string();
        assert!(told.contains("a shard that cannot be"), "{told}");
    }
    // A length of everything, and nothing behind it.
    let mut bytes = frame::MARK.to_vec();
    bytes.extend(frame::frame(frame::Kind::Head, &[&serde_json::to_vec(&identity(1, None)).unwrap()]));
    let mut unit = frame::frame(frame::Kind::Unit, &[b"x"]);
    unit[1..9].copy_from_slice(&u64::MAX.to_le_bytes());
    bytes.extend(unit);
    assert!(try_bytes(&bytes).is_ok(), "what is before it can be used");
}

#[test]
fn shards_of_another_run_are_told_and_one_that_contradicts_is_not_believed() {
    let dir = tempfile::tempdir().unwrap();
    shards(dir.path(), 3);
    let folder = || [dir.path().to_owned()];
    fs::remove_file(dir.path().join(shard_name(Shard { index: 2, of: 3 }))).unwrap();
    write_shard(dir.path(), 2, Shard { index: 2, of: 3 }, 5);
    write_shard(dir.path(), 1, Shard { index: 2, of: 4 }, 5);
    let found = gather(&folder()).unwrap();
    let told: Vec<String> = found.faults.iter().map(ToString::to_string).collect();
    assert_eq!(found.missing, [2]);
    assert!(told.iter().any(|fault| fault.contains("its seed is 2, not 1")), "{told:?}");
    assert!(told.iter().any(|fault| fault.contains("its run cut is into 4 shards, not into 3")), "{told:?}");

    // The same unit with another result: a machine that miscounts.
    let dir = tempfile::tempdir().unwrap();
    shards(dir.path(), 2);
    let division = Division::new(&cases(), &settings(1));
    let second = tempfile::tempdir().unwrap();
    let Ok(Beginning::Work(file)) =
        ShardFile::begin(second.path(), identity(1, Some(Shard { index: 1, of: 2 })), division, false)
    else {
        panic!("there is none")
    };
    (0..5).for_each(|k| assert!(file.keep(&unit(1, k), kept(k as u8 + u8::from(k == 3))).is_continue()));
    file.finish().unwrap();
    let found = gather(&[dir.path().to_owned(), second.path().to_owned()]).unwrap();
    assert!(!found.is_whole());
    assert!(found.faults[0].to_string().contains("1 of its results are others than in"), "{:?}", found.faults);
}

#[test]
fn a_folder_is_one_runs_at_a_time() {
    let dir = tempfile::tempdir().unwrap();
    let held = FolderLock::take(dir.path()).unwrap();
    let refused = FolderLock::take(dir.path()).err().unwrap();
    assert!(refused.may_pass());
    let own = format!("in use by another run (process {} on ", std::process::id());
    assert!(refused.to_string().contains(&own), "{refused}");
    drop(held);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0, "nothing is left behind");
    drop(FolderLock::take(dir.path()).unwrap());
    // Many at once: one after the other gets it.
    let inside = Mutex::new(());
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for _ in 0..50 {
                    if let Ok(lock) = FolderLock::take(dir.path()) {
                        let alone = inside.try_lock().expect("two are in");
                        std::thread::yield_now();
                        drop(alone);
                        drop(lock);
                    }
                }
            });
        }
    });
}

#[test]
fn a_keeper_that_cannot_write_says_so() {
    // A device that is always full.
    if !Path::new("/dev/full").exists() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let own = identity(1, None);
    std::os::unix::fs::symlink("/dev/full", dir.path().join(CHECKPOINT)).unwrap();
    let refused = Checkpoint::begin(dir.path(), &own).err().unwrap();
    assert!(refused.to_string().contains("cannot write"), "{refused}");
}
