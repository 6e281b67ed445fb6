//! The folder of a report: claimed before the work starts, swept of an earlier run, filled file by file.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::ReportError;

/// What plots are called after their case: the endings of the files below `plots/`.
pub(super) const PLOT_KINDS: [&str; 8] =
    ["variance", "bias", "profile", "map", "correlation", "caustic", "energy", "texels"];
pub(super) const PLOT_FORMATS: [&str; 2] = ["svg", "png"];
pub(super) const PLOTS: &str = "plots";
/// Pictures of receivers: below `images/`, by this ending.
pub(super) const VIEWS: &str = "images";
pub(super) const VIEW_ENDING: &str = "-view.png";

/// A file that is being written carries this ending until it is whole.
const PARTIAL: &str = "partial";

/// Files that lie directly in the folder.
pub(super) const FILES: [&str; 15] = [
    "convergence.csv",
    "means.csv",
    "rates.csv",
    "curves.csv",
    "correlation.csv",
    "energy.csv",
    "caustic.csv",
    "texels.csv",
    "paths.csv",
    "scene.csv",
    "verdicts.csv",
    "timings.csv",
    "timings.html",
    "index.html",
    "manifest.json",
];

/// A case's name may fill this much of a file name, bytes.
const LONGEST_STEM: usize = 120;

/// Makes the folder, makes sure that files can be written and moved in it, and removes the files of an earlier report,
/// so that a folder never mixes two runs. Only files that a report of ours consists of are touched.
pub fn claim(dir: &Path) -> Result<(), ReportError> {
    claim_files(dir, &FILES)?;
    claim_plots(dir)?;
    let views = dir.join(VIEWS);
    if views.is_dir() { sweep(&views, |name| whole_name(name).ends_with(VIEW_ENDING)) } else { Ok(()) }
}

/// The same for its plots alone.
pub(super) fn claim_plots(dir: &Path) -> Result<(), ReportError> {
    let plots = dir.join(PLOTS);
    claim_files(&plots, &[])?;
    sweep(&plots, is_ours)
}

/// Removes the files of a folder that bear such names.
fn sweep(dir: &Path, is_ours: impl Fn(&str) -> bool) -> Result<(), ReportError> {
    let entries = fs::read_dir(dir).map_err(|source| unusable(dir, source))?;
    for entry in entries {
        let entry = entry.map_err(|source| unusable(dir, source))?;
        if entry.file_name().to_str().is_some_and(&is_ours) {
            remove(&entry.path())?;
        }
    }
    Ok(())
}

/// The name of a file that may not be whole yet.
fn whole_name(name: &str) -> &str {
    let whole = name.strip_prefix('.').and_then(|n| n.strip_suffix(PARTIAL)).and_then(|n| n.strip_suffix('.'));
    whole.unwrap_or(name)
}

/// Makes one folder, makes sure that files can be written and moved in it, and removes the named ones of an earlier run.
pub(super) fn claim_files(dir: &Path, names: &[&str]) -> Result<(), ReportError> {
    probe(dir)?;
    for name in names {
        remove(&dir.join(name))?;
        remove(&dir.join(format!(".{name}.{PARTIAL}")))?;
    }
    Ok(())
}

/// Makes one folder, and makes sure that files can be written and moved in it.
pub fn probe(dir: &Path) -> Result<(), ReportError> {
    fs::create_dir_all(dir).map_err(|source| unusable(dir, source))?;
    // Processes in containers all have the same number.
    let nonce = RandomState::new().build_hasher().finish();
    let probe = dir.join(format!(".probe-{nonce:016x}.{PARTIAL}"));
    let moved = dir.join(format!(".probe-{nonce:016x}-moved.{PARTIAL}"));
    let moves = fs::write(&probe, b"etendue").and_then(|()| fs::rename(&probe, &moved));
    let _ = fs::remove_file(&probe);
    moves.map_err(|source| unusable(dir, source))?;
    fs::remove_file(&moved).map_err(|source| unusable(dir, source))
}

fn unusable(path: &Path, source: io::Error) -> ReportError {
    let path = path.to_owned();
    match source.kind() {
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => ReportError::NotAFolder { path },
        _ => ReportError::Folder { path, source },
    }
}

/// Whether a file below `plots/` bears a name that a report gives.
fn is_ours(name: &str) -> bool {
    let Some((stem, format)) = whole_name(name).rsplit_once('.') else { return false };
    let Some((_, kind)) = stem.rsplit_once('-') else { return false };
    PLOT_FORMATS.contains(&format) && PLOT_KINDS.contains(&kind)
}

fn remove(path: &Path) -> Result<(), ReportError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != ErrorKind::NotFound => {
            Err(ReportError::File { path: path.to_owned(), source })
        }
        _ => Ok(()),
    }
}

/// Writes a file under a passing name and moves it into place: nobody ever reads half a file.
pub(super) fn write_whole(dir: &Path, name: &str, content: &[u8]) -> Result<PathBuf, ReportError> {
    let path = dir.join(name);
    let passing = dir.join(format!(".{name}.{PARTIAL}"));
    fs::write(&passing, content).and_then(|()| fs::rename(&passing, &path)).map_err(|source| {
        let _ = fs::remove_file(&passing);
        ReportError::File { path: path.clone(), source }
    })?;
    Ok(path)
}

/// One file stem for each case name, all different, none able to leave its folder.
///
/// Path separators become `-`, and so does whatever is no letter, digit, `-`, `_` or `.`; `.` and `..` vanish. Names
/// that then coincide (also on file systems that fold case) are numbered in order.
pub(super) fn file_stems<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut taken = HashSet::new();
    // By stem: the next number that may be free.
    let mut next: HashMap<String, usize> = HashMap::new();
    let stem = |name: &str| {
        let parts = name.split(['/', '\\']).filter(|part| !matches!(*part, "" | "." | ".."));
        let joined = parts.collect::<Vec<_>>().join("-");
        let kept = joined.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' });
        let mut stem = String::new();
        for c in kept {
            if stem.len() + c.len_utf8() > LONGEST_STEM {
                break;
            }
            stem.push(c);
        }
        let stem = stem.trim_start_matches('.');
        if stem.is_empty() { "case".to_owned() } else { stem.to_owned() }
    };
    let first = names.into_iter().map(stem);
    first
        .map(|stem| {
            if taken.insert(stem.to_lowercase()) {
                return stem;
            }
            let number = next.entry(stem.to_lowercase()).or_insert(2);
            loop {
                let numbered = format!("{stem}-{number}");
                *number += 1;
                if taken.insert(numbered.to_lowercase()) {
                    return numbered;
                }
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn case_names_cannot_leave_the_plots_folder() {
        let names = ["../x", "/etc/passwd", "..\\..\\x", "a/../../b", ".hidden", "..", "", "C:\\x", "a\0b", "a b\n"];
        for (name, stem) in names.into_iter().zip(file_stems(names)) {
            assert!(!stem.is_empty() && !stem.starts_with('.'), "{name:?} became {stem:?}");
            assert!(!stem.contains(['/', '\\', ':', '\0', '\n']), "{name:?} became {stem:?}");
            assert_eq!(Path::new(&stem).components().count(), 1);
        }
        assert_eq!(file_stems(["penumbra/eclipse"]), ["penumbra-eclipse"]);
    }

    #[test]
    fn different_cases_have_different_files() {
        assert_eq!(file_stems(["a/b", "a-b", "A-B", "a-b-2"]), ["a-b", "a-b-2", "A-B-3", "a-b-2-2"]);
        let long = "ä".repeat(300);
        let stems = file_stems([long.as_str(), long.as_str()]);
        assert!(stems[0] != stems[1] && stems.iter().all(|s| s.len() <= LONGEST_STEM + 4), "{stems:?}");
    }

    #[test]
    fn a_claimed_folder_holds_nothing_of_an_earlier_run_and_everything_else() {
        let dir = tempfile::tempdir().unwrap();
        let plots = dir.path().join(PLOTS);
        fs::create_dir(&plots).unwrap();
        let stale = ["verdicts.csv", "manifest.json", ".rates.csv.partial", "plots/a-b-variance.svg"];
        let stale_partial = "plots/.a-map.png.partial";
        let foreign = ["notes.csv", "plots/holiday.png", "plots/my-variance.svg.bak", "plots/variance.svg"];
        for file in stale.into_iter().chain([stale_partial]).chain(foreign) {
            fs::write(dir.path().join(file), "x").unwrap();
        }
        claim(dir.path()).unwrap();
        for file in stale.into_iter().chain([stale_partial]) {
            assert!(!dir.path().join(file).exists(), "{file} is stale");
        }
        for file in foreign {
            assert!(dir.path().join(file).exists(), "{file} is not ours");
        }
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2, "the probe is gone");
        assert_eq!(fs::read_dir(&plots).unwrap().count(), 3, "the probe is gone");
    }

    #[test]
    fn a_file_in_the_folders_place_is_found_before_the_work() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("taken");
        fs::write(&file, "x").unwrap();
        assert!(matches!(claim(&file), Err(ReportError::NotAFolder { path }) if path == file));
        let below = file.join("report");
        assert!(matches!(claim(&below), Err(ReportError::NotAFolder { path }) if path == below));
        assert_eq!(fs::read(&file).unwrap(), b"x", "left as it was");
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_found_before_the_work() {
        // A read-only file system also stops the superuser, whom permissions do not.
        let sealed = Path::new("/proc/etendue-report");
        if sealed.parent().is_some_and(Path::exists) {
            let refused = claim(sealed).unwrap_err();
            assert!(matches!(&refused, ReportError::Folder { path, .. } if path == sealed), "{refused}");
        }
        // A file that cannot be removed: a folder of its name.
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("verdicts.csv")).unwrap();
        let refused = claim(dir.path()).unwrap_err();
        assert!(matches!(&refused, ReportError::File { path, .. } if path.ends_with("verdicts.csv")), "{refused}");
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_respected_where_they_bind() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let sealed = dir.path().join("sealed");
        fs::create_dir(&sealed).unwrap();
        fs::set_permissions(&sealed, fs::Permissions::from_mode(0o555)).unwrap();
        let binds = fs::write(sealed.join("try"), "x").is_err();
        let claimed = claim(&sealed);
        assert_eq!(claimed.is_err(), binds, "{claimed:?}");
        fs::set_permissions(&sealed, fs::Permissions::from_mode(0o755)).unwrap();
    }
}
